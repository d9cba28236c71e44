//! Contacts of a robot with itself: an arm, or what it holds, does not pass through the base that carries it.
//!
//! Surfaces are simpler than the robot's parts, and overlap near joints. So a surface touches the base only if it is apart from it in every
//! pose that one joint alone can reach: the limits of a robot's joints keep it from hitting itself there. Links that a joint connects to the
//! base never touch it, nor do wheels. Links of an arm pass through each other.

use std::sync::Arc;

use articulated::{Body, Tree};
use rapier3d::math::Pose as EnginePose;
use rapier3d::parry::bounding_volume::BoundingVolume;
use rapier3d::parry::query;
use scene::Pose;

use super::super::convert;
use super::form::{Form, Surface};
use super::link_pose;

/// Least distance between two surfaces that count as apart, m.
const APART: f64 = 0.002;
/// Least and most poses of each joint, from end to end, in which surfaces must be apart, and the way between two, rad or m.
const POSES: [f64; 2] = [8.0, 64.0];
const WAY: f64 = 0.1;
/// Most pairs of surfaces of a robot. The first ones touch.
const MAX_PAIRS: usize = 512;

/// Returns the pairs of a robot's surfaces that may touch. `joints` are those that move to positions, each with its degree of freedom and its
/// limits, rad or m.
pub(super) fn pairs(
    tree: &Arc<Tree>,
    surfaces: &[Surface],
    joints: impl Iterator<Item = (usize, [f64; 2])>,
) -> Vec<(usize, usize)> {
    let links = tree.links();
    let solids = surfaces.iter().enumerate().filter(|(_, it)| it.form == Form::Solid);
    let (base, carried): (Vec<_>, Vec<_>) = solids.partition(|(_, it)| it.link == 0);
    let moved = carried.iter().filter(|(_, it)| links[it.link].parent != 0);
    let mut pairs: Vec<(usize, usize)> =
        moved.flat_map(|&(one, _)| base.iter().map(move |&(other, _)| (one, other))).collect();
    if pairs.is_empty() {
        return pairs;
    }
    let mut body = Body::new(tree.clone(), Pose::identity());
    let rest = body.motion();
    keep_apart(surfaces, &body, &mut pairs);
    for (dof, [least, most]) in joints {
        let last = ((most - least) / WAY).ceil().clamp(POSES[0], POSES[1]) as usize;
        for pose in 0..=last {
            let position = least + (most - least) * pose as f64 / last as f64;
            body.velocity_mut().fill(0.0);
            body.velocity_mut()[dof] = position;
            body.advance(1.0);
            keep_apart(surfaces, &body, &mut pairs);
            body.set_motion(&rest);
        }
    }
    pairs.truncate(MAX_PAIRS);
    pairs
}

/// Keeps the pairs of surfaces that are apart.
fn keep_apart(surfaces: &[Surface], body: &Body, pairs: &mut Vec<(usize, usize)>) {
    let placed = surfaces.iter().map(|surface| {
        let pose: EnginePose = convert::pose(&link_pose(body, surface.link)) * surface.pose;
        (pose, surface.shape.compute_aabb(&pose).loosened(APART))
    });
    let placed: Vec<_> = placed.collect();
    pairs.retain(|&(one, other)| {
        let ((own, own_box), (its, its_box)) = (&placed[one], &placed[other]);
        let shapes = (&*surfaces[one].shape, &*surfaces[other].shape);
        !own_box.intersects(its_box)
            || query::distance(own, shapes.0, its, shapes.1).is_ok_and(|it| it.distance > APART)
    });
}
