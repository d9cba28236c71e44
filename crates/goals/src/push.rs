//! Push the object to a point.
//!
//! A robot observes the object (2) and the point (2) in its own frame, the object's heading (2: cosine and sine), and its own velocities
//! (3). All robots get one reward: the distance that the object came nearer to the point, m, a tenth of the distance that the robots came
//! nearer to the object, and 1 when the object is there.

use rand_chacha::ChaCha8Rng;
use scene::goal;
use sim_core::World;

use crate::rules::{ARRIVAL, Rules, Verdict};
use crate::sight::{Place, Sight, distance, draw};

/// Reward for coming nearer to the object, of that for the object's coming nearer to the point.
const APPROACH: f64 = 0.1;

/// The goal as it is played.
#[derive(Clone)]
pub(crate) struct Push {
    settings: goal::Push,
    target: [f64; 2],
    /// Distances of the object from the point, and of the robots from the object, m.
    distances: [f64; 2],
}

impl Push {
    pub(crate) fn new(settings: goal::Push) -> Self {
        Self { settings, target: [0.0; 2], distances: [0.0; 2] }
    }

    fn distances(&self, sight: &Sight) -> [f64; 2] {
        let object = object(sight).point();
        let robots = sight.robots.iter().map(|robot| distance(robot.place.point(), object));
        [distance(object, self.target), robots.sum::<f64>() / sight.robots.len().max(1) as f64]
    }
}

/// Returns the place of the object.
fn object(sight: &Sight) -> Place {
    sight.object.as_ref().map_or_else(Place::default, Place::of)
}

impl Rules for Push {
    fn width(&self) -> usize {
        9
    }

    fn begin(&mut self, sight: &Sight, rng: &mut ChaCha8Rng) {
        self.target = self.settings.target.map(|range| draw(rng, range));
        self.distances = self.distances(sight);
    }

    fn observe(&self, sight: &Sight, robot: usize, push: &mut dyn FnMut(f64)) {
        let (seen, object) = (&sight.robots[robot], object(sight));
        let heading = seen.place.heading_of(object);
        let places = [seen.place.to_own(object.point()), seen.place.to_own(self.target), heading];
        places.into_iter().flatten().chain(seen.velocity).for_each(push);
    }

    fn judge(&mut self, _: &mut World, sight: &Sight) -> Verdict {
        let now = self.distances(sight);
        let [pushed, approached] = [0, 1].map(|which| self.distances[which] - now[which]);
        self.distances = now;
        let is_success = now[0] <= self.settings.tolerance;
        let reward = pushed + APPROACH * approached + if is_success { ARRIVAL } else { 0.0 };
        Verdict { rewards: vec![reward; sight.robots.len()], is_over: is_success, is_success }
    }
}
