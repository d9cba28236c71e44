//! Drive into an upright box.
//!
//! A robot observes the middle of the box in its own frame (3), and its velocities (3). The reward is the distance that it came nearer to
//! the middle, m, and 1 when it is inside. All robots have to be.

use nalgebra::Point3;
use rand_chacha::ChaCha8Rng;
use scene::goal;
use sim_core::World;

use crate::rules::{Rules, Verdict, approached};
use crate::sight::Sight;

/// The goal as it is played.
#[derive(Clone)]
pub(crate) struct Zone {
    settings: goal::Zone,
    distances: Vec<f64>,
}

impl Zone {
    pub(crate) fn new(settings: goal::Zone, robots: usize) -> Self {
        Self { settings, distances: vec![0.0; robots] }
    }

    fn distances(&self, sight: &Sight) -> Vec<f64> {
        sight.robots.iter().map(|robot| robot.distance_from(self.settings.position)).collect()
    }
}

impl Rules for Zone {
    fn width(&self) -> usize {
        6
    }

    fn begin(&mut self, sight: &Sight, _: &mut ChaCha8Rng) {
        self.distances = self.distances(sight);
    }

    fn observe(&self, sight: &Sight, robot: usize, push: &mut dyn FnMut(f64)) {
        let seen = &sight.robots[robot];
        let own = seen.pose.inverse() * Point3::from(self.settings.position);
        own.iter().copied().chain(seen.velocity).for_each(push);
    }

    fn judge(&mut self, _: &mut World, sight: &Sight) -> Verdict {
        let now = self.distances(sight);
        let inside = sight.robots.iter().map(|robot| self.settings.contains(robot.pose.translation.vector.into()));
        let inside: Vec<bool> = inside.collect();
        let rewards = approached(&self.distances, &now, &inside);
        let is_success = inside.iter().all(|&it| it);
        self.distances = now;
        Verdict { rewards, is_over: is_success, is_success }
    }
}
