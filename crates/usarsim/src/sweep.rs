//! `usarsim sweep`: an experiment of many runs, in batches that may be spread over machines.

use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::PoisonError;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use experiments::sweep::{Sweep, SweepError};
use serde_json::json;

use crate::progress::Progress;
use crate::{Failure, exit, print};

/// Options of `sweep`.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  usarsim sweep plan.toml\n  usarsim sweep plan.toml --out results --batch 50 --jobs 2\n  \
    usarsim sweep plan.toml --out results --only 7    # a batch, on any machine that has the folder\n\n\
    A plan is an experiment file: docs/experiments.md. The folder gets runs.parquet, tables, plots and report.html. Call it again to \
    resume an interrupted sweep. docs/howto-sweeps.md spreads a sweep over a cluster with Dask."
)]
pub(crate) struct Arguments {
    /// The experiment.
    #[arg(value_name = "FILE.toml")]
    file: PathBuf,
    /// Folder of the results; by default the experiment's name.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Runs of a batch.
    #[arg(long, default_value_t = 100, value_name = "RUNS")]
    batch: usize,
    /// Batches at a time; by default as many as there are cores.
    #[arg(long)]
    jobs: Option<usize>,
    /// Do only this batch, counted from 0, and leave the tables and the report to the call without --only.
    #[arg(long, value_name = "BATCH")]
    only: Option<usize>,
    /// Print a summary as JSON.
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(arguments: &Arguments, quiet: bool) -> Result<(), Failure> {
    let Arguments { file, out, batch, jobs, only, json } = arguments;
    let text = scene_loader::text(file).map_err(|error| Failure::new(exit::BAD_CONFIGURATION, error))?;
    let sweep = Sweep::read(file, &text, *batch).map_err(failure)?;
    let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let out = out.as_deref().unwrap_or(Path::new(&name));
    let missing = sweep.open(out).map_err(failure)?;
    let start = Instant::now();
    if let Some(only) = only {
        let runs = sweep.run_batch(out, *only).map_err(failure)?;
        let seconds = start.elapsed().as_secs_f64();
        if *json {
            print(json!({"batch": only, "runs": runs, "seconds": seconds, "folder": out.display().to_string()}));
        } else {
            print(format_args!("batch {only}: {} in {seconds:.1} s", names::count(runs, "run")));
        }
        return Ok(());
    }
    let kept = sweep.batches() - missing.len();
    let left: usize = missing.iter().map(|&batch| sweep.runs_of(batch)).sum();
    let progress = Progress::of_runs(left, quiet);
    let jobs = jobs.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from));
    run_batches(&sweep, out, &missing, jobs, &progress).map_err(failure)?;
    progress.say("tables, plots, report");
    let plots = sweep.finish(out).map_err(failure)?;
    progress.finish();
    let (seconds, report) = (start.elapsed().as_secs_f64(), out.join("report.html"));
    if *json {
        print(json!({
            "runs": sweep.runs(), "batches": sweep.batches(), "kept": kept, "seconds": seconds, "plots": plots,
            "folder": out.display().to_string(), "report": report.display().to_string(),
        }));
    } else {
        let batches = match sweep.batches() {
            1 => "1 batch".to_owned(),
            more => format!("{more} batches"),
        };
        print(format_args!(
            "{} in {} ({kept} kept from before), {} in {seconds:.0} s: open {}",
            names::count(sweep.runs(), "run"),
            batches,
            names::count(plots, "plot"),
            report.display()
        ));
    }
    Ok(())
}

/// Does batches on several threads. After a failure, batches under way are finished.
fn run_batches(
    sweep: &Sweep,
    out: &Path,
    batches: &[usize],
    jobs: usize,
    progress: &Progress,
) -> Result<(), SweepError> {
    let (next, failed) = (AtomicUsize::new(0), Mutex::new(None));
    let work = || {
        while failed.lock().unwrap_or_else(PoisonError::into_inner).is_none() {
            let Some(&batch) = batches.get(next.fetch_add(1, Ordering::Relaxed)) else { return };
            match sweep.run_batch(out, batch) {
                Ok(runs) => {
                    progress.say(format!("batch {batch}"));
                    progress.add(runs);
                }
                Err(error) => *failed.lock().unwrap_or_else(PoisonError::into_inner) = Some(error),
            }
        }
    };
    std::thread::scope(|scope| (0..jobs.max(1)).for_each(|_| drop(scope.spawn(work))));
    failed.into_inner().unwrap_or_else(PoisonError::into_inner).map_or(Ok(()), Err)
}

fn failure(error: SweepError) -> Failure {
    let code = match &error {
        SweepError::Plan(_) => exit::BAD_CONFIGURATION,
        SweepError::Batch(error) => return crate::experiment::failure(error),
        SweepError::BatchSize(_) | SweepError::NoBatch { .. } => exit::USAGE,
        SweepError::Missing { .. } => exit::FAILURE,
    };
    Failure::new(code, error)
}
