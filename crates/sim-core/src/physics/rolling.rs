//! Rolling resistance: a force against the motion of a wheel's hub. Its size is the load times a coefficient.
//!
//! The coefficient of a pair is the sum of both materials', as both are deformed. The load is that of the last step.

use nalgebra::Vector3;

/// The hub of a wheel, on which its rolling resistance acts.
pub(super) struct Hub {
    /// Number of the link that carries the wheel.
    pub(super) carrier: usize,
    /// Centre in the frame of that link's body, m.
    pub(super) centre: Vector3<f64>,
    /// True for a plain wheel, which rolls ahead and slides sideways. Other wheels roll in every direction.
    pub(super) rolls_ahead_only: bool,
}

/// The load of one wheel.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub(super) struct Load {
    /// Sum of the impulses of the last step times their normals, N s.
    pub(super) normal: Vector3<f64>,
    /// Sum of the impulses times their coefficients, N s.
    pub(super) resistance: f64,
}

impl Hub {
    /// Computes the rolling resistance in a step, N. `velocity` is the hub's velocity without it, `ahead` the x axis of the carrier, and
    /// `mass` the hub's share of the robot's mass, kg.
    pub(super) fn resistance(
        &self,
        load: &Load,
        velocity: Vector3<f64>,
        ahead: Vector3<f64>,
        mass: f64,
        time_step: f64,
    ) -> Vector3<f64> {
        let velocity = if self.rolls_ahead_only { ahead * ahead.dot(&velocity) } else { velocity };
        load.impulse(velocity, mass) / time_step
    }
}

impl Load {
    /// Returns the impulse on a hub that moves with a velocity and carries a mass. It never exceeds the impulse that stops the hub.
    fn impulse(&self, velocity: Vector3<f64>, mass: f64) -> Vector3<f64> {
        let Some(normal) = self.normal.try_normalize(0.0) else { return Vector3::zeros() };
        let along = velocity - normal * normal.dot(&velocity);
        let speed = along.norm();
        if speed > 0.0 { -along * (self.resistance.min(mass * speed) / speed) } else { Vector3::zeros() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Computes the resistance of a hub that carries 10 kg under a load of 1 N s, in steps of 0.01 s.
    fn resistance(rolls_ahead_only: bool, velocity: [f64; 3]) -> Vector3<f64> {
        let hub = Hub { carrier: 0, centre: Vector3::zeros(), rolls_ahead_only };
        let load = Load { normal: -Vector3::z(), resistance: 0.02 };
        hub.resistance(&load, velocity.into(), Vector3::x(), 10.0, 0.01)
    }

    #[test]
    fn it_brakes_by_the_load_and_no_more_than_to_a_stop() {
        assert!((resistance(false, [3.0, 4.0, 5.0]) - Vector3::new(-1.2, -1.6, 0.0)).norm() < 1e-12);
        assert!((resistance(false, [0.001, 0.0, 0.0]) - Vector3::new(-1.0, 0.0, 0.0)).norm() < 1e-12);
        assert_eq!(resistance(false, [0.0, 0.0, 5.0]), Vector3::zeros());
    }

    #[test]
    fn a_plain_wheel_is_braked_ahead_alone() {
        assert!((resistance(true, [3.0, 4.0, 5.0]) - Vector3::new(-2.0, 0.0, 0.0)).norm() < 1e-12);
    }
}
