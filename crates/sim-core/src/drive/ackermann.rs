//! Steered wheels: `{Speed f} {FrontSteer f} {RearSteer f}`, all three required (AckermanSteeredVehicle.uc:22-67). Every driven wheel
//! gets the speed. Revolute joints with FRONTSTEER or REARSTEER in their names, in any case, get the angle, rad, positive to the right.
//!
//! USARSim turns both wheels of an axle by the same angle, so one of them has to slide. With rigid wheels that grip, the robot would then
//! follow the circle of one wheel or the other, half a track off. Here the commanded angle is that of the axle's midpoint, and each wheel
//! is perpendicular to the line from it to the turning centre.

use gamebots_proto::Problem;
use gamebots_proto::command::Drive;
use scene::{Link, RobotDef};

use super::Order;

pub(super) const KEYS: [&str; 3] = ["Speed", "FrontSteer", "RearSteer"];

/// Reported range of an axle that does not steer (AckermanSteeredVehicle.uc:69-105).
#[expect(clippy::approx_constant, reason = "USARSim writes so")]
const NO_RANGE: f64 = 6.28;

/// Returns the orders of a command, with the speed in its unit; none if a key is missing.
pub(super) fn orders(robot: &RobotDef, drive: &Drive, problems: &mut Vec<Problem>) -> Vec<Order> {
    let given = drive.numbers(KEYS, problems);
    if let [Some(speed), Some(front), Some(rear)] = given {
        return vec![Order::Steer([front, rear]), Order::Wheels(robot.driven().map(|_| Some(speed)).collect())];
    }
    if given.iter().any(Option::is_some) {
        problems.push(Problem::MissingKey { verb: "DRIVE", key: "Speed, FrontSteer and RearSteer together" });
    }
    Vec::new()
}

/// Returns the target angles of the steering joints, rad, each with the joint's number among those that have a value.
pub(super) fn joint_targets(robot: &RobotDef, steer: [f64; 2]) -> Vec<(usize, f64)> {
    // Beyond a joint's limits, the tangent of the angle could change its sign.
    let within =
        |axle| robot.steering_limits(axle).fold(steer[axle], |angle: f64, [least, most]| angle.clamp(least, most));
    let steer = [0, 1].map(within);
    let centre = turning_centre(robot, steer);
    let joints = robot.with_values().enumerate();
    let target = |(number, link): (usize, &Link)| {
        let angle = steer[link.steered_axle()?];
        let [x, y, _] = link.origin();
        // The turning centre is `aside` to the right of the wheel and `behind` behind it.
        let angle = centre.map_or(angle, |[centre_x, centre_y]| {
            let (behind, aside) = (x - centre_x, centre_y - y);
            libm::atan(behind / aside)
        });
        // A joint whose axis points up turns the other way.
        let axis = link.joint.as_ref()?.axis[2];
        Some((number, angle * axis.signum()))
    };
    joints.filter_map(target).collect()
}

/// Returns the turning centre, x and y in the robot frame, m. `None` if the wheels of both axles are parallel, or if they are so steep
/// that the centre would be between left and right wheels.
fn turning_centre(robot: &RobotDef, [front, rear]: [f64; 2]) -> Option<[f64; 2]> {
    let geometry = robot.wheel_geometry();
    let front_x = robot.driven().map(|wheel| wheel.position[0]).reduce(f64::max)?;
    let [front_slope, rear_slope] = [front, rear].map(libm::tan);
    let aside = geometry.wheel_base / (front_slope - rear_slope);
    let is_outside = aside.is_finite() && aside.abs() > geometry.track / 2.0;
    is_outside.then_some([front_x - aside * front_slope, aside])
}

/// Returns the smallest range of the steering joints of front and rear, rad, measured from end to end, not to one side.
pub(super) fn ranges(robot: &RobotDef) -> [f32; 2] {
    let ranges = |axle| robot.steering_limits(axle).map(|[least, most]| most - least);
    [0, 1].map(|axle| ranges(axle).reduce(f64::min).unwrap_or(NO_RANGE) as f32)
}
