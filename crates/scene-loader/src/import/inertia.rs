//! Repair of impossible masses and inertias.

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Point3};
use scene::check::{MASS_RATIO, PART_MASS};
use urdf_rs::{Inertia, JointType, Link, Robot};

use super::bounds_of;
use crate::source::Source;
use crate::urdf;

/// Density of a link without a mass, of the box around its shapes, kg/m³. Robots have 200 to 700.
const DENSITY: f64 = 500.0;
/// Range of the mass of a link without a mass, kg.
const LEAST_MASS: f64 = 0.01;
const MOST_MASS: f64 = 1000.0;
/// Least edge of the box whose inertia a link gets, m.
const LEAST_EDGE: f64 = 0.01;
/// Margin above the least mass that the greatest ratio of masses allows.
const MARGIN: f64 = 1.01;

/// Replaces inertias that no body can have, and gives a mass to links that move and have none.
pub(super) fn repair(source: &Source, robot: &mut Robot, replaced: &mut Vec<String>) {
    for link in &mut robot.links {
        let mass = link.inertial.mass.value;
        if mass != 0.0 && mass < PART_MASS.least {
            replaced.push(format!("link {}: its mass of {mass} kg is taken as none", link.name));
            link.inertial.mass.value = 0.0;
        } else if let Some(wrong) = wrong_inertia(link) {
            let edges = set_inertia(source, link);
            replaced.push(format!("link {}: {wrong}: it gets that of a box of {edges}", link.name));
        }
    }
    for group in groups(robot) {
        if group.iter().all(|&number| robot.links[number].inertial.mass.value == 0.0) {
            let with_shape = group.iter().copied().find(|&number| bounds_of(source, &robot.links[number]).is_some());
            let Some(number) = with_shape.or(group.first().copied()) else { continue };
            let link = &mut robot.links[number];
            let volume = bounds_of(source, link).map_or(0.0, |bounds| edges(bounds).iter().product());
            let mass = (volume * DENSITY).clamp(LEAST_MASS, MOST_MASS);
            link.inertial.mass.value = mass;
            link.inertial.origin = urdf_rs::Pose::default();
            if let Some([low, high]) = bounds_of(source, link) {
                *link.inertial.origin.xyz = nalgebra::center(&low, &high).into();
            }
            let edges = set_inertia(source, link);
            replaced.push(format!("link {}: no mass: it gets {mass:.3} kg and is a box of {edges}", link.name));
        }
    }
    raise_light(robot, replaced);
}

/// Raises masses of moving links that are too light beside the others.
fn raise_light(robot: &mut Robot, replaced: &mut Vec<String>) {
    let groups = groups(robot);
    let mass = |robot: &Robot, group: &[usize]| -> f64 {
        group.iter().map(|&number| robot.links[number].inertial.mass.value).sum()
    };
    let most = groups.iter().map(|group| mass(robot, group)).fold(0.0, f64::max);
    let least = MARGIN * most / MASS_RATIO;
    for group in &groups {
        let own = mass(robot, group);
        if own >= least {
            continue;
        }
        for &number in group {
            let inertial = &mut robot.links[number].inertial;
            let times = least / own;
            inertial.mass.value *= times;
            let Inertia { ixx, ixy, ixz, iyy, iyz, izz } = &mut inertial.inertia;
            [ixx, ixy, ixz, iyy, iyz, izz].into_iter().for_each(|moment| *moment *= times);
        }
        if let Some(&first) = group.first() {
            let name = &robot.links[first].name;
            replaced.push(format!("link {name}: its mass of {own} kg is taken as {least:.6} kg, as others are heavy"));
        }
    }
}

/// Returns the problem of a link's inertia; `None` if it is sound, or if the link has no mass.
fn wrong_inertia(link: &Link) -> Option<String> {
    let part = urdf::part(link, &Isometry3::identity())?;
    let wrong = scene::check::part(&part).into_iter().find(|problem| problem.starts_with("`inertia`"))?;
    Some(wrong.split(": expected").next().unwrap_or_default().to_owned())
}

/// Gives a link the inertia of a box around its shapes, or of a ball of water if it has none. Returns the edges, in words.
fn set_inertia(source: &Source, link: &mut Link) -> String {
    let mass = link.inertial.mass.value;
    let [x, y, z] = match bounds_of(source, link) {
        Some(bounds) => edges(bounds),
        None => [(mass / 1000.0).cbrt().max(LEAST_EDGE); 3],
    };
    let moment = |a: f64, b: f64| mass / 12.0 * (a * a + b * b);
    link.inertial.origin.rpy = urdf_rs::Vec3([0.0; 3]);
    link.inertial.inertia =
        Inertia { ixx: moment(y, z), iyy: moment(x, z), izz: moment(x, y), ixy: 0.0, ixz: 0.0, iyz: 0.0 };
    format!("{x:.3} x {y:.3} x {z:.3} m")
}

fn edges([low, high]: [Point3<f64>; 2]) -> [f64; 3] {
    (high - low).map(|edge| edge.max(LEAST_EDGE)).into()
}

/// Returns the numbers of the links that move as one, each list beginning with the one on a joint. The first list is the body.
fn groups(robot: &Robot) -> Vec<Vec<usize>> {
    let numbers: BTreeMap<&str, usize> =
        robot.links.iter().enumerate().map(|(at, it)| (it.name.as_str(), at)).collect();
    let held = robot.joints.iter().filter(|joint| is_held(joint));
    let ends = |joint: &urdf_rs::Joint| {
        Some((*numbers.get(joint.child.link.as_str())?, *numbers.get(joint.parent.link.as_str())?))
    };
    let parents: BTreeMap<usize, usize> = held.filter_map(ends).collect();
    // The tree was checked, so each link reaches the root.
    let leader = |link: usize| {
        let above = std::iter::successors(Some(link), |link| parents.get(link).copied());
        above.take(robot.links.len()).last().unwrap_or(link)
    };
    let mut groups: Vec<Vec<usize>> = Vec::new();
    let leaders: Vec<usize> = (0..robot.links.len()).map(leader).collect();
    for link in (0..robot.links.len()).filter(|&link| leaders[link] == link) {
        let others = (0..robot.links.len()).filter(|&other| other != link && leaders[other] == link);
        groups.push(std::iter::once(link).chain(others).collect());
    }
    groups
}

/// True for a joint that the loader holds.
pub(super) fn is_held(joint: &urdf_rs::Joint) -> bool {
    let equal = joint.limit.lower == joint.limit.upper;
    match joint.joint_type {
        JointType::Continuous | JointType::Spherical => false,
        JointType::Revolute | JointType::Prismatic => equal,
        JointType::Fixed | JointType::Floating | JointType::Planar => true,
    }
}
