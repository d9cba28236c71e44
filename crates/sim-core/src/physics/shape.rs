//! Shapes and mass of solids, wheels and rollers.

use std::f64::consts::{FRAC_PI_2, PI};

use rapier3d::math::{Pose as EnginePose, Rotation};
use rapier3d::parry::shape::{HalfSpace, TriMeshFlags};
use rapier3d::prelude::*;

use super::roller::RollerShape;
use super::{convert, with_material};
use crate::scene::{self, Material, RobotDef, Rollers};

/// Width of the crown of a plain wheel, m.
const CROWN_WIDTH: f64 = 0.004;
/// How far the crown stands out, m.
const CROWN_HEIGHT: f64 = 0.002;

/// A collider at a place of its parent, without mass of its own.
pub(super) fn collider(shape: &scene::Shape, pose: &scene::Pose, material: &Material) -> ColliderBuilder {
    let shape = shared_shape(shape);
    with_material(ColliderBuilder::new(shape), material).position(convert::pose(pose)).density(0.0)
}

/// A hull or mesh that has no volume or no triangle becomes a dot; `scene-loader` refuses such before.
fn shared_shape(shape: &scene::Shape) -> SharedShape {
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

/// The surface of a convex hull as a mesh, for those who draw it. `None` for points in one plane.
pub fn hull_surface(corners: &[[f64; 3]]) -> Option<scene::Shape> {
    let points: Vec<Vector> = corners.iter().map(|&point| convert::vector(point)).collect();
    let (vertices, triangles) = rapier3d::parry::transformation::try_convex_hull(&points).ok()?;
    let vertices = vertices.iter().map(|vertex| vertex.to_array()).collect();
    Some(scene::Shape::Mesh { vertices, triangles })
}

/// The outlines of everything that a robot is made of, in its frame: its solids, its wheels as plain discs, its casters.
pub(super) fn parts(robot: &RobotDef) -> Vec<(scene::Pose, SharedShape)> {
    let solids = robot.solids.iter().map(|solid| (solid.pose(), shared_shape(&solid.shape)));
    let wheels = robot.wheels.iter().map(|wheel| {
        let shape = match wheel.drive {
            Some(_) => SharedShape::cylinder(wheel.width / 2.0, wheel.radius),
            None => SharedShape::ball(wheel.radius),
        };
        (wheel.pose(0.0), shape)
    });
    solids.chain(wheels).collect()
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

/// Moments of inertia of a roller along the x axis, as a solid of the exact profile, kg m².
pub(super) fn roller_inertia(rollers: &Rollers, wheel_radius: f64) -> [f64; 3] {
    let (axial, transverse) = Profile { rollers, wheel_radius }.inertia_per_mass();
    [axial, transverse, transverse].map(|inertia| inertia * rollers.mass)
}

/// The outline of a Mecanum roller (Gfrerrer, "Geometry and kinematics of the Mecanum wheel").
struct Profile<'a> {
    rollers: &'a Rollers,
    wheel_radius: f64,
}

impl Profile<'_> {
    /// Place on the axis and radius of the outline at a phase of the contact.
    fn at(&self, phase: f64) -> (f64, f64) {
        (self.rollers.half_length_at(phase, self.wheel_radius), self.rollers.radius_at(phase, self.wheel_radius))
    }

    /// Moments of inertia about the axis and across it for a mass of 1, m², by summing thin discs.
    fn inertia_per_mass(&self) -> (f64, f64) {
        const DISCS: u32 = 200;
        let (mut volume, mut axial, mut transverse) = (0.0, 0.0, 0.0);
        let mut edge = self.at(-self.rollers.last_phase);
        for disc in 1..=DISCS {
            let next = self.at(self.rollers.last_phase * (2.0 * f64::from(disc) / f64::from(DISCS) - 1.0));
            let (thickness, along, radius) = (next.0 - edge.0, (next.0 + edge.0) / 2.0, (next.1 + edge.1) / 2.0);
            let disc_volume = PI * radius * radius * thickness;
            volume += disc_volume;
            axial += disc_volume * radius * radius / 2.0;
            transverse += disc_volume * (radius * radius / 4.0 + along * along);
            edge = next;
        }
        (axial / volume, transverse / volume)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// R = 50, a = 36 mm, six rollers at 45 degrees: computed independently (fidelity.md 3.2, 3.3).
    #[test]
    fn the_profile_has_the_known_numbers() {
        let material = Material::default();
        let rollers = Rollers {
            count: 6,
            axis_circle: 0.036,
            angle: PI / 4.0,
            first_roller: 0.0,
            last_phase: PI / 6.0,
            mass: 1.0,
            damping: 0.0,
            material,
        };
        let profile = Profile { rollers: &rollers, wheel_radius: 0.05 };
        let (end, end_radius) = profile.at(rollers.last_phase);
        assert!((2.0 * end - 0.06475).abs() < 1e-5, "length {end}");
        assert!((end_radius - 0.00789).abs() < 1e-5, "end radius {end_radius}");
        let (axial, transverse) = profile.inertia_per_mass();
        assert!((axial - 79.1e-6).abs() < 0.2e-6, "axial {axial}");
        assert!((transverse - 300.4e-6).abs() < 0.5e-6, "transverse {transverse}");
    }
}
