//! A log that was cut off, made whole.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use mcap::read::{ChunkFlattener, Options};
use mcap::records::Record;
use mcap::{Compression, McapResult, WriteOptions};

use crate::RecordError;
use crate::reader::{ReadError, unreadable};
use crate::writer::refused;

/// What could be saved.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Recovered {
    /// Messages saved.
    pub messages: u64,
    /// Simulated time of the last of them, s.
    pub seconds: f64,
}

/// Why nothing was saved.
#[derive(Debug, thiserror::Error)]
pub enum RecoverError {
    /// The damaged file is no MCAP file.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// The new file cannot be written.
    #[error(transparent)]
    Write(#[from] RecordError),
}

/// Copies everything up to the damage to a new file, with the index that readers want. Works for any MCAP file.
///
/// # Errors
/// When the file cannot be read or is not MCAP, or the new one cannot be written.
pub fn recover(path: &Path, to: &Path) -> Result<Recovered, RecoverError> {
    let bytes = std::fs::read(path).map_err(|reason| unreadable(path, reason))?;
    if !bytes.starts_with(mcap::MAGIC) {
        return Err(unreadable(path, "not an MCAP file").into());
    }
    copy(&bytes, to).map_err(|reason| refused(to, reason).into())
}

fn copy(bytes: &[u8], to: &Path) -> McapResult<Recovered> {
    let records = ChunkFlattener::new_with_options(bytes, Options::IgnoreEndMagic.into())?;
    let mut options = WriteOptions::new().compression(Some(Compression::Lz4));
    let mut records = records.map_while(Result::ok).peekable();
    if let Some(Record::Header(header)) = records.peek() {
        options = options.profile(header.profile.clone()).library(header.library.clone());
    }
    let mut writer = options.create(BufWriter::new(File::create(to)?))?;
    let (mut schemas, mut channels) = (BTreeMap::from([(0, 0)]), BTreeMap::new());
    let mut recovered = Recovered::default();
    for record in records {
        match record {
            Record::Schema { header, data } => {
                schemas.insert(header.id, writer.add_schema(&header.name, &header.encoding, &data)?);
            }
            Record::Channel(channel) => {
                let schema = schemas.get(&channel.schema_id).copied().unwrap_or(0);
                let (topic, encoding) = (&channel.topic, &channel.message_encoding);
                channels.insert(channel.id, writer.add_channel(schema, topic, encoding, &channel.metadata)?);
            }
            Record::Message { mut header, data } => {
                let Some(&channel) = channels.get(&header.channel_id) else { continue };
                header.channel_id = channel;
                recovered.messages += 1;
                recovered.seconds = recovered.seconds.max(header.log_time as f64 / 1e9);
                writer.write_to_known_channel(&header, &data)?;
            }
            Record::Metadata(metadata) => writer.write_metadata(&metadata)?,
            // What comes after the data is made anew.
            Record::DataEnd(_) => break,
            _ => {}
        }
    }
    writer.finish()?;
    Ok(recovered)
}
