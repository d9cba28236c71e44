//! Inertia of robots that roll.

use scene::{MountedWheel, RobotDef};

/// Returns the inertia of a driven wheel about its axle, with its rotor, kg m².
pub(crate) fn turning_inertia(wheel: &MountedWheel) -> f64 {
    wheel.spin_inertia() + wheel.drive.map_or(0.0, |motor| motor.armature)
}

/// Returns the effective mass of a forward push: the robot's mass plus the share of its driven wheels' inertia.
pub(crate) fn rolling_mass(robot: &RobotDef) -> f64 {
    let wheels = robot.driven().map(|wheel| turning_inertia(&wheel) / wheel.radius.powi(2));
    f64::from(robot.mass()) + wheels.sum::<f64>()
}
