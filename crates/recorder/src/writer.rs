//! Writing: a file, and for a live world a queue and a thread before it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use sim_core::Options;
use sim_core::scene::WorldDef;

use crate::file::LogFile;
use crate::native::Native;
use crate::ros2::{self, Ros2};
use crate::{END, End, RUN, Record};

/// Records that are handed over at once.
const BATCH: usize = 256;
/// Batches that may wait for the disk; more are dropped and counted.
const QUEUE: usize = 256;
/// Longest time that a record stays out of the file.
const FLUSH_INTERVAL: Duration = Duration::from_millis(500);

/// A log that cannot be written.
#[derive(Debug, thiserror::Error)]
#[error("log {file}: {reason}")]
pub struct RecordError {
    file: String,
    reason: String,
}

/// Writes a log record by record, waiting for the disk.
pub struct LogWriter {
    path: PathBuf,
    file: LogFile,
    native: Native,
    ros2: Option<(LogFile, Ros2)>,
}

impl LogWriter {
    /// Creates the file, replacing an old one, and writes the scene, the options and what else describes the run.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn create(
        path: &Path,
        world: &WorldDef,
        options: Options,
        description: &[(String, String)],
    ) -> Result<Self, RecordError> {
        let entry = |key: &str, value: &dyn std::fmt::Display| (key.to_owned(), value.to_string());
        let mut metadata: BTreeMap<String, String> = description.iter().cloned().collect();
        metadata.extend([
            entry("map", &world.map.name),
            entry("seed", &options.seed),
            entry("time_step", &options.time_step),
            entry("speed_unit", &options.speed_unit),
            entry("keep_robots", &options.keep_robots),
            entry("scene", &serde_json::to_string(world).unwrap_or_default()),
            entry("frame", &"x forward, y right, z down; m, kg, s, rad"),
        ]);
        metadata.extend(options.panic_at.map(|steps| entry("panic_at", &steps)));
        let start = || {
            let mut file = LogFile::create(path, "")?;
            file.metadata(RUN, metadata)?;
            let native = Native::new(world, &mut file)?;
            file.flush()?;
            Ok(Self { path: path.to_owned(), file, native, ros2: None })
        };
        start().map_err(|reason: mcap::McapError| refused(path, reason))
    }

    /// Writes the messages of [`crate::ros2`] as well, to a file of their own beside the log: `run.ros2.mcap` for `run.mcap`.
    ///
    /// # Errors
    /// When that file cannot be written.
    pub fn with_ros2(mut self, world: &WorldDef) -> Result<Self, RecordError> {
        let path = self.path.with_extension("ros2.mcap");
        let file = ros2::create(&path).map_err(|reason| refused(&path, reason))?;
        self.ros2 = Some((file, Ros2::new(world)));
        Ok(self)
    }

    /// Writes a record of a simulated time in seconds.
    ///
    /// # Errors
    /// When the disk takes no more.
    pub fn write(&mut self, time: f64, record: &Record) -> Result<(), RecordError> {
        let mut write = || {
            if let Some((file, ros2)) = &mut self.ros2 {
                ros2.write(time, record, file)?;
            }
            self.native.write(time, record, &mut self.file)
        };
        write().map_err(|reason| refused(&self.path, reason))
    }

    /// Hands everything written so far to the operating system.
    ///
    /// # Errors
    /// When the disk takes no more.
    pub fn flush(&mut self) -> Result<(), RecordError> {
        let files = std::iter::once(&mut self.file).chain(self.ros2.iter_mut().map(|(file, _)| file));
        for file in files {
            file.flush().map_err(|reason| refused(&self.path, reason))?;
        }
        Ok(())
    }

    /// Ends the log with the simulated time and the digest of the world, by which a replay is checked.
    ///
    /// # Errors
    /// When the disk takes no more.
    pub fn finish(self, end: End) -> Result<(), RecordError> {
        let entry = |key: &str, value: String| (key.to_owned(), value);
        let End { time, digest, dropped } = end;
        let mut metadata = BTreeMap::from([entry("seconds", time.to_string()), entry("dropped", dropped.to_string())]);
        metadata.extend(digest.map(|digest| entry("digest", format!("{digest:016x}"))));
        let Self { path, mut file, ros2, .. } = self;
        let finish = || {
            file.metadata(END, metadata)?;
            file.finish()?;
            ros2.map_or(Ok(()), |(file, _)| file.finish())
        };
        finish().map_err(|reason| refused(&path, reason))
    }
}

/// With what the operating system says, where that is the cause.
pub(crate) fn refused(file: impl AsRef<Path>, reason: impl Into<Box<dyn std::error::Error>>) -> RecordError {
    let reason = reason.into();
    let cause = reason.source().map(ToString::to_string);
    RecordError { file: file.as_ref().display().to_string(), reason: cause.unwrap_or_else(|| reason.to_string()) }
}

/// What takes records one by one.
pub trait Sink: Send + 'static {
    /// Takes a record of a simulated time in seconds.
    ///
    /// # Errors
    /// When it takes no more.
    fn write(&mut self, time: f64, record: &Record) -> Result<(), RecordError>;

    /// Hands on everything that it has taken so far.
    ///
    /// # Errors
    /// When it takes no more.
    fn flush(&mut self) -> Result<(), RecordError>;
}

impl Sink for LogWriter {
    fn write(&mut self, time: f64, record: &Record) -> Result<(), RecordError> {
        Self::write(self, time, record)
    }

    fn flush(&mut self) -> Result<(), RecordError> {
        Self::flush(self)
    }
}

/// Writes a log from a thread of its own until it is finished or dropped.
///
/// Records are handed over in batches: waking the thread for each would cost more than writing it.
pub struct Recorder<S: Sink = LogWriter> {
    queue: Option<SyncSender<Vec<Timed>>>,
    batch: Vec<Timed>,
    thread: Option<JoinHandle<Option<S>>>,
    dropped: u64,
}

/// A record and its simulated time, s.
type Timed = (f64, Record);

impl<S: Sink> Recorder<S> {
    /// Goes on with a log that has been begun.
    ///
    /// # Errors
    /// When there is no thread for it.
    pub fn new(log: S) -> Result<Self, RecordError> {
        let (queue, batches) = sync_channel(QUEUE);
        let run =
            move || write_all(log, &batches).inspect_err(|error| tracing::error!(%error, "the log ends here")).ok();
        let thread = std::thread::Builder::new().name("recorder".to_owned()).spawn(run);
        let thread = thread.map_err(|reason| refused("of this run", reason))?;
        Ok(Self { queue: Some(queue), batch: Vec::with_capacity(BATCH), thread: Some(thread), dropped: 0 })
    }

    /// Takes a record of a simulated time in seconds; never waits.
    pub fn record(&mut self, time: f64, record: Record) {
        self.batch.push((time, record));
        if self.batch.len() >= BATCH {
            self.hand_over();
        }
    }

    /// Hands what was recorded to the thread; to be called when there is nothing else to do.
    pub fn hand_over(&mut self) {
        let Some(queue) = self.queue.as_ref().filter(|_| !self.batch.is_empty()) else { return self.batch.clear() };
        match queue.try_send(std::mem::replace(&mut self.batch, Vec::with_capacity(BATCH))) {
            Ok(()) => {}
            Err(TrySendError::Full(batch)) => {
                if self.dropped == 0 {
                    tracing::warn!("the disk is too slow: records are missing in the log");
                }
                self.dropped += batch.len() as u64;
            }
            // The thread has said why it ended.
            Err(TrySendError::Disconnected(_)) => self.queue = None,
        }
    }

    /// Waits until everything is written and takes the log back, unless it could not be written.
    fn stop(&mut self) -> Option<S> {
        if let Some(queue) = self.queue.take() {
            // A thread that has ended has said why.
            let _ = queue.send(std::mem::take(&mut self.batch));
        }
        // A panic of the thread has been printed where it happened.
        self.thread.take()?.join().ok()?
    }
}

impl Recorder {
    /// Ends the log properly and waits until it is written.
    pub fn finish(mut self, time: f64, digest: Option<u64>) {
        if let Some(log) = self.stop() {
            let end = End { time, digest, dropped: self.dropped };
            if let Err(error) = log.finish(end) {
                tracing::error!(%error, "the log ends here");
            }
        }
    }
}

impl<S: Sink> Drop for Recorder<S> {
    fn drop(&mut self) {
        self.stop();
    }
}

fn write_all<S: Sink>(mut log: S, batches: &Receiver<Vec<Timed>>) -> Result<S, RecordError> {
    let mut flush_at = Instant::now() + FLUSH_INTERVAL;
    loop {
        match batches.recv_timeout(flush_at.saturating_duration_since(Instant::now())) {
            Ok(batch) => batch.iter().try_for_each(|(time, record)| log.write(*time, record))?,
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => {
                log.flush()?;
                return Ok(log);
            }
        }
        if Instant::now() >= flush_at {
            log.flush()?;
            flush_at = Instant::now() + FLUSH_INTERVAL;
        }
    }
}
