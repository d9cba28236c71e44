//! Surfaces of contacts: shapes with a material, and the scene's table of materials.

use rapier3d::math::Pose as EnginePose;
use rapier3d::prelude::*;
use scene::{Material, Pose};

use super::convert;
use super::identity::{Identity, Mark};

/// Materials by number.
#[derive(Debug, Clone, Default)]
pub(crate) struct Materials(Vec<Material>);

impl Materials {
    /// Returns the number of a material. Its first use adds it to the table.
    fn number(&mut self, material: &Material) -> u32 {
        let known = self.0.iter().position(|known| known == material);
        known.unwrap_or_else(|| {
            self.0.push(material.clone());
            self.0.len() - 1
        }) as u32
    }

    /// Returns a material by its number.
    pub(super) fn get(&self, number: u32) -> Option<&Material> {
        self.0.get(number as usize)
    }

    /// Returns the material of a collider's surface.
    pub(super) fn of(&self, collider: &Collider) -> &Material {
        &self.0[Mark::of(collider).material as usize]
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
