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
    /// Angle at which it is held, rad.
    held: Option<f64>,
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
        self.target = speed;
    }

    /// The speed set, rad/s.
    pub(super) fn target(&self) -> f64 {
        self.target
    }

    /// The torque in the coming step. A servo of the speed alone gives way under a load for ever; told to stand, it
    /// holds the angle where the wheel has come to rest, as the position loop of a real controller does.
    pub(super) fn torque(&mut self, motor: &Motor, angle: f64, speed: f64, time_step: f64) -> Torque {
        if self.target != 0.0 {
            self.held = None;
        } else if self.held.is_none() && speed.abs() < HOLDING_SPEED {
            self.held = Some(angle);
        }
        // A wheel that is dragged away is held where it comes to be, not pulled back all the way.
        let slack = motor.max_torque * HOLDING_TIME / motor.gain;
        self.held =
            self.held.map(|held| if slack.is_finite() { held.clamp(angle - slack, angle + slack) } else { held });
        let (offset, stiffness) = self.held.map_or((0.0, 0.0), |held| (held - angle, motor.gain / HOLDING_TIME));
        Torque { at_rest: motor.gain * self.target + stiffness * offset, gain: motor.gain + stiffness * time_step }
    }
}
