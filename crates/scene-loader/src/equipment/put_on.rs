//! Items of equipment put on robots.

use scene::RobotDef;

use super::{Equipment, Kind, Set};
use crate::document::{Document, Table};
use crate::problem::Problems;
use crate::robot::{Definition, mount, read_battery, read_sensors};

impl Equipment {
    /// Puts the items of the definition's class on a robot.
    pub(crate) fn put_on(
        &self,
        definition: &Definition,
        robot: &mut RobotDef,
        complete: bool,
        problems: &mut Problems,
    ) {
        match &self.0 {
            Kind::Shipped => {}
            Kind::Set(set) => set.put_on(definition, robot, complete, problems),
            Kind::Inis(inis) => inis.put_on(definition, robot, problems),
        }
    }
}

impl Set {
    fn put_on(&self, definition: &Definition, robot: &mut RobotDef, complete: bool, problems: &mut Problems) {
        const KEYS: &str = "sensor, mount, battery";
        let Some((class, _)) = self.classes.get(&definition.equipped_as.to_lowercase()) else { return };
        let Some((mut document, mut root)) = Document::parse(&self.file, &self.text, problems) else { return };
        let Some(mut table): Option<Table> = document.table(&mut root, class) else { return };
        let wheels = robot.driven().count();
        let settings = definition.changes.equipment;
        robot.sensors = read_sensors(&mut document, &mut table, settings, &robot.links, Some(wheels), complete);
        if let Some(battery) = read_battery(&mut document, &mut table) {
            robot.battery = Some(battery);
        }
        let mounts = mount::read(definition, &mut document, &mut table);
        document.finish(table, KEYS);
        mount::mount(&mut document, robot, mounts, complete);
    }
}
