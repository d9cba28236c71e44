//! `usarsim calibrate` as a process: a log, its table and its bag of ROS 2 tell the same.

use std::path::Path;
use std::process::{Command, Output};

use experiments::plan::Plan;

/// Half a minute of a P3AT: ahead, on the spot, and a curve.
const FILE: &str = r#"
description = "ahead, on the spot, a curve"
drive_models = ["articulated"]
[setup]
map = "smooth"
robot = "P3AT"
steps = 15
script = [
    { at = 0, line = "DRIVE {Left 4}{Right 4}" },
    { at = 10, line = "DRIVE {Left 3}{Right -3}" },
    { at = 20, line = "DRIVE {Left 4}{Right 2}" },
]
"#;

fn usarsim(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_usarsim")).args(arguments).current_dir(folder).output().expect("usarsim runs")
}

/// Returns the output of a command that must succeed.
#[track_caller]
fn text(folder: &Path, arguments: &[&str]) -> String {
    let output = usarsim(folder, arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("text")
}

/// Returns the error of a command that must fail with an exit code.
#[track_caller]
fn refused(folder: &Path, code: i32, arguments: &[&str]) -> String {
    let output = usarsim(folder, arguments);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stderr).expect("text")
}

/// Returns the value of a number of the JSON that a calibration prints.
#[track_caller]
fn number(found: &str, name: &str) -> f64 {
    let found: serde_json::Value = serde_json::from_str(found).expect("JSON");
    let numbers = found["numbers"].as_array().expect("numbers");
    let number = numbers.iter().find(|it| it["name"] == name).unwrap_or_else(|| panic!("no {name} in {found}"));
    number["value"].as_f64().expect("a number")
}

#[test]
fn a_log_its_table_and_its_bag_tell_the_same() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let plan = Plan::read(Path::new("drive.toml"), FILE).unwrap_or_else(|error| panic!("{error}"));
    experiments::run::run(&plan, &plan.runs()[0], Some(&folder.join("run.mcap")))
        .unwrap_or_else(|error| panic!("{error}"));
    std::fs::write(folder.join("run.csv"), text(folder, &["log", "export", "run.mcap", "--csv"])).expect("a table");
    text(folder, &["log", "export", "run.mcap", "--ros2", "--out", "bag.mcap"]);
    // Odometry of the wheels is on the bag, too, so the truth has to be chosen.
    let several = refused(folder, 65, &["calibrate", "bag.mcap", "P3AT"]);
    assert!(several.contains("ground_truth") && several.contains("choose one with --poses"), "{several}");
    let truth = several.split([' ', ',', ':']).find(|it| it.ends_with("/ground_truth")).expect("a topic");
    let of_log = text(folder, &["calibrate", "run.mcap", "P3AT", "--json"]);
    let of_table = text(folder, &["calibrate", "run.csv", "P3AT", "--json"]);
    let of_bag = text(folder, &["calibrate", "bag.mcap", "P3AT", "--poses", truth, "--json"]);
    assert_eq!(of_log, of_table);
    println!("{of_log}\n{of_bag}");
    for name in ["wheel radius", "effective track"] {
        let [one, other] = [&of_log, &of_bag].map(|found| number(found, name));
        assert!((one / other - 1.0).abs() < 1e-3, "{name}: {one}, {other}");
    }
    assert!((number(&of_log, "wheel radius") - 0.098).abs() < 5e-4, "{of_log}");
    // Numbers as people read them, and a file with them.
    text(folder, &["copy", "robot", "P3AT", "own"]);
    let shown = text(folder, &["calibrate", "run.mcap", "own/robot.toml", "--out", "found.toml"]);
    assert!(shown.contains("not found: rolling resistance") && shown.contains("found.toml: radius = 0.09"), "{shown}");
    let written = std::fs::read_to_string(folder.join("found.toml")).expect("a file");
    assert!(written.contains("radius = 0.09") && !written.contains("radius = 0.098 "), "{written}");
    // A bag that was cut off is used up to there, and said to be.
    let bag = std::fs::read(folder.join("bag.mcap")).expect("a bag");
    std::fs::write(folder.join("cut.mcap"), &bag[..bag.len() * 3 / 4]).expect("a file");
    let cut = usarsim(folder, &["calibrate", "cut.mcap", "P3AT", "--poses", truth]);
    let said = String::from_utf8_lossy(&cut.stderr);
    assert!(cut.status.success() && said.contains("cut off"), "{said}");
    // What is wrong is said by name.
    for (code, arguments, expected) in [
        (2, &["calibrate", "run.mcap", "P3AT", "--out", "found.toml"][..], "expected its robot.toml"),
        (78, &["calibrate", "none.csv", "P3AT"], "none.csv: No such file"),
        (2, &["calibrate", "run.mcap", "P3AT", "--robot", "7"], "no robot `7`"),
        (65, &["calibrate", "bag.mcap", "P3AT", "--poses", "/none"], "on /none: it has"),
        (65, &["calibrate", "bag.mcap", "P3AT", "--poses", truth, "--wheels", "a,b,c,d"], "no joint `a`"),
    ] {
        let said = refused(folder, code, arguments);
        println!("{said}");
        assert!(said.contains(expected), "{arguments:?}: {said}");
    }
}
