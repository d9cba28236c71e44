//! Passes by which the server behind the gate knows the gate's connections.

use std::hash::{BuildHasher, RandomState};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use subtle::ConstantTimeEq;

/// The secret of all passes. Copies are the same.
#[derive(Clone)]
pub(crate) struct Pass {
    secret: Arc<str>,
    next: Arc<AtomicU64>,
}

impl Pass {
    pub(crate) fn new() -> Self {
        // Keys of a hasher are random bits of the operating system's.
        let keys = RandomState::new();
        let secret = format!("{:016x}{:016x}", keys.hash_one(0), keys.hash_one(1));
        Self { secret: secret.into(), next: Arc::default() }
    }

    /// Returns the number of a new connection, and the frame that shows its pass to the server: a WebSocket message that advertises a
    /// channel.
    pub(crate) fn frame(&self) -> (u64, Vec<u8>) {
        let number = self.next.fetch_add(1, Ordering::Relaxed);
        let topic = format!("{}/{number}", self.secret);
        let channel = serde_json::json!({ "id": 0, "topic": topic, "encoding": "json", "schemaName": "" });
        let text = serde_json::json!({ "op": "advertise", "channels": [channel] }).to_string();
        // A whole text with two bytes of length, masked by zeros (RFC 6455, 5.2).
        let mut frame = vec![0x81, 0x80 | 126];
        frame.extend((text.len() as u16).to_be_bytes());
        frame.extend([0; 4]);
        frame.extend(text.into_bytes());
        (number, frame)
    }

    /// Returns the number of the connection whose pass this is.
    pub(crate) fn number(&self, topic: &str) -> Option<u64> {
        let (secret, number) = topic.split_once('/')?;
        let number = number.parse().ok()?;
        bool::from(secret.as_bytes().ct_eq(self.secret.as_bytes())).then_some(number)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pass_has_the_number_of_its_connection_and_a_secret() {
        let (pass, other) = (Pass::new(), Pass::new());
        let topic = |frame: &[u8]| {
            let message: serde_json::Value = serde_json::from_slice(&frame[8..]).unwrap();
            message["channels"][0]["topic"].as_str().unwrap().to_owned()
        };
        for number in 0..3 {
            let (own, frame) = pass.frame();
            assert_eq!((own, pass.number(&topic(&frame)), other.number(&topic(&frame))), (number, Some(number), None));
            assert_eq!(usize::from(u16::from_be_bytes([frame[2], frame[3]])), frame.len() - 8);
        }
        assert_eq!(pass.number("/1"), None);
    }
}
