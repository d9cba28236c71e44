//! A world with a world controller.

use nalgebra::Vector3;
use scene::ObjectSnapshot;
use sim_core::{Options, PawnId, World};

use crate::{init, problems};

/// A world with a world controller.
pub struct Stage {
    /// The world.
    pub world: World,
    /// The controller.
    pub controller: PawnId,
}

impl Stage {
    /// Puts a controller into a world on a built-in map.
    pub fn new(map: &str, options: Options) -> Self {
        let mut world = World::new(scene_loader::load(map, &[]).expect("a map"), options);
        let controller = init(&mut world, "INIT {ClassName USARBotAPI.WorldController}");
        Self { world, controller }
    }

    /// Sends an order. Returns the problems with it.
    pub fn order(&mut self, text: &str) -> Vec<String> {
        problems(&mut self.world, self.controller, &format!("CONTROL {text}"))
    }

    /// Sends an order that has no problem.
    pub fn must(&mut self, text: &str) {
        assert_eq!(self.order(text), [""; 0], "{text}");
    }

    /// Returns an object.
    pub fn object(&self, name: &str) -> ObjectSnapshot {
        let object = self.world.objects().find(|object| object.def.solid.name == name);
        object.unwrap_or_else(|| panic!("no {name}"))
    }

    /// Returns the position of an object.
    pub fn at(&self, name: &str) -> Vector3<f64> {
        self.object(name).pose.translation.vector
    }
}
