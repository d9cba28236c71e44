//! Rolling resistance: the ground's force acts ahead of a wheel's axle, by the coefficient times the radius.
//!
//! So it is a moment on a driven wheel, which its motor gives or which brakes it: it moves no hub, and costs a wheel that slides no friction.
//! On a wheel that turns freely the moment is that of a force against the motion of its hub, which is how casters and Mecanum wheels are
//! braked (docs/kinematics.md). `bodies` brakes all wheels so: the engine's contacts do not feel the servo that would give the moment. The
//! bearings of rollers brake these by a moment of their own.
//!
//! The coefficient of a pair is the sum of both materials', as both are deformed. The load is that of the last step.

use nalgebra::Vector3;

/// The hub of a wheel.
pub(super) struct Hub {
    /// Number of the link that carries the wheel.
    pub(super) carrier: usize,
    /// Centre in the frame of that link's body, m.
    pub(super) centre: Vector3<f64>,
    /// The wheel, if it is driven and plain. Others are braked at the hub, in every direction.
    pub(super) driven: Option<Driven>,
}

/// A driven plain wheel or the sprocket of a track.
#[derive(Debug, Clone, Copy)]
pub(super) struct Driven {
    /// Number of its link.
    pub(super) link: usize,
    /// m.
    pub(super) radius: f64,
}

/// The load of one wheel.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub(super) struct Load {
    /// Sum of the impulses of the last step times their normals, N s.
    pub(super) normal: Vector3<f64>,
    /// Sum of the impulses times their coefficients, N s.
    pub(super) resistance: f64,
}

impl Load {
    /// Computes the rolling resistance on a hub in a step, N. `velocity` is the hub's velocity without it, and `mass` the hub's share of the
    /// robot's mass, kg. It is no more than stops the hub.
    pub(super) fn force(&self, velocity: Vector3<f64>, mass: f64, time_step: f64) -> Vector3<f64> {
        let Some(normal) = self.normal.try_normalize(0.0) else { return Vector3::zeros() };
        let along = velocity - normal * normal.dot(&velocity);
        let speed = along.norm();
        if speed > 0.0 { -along * (self.resistance.min(mass * speed) / speed) / time_step } else { Vector3::zeros() }
    }

    /// Computes the moment on a driven wheel, or on a roller, about its axle in a step, N m. `speed` is that of its rim without it, m/s. It is
    /// no more than stops the wheel with its share of the robot's mass, kg.
    pub(super) fn moment(&self, radius: f64, speed: f64, mass: f64, time_step: f64) -> f64 {
        let impulse = (mass * speed).clamp(-self.resistance, self.resistance);
        -impulse * radius / time_step
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LOAD: Load = Load { normal: Vector3::new(0.0, 0.0, -1.0), resistance: 0.02 };

    #[test]
    fn it_brakes_by_the_load_and_no_more_than_to_a_stop() {
        // A hub that carries 10 kg, in steps of 0.01 s.
        let force = |velocity: [f64; 3]| LOAD.force(velocity.into(), 10.0, 0.01);
        assert!((force([3.0, 4.0, 5.0]) - Vector3::new(-1.2, -1.6, 0.0)).norm() < 1e-12);
        assert!((force([0.001, 0.0, 0.0]) - Vector3::new(-1.0, 0.0, 0.0)).norm() < 1e-12);
        assert_eq!(force([0.0, 0.0, 5.0]), Vector3::zeros());
    }

    #[test]
    fn a_driven_wheel_is_braked_about_its_axle() {
        for (speed, expected) in [(3.0, -0.2), (-3.0, 0.2), (0.001, -0.1), (0.0, 0.0)] {
            let moment = LOAD.moment(0.1, speed, 10.0, 0.01);
            assert!((moment - expected).abs() < 1e-12, "{speed} m/s: {moment} N m");
        }
    }
}
