//! The controller of a real robot, as its maker's parameters of ros2_control describe it.

use base_motion::{Base, DiffDrive};
use kinematics::Mecanum;
use scene::RobotDef;

/// A controller that drives a base: what it assumes of the wheels, how it limits velocities, and how it names things.
#[derive(Debug, Clone, PartialEq)]
pub struct Controller {
    /// Name of its node.
    pub name: String,
    /// Its assumption about the wheels.
    pub wheels: Wheels,
    /// Frame of its odometry, without the robot's prefix.
    pub odom_frame: String,
    /// Frame of the robot, without the prefix.
    pub base_frame: String,
    /// True if it publishes the transform between these.
    pub publishes_transform: bool,
    /// Variances of pose and twist of its odometry: along x, y, z, m² and (m/s)², and about them, rad² and (rad/s)².
    pub variances: [[f64; 6]; 2],
    /// Time without an order after which it stops the robot, s; 0 for never.
    pub timeout: f64,
    /// Limits of the velocities ahead and to the left, m/s, and of the turn, rad/s.
    pub limits: [Limit; 3],
}

/// An assumption about the wheels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Wheels {
    /// diff_drive_controller.
    Sides(DiffDrive),
    /// mecanum_drive_controller.
    Mecanum(Mecanum),
    /// ackermann_steering_controller: the distance of the axles and the radius of the wheels, m.
    Car {
        /// m.
        wheel_base: f64,
        /// m.
        radius: f64,
    },
}

/// Limits of a velocity and of its change a second: least and greatest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limit {
    /// m/s or rad/s.
    pub velocity: [f64; 2],
    /// m/s² or rad/s².
    pub acceleration: [f64; 2],
}

impl Limit {
    /// No limit.
    pub const NONE: Self =
        Self { velocity: [f64::NEG_INFINITY, f64::INFINITY], acceleration: [f64::NEG_INFINITY, f64::INFINITY] };

    /// Returns the velocity after a time, s, on the way from one to another.
    pub fn next(&self, now: f64, wanted: f64, time: f64) -> f64 {
        let [least, most] = self.velocity;
        let wanted = wanted.clamp(least, most);
        let [down, up] = self.acceleration;
        let change = wanted - now;
        // An infinite acceleration takes no time.
        let most = if change < 0.0 { -down } else { up };
        if most.is_infinite() { wanted } else { now + change.signum() * change.abs().min(most * time) }
    }
}

impl Controller {
    /// Returns the kinematics that it assumes for a class of robots.
    pub fn base(&self, robot: &RobotDef) -> Base {
        match self.wheels {
            Wheels::Sides(numbers) => Base::of_driver(robot, numbers),
            Wheels::Mecanum(numbers) => Base::Mecanum(numbers),
            Wheels::Car { wheel_base, radius } => Base::of_car_driver(robot, wheel_base, radius),
        }
    }

    /// Returns the names of its topics for velocities and odometry, without the robot's namespace.
    pub fn topics(&self) -> [String; 2] {
        let [velocity, odometry] = match self.wheels {
            Wheels::Sides(_) => ["cmd_vel", "odom"],
            Wheels::Mecanum(_) | Wheels::Car { .. } => ["reference", "odometry"],
        };
        [velocity, odometry].map(|topic| format!("{}/{topic}", self.name))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_holds_velocity_and_acceleration() {
        let limit = Limit { velocity: [-1.0, 2.0], acceleration: [-4.0, 1.0] };
        for (now, wanted, expected) in
            [(0.0, 5.0, 0.1), (1.95, 5.0, 2.0), (0.0, -5.0, -0.4), (-0.9, -5.0, -1.0), (0.5, 0.5, 0.5)]
        {
            assert!((limit.next(now, wanted, 0.1) - expected).abs() < 1e-12, "{now} to {wanted}");
        }
        assert_eq!(Limit::NONE.next(0.0, 5.0, 0.0), 5.0);
    }
}
