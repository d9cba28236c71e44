//! Sweeps: an experiment of many runs, in batches that any machine can do.
//!
//! ```text
//! DIR/sweep.json              name and text of the experiment, runs of a batch
//! DIR/parts/<batch>.parquet   the outcomes of a batch, written under a temporary name and renamed
//! DIR/runs.parquet            all outcomes, with steps.csv, runs.csv, summary.csv, plots and report.html
//! ```
//!
//! A batch depends on nothing but the experiment and its number. So its part has the same bytes wherever and however often it ran, and a
//! lost machine costs the batches that it had under way.

mod table;

use std::io::Write;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::batch::{BatchError, refused, write};
use crate::plan::{Plan, PlanError};
use crate::report;
use crate::run::{self, Outcome};

/// Maximum number of runs of a batch.
const MAX_BATCH: usize = 100_000;
/// Beginning of the names of parts that are not whole.
const UNFINISHED: &str = ".unfinished-";

/// A sweep.
pub struct Sweep {
    plan: Plan,
    batch_size: usize,
}

/// Errors of a sweep.
#[derive(Debug, thiserror::Error)]
pub enum SweepError {
    /// The experiment cannot be run.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// A run failed, or a file cannot be read or written.
    #[error(transparent)]
    Batch(#[from] BatchError),
    /// The number of runs of a batch is out of bounds.
    #[error("runs of a batch: got {0}, expected 1 to {MAX_BATCH}")]
    BatchSize(usize),
    /// The sweep has no such batch.
    #[error("batch {got}: expected less than {expected}")]
    NoBatch {
        /// Number of the batch.
        got: usize,
        /// Number of batches.
        expected: usize,
    },
    /// Not all batches are done.
    #[error(
        "{folder}: {missing} of {batches} batches are missing, the first is {first}; run the sweep again to do them"
    )]
    Missing {
        /// The folder.
        folder: String,
        /// Number of missing batches.
        missing: usize,
        /// Number of batches.
        batches: usize,
        /// The first missing one.
        first: usize,
    },
}

/// Contents of `sweep.json`.
#[derive(PartialEq, Serialize, Deserialize)]
struct Marker {
    name: String,
    batch_size: usize,
    text: String,
}

impl Sweep {
    /// Creates a sweep of an experiment from its text, and checks every run of it.
    ///
    /// # Errors
    /// When the experiment has a mistake, or the number of runs of a batch is out of bounds.
    pub fn read(file: &Path, text: &str, batch_size: usize) -> Result<Self, SweepError> {
        Self::of(Plan::read(file, text)?, batch_size)
    }

    /// Creates a sweep of an experiment that was checked before, to do a batch of it.
    ///
    /// # Errors
    /// As [`Sweep::read`].
    pub fn read_checked(file: &Path, text: &str, batch_size: usize) -> Result<Self, SweepError> {
        Self::of(Plan::read_checked(file, text)?, batch_size)
    }

    fn of(plan: Plan, batch_size: usize) -> Result<Self, SweepError> {
        if !(1..=MAX_BATCH).contains(&batch_size) {
            return Err(SweepError::BatchSize(batch_size));
        }
        Ok(Self { plan, batch_size })
    }

    /// Returns the number of runs.
    pub fn runs(&self) -> usize {
        self.plan.count()
    }

    /// Returns the number of batches.
    pub fn batches(&self) -> usize {
        self.runs().div_ceil(self.batch_size)
    }

    /// Returns the number of runs of a batch.
    pub fn runs_of(&self, batch: usize) -> usize {
        self.runs().saturating_sub(batch.saturating_mul(self.batch_size)).min(self.batch_size)
    }

    /// Opens or creates the folder of the sweep. Returns the batches that are not done.
    ///
    /// # Errors
    /// When the folder has other contents; it then stays unchanged.
    pub fn open(&self, folder: &Path) -> Result<Vec<usize>, SweepError> {
        let foreign =
            |reason: &str| BatchError::Folder { folder: folder.display().to_string(), reason: reason.to_owned() };
        let file = folder.join("sweep.json");
        let Plan { name, text, .. } = &self.plan;
        let own = Marker { name: name.clone(), batch_size: self.batch_size, text: text.clone() };
        match std::fs::read(&file) {
            Ok(known) => {
                let known: Option<Marker> = serde_json::from_slice(&known).ok();
                if known != Some(own) {
                    return Err(foreign("it has another sweep, or batches of another size").into());
                }
            }
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
                if std::fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some()) {
                    return Err(foreign("expected an empty folder, or one of a sweep").into());
                }
                write(&file, serde_json::to_string_pretty(&own).unwrap_or_default().as_bytes())?;
            }
            Err(error) => return Err(refused(&file, error).into()),
        }
        let parts = folder.join("parts");
        std::fs::create_dir_all(&parts).map_err(|error| refused(&parts, error))?;
        Ok(self.missing(folder))
    }

    fn missing(&self, folder: &Path) -> Vec<usize> {
        (0..self.batches()).filter(|&batch| !part(folder, batch).is_file()).collect()
    }

    /// Executes the runs of a batch in this thread, and writes its part whole or not at all. Returns the number of runs. Several machines
    /// may do one batch; their parts have the same bytes.
    ///
    /// # Errors
    /// When there is no such batch, a run fails, or the part cannot be written.
    pub fn run_batch(&self, folder: &Path, batch: usize) -> Result<usize, SweepError> {
        if batch >= self.batches() {
            return Err(SweepError::NoBatch { got: batch, expected: self.batches() });
        }
        let first = batch * self.batch_size;
        let runs = self.plan.runs_in(first..first + self.batch_size);
        let outcomes = runs.map(|run| run::run(&self.plan, &run, None).map_err(BatchError::from));
        let outcomes = outcomes.collect::<Result<Vec<Outcome>, _>>()?;
        let bytes = table::to_parquet(&outcomes).map_err(|error| refused(&part(folder, batch), error))?;
        write_part(&part(folder, batch), &bytes)?;
        Ok(outcomes.len())
    }

    /// Joins the parts of all batches: table, plots and report. Returns the number of plots.
    ///
    /// # Errors
    /// When a part is missing or damaged, or a file cannot be written.
    pub fn finish(&self, folder: &Path) -> Result<usize, SweepError> {
        let missing = self.missing(folder);
        if let Some(&first) = missing.first() {
            let (folder, batches) = (folder.display().to_string(), self.batches());
            return Err(SweepError::Missing { folder, missing: missing.len(), batches, first });
        }
        let mut outcomes = Vec::with_capacity(self.runs());
        for batch in 0..self.batches() {
            let file = part(folder, batch);
            let bytes = std::fs::read(&file).map_err(|error| refused(&file, error))?;
            let read = table::from_parquet(bytes).map_err(|error| refused(&file, error))?;
            if read.len() != self.runs_of(batch) {
                let text = format!(
                    "got {} runs, expected {}; remove it and run the sweep again",
                    read.len(),
                    self.runs_of(batch)
                );
                return Err(refused(&file, text).into());
            }
            outcomes.extend(read);
        }
        let file = folder.join("runs.parquet");
        let bytes = table::to_parquet(&outcomes).map_err(|error| refused(&file, error))?;
        write(&file, &bytes)?;
        let plans = std::slice::from_ref(&self.plan);
        let plots = report::write_all(folder, &self.plan.name, plans, &[], &outcomes)?;
        forget_unfinished(&folder.join("parts"));
        Ok(plots)
    }
}

/// Returns the file of a batch.
fn part(folder: &Path, batch: usize) -> PathBuf {
    folder.join("parts").join(format!("{batch:06}.parquet"))
}

/// Writes a file under a temporary name that no other process has, and renames it.
fn write_part(file: &Path, bytes: &[u8]) -> Result<(), BatchError> {
    let failed = |error: std::io::Error| refused(file, error);
    let folder = file.parent().unwrap_or(Path::new("."));
    let mut unfinished = tempfile::Builder::new().prefix(UNFINISHED).tempfile_in(folder).map_err(failed)?;
    unfinished.write_all(bytes).and_then(|()| unfinished.as_file().sync_all()).map_err(failed)?;
    // Temporary files are private, but others may finish the sweep.
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let readable = std::fs::Permissions::from_mode(0o644);
        unfinished.as_file().set_permissions(readable).map_err(failed)?;
    }
    unfinished.persist(file).map_err(|error| failed(error.error))?;
    Ok(())
}

/// Removes parts that lost machines left.
fn forget_unfinished(parts: &Path) {
    let entries = std::fs::read_dir(parts).into_iter().flatten().flatten();
    for entry in entries.filter(|entry| entry.file_name().to_string_lossy().starts_with(UNFINISHED)) {
        // It is only in the way.
        let _ = std::fs::remove_file(entry.path());
    }
}
