//! Surfaces that touch: shapes with a material, and the table of a scene's materials.

use rapier3d::math::Pose as EnginePose;
use rapier3d::prelude::*;
use scene::{Material, Pose};

use super::convert;
use super::identity::{Identity, Mark};

/// Materials by number.
#[derive(Debug, Default)]
pub(crate) struct Materials(Vec<Material>);

impl Materials {
    /// The number of a material, which enters the table with its first use.
    fn number(&mut self, material: &Material) -> u32 {
        let known = self.0.iter().position(|known| known == material);
        known.unwrap_or_else(|| {
            self.0.push(material.clone());
            self.0.len() - 1
        }) as u32
    }

    /// The material of a collider's surface.
    pub(super) fn of(&self, collider: &Collider) -> &Material {
        &self.0[Mark::of(collider).material as usize]
    }
}

/// A template of colliders: every world and robot has its own, with one shape.
#[derive(Clone)]
pub(super) struct Surface {
    builder: ColliderBuilder,
    material: u32,
}

impl Surface {
    /// A shape at a pose of its parent, without mass of its own. Both sides of a contact average, which is
    /// [`Material::pair`].
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

    /// Its shape, and the pose of that on what carries it.
    pub(super) fn placed(&self) -> (SharedShape, EnginePose) {
        (self.builder.shape.clone(), self.builder.position)
    }

    /// A collider of it, marked with an identity.
    pub(super) fn collider(&self, identity: Identity) -> ColliderBuilder {
        let mark = Mark { identity, material: self.material };
        self.builder.clone().user_data(mark.to_bits())
    }
}
