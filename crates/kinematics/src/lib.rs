//! Kinematics of wheeled bases: twist of the base to wheel speeds and back.
//!
//! Frame: x forward, y right, z down, so a positive yaw rate is clockwise seen from above. SI units, radians.
//! A wheel speed is positive when the wheel rolls the base forward.
//!
//! A Mecanum base has three models here. R is the wheel radius, L = lx + ly, N the number of rollers per wheel, and phi the phases:
//!
//! | all wheels at omega | [`Mecanum`], the textbook | [`FiniteRollers`], exact | [`thesis::printed`] |
//! |---|---|---|---|
//! | forward | R omega | R omega | R omega |
//! | to the right | R omega | cos(phi) R omega, mean sin(pi/N)/(pi/N): 0.955 for N = 6 | R omega, then scaled by sqrt(2)/2 without a reason |
//! | turning | R omega / L | R omega / (ly + y(phi) + lx / cos(phi)), mean 0.972 for the youBot | R omega / (lx - ly): 4.5 times as fast |

pub mod coulomb;
mod finite;
mod mecanum;
mod skid;
pub mod thesis;

pub use finite::FiniteRollers;
pub use mecanum::Mecanum;
pub use skid::Skid;

/// Velocity of a base in the plane, in its own frame.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct Twist {
    /// Forward velocity, m/s.
    pub forward: f64,
    /// Velocity to the right, m/s.
    pub right: f64,
    /// Yaw rate, rad/s, clockwise seen from above.
    pub clockwise: f64,
}

/// Position and heading in the plane, in the frame of the start.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PlanarPose {
    /// Distance forward, m.
    pub x: f64,
    /// Distance to the right, m.
    pub y: f64,
    /// Heading, rad, clockwise seen from above, not wrapped.
    pub theta: f64,
}

impl PlanarPose {
    /// Returns the pose after a twist held for `dt` seconds, with the heading of the beginning (Odometry.uc:99-135).
    #[must_use]
    pub fn moved(self, twist: Twist, dt: f64) -> Self {
        let (sin, cos) = libm::sincos(self.theta);
        Self {
            x: self.x + (twist.forward * cos - twist.right * sin) * dt,
            y: self.y + (twist.forward * sin + twist.right * cos) * dt,
            theta: self.theta + twist.clockwise * dt,
        }
    }
}

/// The examples of the README, as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
