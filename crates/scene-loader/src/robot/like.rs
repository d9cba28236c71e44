//! `like`: a class that is another one with other names, items, battery or additional visuals.

use scene::RobotDef;

use super::visual::read_visuals;
use super::{Definition, mount, read_battery, read_dialect, read_reported_steering, read_sensors};
use crate::document::{Document, Table};

/// Keys that may stand beside `like`.
const KEYS: &str =
    "like, names, description, dialect, one_side_drives, reported_steering, battery, sensor, visual, mount";

/// Reads a class that is like another, a shipped one. Each key that the file has replaces that of the other class, the sensors as a whole.
/// Visuals and mounts are added to those of the other class.
pub(super) fn read<'a>(
    definition: &Definition<'a>,
    mut document: Document<'a>,
    mut root: Table<'a>,
) -> Option<RobotDef> {
    let (span, other) = document.section::<String>(&mut root, "like").ok()??;
    let equipment = definition.changes.equipment;
    let replaced = equipment.replaces(definition.equipped_as);
    // What replaces the items of this class replaces those of the other class, too.
    let as_itself = replaced.then_some(definition.equipped_as);
    let mut robot = match (definition.others.class)(&other, definition.changes, as_itself) {
        Ok(robot) => robot,
        Err(error) => {
            document.problem(&span, error);
            return None;
        }
    };
    robot.class = definition.class.to_owned();
    let _: Option<Vec<String>> = document.optional(&mut root, "names");
    if let Some(description) = document.optional(&mut root, "description") {
        robot.description = description;
    }
    if root.has("dialect") {
        robot.speaks_ut2004 = read_dialect(&mut document, &mut root);
    }
    if let Some(one_side_drives) = document.optional(&mut root, "one_side_drives") {
        robot.one_side_drives = one_side_drives;
    }
    if root.has("reported_steering") {
        robot.reported_steering = read_reported_steering(&mut document, &mut root);
    }
    if root.has("battery") {
        robot.battery = read_battery(&mut document, &mut root);
    }
    if replaced {
        root.forget(&["sensor", "mount"]);
    }
    if root.has("sensor") {
        let wheels = robot.driven().count();
        robot.sensors = read_sensors(&mut document, &mut root, equipment, &robot.links, Some(wheels), true);
    }
    read_visuals(definition.source, &mut document, &mut root, &mut robot.links, true);
    let mounts = mount::read(definition, &mut document, &mut root);
    document.finish(root, KEYS);
    mount::mount(&mut document, &mut robot, mounts, true);
    if !replaced {
        equipment.put_on(definition, &mut robot, true, document.problems());
    }
    document.as_a_whole(|| scene::check::robot(&robot));
    Some(robot)
}
