//! Drawing of what a robot's camera sees, for a thread. No picture changes the world.

use std::sync::Arc;

use picture::{Image, SENSOR_SIZE, Stage};
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
}

/// Draws a picture. `prepared` keeps the scene for the next one.
pub(crate) fn image_of(job: &Job, prepared: &mut Option<(CompiledScene, Stage)>) -> Option<Image> {
    if prepared.as_ref().is_none_or(|(scene, _)| !std::ptr::eq(scene.def(), job.scene.def())) {
        *prepared = Some((job.scene.clone(), Stage::new(job.scene.def())));
    }
    let (_, stage) = prepared.as_ref()?;
    picture::of_sensor(stage, job.scene.def(), &job.snapshot, &job.sensed, SENSOR_SIZE)
}
