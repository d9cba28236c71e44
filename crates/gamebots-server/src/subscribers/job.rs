//! Drawing of what a robot's camera sees, for a thread. No picture changes the world.

use std::sync::Arc;

use picture::{Drawer, Image, SENSOR_SIZE};
use scene::{Sensed, Snapshot};
use sim_core::{CompiledScene, World};

/// A picture to draw.
pub(crate) struct Job {
    scene: CompiledScene,
    pub(crate) snapshot: Arc<Snapshot>,
    pub(crate) sensed: Sensed,
}

impl Job {
    /// Creates the picture of a camera's reading in a snapshot of the same time.
    pub(crate) fn new(world: &World, sensed: &Sensed, snapshot: Arc<Snapshot>) -> Self {
        Self { scene: world.scene().clone(), snapshot, sensed: sensed.clone() }
    }

    /// Draws the picture.
    pub(crate) fn draw(&self, drawer: &mut Drawer<CompiledScene>) -> Option<Image> {
        drawer.of_sensor(&self.scene, &self.snapshot, &self.sensed, SENSOR_SIZE)
    }
}
