//! Messages between the server and the process of its node, over pipes: the length of each, then CDR, the encoding of all else here.

use std::io::{self, Read, Write};
use std::net::Ipv4Addr;

use ros2_topics::cdr;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// Longest message, bytes.
const MOST_BYTES: u32 = 64 << 20;

/// Identity of a request: its writer and its number there.
pub(crate) type Identity = rustdds::SampleIdentity;

/// A message to the node.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) enum Order {
    /// Joins a domain at an address of this machine. The first message.
    Join { domain: u16, address: Ipv4Addr },
    /// Opens a topic of a type in DDS, by a number of its own.
    Open { number: u32, topic: String, kind: String, terms: Terms },
    /// Publishes a message on a topic.
    Publish { number: u32, message: Vec<u8> },
    /// Subscribes to a topic.
    Listen { number: u32, topic: String, kind: String },
    /// Offers a service of a type, as in `std_srvs/Trigger`.
    Offer { number: u32, service: String, kind: String },
    /// Replies to a request of a service.
    Reply { number: u32, to: Identity, message: Vec<u8> },
    /// Closes a topic, a subscription or a service.
    Close { number: u32 },
}

/// Terms of a topic.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Terms {
    /// Each message arrives.
    Usual,
    /// Each message arrives; there are few, and they are large.
    Large,
    /// Late subscribers get the last message.
    Latched,
}

/// A message of the node.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) enum Event {
    /// The domain is joined, or cannot be for the reason.
    Joined(Result<(), String>),
    /// The number of subscribers of a topic has changed.
    Subscribers { number: u32, count: i32 },
    /// Somebody published a message.
    Heard { number: u32, message: Vec<u8> },
    /// Somebody asked a service.
    Asked { number: u32, from: Identity, message: Vec<u8> },
    /// So many messages found no room since the start.
    Refused(u64),
}

/// Writes a message.
///
/// # Errors
/// When the pipe is closed.
pub(crate) fn write<T: Serialize>(pipe: &mut impl Write, message: &T) -> io::Result<()> {
    let bytes = cdr::write(message).map_err(io::Error::other)?;
    let length = u32::try_from(bytes.len()).ok().filter(|length| *length <= MOST_BYTES);
    let length = length.ok_or_else(|| io::Error::other(format!("a message of {} bytes", bytes.len())))?;
    pipe.write_all(&length.to_be_bytes())?;
    pipe.write_all(&bytes)
}

/// Reads a message.
///
/// # Errors
/// When the pipe is closed, or the bytes are no message.
pub(crate) fn read<T: DeserializeOwned>(pipe: &mut impl Read) -> io::Result<T> {
    let mut length = [0; 4];
    pipe.read_exact(&mut length)?;
    let length = u32::from_be_bytes(length);
    if length > MOST_BYTES {
        return Err(io::Error::other(format!("a message of {length} bytes: expected at most {MOST_BYTES}")));
    }
    let mut bytes = Vec::new();
    pipe.take(u64::from(length)).read_to_end(&mut bytes)?;
    cdr::read(&bytes).map_err(io::Error::other)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_go_through_a_pipe() {
        let orders = [
            Order::Join { domain: 7, address: Ipv4Addr::LOCALHOST },
            Order::Open { number: 1, topic: "/tf".to_owned(), kind: "TF_".to_owned(), terms: Terms::Latched },
            Order::Publish { number: 1, message: vec![1, 2, 3] },
            Order::Reply { number: 2, to: Identity::default(), message: Vec::new() },
            Order::Close { number: 1 },
        ];
        let mut pipe = Vec::new();
        orders.iter().for_each(|order| write(&mut pipe, order).expect("a message"));
        let mut pipe = pipe.as_slice();
        let read_back: Vec<Order> = std::iter::from_fn(|| read(&mut pipe).ok()).collect();
        assert_eq!(read_back, orders);
        let events = [
            Event::Joined(Err("taken".to_owned())),
            Event::Asked { number: 3, from: Identity::default(), message: vec![9] },
        ];
        let mut pipe = Vec::new();
        events.iter().for_each(|event| write(&mut pipe, event).expect("a message"));
        assert_eq!(read::<Event>(&mut pipe.as_slice()).expect("an event"), events[0]);
        assert!(read::<Event>(&mut &[0xff, 0xff, 0xff, 0xff][..]).is_err());
    }
}
