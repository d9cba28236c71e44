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
    assert_eq!(conduct(&["--out", "there", "--socket", "2"]), (Some(0), String::new()));
    let (here, there) = (steps(&folder.path().join("here")), steps(&folder.path().join("there")));
    assert_eq!(here.len(), 8);
    for ((run, step, travel), (same_run, same_step, on_the_wire)) in here.iter().zip(&there) {
        assert_eq!((run, step), (same_run, same_step));
        // Poses on the wire have millimetres. The first step begins when its line arrives, which is late on a busy machine.
        let late = travel.abs() - on_the_wire.abs();
        let most = if *step == 1 { travel.abs() } else { 0.0015 };
        assert!((-0.0015..most).contains(&late) && travel * on_the_wire >= 0.0, "{run} {step}: {travel} {on_the_wire}");
    }
    // A run through the socket can be replayed, and is not confused with a run in this process.
    assert_eq!(run(&["log", "replay", "there/logs"]).0, Some(0));
    let (code, said) = conduct(&["--out", "there"]);
    assert!(code == Some(78) && said.contains("another version of `moves`"), "{said}");
}

/// Into a file, where there is no bar, each tenth part of the runs has a line. Without plots the report has one of each axis.
#[test]
fn an_experiment_and_a_sweep_say_how_far_they_are_and_draw_each_axis() {
    let folder = tempfile::tempdir().expect("a folder");
    let samples =
        FILE.replace("[setup]", "samples = 10\n[setup]").replace("steps = 4", "steps = 1\nstep_seconds = 0.2");
    std::fs::write(folder.path().join("moves.toml"), samples).expect("a file");
    for (command, logs) in [(&["experiment", "run"][..], true), (&["sweep"], false)] {
        let mut program = Command::new(env!("CARGO_BIN_EXE_usarsim"));
        let out = command[0];
        program.args(command).args(["moves.toml", "--out", out]).current_dir(&folder);
        let output = program.output().expect("usarsim runs");
        let (said, errors) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
        assert!(output.status.success(), "{errors}");
        // A batch of a sweep has all 20 runs.
        let lines = errors.lines().filter(|line| line.contains(" of 20 runs in ")).count();
        assert_eq!(lines, if logs { 10 } else { 1 }, "{errors}");
        assert!(errors.contains("20 of 20 runs in ") && said.contains("1 plot in"), "{said}{errors}");
        let report = std::fs::read_to_string(folder.path().join(out).join("report.html")).expect("a report");
        assert!(report.contains("20 runs of usarsim") && report.contains(", 1 experiment."), "{report}");
        assert!(report.contains("Main movement against move") && report.contains("<details open>"), "{report}");
        assert_eq!(report.contains("a log of each"), logs);
    }
}

/// A map and a robot in folders beside the experiment are found.
#[test]
fn an_experiment_takes_folders_of_a_map_and_a_robot() {
    let folder = tempfile::tempdir().expect("a folder");
    for (what, name, to) in [("map", "rough", "floor"), ("robot", "KUKA_YouBot", "Mine")] {
        let mut program = Command::new(env!("CARGO_BIN_EXE_usarsim"));
        program.args(["copy", what, name, to]).current_dir(&folder);
        assert!(program.output().expect("usarsim runs").status.success());
    }
    let file = FILE.replace("[setup]", "[setup]\nmap = \"floor\"\nrobot = \"Mine\"");
    let file = file.replace("steps = 4", "steps = 1\nstep_seconds = 0.2");
    std::fs::create_dir(folder.path().join("work")).expect("a folder");
    std::fs::write(folder.path().join("moves.toml"), file).expect("a file");
    let mut program = Command::new(env!("CARGO_BIN_EXE_usarsim"));
    let work = folder.path().join("work");
    let output = program.args(["experiment", "run", "../moves.toml"]).current_dir(work).output().expect("it runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}
