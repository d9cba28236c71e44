//! Saving a world as plain data, and going on from it.

use scene::{Options, PawnId};
use serde::{Deserialize, Serialize};

use super::World;
use super::robot::{Robot, SavedRobot};
use crate::CompiledScene;
use crate::physics::SavedObject;

/// The state of a world at the end of a step. The scene is not in it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SavedWorld {
    options: Options,
    steps: u64,
    next_id: u64,
    unsettled: u64,
    objects: Vec<SavedObject>,
    robots: Vec<SavedRobot>,
}

/// Reason why a world cannot be saved.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SaveError {
    /// The engine moves a robot, and keeps part of its state to itself.
    #[error("robot {} of class {class} is moved by the engine (drive model `bodies`), which cannot be saved; expected another drive model", id.0)]
    OfEngine {
        /// The robot.
        id: PawnId,
        /// Its class.
        class: String,
    },
}

/// Reason why a saved world cannot go on.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum LoadError {
    /// The scene has no such class.
    #[error("robot {}: got the class {class}, expected one of {expected}", id.0)]
    UnknownClass {
        /// The robot.
        id: PawnId,
        /// Its class when it was saved.
        class: String,
        /// Classes of the scene.
        expected: String,
    },
    /// The class has other links or sensors than when the robot was saved.
    #[error("robot {}: its state does not fit the class {class} of this scene", id.0)]
    OtherClass {
        /// The robot.
        id: PawnId,
        /// Its class.
        class: String,
    },
    /// The map has other objects than when the world was saved.
    #[error("object {number}: its state does not fit the map of this scene")]
    OtherMap {
        /// The object's number in the map, from 0.
        number: usize,
    },
    /// Robots are not in the order of their numbers, or have numbers that are still to be given.
    #[error("robot {}: its number is out of order", id.0)]
    OutOfOrder {
        /// The robot.
        id: PawnId,
    },
}

impl World {
    /// Returns the state.
    ///
    /// # Errors
    /// If the engine moves a robot.
    pub fn save(&self) -> Result<SavedWorld, SaveError> {
        let save = |robot: &Robot| {
            let class = || robot.def().class.clone();
            robot.save().ok_or_else(|| SaveError::OfEngine { id: robot.id(), class: class() })
        };
        Ok(SavedWorld {
            options: self.options,
            steps: self.steps,
            next_id: self.next_id,
            unsettled: self.physics.unsettled_steps(),
            objects: self.physics.save_objects(),
            robots: self.robots.values().map(save).collect::<Result<_, _>>()?,
        })
    }

    /// Creates a world that goes on from a saved state with the same bits, if the scene is the same.
    ///
    /// # Errors
    /// If the state does not fit the scene.
    pub fn load(scene: impl Into<CompiledScene>, saved: &SavedWorld) -> Result<Self, LoadError> {
        let mut world = Self::new(scene, saved.options);
        (world.steps, world.next_id) = (saved.steps, saved.next_id);
        let objects = world.physics.load_objects(&saved.objects, saved.unsettled);
        objects.map_err(|number| LoadError::OtherMap { number })?;
        for robot in &saved.robots {
            let (id, class) = (robot.id, robot.class.clone());
            if id.0 >= saved.next_id || world.robots.last_key_value().is_some_and(|(last, _)| *last >= id) {
                return Err(LoadError::OutOfOrder { id });
            }
            let Some(compiled) = world.scene.robots().get(&class).cloned() else {
                let expected = world.scene.robots().keys().cloned().collect::<Vec<_>>().join(", ");
                return Err(LoadError::UnknownClass { id, class, expected });
            };
            let loaded = Robot::load(&mut world.physics, compiled, robot, saved.steps, saved.options);
            world.robots.insert(id, loaded.ok_or(LoadError::OtherClass { id, class })?);
        }
        Ok(world)
    }
}
