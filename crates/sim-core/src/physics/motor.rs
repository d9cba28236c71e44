//! Joint servos, for every drive model.

use scene::{Coupling, Motor};

/// Speed below which a wheel that is told to stop is held in place, rad/s.
const HOLDING_SPEED: f64 = 0.5;
/// Time constant of holding, s. The servo's gain over this is the stiffness of a held wheel.
const HOLDING_TIME: f64 = 0.05;

/// A joint whose position is one number.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Value {
    /// Limits of the targets of a position servo.
    pub(super) limits: Option<[f64; 2]>,
    pub(super) motor: Option<Motor>,
    /// Coupling of the servo's target to a leader, by the leader's number among the joints that have a value.
    pub(super) follows: Option<Coupling>,
    pub(super) is_wheel: bool,
}

/// The target of a joint, and the state of its servo.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub(super) struct Servo {
    target: f64,
    /// Angle that the servo holds or follows, rad, if any.
    reference: Option<f64>,
    /// Present set point of a position servo on its way to the target, rad.
    asked: Option<f64>,
}

/// Torque as a function of the speed at the end of a step: `at_rest - gain speed`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Torque {
    /// Torque at speed 0, N m.
    pub(super) at_rest: f64,
    /// Decrease of the torque with speed, N m s/rad.
    pub(super) gain: f64,
}

impl Value {
    /// Builds the value of a joint of a definition.
    pub(super) fn new(def: &scene::Joint, is_wheel: bool) -> Self {
        Self { limits: def.limits, motor: def.drive.clone(), follows: None, is_wheel }
    }

    /// Clamps a target to the servo's range: the joint's limits for a position, the motor's largest speed for a speed.
    pub(super) fn within_limits(&self, target: f64) -> f64 {
        let Some(motor) = &self.motor else { return target };
        let limits = if motor.stiffness.is_some() { self.limits } else { Some([-motor.max_speed, motor.max_speed]) };
        limits.map_or(target, |[least, most]| target.clamp(least, most))
    }
}

impl Servo {
    /// Sets the target: a speed, rad/s, or for a servo with a stiffness an angle, rad.
    pub(super) fn set_target(&mut self, target: f64) {
        if target != self.target {
            self.reference = None;
        }
        self.target = target;
    }

    /// Returns the target.
    pub(super) fn target(&self) -> f64 {
        self.target
    }

    /// Computes the torque in the coming step. A plain speed servo gives way under a load for ever. Told to stop, it holds the angle at
    /// which the wheel came to rest, as the position loop of a real controller does. With integral action it follows the angle that its
    /// target speed demands.
    pub(super) fn torque(&mut self, motor: &Motor, angle: f64, speed: f64, time_step: f64) -> Torque {
        if let Some(stiffness) = motor.stiffness {
            return self.torque_to_position(motor, stiffness, angle, time_step);
        }
        let stands = self.target == 0.0 && speed.abs() < HOLDING_SPEED;
        if self.reference.is_none() && (stands || motor.integral_time.is_some() && self.target != 0.0) {
            self.reference = Some(angle);
        }
        let Some(reference) = self.reference else {
            return Torque { at_rest: motor.gain * self.target, gain: motor.gain };
        };
        let stiffness = motor.gain / motor.integral_time.unwrap_or(HOLDING_TIME);
        // A wheel that is dragged away is held near its new angle, not pulled back all the way.
        let slack = motor.max_torque / stiffness;
        let ahead = (reference - angle).clamp(-slack, slack) + self.target * time_step;
        self.reference = Some(angle + ahead);
        Torque { at_rest: motor.gain * self.target + stiffness * ahead, gain: motor.gain + stiffness * time_step }
    }

    /// Computes the torque towards a position. The set point moves no faster than the motor's speed limit. Stiffness and gain act on the
    /// position at the end of the step, so any stiffness is stable.
    fn torque_to_position(&mut self, motor: &Motor, stiffness: f64, angle: f64, time_step: f64) -> Torque {
        let from = self.asked.unwrap_or(angle);
        let most = motor.max_speed * time_step;
        let asked = from + (self.target - from).clamp(-most, most);
        self.asked = Some(asked);
        let at_rest = stiffness * (asked - angle) + motor.gain * (asked - from) / time_step;
        Torque { at_rest, gain: motor.gain + stiffness * time_step }
    }
}

/// Sets the targets of the wheels' servos, rad/s.
pub(super) fn set_wheel_speeds<'a>(values: impl Iterator<Item = &'a Value>, servos: &mut [Servo], speeds: &[f64]) {
    let wheels = values.zip(servos).filter(|(value, _)| value.is_wheel);
    wheels.zip(speeds).for_each(|((_, servo), &speed)| servo.set_target(speed));
}

/// Sets the target of a joint, by its number, within its limits. `value` is the joint's, if the joint exists.
pub(super) fn set_target(value: Option<&Value>, joint: usize, target: f64, targets: &mut [f64], servos: &mut [Servo]) {
    if let Some(value) = value {
        targets[joint] = value.within_limits(target);
        servos[joint].set_target(targets[joint]);
    }
}

/// Sets the targets of servos that follow another's. `targets` are the joints' own, which are added to the leader's share.
pub(super) fn follow_targets<'a>(values: impl Iterator<Item = &'a Value>, targets: &[f64], servos: &mut [Servo]) {
    for (number, value) in values.enumerate() {
        let Some(Coupling { leader, multiplier, offset, .. }) = value.follows else { continue };
        let Some(leader) = servos.get(leader) else { continue };
        let target = value.within_limits(targets[number] + multiplier * leader.target() + offset);
        servos[number].set_target(target);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn motor(integral_time: Option<f64>) -> Motor {
        Motor { max_speed: 10.0, gain: 4.0, max_torque: 100.0, stiffness: None, integral_time, armature: 0.0 }
    }

    /// Computes the torque at the speed that the wheel keeps.
    fn given(servo: &mut Servo, motor: &Motor, angle: f64, speed: f64) -> f64 {
        let Torque { at_rest, gain } = servo.torque(motor, angle, speed, 0.01);
        at_rest - gain * speed
    }

    #[test]
    fn a_speed_servo_droops_by_torque_over_gain() {
        let mut servo = Servo::default();
        servo.set_target(2.0);
        assert!((given(&mut servo, &motor(None), 0.0, 1.75) - 1.0).abs() < 1e-12);
        assert!((given(&mut servo, &motor(None), 7.0, 1.75) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn told_to_stand_it_holds_where_it_stopped() {
        let mut servo = Servo::default();
        servo.set_target(2.0);
        servo.set_target(0.0);
        assert!((given(&mut servo, &motor(None), 1.0, 2.0) + 8.0).abs() < 1e-12, "still turning: only brakes");
        assert_eq!(given(&mut servo, &motor(None), 1.1, 0.0), 0.0);
        assert!((given(&mut servo, &motor(None), 1.0, 0.0) - 0.1 * 4.0 / HOLDING_TIME).abs() < 1e-9);
    }

    #[test]
    fn a_follower_adds_its_own_target_to_its_leaders_within_its_limits() {
        let follower = |leader| Value {
            limits: Some([-1.0, 1.0]),
            motor: Some(Motor { stiffness: Some(10.0), ..motor(None) }),
            follows: Some(Coupling { leader, multiplier: -2.0, offset: 0.1, kind: scene::CouplingKind::Target }),
            is_wheel: false,
        };
        let values = [Value { follows: None, ..follower(0) }, follower(0), follower(1)];
        let mut servos = [Servo::default(); 3];
        servos[0].set_target(0.3);
        follow_targets(values.iter(), &[0.3, 0.2, 0.8], &mut servos);
        assert!((servos[1].target() + 0.3).abs() < 1e-12);
        assert_eq!(servos[2].target(), 1.0);
    }

    #[test]
    fn with_integral_action_it_makes_up_for_what_it_lost() {
        let (mut servo, motor) = (Servo::default(), motor(Some(0.1)));
        servo.set_target(2.0);
        // The wheel lags by 1 rad/s: each step it falls 0.01 rad further behind, which is 0.4 N m more.
        let torques: Vec<f64> = (0..4).map(|step| given(&mut servo, &motor, 0.01 * f64::from(step), 1.0)).collect();
        assert!(torques.windows(2).all(|pair| (pair[1] - pair[0] - 0.4).abs() < 1e-9), "{torques:?}");
    }

    #[test]
    fn dragged_away_it_holds_no_harder_than_it_can() {
        let mut servo = Servo::default();
        given(&mut servo, &motor(None), 0.0, 0.0);
        assert!((given(&mut servo, &motor(None), -1e3, 0.0) - 100.0).abs() < 1e-9);
        assert!((given(&mut servo, &motor(None), -1e3 + 0.5, 0.0) - 60.0).abs() < 1e-9);
    }
}
