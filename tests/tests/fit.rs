//! Parameters of a robot, fitted to steps that were simulated with them.

use std::ops::ControlFlow;
use std::path::Path;

use experiments::fit::{Estimate, Fit, FitError, FitResult};
use experiments::plan::Plan;
use experiments::{run, table};
use scene::DriveModel;

/// Radius of the measured robot's wheels, m; the file of the robot says 0.05.
const RADIUS: f64 = 0.0497;

const MOVES: &str = r#"
description = "ahead and to the left"
drive_models = ["analytic"]
samples = 6
tolerances = { yaw = 0.002, wheel_phase = 0.5, mass = 0.02 }
[setup]
steps = 3
[[axis]]
name = "move"
values = [
    { name = "forward", drive = "DRIVE {Front-Left 1}{Front-Right 1}{Back-Left 1}{Back-Right 1}" },
    { name = "left", drive = "DRIVE {Front-Left -1}{Front-Right 1}{Back-Left 1}{Back-Right -1}", main = [0, 1], error = [1, 0] },
]
"#;

const RADIUS_AND_FRICTION: &str = r#"
description = "wheel radius and friction"
experiment = "moves.toml"
measured = "measured.csv"
[[parameter]]
name = "wheel radius"
set = ["robot.wheels.radius={}"]
range = [0.047, 0.053]
[[parameter]]
name = "roller friction"
set = ["robot.roller_friction={}"]
range = [0.3, 1.2]
start = 0.9
"#;

const GAIN: &str = r#"
[[parameter]]
name = "servo gain"
set = ["robot.wheels.gain={}"]
range = [2.0, 8.0]
start = 4.0
"#;

/// Simulates the steps of a robot with that radius, in other samples than the fit draws. (For twenty such robots with their seeds, all
/// twenty intervals contained the radius.)
fn measured() -> String {
    let moves = MOVES.replace("samples = 6", "samples = 8\nseed = 1");
    let moves = moves.replace("[setup]", &format!("[setup]\nset = [\"robot.wheels.radius={RADIUS}\"]"));
    let plan = Plan::read(Path::new("moves.toml"), &moves).unwrap_or_else(|error| panic!("{error}"));
    let outcome = |run: &experiments::plan::Run| run::run(&plan, run, None).unwrap_or_else(|error| panic!("{error}"));
    let outcomes: Vec<_> = plan.runs().iter().map(outcome).collect();
    table::steps(&outcomes)
}

/// Creates a folder with a fit, its experiment with a number of samples, and the measured steps.
fn folder(fit: &str, measured: &str, samples: u32) -> tempfile::TempDir {
    let moves = MOVES.replace("samples = 6", &format!("samples = {samples}"));
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in [("fit.toml", fit), ("moves.toml", &moves), ("measured.csv", measured)] {
        std::fs::write(folder.path().join(name), text).expect("a file");
    }
    folder
}

fn found(fit: &str, measured: &str, samples: u32, jobs: usize) -> FitResult {
    let folder = folder(fit, measured, samples);
    let fit = Fit::read(&folder.path().join("fit.toml"), None).unwrap_or_else(|error| panic!("{error}"));
    fit.find(jobs, |_| ControlFlow::Continue(())).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn a_wheel_radius_is_found_and_friction_on_flat_ground_is_not() {
    let measured = measured();
    let found = found(RADIUS_AND_FRICTION, &measured, 6, 2);
    let [radius, friction]: &[Estimate; 2] = found.parameters.as_slice().try_into().expect("two");
    println!("{found:?}");
    assert!((radius.value - RADIUS).abs() < 1e-4 && radius.caution.is_none(), "{radius:?}");
    assert!(radius.interval[0] < RADIUS && RADIUS < radius.interval[1], "{radius:?}");
    assert!(radius.interval[1] - radius.interval[0] < 2e-4, "{radius:?}");
    assert!(found.distance < 0.5 * found.distance_before && found.scatter.is_some_and(|scatter| scatter > 1e-5));
    // A parameter that the data does not determine keeps its value.
    assert_eq!((friction.value, friction.interval), (0.9, [0.3, 1.2]));
    assert!(friction.caution.as_ref().is_some_and(|text| text.starts_with("not identifiable")), "{friction:?}");
}

#[test]
fn a_fit_is_the_same_whatever_the_jobs() {
    let (fit, steps) = RADIUS_AND_FRICTION.rsplit_once("[[parameter]]").map(|(fit, _)| (fit, measured())).expect("two");
    assert_eq!(found(fit, &steps, 1, 1), found(fit, &steps, 1, 3));
}

#[test]
fn what_is_only_known_together_is_said_to_be() {
    let found = found(&format!("{RADIUS_AND_FRICTION}{GAIN}"), &measured(), 1, 2);
    let cautions: Vec<&str> = found.parameters.iter().filter_map(|p| p.caution.as_deref()).collect();
    assert_eq!(cautions.len(), 3, "{cautions:?}");
    assert!(cautions[0].contains("together with `servo gain`"), "{cautions:?}");
    assert!(cautions[1].starts_with("not identifiable"), "{cautions:?}");
}

#[test]
fn a_wrong_file_is_named_with_what_was_expected() {
    let check = |fit: &str, measured: &str, expected: &str| {
        let folder = self::folder(fit, measured, 1);
        let error = Fit::read(&folder.path().join("fit.toml"), None).map(|_| ()).expect_err(expected).to_string();
        assert!(error.contains(expected), "{error}");
    };
    let good = "run,step,main,error,yaw\nforward,1,0.1,0,0\n";
    let fit = RADIUS_AND_FRICTION;
    let folder = folder(fit, good, 1);
    let kinematic =
        Fit::read(&folder.path().join("fit.toml"), Some(DriveModel::Kinematic)).expect_err("a model of no run");
    assert!(kinematic.to_string().ends_with("no runs with the drive model that is asked for"), "{kinematic}");
    check(&fit.replace("measured.csv", "none.csv"), good, "none.csv");
    check(&fit.replace("moves.toml", "none.toml"), good, "none.toml");
    check(&fit.replace("[0.047, 0.053]", "[0.06, 0.05]"), good, "parameter `wheel radius`: `range` is [0.06, 0.05]");
    check(&fit.replace("start = 0.9", "start = 9"), good, "`start` is outside of 0.3 to 1.2");
    check(&fit.replace("radius={}", "radius=1"), good, "a {} for the number");
    check(&fit.replace("roller friction", "wheel radius"), good, "expected a name of its own");
    check(&fit.replace("start", "begin"), good, "unknown field `begin`");
    check(fit, "run,step,main,error,yaw\n", "at least one step");
    check(fit, "run,step,main,error,yaw\nback,1,0,0,0\n", "expected one of forward, left");
    check(fit, "run,step,main,error,yaw\nleft,4,0,0,0\n", "run `left`, step 4: expected a step from 1 to 3");
    check(fit, "run,step,main,error,yaw\nleft,1,a,0,0\n", "measured.csv");
    check(fit, "run,step,main,error,yaw\nleft,1,NaN,0,0\n", "not finite");
}

#[test]
fn a_fit_can_be_broken_off() {
    let folder = folder(RADIUS_AND_FRICTION, &measured(), 1);
    let fit = Fit::read(&folder.path().join("fit.toml"), None).unwrap_or_else(|error| panic!("{error}"));
    let found = fit.find(1, |_| ControlFlow::Break(()));
    assert!(matches!(found, Err(FitError::BrokenOff)), "{found:?}");
}
