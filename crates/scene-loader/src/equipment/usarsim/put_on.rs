//! Items of ini files put on robots.

use scene::check::{self, MAX_LINKS};
use scene::{Battery, Link, RobotDef, SensorDef, pose, sensor};

use super::super::classes::{self, Row};
use super::super::default_battery;
use super::{Inis, Item, Kind, SCAN_INTERVAL, config};
use crate::problem::Problems;
use crate::robot::{Definition, mount};

impl Inis {
    /// Puts the items of the definition's class on a robot.
    pub(in crate::equipment) fn put_on(&self, definition: &Definition, robot: &mut RobotDef, problems: &mut Problems) {
        let number = |key: &str| self.values.get(&(classes::BATTERY, key.to_lowercase()))?.parse::<f64>().ok();
        let (energy, life) = (number(classes::MAX_ENERGY), number(classes::LIFE));
        let changed = |battery: Battery| Battery {
            max_energy: energy.unwrap_or(battery.max_energy),
            life: life.unwrap_or(battery.life),
        };
        // Other numbers are the robot's own.
        if robot.battery == Some(default_battery()) {
            robot.battery = robot.battery.map(changed);
        }
        let Some(carried) = self.carried(definition.equipped_as) else { return };
        let is_battery = |item: &Item| matches!(item.kind, Kind::Sensor(row) if row.here == Some(classes::BATTERY));
        if carried.items.iter().any(is_battery) {
            robot.battery = Some(changed(default_battery()));
        } else if carried.replaces {
            robot.battery = None;
        }
        if let Some(life) = carried.battery_life {
            robot.battery = Some(Battery { life, ..changed(default_battery()) });
        }
        if let Some(battery) = robot.battery {
            check::battery(&battery).into_iter().for_each(|it| self.problem(problems, carried.place, it));
        }
        for item in &carried.items {
            let link = self.link(item, robot);
            match &item.kind {
                Kind::Sensor(row) => match self.sensor(row, item, link) {
                    Ok(sensor) => {
                        check::sensor(&sensor).into_iter().for_each(|it| self.problem(problems, item.place, it));
                        robot.sensors.push(sensor);
                    }
                    Err(message) => self.problem(problems, item.place, message),
                },
                Kind::Mount(class) => match mount::load(definition, class) {
                    // The robot's check reports that these are too many.
                    Ok(_) if robot.links.len() > MAX_LINKS => return,
                    Ok(actuator) => robot.mount(&actuator, &item.name, link, &pose(item.position, item.direction)),
                    Err(message) => {
                        self.problem(problems, item.place, message);
                        return;
                    }
                },
            }
        }
    }

    /// Returns the link that an item is on: the one of its parent, or the body, as in USARSim, if there is no such part.
    fn link(&self, item: &Item, robot: &mut RobotDef) -> usize {
        if item.parent.is_empty() {
            return 0;
        }
        let is_parent = |name: &str| name.eq_ignore_ascii_case(&item.parent);
        let has = |link: &Link| is_parent(&link.name) || link.parts.iter().any(|part| is_parent(&part.name));
        robot.links.iter().position(has).unwrap_or_else(|| {
            robot.assumptions.push(format!("it has no part `{}`: `{}` is on its body", item.parent, item.name));
            0
        })
    }

    fn sensor(&self, row: &'static Row, item: &Item, link: usize) -> Result<SensorDef, String> {
        let class = row.here.unwrap_or_default();
        let settings = self.settings_of(row);
        let config = config(class, &settings)?;
        let default = sensor::CLASSES.iter().find(|(known, _)| *known == class).map_or(0.0, |(_, interval)| *interval);
        let interval = settings.iter().find(|(key, _)| *key == SCAN_INTERVAL).and_then(|(_, value)| value.parse().ok());
        let (name, position, direction) = (item.name.clone(), item.position, item.direction);
        Ok(SensorDef { name, link, position, direction, scan_interval: interval.unwrap_or(default), config })
    }
}
