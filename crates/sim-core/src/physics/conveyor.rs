//! Conveyors: boxes that stand fast and whose surfaces move. Contacts take the velocity of the surface as their target, so it carries what
//! stands on it. The engine's robots do not feel it.

use nalgebra::Vector3;
use rapier3d::prelude::*;

use super::{Physics, WAKING_REACH};

/// A conveyor of a world.
#[derive(Clone)]
pub(super) struct Conveyor {
    pub(super) collider: ColliderHandle,
    /// Velocity of the surface at the factor 1, world axes, m/s.
    velocity: Vector3<f64>,
    /// Multiple of the velocity at which it runs.
    factor: f64,
}

impl Conveyor {
    /// Builds the conveyors of a map from the numbers of their solids and their velocities. `solids` are the colliders of its solids, in order.
    pub(super) fn all(conveyors: &[(usize, Vector3<f64>)], solids: &[ColliderHandle]) -> Vec<Self> {
        let conveyor = |&(solid, velocity): &(usize, Vector3<f64>)| {
            let collider = *solids.get(solid)?;
            Some(Self { collider, velocity, factor: 1.0 })
        };
        conveyors.iter().filter_map(conveyor).collect()
    }

    /// Returns the velocity of the surface where it has a normal, m/s. No surface moves along its normal.
    pub(super) fn drift(&self, normal: &Vector3<f64>) -> Vector3<f64> {
        let velocity = self.velocity * self.factor;
        velocity - normal * normal.dot(&velocity)
    }
}

impl Physics {
    /// Returns the factors at which the conveyors run, in the order of the map.
    pub(crate) fn conveyor_factors(&self) -> impl Iterator<Item = f64> {
        self.conveyors.iter().map(|conveyor| conveyor.factor)
    }

    /// Takes the factors of a saved world.
    pub(crate) fn load_conveyors(&mut self, factors: &[f64]) {
        self.conveyors.iter_mut().zip(factors).for_each(|(conveyor, &factor)| conveyor.factor = factor);
    }

    /// Sets a conveyor to a multiple of its velocity on the map. Robots and objects on it find their contacts anew, and objects wake.
    pub(crate) fn set_conveyor(&mut self, number: usize, factor: f64) {
        let Some(conveyor) = self.conveyors.get_mut(number) else { return };
        conveyor.factor = factor;
        let Some(collider) = self.world.colliders.get(conveyor.collider) else { return };
        let around = collider.compute_aabb().loosened(WAKING_REACH);
        for object in self.objects.iter_mut().filter(|object| object.is_near(&around)) {
            object.wake();
        }
        self.is_changed = true;
    }
}
