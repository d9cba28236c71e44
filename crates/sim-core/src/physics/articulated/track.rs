//! Contacts of a track.
//!
//! The belt of a track is the union of discs inside it. On a plane its load is on four of them along its lowest run, whose friction is that of
//! an even load ([`scene::LOADED`]). On other shapes the engine finds the area of contact, which gets four contacts along the run alike.
//! Across the belt each is in the middle, and moves to an edge as the track leans, as under a wheel.

use nalgebra::{Vector2, Vector3};
use rapier3d::math::{Pose as EnginePose, Vector};
use rapier3d::parry::shape::Shape;
use scene::{Belt, Disc, LOADED, MountedWheel};

use super::super::convert;
use super::form::Surface;
use super::shape_contact::on_faces;
use super::wheel::{LEANING, SIDE, Touch};

/// Length of an area along the run below which it has one contact, m.
const SHORT: f64 = 1e-3;

/// A track, in the frame of its link: the origin is the sprocket's middle.
pub(super) struct Track {
    belt: Belt,
    /// Numbers of the rollers that the belt lies on, in their order around it.
    around: Vec<usize>,
    half_width: f64,
    /// Distance of its farthest point from the origin, m.
    reach: f64,
}

impl Track {
    /// Compiles the track of a wheel; `None` if it has no belt.
    pub(super) fn new(wheel: &MountedWheel) -> Option<Self> {
        let mut belt = wheel.belt.clone()?;
        let [x, _, z] = wheel.position;
        belt.rollers.iter_mut().for_each(|roller| *roller = [roller[0] - x, roller[1] - z, roller[2]]);
        let half_width = wheel.width / 2.0;
        let reach = belt.rollers.iter().map(|[x, z, radius]| Vector2::new(*x, *z).norm() + radius).fold(0.0, f64::max);
        let reach = Vector2::new(reach, half_width).norm();
        Some(Self { around: belt.around(), belt, half_width, reach })
    }

    /// Adds the contacts with a shape, each at a pose, within a distance, m, in world axes.
    pub(super) fn touch(
        &self,
        own: &Surface,
        at: &EnginePose,
        other: &dyn Shape,
        other_pose: &EnginePose,
        prediction: f64,
        found: &mut Vec<Touch>,
    ) {
        let axle = convert::from_vector(at.rotation * Vector::Y);
        if let Some(half_space) = other.as_halfspace() {
            let normal = convert::from_vector(other_pose.rotation * half_space.normal);
            let place = convert::from_vector(other_pose.translation);
            let centre = convert::from_vector(at.translation);
            if normal.dot(&(centre - place)) > self.reach + prediction {
                return;
            }
            if normal.dot(&axle).abs() < SIDE {
                let discs = self.lowest_run(at, &normal, &axle);
                let touches = discs.into_iter().map(|disc| self.on_plane(at, &axle, disc, normal, place));
                let mut touches: Vec<Touch> = touches.filter(|touch| touch.gap <= prediction).collect();
                if let [alone] = &mut touches[..] {
                    alone.share = Belt::ALONE;
                }
                found.extend(touches);
                return;
            }
        }
        on_faces(own, at, other, other_pose, prediction, |corners| self.spread(&axle, &corners, found));
    }

    fn lowest_run(&self, at: &EnginePose, normal: &Vector3<f64>, axle: &Vector3<f64>) -> Vec<Disc> {
        let across = (normal - axle * normal.dot(axle)).try_normalize(1e-9).unwrap_or(*normal);
        let down = convert::from_vector(at.rotation.inverse() * convert::vector(-across));
        self.belt.lowest_run(&self.around, [down.x, down.z])
    }

    /// Returns the contact of a disc with a plane through a point.
    fn on_plane(
        &self,
        at: &EnginePose,
        axle: &Vector3<f64>,
        disc: Disc,
        normal: Vector3<f64>,
        place: Vector3<f64>,
    ) -> Touch {
        let lean = normal.dot(axle);
        let toward = (axle * lean - normal).try_normalize(1e-9).unwrap_or(-normal);
        let [x, z] = disc.middle;
        let middle = convert::from_vector(*at * convert::vector([x, 0.0, z]));
        let along = (-lean / LEANING).clamp(-1.0, 1.0) * self.half_width;
        let point = middle + axle * along + toward * disc.radius;
        Touch { normal, point, gap: normal.dot(&(point - place)), share: disc.share, roller: None }
    }

    /// Adds contacts along an area of contact, which is given by its corners.
    fn spread(&self, axle: &Vector3<f64>, corners: &[Touch], found: &mut Vec<Touch>) {
        let Some(first) = corners.first() else { return };
        let normal = first.normal;
        let Some(along) = normal.cross(axle).try_normalize(1.0 - SIDE) else { return found.extend(corners) };
        let across = along.cross(&normal);
        // Places along the run and across it, and gaps.
        let flat: Vec<[f64; 3]> = corners
            .iter()
            .map(|corner| {
                let arm = corner.point - first.point;
                [along.dot(&arm), across.dot(&arm), corner.gap]
            })
            .collect();
        let (least, most) = flat.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), corner| {
            (least.min(corner[0]), most.max(corner[0]))
        });
        let alone = [(0.5, Belt::ALONE)];
        let loaded: &[(f64, f64)] = if most - least < SHORT { &alone } else { &LOADED };
        for &(part, share) in loaded {
            let place = least + (most - least) * part;
            let [aside, gap] = middle_of(section(&flat, place));
            let on_other = first.point - normal * first.gap + along * place + across * aside;
            found.push(Touch { normal, point: on_other + normal * gap, gap, share, roller: None });
        }
    }
}

/// Returns the ends of an area's section at a place along the run: places across it, and gaps.
fn section(corners: &[[f64; 3]], place: f64) -> [[f64; 2]; 2] {
    let mut ends: Option<[[f64; 2]; 2]> = None;
    let mut add = |end: [f64; 2]| {
        let [left, right] = ends.get_or_insert([end; 2]);
        if end[0] < left[0] {
            *left = end;
        } else if end[0] > right[0] {
            *right = end;
        }
    };
    for (number, one) in corners.iter().enumerate() {
        for other in &corners[number..] {
            let (from, to) = (place - one[0], other[0] - one[0]);
            let part = if to.abs() < SHORT { 0.0 } else { from / to };
            let is_near = from.abs() < SHORT || (place - other[0]).abs() < SHORT;
            if to.abs() < SHORT && is_near {
                add([one[1], one[2]]);
                add([other[1], other[2]]);
            } else if (0.0..=1.0).contains(&part) && to.abs() >= SHORT {
                add([one[1] + (other[1] - one[1]) * part, one[2] + (other[2] - one[2]) * part]);
            }
        }
    }
    ends.unwrap_or([[0.0; 2]; 2])
}

/// Returns the place of the contact on a section, and its gap: the middle, or nearer to the deeper end as the track leans.
fn middle_of([left, right]: [[f64; 2]; 2]) -> [f64; 2] {
    let width = right[0] - left[0];
    if width < SHORT {
        return if left[1] < right[1] { left } else { right };
    }
    let lean = (right[1] - left[1]) / width;
    let part = 0.5 - (lean / LEANING).clamp(-1.0, 1.0) / 2.0;
    [left[0] + width * part, left[1] + (right[1] - left[1]) * part]
}
