//! A base with four Mecanum wheels. The thesis's keys `{Front-Left v}` ..., `{WheelNumber n} {WheelSpeed v}`,
//! the sides `{Left v} {Right v}`, and the velocities of an aerial robot. Keys given change what they name;
//! wheels win over sides, sides over velocities.

use gamebots_proto::command::Drive;
use kinematics::Twist;
use scene::RobotDef;

use super::{mecanum, of_side};

/// Speed of each wheel that the command names by wheel or side, in the unit of the command.
pub(super) fn wheel_speeds(robot: &RobotDef, drive: &Drive) -> Vec<Option<f64>> {
    let named = [drive.front_left, drive.front_right, drive.back_left, drive.back_right];
    let numbered = |index| drive.wheels.iter().find(|wheel| wheel.number as usize == index).map(|wheel| wheel.speed);
    robot
        .driven()
        .zip(named)
        .enumerate()
        .map(|(index, (wheel, named))| named.or_else(|| numbered(index)).or_else(|| of_side(drive, wheel.side)))
        .collect()
}

/// True when the command gives any velocity; wheels and sides that it names as well win over it.
pub(super) fn has_velocities(drive: &Drive) -> bool {
    velocities(drive).iter().any(Option::is_some)
}

/// The velocities held after the command. Naming wheels or sides lets go of those that are not given again.
/// Normalized: percent of what the base reaches with every wheel at its limit.
pub(super) fn held_twist(held: Twist, robot: &RobotDef, drive: &Drive, normalized: bool) -> Twist {
    let held = if names_wheels(drive) { Twist::default() } else { held };
    let limit = fastest(robot);
    let [forward, right, clockwise] = velocities(drive);
    let value = |given: Option<f64>, limit: f64, held: f64| {
        given.map_or(held, |given| if normalized { given * limit / 100.0 } else { given })
    };
    Twist {
        forward: value(forward, limit.forward, held.forward),
        right: value(right, limit.right, held.right),
        clockwise: value(clockwise, limit.clockwise, held.clockwise),
    }
}

/// Wheel speeds, rad/s, for a twist; a twist out of reach is slowed down as a whole, so its direction stays.
pub(super) fn follow(robot: &RobotDef, twist: Twist) -> Vec<f64> {
    let Some(mecanum) = mecanum(robot) else { return Vec::new() };
    let speeds = mecanum.inverse(twist);
    let limits = robot.driven().map(|wheel| wheel.drive.map_or(0.0, |motor| motor.max_speed));
    let excess = speeds.iter().zip(limits).map(|(speed, limit)| speed.abs() / limit).fold(1.0, f64::max);
    speeds.iter().map(|speed| speed / excess).collect()
}

fn velocities(drive: &Drive) -> [Option<f64>; 3] {
    [drive.linear_velocity, drive.lateral_velocity, drive.rotational_velocity]
}

fn names_wheels(drive: &Drive) -> bool {
    let wheels = [drive.front_left, drive.front_right, drive.back_left, drive.back_right, drive.left, drive.right];
    wheels.iter().any(Option::is_some) || !drive.wheels.is_empty()
}

fn fastest(robot: &RobotDef) -> Twist {
    let Some(mecanum) = mecanum(robot) else { return Twist::default() };
    let limit = robot.driven().filter_map(|wheel| wheel.drive).map(|motor| motor.max_speed);
    let limit = limit.fold(f64::INFINITY, f64::min);
    let of = |signs: [f64; 4]| mecanum.forward(signs.map(|sign| sign * limit));
    Twist {
        forward: of([1.0, 1.0, 1.0, 1.0]).forward,
        right: of([1.0, -1.0, -1.0, 1.0]).right,
        clockwise: of([1.0, -1.0, 1.0, -1.0]).clockwise,
    }
}
