//! A base with four Mecanum wheels. It takes the thesis's keys `{Front-Left v}` ..., `{WheelNumber n} {WheelSpeed v}`, the sides
//! `{Left v} {Right v}`, and velocities: `{LinearVelocity f} {LateralVelocity f}`, m/s, and `{RotationalVelocity f}`, rad/s, clockwise
//! seen from above. A key changes only what it names. Wheels take precedence over sides, sides over velocities.

use gamebots_proto::Problem;
use gamebots_proto::command::Drive;
use kinematics::Twist;
use scene::{MountedWheel, RobotDef};

use super::{Order, of_side};
use base_motion::mecanum;

/// The last one moves nothing.
pub(super) const KEYS: [&str; 12] = [
    "Front-Left",
    "Front-Right",
    "Back-Left",
    "Back-Right",
    "Left",
    "Right",
    "LinearVelocity",
    "LateralVelocity",
    "RotationalVelocity",
    "WheelNumber",
    "WheelSpeed",
    "WheelSteer",
];
const WHEELS: [&str; 4] = ["Front-Left", "Front-Right", "Back-Left", "Back-Right"];
const SIDES: [&str; 2] = ["Left", "Right"];
const VELOCITIES: [&str; 3] = ["LinearVelocity", "LateralVelocity", "RotationalVelocity"];

/// Returns the order for each wheel that the command names by wheel or side, with speeds in its unit.
pub(super) fn wheels(robot: &RobotDef, drive: &Drive, problems: &mut Vec<Problem>) -> Order {
    let named = drive.numbers(WHEELS, problems);
    let sides = drive.numbers(SIDES, problems);
    let numbered = numbered(drive, problems);
    let count = robot.driven().count();
    if let Some((number, _)) = numbered.iter().find(|(number, _)| *number >= count) {
        let why = format!("{} has wheels 0 to {}", robot.class, count.saturating_sub(1));
        problems.push(Problem::Ignored { what: format!("{{WheelNumber {number}}}"), why });
    }
    let by_number = |index| numbered.iter().find(|(number, _)| *number == index).map(|(_, speed)| *speed);
    let speed = |(index, (wheel, named)): (usize, (MountedWheel, Option<f64>))| {
        named.or_else(|| by_number(index)).or_else(|| of_side(sides, wheel.side))
    };
    Order::Wheels(robot.driven().zip(named).enumerate().map(speed).collect())
}

/// Returns wheel numbers and speeds of `{WheelNumber n} {WheelSpeed v}`. A speed belongs to the last number before it. Numbers start at 0
/// in the robot's order of wheels. `WheelSteer` has no meaning for fixed wheels.
fn numbered(drive: &Drive, problems: &mut Vec<Problem>) -> Vec<(usize, f64)> {
    let mut wheels = Vec::new();
    let mut number = None;
    for given in &drive.given {
        if given.is("WheelNumber") {
            number = given.index(problems);
        } else if given.is("WheelSpeed") {
            let speed = given.number(problems);
            wheels.extend(number.take().map(|number| (number, speed)));
        }
    }
    wheels
}

/// Merges the command's velocities into the held ones and returns the order for them. `None` if the command has no velocities. A command that names wheels or sides first resets the held velocities to 0. Normalized velocities are percent of the
/// velocity that the base reaches with every wheel at its limit.
pub(super) fn twist(
    held: &mut Twist,
    robot: &RobotDef,
    drive: &Drive,
    normalized: bool,
    problems: &mut Vec<Problem>,
) -> Option<Order> {
    if names_wheels(drive) {
        *held = Twist::default();
    }
    let given = drive.numbers(VELOCITIES, problems);
    if given.iter().all(Option::is_none) {
        return None;
    }
    let limit = if normalized { fastest(robot) } else { Twist::default() };
    let value = |given: Option<f64>, limit: f64, held: f64| {
        given.map_or(held, |given| if normalized { given * limit / 100.0 } else { given })
    };
    let [forward, right, clockwise] = given;
    *held = Twist {
        forward: value(forward, limit.forward, held.forward),
        right: value(right, limit.right, held.right),
        clockwise: value(clockwise, limit.clockwise, held.clockwise),
    };
    Some(Order::Twist(*held))
}

/// Returns the wheel speeds for a twist, rad/s. A twist out of reach is scaled down as a whole, which keeps its direction.
pub(super) fn speeds(robot: &RobotDef, twist: Twist) -> Vec<f64> {
    let Some(mecanum) = mecanum::textbook(robot) else { return Vec::new() };
    let speeds = mecanum.inverse(twist);
    let limits = robot.driven().map(|wheel| wheel.drive.map_or(0.0, |motor| motor.max_speed));
    let excess = speeds.iter().zip(limits).map(|(speed, limit)| speed.abs() / limit).fold(1.0, f64::max);
    speeds.iter().map(|speed| speed / excess).collect()
}

fn names_wheels(drive: &Drive) -> bool {
    let mut ignored = Vec::new();
    let mut named = WHEELS.iter().chain(&SIDES).filter_map(|key| drive.number(key, &mut ignored));
    named.next().is_some() || !numbered(drive, &mut Vec::new()).is_empty()
}

fn fastest(robot: &RobotDef) -> Twist {
    let Some(mecanum) = mecanum::textbook(robot) else { return Twist::default() };
    let limit = robot.driven().filter_map(|wheel| wheel.drive).map(|motor| motor.max_speed);
    let limit = limit.fold(f64::INFINITY, f64::min);
    let of = |signs: [f64; 4]| mecanum.forward(signs.map(|sign| sign * limit));
    Twist {
        forward: of([1.0, 1.0, 1.0, 1.0]).forward,
        right: of([1.0, -1.0, -1.0, 1.0]).right,
        clockwise: of([1.0, -1.0, 1.0, -1.0]).clockwise,
    }
}
