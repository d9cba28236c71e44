//! Shapes of solids, wheels and rollers.

use std::f64::consts::FRAC_PI_2;

use rapier3d::math::{Pose as EnginePose, Rotation};
use rapier3d::parry::shape::{HalfSpace, TriMeshFlags};
use rapier3d::prelude::*;

use scene::{MountedWheel, Rollers};

use super::convert;
use super::roller::RollerShape;

/// Width of the crown of a plain wheel, m.
const CROWN_WIDTH: f64 = 0.004;
/// How far the crown stands out, m.
const CROWN_HEIGHT: f64 = 0.002;

/// A hull or mesh that has no volume or no triangle becomes a dot; `scene-loader` refuses such before.
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
    }
}

/// A wheel as a plain disc about the y axis, a caster as a ball.
pub(super) fn outline(wheel: &MountedWheel) -> SharedShape {
    match wheel.drive {
        Some(_) => SharedShape::cylinder(wheel.width / 2.0, wheel.radius),
        None => SharedShape::ball(wheel.radius),
    }
}

/// The engine's cylinders stand along y.
fn cylinder(radius: f64, length: f64, rotation: Rotation) -> SharedShape {
    let cylinder = SharedShape::cylinder(length / 2.0, radius);
    SharedShape::compound(vec![(EnginePose::from_rotation(rotation), cylinder)])
}

/// A plain wheel about the robot's y axis: a narrow crown that carries the load, so that it stands in the middle
/// of the wheel and not on either edge, and the whole width a little below it, for walls and kerbs.
pub(super) fn tread(radius: f64, width: f64) -> SharedShape {
    let cylinder = |radius: f64, width: f64| (EnginePose::IDENTITY, SharedShape::cylinder(width / 2.0, radius));
    SharedShape::compound(vec![cylinder(radius, CROWN_WIDTH.min(width)), cylinder(radius - CROWN_HEIGHT, width)])
}

/// A roller along the x axis.
pub(super) fn roller(rollers: &Rollers, wheel_radius: f64) -> SharedShape {
    SharedShape::new(RollerShape::new(rollers, wheel_radius))
}
