//! Named random streams, and the hash for them and for the digest.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// The hash FNV-1a, 64 bits: small, and stable across platforms and versions. No secret is needed.
pub(super) struct Fnv(u64);

impl Default for Fnv {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Fnv {
    pub(super) fn mix(&mut self, bytes: &[u8]) {
        for &byte in bytes {
            self.0 = (self.0 ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    pub(super) fn value(&self) -> u64 {
        self.0
    }
}

/// Returns the random stream of one sensor. Appending a sensor or a robot does not change the numbers that others draw.
pub(super) fn stream(seed: u64, robot: u64, sensor: &str, index: usize) -> ChaCha8Rng {
    let mut hash = Fnv::default();
    hash.mix(&seed.to_le_bytes());
    hash.mix(&robot.to_le_bytes());
    hash.mix(&(index as u64).to_le_bytes());
    hash.mix(sensor.as_bytes());
    ChaCha8Rng::seed_from_u64(hash.value())
}
