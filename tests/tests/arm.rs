//! A youBot with its arm picks something up, carries it aside and sets it on a table.

use gamebots_proto::Command;
use gamebots_proto::message::{Message, Reading};
use nalgebra::Vector3;
use scene::{Material, Object, Shape, Solid, WorldDef};
use sim_core::{Options, PawnId, World};
use system_tests::{apply, command, copy_robot, init, run};

/// Edge of the cube in tests that do not grip it, m.
const EDGE: f64 = 0.04;
/// Height of the table, m.
const TABLE: f64 = 0.08;
/// Distance of the cube from the robot's middle, ahead, m.
const AHEAD: f64 = 0.4;
/// Height of the shoulder above the floor, m; then the lengths of upper arm, forearm and hand.
const SHOULDER: f64 = 0.161 + 0.08;
const ARM: [f64; 3] = [0.155, 0.135, 0.209];

/// Builds a scene with a cube of 0.5 kg ahead of the robot and a table a metre to its right.
fn scene(edge: f64) -> WorldDef {
    let mut scene = scene_loader::load("rough", &[]).expect("a map");
    let material = Material { name: "wood".to_owned(), friction: 0.6, ..Material::default() };
    let solid = |name: &str, shape: Shape, position: [f64; 3]| {
        let (name, rotation, material) = (name.to_owned(), [0.0; 3], material.clone());
        Solid { name, shape, position, rotation, material }
    };
    let cube = solid("cube", Shape::Box { size: [edge; 3] }, [AHEAD, 0.0, -edge / 2.0]);
    scene.map.objects.push(Object { solid: cube, mass: 0.5 });
    let table = solid("table", Shape::Box { size: [0.3, 0.3, TABLE] }, [AHEAD + 0.1, 1.0, -TABLE / 2.0]);
    scene.map.solids.push(table);
    scene
}

fn world(edge: f64) -> (World, PawnId) {
    let mut world = World::new(scene(edge), Options::default());
    let robot = init(&mut world, "INIT {ClassName USARBot.YouBotArm} {Location 0,0,0}");
    run(&mut world, 1.0);
    (world, robot)
}

/// Returns the angles of shoulder, elbow and wrist, rad from upward, for a hand that points down at a height above the floor, m.
fn reach(height: f64) -> [f64; 3] {
    let [upper, lower, hand] = ARM;
    let (ahead, up) = (AHEAD - 0.2, height + hand - SHOULDER);
    let (distance, slope) = (ahead.hypot(up), up.atan2(ahead));
    let lift = ((distance * distance + upper * upper - lower * lower) / (2.0 * distance * upper)).acos();
    let shoulder = std::f64::consts::FRAC_PI_2 - slope - lift;
    let (elbow_x, elbow_up) = (upper * shoulder.sin(), upper * shoulder.cos());
    let forearm = (ahead - elbow_x).atan2(up - elbow_up);
    [shoulder, forearm - shoulder, std::f64::consts::PI - forearm]
}

/// Returns the `ACT` command for a height of the hand.
fn to_height(height: f64) -> String {
    let [shoulder, elbow, wrist] = reach(height);
    format!(
        "ACT {{Name arm}} {{Link 1}} {{Value {shoulder:.4}}} {{Link 2}} {{Value {elbow:.4}}} {{Link 3}} {{Value {wrist:.4}}}"
    )
}

fn cube(world: &World) -> Vector3<f64> {
    world.snapshot().objects[0].pose.translation.vector
}

/// Runs a world for a time. Returns the arm's values in the last ASTA, and true if the gripper reports that it is closed.
fn states(world: &mut World, seconds: f64) -> (Vec<f32>, bool) {
    let messages = run(world, seconds);
    let arm = messages.iter().rev().find_map(|it| if let Message::Asta(it) = it { Some(it.clone()) } else { None });
    let hand = messages.iter().rev().find_map(|it| if let Message::Eff(it) = it { Some(it.clone()) } else { None });
    let arm = arm.expect("an ASTA");
    assert_eq!(arm.name, "Arm");
    (arm.joints.into_iter().map(|joint| joint.value).collect(), hand.expect("an EFF").closed)
}

/// Picks the cube up, carries it aside and sets it on the table. Returns a digest of the final state.
fn carry(edge: f64) -> u64 {
    let (mut world, robot) = world(edge);
    // Fingers reach 2.5 cm below their middle.
    let grip = f64::max(edge / 2.0, 0.03);
    let mut go = |line: &str, seconds: f64| {
        apply(&mut world, robot, line);
        let states = states(&mut world, seconds);
        (states, cube(&world), world.snapshot().robots[0].body.pose.translation.vector)
    };
    go("SET {Type Gripper} {Name Gripper} {Opcode Open}", 0.5);
    // From above, in steps, as each joint moves at its own speed and the hand not along a line.
    for above in [0.2, 0.15, 0.1, 0.06, 0.03] {
        go(&to_height(grip + above), 2.0);
    }
    let ((values, closed), before, _) = go(&to_height(grip), 2.0);
    assert!(!closed && (before.x - AHEAD).abs() < 0.01, "{values:?} {before:?}");
    let wanted = reach(grip);
    for (value, wanted) in values[1..4].iter().zip(wanted) {
        assert!((f64::from(*value) - wanted).abs() < 0.01, "{values:?}, expected {wanted:?}");
    }
    let ((_, closed), ..) = go("ACT {Name Gripper} {Gripper 1}", 1.0);
    assert!(closed);
    let (_, lifted, _) = go(&to_height(grip + 0.1), 3.0);
    println!("lifted to {:.3?}", lifted.as_slice());
    assert!((lifted.z + 0.1 + edge / 2.0).abs() < 0.01, "{lifted:?}");
    let (_, carried, base) = go("DRIVE {LateralVelocity 0.2}", 5.3);
    println!("carried to {:.3?}, the robot at {:.3?}", carried.as_slice(), base.as_slice());
    let (_, carried, base) = go("DRIVE {LateralVelocity 0}", 1.0);
    assert!(base.y > 1.0 && (carried.y - base.y).abs() < 0.02, "{base:?} {carried:?}");
    go(&to_height(TABLE + grip), 2.0);
    go("MISPKG {Name Arm} {Gripper 0}", 1.0);
    let (_, there, _) = go(&to_height(TABLE + grip + 0.1), 3.0);
    println!("stands at {:.3?}", there.as_slice());
    assert!((there.z + TABLE + edge / 2.0).abs() < 0.003 && (there.y - base.y).abs() < 0.03, "{there:?}");
    world.digest()
}

#[test]
fn it_picks_up_carries_and_sets_down_and_does_the_same_again() {
    for edge in [0.04, 0.055] {
        assert_eq!(carry(edge), carry(edge), "a cube of {edge} m");
    }
}

/// Lifts the cube, which is turned about the vertical, rad, with a smaller one on top of it, and holds both for a time, s. Returns how far
/// each moved meanwhile, m, and turned, rad.
fn hold(turned: f64, seconds: f64) -> [(f64, f64); 2] {
    let mut scene = scene(EDGE);
    let cube = &mut scene.map.objects[0];
    cube.solid.rotation[2] = turned;
    let mut top = cube.clone();
    (top.solid.name, top.mass) = ("top".to_owned(), 0.02);
    top.solid.shape = Shape::Box { size: [EDGE / 2.0; 3] };
    top.solid.position[2] = -EDGE * 1.25;
    scene.map.objects.push(top);
    let mut world = World::new(scene, Options::default());
    let robot = init(&mut world, "INIT {ClassName USARBot.YouBotArm} {Location 0,0,0}");
    run(&mut world, 1.0);
    let mut go = |line: &str, seconds: f64| {
        apply(&mut world, robot, line);
        run(&mut world, seconds);
    };
    go("SET {Type Gripper} {Name Gripper} {Opcode Open}", 0.5);
    for above in [0.2, 0.15, 0.1, 0.06, 0.03, 0.0] {
        go(&to_height(0.03 + above), 2.0);
    }
    go("ACT {Name Gripper} {Gripper 1}", 1.0);
    go(&to_height(0.13), 3.0);
    // A cube that is gripped askew turns until it lies flush.
    run(&mut world, 10.0);
    let poses = |world: &World| [0, 1].map(|object| world.snapshot().objects[object].pose);
    let before = poses(&world);
    run(&mut world, seconds);
    let after = poses(&world);
    [0, 1].map(|object| {
        let (before, after) = (before[object], after[object]);
        assert!(before.translation.z < -0.1, "it is lifted: {before:?}");
        ((after.translation.vector - before.translation.vector).norm(), before.rotation.angle_to(&after.rotation))
    })
}

#[test]
fn a_cube_that_is_gripped_neither_creeps_nor_turns_however_askew_it_was() {
    for turned in [0.0, 0.1, 0.3, 0.5] {
        for (moved, rotated) in hold(turned, 60.0) {
            println!("gripped at {turned} rad: moved {:.3} um, turned {rotated:.6} rad", moved * 1e6);
            assert!(moved < 2e-5 && rotated < 1e-3, "gripped at {turned} rad: {moved} m, {rotated} rad");
        }
    }
}

#[test]
fn act_counts_from_0_and_mispkg_from_1_and_both_have_keys_in_one_case() {
    let (mut world, robot) = world(EDGE);
    for (line, expected) in [
        ("ACT {Name ARM} {Link 0} {Value 0.3}", 0.3),
        ("MISPKG {Name Arm} {Link 1} {Value 0.1} {Order 0}", 0.1),
        ("MISPKG {Name Arm} {Link 1} {Value 0.2} {Order 1}", 0.1),
        ("MISPKG {Name Arm} {Link 1} {Order 0} {Value 0.4}", 0.4),
        ("MISPKG {Name Arm} {Link 1} {Order 1} {Value 0.1}", 0.4),
        ("MISPKG {Name Arm} {Link 2} {Value 0.3} {Link 1} {Value 0.2}", 0.2),
        ("ACT {Name Arm} {link 0} {value 0.5}", 0.2),
        ("ACT {Name nobody} {Link 0} {Value 1}", 0.2),
        ("ACT {Name Arm} {Link 9} {Value 1}", 0.2),
        ("SET {Type Joint} {Name ArmJoint1} {Opcode Angle} {Params -0.2}", -0.2),
    ] {
        assert_eq!(apply(&mut world, robot, line), [""; 0], "{line}");
        let (values, _) = states(&mut world, 1.0);
        assert!((f64::from(values[0]) - expected).abs() < 0.002, "{line}: {values:?}");
    }
    let mut problems = Vec::new();
    world.execute(Some(robot), &command("ACT {Name Amr} {Link 0} {Value 1}"), &mut problems);
    let said: Vec<String> = problems.iter().map(ToString::to_string).collect();
    assert_eq!(said, ["{Name Amr} is unknown (did you mean `Arm`?); expected one of Arm, Gripper; nothing is moved"]);
    for (line, expected) in [
        ("ACT {Name Arm} {Link 99} {Value 1}", "{Link 99}: the actuator `Arm` has links 0 to 4; nothing is moved"),
        (
            "MISPKG {Name Arm} {Link 0} {Value 1} {Order 0}",
            "{Link 0}: the actuator `Arm` has links 1 to 5; nothing is moved",
        ),
        ("MISPKG {Name Arm} {Value 1} {Link 1}", "MISPKG needs Link and Value, or Gripper"),
        ("ACT {Name Arm}", "ACT needs Link and Value, or Gripper"),
        (
            "SET {Type Lamp} {Opcode RESET}",
            "SET {Type Lamp}: the robot has no such item or opcode; expected one of Gripper Gripper, GroundTruth GndTruth, ",
        ),
        (
            "SET {Type Joint} {Name Elbow} {Opcode Angle} {Params 1}",
            "SET {Type Joint} {Name Elbow}: the robot has no such item or opcode; ",
        ),
    ] {
        let mut problems = Vec::new();
        let command = Command::parse(line, &mut problems).expect("a command");
        world.execute(Some(robot), &command, &mut problems);
        assert!(problems.iter().any(|problem| problem.to_string().starts_with(expected)), "{line}: {problems:?}");
    }
    let confs = ["GETCONF {Type Actuator}", "GETCONF {Type MisPkg}", "GETCONF {Type Gripper}"];
    let confs = confs.map(|line| apply(&mut world, robot, line).join("\n"));
    let first = "{Link 1} {JointType Revolute} {MaxTorque 47.5000} {MinValue -2.9496} {MaxValue 2.9496} {Link 2}";
    assert!(confs[0].starts_with(&format!("CONF {{Type Actuator}} {{Name Arm}} {first}")), "{}", confs[0]);
    assert!(
        confs[1].starts_with("CONF {Type MisPkg} {Name Arm} {Link 1} {JointType Revolute} {MaxRotationSpeed 1.571}")
    );
    assert_eq!(
        confs[2],
        "CONF {Type Gripper} {Name Gripper} {Opcode Grip} {MaxVal 1} {MinVal 0} {Opcode Close} {Opcode Open}"
    );
    let geo = apply(&mut world, robot, "GETGEO {Type Actuator}").join("\n");
    let expected = "GEO {Type Actuator} {Name Arm} {Location 0.000,0.000,0.000} {Orientation 0.000,0.000,0.000}{Mount YouBotArm} \
                    {Link 1} {Parent 0} {Location 0.167,0.000,-0.142} {Orientation 0.00,0.00,0.00} {Link 2} {Parent 1} ";
    assert!(geo.starts_with(expected) && geo.ends_with("{Tip 0.00,0.00,-0.08}"), "{geo}");
}

/// A laser on the hand points where the hand does.
#[test]
fn a_sensor_on_a_link_goes_where_that_goes() {
    let text = include_str!("../../assets/robots/YouBotArm/robot.toml");
    let sensors = "[[sensor]]\nclass = \"Sonar\"\nname = \"HandSonar\"\nlink = \"ArmJoint5\"\nposition = [0.198, 0.0, -0.67]\n\
                   direction = [0.0, 1.5707963, 0.0]\nmax_range = 4.0\n\
                   [[sensor]]\nclass = \"GroundTruth\"\nname = \"Hand\"\nlink = \"ArmJoint5\"\nfixed_to_platform = false\n\
                   position = [0.198, 0.0, -0.66]\n";
    let folder = tempfile::tempdir().expect("a folder");
    copy_robot("YouBotArm", folder.path());
    let path = folder.path().join("Handy.toml");
    std::fs::write(&path, format!("{text}\n{sensors}")).expect("a file");
    let scene = scene_loader::load("rough", &[&path]).unwrap_or_else(|error| panic!("{error}"));
    let mut world = World::new(scene, Options::default());
    let robot = init(&mut world, "INIT {ClassName USARBot.Handy} {Location 0,0,0}");
    apply(&mut world, robot, &to_height(0.2));
    let messages = run(&mut world, 4.0);
    let sensed =
        messages.iter().rev().filter_map(|it| if let Message::Sen(it) = it { Some(&it.reading) } else { None });
    let (mut hand, mut range) = (None, None);
    for reading in sensed {
        match reading {
            Reading::GroundTruth(it) if it.name == "Hand" => hand = hand.or(Some(it.location)),
            Reading::Sonar(it) => range = range.or(Some(it.range)),
            _ => {}
        }
    }
    let ([x, y, z], range) = (hand.expect("a pose"), range.expect("a range"));
    println!("hand at {x:.4}, {y:.4}, {z:.4}; sonar {range:.4} m");
    // The hand's middle is 2 mm from the middle of the wrist.
    assert!((f64::from(x) - AHEAD).abs() < 0.01 && y.abs() < 0.005 && (f64::from(z) + 0.2).abs() < 0.01, "{x} {y} {z}");
    assert!((f64::from(range) - 0.19).abs() < 0.01, "{range} m to the floor");
    let geo = apply(&mut world, robot, "GETGEO {Type Sonar}").join("\n");
    assert!(geo.contains("{Location 0.00,0.00,-0.09}") && geo.ends_with("{Mount Arm}{MountLink 5}"), "{geo}");
}

#[test]
fn a_joint_at_rest_reports_no_negative_zero() {
    let (mut world, _) = world(EDGE);
    for message in run(&mut world, 2.0).iter().filter(|message| matches!(message, Message::Asta(_))) {
        let line = message.write(gamebots_proto::Dialect::Udk);
        assert!(!line.contains("-0.0000"), "{line}");
    }
}

/// The arm is laid down aside and swung back until it meets the chassis. It stays there, and its push moves nothing: the forces are within
/// the robot.
#[test]
fn an_arm_stops_at_its_own_base_and_does_not_push_the_robot() {
    let (mut world, robot) = world(EDGE);
    let put = |world: &mut World, angles: [f64; 4]| {
        let link = |(number, angle): (usize, &f64)| format!("{{Link {number}}} {{Value {angle:.3}}}");
        let links: String = angles.iter().enumerate().map(link).collect();
        apply(world, robot, &format!("ACT {{Name arm}} {links}"));
        run(world, 6.0);
    };
    put(&mut world, [-2.9, -1.13, -2.63, -1.78]);
    let number =
        world.def().robots["YouBotArm"].with_values().position(|link| link.name == "ArmJoint1").expect("a joint");
    let turned = |world: &World| world.snapshot().robots[0].joints[number].position;
    let free = turned(&world);
    assert!((free + 2.9).abs() < 0.02, "{free}");
    put(&mut world, [2.9, -1.13, -2.63, -1.78]);
    let stopped = turned(&world);
    assert!((-2.2..-1.6).contains(&stopped), "{stopped}");
    let place = |world: &World| world.state(robot).expect("a robot").0.pose.translation.vector;
    let before = place(&world);
    run(&mut world, 5.0);
    let crept = (place(&world) - before).norm();
    assert!(crept < 1e-4, "{crept} m");
    // Once it is raised, it turns on.
    put(&mut world, [2.9, 0.0, 0.0, 0.0]);
    let turned = turned(&world);
    assert!((turned - 2.9).abs() < 0.02, "{turned}");
}
