//! An MCAP file of messages with their schemas.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use foxglove::Encode;
use mcap::records::{MessageHeader, Metadata};
use mcap::{Compression, McapResult, WriteOptions, Writer};

use crate::Put;

/// A file that is being written.
pub(crate) struct LogFile {
    writer: Writer<BufWriter<File>>,
    channels: BTreeMap<String, u16>,
    sequence: u32,
    /// Whole second of the last message: each second ends a chunk, so that a file that is cut off loses less than one.
    second: u64,
    buffer: Vec<u8>,
}

impl LogFile {
    /// Creates the file, replacing an old one. The profile is MCAP's: empty, or `ros2`.
    pub(crate) fn create(path: &Path, profile: &str) -> McapResult<Self> {
        let library = concat!("usarsim ", env!("CARGO_PKG_VERSION"));
        let options = WriteOptions::new().compression(Some(Compression::Lz4)).profile(profile).library(library);
        let writer = options.create(BufWriter::new(File::create(path)?))?;
        Ok(Self { writer, channels: BTreeMap::new(), sequence: 0, second: 0, buffer: Vec::new() })
    }

    pub(crate) fn metadata(&mut self, name: &str, metadata: BTreeMap<String, String>) -> McapResult<()> {
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

    /// Ends the chunk and hands everything to the operating system.
    pub(crate) fn flush(&mut self) -> McapResult<()> {
        self.writer.flush()
    }

    pub(crate) fn finish(mut self) -> McapResult<()> {
        self.writer.finish()?;
        Ok(self.writer.into_inner().flush()?)
    }
}

impl Put for LogFile {
    fn put<T: Encode>(&mut self, time: f64, topic: &str, message: &T) -> McapResult<()> {
        if time as u64 > self.second {
            self.second = time as u64;
            self.flush()?;
        }
        let channel_id = match self.channels.get(topic) {
            Some(&channel) => channel,
            None => self.add_channel::<T>(topic)?,
        };
        self.buffer.clear();
        message.encode(&mut self.buffer).map_err(|error| std::io::Error::other(error.to_string()))?;
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
