//! A robot with a tool changer drops its tool, and takes it and others'.

use gamebots_proto::Problem;
use gamebots_proto::message::{Eff, Message};
use nalgebra::Vector3;
use scene::{DriveModel, ObjectSnapshot};
use sim_core::{Options, PawnId, World};
use system_tests::{apply, command, init, run, scene_with_test_robot};

const OPEN: &str = "SET {Type ToolChanger} {Name toolchange} {Opcode OPEN}";
const CLOSE: &str = "SET {Type ToolChanger} {Name toolchange} {Opcode CLOSE}";
/// Mass of the tool, kg.
const MASS: f64 = 1.5;
/// Stiffness of the slide that carries the tool changer, N/m.
const STIFFNESS: f64 = 5000.0;

/// Builds a world with the robot at the origin, its slide down so far, m, and the tool in its hand.
fn world(down: f64) -> (World, PawnId) {
    let mut world = World::new(scene_with_test_robot("KR60"), Options::default());
    let robot = init(&mut world, "INIT {ClassName KR60} {Location 0,0,-0.1}");
    apply(&mut world, robot, &format!("ACT {{Name KR60Arm}} {{Link 1}} {{Value {down}}}"));
    run(&mut world, 3.0);
    (world, robot)
}

fn tool(world: &World) -> ObjectSnapshot {
    let is_tool = |object: &ObjectSnapshot| object.def.solid.name == "KR60gripper";
    world.objects().find(is_tool).expect("a tool")
}

fn place(world: &World) -> Vector3<f64> {
    tool(world).pose.translation.vector
}

fn state(world: &mut World) -> Eff {
    let messages = run(world, 0.2);
    let effector = |message: &Message| match message {
        Message::Eff(it) if it.is_tool_changer => Some(it.clone()),
        _ => None,
    };
    messages.iter().rev().find_map(effector).expect("EFF")
}

/// Returns the reason why a command does nothing.
fn refusal(world: &mut World, robot: PawnId, text: &str) -> String {
    let mut problems = Vec::new();
    world.execute(Some(robot), &command(text), &mut problems);
    match &problems[..] {
        [Problem::ToolRefused { why, .. }] => why.clone(),
        other => panic!("{text}: {other:?}"),
    }
}

#[test]
fn a_held_tool_loads_the_arm_and_a_dropped_one_does_not() {
    let (mut world, robot) = world(0.4);
    let slide = |world: &World| world.observe(robot).expect("a robot").joints[1].position;
    let loaded = slide(&world);
    apply(&mut world, robot, OPEN);
    run(&mut world, 3.0);
    let sag = loaded - slide(&world);
    let expected = MASS * 9.81 / STIFFNESS;
    assert!((sag - expected).abs() < 0.02 * expected, "{sag} m instead of {expected}");
}

#[test]
fn a_dropped_tool_falls_to_the_floor_and_stays_one_object() {
    let (mut world, robot) = world(0.4);
    let (before, held) = (tool(&world), place(&world));
    assert!((held - Vector3::new(1.0, 0.0, -0.84 + 0.4 + 0.0935 - 0.1)).norm() < 0.01, "{held}");
    apply(&mut world, robot, OPEN);
    assert_eq!(tool(&world).pose, before.pose);
    let time = 0.2;
    run(&mut world, time);
    let fallen = place(&world).z - held.z;
    assert!((fallen - 9.81 * time * time / 2.0).abs() < 0.01, "{fallen}");
    run(&mut world, 2.0);
    let resting = tool(&world);
    assert!((resting.pose.translation.z + 0.183 / 2.0).abs() < 1e-3, "{}", resting.pose);
    assert_eq!(resting.id, before.id);
    assert_eq!(world.objects().filter(|it| it.def.solid.name == "KR60gripper").count(), 1);
}

#[test]
fn a_tool_leaves_a_moving_hand_with_its_velocity() {
    let (mut world, robot) = world(0.0);
    apply(&mut world, robot, "ACT {Name KR60Arm} {Link 0} {Value 2.5}");
    run(&mut world, 1.5);
    let turning = world.observe(robot).expect("a robot").joints[0].speed;
    assert!(turning.abs() > 0.3, "{turning}");
    let (held, angle) = (place(&world), world.observe(robot).expect("a robot").joints[0].position);
    apply(&mut world, robot, OPEN);
    run(&mut world, 0.1);
    let flown = place(&world) - held;
    let expected = 0.1 * turning * Vector3::new(-angle.sin(), angle.cos(), 0.0);
    assert!((flown - expected).xy().norm() < 0.005, "{flown} instead of {expected}");
}

#[test]
fn a_tool_on_the_floor_is_taken_again_and_hangs_where_it_did() {
    let (mut world, robot) = world(0.7);
    let held = place(&world);
    apply(&mut world, robot, OPEN);
    run(&mut world, 0.5);
    assert!(place(&world).z > held.z + 0.04, "it fell");
    assert!(!state(&mut world).closed);
    apply(&mut world, robot, CLOSE);
    let taken = state(&mut world);
    assert_eq!(
        (taken.closed, taken.tool.as_deref(), taken.tool_type.as_deref()),
        (true, Some("KR60gripper"), Some("Gripper"))
    );
    run(&mut world, 1.0);
    assert!((place(&world) - held).norm() < 1e-3, "{} instead of {held}", place(&world));
}

#[test]
fn a_tool_that_is_far_or_turned_or_absent_is_not_taken() {
    let (mut world, robot) = world(0.0);
    apply(&mut world, robot, OPEN);
    run(&mut world, 2.0);
    let why = refusal(&mut world, robot, CLOSE);
    assert!(why.contains("expected at most 0.5 m"), "{why}");
    apply(&mut world, robot, "ACT {Name KR60Arm} {Link 0} {Value 1.0}");
    run(&mut world, 4.0);
    let why = refusal(&mut world, robot, CLOSE);
    assert!(why.contains("no tool"), "{why}");
}

#[test]
fn a_robot_takes_the_tool_that_another_dropped_and_keeps_it_when_that_one_leaves() {
    let (mut world, robot) = world(0.7);
    apply(&mut world, robot, OPEN);
    run(&mut world, 0.5);
    let id = tool(&world).id;
    // The other drops its own tool aside, and a world controller puts the first one's below its hand.
    let other = init(&mut world, "INIT {ClassName KR60} {Location 4,0,-0.1}");
    let controller = init(&mut world, "INIT {ClassName USARBotAPI.WorldController}");
    apply(&mut world, other, "ACT {Name KR60Arm} {Link 0} {Value -2.0} {Link 1} {Value 0.7}");
    run(&mut world, 4.0);
    apply(&mut world, other, OPEN);
    run(&mut world, 0.5);
    apply(&mut world, other, "ACT {Name KR60Arm} {Link 0} {Value 0}");
    run(&mut world, 4.0);
    let put = "CONTROL {Type AbsMove} {Name KR60gripper} {Location 5,0,-0.0915}";
    for turned in [1.0, 0.0] {
        apply(&mut world, controller, &format!("{put} {{Rotation 0,0,{turned}}}"));
        run(&mut world, 0.2);
        if turned > 0.0 {
            let why = refusal(&mut world, other, CLOSE);
            assert!(why.contains("1.000 rad away"), "{why}");
        }
    }
    apply(&mut world, other, CLOSE);
    run(&mut world, 1.0);
    world.remove(robot);
    let held = world.objects().find(|it| it.id == id).expect("the tool");
    assert!((held.pose.translation.vector - Vector3::new(5.0, 0.0, -0.1465)).norm() < 0.01, "{}", held.pose);
    world.remove(other);
    assert!(world.objects().all(|it| it.def.solid.name != "KR60gripper"), "both tools leave with the last holder");
}

#[test]
fn a_robot_that_leaves_takes_its_tool_along_held_or_dropped() {
    for drop in [false, true] {
        let (mut world, robot) = world(0.3);
        let objects = world.objects().count();
        if drop {
            apply(&mut world, robot, OPEN);
            run(&mut world, 0.3);
        }
        assert_eq!(world.objects().count(), objects);
        world.remove(robot);
        assert_eq!(world.objects().count(), objects - 1);
    }
}

#[test]
fn a_robot_of_the_engine_keeps_its_tool_and_says_why() {
    let mut scene = scene_with_test_robot("KR60");
    scene.robots.values_mut().for_each(|robot| robot.set_drive_model(Some(DriveModel::Bodies)));
    let mut world = World::new(scene, Options::default());
    let robot = init(&mut world, "INIT {ClassName KR60} {Location 0,0,-0.1}");
    run(&mut world, 0.5);
    let why = refusal(&mut world, robot, OPEN);
    assert!(why.contains("`bodies`"), "{why}");
    assert!(state(&mut world).closed);
    run(&mut world, 0.5);
    assert!((place(&world) - Vector3::new(1.0, 0.0, -0.8465)).norm() < 0.02, "{}", place(&world));
}

#[test]
fn a_saved_world_goes_on_with_its_tools() {
    let (mut original, robot) = world(0.7);
    for text in ["GETSTARTPOSES", OPEN, CLOSE] {
        apply(&mut original, robot, text);
        run(&mut original, 0.3);
        let saved = original.save().expect("a state");
        let text = serde_json::to_string(&saved).expect("JSON");
        let mut loaded = World::load(scene_with_test_robot("KR60"), &serde_json::from_str(&text).expect("a state"))
            .expect("a world");
        let mut copy = original.clone();
        for _ in 0..200 {
            original.step();
            loaded.step();
            copy.step();
            assert_eq!((loaded.digest(), copy.digest()), (original.digest(), original.digest()));
        }
        assert_eq!(loaded.snapshot(), original.snapshot());
    }
}
