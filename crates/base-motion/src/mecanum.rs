//! The kinematics of a robot with Mecanum wheels.

use kinematics::{FiniteRollers, Mecanum};
use scene::{Drivetrain, RobotDef};

/// Returns the textbook kinematics of a robot with Mecanum wheels. `None` for other robots.
pub fn textbook(robot: &RobotDef) -> Option<Mecanum> {
    let geometry = robot.wheel_geometry();
    (robot.drivetrain() == Drivetrain::Mecanum).then_some(Mecanum {
        half_wheelbase: geometry.wheel_base / 2.0,
        half_track: geometry.track / 2.0,
        wheel_radius: geometry.radius,
    })
}

/// Returns the kinematics that account for the finite number of rollers. `None` for other robots.
pub fn finite_rollers(robot: &RobotDef) -> Option<FiniteRollers> {
    let rollers = robot.driven().next()?.wheel.rollers.as_ref()?;
    let mut firsts = robot.driven().map(|wheel| wheel.rollers.as_ref().map_or(0.0, |rollers| rollers.first_roller));
    Some(FiniteRollers {
        base: textbook(robot)?,
        first_rollers: std::array::from_fn(|_| firsts.next().unwrap_or(0.0)),
        count: rollers.count,
        axis_circle: rollers.axis_circle,
        angle: rollers.angle.abs(),
    })
}
