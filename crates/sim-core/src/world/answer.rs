//! Answers to GETCONF and GETGEO (protocol.md 4.7).

use gamebots_proto::command::{GetConf, GetGeo};
use gamebots_proto::message::{Conf, Geo, ItemConf, ItemGeo, RobotConf, RobotGeo};

use super::robot::Robot;
use crate::drive;

/// Type of actuators in the form before ACT, in exact case.
const MISSION_PACKAGE: &str = "MisPkg";

/// Returns the robot's configuration, or that of every matching item. `None` if nothing matches.
pub(super) fn conf(robot: &Robot, GetConf { type_name, name }: &GetConf) -> Option<Conf> {
    if type_name == "Robot" {
        return Some(Conf::Robot(robot_conf(robot)));
    }
    let (def, type_name) = (robot.def(), type_name.clone());
    // A request for the deprecated mission packages is always answered.
    if type_name == MISSION_PACKAGE {
        let items = robot.asked("Actuator", name).filter_map(|item| item.mission_package(def)).collect();
        return Some(Conf::Items { type_name, items });
    }
    let items: Vec<ItemConf> = robot.asked(&type_name, name).map(|item| item.get().conf(def)).collect();
    (!items.is_empty()).then_some(Conf::Items { type_name, items })
}

/// Returns the robot's geometry, or that of every matching item. `None` if nothing matches.
pub(super) fn geo(robot: &Robot, GetGeo { type_name, name }: &GetGeo) -> Option<Geo> {
    if type_name == "Robot" {
        return Some(Geo::Robot(robot_geo(robot)));
    }
    // Only UT2004 sends this answer.
    let asked = if type_name.eq_ignore_ascii_case(MISSION_PACKAGE) { "Actuator" } else { type_name };
    let items: Vec<ItemGeo> = robot.asked(asked, name).filter_map(|item| item.get().geo(robot.def())).collect();
    (!items.is_empty()).then(|| Geo::Items { type_name: type_name.clone(), items })
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
