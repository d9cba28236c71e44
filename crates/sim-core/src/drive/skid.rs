//! Skid steering: `{Left f} {Right f}`, both required (SkidSteeredVehicle.uc:17-61) unless the robot accepts one side alone.

use gamebots_proto::Problem;
use gamebots_proto::command::Drive;
use scene::RobotDef;

use super::of_side;

/// Returns the speed of each driven wheel in the unit of the command; `None` keeps its target.
pub(super) fn wheel_speeds(robot: &RobotDef, drive: &Drive, problems: &mut Vec<Problem>) -> Vec<Option<f64>> {
    let sides = drive.numbers(["Left", "Right"], problems);
    let enough = robot.one_side_drives || sides.iter().all(Option::is_some);
    if !enough && sides.iter().any(Option::is_some) {
        problems.push(Problem::MissingKey { verb: "DRIVE", key: "Left and Right together" });
    }
    robot.driven().map(|wheel| of_side(sides, wheel.side).filter(|_| enough)).collect()
}
