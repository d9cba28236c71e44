//! Reading a log back, whole or cut off.

use std::collections::BTreeMap;
use std::path::Path;

use foxglove::messages::{Log as LogMessage, log::Level};
use mcap::read::{ChunkFlattener, Options};
use mcap::records::Record as Raw;
use prost::{DecodeError, Message};

use crate::{END, ObjectState, RUN, Record, RobotState, WireLine};

/// One record with its simulated time, s.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// Simulated time, s.
    pub time: f64,
    /// What happened.
    pub record: Record,
}

/// A log as it was read.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Log {
    /// What describes the run.
    pub run: BTreeMap<String, String>,
    /// How it ended: `seconds`, `digest`, `dropped`. Empty when the log was cut off.
    pub end: BTreeMap<String, String>,
    /// What was recorded, in its order.
    pub entries: Vec<Entry>,
}

/// A log that cannot be read at all.
#[derive(Debug, thiserror::Error)]
#[error("log {file}: {reason}")]
pub struct ReadError {
    file: String,
    reason: String,
}

/// Reads a log. One that was cut off gives what is whole in it.
///
/// # Errors
/// When the file cannot be read or is no log of this program.
pub fn read(path: &Path) -> Result<Log, ReadError> {
    let error = |reason: &dyn std::fmt::Display| unreadable(path, reason);
    let bytes = std::fs::read(path).map_err(|reason| error(&reason))?;
    if !bytes.starts_with(mcap::MAGIC) {
        return Err(error(&"not an MCAP file"));
    }
    let records = ChunkFlattener::new_with_options(&bytes, Options::IgnoreEndMagic.into());
    let (mut log, mut topics) = (Log::default(), BTreeMap::new());
    // An error is the end of what was written before the process died.
    for record in records.map_err(|reason| error(&reason))?.map_while(Result::ok) {
        match record {
            Raw::Metadata(metadata) if metadata.name == RUN => log.run = metadata.metadata,
            Raw::Metadata(metadata) if metadata.name == END => log.end = metadata.metadata,
            Raw::Channel(channel) => drop(topics.insert(channel.id, channel.topic)),
            Raw::Message { header, data } => {
                let topic = topics.get(&header.channel_id).map_or("", String::as_str);
                let record = parse(topic, &data).map_err(|reason| error(&format_args!("{topic}: {reason}")))?;
                log.entries.extend(record.map(|record| Entry { time: header.log_time as f64 / 1e9, record }));
            }
            _ => {}
        }
    }
    if log.run.is_empty() && log.entries.is_empty() {
        return Err(error(&"no log of usarsim: expected the metadata `run`, or a message"));
    }
    Ok(log)
}

pub(crate) fn unreadable(path: &Path, reason: impl std::fmt::Display) -> ReadError {
    ReadError { file: path.display().to_string(), reason: reason.to_string() }
}

/// `None` for a topic that only shows what another one says.
fn parse(topic: &str, data: &[u8]) -> Result<Option<Record>, DecodeError> {
    let record = match topic {
        "/wire/in" => Record::In(WireLine::decode(data)?),
        "/wire/out" => Record::Out(WireLine::decode(data)?),
        "/wire/closed" => Record::Closed(WireLine::decode(data)?),
        "/log" => {
            let LogMessage { level, message, .. } = LogMessage::decode(data)?;
            return Ok((level == Level::Warning as i32).then_some(Record::Warning(message)));
        }
        _ => match topic.split('/').collect::<Vec<_>>()[..] {
            ["", "robot", _, "state"] => Record::State(RobotState::decode(data)?),
            ["", "map", "object", _] => Record::Object(ObjectState::decode(data)?),
            _ => return Ok(None),
        },
    };
    Ok(Some(record))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{LogWriter, Recorder};
    use sim_core::scene::{MapDef, WorldDef};

    fn line(number: u64) -> Record {
        Record::In(WireLine { connection: number, robot: None, line: format!("DRIVE {{Left {number}}}") })
    }

    fn written(path: &Path) {
        let map = MapDef {
            name: "none".to_owned(),
            description: String::new(),
            gravity: 9.81,
            time_limit: 0,
            solids: Vec::new(),
            objects: Vec::new(),
            starts: Vec::new(),
            path_nodes: Vec::new(),
        };
        let world = WorldDef { map, robots: BTreeMap::new() };
        let log = LogWriter::create(path, &world, sim_core::Options::default(), &[]).unwrap();
        let mut recorder = Recorder::new(log).unwrap();
        (0..1000).for_each(|number| recorder.record(number as f64 * 0.002, line(number)));
        recorder.finish(2.0, Some(0xabc));
    }

    #[test]
    fn a_log_reads_back_as_it_was_recorded() {
        let file = tempfile::NamedTempFile::new().unwrap();
        written(file.path());
        let Log { run, end, entries } = read(file.path()).unwrap();
        assert_eq!((run["map"].as_str(), end["digest"].as_str()), ("none", "0000000000000abc"));
        assert_eq!(entries.len(), 1000);
        assert_eq!(entries[999], Entry { time: 1.998, record: line(999) });
    }

    #[test]
    fn a_log_cut_off_anywhere_reads_without_an_error() {
        let file = tempfile::NamedTempFile::new().unwrap();
        written(file.path());
        let bytes = std::fs::read(file.path()).unwrap();
        for part in [50, 90, 99] {
            std::fs::write(file.path(), &bytes[..bytes.len() * part / 100]).unwrap();
            assert!(read(file.path()).is_ok(), "{part} %");
        }
    }

    #[test]
    fn a_file_that_is_no_log_is_a_named_error() {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), "hello").unwrap();
        assert!(read(file.path()).unwrap_err().to_string().contains("log "));
    }
}
