//! Find a victim: see it from nearby.
//!
//! A robot observes the victim's pelvis in its own frame (3), 1 if it finds the victim now (1), and its velocities (3). The reward is the
//! distance that it came nearer, m, and 1 when it finds the victim. One robot is enough.

use nalgebra::Point3;
use rand_chacha::ChaCha8Rng;
use scene::{MapDef, goal};
use sim_core::World;

use crate::rules::{Rules, Verdict, approached};
use crate::sight::Sight;

/// The goal as it is played.
#[derive(Clone)]
pub(crate) struct Find {
    /// Number of the victim on the map.
    victim: usize,
    /// Its pelvis, m.
    pelvis: [f64; 3],
    /// Greatest distance between robot frame and pelvis, m.
    radius: f64,
    distances: Vec<f64>,
    is_found: Vec<bool>,
}

impl Find {
    /// Creates the goal for the victim with a number on the map.
    pub(crate) fn new(victim: usize, radius: f64, robots: usize, map: &MapDef) -> Self {
        let pelvis = map.victims.get(victim).map_or([0.0; 3], |victim| victim.position);
        Self { victim, pelvis, radius, distances: vec![0.0; robots], is_found: vec![false; robots] }
    }

    /// Returns the number of the victim that the goal names.
    ///
    /// # Errors
    /// When the map has none of this name.
    pub(crate) fn victim(settings: &goal::Find, map: &MapDef) -> Result<usize, String> {
        let victims = &map.victims;
        let victim = victims.iter().position(|victim| victim.name.eq_ignore_ascii_case(&settings.victim));
        victim.ok_or_else(|| {
            let known = names::listed(victims.iter().map(|victim| victim.name.as_str()));
            format!("find.victim: the map {} has no `{}`: expected one of {known}", map.name, settings.victim)
        })
    }

    fn distances(&self, sight: &Sight) -> Vec<f64> {
        sight.robots.iter().map(|robot| robot.distance_from(self.pelvis)).collect()
    }
}

impl Rules for Find {
    fn width(&self) -> usize {
        7
    }

    fn begin(&mut self, sight: &Sight, _: &mut ChaCha8Rng) {
        self.distances = self.distances(sight);
        self.is_found.fill(false);
    }

    fn observe(&self, sight: &Sight, robot: usize, push: &mut dyn FnMut(f64)) {
        let seen = &sight.robots[robot];
        let own = seen.pose.inverse() * Point3::from(self.pelvis);
        own.iter().for_each(|number| push(*number));
        push(f64::from(u8::from(self.is_found[robot])));
        seen.velocity.into_iter().for_each(push);
    }

    fn judge(&mut self, world: &mut World, sight: &Sight) -> Verdict {
        let now = self.distances(sight);
        for ((is_found, robot), &distance) in self.is_found.iter_mut().zip(&sight.robots).zip(&now) {
            *is_found = distance <= self.radius && world.sees(robot.id, self.victim);
        }
        let rewards = approached(&self.distances, &now, &self.is_found);
        let is_success = self.is_found.contains(&true);
        self.distances = now;
        Verdict { rewards, is_over: is_success, is_success }
    }
}
