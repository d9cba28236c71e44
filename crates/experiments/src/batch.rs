//! Batches of runs in a folder. Runs go in parallel, finished ones are kept, and an interrupted batch continues.
//!
//! ```text
//! DIR/experiment.json          the text of every experiment file in it
//! DIR/runs/<plan>/<run>.json   an Outcome, written when its run is done
//! DIR/logs/<plan>/<run>.mcap
//! ```

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use crate::plan::{Plan, Run};

use crate::run::{Outcome, RunError};

/// A folder of runs.
pub struct Batch<'a> {
    folder: &'a Path,
    plans: &'a [Plan],
}

/// Errors of a batch.
#[derive(Debug, thiserror::Error)]
pub enum BatchError {
    /// The folder has other contents.
    #[error("{folder}: {reason}; choose another folder with --out")]
    Folder {
        /// The folder.
        folder: String,
        /// Description of its contents.
        reason: String,
    },
    /// A file cannot be read or written.
    #[error("{file}: {reason}")]
    File {
        /// The file.
        file: String,
        /// Message of the operating system.
        reason: String,
    },
    /// A run failed.
    #[error(transparent)]
    Run(#[from] RunError),
    /// A plot cannot be written.
    #[error(transparent)]
    Plot(#[from] charts::ChartError),
}

pub(crate) fn refused(file: &Path, reason: impl std::fmt::Display) -> BatchError {
    BatchError::File { file: file.display().to_string(), reason: reason.to_string() }
}

impl<'a> Batch<'a> {
    /// Opens or creates the folder. It stores the text of every plan.
    ///
    /// # Errors
    /// When the folder has other contents, or runs of another version of a plan; the folder then stays unchanged.
    pub fn open(folder: &'a Path, plans: &'a [Plan]) -> Result<Self, BatchError> {
        let foreign = |reason: String| BatchError::Folder { folder: folder.display().to_string(), reason };
        let file = folder.join("experiment.json");
        let known = match std::fs::read_to_string(&file) {
            Ok(text) => {
                serde_json::from_str(&text).map_err(|_| foreign("experiment.json is not of usarsim".to_owned()))?
            }
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
                let mut entries = std::fs::read_dir(folder).into_iter().flatten();
                if entries.next().is_some() {
                    return Err(foreign("expected an empty folder, or one of an experiment".to_owned()));
                }
                BTreeMap::<String, String>::new()
            }
            Err(error) => return Err(refused(&file, error)),
        };
        // A plan without a finished run may change, as there is nothing to keep.
        let has_runs = |plan: &Plan| {
            std::fs::read_dir(folder.join("runs").join(&plan.name)).is_ok_and(|mut runs| runs.next().is_some())
        };
        let differs = |plan: &&Plan| known.get(&plan.name).is_some_and(|known| *known != plan.text) && has_runs(plan);
        if let Some(plan) = plans.iter().find(differs) {
            return Err(foreign(format!("it has runs of another version of `{}`", plan.name)));
        }
        let mut all = known.clone();
        all.extend(plans.iter().map(|plan| (plan.name.clone(), plan.text.clone())));
        if all != known {
            write(&file, serde_json::to_string_pretty(&all).unwrap_or_default().as_bytes())?;
        }
        Ok(Self { folder, plans })
    }

    /// Executes every run without a stored outcome, `jobs` at a time. `make` executes one run, given the path of its log;
    /// [`crate::run::run`] does so in this process. Returns all outcomes in the order of the plans, regardless of the order of
    /// execution. Calls `done` with each outcome, and with true if it was stored before.
    ///
    /// # Errors
    /// Returns the first error that occurs. Runs under way are finished first, and everything finished is kept.
    pub fn run(
        &self,
        jobs: usize,
        make: impl Fn(&Plan, &Run, &Path) -> Result<Outcome, RunError> + Sync,
        done: impl Fn(&Outcome, bool) + Sync,
    ) -> Result<Vec<Outcome>, BatchError> {
        let runs: Vec<(&Plan, Run)> =
            self.plans.iter().flat_map(|plan| plan.runs().into_iter().map(move |run| (plan, run))).collect();
        let outcomes: Vec<Mutex<Option<Outcome>>> = runs.iter().map(|_| Mutex::new(None)).collect();
        let (next, stop, failure) = (AtomicUsize::new(0), AtomicBool::new(false), Mutex::new(None));
        let work = || {
            while !stop.load(Ordering::Relaxed) {
                let index = next.fetch_add(1, Ordering::Relaxed);
                let Some((plan, run)) = runs.get(index) else { return };
                match self.outcome(plan, run, &make) {
                    Ok((outcome, old)) => {
                        done(&outcome, old);
                        set(&outcomes[index], outcome);
                    }
                    Err(error) => {
                        stop.store(true, Ordering::Relaxed);
                        set(&failure, error);
                    }
                }
            }
        };
        std::thread::scope(|scope| {
            for _ in 0..jobs.max(1) {
                scope.spawn(work);
            }
        });
        match take(failure) {
            Some(error) => Err(error),
            None => Ok(outcomes.into_iter().filter_map(take).collect()),
        }
    }

    /// Returns the outcome of a run, and true if it was stored before.
    fn outcome(
        &self,
        plan: &Plan,
        run: &Run,
        make: impl Fn(&Plan, &Run, &Path) -> Result<Outcome, RunError>,
    ) -> Result<(Outcome, bool), BatchError> {
        let file = self.folder.join("runs").join(format!("{}.json", run.id));
        if let Some(outcome) = std::fs::read(&file).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok()) {
            return Ok((outcome, true));
        }
        let log = self.folder.join("logs").join(format!("{}.mcap", run.id));
        let part = unfinished(&log);
        make_folder_of(&log)?;
        // An interrupted run leaves a partial log, and a server would write beside it.
        let _ = std::fs::remove_file(&part);
        let outcome = make(plan, run, &part)?;
        std::fs::rename(&part, &log).map_err(|error| refused(&log, error))?;
        write(&file, serde_json::to_string(&outcome).unwrap_or_default().as_bytes())?;
        Ok((outcome, false))
    }
}

/// Writes a file whole or not at all, and creates its folder if needed.
pub(crate) fn write(file: &Path, bytes: &[u8]) -> Result<(), BatchError> {
    make_folder_of(file)?;
    let part = unfinished(file);
    std::fs::write(&part, bytes).and_then(|()| std::fs::rename(&part, file)).map_err(|error| refused(file, error))
}

fn unfinished(file: &Path) -> PathBuf {
    let mut name = file.file_name().unwrap_or_default().to_owned();
    name.push(".part");
    file.with_file_name(name)
}

fn make_folder_of(file: &Path) -> Result<(), BatchError> {
    let folder = file.parent().unwrap_or(Path::new("."));
    std::fs::create_dir_all(folder).map_err(|error| refused(folder, error))
}

fn set<T>(place: &Mutex<Option<T>>, value: T) {
    *place.lock().unwrap_or_else(std::sync::PoisonError::into_inner) = Some(value);
}

fn take<T>(place: Mutex<Option<T>>) -> Option<T> {
    place.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner)
}
