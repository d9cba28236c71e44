//! Replay, validation, experiments and fits. Results are JSON, which the Python part reads.

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use ::scene::check::TIME_STEP;
use ::scene::{DriveModel, Options};
use experiments::batch::Batch;
use experiments::fit::Fit;
use experiments::plan::Plan;
use experiments::run::RunError;
use experiments::sweep::Sweep;
use experiments::validation::{self, Subject};
use experiments::{report, run};
use pyo3::prelude::*;
use scene_loader::Override;
use serde_json::Value;

use crate::error;

/// Time between two looks at the signals of the process, for Ctrl-C.
const SIGNAL_INTERVAL: Duration = Duration::from_millis(100);

/// Replays a log and compares. Returns JSON.
#[pyfunction]
#[pyo3(name = "_replay")]
pub(crate) fn replay(py: Python, path: PathBuf) -> PyResult<String> {
    py.detach(|| {
        let failed = |text: &dyn std::fmt::Display| error::log(format_args!("{}: {text}", path.display()));
        let log = recorder::read(&path).map_err(error::log)?;
        let replay = logbook::replay(&log).map_err(|error| failed(&error))?;
        Ok(replay.to_json().to_string())
    })
}

/// Runs the physical checks of a robot on wheels. Returns JSON.
#[pyfunction]
#[pyo3(name = "_validate", signature = (robot, *, drive_model = None, set = Vec::new(), checks = None, seconds = 20.0, time_step = 0.002))]
pub(crate) fn validate(
    py: Python,
    robot: String,
    drive_model: Option<String>,
    set: Vec<String>,
    checks: Option<Vec<u32>>,
    seconds: f64,
    time_step: f64,
) -> PyResult<String> {
    interruptible(py, move |stop| {
        if !(1.0..=60.0).contains(&seconds) || !TIME_STEP.holds(time_step) {
            let text = format!("got {seconds} s and a time step of {time_step} s: expected 1 to 60 s and {TIME_STEP}");
            return Err(error::task(text));
        }
        let overrides = set.iter().map(|text| text.parse()).collect::<Result<Vec<Override>, _>>();
        let overrides = overrides.map_err(error::scene)?;
        let model = drive_model.map(|name| name.parse::<DriveModel>()).transpose().map_err(error::scene)?;
        let options = Options { time_step, ..Options::default() };
        let subject = Subject::load(&robot, model, &overrides, options, seconds).map_err(error::scene)?;
        let count = validation::checks(&subject.robot).len();
        let mut findings = Vec::new();
        for check in checks.unwrap_or_else(|| (1..=count as u32).collect()) {
            if stop.load(Ordering::Relaxed) {
                break;
            }
            findings.extend(validation::check(&subject, check).map_err(error::task)?);
        }
        Ok(Value::from(findings.iter().map(|finding| subject.to_json(finding)).collect::<Vec<_>>()).to_string())
    })
}

/// Runs an experiment file into a folder. Returns the outcomes as JSON.
#[pyfunction]
#[pyo3(name = "_run_experiment", signature = (file, out, *, jobs))]
pub(crate) fn run_experiment(py: Python, file: PathBuf, out: PathBuf, jobs: usize) -> PyResult<String> {
    interruptible(py, move |stop| {
        let text =
            std::fs::read_to_string(&file).map_err(|it| error::task(format_args!("{}: {it}", file.display())))?;
        let plans = [Plan::read(&file, &text).map_err(error::task)?];
        let batch = Batch::open(&out, &plans).map_err(error::task)?;
        let make = |plan: &Plan, run: &experiments::plan::Run, log: &std::path::Path| {
            if stop.load(Ordering::Relaxed) {
                return Err(RunError::Setup { id: run.id.clone(), reason: "interrupted".to_owned() });
            }
            run::run(plan, run, Some(log))
        };
        let outcomes = batch.run(jobs, make, |_, _| {}).map_err(error::task)?;
        report::write_all(&out, &plans[0].name, &plans, &[], &outcomes).map_err(error::task)?;
        serde_json::to_string(&outcomes).map_err(error::task)
    })
}

/// Fits parameters of a robot to measured steps. Returns JSON.
#[pyfunction]
#[pyo3(name = "_fit", signature = (file, *, drive_model = None, jobs))]
pub(crate) fn fit(py: Python, file: PathBuf, drive_model: Option<String>, jobs: usize) -> PyResult<String> {
    interruptible(py, move |stop| {
        let model = drive_model.map(|name| name.parse::<DriveModel>()).transpose().map_err(error::scene)?;
        let fit = Fit::read(&file, model).map_err(error::task)?;
        let go_on = |_| if stop.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
        let found = fit.find(jobs, go_on).map_err(error::task)?;
        serde_json::to_string(&found).map_err(error::task)
    })
}

/// Opens the folder of a sweep. Returns the numbers of runs and of batches, and the batches that are not done.
#[pyfunction]
#[pyo3(name = "_sweep_batches")]
pub(crate) fn sweep_batches(
    py: Python,
    file: PathBuf,
    text: String,
    batch_size: usize,
    out: PathBuf,
) -> PyResult<(usize, usize, Vec<usize>)> {
    py.detach(|| {
        let sweep = Sweep::read(&file, &text, batch_size).map_err(error::task)?;
        let missing = sweep.open(&out).map_err(error::task)?;
        Ok((sweep.runs(), sweep.batches(), missing))
    })
}

/// Does a batch of a sweep. Returns the number of its runs.
#[pyfunction]
#[pyo3(name = "_sweep_batch")]
pub(crate) fn sweep_batch(
    py: Python,
    file: PathBuf,
    text: String,
    batch_size: usize,
    out: PathBuf,
    batch: usize,
) -> PyResult<usize> {
    py.detach(|| {
        let sweep = Sweep::read_checked(&file, &text, batch_size).map_err(error::task)?;
        sweep.run_batch(&out, batch).map_err(error::task)
    })
}

/// Joins the parts of a sweep: table, plots and report. Returns the number of plots.
#[pyfunction]
#[pyo3(name = "_finish_sweep")]
pub(crate) fn finish_sweep(
    py: Python,
    file: PathBuf,
    text: String,
    batch_size: usize,
    out: PathBuf,
) -> PyResult<usize> {
    py.detach(|| {
        let sweep = Sweep::read_checked(&file, &text, batch_size).map_err(error::task)?;
        sweep.finish(&out).map_err(error::task)
    })
}

/// Does long work on another thread, and looks at the signals of the process meanwhile. Ctrl-C sets the flag and returns at once; what
/// the work does until it looks at the flag is lost.
fn interruptible<T: Send + 'static>(
    py: Python,
    work: impl FnOnce(&AtomicBool) -> PyResult<T> + Send + 'static,
) -> PyResult<T> {
    let (done, result) = channel();
    // A receiver is for one thread, and Python's may change.
    let result = Mutex::new(result);
    let stop = Arc::new(AtomicBool::new(false));
    let flag = stop.clone();
    std::thread::spawn(move || {
        // The caller may have been interrupted.
        let _ = done.send(work(&flag));
    });
    loop {
        let next = py.detach(|| result.lock().unwrap_or_else(PoisonError::into_inner).recv_timeout(SIGNAL_INTERVAL));
        match next {
            Ok(result) => return result,
            Err(RecvTimeoutError::Disconnected) => return Err(error::task("a defect: the work panicked")),
            Err(RecvTimeoutError::Timeout) => {
                py.check_signals().inspect_err(|_| stop.store(true, Ordering::Relaxed))?
            }
        }
    }
}
