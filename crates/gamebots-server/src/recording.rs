//! Where a served world is recorded: in a log, one from the start or as many as somebody wishes, and live for Foxglove.

use std::path::{Path, PathBuf};
use std::time::Instant;

use recorder::{LogWriter, Record, RecordError, Recorder, StateTimer};
use sim_core::{Options, World};

use crate::foxglove_server::FoxgloveServer;

/// What logs are written with, and the two places where records go.
pub(crate) struct Recording {
    options: Options,
    real_time_factor: f64,
    ros2: bool,
    /// Where a log goes that nobody has named.
    unnamed: PathBuf,
    open: Option<Open>,
    foxglove: Option<FoxgloveServer>,
}

/// The log that is being written.
struct Open {
    path: PathBuf,
    recorder: Recorder,
    states: StateTimer,
}

impl Recording {
    /// Nothing is written yet.
    pub(crate) fn new(
        options: Options,
        real_time_factor: f64,
        ros2: bool,
        unnamed: PathBuf,
        foxglove: Option<FoxgloveServer>,
    ) -> Self {
        Self { options, real_time_factor, ros2, unnamed, open: None, foxglove }
    }

    /// The file that is being written.
    pub(crate) fn path(&self) -> Option<&Path> {
        self.open.as_ref().map(|open| open.path.as_path())
    }

    /// Begins a log; one that is being written ends.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub(crate) fn start(&mut self, path: &Path, world: &World) -> Result<(), RecordError> {
        self.stop(world);
        let mut description = vec![("real_time_factor".to_owned(), self.real_time_factor.to_string())];
        if !world.is_untouched() {
            description.push(("began".to_owned(), world.time().to_string()));
        }
        let mut log = LogWriter::create(path, world.def(), self.options, &description)?;
        if self.ros2 {
            log = log.with_ros2(world.def())?;
        }
        let (recorder, states) = (Recorder::new(log)?, StateTimer::default());
        self.open = Some(Open { path: path.to_owned(), recorder, states });
        Ok(())
    }

    /// Begins a log under a name that is free.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub(crate) fn start_unnamed(&mut self, world: &World) -> Result<(), RecordError> {
        self.start(&free(&self.unnamed), world)
    }

    /// Ends the log properly and gives back its file; waits until it is written.
    pub(crate) fn stop(&mut self, world: &World) -> Option<PathBuf> {
        let Open { path, recorder, .. } = self.open.take()?;
        recorder.finish(world.time(), Some(world.digest()));
        Some(path)
    }

    /// Ends the log of a world that has panicked, with the step in which it did and without a digest.
    pub(crate) fn stop_broken(&mut self, world: &World) {
        if let Some(Open { recorder, .. }) = self.open.take() {
            recorder.finish(world.time() + world.time_step(), None);
        }
    }

    /// Ends the log of a world that is over and begins the next beside it, if one was written.
    ///
    /// # Errors
    /// When the next file cannot be written.
    pub(crate) fn start_over(&mut self, old: &World, new: &World) -> Result<(), RecordError> {
        if let Some(foxglove) = &mut self.foxglove {
            foxglove.start_over();
        }
        self.stop(old).map_or(Ok(()), |path| self.start(&free(&path), new))
    }

    /// Takes what `record` gives, if anybody wants it.
    pub(crate) fn record(&mut self, world: &World, record: impl FnOnce() -> Record) {
        let Self { open, foxglove, .. } = self;
        if open.is_none() && foxglove.is_none() {
            return;
        }
        let record = record();
        if let Some(foxglove) = foxglove {
            foxglove.record(world.time(), record.clone());
        }
        if let Some(open) = open {
            open.recorder.record(world.time(), record);
        }
    }

    /// Takes the states of the world when they are due; to be called after every step.
    pub(crate) fn record_states(&mut self, world: &World) {
        if let Some(Open { recorder, states, .. }) = &mut self.open {
            states.due(world).into_iter().for_each(|state| recorder.record(world.time(), state));
        }
        if let Some(foxglove) = &mut self.foxglove {
            foxglove.record_states(world);
        }
    }

    /// Tells Foxglove what is new; to be called often.
    pub(crate) fn tell(&mut self, now: Instant, world: &World) {
        if let Some(foxglove) = &mut self.foxglove {
            foxglove.tell(now, world.time());
        }
    }

    /// Hands what was recorded to the disk; to be called when there is nothing else to do.
    pub(crate) fn hand_over(&mut self) {
        if let Some(open) = &mut self.open {
            open.recorder.hand_over();
        }
    }
}

/// The path, or the same with the first number that makes it a new file: `run.mcap`, `run-2.mcap`, `run-3.mcap` ...
fn free(path: &Path) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let numbered = |number: u32| path.with_file_name(format!("{stem}-{number}.mcap"));
    std::iter::once(path.to_owned()).chain((2..).map(numbered)).find(|path| !path.exists()).unwrap_or_default()
}
