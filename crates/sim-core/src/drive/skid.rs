//! Skid steering: `{Left f} {Right f}`, both required (SkidSteeredVehicle.uc:17-61) unless the robot accepts one side alone.

use gamebots_proto::Problem;
use gamebots_proto::command::Drive;
use scene::RobotDef;

use super::{Order, of_side};

pub(super) const KEYS: [&str; 2] = ["Left", "Right"];

/// Returns the order of a command, with speeds in its unit.
pub(super) fn order(robot: &RobotDef, drive: &Drive, problems: &mut Vec<Problem>) -> Order {
    let sides = drive.numbers(KEYS, problems);
    let enough = robot.one_side_drives || sides.iter().all(Option::is_some);
    if !enough && sides.iter().any(Option::is_some) {
        problems.push(Problem::MissingKey { verb: "DRIVE", key: "Left and Right together" });
    }
    Order::Wheels(robot.driven().map(|wheel| of_side(sides, wheel.side).filter(|_| enough)).collect())
}
