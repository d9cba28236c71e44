//! Named random streams: one for each sensor, from the seed, the robot's number, the sensor's name and its index. Another seed changes
//! noise, never motion.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use scene::Fnv;

/// Returns the random stream of one sensor. Appending a sensor or a robot does not change the numbers that others draw.
pub(super) fn stream(seed: u64, robot: u64, sensor: &str, index: usize) -> ChaCha8Rng {
    let mut hash = Fnv::default();
    hash.mix(&seed.to_le_bytes());
    hash.mix(&robot.to_le_bytes());
    hash.mix(&(index as u64).to_le_bytes());
    hash.mix(sensor.as_bytes());
    ChaCha8Rng::seed_from_u64(hash.value())
}
