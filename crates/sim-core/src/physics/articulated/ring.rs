//! Contacts of a Mecanum wheel's rollers without a body for each roller, with the same geometry.

use nalgebra::{Vector2, Vector3};
use rapier3d::parry::bounding_volume::Aabb;
use rapier3d::parry::math::{Pose as EnginePose, Vector};
use rapier3d::parry::query::details::NormalConstraints;
use rapier3d::parry::shape::Shape;
use scene::{Pose, Rollers};

use super::super::contact::{self, distance, touch_part};
use super::super::convert;
use super::super::roller::RollerShape;
use super::wheel::{RollerTouch, Touch};

/// Angle beside the direction to a surface within which rollers are tested, beyond a roller's half sector, rad. A contact is up to 21 mm
/// beside the hub. Where a surface ends obliquely, its point nearest to the hub is up to 15 mm before or behind it.
const MARGIN: f64 = 0.3;
/// Distance below which two contacts are one, m.
const SAME_PLACE: f64 = 1e-5;
/// Cosine of the normal with the axle above which a surface can touch any roller of the wheel.
const FACING: f64 = 0.5;

/// The rollers of a wheel as geometry.
#[derive(Debug, Clone)]
pub(super) struct RollerRing {
    shape: RollerShape,
    /// Largest distance of a point of the ring from the hub, m.
    reach: f64,
    /// Half the sector that a roller covers, rad.
    last_phase: f64,
    /// Angle of the first roller past the front, rad.
    first_roller: f64,
    /// Poses of the rollers in the frame of the wheel.
    rollers: Vec<Pose>,
}

impl RollerRing {
    /// Builds the ring of a wheel.
    pub(super) fn new(rollers: &Rollers, wheel_radius: f64) -> Self {
        let half_width = rollers.half_length_at(rollers.last_phase, wheel_radius) * libm::cos(rollers.angle)
            + (wheel_radius - rollers.axis_circle);
        Self {
            shape: RollerShape::new(rollers, wheel_radius),
            reach: Vector2::new(wheel_radius, half_width).norm(),
            last_phase: rollers.last_phase,
            first_roller: rollers.first_roller,
            rollers: (0..rollers.count).map(|index| rollers.pose(index)).collect(),
        }
    }

    /// Returns the number of rollers.
    pub(super) fn len(&self) -> usize {
        self.rollers.len()
    }

    /// Adds every contact of the ring with a shape at a pose, in world axes. `hub` is the pose of the wheel at angle 0.
    pub(super) fn touch(
        &self,
        hub: &Pose,
        angle: f64,
        prediction: f64,
        shape: &dyn Shape,
        frame: &EnginePose,
        contacts: &mut Vec<Touch>,
    ) {
        let before = contacts.len();
        let frame = convert::from_pose(frame);
        let hub = frame.inv_mul(hub);
        let mut touch =
            |part_pose: Option<&EnginePose>, part: &dyn Shape, constraints: Option<&dyn NormalConstraints>| {
                let part_frame = part_pose.map(convert::from_pose);
                let local = part_frame.map_or(hub, |pose| pose.inv_mul(&hub));
                let frame = part_frame.map_or(frame, |pose| frame * pose);
                self.touch_part(&local, angle, prediction, part, constraints, |index, roller, touch| {
                    let contact = self.contact(&frame, index, roller, touch);
                    // Two triangles that share an edge find the same contact there.
                    if !contacts[before..].iter().any(|known| (known.point - contact.point).amax() < SAME_PLACE) {
                        contacts.push(contact);
                    }
                });
            };
        let Some(composite) = shape.as_composite_shape() else {
            touch(None, shape, None);
            return;
        };
        let reach = Vector::splat(self.reach + prediction);
        let near = Aabb::from_half_extents(convert::vector(hub.translation.vector), reach);
        for part in composite.bvh().intersect_aabb(&near) {
            composite.map_part_at(part, &mut touch);
        }
    }

    /// Finds the contacts with one convex part, in its frame.
    fn touch_part(
        &self,
        hub: &Pose,
        angle: f64,
        prediction: f64,
        part: &dyn Shape,
        constraints: Option<&dyn NormalConstraints>,
        mut found: impl FnMut(usize, &Pose, contact::Touch),
    ) {
        let centre = convert::vector(hub.translation.vector);
        let nearest = match part.as_halfspace() {
            Some(half_space) => Some((half_space.normal.dot(centre), half_space.normal)),
            None => distance(part, centre),
        };
        let Some((gap, normal)) = nearest else { return };
        if gap > self.reach + prediction {
            return;
        }
        let toward = hub.rotation.inverse() * -convert::from_vector(normal);
        let direction = libm::atan2(toward.z, toward.x);
        let pitch = std::f64::consts::TAU / self.rollers.len() as f64;
        let turn = nalgebra::UnitQuaternion::from_axis_angle(&-Vector3::y_axis(), angle);
        let wheel = hub * turn;
        for (index, roller) in self.rollers.iter().enumerate() {
            let off = self.first_roller + pitch * index as f64 + angle - direction;
            // Half a turn either way is the far side of the wheel, so it does not matter how ties are rounded.
            let off = off - std::f64::consts::TAU * (off / std::f64::consts::TAU).round_ties_even();
            if off.abs() > self.last_phase + MARGIN && toward.y.abs() < FACING {
                continue;
            }
            let pose = wheel * roller;
            if let Some(touch) = touch_part(&self.shape, &convert::pose(&pose), part, constraints, prediction) {
                found(index, &pose, touch);
            }
        }
    }

    fn contact(&self, frame: &Pose, index: usize, roller: &Pose, touch: contact::Touch) -> Touch {
        let normal = convert::from_vector(touch.normal);
        let axis = roller.rotation * Vector3::x();
        let radius = self.shape.radius_at(touch.along);
        let gap = touch.gap;
        let point = roller.translation.vector + axis * touch.along - normal * (radius + gap / 2.0);
        Touch {
            point: (frame * nalgebra::Point3::from(point)).coords,
            normal: frame.rotation * normal,
            gap,
            share: 1.0,
            roller: Some(RollerTouch { index, axis: frame.rotation * axis, radius }),
        }
    }
}
