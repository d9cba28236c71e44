//! Bases of robots: how a robot's root is supported, and what its wheels can do.

use serde::{Deserialize, Serialize};

use crate::check::LEAST_OFFSET;
use crate::{MountedWheel, RobotDef, Side, Steering};

/// The support of a robot's root.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub enum Footing {
    /// The root is free to move, and the ground carries it.
    #[default]
    Free,
    /// The root has no weight and follows the velocities of its commands, within these limits.
    Flying(Aerial),
    /// The root is fixed to the ground.
    Fixed,
}

/// Flight limits of a robot; percentages in commands refer to these.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Aerial {
    /// Greatest forward, sideways and vertical velocity, m/s.
    pub max_velocity: [f64; 3],
    /// Greatest turn rate, rad/s.
    pub max_turn: f64,
    /// Greatest lean, rad.
    pub max_tilt: f64,
}

impl Footing {
    /// Returns the footing of robots with a steering, whose files say nothing else, and with these limits of flight, if any.
    pub fn of(steering: Steering, aerial: Option<Aerial>) -> Self {
        let other = if steering == Steering::None { Self::Fixed } else { Self::Free };
        aerial.map_or(other, Self::Flying)
    }

    /// Returns the flight limits. `None` if the robot does not fly.
    pub fn aerial(&self) -> Option<Aerial> {
        if let Self::Flying(aerial) = self { Some(*aerial) } else { None }
    }
}

/// A base's wheels, by how they steer it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Drivetrain {
    /// No driven wheels.
    None,
    /// Wheels that keep their direction: the base turns by a difference between its sides.
    Sides,
    /// Wheels of which joints steer some, as in cars.
    Steered,
    /// Four Mecanum wheels in the order front left, front right, back left, back right, whose rollers form an X as seen from above.
    Mecanum,
}

impl RobotDef {
    /// Returns the drivetrain that the tree of links has.
    pub fn drivetrain(&self) -> Drivetrain {
        // The signs of x and of the rollers' angle.
        const MECANUM: [(f64, Side, f64); 4] =
            [(1.0, Side::Left, 1.0), (1.0, Side::Right, -1.0), (-1.0, Side::Left, -1.0), (-1.0, Side::Right, 1.0)];
        let fits = |(wheel, (front, side, angle)): (MountedWheel, (f64, Side, f64))| {
            wheel.position[0] * front >= LEAST_OFFSET
                && wheel.side == side
                && wheel.rollers.as_ref().is_some_and(|rollers| rollers.angle * angle > 0.0)
        };
        if self.driven().count() == 4 && self.driven().zip(MECANUM).all(fits) {
            return Drivetrain::Mecanum;
        }
        let is_steered = self.links.iter().any(|link| link.steered_axle().is_some());
        match self.driven().next() {
            None => Drivetrain::None,
            Some(_) if is_steered => Drivetrain::Steered,
            Some(_) => Drivetrain::Sides,
        }
    }
}
