//! Reading a log back, whole or cut off.

use std::path::Path;

use mcap::MessageStream;
use mcap::read::Options;

use crate::Record;

/// One record with its simulated time, s.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// Simulated time, s.
    pub time: f64,
    /// What happened.
    pub record: Record,
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
pub fn read(path: &Path) -> Result<Vec<Entry>, ReadError> {
    let error = |reason: String| ReadError { file: path.display().to_string(), reason };
    let bytes = std::fs::read(path).map_err(|reason| error(reason.to_string()))?;
    if !bytes.starts_with(mcap::MAGIC) {
        return Err(error("not an MCAP file".to_owned()));
    }
    let stream = MessageStream::new_with_options(&bytes, Options::IgnoreEndMagic.into())
        .map_err(|reason| error(reason.to_string()))?;
    let mut entries = Vec::new();
    for message in stream {
        // The end of what was written before the process died.
        let Ok(message) = message else { break };
        let record = parse(&message.channel.topic, &message.data)
            .map_err(|reason| error(format!("{}: {reason}", message.channel.topic)))?;
        entries.push(Entry { time: message.log_time as f64 / 1e9, record });
    }
    Ok(entries)
}

fn parse(topic: &str, data: &[u8]) -> serde_json::Result<Record> {
    match topic {
        "/wire/in" => serde_json::from_slice(data).map(Record::In),
        "/wire/out" => serde_json::from_slice(data).map(Record::Out),
        _ => serde_json::from_slice(data).map(Record::State),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Recorder, WireLine};
    use std::collections::BTreeMap;

    fn line(number: u64) -> Record {
        Record::In(WireLine { connection: number, line: format!("DRIVE {{Left {number}}}") })
    }

    fn written(path: &Path) {
        let mut recorder = Recorder::create(path, BTreeMap::new()).unwrap();
        (0..1000).for_each(|number| recorder.record(number as f64 * 0.002, line(number)));
    }

    #[test]
    fn a_log_reads_back_as_it_was_recorded() {
        let file = tempfile::NamedTempFile::new().unwrap();
        written(file.path());
        let entries = read(file.path()).unwrap();
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
