//! CDR, the encoding of messages: plain, little endian, without the four bytes of the encapsulation.

use byteorder::LittleEndian;
use serde::Serialize;
use serde::de::DeserializeOwned;

pub use cdr_encoding::Error;

/// Writes a message.
///
/// # Errors
/// When it does not fit into CDR: a text or a list is longer than 4 GiB.
pub fn write(message: &impl Serialize) -> Result<Vec<u8>, Error> {
    cdr_encoding::to_vec::<_, LittleEndian>(message)
}

/// Reads a message.
///
/// # Errors
/// When the bytes are no such message.
pub fn read<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, Error> {
    cdr_encoding::from_bytes::<T, LittleEndian>(bytes).map(|(message, _)| message)
}
