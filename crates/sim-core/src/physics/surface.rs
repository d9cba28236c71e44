//! Surfaces of contacts: shapes with a material, and the scene's table of materials.

use std::sync::{Arc, Mutex, PoisonError};

use rapier3d::math::Pose as EnginePose;
use rapier3d::prelude::*;
use scene::{Material, Pose};

use super::convert;
use super::identity::{Identity, Mark};

/// Materials by number. Copies share the numbers, so what is compiled for one world fits all worlds of a scene.
#[derive(Debug, Clone, Default)]
pub(crate) struct Materials {
    /// Materials of all copies. A copy locks them when it meets a material for the first time.
    all: Arc<Mutex<Arc<Vec<Material>>>>,
    /// Materials that this copy has met.
    known: Arc<Vec<Material>>,
}

impl Materials {
    /// Returns the number of a material. Its first use adds it to the table.
    fn number(&mut self, material: &Material) -> u32 {
        let place = |all: &[Material]| all.iter().position(|known| known == material);
        let number = place(&self.known).unwrap_or_else(|| {
            let mut all = self.all.lock().unwrap_or_else(PoisonError::into_inner);
            let number = place(&all).unwrap_or_else(|| {
                Arc::make_mut(&mut all).push(material.clone());
                all.len() - 1
            });
            self.known = all.clone();
            number
        });
        number as u32
    }

    /// Meets the materials that copies have added.
    pub(crate) fn update(&mut self) {
        self.known = self.all.lock().unwrap_or_else(PoisonError::into_inner).clone();
    }

    /// Returns a material by its number.
    pub(super) fn get(&self, number: u32) -> Option<&Material> {
        self.known.get(number as usize)
    }

    /// Returns the material of a collider's surface.
    pub(super) fn of(&self, collider: &Collider) -> &Material {
        &self.known[Mark::of(collider).material as usize]
    }
}

/// A template of colliders. All worlds and robots share its shape.
#[derive(Clone)]
pub(super) struct Surface {
    builder: ColliderBuilder,
    material: u32,
}

impl Surface {
    /// Builds a massless surface at a pose in its parent's frame. The engine averages the coefficients of both sides of a contact, as
    /// [`Material::pair`] does.
    pub(super) fn new(shape: SharedShape, pose: &Pose, material: &Material, materials: &mut Materials) -> Self {
        let builder = ColliderBuilder::new(shape)
            .position(convert::pose(pose))
            .density(0.0)
            .friction(material.friction)
            .friction_combine_rule(CoefficientCombineRule::Average)
            .restitution(material.restitution)
            .restitution_combine_rule(CoefficientCombineRule::Average);
        Self { builder, material: materials.number(material) }
    }

    /// Returns the shape, and its pose in the parent's frame.
    pub(super) fn placed(&self) -> (SharedShape, EnginePose) {
        (self.builder.shape.clone(), self.builder.position)
    }

    /// Builds a collider that is marked with an identity.
    pub(super) fn collider(&self, identity: Identity) -> ColliderBuilder {
        let mark = Mark { identity, material: self.material };
        self.builder.clone().user_data(mark.to_bits())
    }
}
