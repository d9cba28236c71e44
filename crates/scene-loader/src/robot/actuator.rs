//! `[[actuator]]` and `[[gripper]]`: groups of joints with a name on the wire.

use std::ops::Range;

use scene::{Actuator, Gripper, Link, check};
use serde::Deserialize;

use crate::document::{Document, Table, Vector};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ActuatorEntry {
    name: String,
    joints: Vec<String>,
    #[serde(default)]
    tip: Vector,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct GripperEntry {
    name: String,
    joints: Vec<String>,
    open: Vec<f64>,
    closed: Vec<f64>,
}

/// Reads the actuators; returns none if not all links could be read.
pub(super) fn read_actuators<'a>(
    document: &mut Document<'a>,
    root: &mut Table<'a>,
    links: &[Link],
    complete: bool,
) -> Vec<Actuator> {
    let entries = document.list::<ActuatorEntry>(root, "actuator").into_iter().filter(|_| complete);
    let mut actuators = Vec::new();
    for (span, ActuatorEntry { name, joints, tip }) in entries {
        let Some(numbers) = find(document, &span, &joints, links) else { continue };
        let actuator = Actuator { name, links: numbers, tip };
        document.wrong(&span, check::actuator(&actuator, links));
        actuators.push(actuator);
    }
    actuators
}

/// Reads the grippers; returns none if not all links could be read.
pub(super) fn read_grippers<'a>(
    document: &mut Document<'a>,
    root: &mut Table<'a>,
    links: &[Link],
    complete: bool,
) -> Vec<Gripper> {
    let entries = document.list::<GripperEntry>(root, "gripper").into_iter().filter(|_| complete);
    let mut grippers = Vec::new();
    for (span, GripperEntry { name, joints, open, closed }) in entries {
        let Some(numbers) = find(document, &span, &joints, links) else { continue };
        let gripper = Gripper { name, links: numbers, open, closed };
        document.wrong(&span, check::gripper(&gripper, links));
        grippers.push(gripper);
    }
    grippers
}

/// Returns the numbers of links by the names of their joints.
fn find(document: &mut Document, span: &Range<usize>, joints: &[String], links: &[Link]) -> Option<Vec<usize>> {
    let names = || links.iter().map(|link| link.name.as_str());
    joints.iter().map(|joint| document.one_of(span, "joints", joint, names())).collect()
}
