//! Writing: a queue, a thread, a file.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use mcap::records::{MessageHeader, Metadata};
use mcap::{WriteOptions, Writer};

use crate::Record;

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

/// Writes a log until it is dropped.
pub struct Recorder {
    queue: Option<SyncSender<(f64, Record)>>,
    thread: Option<JoinHandle<()>>,
    dropped: u64,
}

impl Recorder {
    /// Creates the file, replacing an old one, and writes what describes the run.
    ///
    /// # Errors
    /// When the file cannot be created.
    pub fn create(path: &Path, description: BTreeMap<String, String>) -> Result<Self, RecordError> {
        let error = |reason: &dyn std::fmt::Display| RecordError {
            file: path.display().to_string(),
            reason: reason.to_string(),
        };
        let file = File::create(path).map_err(|reason| error(&reason))?;
        let log = Log::start(BufWriter::new(file), description).map_err(|reason| error(&reason))?;
        let (queue, records) = sync_channel(QUEUE);
        let thread = std::thread::Builder::new()
            .name("recorder".to_owned())
            .spawn(move || log.run(&records))
            .map_err(|reason| error(&reason))?;
        Ok(Self { queue: Some(queue), thread: Some(thread), dropped: 0 })
    }

    /// Queues a record of a simulated time in seconds; never waits.
    pub fn record(&mut self, time: f64, record: Record) {
        let Some(queue) = &self.queue else { return };
        match queue.try_send((time, record)) {
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

struct Log {
    writer: Writer<BufWriter<File>>,
    wire_schema: u16,
    state_schema: u16,
    channels: BTreeMap<String, u16>,
    sequence: u32,
}

impl Log {
    fn start(file: BufWriter<File>, description: BTreeMap<String, String>) -> mcap::McapResult<Self> {
        let options =
            WriteOptions::new().compression(None).profile("").library(concat!("usarsim ", env!("CARGO_PKG_VERSION")));
        let mut writer = options.create(file)?;
        writer.write_metadata(&Metadata { name: "run".to_owned(), metadata: description })?;
        let wire_schema = writer.add_schema("usarsim.WireLine", "jsonschema", WIRE_SCHEMA.as_bytes())?;
        let state_schema = writer.add_schema("usarsim.RobotState", "jsonschema", STATE_SCHEMA.as_bytes())?;
        writer.flush()?;
        Ok(Self { writer, wire_schema, state_schema, channels: BTreeMap::new(), sequence: 0 })
    }

    fn run(mut self, records: &Receiver<(f64, Record)>) {
        if let Err(error) = self.write_all(records).and_then(|()| self.writer.finish().map(drop)) {
            tracing::error!(%error, "the log ends here");
        }
    }

    fn write_all(&mut self, records: &Receiver<(f64, Record)>) -> mcap::McapResult<()> {
        let mut flush_at = Instant::now() + FLUSH_INTERVAL;
        loop {
            match records.recv_timeout(flush_at.saturating_duration_since(Instant::now())) {
                Ok((time, record)) => self.write(time, &record)?,
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return Ok(()),
            }
            if Instant::now() >= flush_at {
                self.writer.flush()?;
                flush_at = Instant::now() + FLUSH_INTERVAL;
            }
        }
    }

    fn write(&mut self, time: f64, record: &Record) -> mcap::McapResult<()> {
        let (topic, schema, data) = match record {
            Record::In(line) => ("/wire/in".to_owned(), self.wire_schema, serde_json::to_vec(line)),
            Record::Out(line) => ("/wire/out".to_owned(), self.wire_schema, serde_json::to_vec(line)),
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

const WIRE_SCHEMA: &str = r#"{"type":"object","title":"usarsim.WireLine","properties":{
"connection":{"type":"integer"},"line":{"type":"string"}}}"#;

const STATE_SCHEMA: &str = r#"{"type":"object","title":"usarsim.RobotState","description":"World frame: x forward, y right, z down; m, rad, s",
"properties":{"robot":{"type":"integer"},"class":{"type":"string"},"name":{"type":"string"},
"position":{"type":"array","items":{"type":"number"}},"orientation":{"type":"array","items":{"type":"number"},"description":"quaternion x, y, z, w"},
"linear":{"type":"array","items":{"type":"number"}},"angular":{"type":"array","items":{"type":"number"}},
"wheel_angles":{"type":"array","items":{"type":"number"}},"wheel_speeds":{"type":"array","items":{"type":"number"}}}}"#;
