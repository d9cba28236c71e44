//! Every family of robots moves as its controllers expect: cars, flippers, aerial robots and platforms.

use gamebots_proto::Dialect;
use nalgebra::Vector3;
use scene::{BodyState, Steering};
use sim_core::{Options, PawnId, World};
use system_tests::{apply, command, init, run};

fn world_with(map: &str, class: &str) -> (World, PawnId) {
    let mut world = World::new(scene_loader::load(map, &[]).expect("a map"), Options::default());
    let robot = init(&mut world, &format!("INIT {{ClassName USARBot.{class}}} {{Location 0,0,0}}"));
    run(&mut world, 1.0);
    (world, robot)
}

fn body(world: &World) -> BodyState {
    world.snapshot().robots[0].body
}

fn yaw(world: &World) -> f64 {
    body(world).pose.rotation.euler_angles().2
}

/// Returns the lines of a kind that a world sends in some seconds, as on the wire.
fn lines(world: &mut World, seconds: f64, kind: &str) -> Vec<String> {
    let written = run(world, seconds).into_iter().map(|message| message.write(Dialect::Udk));
    written.filter(|line| line.starts_with(kind)).collect()
}

/// Returns the radius of the circle on which a point of a robot moves, m; negative in a turn to the left.
fn radius_of(world: &mut World, point: Vector3<f64>) -> f64 {
    let at = |world: &World| {
        let BodyState { pose, .. } = body(world);
        (pose * nalgebra::Point3::from(point)).coords
    };
    let (mut path, mut turned, mut last) = (0.0, 0.0, (at(world), yaw(world)));
    for _ in 0..4000 {
        world.step();
        let now = (at(world), yaw(world));
        path += (now.0 - last.0).xy().norm();
        turned +=
            (now.1 - last.1 + 9.0 * std::f64::consts::PI).rem_euclid(std::f64::consts::TAU) - std::f64::consts::PI;
        last = now;
    }
    path / turned
}

#[test]
fn cars_drive_the_circle_of_their_steering_angle() {
    // Class, command, wheel base, and the middle of the axle that is not steered.
    for (class, steer, wheel_base, axle, right) in [
        ("FrontAckerman", "{FrontSteer 0.3} {RearSteer 0}", 0.956, -0.416, 1.0),
        ("FrontAckerman", "{FrontSteer -0.45} {RearSteer 0}", 0.956, -0.416, -1.0),
        ("BasicAckermanRobot", "{FrontSteer 0} {RearSteer 0.3}", 0.6, 0.3, -1.0),
        ("BasicAckermanRobot", "{FrontSteer 0} {RearSteer -0.4}", 0.6, 0.3, 1.0),
    ] {
        let (mut world, robot) = world_with("rough", class);
        apply(&mut world, robot, &format!("DRIVE {{Speed 2}} {steer}"));
        run(&mut world, 3.0);
        let angle: f64 = steer.split(['{', '}', ' ']).filter_map(|word| word.parse::<f64>().ok()).map(f64::abs).sum();
        let (got, expected) = (radius_of(&mut world, Vector3::new(axle, 0.0, 0.0)), right * wheel_base / angle.tan());
        println!("{class} {steer}: {got:.3} m, expected {expected:.3} m, {:+.2} %", 100.0 * (got / expected - 1.0));
        assert!((got / expected - 1.0).abs() < 0.01, "{class} {steer}: {got} m, expected {expected} m");
    }
}

/// A URDF whose steering joints have dry friction, as exporters write it: it takes 40 % of their torque.
#[test]
fn an_imported_car_drives_the_circle_of_its_angle_against_the_friction_of_its_joints() {
    let inertial =
        "<inertial><mass value='1'/><inertia ixx='0.01' iyy='0.01' izz='0.01' ixy='0' ixz='0' iyz='0'/></inertial>";
    let wheel = |name: &str, parent: &str, [x, y, z]: [f64; 3]| {
        format!(
            "<link name='{name}'>{inertial}<collision><origin rpy='1.5708 0 0'/><geometry><cylinder radius='0.05' length='0.04'/></geometry>\
             </collision></link><joint name='{name}_wheel' type='continuous'><parent link='{parent}'/><child link='{name}'/>\
             <origin xyz='{x} {y} {z}'/><axis xyz='0 1 0'/><limit effort='5' velocity='30'/></joint>"
        )
    };
    let front = |name: &str, y: f64| {
        format!(
            "<link name='{name}_knuckle'>{inertial}</link><joint name='{name}_hinge' type='revolute'><parent link='base'/>\
             <child link='{name}_knuckle'/><origin xyz='0.12 {y} 0'/><axis xyz='0 0 1'/>\
             <limit lower='-0.5' upper='0.5' effort='5' velocity='0.5'/><dynamics damping='1' friction='2'/></joint>{}",
            wheel(name, &format!("{name}_knuckle"), [0.0, 0.0, 0.0])
        )
    };
    let rear = wheel("rl", "base", [-0.12, 0.09, 0.0]) + &wheel("rr", "base", [-0.12, -0.09, 0.0]);
    let body = "<collision><geometry><box size='0.3 0.12 0.04'/></geometry></collision>";
    let wheels = front("fl", 0.09) + &front("fr", -0.09) + &rear;
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("Cart.urdf");
    let text = format!("<robot name='c'><link name='base'>{inertial}{body}</link>{wheels}</robot>");
    std::fs::write(&file, text).expect("a file");
    for angle in [0.1_f64, 0.3] {
        let def = scene_loader::load("smooth", &[file.as_path()]).expect("a world");
        let mut world = World::new(def, Options::default());
        let robot = init(&mut world, "INIT {ClassName USARBot.Cart} {Location 0,0,0}");
        apply(&mut world, robot, &format!("DRIVE {{Speed 2}} {{FrontSteer {angle}}} {{RearSteer 0}}"));
        run(&mut world, 4.0);
        let (got, expected) = (radius_of(&mut world, Vector3::new(-0.12, 0.0, 0.0)), 0.24 / angle.tan());
        assert!((got / expected - 1.0).abs() < 0.01, "{angle} rad: {got} m, expected {expected} m");
    }
}

#[test]
fn a_car_drives_straight_and_says_what_it_was_asked_for() {
    let (mut world, robot) = world_with("rough", "FrontAckerman");
    // Case 80: all three parameters or none.
    apply(&mut world, robot, "DRIVE {Speed 2} {FrontSteer 0.2}");
    run(&mut world, 1.0);
    assert!(body(&world).linear.norm() < 1e-3, "{:?}", body(&world).linear);
    apply(&mut world, robot, "DRIVE {Speed 2} {FrontSteer 0} {RearSteer 0}");
    run(&mut world, 3.0);
    let BodyState { linear, angular, .. } = body(&world);
    // The servos are soft: front and rear wheels ask for 0.368 and 0.256 m/s.
    assert!((0.25..0.37).contains(&linear.x) && angular.norm() < 0.005, "{linear:?} {angular:?}");
    // Case 81: the status reports the commanded angle, although the middle of the axle stops at 0.5: the inner wheel at a little more.
    apply(&mut world, robot, "DRIVE {Speed 0} {FrontSteer 2} {RearSteer 0}");
    let status = lines(&mut world, 2.0, "STA");
    assert!(status[0].ends_with("{LightIntensity 100} {FrontSteer 2.0000} {RearSteer 0.0000}"), "{}", status[0]);
    let def = &world.def().robots["FrontAckerman"];
    let steered = def.with_values().position(|link| link.name == "FRFrontSteer").expect("a joint");
    let angle = world.snapshot().robots[0].joints[steered].position;
    assert!((0.53..0.58).contains(&angle), "{angle}");
    let conf = apply(&mut world, robot, "GETCONF {Type Robot}");
    assert!(conf[0].ends_with("{MaxFrontSteer 1.0000} {MaxRearSteer 6.2800}"), "{conf:?}");
}

#[test]
fn flippers_move_by_multidrive_and_set_and_lift_the_robot() {
    let (mut world, robot) = world_with("rough", "Kenaf");
    let height = body(&world).pose.translation.z;
    let flipper = |world: &World, name: &str| {
        let def = &world.def().robots["Kenaf"];
        let number = def.with_values().position(|link| link.name == name).expect("a flipper");
        world.snapshot().robots[0].joints[number].position
    };
    // Front flippers up: negative turns the front up about the robot's left.
    apply(&mut world, robot, "MultiDrive {FRFlipper -1,2} {FLFlipper  -1.2}");
    run(&mut world, 2.0);
    for name in ["FRFlipper", "FLFlipper"] {
        assert!((flipper(&world, name) + 1.2).abs() < 0.01, "{name}: {}", flipper(&world, name));
    }
    assert!((body(&world).pose.translation.z - height).abs() < 0.003, "lifted by flippers in the air");
    // All four down: it stands on its flippers.
    for (name, angle) in [("FRFlipper", 0.8), ("FLFlipper", 0.8), ("RRFlipper", -0.8), ("RLFlipper", -0.8)] {
        apply(&mut world, robot, &format!("SET {{Type Joint}} {{Name {name}}} {{Opcode Angle}} {{Params {angle}}}"));
    }
    run(&mut world, 4.0);
    let lifted = height - body(&world).pose.translation.z;
    // The far wheel is 0.145 m out with a radius of 0.04, the main ones have 0.06.
    let expected = 0.145 * 0.8f64.sin() + 0.04 - 0.06;
    println!("lifted by {lifted:.3} m, expected {expected:.3} m");
    assert!((lifted - expected).abs() < 0.01, "{lifted} m, expected {expected} m");
}

/// The step is 5 cm high, a metre long and two wide.
#[test]
fn flippers_take_the_robot_over_the_arenas_step() {
    let mut world = World::new(scene_loader::load("arena", &[]).expect("a map"), Options::default());
    let robot = init(&mut world, "INIT {ClassName USARBot.Kenaf} {Location -5.3,-2,0}");
    run(&mut world, 1.0);
    let on_the_floor = body(&world).pose.translation.z;
    let (mut highest, mut seconds) = (on_the_floor, 0.0);
    // As an operator does: raise the front against the step, lift the rear onto it, then level.
    for (front, rear, until) in [(-0.5, 0.5, -4.8), (-0.5, -0.7, -4.35), (0.0, 0.0, -2.7)] {
        let flippers = [("FR", front), ("FL", front), ("RR", rear), ("RL", rear)];
        let flippers = flippers.map(|(name, angle)| format!(" {{{name}Flipper {angle}}}")).concat();
        apply(&mut world, robot, &format!("MULTIDRIVE{flippers}"));
        apply(&mut world, robot, "DRIVE {Left 3} {Right 3}");
        while body(&world).pose.translation.x < until && seconds < 60.0 {
            run(&mut world, 0.1);
            seconds += 0.1;
            highest = highest.min(body(&world).pose.translation.z);
        }
        println!("{seconds:.1} s: {:.3?}", body(&world).pose.translation.vector.as_slice());
    }
    let BodyState { pose, .. } = body(&world);
    println!("over it in {seconds:.1} s, at most {:.3} m up", on_the_floor - highest);
    assert!(seconds < 60.0 && pose.translation.y + 2.0 < 0.5, "{pose}");
    assert!((on_the_floor - highest - 0.05).abs() < 0.02 && (pose.translation.z - on_the_floor).abs() < 0.01, "{pose}");
}

#[test]
fn a_robot_in_the_air_hovers_flies_a_square_and_leans() {
    let mut world = World::new(scene_loader::load("rough", &[]).expect("a map"), Options::default());
    let robot = init(&mut world, "INIT {ClassName USARBot.AirRobot} {Location 1,2,-1.5}");
    run(&mut world, 2.0);
    let position = |world: &World| body(world).pose.translation.vector;
    assert!((position(&world) - Vector3::new(1.0, 2.0, -1.5)).norm() < 1e-9, "hovers: {}", position(&world));
    // Cases 83 and 84.
    let leg = |world: &mut World, line: &str, seconds: f64, expected: [f64; 3]| {
        apply(world, robot, line);
        let before = position(world);
        run(world, seconds);
        let moved = position(world) - before;
        assert!((moved - Vector3::from(expected)).norm() < 1e-3, "{line}: {moved:?}, expected {expected:?}");
    };
    leg(&mut world, "DRIVE {AltitudeVelocity 1}", 1.0, [0.0, 0.0, -1.0]);
    leg(&mut world, "DRIVE {AltitudeVelocity 0}", 1.0, [0.0, 0.0, 0.0]);
    leg(&mut world, "DRIVE {LinearVelocity 0.5}", 2.0, [1.0, 0.0, 0.0]);
    let (roll, pitch, _) = body(&world).pose.rotation.euler_angles();
    assert!(roll.abs() < 1e-6 && (pitch + 25f64.to_radians()).abs() < 0.02, "nose down: {roll} {pitch}");
    leg(&mut world, "DRIVE {LinearVelocity 0} {LateralVelocity 0.5}", 2.0, [0.0, 1.0, 0.0]);
    leg(&mut world, "DRIVE {Normalized true} {LinearVelocity -25} {LateralVelocity 0}", 2.0, [-1.0, 0.0, 0.0]);
    leg(&mut world, "DRIVE {LinearVelocity 0} {LateralVelocity -0.5}", 2.0, [0.0, -1.0, 0.0]);
    apply(&mut world, robot, "DRIVE {LateralVelocity 0} {RotationalVelocity 90}");
    run(&mut world, 1.0);
    assert!((yaw(&world) - 90f64.to_radians()).abs() < 1e-3, "{}", yaw(&world));
    leg(&mut world, "DRIVE {RotationalVelocity 0} {LinearVelocity 1}", 1.0, [0.0, 1.0, 0.0]);
    // Case 82, and the configuration.
    let status = lines(&mut world, 0.2, "STA");
    assert!(status[0].starts_with("STA {Time ") && status[0].ends_with("} {Battery 99999}"), "{}", status[0]);
    assert_eq!(apply(&mut world, robot, "GETCONF {Type Robot}"), ["CONF {Name AirRobot}"]);
    assert_eq!(apply(&mut world, robot, "GETGEO {Type Robot}"), ["GEO {Name AirRobot}"]);
}

#[test]
fn a_robot_in_the_air_keeps_its_limits_whatever_the_line_says() {
    for (line, axis, limit) in [
        ("DRIVE {LinearVelocity 1e6}", 0, 2.0),
        ("DRIVE {LateralVelocity -1e308}", 1, -2.0),
        ("DRIVE {AltitudeVelocity 1e9}", 2, -2.0),
        ("DRIVE {Normalized true} {LinearVelocity 5000}", 0, 2.0),
        ("DRIVE {Normalized true} {AltitudeVelocity 1e300}", 2, -2.0),
        ("DRIVE {RotationalVelocity 1e6}", 5, 100f64.to_radians()),
        ("DRIVE {Normalized true} {RotationalVelocity -900}", 5, -100f64.to_radians()),
    ] {
        let mut world = World::new(scene_loader::load("rough", &[]).expect("a map"), Options::default());
        let robot = init(&mut world, "INIT {ClassName USARBot.AirRobot} {Location 0,0,-2}");
        apply(&mut world, robot, line);
        run(&mut world, 0.5);
        let BodyState { linear, angular, .. } = body(&world);
        let got = [linear.as_slice(), angular.as_slice()].concat();
        assert!((got[axis] - limit).abs() < 1e-3, "{line}: {got:?}, expected {limit}");
    }
    for (line, roll, pitch) in [("DRIVE {RollAngle 1e6}", 1.0, 0.0), ("DRIVE {PitchAngle -4000}", 0.0, -1.0)] {
        let (mut world, robot) = world_with("rough", "AirRobot");
        apply(&mut world, robot, "DRIVE {AltitudeVelocity 1}");
        apply(&mut world, robot, line);
        run(&mut world, 3.0);
        let got = body(&world).pose.rotation.euler_angles();
        let most = 25f64.to_radians();
        assert!((got.0 - roll * most).abs() < 0.01 && (got.1 - pitch * most).abs() < 0.01, "{line}: {got:?}");
    }
}

/// A flying robot pushes with the 30 N that its rotors can give, not with any force.
#[test]
fn a_robot_in_the_air_moves_no_robot_that_is_far_heavier() {
    let mut world = World::new(scene_loader::load("rough", &[]).expect("a map"), Options::default());
    let heavy = init(&mut world, "INIT {ClassName USARBot.P3AT} {Location 1.5,0,0}");
    run(&mut world, 1.0);
    let at = |world: &World| world.state(heavy).expect("the robot is there").0.pose.translation.vector;
    let before = at(&world);
    let flier = init(&mut world, "INIT {ClassName USARBot.AirRobot} {Location 0,0,-0.2}");
    apply(&mut world, flier, "DRIVE {LinearVelocity 1e6}");
    run(&mut world, 5.0);
    let (moved, flown) = ((at(&world) - before).norm(), world.state(flier).expect("it is there").0.pose.translation.x);
    assert!(flown > 0.5, "it got to {flown} m only");
    assert!(moved < 0.01, "the P3AT was pushed by {moved} m");
}

#[test]
fn what_flies_into_a_wall_stops_there() {
    let (mut world, robot) = world_with("arena", "AirRobot");
    apply(&mut world, robot, "DRIVE {AltitudeVelocity 0.3}");
    run(&mut world, 1.0);
    apply(&mut world, robot, "DRIVE {AltitudeVelocity 0} {LinearVelocity 2}");
    run(&mut world, 20.0);
    let (before, speed) = (body(&world).pose.translation.vector, body(&world).linear.norm());
    run(&mut world, 2.0);
    let moved = (body(&world).pose.translation.vector - before).norm();
    assert!(moved < 0.05, "went on by {moved} m at {speed} m/s to {before}");
}

/// A column with a rotating head, on a base that stands in the air if it is fixed.
const COLUMN: &str = r#"
description = "a column with a head"
steering = "STEERING"
[[part]]
name = "Base"
mass = 5.0
size = [0.3, 0.3, 0.1]
material = "aluminium"
[[joint]]
name = "Head"
kind = "revolute"
position = [0.0, 0.0, -0.3]
limits = [-1.0, 1.0]
max_speed = 2.0
max_torque = 10.0
gain = 1.0
stiffness = 100.0
[[part]]
name = "Face"
link = "Head"
mass = 0.5
position = [0.0, 0.0, -0.35]
size = [0.1, 0.1, 0.1]
material = "aluminium"
"#;

#[test]
fn a_platform_stays_where_it_is_and_what_has_legs_falls() {
    for (steering, falls, conf, geo, state) in [
        (
            "none",
            0.0,
            "CONF {Name Column} {Type StaticPlatform} {SteeringType None} {Mass 0} ",
            "GEO {Type StaticPlatform} {Name Column}",
            "{Type StaticPlatform}",
        ),
        ("legged", 0.95, "CONF {Name Column}", "GEO {Name Column}", "{Type LeggedVehicle} {Head 0.4000}"),
    ] {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("Column.toml");
        std::fs::write(&path, COLUMN.replace("STEERING", steering)).expect("a file");
        let scene = scene_loader::load("rough", &[&path]).unwrap_or_else(|error| panic!("{error}"));
        let mut world = World::new(scene, Options::default());
        let robot = init(&mut world, "INIT {ClassName USARBot.Column} {Location 0,0,-1}");
        apply(&mut world, robot, "SET {Type Joint} {Name Head} {Opcode Angle} {Params 0.4}");
        let mut problems = Vec::new();
        world.execute(Some(robot), &command("DRIVE {Left 1} {Right 1}"), &mut problems);
        assert_eq!(problems.len(), 1, "{problems:?}");
        run(&mut world, 2.0);
        let fallen = body(&world).pose.translation.z + 1.0;
        assert!((fallen - falls).abs() < 0.005, "{steering} fell by {fallen} m");
        assert_eq!(apply(&mut world, robot, "GETCONF {Type Robot}"), [conf]);
        assert_eq!(apply(&mut world, robot, "GETGEO {Type Robot}"), [geo]);
        let status = lines(&mut world, 0.2, "STA");
        let near = status[0].replace("0.3999", "0.4000").replace("0.4001", "0.4000");
        assert!(near.ends_with(state), "{}", status[0]);
        assert!((world.snapshot().robots[0].joints[0].position - 0.4).abs() < 1e-3);
    }
}

#[test]
fn a_robot_of_every_class_is_driven_in_its_own_words() {
    let world = scene_loader::load("rough", &[]).expect("a map");
    for (class, def) in world.robots.iter() {
        let mut world = World::new(world.clone(), Options::default());
        let robot = init(&mut world, &format!("INIT {{ClassName USARBot.{class}}} {{Location 0,0,-0.5}}"));
        run(&mut world, 1.0);
        let line = match def.steering {
            Steering::Skid => "DRIVE {Left 2} {Right 2}",
            Steering::Omni => "DRIVE {Front-Left 2} {Front-Right 2} {Back-Left 2} {Back-Right 2}",
            Steering::Ackermann => "DRIVE {Speed 2} {FrontSteer 0} {RearSteer 0}",
            Steering::Aerial => "DRIVE {LinearVelocity 0.3}",
            Steering::Legged | Steering::None => continue,
        };
        let mut problems = Vec::new();
        world.execute(Some(robot), &command(line), &mut problems);
        assert_eq!(problems, [], "{class}: {line}");
        run(&mut world, 2.0);
        let ahead = body(&world).pose.translation.x;
        assert!(ahead > 0.1, "{class}: {line} moved it by {ahead} m");
    }
}

#[test]
fn a_robot_on_its_back_is_flipped_onto_its_wheels() {
    for class in ["P2DX", "P3AT", "Zerg"] {
        let mut world = World::new(scene_loader::load("rough", &[]).expect("a scene"), Options::default());
        let robot = init(
            &mut world,
            &format!("INIT {{ClassName USARBot.{class}}} {{Location 0,0,-0.6}} {{Rotation 3.1416,0,1}}"),
        );
        run(&mut world, 1.0);
        let lean = |world: &World| (body(world).pose.rotation * Vector3::z()).z;
        assert!(lean(&world) < -0.9, "{class}: {}", lean(&world));
        apply(&mut world, robot, "DRIVE {Flip False}");
        run(&mut world, 0.2);
        assert!(lean(&world) < -0.9, "{class}: {}", lean(&world));
        assert_eq!(apply(&mut world, robot, "DRIVE {Flip True}"), [""; 0]);
        run(&mut world, 1.0);
        assert!(lean(&world) > 0.99 && (yaw(&world) - 1.0).abs() < 0.1, "{class}: {} {}", lean(&world), yaw(&world));
    }
}
