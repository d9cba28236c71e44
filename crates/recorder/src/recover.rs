//! Repair of a log that was cut off or damaged.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Read};
use std::path::Path;

use mcap::records::Metadata;
use mcap::{Compression, McapError, McapResult, WriteOptions, Writer};

use crate::RecordError;
use crate::error::refused;
use crate::reader::{ReadError, open};
use crate::records::{self, Damage, Record};

/// The result of a recovery.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Recovered {
    /// Messages saved.
    pub messages: u64,
    /// Latest simulated time among them, s.
    pub seconds: f64,
    /// The reason why the rest could not be read; `None` if the file was whole.
    pub damage: Option<String>,
}

/// The reason why nothing was saved.
#[derive(Debug, thiserror::Error)]
pub enum RecoverError {
    /// The damaged file cannot be read, or is not an MCAP file.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The new file cannot be written.
    #[error(transparent)]
    Write(#[from] RecordError),
}

/// Most bytes of schemas and channels, which the index repeats and memory holds; those of a log are some thousand bytes.
const MAX_DEFINITIONS: usize = 64 << 20;

/// Copies everything up to the damage to a new file, with the index that readers need. Works for any MCAP file whose chunks are
/// compressed with LZ4 or not at all.
///
/// # Errors
/// When the file cannot be read or is not MCAP, or the new one exists or cannot be written. A partial new file is removed.
pub fn recover(path: &Path, to: &Path) -> Result<Recovered, RecoverError> {
    let (source, _) = open(path)?;
    let file = File::create_new(to).map_err(|reason| refused(to, reason))?;
    copy(source, file).map_err(|reason| {
        // Half a file would hinder the next try.
        let _ = std::fs::remove_file(to);
        refused(to, reason).into()
    })
}

/// The reason why copying stopped.
enum Stop {
    Damaged(String),
    Refused(McapError),
}

impl From<Damage> for Stop {
    fn from(damage: Damage) -> Self {
        Self::Damaged(damage.to_string())
    }
}

impl From<McapError> for Stop {
    fn from(error: McapError) -> Self {
        match error {
            McapError::Io(_) => Self::Refused(error),
            // The writer refuses invalid MCAP: more channels than there are numbers, or a missing schema.
            error => Self::Damaged(error.to_string()),
        }
    }
}

fn copy(source: impl Read, file: File) -> McapResult<Recovered> {
    let (mut file, mut copy) = (Some(file), None);
    let mut begin = |profile: &str, library: &str| {
        let options = WriteOptions::new().compression(Some(Compression::Lz4)).profile(profile).library(library);
        // It is called once.
        file.take().map(|file| options.create(BufWriter::new(file)).map(Copy::new)).transpose()
    };
    let read = records::each(source, |record| {
        if let (None, Record::Header { profile, library }) = (&copy, &record) {
            copy = begin(profile, library)?;
        }
        if copy.is_none() {
            copy = begin("", "")?;
        }
        copy.as_mut().map_or(Ok(()), |copy| copy.take(record))
    });
    let damage = match read {
        Ok(()) => None,
        Err(Stop::Damaged(damage)) => Some(damage),
        Err(Stop::Refused(error)) => return Err(error),
    };
    let Some(mut copy) = copy.map_or_else(|| begin("", ""), |copy| Ok(Some(copy)))? else {
        return Ok(Recovered::default());
    };
    copy.writer.finish()?;
    Ok(Recovered { damage, ..copy.recovered })
}

struct Copy {
    writer: Writer<BufWriter<File>>,
    /// Numbers in the copy by numbers in the source.
    schemas: BTreeMap<u16, u16>,
    channels: BTreeMap<u16, u16>,
    definitions: usize,
    recovered: Recovered,
}

impl Copy {
    fn new(writer: Writer<BufWriter<File>>) -> Self {
        let (schemas, channels) = (BTreeMap::from([(0, 0)]), BTreeMap::new());
        Self { writer, schemas, channels, definitions: 0, recovered: Recovered::default() }
    }

    fn take(&mut self, record: Record<'_>) -> Result<(), Stop> {
        match record {
            Record::Header { .. } => {}
            Record::Schema { id, name, encoding, data } => {
                self.define(name.len() + encoding.len() + data.len())?;
                self.schemas.insert(id, self.writer.add_schema(name, encoding, data)?);
            }
            Record::Channel { id, schema, topic, encoding, metadata } => {
                let entries: usize = metadata.iter().map(|(key, value)| key.len() + value.len()).sum();
                self.define(topic.len() + encoding.len() + entries)?;
                let schema = self.schemas.get(&schema).copied().unwrap_or(0);
                self.channels.insert(id, self.writer.add_channel(schema, topic, encoding, &metadata)?);
            }
            Record::Message { mut header, data } => {
                let Some(&channel) = self.channels.get(&header.channel_id) else { return Ok(()) };
                header.channel_id = channel;
                self.writer.write_to_known_channel(&header, data)?;
                self.recovered.messages += 1;
                self.recovered.seconds = self.recovered.seconds.max(header.log_time as f64 / 1e9);
            }
            Record::Metadata { name, entries } => {
                self.writer.write_metadata(&Metadata { name: name.to_owned(), metadata: entries })?;
            }
        }
        Ok(())
    }

    fn define(&mut self, bytes: usize) -> Result<(), Stop> {
        self.definitions = self.definitions.saturating_add(bytes);
        if self.definitions > MAX_DEFINITIONS {
            let text = format!("its schemas and channels are more than {MAX_DEFINITIONS} bytes");
            return Err(Stop::Damaged(text));
        }
        Ok(())
    }
}
