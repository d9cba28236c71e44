//! `usarsim experiment` as a process.

use std::process::Command;

const FILE: &str = r#"
description = "ahead and to the left"
drive_models = ["analytic"]
[setup]
steps = 4
[[axis]]
name = "move"
values = [
    { name = "forward", drive = "DRIVE {Front-Left 1}{Front-Right 1}{Back-Left 1}{Back-Right 1}" },
    { name = "left", drive = "DRIVE {Front-Left -1}{Front-Right 1}{Back-Left 1}{Back-Right -1}", main = [0, 1], error = [1, 0] },
]
"#;

/// Reads run, step and travel of every step.
fn steps(folder: &std::path::Path) -> Vec<(String, u32, f64)> {
    let table = std::fs::read_to_string(folder.join("steps.csv")).expect("steps.csv");
    let read = |line: &str| {
        let mut parts = line.split(',');
        let mut part = || parts.next().expect("a part").to_owned();
        (part(), part().parse().expect("a step"), part().parse().expect("a travel"))
    };
    table.lines().skip(1).map(read).collect()
}

#[test]
fn an_experiment_through_the_socket_has_the_steps_of_one_in_process() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("moves.toml"), FILE).expect("a file");
    let run = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_usarsim"));
        let output = command.args(arguments).current_dir(&folder).output().expect("usarsim runs");
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let conduct = |arguments: &[&str]| run(&[&["--quiet", "experiment", "run", "moves.toml"], arguments].concat());
    assert_eq!(conduct(&["--out", "here"]), (Some(0), String::new()));
    assert_eq!(conduct(&["--out", "there", "--socket", "10"]), (Some(0), String::new()));
    let (here, there) = (steps(&folder.path().join("here")), steps(&folder.path().join("there")));
    assert_eq!(here.len(), 8);
    for ((run, step, travel), (same_run, same_step, on_the_wire)) in here.iter().zip(&there) {
        assert_eq!((run, step), (same_run, same_step));
        // Poses on the wire have millimetres. The first step begins when its line arrives.
        let allowed = if *step == 1 { 0.02 } else { 0.0015 };
        assert!((travel - on_the_wire).abs() < allowed, "{run} {step}: {travel} {on_the_wire}");
    }
    // A run through the socket can be replayed, and is not confused with a run in this process.
    assert_eq!(run(&["log", "replay", "there/logs"]).0, Some(0));
    let (code, said) = conduct(&["--out", "there"]);
    assert!(code == Some(78) && said.contains("another version of `moves`"), "{said}");
}
