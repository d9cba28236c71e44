//! Writing: a file, and for a live world a queue and a thread before it.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use mcap::records::{MessageHeader, Metadata};
use mcap::{WriteOptions, Writer};

use sim_core::Options;
use sim_core::scene::WorldDef;

use crate::{END, End, RUN, Record};

/// Records that may wait for the disk; more are dropped and counted.
const QUEUE: usize = 65_536;
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
    file: PathBuf,
    writer: Writer<BufWriter<File>>,
    wire_schema: u16,
    state_schema: u16,
    channels: BTreeMap<String, u16>,
    sequence: u32,
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
            entry("scene", &serde_json::to_string(world).unwrap_or_default()),
            entry("frame", &"x forward, y right, z down; m, kg, s, rad"),
        ]);
        Self::start(path, metadata).map_err(|reason| refused(path, reason))
    }

    fn start(path: &Path, metadata: BTreeMap<String, String>) -> mcap::McapResult<Self> {
        let options =
            WriteOptions::new().compression(None).profile("").library(concat!("usarsim ", env!("CARGO_PKG_VERSION")));
        let mut writer = options.create(BufWriter::new(File::create(path)?))?;
        writer.write_metadata(&Metadata { name: RUN.to_owned(), metadata })?;
        let wire_schema = writer.add_schema("usarsim.WireLine", "jsonschema", WIRE_SCHEMA.as_bytes())?;
        let state_schema = writer.add_schema("usarsim.RobotState", "jsonschema", STATE_SCHEMA.as_bytes())?;
        writer.flush()?;
        let file = path.to_owned();
        Ok(Self { file, writer, wire_schema, state_schema, channels: BTreeMap::new(), sequence: 0 })
    }

    /// Writes a record of a simulated time in seconds.
    ///
    /// # Errors
    /// When the disk takes no more.
    pub fn write(&mut self, time: f64, record: &Record) -> Result<(), RecordError> {
        self.try_write(time, record).map_err(|reason| refused(&self.file, reason))
    }

    /// Hands everything written so far to the operating system.
    ///
    /// # Errors
    /// When the disk takes no more.
    pub fn flush(&mut self) -> Result<(), RecordError> {
        self.writer.flush().map_err(|reason| refused(&self.file, reason))
    }

    /// Ends the log with the simulated time and the digest of the world, by which a replay is checked.
    ///
    /// # Errors
    /// When the disk takes no more.
    pub fn finish(self, end: End) -> Result<(), RecordError> {
        let file = self.file.clone();
        self.try_finish(end).map_err(|reason| refused(&file, reason))
    }

    fn try_finish(mut self, end: End) -> mcap::McapResult<()> {
        let entry = |key: &str, value: String| (key.to_owned(), value);
        let End { time, digest, dropped } = end;
        let metadata = BTreeMap::from([
            entry("seconds", time.to_string()),
            entry("digest", format!("{digest:016x}")),
            entry("dropped", dropped.to_string()),
        ]);
        self.writer.write_metadata(&Metadata { name: END.to_owned(), metadata })?;
        self.writer.finish()?;
        Ok(self.writer.into_inner().flush()?)
    }

    fn try_write(&mut self, time: f64, record: &Record) -> mcap::McapResult<()> {
        let (topic, schema, data) = match record {
            Record::In(line) => ("/wire/in".to_owned(), self.wire_schema, serde_json::to_vec(line)),
            Record::Out(line) => ("/wire/out".to_owned(), self.wire_schema, serde_json::to_vec(line)),
            Record::Closed(line) => ("/wire/closed".to_owned(), self.wire_schema, serde_json::to_vec(line)),
            Record::State(state) => {
                (format!("/robot/{}/state", state.robot), self.state_schema, serde_json::to_vec(state))
            }
        };
        let data = data.map_err(|error| std::io::Error::other(error.to_string()))?;
        let channel_id = match self.channels.get(&topic) {
            Some(&channel) => channel,
            None => {
                let channel = self.writer.add_channel(schema, &topic, "json", &BTreeMap::new())?;
                self.channels.insert(topic, channel);
                channel
            }
        };
        let nanoseconds = (time * 1e9).round() as u64;
        self.sequence = self.sequence.wrapping_add(1);
        let header =
            MessageHeader { channel_id, sequence: self.sequence, log_time: nanoseconds, publish_time: nanoseconds };
        self.writer.write_to_known_channel(&header, &data)
    }
}

fn refused(file: &Path, reason: impl std::fmt::Display) -> RecordError {
    RecordError { file: file.display().to_string(), reason: reason.to_string() }
}

/// Writes a log from a thread of its own until it is finished or dropped.
pub struct Recorder {
    queue: Option<SyncSender<Entry>>,
    thread: Option<JoinHandle<()>>,
    dropped: u64,
}

enum Entry {
    Record(f64, Record),
    End(End),
}

impl Recorder {
    /// Goes on with a log that has been begun.
    ///
    /// # Errors
    /// When there is no thread for it.
    pub fn new(log: LogWriter) -> Result<Self, RecordError> {
        let (queue, entries) = sync_channel(QUEUE);
        let file = log.file.clone();
        let run = move || {
            if let Err(error) = write_all(log, &entries) {
                tracing::error!(%error, "the log ends here");
            }
        };
        let thread = std::thread::Builder::new().name("recorder".to_owned()).spawn(run);
        let thread = thread.map_err(|reason| refused(&file, reason))?;
        Ok(Self { queue: Some(queue), thread: Some(thread), dropped: 0 })
    }

    /// Queues a record of a simulated time in seconds; never waits.
    pub fn record(&mut self, time: f64, record: Record) {
        let Some(queue) = &self.queue else { return };
        match queue.try_send(Entry::Record(time, record)) {
            Ok(()) => {}
            Err(TrySendError::Full(_)) => {
                self.dropped += 1;
                if self.dropped.is_power_of_two() {
                    tracing::warn!(dropped = self.dropped, "the disk is too slow: records are missing in the log");
                }
            }
            // The thread has said why it ended.
            Err(TrySendError::Disconnected(_)) => self.queue = None,
        }
    }

    /// Ends the log properly and waits until it is written.
    pub fn finish(mut self, time: f64, digest: u64) {
        if let Some(queue) = self.queue.take() {
            // A thread that has ended has said why.
            let _ = queue.send(Entry::End(End { time, digest, dropped: self.dropped }));
        }
    }
}

impl Drop for Recorder {
    fn drop(&mut self) {
        self.queue = None;
        if let Some(thread) = self.thread.take() {
            // A panic of the thread has been printed where it happened.
            let _ = thread.join();
        }
    }
}

fn write_all(mut log: LogWriter, entries: &Receiver<Entry>) -> Result<(), RecordError> {
    let mut flush_at = Instant::now() + FLUSH_INTERVAL;
    loop {
        match entries.recv_timeout(flush_at.saturating_duration_since(Instant::now())) {
            Ok(Entry::Record(time, record)) => log.write(time, &record)?,
            Ok(Entry::End(end)) => return log.finish(end),
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => return log.flush(),
        }
        if Instant::now() >= flush_at {
            log.flush()?;
            flush_at = Instant::now() + FLUSH_INTERVAL;
        }
    }
}

const WIRE_SCHEMA: &str = r#"{"type":"object","title":"usarsim.WireLine","properties":{
"connection":{"type":"integer"},"line":{"type":"string"}}}"#;

const STATE_SCHEMA: &str = r#"{"type":"object","title":"usarsim.RobotState","description":"World frame: x forward, y right, z down; m, rad, s",
"properties":{"robot":{"type":"integer"},"class":{"type":"string"},"name":{"type":"string"},
"position":{"type":"array","items":{"type":"number"}},"orientation":{"type":"array","items":{"type":"number"},"description":"quaternion x, y, z, w"},
"linear":{"type":"array","items":{"type":"number"}},"angular":{"type":"array","items":{"type":"number"}},
"wheel_angles":{"type":"array","items":{"type":"number"}},"wheel_speeds":{"type":"array","items":{"type":"number"}}}}"#;
