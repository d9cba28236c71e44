//! Every class of robots: it spawns, stands, moves as commanded, and its joints reach their ends.

use std::sync::LazyLock;

use gamebots_proto::Command;
use scene::{CouplingKind, Footing, Link, Steering, WorldDef};
use sim_core::{Options, Order, PawnId, TIME_STEP, World};
use system_tests::{apply, command, init, run};

/// Classes that known programs ask for by name (clients.md, clients-2.md 2).
const ASKED_FOR: &str = "P3AT P2AT AirRobot P2DX Kenaf ComStation Zerg Nao ARDrone Talon Sedan KR60 KR6 Kiva4Wheel kiva4Wheel Fanuc_M16iB20 \
     Fanuc_Robot_And_Rail KinectBot TwoLink BasicAckermanRobot BasicSkidRobot Cramer StereoP2AT Tarantula TeleMax Submarine MDS MultiView \
     KUKA_YouBot pioneer3at_with_sensors pioneer3at_with_sensors_b pioneer2dx_with_sensors pioneer2dx_with_sensors_g turtlebot_with_sensors \
     turtlebot_with_sensors_r Crawler_Robot crawler_robot crawler_robot_y Rugbot Hummer ATRVJr ATRV ATRV2 Matilda Soryu Cooper KR3 KR5 \
     FanucM16 Forklift GripperBase CasterSkidRobot KURT2D P2AT_ATLANTA TarantulaSIED FrontAckerman HandBot KUKA_LWR_BOT StaticPlatform \
     YouBot YouBotArm SoccerRobot Element QRIO OmniP2AT OmniP2DX Kurt3D";
/// Steps of 8 ms: contacts converge in each.
const STEP: f64 = 0.008;
/// Part of a joint's range that it has to reach.
const RANGE: f64 = 0.9;

static SCENE: LazyLock<WorldDef> = LazyLock::new(|| scene_loader::load("rough", &[]).expect("the built-in robots"));

fn world(change: impl Fn(&mut scene::RobotDef), class: &str) -> World {
    let mut robot = SCENE.robots[class].clone();
    change(&mut robot);
    let robots = [(class.to_owned(), robot)].into();
    let options = Options { time_step: STEP, ..Options::default() };
    World::new(WorldDef { map: SCENE.map.clone(), robots, ..WorldDef::default() }, options)
}

fn pass(world: &mut World, seconds: f64) {
    run(world, seconds * TIME_STEP / STEP);
}

/// Returns the place of the robot and its orientation.
fn place(world: &World, robot: PawnId) -> scene::Pose {
    let class = world.def().robots.keys().next().cloned();
    world.state(robot).unwrap_or_else(|| panic!("{class:?} is gone")).0.pose
}

fn stands(class: &str) -> Result<(), String> {
    let mut world = world(|_| {}, class);
    let flies = world.def().robots[class].footing.aerial().is_some();
    let at = if flies { "0,0,-1.5" } else { "0,0,0" };
    let robot = init(&mut world, &format!("INIT {{ClassName USARBot.{class}}} {{Location {at}}}"));
    pass(&mut world, 2.0);
    let before = place(&world, robot);
    pass(&mut world, 10.0);
    let after = place(&world, robot);
    let moved = (after.translation.vector - before.translation.vector).norm();
    let turned = before.rotation.angle_to(&after.rotation).to_degrees();
    if moved > 0.001 || turned > 0.1 {
        return Err(format!("stands: moves by {:.2} mm and {turned:.3} degrees in 10 s", 1000.0 * moved));
    }
    let level = after.rotation.inverse_transform_vector(&nalgebra::Vector3::z()).z;
    if level < 0.98 { Err(format!("stands: leans, {after}")) } else { Ok(()) }
}

/// Drives at half of the wheels' speed limit, at most 1 m/s.
fn drives(class: &str) -> Result<(), String> {
    let mut world = world(|_| {}, class);
    let def = world.def().robots[class].clone();
    let radius = def.driven().next().map_or(0.0, |wheel| wheel.radius);
    let fastest =
        def.driven().filter_map(|wheel| wheel.drive).map(|motor| motor.max_speed).fold(f64::INFINITY, f64::min);
    let speed = (fastest / 2.0).min(1.0 / radius);
    let (line, expected) = match def.steering {
        Steering::Skid => (format!("DRIVE {{Left {speed:.4}}} {{Right {speed:.4}}}"), speed * radius),
        Steering::Omni => ("DRIVE {LinearVelocity 0.2} {LateralVelocity 0} {RotationalVelocity 0}".to_owned(), 0.2),
        Steering::Ackermann => (format!("DRIVE {{Speed {speed:.4}}} {{FrontSteer 0}} {{RearSteer 0}}"), speed * radius),
        Steering::Aerial => ("DRIVE {LinearVelocity 0.5}".to_owned(), 0.5),
        Steering::Legged | Steering::None => return Ok(()),
    };
    let at = if def.steering == Steering::Aerial { "0,0,-1.5" } else { "0,0,0" };
    let robot = init(&mut world, &format!("INIT {{ClassName USARBot.{class}}} {{Location {at}}}"));
    pass(&mut world, 1.0);
    apply(&mut world, robot, &line);
    pass(&mut world, 2.0);
    let before = place(&world, robot);
    pass(&mut world, 2.0);
    let moved = before.inverse() * place(&world, robot);
    let (ahead, aside) = (moved.translation.x / 2.0, moved.translation.y / 2.0);
    // Soft servos droop under a load. The wheels of FrontAckerman differ in radius.
    let slowest = def.driven().map(|wheel| wheel.radius / radius).fold(1.0, f64::min);
    if ahead / expected < 0.85 * slowest || ahead / expected > 1.05 || aside.abs() > 0.05 * expected {
        return Err(format!("drives: {ahead:.3} m/s ahead and {aside:.3} aside, expected {expected:.3}"));
    }
    Ok(())
}

/// Moves every joint from end to end, one after the other, with the body held in the air. Together they would hit each other.
fn reaches(class: &str) -> Result<(), String> {
    let mut world = world(|robot| robot.footing = Footing::Fixed, class);
    let def = world.def().robots[class].clone();
    let robot = init(&mut world, &format!("INIT {{ClassName USARBot.{class}}} {{Location 0,0,-10}}"));
    let is_mimic = |link: &Link| {
        link.joint.as_ref().and_then(|joint| joint.coupling).is_some_and(|it| it.kind == CouplingKind::Mimic)
    };
    for (number, link) in def.with_values().enumerate().filter(|(_, link)| !is_mimic(link)) {
        let Some([least, most]) = link.position_limits() else { continue };
        let most_speed = link.joint.as_ref().and_then(|joint| joint.drive.as_ref()).map_or(1.0, |it| it.max_speed);
        let ends = [least, most].map(|end| {
            let others = def.with_values().enumerate().filter(|(_, link)| link.position_limits().is_some());
            let targets = others.map(|(other, _)| (other, if other == number { end } else { 0.0 })).collect();
            assert!(world.order(robot, &Order::Joints(targets)), "{class} takes no targets");
            pass(&mut world, (most - least) / most_speed + 1.0);
            world.snapshot().robots[0].joints[number].position
        });
        if ends[1] - ends[0] < RANGE * (most - least) {
            let [low, high] = ends;
            return Err(format!("reaches: {} goes from {low:.3} to {high:.3}, of {least} to {most}", link.name));
        }
    }
    Ok(())
}

#[track_caller]
fn check(classes: impl Iterator<Item = &'static String>) {
    let wrong: Vec<String> = classes
        .flat_map(|class| {
            [stands(class), drives(class), reaches(class)]
                .into_iter()
                .filter_map(move |it| Some(format!("{class} {}", it.err()?)))
        })
        .collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// With its package and without, as programs spell it and in other cases.
#[test]
fn every_class_that_programs_ask_for_spawns() {
    let mut world = World::new(SCENE.clone(), Options::default());
    let mut problems = Vec::new();
    for name in ASKED_FOR.split_whitespace() {
        for class in [format!("USARBot.{name}"), name.to_lowercase(), format!("usarbot.{}", name.to_uppercase())] {
            let line = command(&format!("INIT {{ClassName {class}}} {{Location 0,0,-3}}"));
            let Command::Init(line) = line else { panic!("{line:?}") };
            if let Some(robot) = world.init(&line, &mut problems) {
                world.remove(robot);
            }
        }
    }
    assert!(problems.is_empty(), "{problems:?}");
}

/// Half of the classes; the other half is another test, which runs beside it.
#[test]
fn classes_of_even_number_stand_drive_and_reach() {
    check(SCENE.robots.keys().step_by(2));
}

#[test]
fn classes_of_odd_number_stand_drive_and_reach() {
    check(SCENE.robots.keys().skip(1).step_by(2));
}

/// The fork's mast reaches into the floor, and no joint moves it sideways.
#[test]
fn a_fixed_robot_in_the_floor_keeps_its_state() {
    let mut world = world(|_| {}, "Forklift");
    let robot = init(&mut world, "INIT {ClassName USARBot.Forklift} {Location 0,0,0.1}");
    pass(&mut world, 2.0);
    assert_eq!(place(&world, robot).translation.z, 0.1);
}

#[test]
fn a_nao_lifts_an_arm_and_stands() {
    let mut world = world(|_| {}, "Nao");
    let robot = init(&mut world, "INIT {ClassName USARBot.Nao} {Location 0,0,0}");
    pass(&mut world, 1.0);
    for (name, angle) in [("LShoulderPitch", -1.0), ("HeadYaw", 0.8), ("LElbowRoll", -1.0)] {
        apply(&mut world, robot, &format!("SET {{Type Joint}} {{Name {name}}} {{Opcode Angle}} {{Params {angle}}}"));
        pass(&mut world, 2.0);
        let number = world.def().robots["Nao"].with_values().position(|link| link.name == name).expect("a joint");
        let position = world.snapshot().robots[0].joints[number].position;
        assert!((position - angle).abs() < 0.05, "{name}: {position}");
    }
    let up = place(&world, robot).rotation.inverse_transform_vector(&nalgebra::Vector3::z()).z;
    assert!(up > 0.99, "{up}");
}

/// The tips of arms are where forward kinematics of the targets puts them, against gravity.
#[test]
fn tips_of_arms_are_within_a_millimetre_of_forward_kinematics() {
    for (class, angles) in [
        ("TwoLink", vec![1.2]),
        ("KR60", vec![0.7, -0.8, 0.9, 1.0, -1.1, 0.5]),
        ("KR6", vec![0.7, 0.5, 0.4, 1.0, -0.8, 0.5]),
    ] {
        let mut world = world(|_| {}, class);
        let robot = init(&mut world, &format!("INIT {{ClassName USARBot.{class}}} {{Location 0,0,-3}}"));
        let def = world.def().robots[class].clone();
        let arm = &def.actuators[0];
        let links: String =
            angles.iter().enumerate().map(|(link, angle)| format!(" {{Link {link}}} {{Value {angle}}}")).collect();
        apply(&mut world, robot, &format!("ACT {{Name {}}}{links}", arm.name));
        pass(&mut world, 8.0);
        let joints = world.snapshot().robots[0].joints.clone();
        let mut wanted = joints.clone();
        for (&link, &angle) in arm.links.iter().zip(&angles) {
            wanted[def.value_of(link).expect("a value")].position = angle;
        }
        let tip = |joints: &[scene::JointState]| {
            let last = *arm.links.last().expect("a joint");
            let (link, pose) = def.placed_links(joints)[last];
            pose * nalgebra::Point3::from(nalgebra::Vector3::from(arm.tip) - nalgebra::Vector3::from(link.origin()))
        };
        let off = (tip(&joints) - tip(&wanted)).norm();
        println!("{class}: the tip is {:.3} mm off", 1000.0 * off);
        assert!(off < 0.001, "{class}: {off} m");
    }
}
