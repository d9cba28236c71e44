//! Experiments from files: refused mistakes, measured results, and their independence of the way they are run.

use std::path::Path;

use experiments::batch::{Batch, BatchError};
use experiments::claim::Claims;
use experiments::plan::Plan;
use experiments::plot::Quantity;
use experiments::run::{self, Outcome, RunError, Step};
use experiments::{report, thesis};
use gamebots_proto::Command;
use gamebots_proto::message::{Message, Reading, Sen};
use recorder::Record;
use scene::DriveModel;
use system_tests::Server;

/// The four moves of the thesis in two different samples.
const FILE: &str = r#"
description = "four moves"
drive_models = ["analytic"]
samples = 2
tolerances = { position = 0.01, yaw = 0.01, wheel_phase = 0.5, friction = 0.1, mass = 0.05 }
[setup]
steps = 2
step_seconds = 1.0
[[axis]]
name = "move"
values = [
    { name = "forward", drive = "DRIVE {Front-Left 1}{Front-Right 1}{Back-Left 1}{Back-Right 1}" },
    { name = "left", drive = "DRIVE {Front-Left -1}{Front-Right 1}{Back-Left 1}{Back-Right -1}", main = [0, 1], error = [1, 0] },
    { name = "stops", drive = "DRIVE {Left 1}{Right 1}", stop_seconds = 0.5 },
    { name = "script", script = [{ at = 0, velocity = [0.0, 0.05, 0.0] }, { at = 1, line = "DRIVE {LateralVelocity 0}" }] },
]
[[plot]]
name = "ways"
title = "ways"
y = "main"
colour = ["move"]
"#;

fn plan(text: &str) -> Plan {
    Plan::read(Path::new("moves.toml"), text).unwrap_or_else(|error| panic!("{error}"))
}

fn conduct(folder: &Path, text: &str, jobs: usize) -> Result<(Vec<Outcome>, usize), BatchError> {
    let plans = [plan(text)];
    let kept = std::sync::atomic::AtomicUsize::new(0);
    let done = |_: &Outcome, old: bool| {
        kept.fetch_add(usize::from(old), std::sync::atomic::Ordering::Relaxed);
    };
    let outcomes = Batch::open(folder, &plans)?.run(jobs, |plan, run, log| run::run(plan, run, Some(log)), done)?;
    report::write_all(folder, "moves", &plans, &[], &outcomes)?;
    Ok((outcomes, kept.into_inner()))
}

fn steps_file(folder: &Path) -> String {
    std::fs::read_to_string(folder.join("steps.csv")).expect("steps.csv")
}

#[test]
fn results_depend_neither_on_jobs_nor_on_an_interruption() {
    let (one, two) = (tempfile::tempdir().expect("a folder"), tempfile::tempdir().expect("a folder"));
    let (outcomes, kept) = conduct(one.path(), FILE, 1).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!((outcomes.len(), kept), (8, 0));
    conduct(two.path(), FILE, 2).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(steps_file(one.path()), steps_file(two.path()));
    for file in ["runs/moves/left-analytic-2.json", "steps.csv", "report.html"] {
        std::fs::remove_file(two.path().join(file)).expect(file);
    }
    let (_, kept) = conduct(two.path(), FILE, 2).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!((kept, steps_file(two.path())), (7, steps_file(one.path())));
    let page = std::fs::read_to_string(two.path().join("report.html")).expect("report.html");
    assert!(page.contains("<svg") && !page.contains("src=") && !page.contains("<link"), "a page by itself");
    assert!(two.path().join("plots/ways.png").is_file());
}

/// Steps in the frame of the start, compared with the exact kinematics: 5 cm a second ahead, 0.955 of it to the side.
#[test]
fn steps_are_those_of_the_kinematics() {
    let text = FILE.replace("name = \"forward\"", "name = \"forward\", set = [\"material.carpet.rolling_resistance=0\", \"material.roller.rolling_resistance=0\"]");
    let plan = plan(&text);
    for (prefix, expected) in
        [("moves/forward", 0.05), ("moves/left", 0.0470), ("moves/stops", 0.049), ("moves/script", 0.0)]
    {
        let wanted = plan.runs().into_iter().find(|run| run.id.starts_with(prefix)).expect(prefix);
        let outcome = run::run(&plan, &wanted, None).unwrap_or_else(|error| panic!("{error}"));
        let Step { main, error, yaw } = outcome.steps[1];
        println!("{prefix}: {main:.5} {error:.5} {yaw:.5}");
        assert!((main - expected).abs() < 0.0012, "{prefix}: {main}");
        assert!(error.abs() < 0.001 && yaw.abs() < 0.002, "{prefix}: {error} {yaw}");
    }
    let script = plan.runs().into_iter().find(|run| run.id.starts_with("moves/script")).expect("a script");
    let outcome = run::run(&plan, &script, None).unwrap_or_else(|error| panic!("{error}"));
    assert!((outcome.steps[0].error - 0.047).abs() < 0.002, "its first step is to the left: {:?}", outcome.steps[0]);
}

#[test]
fn samples_differ_and_a_sample_is_the_same_in_every_setting() {
    let plan = plan(FILE);
    let runs = plan.runs();
    let prepared = |index: usize| run::prepare(&plan, &runs[index]).unwrap_or_else(|error| panic!("{error}"));
    let (first, second, other_move) = (prepared(0), prepared(1), prepared(2));
    assert_ne!(first.init, second.init);
    assert_ne!(first.world.robots, second.world.robots);
    assert_eq!((&first.init, &first.world.robots), (&other_move.init, &other_move.world.robots));
}

/// An experiment without the wanted models must not fall back to the robot's own model.
#[test]
fn an_experiment_without_the_wanted_models_has_no_runs() {
    let models = |text: &str, wanted: &[DriveModel]| {
        let mut plan = plan(text);
        plan.keep_models(wanted);
        plan.runs().iter().filter(|run| run.sample == 1).map(|run| run.drive_model).collect::<Vec<_>>()
    };
    assert_eq!(models(FILE, &[DriveModel::Bodies]), []);
    assert_eq!(models(FILE, &[DriveModel::Bodies, DriveModel::Analytic]), [Some(DriveModel::Analytic); 4]);
    let any = FILE.replace("drive_models = [\"analytic\"]", "");
    assert_eq!(models(&any, &[DriveModel::Kinematic]), [Some(DriveModel::Kinematic); 4]);
}

#[track_caller]
fn check_refused(change: &str, with: &str, expected: &str) {
    assert!(FILE.contains(change), "{change}");
    let error = Plan::read(Path::new("moves.toml"), &FILE.replace(change, with)).expect_err("a mistake").to_string();
    assert!(error.starts_with("moves.toml: ") && error.contains(expected), "{error}");
}

#[test]
fn a_wrong_file_is_refused_with_what_and_where() {
    check_refused("samples = 2", "samples = 0", "`samples` is 0: expected 1 to 10000");
    check_refused("samples = 2", "sample = 2", "unknown field `sample`");
    check_refused("[\"analytic\"]", "[\"analytics\"]", "unknown drive model `analytics`");
    check_refused("mass = 0.05", "mass = 2.0", "`mass` is 2: expected 0 to 0.9");
    check_refused("steps = 2", "steps = 0", "expected `steps` of at least 1");
    check_refused("steps = 2", "steps = 4000000000", "expected at most 86400");
    check_refused("name = \"left\"", "name = \"forward\"", "two runs are called moves/forward-analytic-1");
    check_refused("y = \"main\"", "y = \"mian\"", "unknown variant `mian`");
    check_refused("[\"move\"]", "[\"mvoe\"]", "plot `ways`: unknown axis `mvoe`");
    check_refused("{ at = 0, velocity", "{ at = -1, velocity", "the event at -1 s");
    check_refused("drive = \"DRIVE {Left 1}{Right 1}\",", "", "expected either `drive` or");
    check_refused("stop_seconds = 0.5", "set = [\"robot\"]", "expected PATH=VALUE");
}

#[test]
fn what_a_run_cannot_do_is_a_named_error() {
    for (change, with, expected) in [
        ("DRIVE {Left 1}{Right 1}", "DRIV {Left 1}", "unknown verb `DRIV`"),
        ("stop_seconds = 0.5", "robot = \"P9\"", "unknown robot `P9`"),
        ("stop_seconds = 0.5", "map = \"moon\"", "unknown map `moon`"),
        ("stop_seconds = 0.5", "set = [\"robot.gian=1\"]", "unknown key `gian`"),
    ] {
        let plan = plan(&FILE.replace(change, with));
        let stops = plan.runs().into_iter().find(|run| run.id.starts_with("moves/stops")).expect("a run");
        let error = run::run(&plan, &stops, None).expect_err("a mistake").to_string();
        assert!(error.contains("moves/stops-analytic-1") && error.contains(expected), "{error}");
    }
}

#[test]
fn a_folder_of_something_else_is_left_alone() {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("thesis.doc"), "mine").expect("a file");
    let error = conduct(folder.path(), FILE, 1).expect_err("a mistake").to_string();
    assert!(error.contains("expected an empty folder") && error.contains("--out"), "{error}");
    assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 1);

    let folder = tempfile::tempdir().expect("a folder");
    conduct(folder.path(), FILE, 2).unwrap_or_else(|error| panic!("{error}"));
    let before = steps_file(folder.path());
    let error = conduct(folder.path(), &FILE.replace("steps = 2", "steps = 3"), 1).expect_err("a mistake").to_string();
    assert!(error.contains("another version of `moves`"), "{error}");
    assert_eq!(steps_file(folder.path()), before);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_a_named_error() {
    let plan = plan(FILE);
    match run::run(&plan, &plan.runs()[0], Some(Path::new("/dev/full"))) {
        Err(RunError::Log(error)) => {
            assert!(error.to_string().starts_with("log /dev/full: No space left on device"), "{error}")
        }
        other => panic!("{other:?}"),
    }
}

/// An experiment driven through a socket, as Iridium did it. Steps at constant speed are those made in this process, for any delays. The
/// lines, replayed at the steps at which they came, reproduce every pose bit by bit.
#[test]
fn through_the_socket_the_poses_are_the_same() {
    let plan = plan(FILE);
    let forward = plan.runs().swap_remove(0);
    let here = run::run(&plan, &forward, None).unwrap_or_else(|error| panic!("{error}"));
    let run::Prepared { world, options, init, lines } = run::prepare(&plan, &forward).unwrap_or_else(|e| panic!("{e}"));
    let folder = tempfile::tempdir().expect("a folder");
    let log = folder.path().join("socket.mcap");
    let server = Server::start("rough", &[], |config| {
        (config.world, config.options, config.real_time_factor) = (world, options, 20.0);
        config.log = Some(log.clone());
    });
    let mut client = server.client();
    client.send(&Command::Init(init).write().to_string());
    // All lines but the last, which stops the robot. It drives for at least three seconds.
    let (mut lines, mut start) = (lines.into_iter().rev().skip(1).rev().peekable(), None);
    loop {
        let line = client.line();
        let Some(Message::Sen(Sen { time: Some(time), reading: Reading::GroundTruth(truth), .. })) =
            Message::read(&line)
        else {
            continue;
        };
        let (began, [x, y, _]) = *start.get_or_insert((time, truth.location));
        while let Some((_, line)) = lines.next_if(|(at, _)| f64::from(time - began) > at - 0.05) {
            client.send(&line);
        }
        if (truth.location[0] - x).hypot(truth.location[1] - y) > 0.15 {
            break;
        }
    }
    drop(client);
    server.stop().unwrap_or_else(|error| panic!("{error}"));
    let log = recorder::read(&log).unwrap_or_else(|error| panic!("{error}"));
    let replay = logbook::replay(&log).unwrap_or_else(|error| panic!("{error}"));
    assert!(replay.is_same() && replay.recorded.is_some() && replay.states > 50, "{replay:?}");
    let came =
        log.entries.iter().find(|entry| matches!(&entry.record, Record::In(line) if line.line.starts_with("DRIVE")));
    let came = came.expect("a DRIVE").time;
    let states: Vec<(f64, nalgebra::Vector3<f64>)> = log
        .entries
        .iter()
        .filter_map(|entry| match &entry.record {
            Record::State(state) if entry.time > came + 0.5 => Some((entry.time, state.pose().translation.vector)),
            _ => None,
        })
        .collect();
    // Fifty states are a second, from any first one.
    let ((start, from), (end, to)) = (states[0], states[50]);
    assert!((end - start - 1.0).abs() < 1e-9, "{start} {end}");
    let second = (to[0] - from[0]).hypot(to[1] - from[1]);
    println!("a second of driving: {second:.6} m through the socket, {:.6} m here", here.steps[1].main);
    assert!((second - here.steps[1].main).abs() < 5e-4 * second, "{second} {:?}", here.steps);
}

#[test]
fn a_changed_log_does_not_replay() {
    let plan = plan(FILE);
    let file = tempfile::NamedTempFile::new().expect("a file");
    run::run(&plan, &plan.runs()[0], Some(file.path())).unwrap_or_else(|error| panic!("{error}"));
    let log = recorder::read(file.path()).unwrap_or_else(|error| panic!("{error}"));
    let same = |log: &recorder::Log| logbook::replay(log).unwrap_or_else(|error| panic!("{error}")).is_same();
    assert!(same(&log));
    let mut changed = log.clone();
    for entry in &mut changed.entries {
        if let Record::In(line) = &mut entry.record {
            line.line = line.line.replace("{Back-Left 1}", "{Back-Left 1.001}");
        }
    }
    assert!(!same(&changed));
    let mut endless = log.clone();
    endless.end.insert("seconds".to_owned(), "1e300".to_owned());
    assert!(logbook::replay(&endless).is_err_and(|error| error.to_string().contains("expected at most 2678400")));
    let mut headless = log.clone();
    headless.run.remove("scene");
    assert!(logbook::replay(&headless).is_err());
}

/// Every file of the thesis can be read, every figure is used, and every claim finds its runs.
#[test]
fn the_files_of_the_thesis_belong_together() {
    let plans: Vec<Plan> = thesis::files()
        .into_iter()
        .map(|(file, text)| Plan::read(Path::new(&file), text).unwrap_or_else(|error| panic!("{error}")))
        .collect();
    let plots: Vec<&str> = plans.iter().flat_map(|plan| &plan.plots).map(|plot| plot.name.as_str()).collect();
    let figures = (1..=13)
        .map(|n| format!("7.{n}"))
        .chain((1..=3).map(|n| format!("B.{n}")))
        .chain((1..=8).map(|n| format!("C.{n}")));
    for figure in figures {
        assert!(plots.contains(&figure.as_str()), "figure {figure}");
    }
    let step = Step { main: 0.1, error: 0.0, yaw: 0.0 };
    let outcome = |run: &experiments::plan::Run| Outcome {
        id: run.id.clone(),
        labels: run.labels.clone(),
        seed: 0,
        steps: vec![step; 10],
        wheels_turned: 20.0,
        digest: String::new(),
        seconds: 20.0,
    };
    let outcomes: Vec<Outcome> = plans.iter().flat_map(Plan::runs).map(|run| outcome(&run)).collect();
    assert!((Quantity::Main.of(&outcomes[0], 3) - 0.3).abs() < 1e-12);
    let Claims { claims } = toml::from_str(thesis::claims()).unwrap_or_else(|error| panic!("{error}"));
    for claim in &claims {
        let found = claim.measure.as_ref().map(|_| claim.found(&outcomes, "bodies"));
        assert_ne!(found, Some(None), "line {}: no run fits", claim.line);
        assert!(!claim.sentence(claim.verdict(&outcomes)).is_empty() || claim.number.is_some(), "line {}", claim.line);
    }
    println!("{} experiments, {} runs, {} plots, {} claims", plans.len(), outcomes.len(), plots.len(), claims.len());
}

/// The runs that are done unasked draw the same figures and find the same claims as all runs do.
#[test]
fn the_needed_runs_of_the_thesis_have_every_figure_and_claim() {
    let Claims { claims } = toml::from_str(thesis::claims()).unwrap_or_else(|error| panic!("{error}"));
    let step = Step { main: 0.1, error: 0.0, yaw: 0.0 };
    let outcome = |run: &experiments::plan::Run| Outcome {
        id: run.id.clone(),
        labels: run.labels.clone(),
        seed: 0,
        steps: vec![step; 10],
        wheels_turned: 20.0,
        digest: String::new(),
        seconds: 20.0,
    };
    let (mut all, mut needed) = (Vec::new(), Vec::new());
    let (folder, mut plots) = (tempfile::tempdir().expect("a folder"), 0);
    for (file, text) in thesis::files() {
        let mut plan = Plan::read(Path::new(&file), text).unwrap_or_else(|error| panic!("{error}"));
        all.extend(plan.runs().iter().map(outcome));
        thesis::keep_needed(&mut plan, &claims);
        let own: Vec<Outcome> = plan.runs().iter().map(outcome).collect();
        for plot in plan.shown_plots() {
            assert!(plot.draw(&own, folder.path()).expect("a plot"), "{file}: {}", plot.name);
            plots += 1;
        }
        needed.extend(own);
    }
    assert!(plots > 24 && needed.len() * 3 < all.len(), "{plots} plots, {} of {} runs", needed.len(), all.len());
    for claim in &claims {
        for model in ["bodies", "analytic", "kinematic"] {
            let found = |outcomes: &[Outcome]| claim.found(outcomes, model).is_some();
            assert_eq!(found(&needed), found(&all), "line {} with {model}", claim.line);
        }
    }
}
