//! Robots whose forward axis is not x.

use nalgebra::{Isometry3, Vector3};
use urdf_rs::Robot;

use super::{isometry, origin};

/// Turns a robot about the vertical through its root, rad, counterclockwise from above.
pub(crate) fn turn(robot: &mut Robot, yaw: f64) {
    let is_child = |name: &String| robot.joints.iter().any(|joint| joint.child.link == *name);
    let Some(root) = robot.links.iter().position(|link| !is_child(&link.name)) else { return };
    let rotation = Isometry3::rotation(Vector3::z() * yaw);
    let turned = |pose: &mut urdf_rs::Pose| {
        *pose = origin(&(rotation * isometry(pose)));
    };
    let link = &mut robot.links[root];
    turned(&mut link.inertial.origin);
    link.visual.iter_mut().for_each(|visual| turned(&mut visual.origin));
    link.collision.iter_mut().for_each(|collision| turned(&mut collision.origin));
    let of_root = robot.joints.iter_mut().filter(|joint| joint.parent.link == robot.links[root].name);
    of_root.for_each(|joint| turned(&mut joint.origin));
}
