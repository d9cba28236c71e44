//! `DRIVE` commands to wheel speeds: one file a way of steering, the maths in the crate `kinematics`.

mod omni;
mod skid;

use gamebots_proto::Problem;
use gamebots_proto::command::Drive;
use kinematics::{FiniteRollers, Mecanum, Twist};
use scene::{RobotDef, Side, Steering};

/// What a robot remembers between two `DRIVE` lines.
#[derive(Debug, Clone, PartialEq)]
pub struct DriveState {
    /// Speeds of the driven wheels, rad/s, in the order of the robot's wheels.
    pub targets: Vec<f64>,
    /// Headlight.
    pub light: bool,
    /// Sticky: numbers are percent of the limit (BotConnection.uc:195-197).
    normalized: bool,
    /// Velocities held by an omni base until they are replaced.
    twist: Twist,
}

impl DriveState {
    /// At rest.
    pub fn new(robot: &RobotDef) -> Self {
        Self { targets: vec![0.0; robot.driven().count()], light: false, normalized: false, twist: Twist::default() }
    }

    /// Takes a command. `speed_unit` is what one wheel-speed unit of the wire is in rad/s.
    pub fn apply(&mut self, robot: &RobotDef, drive: &Drive, speed_unit: f64, problems: &mut Vec<Problem>) {
        self.normalized = drive.normalized.unwrap_or(self.normalized);
        self.light = drive.light.unwrap_or(self.light);
        let speeds = match robot.steering {
            Steering::Skid => skid::wheel_speeds(robot, drive, problems),
            Steering::Omni => omni::wheel_speeds(robot, drive),
        };
        if robot.steering == Steering::Omni {
            self.twist = omni::held_twist(self.twist, robot, drive, self.normalized);
            if omni::has_velocities(drive) {
                self.targets = omni::follow(robot, self.twist);
            }
        }
        for ((target, speed), wheel) in self.targets.iter_mut().zip(speeds).zip(robot.driven()) {
            if let (Some(speed), Some(motor)) = (speed, wheel.drive) {
                let unit = if self.normalized { motor.max_speed / 100.0 } else { speed_unit };
                *target = (speed * unit).clamp(-motor.max_speed, motor.max_speed);
            }
        }
    }
}

/// Kinematics of an omni robot, or `None` if it is not one. Its wheels are in Mecanum order.
pub fn mecanum(robot: &RobotDef) -> Option<Mecanum> {
    let geometry = robot.wheel_geometry();
    (robot.steering == Steering::Omni && robot.driven().count() == 4).then_some(Mecanum {
        half_wheelbase: geometry.wheel_base / 2.0,
        half_track: geometry.track / 2.0,
        wheel_radius: geometry.radius,
    })
}

/// The same with its rollers counted.
pub fn finite_rollers(robot: &RobotDef) -> Option<FiniteRollers> {
    let rollers = robot.driven().next()?.wheel.rollers.as_ref()?;
    let mut firsts = robot.driven().map(|wheel| wheel.rollers.as_ref().map_or(0.0, |rollers| rollers.first_roller));
    Some(FiniteRollers {
        base: mecanum(robot)?,
        first_rollers: std::array::from_fn(|_| firsts.next().unwrap_or(0.0)),
        count: rollers.count,
        axis_circle: rollers.axis_circle,
        angle: rollers.angle.abs(),
    })
}

/// The speed that `{Left ..}` or `{Right ..}` gives a wheel of this side.
fn of_side(drive: &Drive, side: Side) -> Option<f64> {
    match side {
        Side::Left => drive.left,
        Side::Right => drive.right,
    }
}
