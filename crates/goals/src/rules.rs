//! The rules of a goal: what a robot observes, and what it is rewarded for.

use rand_chacha::ChaCha8Rng;
use sim_core::World;

use crate::sight::Sight;

/// Reward of a robot that reaches its goal.
pub(crate) const ARRIVAL: f64 = 1.0;

/// The result of one interval for the robots of a world.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// Reward of each robot.
    pub rewards: Vec<f64>,
    /// True if the goal is reached, or cannot be reached any longer.
    pub is_over: bool,
    /// True if the goal is reached.
    pub is_success: bool,
}

/// A goal, as it is played in one world.
pub(crate) trait Rules {
    /// Returns the number of observations of a robot.
    fn width(&self) -> usize;

    /// Begins, with the robots where they are.
    fn begin(&mut self, sight: &Sight, rng: &mut ChaCha8Rng);

    /// Pushes the observations of a robot.
    fn observe(&self, sight: &Sight, robot: usize, push: &mut dyn FnMut(f64));

    /// Judges an interval.
    fn judge(&mut self, world: &mut World, sight: &Sight) -> Verdict;
}

/// Returns the rewards of robots for the distances that they came nearer, m, and for being there.
pub(crate) fn approached(before: &[f64], now: &[f64], are_there: &[bool]) -> Vec<f64> {
    let nearer = before.iter().zip(now).map(|(before, now)| before - now);
    nearer.zip(are_there).map(|(nearer, &is_there)| nearer + if is_there { ARRIVAL } else { 0.0 }).collect()
}
