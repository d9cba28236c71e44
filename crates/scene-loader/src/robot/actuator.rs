//! `[[actuator]]` and `[[gripper]]`: groups of joints with a name on the wire. `[[tool_changer]]`: a coupling with a tool. `[[vacuum]]`: a suction
//! cup.

use std::ops::Range;

use scene::{Actuator, Gripper, Link, Object, Shape, Solid, Tool, ToolChanger, Vacuum, check};
use serde::Deserialize;

use super::joint::find_link;
use crate::document::{Document, Table, Vector};
use crate::materials::Materials;

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

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ToolChangerEntry {
    name: String,
    link: Option<String>,
    #[serde(default)]
    position: Vector,
    #[serde(default)]
    direction: Vector,
    #[serde(default = "tolerance")]
    position_tolerance: f64,
    #[serde(default = "tolerance")]
    angle_tolerance: f64,
    tool: Option<ToolEntry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct VacuumEntry {
    name: String,
    link: Option<String>,
    #[serde(default)]
    position: Vector,
    #[serde(default)]
    direction: Vector,
    #[serde(default = "reach")]
    reach: f64,
    force: f64,
    tool: Option<String>,
}

/// The tool that a changer holds at first: a box, whose pose is in the changer's frame.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ToolEntry {
    name: String,
    #[serde(rename = "type")]
    kind: String,
    mass: f64,
    #[serde(default)]
    position: Vector,
    #[serde(default)]
    rotation: Vector,
    size: Vector,
    material: String,
}

/// Returns the default tolerance, m and rad (DefaultUSAR.ini:498-501).
fn tolerance() -> f64 {
    0.5
}

/// Returns the default reach of a vacuum, m (DefaultUSAR.ini:503, `SuctionLength` of VacuumCup).
fn reach() -> f64 {
    0.02
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

/// Reads the tool changers; returns none if not all links could be read.
pub(super) fn read_tool_changers<'a>(
    document: &mut Document<'a>,
    root: &mut Table<'a>,
    materials: &Materials,
    links: &[Link],
    complete: bool,
) -> Vec<ToolChanger> {
    let entries = document.list::<ToolChangerEntry>(root, "tool_changer").into_iter().filter(|_| complete);
    let mut changers = Vec::new();
    for (span, entry) in entries {
        let tool = entry.tool.map(|tool| {
            let ToolEntry { name, kind, mass, position, rotation, size, material } = tool;
            let material = document.material(&span, &material, materials);
            Tool {
                kind,
                object: Object {
                    solid: Solid { name, shape: Shape::Box { size }, position, rotation, material },
                    mass,
                },
            }
        });
        let Some(link) = find_link(document, &span, "link", entry.link.as_deref(), links, complete) else { continue };
        let changer = ToolChanger {
            name: entry.name,
            link,
            position: entry.position,
            direction: entry.direction,
            position_tolerance: entry.position_tolerance,
            angle_tolerance: entry.angle_tolerance,
            tool,
        };
        document.wrong(&span, check::tool_changer(&changer, links));
        changers.push(changer);
    }
    changers
}

/// Reads the vacuums; returns none if not all links could be read.
pub(super) fn read_vacuums<'a>(
    document: &mut Document<'a>,
    root: &mut Table<'a>,
    links: &[Link],
    complete: bool,
) -> Vec<Vacuum> {
    let entries = document.list::<VacuumEntry>(root, "vacuum").into_iter().filter(|_| complete);
    let mut vacuums = Vec::new();
    for (span, entry) in entries {
        let VacuumEntry { name, link, position, direction, reach, force, tool } = entry;
        let Some(link) = find_link(document, &span, "link", link.as_deref(), links, complete) else { continue };
        let vacuum = Vacuum { name, link, position, direction, reach, force, tool };
        document.wrong(&span, check::vacuum(&vacuum, links));
        vacuums.push(vacuum);
    }
    vacuums
}

/// Returns the numbers of links by the names of their joints.
fn find(document: &mut Document, span: &Range<usize>, joints: &[String], links: &[Link]) -> Option<Vec<usize>> {
    let names = || links.iter().map(|link| link.name.as_str());
    joints.iter().map(|joint| document.one_of(span, "joints", joint, names())).collect()
}
