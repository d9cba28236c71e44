//! Contacts of a Mecanum wheel's rollers without a body for each roller, with the same geometry.

use nalgebra::{Matrix3, Vector2, Vector3};
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
    /// Cosine of the angle between a roller and a surface within which they are tested.
    sector: f64,
    /// Rollers in the frame of the wheel.
    rollers: Vec<Roller>,
}

/// A roller in the frame of its wheel.
#[derive(Debug, Clone)]
struct Roller {
    pose: Pose,
    /// Unit vector along its axis.
    axis: Vector3<f64>,
    /// Unit vector from the hub to its middle.
    direction: Vector3<f64>,
}

impl Roller {
    fn new(pose: Pose) -> Self {
        let direction = pose.translation.vector.try_normalize(0.0).unwrap_or_default();
        Self { pose, axis: pose.rotation * Vector3::x(), direction }
    }
}

impl RollerRing {
    /// Builds the ring of a wheel.
    pub(super) fn new(rollers: &Rollers, wheel_radius: f64) -> Self {
        let half_width = rollers.half_length_at(rollers.last_phase, wheel_radius) * libm::cos(rollers.angle)
            + (wheel_radius - rollers.axis_circle);
        Self {
            shape: RollerShape::new(rollers, wheel_radius),
            reach: Vector2::new(wheel_radius, half_width).norm(),
            sector: libm::cos(rollers.last_phase + MARGIN),
            rollers: (0..rollers.count).map(|index| Roller::new(rollers.pose(index))).collect(),
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
        if let Some(half_space) = shape.as_halfspace() {
            let normal = frame.rotation * convert::from_vector(half_space.normal);
            let height = normal.dot(&(hub.translation.vector - frame.translation.vector));
            return self.touch_plane(hub, angle, prediction, normal, height, contacts);
        }
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

    /// Adds the contacts with a plane, given by its normal and the height of the hub over it, in closed form. It does what
    /// [`Self::touch_part`] does, in the frame of the wheel, where the rollers stand still.
    fn touch_plane(
        &self,
        hub: &Pose,
        angle: f64,
        prediction: f64,
        normal: Vector3<f64>,
        height: f64,
        contacts: &mut Vec<Touch>,
    ) {
        if height > self.reach + prediction {
            return;
        }
        let axes = hub.rotation.to_rotation_matrix().into_inner();
        let (sin, cos) = libm::sincos(angle);
        let [ahead, axle, down] = [axes.column(0), axes.column(1), axes.column(2)];
        let wheel = Matrix3::from_columns(&[ahead * cos + down * sin, axle.into_owned(), down * cos - ahead * sin]);
        let toward = -wheel.tr_mul(&normal);
        for (index, Roller { pose, axis, .. }) in self.facing(toward) {
            let along = self.shape.farthest_along(toward.dot(axis));
            let (centre, radius) = (pose.translation.vector + axis * along, self.shape.radius_at(along));
            let gap = height - toward.dot(&centre) - radius;
            if gap > prediction {
                continue;
            }
            let point = hub.translation.vector + wheel * (centre + toward * (radius + gap / 2.0));
            let roller = Some(RollerTouch { index, axis: wheel * axis, radius });
            contacts.push(Touch { roller, ..Touch::new(normal, point, gap) });
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
        let Some((gap, normal)) = distance(part, centre) else { return };
        if gap > self.reach + prediction {
            return;
        }
        let turn = nalgebra::UnitQuaternion::from_axis_angle(&-Vector3::y_axis(), angle);
        let wheel = hub * turn;
        let toward = wheel.rotation.inverse() * -convert::from_vector(normal);
        for (index, Roller { pose, .. }) in self.facing(toward) {
            let pose = wheel * pose;
            if let Some(touch) = touch_part(&self.shape, &convert::pose(&pose), part, constraints, prediction) {
                found(index, &pose, touch);
            }
        }
    }

    /// Returns the rollers that a surface in a direction can touch, with their numbers. The direction is in the frame of the wheel.
    fn facing(&self, toward: Vector3<f64>) -> impl Iterator<Item = (usize, &Roller)> {
        let least = self.sector * toward.xz().norm();
        let faces = move |roller: &Roller| roller.direction.dot(&toward) >= least || toward.y.abs() >= FACING;
        self.rollers.iter().enumerate().filter(move |(_, roller)| faces(roller))
    }

    fn contact(&self, frame: &Pose, index: usize, roller: &Pose, touch: contact::Touch) -> Touch {
        let normal = convert::from_vector(touch.normal);
        let axis = roller.rotation * Vector3::x();
        let radius = self.shape.radius_at(touch.along);
        let gap = touch.gap;
        let point = roller.translation.vector + axis * touch.along - normal * (radius + gap / 2.0);
        let point = (frame * nalgebra::Point3::from(point)).coords;
        let roller = Some(RollerTouch { index, axis: frame.rotation * axis, radius });
        Touch { roller, ..Touch::new(frame.rotation * normal, point, gap) }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_4, PI};

    use rand::{RngExt, SeedableRng};
    use rand_chacha::ChaCha8Rng;
    use rapier3d::parry::shape::{Cuboid, HalfSpace};

    use super::*;

    /// Returns the contacts of the ring with a shape, by their rollers.
    fn touches(ring: &RollerRing, hub: &Pose, angle: f64, shape: &dyn Shape, frame: &Pose) -> Vec<Touch> {
        let mut found = Vec::new();
        ring.touch(hub, angle, 0.01, shape, &convert::pose(frame), &mut found);
        found.sort_by_key(|touch| touch.roller.map(|roller| roller.index));
        found
    }

    #[test]
    fn a_plane_is_touched_as_the_top_of_a_box() {
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        let (plane, block) = (HalfSpace::new(-Vector::Z), Cuboid::new(Vector::splat(5.0)));
        let (mut seen, mut several) = (0, 0);
        for lean in [FRAC_PI_4, -FRAC_PI_4] {
            let material = scene::Material::default();
            let rollers = Rollers {
                count: 6,
                axis_circle: 0.036,
                angle: lean,
                first_roller: 0.4,
                last_phase: PI / 5.0,
                mass: 0.1,
                damping: 0.0,
                bearing_friction: 0.0,
                material,
            };
            let ring = RollerRing::new(&rollers, 0.05);
            for _ in 0..500 {
                let turn = |most: f64, rng: &mut ChaCha8Rng| rng.random_range(-most..most);
                // Upright, leaning, and on its side.
                let tilt = [turn(1.6, &mut rng), turn(0.3, &mut rng), turn(PI, &mut rng)];
                let hub = scene::pose([0.0, 0.0, -rng.random_range(0.03..0.07)], tilt);
                let (angle, sloped) = (turn(20.0, &mut rng), [turn(0.2, &mut rng), turn(0.2, &mut rng), 0.0]);
                let frame = scene::pose([0.0; 3], sloped);
                let on_plane = touches(&ring, &hub, angle, &plane, &frame);
                // The top of the box is the plane; its z points down, too.
                let below = frame * scene::pose([0.0, 0.0, 5.0], [0.0; 3]);
                let on_box = touches(&ring, &hub, angle, &block, &below);
                assert_eq!(on_plane.len(), on_box.len(), "{hub} {angle}");
                for (one, other) in on_plane.iter().zip(&on_box) {
                    let (Some(roller), Some(its)) = (one.roller, other.roller) else { panic!("a roller touches") };
                    assert_eq!(roller.index, its.index);
                    let off = [one.point - other.point, one.normal - other.normal, roller.axis - its.axis];
                    assert!(off.iter().all(|off| off.amax() < 1e-9), "{one:?}, {other:?}");
                    assert!((one.gap - other.gap).abs() < 1e-9 && (roller.radius - its.radius).abs() < 1e-9);
                }
                seen += on_plane.len();
                several += usize::from(on_plane.len() > 1);
            }
        }
        assert!(seen > 500 && several > 100, "{seen} contacts, {several} times several");
    }
}
