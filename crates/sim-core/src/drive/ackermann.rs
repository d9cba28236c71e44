//! Steered wheels: `{Speed f} {FrontSteer f} {RearSteer f}`, all three required (AckermanSteeredVehicle.uc:22-67). The speed is the mean
//! of the driven wheels, as with differentials: each turns as fast as it is far from the turning centre. Revolute joints with FRONTSTEER or REARSTEER in their names, in any case, get the angle, rad, positive to the right.
//!
//! USARSim turns both wheels of an axle by the same angle and drives all at one speed, so some of them have to slide. With rigid wheels that grip, the robot would then
//! follow the circle of one wheel or the other, half a track off. Here the commanded angle is that of the axle's midpoint, and each wheel
//! is perpendicular to the line from it to the turning centre.

use base_motion::{joint_angles, speed_shares};
use gamebots_proto::Problem;
use gamebots_proto::command::Drive;
use scene::RobotDef;

use super::Order;

pub(super) const KEYS: [&str; 3] = ["Speed", "FrontSteer", "RearSteer"];

/// Reported range of an axle that does not steer (AckermanSteeredVehicle.uc:69-105).
#[expect(clippy::approx_constant, reason = "USARSim writes so")]
const NO_RANGE: f64 = 6.28;

/// Returns the orders of a command, with the speed in its unit; none if a key is missing.
pub(super) fn orders(robot: &RobotDef, drive: &Drive, problems: &mut Vec<Problem>) -> Vec<Order> {
    let given = drive.numbers(KEYS, problems);
    if let [Some(speed), Some(front), Some(rear)] = given {
        let shares = speed_shares(robot, within_limits(robot, [front, rear]));
        let speeds = shares.into_iter().map(|share| Some(share * speed)).collect();
        return vec![Order::Steer([front, rear]), Order::Wheels(speeds)];
    }
    if given.iter().any(Option::is_some) {
        problems.push(Problem::MissingKey { verb: "DRIVE", key: "Speed, FrontSteer and RearSteer together" });
    }
    Vec::new()
}

/// Returns the angles of both axles within the limits of their joints, rad: beyond them the tangent of an angle could change its sign.
fn within_limits(robot: &RobotDef, steer: [f64; 2]) -> [f64; 2] {
    let within =
        |axle| robot.steering_limits(axle).fold(steer[axle], |angle: f64, [least, most]| angle.clamp(least, most));
    [0, 1].map(within)
}

/// Returns the target angles of the steering joints, rad, each with the joint's number among those that have a value.
pub(super) fn joint_targets(robot: &RobotDef, steer: [f64; 2]) -> Vec<(usize, f64)> {
    let angles = joint_angles(robot, within_limits(robot, steer));
    angles.into_iter().filter_map(|(link, angle)| Some((robot.value_of(link)?, angle))).collect()
}

/// Returns the smallest range of the steering joints of front and rear, rad, measured from end to end, not to one side.
pub(super) fn ranges(robot: &RobotDef) -> [f32; 2] {
    let ranges = |axle| robot.steering_limits(axle).map(|[least, most]| most - least);
    [0, 1].map(|axle| ranges(axle).reduce(f64::min).unwrap_or(NO_RANGE) as f32)
}
