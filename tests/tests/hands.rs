//! Hands: world controllers that pull objects and robots by springs.

use nalgebra::Vector3;
use sim_core::{Options, World};
use system_tests::{Server, Stage, init, problems};

/// Way that what is lifted hangs below the hand, m: gravity over the square of the spring's frequency.
const SAG: f64 = GRAVITY / 100.0;
/// Gravity of the map, m/s²: that of UT.
const GRAVITY: f64 = 9.81;
const CRATE: &str = "{Type Create} {ClassName WCCrate} {Name box} {Location 1,0,-0.26} {Physics RigidBody}";

/// Runs a world for a time, s, in its own steps.
fn run(world: &mut World, seconds: f64) {
    let end = world.time() + seconds;
    while world.time() < end {
        world.step();
    }
}

/// Puts a controller into a world with a time step, s.
fn stage_with(time_step: f64) -> Stage {
    Stage::new("rough", Options { time_step, ..Options::default() })
}

#[test]
fn a_crate_is_lifted_hangs_below_the_hand_and_falls_when_it_is_let_go() {
    let mut stage = stage_with(0.008);
    stage.must(CRATE);
    run(&mut stage.world, 2.0);
    // It sleeps now, and its lid is pulled.
    stage.must("{Type Pull} {Name BOX} {Grip 0,0,-0.25} {Location 1.5,0.5,-1.5}");
    run(&mut stage.world, 6.0);
    let at = stage.at("box");
    assert!((at - Vector3::new(1.5, 0.5, -1.5 + 0.25 + SAG)).norm() < 0.005, "{at}");
    let [pull] = stage.world.snapshot().pulls[..] else { panic!("one spring") };
    let weight = 9.81 * stage.object("box").def.mass;
    assert!((pull.force.norm() - weight).abs() < 0.01 * weight, "{} N", pull.force.norm());
    assert_eq!(pull.to, Vector3::new(1.5, 0.5, -1.5));
    stage.must("{Type Pull} {Name box}");
    run(&mut stage.world, 2.0);
    assert!((stage.at("box").z + 0.25).abs() < 0.01, "{}", stage.at("box"));
    assert_eq!(stage.world.snapshot().pulls, []);
}

#[test]
fn a_crate_is_turned_by_its_rotation_and_thrown_by_a_hand_that_goes_on() {
    let mut stage = stage_with(0.008);
    stage.must(CRATE);
    stage.must("{Type Pull} {Name box} {Location 1,0,-1} {Rotation 0,0.5,1.2}");
    run(&mut stage.world, 3.0);
    let [roll, pitch, yaw] = scene::position_and_rotation(&stage.object("box").pose).1;
    assert!(roll.abs() < 0.01 && (pitch - 0.5).abs() < 0.01 && (yaw - 1.2).abs() < 0.01, "{roll} {pitch} {yaw}");
    stage.must("{Type Pull} {Name box} {Location 4,0,-3}");
    run(&mut stage.world, 0.4);
    stage.must("{Type Pull} {Name box}");
    let from = stage.at("box");
    run(&mut stage.world, 0.3);
    assert!((stage.at("box") - from).x > 0.5, "{from} to {}", stage.at("box"));
}

#[test]
fn robots_are_lifted_by_name_or_number_and_drive_on() {
    for (class, name, called) in [("P3AT", "{Name Rob}", "Rob"), ("KUKA_YouBot", "", "#1"), ("YouBotArm", "", "#1")] {
        let mut stage = stage_with(0.008);
        let robot = init(&mut stage.world, &format!("INIT {{ClassName USARBot.{class}}} {name} {{Location 0,0,-0.2}}"));
        let at = |stage: &Stage| stage.world.observe(robot).expect("a robot").body.pose.translation.vector;
        run(&mut stage.world, 0.5);
        let ground = at(&stage);
        stage.must(&format!("{{Type Pull}} {{Name {called}}} {{Grip 0,0,-0.3}} {{Location 0,1,-1}}"));
        run(&mut stage.world, 8.0);
        let pose = stage.world.observe(robot).expect("a robot").body.pose;
        let grip = (pose * nalgebra::Point3::new(0.0, 0.0, -0.3)).coords;
        assert!((grip - Vector3::new(0.0, 1.0, -1.0 + SAG)).norm() < 0.02, "{class}: {grip}");
        stage.must(&format!("{{Type Pull}} {{Name {called}}}"));
        run(&mut stage.world, 2.0);
        assert!((at(&stage).z - ground.z).abs() < 0.01, "{class}: {} instead of {}", at(&stage).z, ground.z);
        let landed = at(&stage);
        let drive = if class == "P3AT" {
            "DRIVE {Left 2} {Right 2}"
        } else {
            "DRIVE {Front-Left 2} {Front-Right 2} {Back-Left 2} {Back-Right 2}"
        };
        system_tests::apply(&mut stage.world, robot, drive);
        run(&mut stage.world, 2.0);
        assert!((at(&stage) - landed).norm() > 0.15, "{class}: {}", at(&stage));
    }
}

/// A spring at a corner, or far from the body, turns it more than it moves it.
#[test]
fn nothing_swings_up_whatever_is_pulled_wherever_at_any_time_step() {
    for time_step in [0.002, 0.008, 0.02] {
        for (class, grip) in [
            ("WCCrate", "0.25,0.25,0.25"),
            ("WCPallet", "0.6,0.4,0"),
            ("PartA", "0.02,0.02,0"),
            ("WCCrate", "3,0,0"),
            ("WCCrate", "50,50,0"),
        ] {
            let mut stage = stage_with(time_step);
            stage.must(&format!("{{Type Create}} {{ClassName {class}}} {{Name box}} {{Physics RigidBody}}"));
            stage.must(&format!("{{Type Pull}} {{Name box}} {{Grip {grip}}} {{Location 1,1,-2}}"));
            run(&mut stage.world, 20.0);
            let before = stage.object("box").pose;
            run(&mut stage.world, 0.1);
            let after = stage.object("box").pose;
            let speed = (after.translation.vector - before.translation.vector).norm() / 0.1;
            let turn = before.rotation.angle_to(&after.rotation) / 0.1;
            assert!(speed < 0.5 && turn < 3.0, "{class} {grip} {time_step}: {speed} m/s, {turn} rad/s");
            assert_eq!(stage.world.take_restored(), [], "{class} {grip} {time_step}");
        }
    }
}

#[test]
fn a_pull_ends_with_its_thing_its_hand_or_another_hand() {
    let mut stage = stage_with(0.008);
    stage.must(&format!("{CRATE} {{Permanent true}}"));
    let other = init(&mut stage.world, "INIT {ClassName WorldController}");
    let pulls = |stage: &mut Stage| {
        run(&mut stage.world, 0.1);
        stage.world.snapshot().pulls.len()
    };
    stage.must("{Type Pull} {Name box} {Location 1,0,-1}");
    assert_eq!(pulls(&mut stage), 1);
    assert_eq!(problems(&mut stage.world, other, "CONTROL {Type Pull} {Name box} {Location 2,0,-1}"), [""; 0]);
    assert_eq!(pulls(&mut stage), 1);
    stage.world.remove(other);
    assert_eq!(pulls(&mut stage), 0);
    stage.must("{Type Pull} {Name box} {Location 1,0,-1}");
    stage.must("{Type Kill} {Name box}");
    assert_eq!(pulls(&mut stage), 0);
    let robot = init(&mut stage.world, "INIT {ClassName P3AT} {Name Rob} {Location 3,3,-0.2}");
    stage.must("{Type Pull} {Name Rob} {Location 1,0,-1}");
    stage.world.remove(robot);
    assert_eq!(pulls(&mut stage), 0);
}

#[test]
fn what_cannot_be_pulled_says_why() {
    let mut stage = stage_with(0.008);
    stage.must("{Type Create} {ClassName WCCrate} {Name stays} {Location 5,0,-1}");
    init(&mut stage.world, "INIT {ClassName AirRobot} {Name Fly} {Location 3,0,-2}");
    for (order, why) in [
        ("{Name nobody} {Location 1,0,0}", "no object or robot has that name"),
        ("{Name #7} {Location 1,0,0}", "no object or robot has that name"),
        ("{Name stays} {Location 1,0,0}", "created without {Physics RigidBody}"),
        ("{Name Fly} {Location 1,0,0}", "its rotors hold it"),
        ("{Name stays} {Location 1e9,0,0}", "Location"),
        ("{Name stays} {Grip 0,1e9,0} {Location 1,0,0}", "Grip"),
        ("{Name stays} {Location 1,0,x}", "Location"),
    ] {
        let problems = stage.order(&format!("{{Type Pull}} {order}"));
        assert!(problems.iter().any(|problem| problem.contains(why)), "{order}: {problems:?}");
    }
}

#[test]
fn a_controller_pulls_no_more_than_it_leaves_for_others() {
    let mut stage = stage_with(0.008);
    let other = init(&mut stage.world, "INIT {ClassName WorldController}");
    let mut pull = |number: usize, is_other: bool| {
        let at = format!("{},{},-0.26", number % 10, number / 10);
        let create =
            format!("{{Type Create}} {{ClassName WCCrate}} {{Name c{number}}} {{Location {at}}} {{Physics RigidBody}}");
        stage.must(&format!("{create} {{Permanent true}}"));
        let pull = format!("{{Type Pull}} {{Name c{number}}} {{Location 0,0,-1}}");
        if is_other { problems(&mut stage.world, other, &format!("CONTROL {pull}")) } else { stage.order(&pull) }
    };
    for (is_other, most) in [(false, 32), (true, 16)] {
        let first = if is_other { 40 } else { 0 };
        for number in 0..most {
            assert_eq!(pull(first + number, is_other), [""; 0], "{number}");
        }
        let problems = pull(first + most, is_other);
        assert!(problems.iter().any(|problem| problem.contains("left for others")), "{problems:?}");
    }
}

#[test]
fn a_wall_stops_what_is_pulled_behind_it() {
    for thing in ["a crate", "P3AT", "KUKA_YouBot"] {
        let mut stage = stage_with(0.008);
        stage.must("{Type Create} {ClassName WCCrate} {Name wall} {Location 2,0,-2} {Scale 0.1,10,8}");
        let called = if thing == "a crate" {
            stage.must("{Type Create} {ClassName WCCrate} {Name box} {Location -2,0,-0.26} {Physics RigidBody}");
            "box"
        } else {
            init(&mut stage.world, &format!("INIT {{ClassName {thing}}} {{Name Rob}} {{Location -2,0,-0.2}}"));
            "Rob"
        };
        for grip in ["0.1,0.1,-0.1", "0,0,0"] {
            stage.must(&format!("{{Type Pull}} {{Name {called}}} {{Grip {grip}}} {{Location 8,0,-0.4}}"));
            run(&mut stage.world, 4.0);
            let [pull] = stage.world.snapshot().pulls[..] else { panic!("{thing}: {:?}", stage.world.take_lost()) };
            assert!((0.5..2.0).contains(&pull.from.x), "{thing}: {}", pull.from);
        }
    }
}

#[test]
fn robots_and_crates_that_are_pulled_to_one_place_are_not_lost() {
    let mut stage = stage_with(0.008);
    for number in 0..12 {
        let (x, y) = (-3 + 2 * (number % 4), -2 + 2 * (number / 4));
        let class = ["P3AT", "KUKA_YouBot", "Kenaf"][number as usize % 3];
        init(&mut stage.world, &format!("INIT {{ClassName {class}}} {{Name r{number}}} {{Location {x},{y},-0.3}}"));
        stage.must(&format!(
            "{{Type Create}} {{ClassName WCCrate}} {{Name c{number}}} {{Location {x},{},-0.3}} {{Physics RigidBody}}",
            y + 1
        ));
        for name in ["r", "c"] {
            stage.must(&format!("{{Type Pull}} {{Name {name}{number}}} {{Location 0,0,-0.8}}"));
        }
    }
    run(&mut stage.world, 4.0);
    assert_eq!(stage.world.take_lost(), []);
    assert_eq!(stage.world.take_restored(), []);
    assert_eq!(stage.world.snapshot().pulls.len(), 24);
}

#[test]
fn a_saved_world_is_pulled_on_with_the_same_bits() {
    let mut stage = stage_with(0.008);
    stage.must(CRATE);
    stage.must("{Type Pull} {Name box} {Grip 0.25,0.1,0} {Location 0,1,-2} {Rotation 0,0,1}");
    run(&mut stage.world, 0.5);
    let saved = serde_json::to_value(stage.world.save().expect("a saved world")).expect("JSON");
    let load = |saved| World::load(stage.world.scene().clone(), &serde_json::from_value(saved).expect("a state"));
    let mut loaded = load(saved.clone()).expect("a world");
    run(&mut loaded, 1.0);
    let mut wrong = saved;
    wrong["pulls"][0]["spring"]["to"][0] = 1e12.into();
    assert_eq!(load(wrong).err(), Some(sim_core::LoadError::Pulls));
    run(&mut stage.world, 1.0);
    assert_eq!(loaded.digest(), stage.world.digest());
}

#[test]
fn a_crate_that_is_dragged_in_a_recorded_run_replays_with_the_same_bits() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.mcap");
    let server = Server::start("rough", &[], |config| config.log = Some(path.clone()));
    let mut robot = server.client();
    robot.send("INIT {ClassName USARBot.P3AT} {Name Rob} {Location 0,0,-0.2}");
    robot.next_of("STA");
    let mut hand = server.client();
    hand.send("INIT {ClassName WorldController}");
    hand.send(&format!("CONTROL {CRATE}"));
    let at = |hand: &mut system_tests::Peer| {
        hand.send("CONTROL {Type GetSTA} {Name box}");
        let line = hand.next_of("STA");
        let text = line.split("{Location ").nth(1).and_then(|it| it.split(' ').next()).expect("a place").to_owned();
        let numbers: Vec<f64> = text.split(',').map(|it| it.parse().expect("a number")).collect();
        Vector3::from_row_slice(&numbers)
    };
    // Towards the robot, against it, and up.
    for step in 0..20 {
        let x = 1.0 - f64::from(step) * 0.05;
        hand.send(&format!("CONTROL {{Type Pull}} {{Name box}} {{Grip 0,0.2,0}} {{Location {x},0,-0.3}}"));
        robot.next_of("STA");
    }
    hand.send("CONTROL {Type Pull} {Name box} {Location 0,2,-1}");
    system_tests::wait_until(|| (at(&mut hand) - Vector3::new(0.0, 2.0, -1.0 + SAG)).norm() < 0.05);
    hand.send("CONTROL {Type Pull} {Name box}");
    system_tests::wait_until(|| at(&mut hand).z > -0.27);
    drop((robot, hand));
    server.stop().expect("a good end");
    let replay = logbook::replay(&recorder::read(&path).expect("a log")).expect("a replay");
    assert!(replay.is_same(), "{replay:?}");
}
