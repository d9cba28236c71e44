//! Drive to a point.
//!
//! A robot observes the point in its own frame (2), and its velocities (3). The reward is the distance that it came nearer, m, minus 0.2 a
//! second, and 1 when it arrives.

use rand_chacha::ChaCha8Rng;
use serde::Deserialize;

use super::{Goal, Sight, Verdict, check_range, distance, draw};

/// Penalty of time, 1/s.
const HASTE: f64 = 0.2;
/// Reward of the arrival.
const ARRIVAL: f64 = 1.0;

/// Settings of the goal.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Settings {
    /// Least and most distance of the point from the robot at the start, m.
    distance: [f64; 2],
    /// Distance at which a robot has arrived, m.
    tolerance: f64,
}

pub(crate) struct Reach {
    settings: Settings,
    /// Time between two actions, s.
    interval: f64,
    goals: Vec<[f64; 2]>,
    distances: Vec<f64>,
}

impl Reach {
    pub(crate) fn new(settings: Settings, robots: usize, interval: f64) -> Result<Self, String> {
        check_range("reach.distance", settings.distance, 0.0, 1000.0)?;
        check_range("reach.tolerance", [settings.tolerance; 2], 1e-3, 100.0)?;
        Ok(Self { settings, interval, goals: vec![[0.0; 2]; robots], distances: vec![0.0; robots] })
    }
}

impl Goal for Reach {
    fn width(&self) -> usize {
        5
    }

    fn reset(&mut self, sight: &Sight, rng: &mut ChaCha8Rng) {
        for ((goal, far), robot) in self.goals.iter_mut().zip(&mut self.distances).zip(&sight.robots) {
            let bearing = draw(rng, [-std::f64::consts::PI, std::f64::consts::PI]);
            let (sin, cos) = libm::sincos(bearing);
            *far = draw(rng, self.settings.distance);
            *goal = [robot.place.x + *far * cos, robot.place.y + *far * sin];
        }
    }

    fn observe(&self, sight: &Sight, robot: usize, push: &mut dyn FnMut(f64)) {
        let seen = &sight.robots[robot];
        seen.place.to_own(self.goals[robot]).into_iter().chain(seen.velocity).for_each(push);
    }

    fn judge(&mut self, sight: &Sight) -> Verdict {
        let mut rewards = Vec::with_capacity(self.goals.len());
        let mut arrived = 0;
        for ((goal, before), robot) in self.goals.iter().zip(&mut self.distances).zip(&sight.robots) {
            let now = distance(*goal, robot.place.point());
            let is_there = now <= self.settings.tolerance;
            arrived += usize::from(is_there);
            rewards.push(*before - now - HASTE * self.interval + if is_there { ARRIVAL } else { 0.0 });
            *before = now;
        }
        let is_success = arrived == self.goals.len();
        Verdict { rewards, is_over: is_success, is_success }
    }
}
