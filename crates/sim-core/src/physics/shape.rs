//! Shapes of solids, and outlines of wheels.

use std::f64::consts::FRAC_PI_2;

use rapier3d::math::{Pose as EnginePose, Rotation};
use rapier3d::parry::shape::{HalfSpace, TriMeshFlags};
use rapier3d::prelude::*;

use scene::MountedWheel;

use super::convert;

/// Builds the engine's shape. A hull without volume, or a mesh without triangles, becomes a dot; `scene-loader` refuses these before.
pub(super) fn shared(shape: &scene::Shape) -> SharedShape {
    let points = |points: &[[f64; 3]]| points.iter().map(|&point| convert::vector(point)).collect::<Vec<_>>();
    let dot = || SharedShape::ball(1e-6);
    match shape {
        scene::Shape::HalfSpace => SharedShape::new(HalfSpace::new(-Vector::Z)),
        scene::Shape::Box { size: [x, y, z] } => SharedShape::cuboid(x / 2.0, y / 2.0, z / 2.0),
        scene::Shape::Cylinder { radius, length } => cylinder(*radius, *length, Rotation::from_rotation_x(FRAC_PI_2)),
        scene::Shape::Ball { radius } => SharedShape::ball(*radius),
        scene::Shape::Hull { points: corners } => SharedShape::convex_hull(&points(corners)).unwrap_or_else(dot),
        scene::Shape::Mesh { vertices, triangles } => {
            let flags = TriMeshFlags::MERGE_DUPLICATE_VERTICES | TriMeshFlags::FIX_INTERNAL_EDGES;
            SharedShape::trimesh_with_flags(points(vertices), triangles.clone(), flags).unwrap_or_else(|_| dot())
        }
        scene::Shape::HeightField(field) => shared(&field.surface()),
    }
}

/// Builds the outline of a wheel: a plain disc about the y axis, a ball for a caster, or the volume of a track.
pub(super) fn outline(wheel: &MountedWheel) -> SharedShape {
    match (wheel.drive, &wheel.belt) {
        (Some(_), Some(belt)) => shared(&belt.hull(wheel.width)),
        (Some(_), None) => SharedShape::cylinder(wheel.width / 2.0, wheel.radius),
        (None, _) => SharedShape::ball(wheel.radius),
    }
}

/// Builds a cylinder with a rotation. The engine's cylinders are along y.
fn cylinder(radius: f64, length: f64, rotation: Rotation) -> SharedShape {
    let cylinder = SharedShape::cylinder(length / 2.0, radius);
    SharedShape::compound(vec![(EnginePose::from_rotation(rotation), cylinder)])
}
