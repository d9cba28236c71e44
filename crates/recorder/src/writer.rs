//! Writers of logs: a file, and for a live world a queue and a thread before it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use mcap::McapResult;
use scene::{Classes, Options, RobotDef, Snapshot, WorldDef};

use crate::classes::{CLASS, DEFINITION, Used};
use crate::error::{RecordError, refused};
use crate::file::{LogFile, Storage, storage};
use crate::native::Native;
use crate::ros2::{self, Ros2};
use crate::states::States;
use crate::{END, End, FORMAT, RUN, Record};

/// Number of records that is worth waking the thread.
const BATCH: usize = 256;
/// Most bytes of records that wait for the disk; further records are dropped and counted. That is two minutes of ten youBots in
/// real time.
const MAX_QUEUED: usize = 64 << 20;
/// Longest time that a record stays out of the file, on a clock that nobody can set.
const FLUSH_INTERVAL: Duration = Duration::from_millis(500);

/// Writes a log record by record, and waits for the disk.
pub struct LogWriter {
    file: LogFile,
    native: Native,
    states: States,
    classes: Classes,
    used: Used,
    ros2: Option<(LogFile, Ros2)>,
}

impl LogWriter {
    /// Creates the file, replacing an old one. Writes the scene, the options and the description of the run.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn create(
        path: &Path,
        world: &WorldDef,
        options: Options,
        description: &[(String, String)],
    ) -> Result<Self, RecordError> {
        let storage = storage(path).map_err(|reason| refused(path, reason))?;
        Self::create_on(storage, path, world, options, description)
    }

    /// Creates the log on another storage; `path` is its name.
    ///
    /// # Errors
    /// When the storage cannot be written.
    pub fn create_on(
        storage: Box<dyn Storage>,
        path: &Path,
        world: &WorldDef,
        options: Options,
        description: &[(String, String)],
    ) -> Result<Self, RecordError> {
        let entry = |key: &str, value: &dyn std::fmt::Display| (key.to_owned(), value.to_string());
        let without_classes = WorldDef { robots: Classes::default(), ..world.clone() };
        let names: Vec<&String> = world.robots.keys().collect();
        let mut metadata: BTreeMap<String, String> = description.iter().cloned().collect();
        metadata.extend([
            entry("format", &FORMAT),
            entry("map", &world.map.name),
            entry("seed", &options.seed),
            entry("time_step", &options.time_step),
            entry("speed_unit", &options.speed_unit),
            entry("keep_robots", &options.keep_robots),
            entry("scene", &serde_json::to_string(&without_classes).unwrap_or_default()),
            entry("classes", &serde_json::to_string(&names).unwrap_or_default()),
            entry("frame", &"x forward, y right, z down; m, kg, s, rad"),
        ]);
        let mut file = LogFile::begin(storage, path, "")?;
        let native = file.with(|file| {
            file.metadata(RUN, metadata)?;
            let native = Native::new(world, file)?;
            file.flush()?;
            Ok(native)
        })?;
        let (classes, used) = (world.robots.clone(), Used::default());
        Ok(Self { file, native, states: States::default(), classes, used, ros2: None })
    }

    /// Writes the messages of [`crate::ros2`] as well, to a separate storage: `run.ros2.mcap` for `run.mcap`.
    ///
    /// # Errors
    /// When that storage cannot be written.
    pub fn with_ros2(
        mut self,
        world: &WorldDef,
        storage: impl FnOnce(&Path) -> std::io::Result<Box<dyn Storage>>,
    ) -> Result<Self, RecordError> {
        let path = ros2_path(self.file.path());
        let storage = storage(&path).map_err(|reason| refused(&path, reason))?;
        self.ros2 = Some((ros2::begin(storage, &path)?, Ros2::new(world)));
        Ok(self)
    }

    /// Writes a record at a simulated time, s.
    ///
    /// # Errors
    /// When the disk takes no more.
    pub fn write(&mut self, time: f64, record: &Record) -> Result<(), RecordError> {
        if let Some((name, class)) = self.used.first(&self.classes, record) {
            self.file.with(|file| write_class(file, &name, class))?;
        }
        if let Some((file, ros2)) = &mut self.ros2 {
            file.with(|file| ros2.write(time, record, file))?;
        }
        self.file.with(|file| self.native.write(time, record, file))
    }

    /// Writes the states of robots, and those of objects that changed since the last snapshot.
    ///
    /// # Errors
    /// When the disk takes no more.
    pub fn write_states(&mut self, snapshot: &Snapshot) -> Result<(), RecordError> {
        let records = self.states.records(self.native.objects_of_map(), snapshot);
        records.iter().try_for_each(|record| self.write(snapshot.time, record))
    }

    /// Flushes everything written so far to the operating system.
    ///
    /// # Errors
    /// When the disk takes no more.
    pub fn flush(&mut self) -> Result<(), RecordError> {
        let files = std::iter::once(&mut self.file).chain(self.ros2.iter_mut().map(|(file, _)| file));
        for file in files {
            file.with(LogFile::flush)?;
        }
        Ok(())
    }

    /// Ends the log with the simulated time and the digest of the world, which checks a replay.
    ///
    /// # Errors
    /// When the disk takes no more.
    pub fn finish(self, end: End) -> Result<(), RecordError> {
        let entry = |key: &str, value: String| (key.to_owned(), value);
        let End { time, digest, unsettled_steps, dropped } = end;
        let mut metadata = BTreeMap::from([
            entry("seconds", time.to_string()),
            entry("dropped", dropped.to_string()),
            entry("unsettled_steps", unsettled_steps.to_string()),
        ]);
        metadata.extend(digest.map(|digest| entry("digest", format!("{digest:016x}"))));
        let Self { mut file, ros2, .. } = self;
        file.with(|file| file.metadata(END, metadata))?;
        file.finish()?;
        ros2.map_or(Ok(()), |(file, _)| file.finish())
    }
}

fn write_class(file: &mut LogFile, name: &str, class: &RobotDef) -> McapResult<()> {
    let definition = serde_json::to_string(class).map_err(std::io::Error::from)?;
    file.metadata(&format!("{CLASS}{name}"), BTreeMap::from([(DEFINITION.to_owned(), definition)]))
}

/// Returns the file of a log's ROS 2 messages: `run.ros2.mcap` beside `run.mcap`.
pub fn ros2_path(log: &Path) -> PathBuf {
    log.with_extension("ros2.mcap")
}

/// A receiver of records.
pub trait Sink: Send + 'static {
    /// Takes a record at a simulated time, s.
    ///
    /// # Errors
    /// When the sink takes no more.
    fn write(&mut self, time: f64, record: &Record) -> Result<(), RecordError>;

    /// Takes the states in a snapshot.
    ///
    /// # Errors
    /// When the sink takes no more.
    fn write_states(&mut self, snapshot: &Snapshot) -> Result<(), RecordError>;

    /// Flushes everything taken so far.
    ///
    /// # Errors
    /// When the sink takes no more.
    fn flush(&mut self) -> Result<(), RecordError>;

    /// Takes the end of the world.
    ///
    /// # Errors
    /// When the sink takes no more.
    fn finish(self, end: End) -> Result<(), RecordError>;
}

impl Sink for LogWriter {
    fn write(&mut self, time: f64, record: &Record) -> Result<(), RecordError> {
        Self::write(self, time, record)
    }

    fn write_states(&mut self, snapshot: &Snapshot) -> Result<(), RecordError> {
        Self::write_states(self, snapshot)
    }

    fn flush(&mut self) -> Result<(), RecordError> {
        Self::flush(self)
    }

    fn finish(self, end: End) -> Result<(), RecordError> {
        Self::finish(self, end)
    }
}

/// Writes a log on a separate thread until it is finished or dropped.
pub struct Recorder {
    queue: Arc<Queue>,
    thread: Option<JoinHandle<Result<(), RecordError>>>,
}

/// A thing for the thread to write.
#[expect(clippy::large_enum_variant, reason = "nearly all are records, the largest variant")]
enum Item {
    /// A record at a simulated time, s.
    Record(f64, Record),
    /// The states in a snapshot.
    States(Arc<Snapshot>),
}

impl Item {
    /// Returns the bytes of memory that it takes, approximately, as if nobody else held the snapshot.
    fn size(&self) -> usize {
        match self {
            Self::Record(_, record) => size_of::<Self>() + record.size(),
            Self::States(snapshot) => size_of::<Self>() + snapshot.size(),
        }
    }

    /// Returns the number of records that it becomes, without objects.
    fn count(&self) -> u64 {
        match self {
            Self::Record(..) => 1,
            Self::States(snapshot) => snapshot.robots.len() as u64,
        }
    }

    fn write(&self, log: &mut impl Sink) -> Result<(), RecordError> {
        match self {
            Self::Record(time, record) => log.write(*time, record),
            Self::States(snapshot) => log.write_states(snapshot),
        }
    }
}

impl Recorder {
    /// Starts the thread that continues a log.
    ///
    /// # Errors
    /// When the thread cannot start.
    pub fn new(log: impl Sink) -> Result<Self, RecordError> {
        let queue = Arc::new(Queue::default());
        let run = {
            let queue = queue.clone();
            move || {
                let _closes = Closes(&queue);
                write_all(log, &queue).inspect_err(|error| tracing::error!(%error, "the log ends here"))
            }
        };
        let thread = std::thread::Builder::new().name("recorder".to_owned()).spawn(run);
        let thread = thread.map_err(|reason| refused("of this run", reason))?;
        Ok(Self { queue, thread: Some(thread) })
    }

    /// Takes a record at a simulated time, s; never waits for the disk.
    pub fn record(&mut self, time: f64, record: Record) {
        self.queue.push(Item::Record(time, record));
    }

    /// Takes the states in a snapshot; never waits for the disk.
    pub fn record_states(&mut self, snapshot: Arc<Snapshot>) {
        self.queue.push(Item::States(snapshot));
    }

    /// Wakes the thread at once, for example because somebody waits for the records. Otherwise it waits for a batch or the next flush.
    pub fn hand_over(&mut self) {
        self.queue.hand_over();
    }

    /// True if the thread still writes records.
    pub fn is_writing(&self) -> bool {
        self.thread.as_ref().is_some_and(|thread| !thread.is_finished())
    }

    /// Returns the error that ended the log, once.
    pub fn failure(&mut self) -> Option<RecordError> {
        let thread = self.thread.take_if(|thread| thread.is_finished())?;
        ended(thread).err()
    }

    /// Ends the log properly with the end of the world. The thread does the work.
    pub fn finish(mut self, end: End) -> Closing {
        self.queue.end(Ending::World(end));
        Closing { thread: self.thread.take() }
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        self.queue.end(Ending::Abandoned);
        // The thread has reported its error.
        self.thread.take().map(ended);
    }
}

/// A log whose end is being written. Dropping it waits for that.
pub struct Closing {
    thread: Option<JoinHandle<Result<(), RecordError>>>,
}

impl Closing {
    /// True if nothing is left to wait for.
    pub fn is_done(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// Waits until everything is written.
    ///
    /// # Errors
    /// When something could not be written.
    pub fn wait(mut self) -> Result<(), RecordError> {
        self.thread.take().map_or(Ok(()), ended)
    }
}

impl Drop for Closing {
    fn drop(&mut self) {
        // The thread has reported its error.
        self.thread.take().map(ended);
    }
}

/// Waits for a writing thread and returns its result.
fn ended(thread: JoinHandle<Result<(), RecordError>>) -> Result<(), RecordError> {
    thread.join().unwrap_or_else(|_| Err(refused("of this run", "its thread panicked, and has said where")))
}

/// Records on their way to the thread.
#[derive(Default)]
struct Queue {
    waiting: Mutex<Waiting>,
    news: Condvar,
}

#[derive(Default)]
struct Waiting {
    items: Vec<Item>,
    /// Bytes of the records that wait, and of those that are being written.
    bytes: usize,
    dropped: u64,
    /// True if the thread must take the records now.
    handed_over: bool,
    ending: Option<Ending>,
    /// True if the thread has ended, so that nobody takes records.
    closed: bool,
}

/// The reason why no more records come.
#[derive(Clone, Copy)]
enum Ending {
    /// The world has ended.
    World(End),
    /// The recorder was dropped without an end.
    Abandoned,
}

impl Queue {
    fn lock(&self) -> MutexGuard<'_, Waiting> {
        // The state is valid after each statement.
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn push(&self, item: Item) {
        let mut waiting = self.lock();
        let bytes = waiting.bytes + item.size();
        if waiting.closed {
            return;
        }
        if bytes > MAX_QUEUED {
            if waiting.dropped == 0 {
                tracing::warn!("the disk is too slow: records are missing in the log");
            }
            waiting.dropped += item.count();
            return;
        }
        waiting.bytes = bytes;
        waiting.items.push(item);
        // Waking the thread for each record would cost more than writing it.
        if waiting.items.len().is_multiple_of(BATCH) {
            self.news.notify_one();
        }
    }

    fn hand_over(&self) {
        let mut waiting = self.lock();
        if !waiting.items.is_empty() && !waiting.handed_over {
            waiting.handed_over = true;
            self.news.notify_one();
        }
    }

    fn end(&self, ending: Ending) {
        self.lock().ending.get_or_insert(ending);
        self.news.notify_one();
    }

    /// Takes the waiting records once they are a batch, are handed over, or no more come; at the latest at `latest`.
    fn take(&self, items: &mut Vec<Item>, latest: Instant) -> Option<Ending> {
        let mut waiting = self.lock();
        while waiting.items.len() < BATCH && !waiting.handed_over && waiting.ending.is_none() {
            let left = latest.saturating_duration_since(Instant::now());
            if left.is_zero() {
                break;
            }
            waiting = self.news.wait_timeout(waiting, left).unwrap_or_else(PoisonError::into_inner).0;
        }
        waiting.handed_over = false;
        std::mem::swap(&mut waiting.items, items);
        waiting.ending
    }
}

/// Drops the waiting records when the thread ends, even by a panic.
struct Closes<'a>(&'a Queue);

impl Drop for Closes<'_> {
    fn drop(&mut self) {
        let mut waiting = self.0.lock();
        (waiting.items, waiting.closed) = (Vec::new(), true);
    }
}

fn write_all(mut log: impl Sink, queue: &Queue) -> Result<(), RecordError> {
    let (mut items, mut flush_at) = (Vec::new(), Instant::now() + FLUSH_INTERVAL);
    loop {
        let ending = queue.take(&mut items, flush_at);
        let bytes: usize = items.iter().map(Item::size).sum();
        items.drain(..).try_for_each(|item| item.write(&mut log))?;
        // Frees the memory that a rush has left.
        items.shrink_to(2 * BATCH);
        let dropped = {
            let mut waiting = queue.lock();
            waiting.bytes -= bytes;
            waiting.dropped
        };
        match ending {
            Some(Ending::World(end)) => return log.finish(End { dropped, ..end }),
            Some(Ending::Abandoned) => return log.flush(),
            None => {}
        }
        if Instant::now() >= flush_at {
            log.flush()?;
            flush_at = Instant::now() + FLUSH_INTERVAL;
        }
    }
}
