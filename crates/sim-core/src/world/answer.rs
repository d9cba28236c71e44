//! What GETCONF and GETGEO answer (protocol.md 4.7).

use gamebots_proto::command::{GetConf, GetGeo};
use gamebots_proto::message::{Conf, Geo, ItemGeo, RobotConf, RobotGeo};

use super::robot::Robot;
use crate::drive;
use crate::sensor::floats;

/// The robot's configuration, or that of every matching item; `None` where nothing matches.
pub(super) fn conf(robot: &Robot, ask: &GetConf) -> Option<Conf> {
    if ask.type_name == "Robot" {
        return Some(Conf::Robot(robot_conf(robot)));
    }
    let items: Vec<_> = matching(robot, &ask.type_name, &ask.name).map(|item| item.sensor.conf()).collect();
    // The deprecated mission packages are always answered, here with none.
    let answered = !items.is_empty() || ask.type_name == "MisPkg";
    answered.then(|| Conf::Items { type_name: ask.type_name.clone(), items })
}

/// The robot's geometry, or that of every matching item; `None` where nothing matches.
pub(super) fn geo(robot: &Robot, ask: &GetGeo) -> Option<Geo> {
    if ask.type_name == "Robot" {
        return Some(Geo::Robot(robot_geo(robot)));
    }
    let items: Vec<_> = matching(robot, &ask.type_name, &ask.name)
        .map(|item| ItemGeo {
            name: item.def.name.clone(),
            location: floats(item.def.position),
            orientation: floats(item.def.direction),
            mount: robot.def().class.clone(),
        })
        .collect();
    (!items.is_empty()).then(|| Geo::Items { type_name: ask.type_name.clone(), items })
}

/// The name is the class, whatever name was asked for: clients compare it with the mount of the sensors (clients.md 4).
fn robot_conf(robot: &Robot) -> RobotConf {
    let def = robot.def();
    RobotConf { name: def.class.clone(), vehicle: drive::conf(def, robot.speed_unit()) }
}

fn robot_geo(robot: &Robot) -> RobotGeo {
    let def = robot.def();
    RobotGeo { name: def.class.clone(), vehicle: drive::geo(def) }
}

fn matching<'a>(robot: &'a Robot, type_name: &'a str, name: &'a str) -> impl Iterator<Item = &'a super::robot::Item> {
    robot.items().iter().filter(move |item| item.matches(type_name, name))
}
