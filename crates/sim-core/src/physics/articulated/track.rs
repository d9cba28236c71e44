//! Contacts of a track.
//!
//! The belt of a track is the union of discs inside it. On a plane its load is on four of them along its lowest run, whose friction is that of
//! an even load ([`scene::LOADED`]). On other shapes the engine finds areas of contact (`area.rs`). Across the belt each contact is in the
//! middle, and moves to an edge as the track leans, as under a wheel.

use nalgebra::{Vector2, Vector3};
use rapier3d::math::{Pose as EnginePose, Vector};
use scene::{Belt, Disc, MountedWheel};

use super::super::convert;
use super::ArticulatedRobot;
use super::area::{Belted, Run};
use super::finding::{CandidateContact, MAX_PREDICTION};
use super::form::{Form, Surface};
use super::shape_contact::{Target, on_faces};
use super::wheel::{LEANING, Plane, SIDE, Touch};

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
            let normal = convert::from_vector(other_pose.rotation * half_space.normal);
            let place = convert::from_vector(other_pose.translation);
            let centre = convert::from_vector(at.translation);
            if normal.dot(&(centre - place)) > self.reach + prediction {
                return;
            }
            if normal.dot(&axle).abs() < SIDE {
                return found.extend(self.on_plane(at, &axle, (normal, place), prediction));
            }
        }
        let mut area = 0;
        on_faces(own, at, other, other_pose, prediction, |mut corners| {
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
        });
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

impl ArticulatedRobot {
    /// Replaces the corners of the areas on which each track lies by its contacts.
    pub(super) fn join_areas(&self, found: &mut Vec<CandidateContact>) {
        for (number, (surface, at)) in self.compiled.surfaces.iter().zip(&self.placed).enumerate() {
            let Form::Track(track) = surface.form else { continue };
            // Contacts with planes have their places already.
            let is_corner = |it: &mut CandidateContact| it.key.surface == number && it.touch.area.is_some();
            let corners: Vec<CandidateContact> = found.extract_if(.., is_corner).collect();
            let is_same = |one: &CandidateContact, other: &CandidateContact| {
                (one.key.other, one.touch.area) == (other.key.other, other.touch.area)
            };
            let areas = corners.chunk_by(is_same).map(<[CandidateContact]>::to_vec).collect();
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
