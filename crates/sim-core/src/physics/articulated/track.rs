//! Contacts of a track.
//!
//! The belt of a track is the union of discs inside it. On a plane its load is on four of them along its lowest run, whose friction is that of
//! an even load ([`scene::LOADED`]). On other shapes it has areas of contact (`area.rs`): over the face of a box in closed form, elsewhere as the
//! engine finds them. Across the belt each contact is in the middle, and moves to an edge as the track leans, as under a wheel.

use nalgebra::{Point3, Vector3};
use rapier3d::math::{Pose as EnginePose, Vector};
use rapier3d::parry::shape::Cuboid;
use scene::{Belt, Disc, MountedWheel};

use super::super::convert;
use super::ArticulatedRobot;
use super::area::{Areas, Belted, Run};
use super::finding::{CandidateContact, MAX_PREDICTION};
use super::form::{Form, Surface};
use super::shape_contact::{Target, on_faces};
use super::wheel::{LEANING, Plane, SIDE, Touch};

/// Height by which the lowest part of a belt over a face may be above that beside it, m.
const LEVEL: f64 = 1e-5;

/// Overlap beyond which another direction than the face's normal may be the shorter way out, m.
const DEEP: f64 = 0.002;

/// A track, in the frame of its link: the origin is the sprocket's middle.
pub(super) struct Track {
    belt: Belt,
    /// Numbers of the rollers that the belt lies on, in their order around it.
    around: Vec<usize>,
    half_width: f64,
}

impl Track {
    /// Compiles the track of a wheel; `None` if it has no belt.
    pub(super) fn new(wheel: &MountedWheel) -> Option<Self> {
        let mut belt = wheel.belt.clone()?;
        let [x, _, z] = wheel.position;
        belt.rollers.iter_mut().for_each(|roller| *roller = [roller[0] - x, roller[1] - z, roller[2]]);
        let half_width = wheel.width / 2.0;
        Some(Self { around: belt.around(), belt, half_width })
    }

    /// Adds the contacts with a shape, each at a pose, within a distance, m, in world axes. Of a fixed shape other than a plane it adds the
    /// corners of the areas of contact, which [`ArticulatedRobot::join_areas`] replaces.
    pub(super) fn touch(
        &self,
        own: &Surface,
        at: &EnginePose,
        target: &Target,
        prediction: f64,
        found: &mut Vec<Touch>,
    ) {
        let &Target { shape: other, pose: other_pose, is_fixed } = target;
        let axle = convert::from_vector(at.rotation * Vector::Y);
        if let Some(half_space) = other.as_halfspace() {
            let up = other_pose.rotation * half_space.normal;
            let normal = convert::from_vector(up);
            let place = convert::from_vector(other_pose.translation);
            let centre = convert::from_vector(at.translation);
            let down = at.rotation.inverse() * -up;
            if normal.dot(&(centre - place)) - self.reach(&convert::from_vector(down)) > prediction {
                return;
            }
            if normal.dot(&axle).abs() < SIDE {
                return found.extend(self.on_plane(at, &axle, (normal, place), prediction));
            }
        }
        let mut area = 0;
        let mut add = |mut corners: Vec<Touch>| {
            if is_fixed {
                corners.iter_mut().for_each(|corner| corner.area = Some(area));
                area += 1;
                return found.extend(corners);
            }
            corners.retain(|corner| corner.gap <= prediction);
            match corners.first().and_then(|corner| Run::new(corner, &axle)) {
                Some(run) => {
                    let outline: Vec<[f64; 3]> = corners.iter().map(|corner| run.flat(corner)).collect();
                    found.extend(run.spread(&outline, 1.0));
                }
                None => found.extend(corners),
            }
        };
        match other.as_cuboid().and_then(|cuboid| self.on_box(at, cuboid, other_pose, prediction)) {
            Some(corners) => add(corners),
            None => on_faces(own, at, other, other_pose, prediction, add),
        }
    }

    /// Returns the corners of the area over the face of a box that separates both most; none if it is farther away than a distance, m.
    /// Returns `None` if the belt's lowest part is not over that face, if the belt's side is, or if the overlap is deep: such contacts need the
    /// engine's search.
    fn on_box(&self, at: &EnginePose, cuboid: &Cuboid, box_pose: &EnginePose, prediction: f64) -> Option<Vec<Touch>> {
        let pose = convert::from_pose(&box_pose.inv_mul(at));
        let (middle, turn) = (pose.translation.vector, pose.rotation.to_rotation_matrix());
        let half = convert::from_vector(cuboid.half_extents);
        let height = |axis: usize, side: f64| {
            side * middle[axis] - self.reach(&(turn.matrix().row(axis).transpose() * -side)) - half[axis]
        };
        let faces = [0, 1, 2].into_iter().flat_map(|axis| [-1.0, 1.0].map(|side| (axis, side)));
        let (axis, side, height) = faces
            .map(|(axis, side)| (axis, side, height(axis, side)))
            .max_by(|one, other| one.2.total_cmp(&other.2))?;
        if height > prediction {
            return Some(Vec::new());
        }
        let (axle, mut normal) = (turn * Vector3::y(), Vector3::zeros());
        normal[axis] = side;
        if height < -DEEP || normal.dot(&axle).abs() >= SIDE {
            return None;
        }
        let toward = (axle * normal.dot(&axle) - normal).normalize();
        let down = turn.inverse() * toward;
        let run = self.belt.lowest_run(&self.around, [down.x, down.z]);
        let (first, last) = (run.first()?, run.last()?);
        let corner = |disc: &Disc, across: f64| {
            let [x, z] = disc.middle;
            middle + turn * Vector3::new(x, across * self.half_width, z) + toward * disc.radius
        };
        let outline = [(first, -1.0), (first, 1.0), (last, 1.0), (last, -1.0)].map(|(disc, side)| corner(disc, side));
        let mut outline = outline.to_vec();
        for across in [(axis + 1) % 3, (axis + 2) % 3] {
            outline = cut(outline, |point| half[across] - point[across]);
            outline = cut(outline, |point| half[across] + point[across]);
        }
        let gap = |point: &Vector3<f64>| side * point[axis] - half[axis];
        let least = outline.iter().map(gap).reduce(f64::min)?;
        if least > height + LEVEL {
            return None;
        }
        let frame = convert::from_pose(box_pose);
        let touch = |point: Vector3<f64>| Touch::new(frame * normal, (frame * Point3::from(point)).coords, gap(&point));
        Some(outline.into_iter().map(touch).collect())
    }

    /// Returns the distance of the farthest point along a direction from the origin, m.
    fn reach(&self, direction: &Vector3<f64>) -> f64 {
        self.belt.reach(&self.around, [direction.x, direction.z]) + direction.y.abs() * self.half_width
    }

    /// Returns the contacts of the lowest run with a plane, by its normal and a point, within a distance, m.
    fn on_plane(&self, at: &EnginePose, axle: &Vector3<f64>, plane: Plane, prediction: f64) -> Vec<Touch> {
        let discs =
            self.lowest_run(at, &plane.0, axle).into_iter().map(|disc| self.disc_on_plane(at, axle, disc, plane));
        let mut touches: Vec<Touch> = discs.filter(|touch| touch.gap <= prediction).collect();
        if let [alone] = &mut touches[..] {
            alone.share = Belt::ALONE;
        }
        touches
    }

    fn lowest_run(&self, at: &EnginePose, normal: &Vector3<f64>, axle: &Vector3<f64>) -> Vec<Disc> {
        let across = (normal - axle * normal.dot(axle)).try_normalize(1e-9).unwrap_or(*normal);
        let down = convert::from_vector(at.rotation.inverse() * convert::vector(-across));
        self.belt.lowest_run(&self.around, [down.x, down.z])
    }

    /// Returns the contact of a disc with a plane through a point.
    fn disc_on_plane(&self, at: &EnginePose, axle: &Vector3<f64>, disc: Disc, (normal, place): Plane) -> Touch {
        let lean = normal.dot(axle);
        let toward = (axle * lean - normal).try_normalize(1e-9).unwrap_or(-normal);
        let [x, z] = disc.middle;
        let middle = convert::from_vector(*at * convert::vector([x, 0.0, z]));
        let along = (-lean / LEANING).clamp(-1.0, 1.0) * self.half_width;
        let point = middle + axle * along + toward * disc.radius;
        Touch { share: disc.share, ..Touch::new(normal, point, normal.dot(&(point - place))) }
    }
}

/// Cuts off the part of a polygon where a linear function is negative.
fn cut(outline: Vec<Vector3<f64>>, inside: impl Fn(&Vector3<f64>) -> f64) -> Vec<Vector3<f64>> {
    if outline.iter().all(|point| inside(point) >= 0.0) {
        return outline;
    }
    let mut kept = Vec::with_capacity(outline.len() + 1);
    let next = outline.iter().cycle().skip(1);
    for (point, next) in outline.iter().zip(next) {
        let (here, there) = (inside(point), inside(next));
        if here >= 0.0 {
            kept.push(*point);
        }
        if (here < 0.0) != (there < 0.0) {
            kept.push(point + (next - point) * (here / (here - there)));
        }
    }
    kept
}

impl ArticulatedRobot {
    /// Replaces the corners of the areas on which each track lies by its contacts.
    pub(super) fn join_areas(&self, found: &mut Vec<CandidateContact>) {
        // Contacts with planes have their places already.
        let mut corners: Vec<CandidateContact> = found.extract_if(.., |it| it.touch.area.is_some()).collect();
        let key = |it: &CandidateContact| (it.key.surface, it.key.other, it.touch.area);
        let mut areas: Areas = Vec::new();
        for area in corners.chunk_by_mut(|one, other| key(one) == key(other)) {
            area.sort_by(|one, other| one.touch.gap.total_cmp(&other.touch.gap));
            areas.push(area);
        }
        for (number, (surface, at)) in self.compiled.surfaces.iter().zip(&self.placed).enumerate() {
            let Form::Track(track) = surface.form else { continue };
            let areas: Areas = areas.iter().copied().filter(|area| area[0].key.surface == number).collect();
            if areas.is_empty() {
                continue;
            }
            let track = &self.compiled.tracks[track];
            let axle = convert::from_vector(at.pose.rotation * Vector::Y);
            let prediction = at.prediction.min(MAX_PREDICTION);
            let on_plane = |plane: Plane| track.on_plane(&at.pose, &axle, plane, prediction);
            let belt = Belted { axle, width: 2.0 * track.half_width, prediction, on_plane: &on_plane };
            let before = found.len();
            for mut contact in belt.contacts(areas) {
                contact.key.number = found[before..].iter().filter(|it| it.key.other == contact.key.other).count();
                found.push(contact);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use rapier3d::math::Rotation;
    use rapier3d::parry::query;

    use super::super::super::shape;
    use super::*;

    const BOX: [f64; 3] = [0.3, 0.2, 0.05];
    const WIDTH: f64 = 0.08;
    const PREDICTION: f64 = 0.01;

    fn flipper() -> Track {
        let belt = Belt { rollers: vec![[0.0, 0.0, 0.06], [0.15, 0.0, 0.04]] };
        Track { around: belt.around(), belt, half_width: WIDTH / 2.0 }
    }

    proptest! {
        // The hull has flat corners of 15 degrees, which are up to 0.5 mm inside of the belt.
        #[test]
        fn the_area_on_a_box_is_as_near_as_the_engine_finds_it(
            place in [-0.4..0.4, -0.3..0.3, 0.08..0.16], turn in [-0.2..0.2, -3.0..3.0, -3.0..3.0],
        ) {
            let track = flipper();
            let cuboid = Cuboid::new(convert::vector(BOX));
            let box_pose = EnginePose::from_parts(convert::vector([1.0, 2.0, 3.0]), Rotation::from_rotation_x(0.3));
            let [x, y, z] = turn;
            let turn = Rotation::from_rotation_z(z) * Rotation::from_rotation_y(y) * Rotation::from_rotation_x(x);
            let at = box_pose * EnginePose::from_parts(convert::vector(place), turn);
            let hull = shape::shared(&track.belt.hull(WIDTH));
            let nearest = query::contact(&at, hull.as_ref(), &box_pose, &cuboid, 0.02);
            let nearest = nearest.expect("known shapes").map_or(0.02, |it| it.dist);
            if let Some(corners) = track.on_box(&at, &cuboid, &box_pose, PREDICTION) {
                let gap = corners.iter().map(|corner| corner.gap).fold(f64::INFINITY, f64::min);
                if corners.is_empty() {
                    prop_assert!(nearest > PREDICTION, "{nearest} m");
                } else {
                    prop_assert!((nearest - 6e-4..nearest + 1e-9).contains(&gap), "{gap} m, the engine {nearest} m");
                }
            }
        }
    }

    #[track_caller]
    fn check(place: [f64; 3], lean: f64, expected: Option<usize>) {
        let at = EnginePose::from_parts(convert::vector(place), Rotation::from_rotation_y(lean));
        let cuboid = Cuboid::new(convert::vector(BOX));
        let corners = flipper().on_box(&at, &cuboid, &EnginePose::IDENTITY, PREDICTION);
        assert_eq!(corners.map(|corners| corners.len()), expected);
    }

    #[test]
    fn a_belt_has_an_area_where_its_lowest_part_is_over_a_face() {
        let level = libm::asin(0.02 / 0.15);
        // On top, over a corner, over an end, beyond the box, above it.
        check([0.0, 0.0, 0.11], level, Some(4));
        check([0.2, 0.18, 0.11], level, Some(4));
        check([0.25, 0.0, 0.11], level, Some(4));
        check([0.6, 0.0, 0.11], level, Some(0));
        check([0.0, 0.0, 0.2], level, Some(0));
        // The sprocket is lower, beyond the edge: the edge meets the middle of the run.
        check([-0.35, 0.0, 0.09], 0.0, None);
        // The side of the belt faces the box.
        check([0.0, 0.24, 0.0], level, None);
    }
}
