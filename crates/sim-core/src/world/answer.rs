//! Answers to GETCONF and GETGEO (protocol.md 4.7).

use gamebots_proto::command::{GetConf, GetGeo};
use gamebots_proto::message::{Conf, Geo, ItemGeo, RobotConf, RobotGeo};
use nalgebra::Vector3;
use scene::{RobotDef, SensorDef};

use super::robot::Robot;
use super::{actuator, tools};
use crate::drive;
use crate::sensor::floats;

/// Returns the robot's configuration, or that of every matching item. `None` if nothing matches.
pub(super) fn conf(robot: &Robot, ask: &GetConf) -> Option<Conf> {
    if ask.type_name == "Robot" {
        return Some(Conf::Robot(robot_conf(robot)));
    }
    let sensors = matching(robot, &ask.type_name, &ask.name).map(|item| item.sensor.get().conf());
    let items = sensors.chain(actuator::confs(robot.def(), &ask.type_name, &ask.name));
    let items: Vec<_> = items.chain(tools::confs(robot.def(), &ask.type_name, &ask.name)).collect();
    // A request for the deprecated mission packages is always answered.
    let answered = !items.is_empty() || ask.type_name == "MisPkg";
    answered.then(|| Conf::Items { type_name: ask.type_name.clone(), items })
}

/// Returns the robot's geometry, or that of every matching item. `None` if nothing matches.
pub(super) fn geo(robot: &Robot, ask: &GetGeo) -> Option<Geo> {
    if ask.type_name == "Robot" {
        return Some(Geo::Robot(robot_geo(robot)));
    }
    if ask.type_name.eq_ignore_ascii_case("Actuator") {
        let items = actuator::geos(robot.def(), &ask.name);
        return (!items.is_empty()).then(|| Geo::Actuators { type_name: ask.type_name.clone(), items });
    }
    let sensor = |SensorDef { name, link, position, direction, .. }: &SensorDef| {
        item_geo(robot.def(), name, *link, (*position).into(), *direction)
    };
    let sensors = matching(robot, &ask.type_name, &ask.name).map(|item| sensor(&item.def));
    let items = sensors.chain(actuator::gripper_geos(robot.def(), &ask.type_name, &ask.name));
    let items: Vec<_> = items.chain(tools::geos(robot.def(), &ask.type_name, &ask.name)).collect();
    (!items.is_empty()).then(|| Geo::Items { type_name: ask.type_name.clone(), items })
}

/// Returns the pose of an item when every joint is at 0, in the robot frame or relative to the actuator's link that carries it.
pub(super) fn item_geo(
    def: &RobotDef,
    name: &str,
    link: usize,
    position: Vector3<f64>,
    orientation: [f64; 3],
) -> ItemGeo {
    let (mount, mount_link, origin) = match def.actuator_of(link).zip(def.links.get(link)) {
        Some(((actuator, number), link)) => (&actuator.name, Some(number), link.origin()),
        None => (&def.class, None, [0.0; 3]),
    };
    let location = floats((position - Vector3::from(origin)).into());
    ItemGeo {
        name: name.to_owned(),
        location,
        orientation: floats(orientation),
        mount: mount.clone(),
        mount_link,
        tip: None,
    }
}

/// Returns the robot's configuration. Its name is always the class, as clients compare it with the mount of the sensors (clients.md 4).
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
