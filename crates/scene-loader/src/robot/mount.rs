//! `[[mount]]`: actuators put on a robot.

use std::ops::Range;

use scene::check::MAX_LINKS;
use scene::{RobotDef, pose};
use serde::Deserialize;

use super::Definition;
use super::joint::find_link;
use crate::document::{Document, Table, Vector};
use crate::equipment::MAX_ITEMS;

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
pub(crate) struct Mount {
    span: Range<usize>,
    actuator: RobotDef,
    name: String,
    link: Option<String>,
    position: Vector,
    direction: Vector,
}

/// Loads an actuator for a definition.
pub(crate) fn load(definition: &Definition, class: &str) -> Result<RobotDef, String> {
    let depth = definition.depth.map_or(0, |depth| depth + 1);
    if depth > MOST_DEEP {
        return Err(format!("an actuator on {depth} others: expected at most {MOST_DEEP}"));
    }
    (definition.others.actuator)(definition.source, class, definition.changes, depth).map_err(|error| error.to_string())
}

/// Reads the mounts with their actuators. Those with a problem are left out.
///
/// Actuators that carry each other could be very many. So reading ends at more links than a robot can have, or a few mistakes.
pub(crate) fn read<'a>(definition: &Definition, document: &mut Document<'a>, root: &mut Table<'a>) -> Vec<Mount> {
    let (mut mounts, mut links) = (Vec::new(), 0);
    let mut entries = document.list::<MountEntry>(root, "mount");
    if let Some((span, _)) = entries.get(MAX_ITEMS) {
        document.problem(span, format_args!("more mounts than {MAX_ITEMS}: expected at most so many"));
        entries.truncate(MAX_ITEMS);
    }
    for (span, MountEntry { class, name, link, position, direction }) in entries {
        match load(definition, &class) {
            Ok(actuator) => {
                let name = name.unwrap_or(class);
                links += actuator.links.len();
                mounts.push(Mount { span, actuator, name, link, position, direction });
            }
            Err(error) => {
                document.problem(&span, error);
                links += if definition.depth.is_some() { 2 * MAX_LINKS } else { MAX_LINKS / 4 };
            }
        }
        // The robot's check reports that these are too many.
        if links >= 2 * MAX_LINKS {
            break;
        }
    }
    mounts
}

/// Puts actuators on a robot. `complete` is true if all of its links could be read.
pub(crate) fn mount(document: &mut Document, robot: &mut RobotDef, mounts: Vec<Mount>, complete: bool) {
    for Mount { span, actuator, name, link, position, direction } in mounts {
        let Some(link) = find_link(document, &span, "link", link.as_deref(), &robot.links, complete) else { continue };
        robot.mount(&actuator, &name, link, &pose(position, direction));
    }
}
