//! CONF and GEO of robots on wheels (WheeledVehicle.uc:19-97).

use gamebots_proto::message::{GroundConf, GroundGeo, VehicleConf, VehicleGeo};
use scene::RobotDef;

use crate::sensor::floats;

/// Returns the configuration. As in USARSim, the maximum speed is the smallest limit of the wheels, at most 100 rad/s.
pub(super) fn conf(robot: &RobotDef, speed_unit: f64, max_steer: Option<[f32; 2]>) -> VehicleConf {
    let speeds = robot.driven().filter_map(|wheel| wheel.drive).map(|motor| motor.max_speed);
    let [max_front_steer, max_rear_steer] = max_steer.map_or([None; 2], |angles| angles.map(Some));
    VehicleConf::Ground(GroundConf {
        steering_type: robot.reported_steering().to_owned(),
        mass: robot.mass(),
        max_speed: (speeds.fold(100.0, f64::min) / speed_unit) as f32,
        max_torque: robot.reported_max_torque as f32,
        max_front_steer,
        max_rear_steer,
    })
}

pub(super) fn geo(robot: &RobotDef) -> VehicleGeo {
    let geometry = robot.wheel_geometry();
    VehicleGeo::Ground(GroundGeo {
        dimensions: floats([geometry.wheel_base, geometry.track, 0.0]),
        centre_of_gravity: floats(robot.total_mass().centre.into()),
        wheel_radius: geometry.radius as f32,
        wheel_separation: geometry.track as f32,
        wheel_base: geometry.wheel_base as f32,
    })
}
