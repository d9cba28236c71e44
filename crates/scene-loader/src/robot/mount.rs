//! `[[mount]]`: actuators put on a robot.

use std::ops::Range;

use scene::{RobotDef, pose};
use serde::Deserialize;

use super::Definition;
use super::joint::find_link;
use crate::catalogue;
use crate::document::{Document, Table, Vector};

/// Largest number of actuators that carry each other. One of the industrial robots has two.
const MOST_DEEP: usize = 4;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MountEntry {
    class: String,
    /// Name on the wire; without one, the class.
    name: Option<String>,
    /// Link that carries it; without one, the body.
    link: Option<String>,
    #[serde(default)]
    position: Vector,
    #[serde(default)]
    direction: Vector,
}

/// An actuator and its place.
pub(super) struct Mount {
    span: Range<usize>,
    actuator: RobotDef,
    name: String,
    link: Option<String>,
    position: Vector,
    direction: Vector,
}

/// Reads the mounts with their actuators. Those with a problem are left out.
pub(super) fn read<'a>(definition: &Definition, document: &mut Document<'a>, root: &mut Table<'a>) -> Vec<Mount> {
    let depth = definition.depth.map_or(0, |depth| depth + 1);
    let mut mounts = Vec::new();
    for (span, MountEntry { class, name, link, position, direction }) in document.list::<MountEntry>(root, "mount") {
        if depth > MOST_DEEP {
            document.problem(&span, format_args!("an actuator on {depth} others: expected at most {MOST_DEEP}"));
            continue;
        }
        match catalogue::actuator(definition.source, &class, definition.overrides, depth) {
            Ok(actuator) => {
                let name = name.unwrap_or(class);
                mounts.push(Mount { span, actuator, name, link, position, direction });
            }
            Err(error) => document.problem(&span, error),
        }
    }
    mounts
}

/// Puts actuators on a robot. `complete` is true if all of its links could be read.
pub(super) fn mount(document: &mut Document, robot: &mut RobotDef, mounts: Vec<Mount>, complete: bool) {
    for Mount { span, actuator, name, link, position, direction } in mounts {
        let Some(link) = find_link(document, &span, "link", link.as_deref(), &robot.links, complete) else { continue };
        robot.mount(&actuator, &name, link, &pose(position, direction));
    }
}
