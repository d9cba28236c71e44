//! The servo of a wheel, the same for every drive model.

use crate::scene::Motor;

/// A wheel commanded to stand that turns slower than this is held where it is, rad/s.
const HOLDING_SPEED: f64 = 0.5;
/// Time constant of holding, s: the servo's gain over this is the stiffness of a held wheel.
const HOLDING_TIME: f64 = 0.05;

/// What a wheel is told.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Servo {
    target: f64,
    /// Angle at which it is to be, rad, where it has one.
    reference: Option<f64>,
}

/// Torque as a function of the speed at the end of a step: `at_rest - gain speed`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Torque {
    /// N m.
    pub(super) at_rest: f64,
    /// N m s/rad.
    pub(super) gain: f64,
}

impl Servo {
    /// Sets the speed, rad/s.
    pub(super) fn set_target(&mut self, speed: f64) {
        if speed != self.target {
            self.reference = None;
        }
        self.target = speed;
    }

    /// The speed set, rad/s.
    pub(super) fn target(&self) -> f64 {
        self.target
    }

    /// The torque in the coming step. A servo of the speed alone gives way under a load for ever; told to stand, it
    /// holds the angle where the wheel has come to rest, as the position loop of a real controller does. With integral
    /// action it follows the angle that its speed asks for.
    pub(super) fn torque(&mut self, motor: &Motor, angle: f64, speed: f64, time_step: f64) -> Torque {
        let stands = self.target == 0.0 && speed.abs() < HOLDING_SPEED;
        if self.reference.is_none() && (stands || motor.integral_time.is_some() && self.target != 0.0) {
            self.reference = Some(angle);
        }
        let Some(reference) = self.reference else {
            return Torque { at_rest: motor.gain * self.target, gain: motor.gain };
        };
        let stiffness = motor.gain / motor.integral_time.unwrap_or(HOLDING_TIME);
        // A wheel that is dragged away is held where it comes to be, not pulled back all the way.
        let slack = motor.max_torque / stiffness;
        let ahead = (reference - angle).clamp(-slack, slack) + self.target * time_step;
        self.reference = Some(angle + ahead);
        Torque { at_rest: motor.gain * self.target + stiffness * ahead, gain: motor.gain + stiffness * time_step }
    }
}
