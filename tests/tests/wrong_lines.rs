//! Mistakes in lines are reported to those who asked for it, and in the log.

use gamebots_proto::Command;
use sim_core::World;
use system_tests::{Server, init, problems, world};

/// A world with a robot, which starts with this name.
fn with_robot(class: &str) -> (World, sim_core::PawnId) {
    let mut world = world("rough", 0);
    let robot = init(&mut world, &format!("INIT {{ClassName USARBot.{class}}} {{Location 0,0,-0.3}}"));
    (world, robot)
}

/// Checks the beginnings of all problems of a line.
#[track_caller]
fn check(class: &str, line: &str, expected: &[&str]) {
    let (mut world, robot) = with_robot(class);
    let said = problems(&mut world, robot, line);
    assert_eq!(said.len(), expected.len(), "{class}, {line}: {said:?}");
    for (said, expected) in said.iter().zip(expected) {
        assert!(said.starts_with(expected), "{class}, {line}: {said}, expected {expected}");
    }
}

#[test]
fn a_drive_with_a_key_that_the_robot_does_not_take_names_it_and_what_it_takes() {
    const SKID: &str = "expected Left, Right, Normalized, Light, Flip; the block is ignored";
    let wrong = |key: &str, rest: &str| format!("DRIVE: P3AT takes no key `{key}`{rest}");
    let expected = |key: &str| wrong(key, &format!("; {SKID}"));
    for key in ["Speed", "LinearVelocity", "Front-Left"] {
        check("P3AT", &format!("DRIVE {{{key} 2}}"), &[&expected(key)]);
    }
    let guess = wrong("Left=2", &format!(" (did you mean `{{Left 2}}`?); {SKID}"));
    check("P3AT", "DRIVE {Left=2}", &[&guess]);
    check("P3AT", "DRIVE {Left=2} {Right=2}", &[&guess, &wrong("Right=2", " (did you mean `{Right 2}`?)")]);
    check(
        "P3AT",
        "DRIVE {Lft 2} {Right 2}",
        &[&wrong("Lft", " (did you mean `Left`?)"), "DRIVE needs Left and Right together"],
    );
    check(
        "P3AT",
        "DRIVE {Left 2",
        &["`{Left 2`: the brace is not closed", "DRIVE without a value does nothing; P3AT takes Left, "],
    );
    check("P3AT", "DRIVE", &["DRIVE without a value does nothing; P3AT takes Left, Right, Normalized, Light, Flip"]);
    check(
        "P3AT",
        "DRIVE {Left} {Right}",
        &["{Left} is ignored: it has no value", "{Right} is ignored: it has no value"],
    );
    check("P3AT", "DRIVE {Left 1} {Right 1} {left 2}", &["{left} is ignored: the first of a line counts"]);
    check("P3AT", "DRIVE {Left 1} {Right 1} {Hover true} {Speed 1}", &[&expected("Hover"), &expected("Speed")]);
    check(
        "KUKA_YouBot",
        "DRIVE {Speed 2}",
        &["DRIVE: KUKA_YouBot takes no key `Speed`; expected Front-Left, Front-Right, "],
    );
    check(
        "KUKA_YouBot",
        "DRIVE {WheelNumber 4} {WheelSpeed 1}",
        &["{WheelNumber 4} is ignored: KUKA_YouBot has wheels 0 to 3"],
    );
    check(
        "FrontAckerman",
        "DRIVE {Left 1} {Right 1}",
        &[
            "DRIVE: FrontAckerman takes no key `Left`; expected Speed, FrontSteer, RearSteer, Normalized, Light, Flip; ",
            "DRIVE: FrontAckerman takes no key `Right`; ",
        ],
    );
    check(
        "AirRobot",
        "DRIVE {Linear 1}",
        &["DRIVE: AirRobot takes no key `Linear` (did you mean `LinearVelocity`?); "],
    );
    check("Nao", "DRIVE {Left 1}", &["a Nao has no drive; move its joints with SET {Type Joint}"]);
}

/// Programs of fifteen years send these.
#[test]
fn lines_that_known_programs_mean_have_no_problem() {
    const STOP: &str = "DRIVE {Left 0} {Right 0} {Speed 0} {AltitudeVelocity 0} {LinearVelocity 0} {LateralVelocity 0} {RotationalVelocity 0}";
    for class in ["P3AT", "KUKA_YouBot", "AirRobot"] {
        check(class, STOP, &[]);
    }
    check("P3AT", "DRIVE {Left 3.00} {Right 3.00} {Light true} {Normalized true}", &[]);
    check("P3AT", "DRIVE {light True}", &[]);
    check("P3AT", "DRIVE {Left 3,00} {Right 3,00} ", &[]);
    check(
        "KUKA_YouBot",
        "DRIVE {WheelNumber 0} {WheelSpeed 1} {WheelSteer 0} {WheelNumber 1} {WheelSpeed 1} {WheelSteer 0}",
        &[],
    );
    check("FrontAckerman", "DRIVE {Speed 3.00} {FrontSteer 0.10} {RearSteer 0.00}", &[]);
    check("AirRobot", "DRIVE {AltitudeVelocity 0.00} {LinearVelocity 0.50} {Spin1 2}", &[]);
    check("P3AT", "GETCONF {Type Robot} {Name ROSbot}", &[]);
    check("P3AT", "GETCONF {Type MisPkg}", &[]);
    check("Kenaf", "MULTIDRIVE {FLFlipper 0.5} {RLFlipper  0.5}", &[]);
    check("P3AT", "SET {Type Tachometer} {Name TachTest} {Opcode RESET} ", &[]);
}

#[test]
fn a_type_or_name_that_the_robot_does_not_have_is_named_with_what_it_has() {
    check(
        "P3AT",
        "GETCONF {Type RangeScaner}",
        &[
            "GETCONF {Type RangeScaner}: the robot has no such item (did you mean `RangeScanner`?); expected one of Robot, ",
        ],
    );
    check(
        "P3AT",
        "GETGEO {Type robot}",
        &["GETGEO {Type robot}: the robot has no such item (did you mean `Robot`?); "],
    );
    check(
        "P3AT",
        "GETCONF {Type RangeScanner} {Name lms20}",
        &["GETCONF {Type RangeScanner} {Name lms20}: the robot has no such item (did you mean `lms200`?); "],
    );
    check("P3AT", "GETGEO", &["GETGEO: the robot has no such item; expected one of Robot, "]);
    check(
        "P3AT",
        "SET {Type Tachometr} {Opcode RESET}",
        &["SET {Type Tachometr}: the robot has no such item or opcode (did you mean `Tachometer`?); expected one of "],
    );
    check(
        "P3AT",
        "ACT {Name Arm} {Link 0} {Value 1}",
        &["{Name Arm} is unknown; this robot has none; nothing is moved"],
    );
    check(
        "P3AT",
        "MULTIDRIVE {FLFlipper 1}",
        &["{MULTIDRIVE FLFlipper} is unknown; this robot has none; nothing is moved"],
    );
}

#[test]
fn a_robot_with_a_flat_battery_says_so() {
    let mut world = World::new(system_tests::scene_with_test_robot("ShortLife"), sim_core::Options::default());
    let robot = init(&mut world, "INIT {ClassName USARBot.ShortLife}");
    system_tests::run(&mut world, 30.0);
    assert_eq!(world.battery(robot), Some(0), "the test's robot still has power");
    for verb in ["DRIVE {Left 1} {Right 1}", "GETCONF {Type Robot}", "SET {Type Joint} {Opcode Angle} {Params 1}"] {
        let said = problems(&mut world, robot, verb);
        let verb = verb.split(' ').next().expect("a verb");
        assert_eq!(said, [format!("{verb} ignored: the robot's battery is flat")]);
    }
}

#[test]
fn a_robot_without_a_name_is_described_by_its_class() {
    let (mut world, _) = with_robot("P3AT");
    let Some(Command::Init(again)) = Command::parse("INIT {ClassName P3AT} {Location 0,0,-0.3}", &mut Vec::new())
    else {
        panic!("no INIT");
    };
    let mut problems = Vec::new();
    world.init(&again, &mut problems).expect("a robot");
    let said: Vec<String> = problems.iter().map(ToString::to_string).collect();
    assert!(said.iter().any(|said| said.contains(": robot 0 (P3AT) takes it; ")), "{said:?}");
}

#[test]
fn a_team_without_a_league_is_said() {
    let server = Server::start("rough", &[], |_| {});
    let mut peer = server.client();
    peer.send("REPORT {Errors true}");
    peer.send("INIT {ClassName USARBot.P3AT} {Team red}");
    assert_eq!(peer.reply(), "NFO {Error 'Team red' is ignored: this world has no league}");
}
