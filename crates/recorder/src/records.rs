//! The records of an MCAP file one by one, however damaged the file is. Nothing in a file is trusted before it is checked:
//! lengths are limited, and a chunk's checksum is compared before its first record is used.

use std::collections::BTreeMap;
use std::io::Read;

use mcap::records::{MessageHeader, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{MAGIC, McapError};

/// Largest record, and largest decompressed chunk, bytes. The scene of a map with meshes is one record: some millions of
/// triangles.
pub(crate) const MAX_RECORD_BYTES: usize = 256 << 20;
/// Most bytes that LZ4 makes of one: a byte of a length represents up to 255.
const MAX_EXPANSION: usize = 255;
/// Most bytes requested from the file at once, so that a length without bytes behind it costs nothing.
const READ_BYTES: usize = 64 * 1024;
/// Bytes of the opcode and length before each record.
const HEAD_BYTES: usize = 9;

/// The records that make up a log; all others only serve these.
#[derive(Debug)]
pub(crate) enum Record<'a> {
    Header { profile: &'a str, library: &'a str },
    Schema { id: u16, name: &'a str, encoding: &'a str, data: &'a [u8] },
    Channel { id: u16, schema: u16, topic: &'a str, encoding: &'a str, metadata: BTreeMap<String, String> },
    Message { header: MessageHeader, data: &'a [u8] },
    Metadata { name: &'a str, entries: BTreeMap<String, String> },
}

/// The reason why the rest of a file cannot be read.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{0}")]
pub(crate) struct Damage(pub(crate) String);

/// The reason why reading stopped: damage, or an error of the receiver.
enum Stop<E> {
    Damaged(Damage),
    Refused(E),
}

impl<E> From<Damage> for Stop<E> {
    fn from(damage: Damage) -> Self {
        Self::Damaged(damage)
    }
}

impl<E> From<McapError> for Stop<E> {
    fn from(error: McapError) -> Self {
        Self::Damaged(match error {
            McapError::UnexpectedEof => Damage("it is cut off".to_owned()),
            McapError::Io(reason) => Damage(reason.to_string()),
            error => Damage(error.to_string()),
        })
    }
}

/// Passes each record to `take`, up to the first damage or the first error of `take`.
pub(crate) fn each<E: From<Damage>>(
    file: impl Read,
    mut take: impl FnMut(Record<'_>) -> Result<(), E>,
) -> Result<(), E> {
    let options = LinearReaderOptions::default()
        .with_emit_chunks(true)
        .with_skip_end_magic(true)
        .with_validate_data_section_crc(true)
        .with_validate_summary_section_crc(true)
        .with_record_length_limit(MAX_RECORD_BYTES);
    let (mut place, mut ended) = (MAGIC.len(), false);
    let stopped = split(file, options, |opcode, data| {
        // The records after the data only repeat it.
        if !ended {
            match opcode {
                op::CHUNK => each_of_chunk(data, &mut take)?,
                op::DATA_END => ended = true,
                _ => give(opcode, data, &mut take)?,
            }
        }
        place += HEAD_BYTES + data.len();
        Ok(())
    });
    match stopped {
        Ok(()) if ended => Ok(()),
        Ok(()) => Err(Damage(format!("it is cut off at byte {place}")).into()),
        Err(Stop::Damaged(Damage(reason))) => Err(Damage(format!("the record at byte {place}: {reason}")).into()),
        Err(Stop::Refused(error)) => Err(error),
    }
}

/// Splits a stream of bytes into opcodes and bodies.
fn split<E>(
    mut source: impl Read,
    options: LinearReaderOptions,
    mut take: impl FnMut(u8, &[u8]) -> Result<(), Stop<E>>,
) -> Result<(), Stop<E>> {
    let mut reader = LinearReader::new_with_options(options);
    while let Some(event) = reader.next_event() {
        match event? {
            LinearReadEvent::ReadRequest(wanted) => {
                let count = source.read(reader.insert(wanted.min(READ_BYTES))).map_err(McapError::from)?;
                reader.notify_read(count);
            }
            LinearReadEvent::Record { opcode, data } => take(opcode, data)?,
        }
    }
    Ok(())
}

/// Passes on the records of a chunk, if its checksum is right.
fn each_of_chunk<E>(chunk: &[u8], take: &mut impl FnMut(Record<'_>) -> Result<(), E>) -> Result<(), Stop<E>> {
    let damaged = |reason: String| Err(Stop::Damaged(Damage(reason)));
    let mut fields = Fields(chunk);
    let [_start, _end, size] = [fields.u64()?, fields.u64()?, fields.u64()?];
    let _checksum = fields.u32()?;
    let (compression, compressed) = (fields.text()?, fields.u64()?);
    let data = fields.0;
    if compressed != data.len() as u64 {
        return damaged(format!("a chunk of {} bytes says that it has {compressed}", data.len()));
    }
    let most = match compression {
        "" => data.len(),
        "lz4" => data.len().saturating_mul(MAX_EXPANSION).min(MAX_RECORD_BYTES),
        other => return damaged(format!("compression `{other}`: expected lz4 or none")),
    };
    let Some(size) = usize::try_from(size).ok().filter(|size| *size <= most) else {
        return damaged(format!(
            "a chunk of {} bytes says that it expands to {size}: expected at most {most}",
            data.len()
        ));
    };
    // The library relies on this.
    if compression.is_empty() && !(size == data.len() && is_records(data)) {
        return damaged("a chunk whose records do not fill it".to_owned());
    }
    let options = LinearReaderOptions::default()
        .with_skip_start_magic(true)
        .with_skip_end_magic(true)
        .with_prevalidate_chunk_crcs(true)
        .with_record_length_limit(size.max(chunk.len()));
    let mut head = [op::CHUNK; HEAD_BYTES];
    head[1..].copy_from_slice(&(chunk.len() as u64).to_le_bytes());
    split(head.chain(chunk), options, |opcode, data| give(opcode, data, take))
}

/// True if these bytes are whole records, from the first to the last.
fn is_records(mut bytes: &[u8]) -> bool {
    while let Some((&[_, ref length @ ..], rest)) = bytes.split_first_chunk::<HEAD_BYTES>() {
        let length = usize::try_from(u64::from_le_bytes(*length)).ok();
        let Some(rest) = length.and_then(|length| rest.get(length..)) else { return false };
        bytes = rest;
    }
    bytes.is_empty()
}

/// Parses the fields of a record and passes it on, if logs are made of its kind.
fn give<E>(opcode: u8, data: &[u8], take: &mut impl FnMut(Record<'_>) -> Result<(), E>) -> Result<(), Stop<E>> {
    let mut fields = Fields(data);
    let record = match opcode {
        op::HEADER => Record::Header { profile: fields.text()?, library: fields.text()? },
        op::SCHEMA => {
            Record::Schema { id: fields.u16()?, name: fields.text()?, encoding: fields.text()?, data: fields.sized()? }
        }
        op::CHANNEL => Record::Channel {
            id: fields.u16()?,
            schema: fields.u16()?,
            topic: fields.text()?,
            encoding: fields.text()?,
            metadata: fields.map()?,
        },
        op::MESSAGE => Record::Message {
            header: MessageHeader {
                channel_id: fields.u16()?,
                sequence: fields.u32()?,
                log_time: fields.u64()?,
                publish_time: fields.u64()?,
            },
            data: fields.0,
        },
        op::METADATA => Record::Metadata { name: fields.text()?, entries: fields.map()? },
        _ => return Ok(()),
    };
    take(record).map_err(Stop::Refused)
}

/// The rest of a record, read field by field. Numbers are little-endian, and each text follows its length. The library's own
/// parser would allocate as much as a length claims.
struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    fn bytes(&mut self, count: usize) -> Result<&'a [u8], Damage> {
        let (bytes, rest) = self.0.split_at_checked(count).ok_or_else(|| Damage("it is too short".to_owned()))?;
        self.0 = rest;
        Ok(bytes)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], Damage> {
        let mut array = [0; N];
        array.copy_from_slice(self.bytes(N)?);
        Ok(array)
    }

    fn u16(&mut self) -> Result<u16, Damage> {
        self.array().map(u16::from_le_bytes)
    }

    fn u32(&mut self) -> Result<u32, Damage> {
        self.array().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Result<u64, Damage> {
        self.array().map(u64::from_le_bytes)
    }

    fn sized(&mut self) -> Result<&'a [u8], Damage> {
        let count = self.u32()?;
        self.bytes(count as usize)
    }

    fn text(&mut self) -> Result<&'a str, Damage> {
        std::str::from_utf8(self.sized()?).map_err(|error| Damage(error.to_string()))
    }

    fn map(&mut self) -> Result<BTreeMap<String, String>, Damage> {
        let mut entries = Fields(self.sized()?);
        let mut map = BTreeMap::new();
        while !entries.0.is_empty() {
            map.insert(entries.text()?.to_owned(), entries.text()?.to_owned());
        }
        Ok(map)
    }
}
