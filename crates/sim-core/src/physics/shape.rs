//! Shapes of solids, and outlines of wheels.

use std::f64::consts::FRAC_PI_2;

use rapier3d::math::{Pose as EnginePose, Rotation};
use rapier3d::parry::shape::{HalfSpace, TriMeshFlags};
use rapier3d::prelude::*;

use scene::MountedWheel;

use super::convert;
use super::mesh::{Shell, shell};

/// Meshes whose triangles hold a body on the side that their normals point to, and on both. Edges between triangles of one plane hold nothing.
const ONE_SIDED: TriMeshFlags = TriMeshFlags::FIX_INTERNAL_EDGES;
const TWO_SIDED: TriMeshFlags = TriMeshFlags::FIX_INTERNAL_EDGES_TWO_SIDED;

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
            let Shell { triangles, is_solid } = shell(vertices, triangles);
            let flags = if is_solid { ONE_SIDED } else { TWO_SIDED };
            SharedShape::trimesh_with_flags(points(vertices), triangles, flags).unwrap_or_else(|_| dot())
        }
        scene::Shape::HeightField(field) => match field.surface() {
            // Below a field is ground.
            scene::Shape::Mesh { vertices, triangles } => {
                SharedShape::trimesh_with_flags(points(&vertices), triangles, ONE_SIDED).unwrap_or_else(|_| dot())
            }
            other => shared(&other),
        },
    }
}

/// True if a mesh holds bodies on both sides of its triangles.
pub(super) fn is_two_sided(mesh: &TriMesh) -> bool {
    mesh.flags().contains(TWO_SIDED)
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
