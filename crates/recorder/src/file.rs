//! An MCAP file of messages with their schemas.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use foxglove::Encode;
use mcap::records::{MessageHeader, Metadata};
use mcap::write::NoSeek;
use mcap::{Compression, McapResult, WriteOptions, Writer};

use crate::error::refused;
use crate::records::MAX_RECORD_BYTES;
use crate::{Publish, RecordError};

/// Largest message or metadata, bytes. A chunk with it and the usual megabyte of a chunk can still be read.
const MAX_BYTES: usize = MAX_RECORD_BYTES - (4 << 20);

/// The storage of one log: a file, or in a test a storage that fails.
pub trait Storage: Write + Send {
    /// Waits until everything is on the disk.
    ///
    /// # Errors
    /// When the storage fails.
    fn sync(&mut self) -> io::Result<()>;
}

impl Storage for File {
    fn sync(&mut self) -> io::Result<()> {
        self.sync_all()
    }
}

/// Opens the file of a log, empty, and locked against other writers of logs.
///
/// # Errors
/// When the file cannot be written, or another program is writing it.
pub fn storage(path: &Path) -> io::Result<Box<dyn Storage>> {
    // The old content is lost only after the file is locked.
    let file = OpenOptions::new().write(true).create(true).truncate(false).open(path)?;
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => {
            return Err(io::Error::other("another program is writing it: end that program, or choose another file"));
        }
        // Some file systems have no locks.
        Ok(()) | Err(TryLockError::Error(_)) => {}
    }
    if file.metadata()?.is_file() {
        file.set_len(0)?;
    }
    Ok(Box::new(file))
}

/// A file that is being written. A chunk is built in memory and written whole, so a file that is cut off has no half-written
/// lengths.
pub(crate) struct LogFile {
    path: PathBuf,
    writer: Writer<NoSeek<BufWriter<Box<dyn Storage>>>>,
    channels: BTreeMap<String, u16>,
    sequence: u32,
    /// Whole second of the last message. Each second ends a chunk, so that a file that is cut off loses less than one.
    second: u64,
    buffer: Vec<u8>,
}

impl LogFile {
    /// Begins the file. `path` names it in errors; `profile` is MCAP's: empty, or `ros2`.
    pub(crate) fn begin(storage: Box<dyn Storage>, path: &Path, profile: &str) -> Result<Self, RecordError> {
        let library = concat!("usarsim ", env!("CARGO_PKG_VERSION"));
        let options = WriteOptions::new().compression(Some(Compression::Lz4)).profile(profile).library(library);
        let writer = options.disable_seeking(true).create(NoSeek::new(BufWriter::new(storage)));
        let (path, writer) = (path.to_owned(), writer.map_err(|reason| refused(path, reason))?);
        Ok(Self { path, writer, channels: BTreeMap::new(), sequence: 0, second: 0, buffer: Vec::new() })
    }

    /// Runs an operation on the file; its errors name the file.
    pub(crate) fn with<T>(&mut self, act: impl FnOnce(&mut Self) -> McapResult<T>) -> Result<T, RecordError> {
        act(self).map_err(|reason| refused(&self.path, reason))
    }

    /// Returns its name.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    pub(crate) fn metadata(&mut self, name: &str, metadata: BTreeMap<String, String>) -> McapResult<()> {
        check_size(metadata.iter().map(|(key, value)| key.len() + value.len()).sum())?;
        self.writer.write_metadata(&Metadata { name: name.to_owned(), metadata })
    }

    fn add_channel<T: Encode>(&mut self, topic: &str) -> McapResult<u16> {
        let schema = match T::get_schema() {
            Some(schema) => self.writer.add_schema(&schema.name, &schema.encoding, &schema.data)?,
            None => 0,
        };
        let channel = self.writer.add_channel(schema, topic, &T::get_message_encoding(), &BTreeMap::new())?;
        self.channels.insert(topic.to_owned(), channel);
        Ok(channel)
    }

    /// Ends the chunk and flushes everything to the operating system.
    pub(crate) fn flush(&mut self) -> McapResult<()> {
        self.writer.flush()
    }

    /// Writes the index, and waits until everything is on the disk.
    pub(crate) fn finish(mut self) -> Result<(), RecordError> {
        self.with(|file| file.writer.finish())?;
        let file = self.writer.into_inner().into_inner().into_inner();
        let synced = file.map_err(io::IntoInnerError::into_error).and_then(|mut file| file.sync());
        synced.map_err(|reason| refused(&self.path, reason))
    }
}

impl Publish for LogFile {
    fn publish<T: Encode>(&mut self, time: f64, topic: &str, message: &T) -> McapResult<()> {
        if time as u64 > self.second {
            self.second = time as u64;
            self.flush()?;
        }
        let channel_id = match self.channels.get(topic) {
            Some(&channel) => channel,
            None => self.add_channel::<T>(topic)?,
        };
        self.buffer.clear();
        message.encode(&mut self.buffer).map_err(|error| io::Error::other(error.to_string()))?;
        check_size(self.buffer.len())?;
        let nanoseconds = nanoseconds(time);
        self.sequence = self.sequence.wrapping_add(1);
        let header =
            MessageHeader { channel_id, sequence: self.sequence, log_time: nanoseconds, publish_time: nanoseconds };
        self.writer.write_to_known_channel(&header, &self.buffer)
    }
}

pub(crate) fn nanoseconds(time: f64) -> u64 {
    (time * 1e9).round() as u64
}

fn check_size(bytes: usize) -> io::Result<()> {
    let text = || format!("a message of {bytes} bytes: expected at most {MAX_BYTES}");
    if bytes > MAX_BYTES { Err(io::Error::other(text())) } else { Ok(()) }
}
