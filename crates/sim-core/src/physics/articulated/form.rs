//! Surfaces of a body, and the geometry that finds their contacts.

use nalgebra::Vector3;
use rapier3d::math::Pose as EnginePose;
use rapier3d::parry::bounding_volume::Aabb;
use rapier3d::prelude::SharedShape;
use scene::Material;

use super::super::convert;
use super::super::surface::Surface as ColliderSurface;
use super::tyre::Tread;

/// A part of a link that makes contacts.
pub(super) struct Surface {
    pub(super) link: usize,
    pub(super) form: Form,
    pub(super) material: Material,
    /// The engine's template of its collider.
    pub(super) seen: ColliderSurface,
    pub(super) shape: SharedShape,
    /// Pose in the frame of the link.
    pub(super) pose: EnginePose,
    /// Bounding box in its own axes.
    pub(super) around: Aabb,
    /// Centre and half extents of its bounding box in the axes of the link, m.
    pub(super) middle: Vector3<f64>,
    pub(super) half: Vector3<f64>,
    /// Number of the wheel that it belongs to.
    pub(super) wheel: Option<usize>,
    /// Tyre, if it is a wheel that has one.
    pub(super) tread: Option<Tread>,
}

/// The geometry that finds its contacts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Form {
    /// The engine's geometry.
    Solid,
    /// A wheel about the y axis of its link.
    Wheel {
        /// m.
        radius: f64,
        /// m.
        half_width: f64,
    },
    /// The rollers of a wheel, by the number of their ring.
    Rollers(usize),
    /// A track, by its number.
    Track(usize),
    /// A ball about the origin of its link.
    Ball {
        /// m.
        radius: f64,
    },
}

impl Surface {
    pub(super) fn new(
        link: usize,
        form: Form,
        material: &Material,
        seen: ColliderSurface,
        wheel: Option<usize>,
    ) -> Self {
        let (shape, pose) = seen.placed();
        let (around, on_link) = (shape.compute_local_aabb(), shape.compute_aabb(&pose));
        let (middle, half) = (convert::from_vector(on_link.center()), convert::from_vector(on_link.half_extents()));
        Self { link, form, material: material.clone(), seen, shape, pose, around, middle, half, wheel, tread: None }
    }
}
