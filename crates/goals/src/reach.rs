//! Drive to a point.
//!
//! A robot observes the point in its own frame (2), and its velocities (3). The reward is the distance that it came nearer, m, minus 0.2 a
//! second, and 1 when it arrives.

use rand_chacha::ChaCha8Rng;
use scene::goal;
use sim_core::World;

use crate::rules::{ARRIVAL, Rules, Verdict};
use crate::sight::{Sight, distance, draw};

/// Penalty of time, 1/s.
const HASTE: f64 = 0.2;

/// The goal as it is played.
#[derive(Clone)]
pub(crate) struct Reach {
    settings: goal::Reach,
    /// Time between two actions, s.
    interval: f64,
    goals: Vec<[f64; 2]>,
    distances: Vec<f64>,
}

impl Reach {
    pub(crate) fn new(settings: goal::Reach, robots: usize, interval: f64) -> Self {
        Self { settings, interval, goals: vec![[0.0; 2]; robots], distances: vec![0.0; robots] }
    }
}

impl Rules for Reach {
    fn width(&self) -> usize {
        5
    }

    fn begin(&mut self, sight: &Sight, rng: &mut ChaCha8Rng) {
        for ((goal, far), robot) in self.goals.iter_mut().zip(&mut self.distances).zip(&sight.robots) {
            if let Some(point) = self.settings.point {
                (*goal, *far) = (point, distance(point, robot.place.point()));
                continue;
            }
            let bearing = draw(rng, [-std::f64::consts::PI, std::f64::consts::PI]);
            let (sin, cos) = libm::sincos(bearing);
            *far = draw(rng, self.settings.distance.unwrap_or_default());
            *goal = [robot.place.x + *far * cos, robot.place.y + *far * sin];
        }
    }

    fn observe(&self, sight: &Sight, robot: usize, push: &mut dyn FnMut(f64)) {
        let seen = &sight.robots[robot];
        seen.place.to_own(self.goals[robot]).into_iter().chain(seen.velocity).for_each(push);
    }

    fn judge(&mut self, _: &mut World, sight: &Sight) -> Verdict {
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
