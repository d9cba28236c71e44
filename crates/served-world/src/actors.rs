//! Everything with a pose at a time, for referees and radios.

use std::sync::OnceLock;

use gamebots_proto::ports::{Stand, positions};
use nalgebra::Vector3;
use scene::Pose;
use sim_core::{Actor, ActorKind, World};

/// Everything with a pose at a time.
pub struct Actors {
    /// Simulated time, s.
    time: f64,
    all: Vec<Actor>,
    /// Answer to GETPOS, once it was asked for.
    stands: OnceLock<String>,
}

impl Actors {
    /// Returns the simulated time, s.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Returns all of it.
    pub fn all(&self) -> &[Actor] {
        &self.all
    }

    /// Collects everything with a pose in a world.
    pub fn of(world: &World) -> Self {
        Self { time: world.time(), all: world.actors(), stands: OnceLock::new() }
    }

    /// Returns names and places of the robots, m, each with true if its battery is empty.
    pub fn places(&self) -> impl Iterator<Item = (String, ([f64; 3], bool))> {
        self.robots().map(|robot| (robot.called.clone(), (point_of(&robot.pose), robot.battery_is_empty)))
    }

    /// Returns the robots.
    pub fn robots(&self) -> impl Iterator<Item = &Actor> {
        self.all.iter().filter(|actor| actor.kind == ActorKind::Robot)
    }

    /// Returns the answer to GETPOS. Clients that ask in the same step share it.
    pub fn stands(&self) -> &str {
        self.stands.get_or_init(|| {
            let robots = self.robots().map(|Actor { called, pose, battery_is_empty, .. }| Stand {
                name: called,
                location: point_of(pose).map(|number| number as f32),
                battery_is_empty: *battery_is_empty,
            });
            positions(&robots.collect::<Vec<_>>())
        })
    }
}

/// Returns the place of a pose, m.
pub fn point_of(pose: &Pose) -> [f64; 3] {
    Vector3::into(pose.translation.vector)
}
