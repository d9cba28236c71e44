//! Mecanum wheels with a finite number of rollers: exact kinematics, unlike the textbook.
//!
//! The roller at the ground is ahead of the lowest point by its phase `phi`, between -pi/N and pi/N. Its axis (roller angle g to
//! the axle) points along `(sin g cos phi, h cos g)` on the ground. h is +1 for the front left and back right wheel and -1 for the
//! others. The roller touches beside the hub, at `-h a tan(phi) cot g` along the axle (a: circle of the roller axes). Without slip
//! along the axis, with the velocity v of the base at that point,
//!
//! ```text
//! (v_x - omega R) sin g cos phi + h v_y cos g = 0
//! ```
//!
//! So a wheel of six rollers strafes at cos(phi) R omega: on average 0.955 of the textbook, `sin(pi/N)/(pi/N)`.

use nalgebra::{Matrix4x3, Vector3, Vector4};

use crate::{Mecanum, Twist};

/// Direction of the rollers at the ground, in the order of the wheels: +1 forward-right, -1 forward-left.
const HANDS: [f64; 4] = [1.0, -1.0, -1.0, 1.0];
/// Number of phases in a mean.
const SAMPLES: u32 = 1000;

/// A base with four Mecanum wheels of `count` rollers each. Wheel order: front left, front right, back left, back right.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FiniteRollers {
    /// Positions and size of the wheels.
    pub base: Mecanum,
    /// Number of rollers per wheel.
    pub count: u32,
    /// Distance of a roller's axis from the wheel's axis, m.
    pub axis_circle: f64,
    /// Angle between the two axes, rad.
    pub angle: f64,
    /// Angle from the front of each wheel to its first roller at a wheel angle of 0, rad.
    pub first_rollers: [f64; 4],
}

impl FiniteRollers {
    /// Returns the phase of the roller at the ground, rad, for the angle that a wheel has turned forward.
    pub fn phase(&self, wheel: usize, angle: f64) -> f64 {
        let pitch = std::f64::consts::TAU / f64::from(self.count);
        let ahead = std::f64::consts::FRAC_PI_2 - angle - self.first_rollers[wheel];
        ahead - pitch * (ahead / pitch).round()
    }

    /// Returns the wheel speeds, rad/s, for a twist of the base at the given phases of the wheels.
    pub fn inverse(&self, twist: Twist, phases: [f64; 4]) -> [f64; 4] {
        let motion = Vector3::new(twist.forward, twist.right, twist.clockwise);
        std::array::from_fn(|wheel| {
            let row = self.row(wheel, phases[wheel]);
            row.dot(&motion) / (row.x * self.base.wheel_radius)
        })
    }

    /// Returns the twist of the base from wheel speeds, rad/s. It is exact if the wheels agree; otherwise it has the least slip
    /// along the rollers' axes.
    pub fn forward(&self, speeds: [f64; 4], phases: [f64; 4]) -> Twist {
        let rows: [Vector3<f64>; 4] = std::array::from_fn(|wheel| self.row(wheel, phases[wheel]));
        let matrix = Matrix4x3::from_rows(&rows.map(|row| row.transpose()));
        let rim = Vector4::from_fn(|wheel, _| rows[wheel].x * self.base.wheel_radius * speeds[wheel]);
        let normal = matrix.transpose() * matrix;
        // Three of the four rows are independent for every phase, so the matrix has an inverse.
        let twist = normal.try_inverse().map_or(Vector3::zeros(), |inverse| inverse * matrix.transpose() * rim);
        Twist { forward: twist.x, right: twist.y, clockwise: twist.z }
    }

    /// Returns the ratio of the sideways velocity to the textbook's at the same wheel speeds, as a mean over a turn of the wheels.
    pub fn mean_lateral_ratio(&self) -> f64 {
        let half_pitch = std::f64::consts::PI / f64::from(self.count);
        libm::tan(self.angle) * libm::sin(half_pitch) / half_pitch
    }

    /// Returns the ratio of the yaw rate to the textbook's at the same wheel speeds, as a mean over the phases. All wheels are in
    /// phase, where they disagree a little and slip least: 0.9716 for the youBot. (Each wheel by itself would have 0.9724; with the
    /// sides in opposite phases it is 0.9708.)
    pub fn mean_rotation_ratio(&self) -> f64 {
        let speeds = [1.0, -1.0, 1.0, -1.0];
        let half_pitch = std::f64::consts::PI / f64::from(self.count);
        let sum: f64 = (0..SAMPLES)
            .map(|sample| half_pitch * (2.0 * (f64::from(sample) + 0.5) / f64::from(SAMPLES) - 1.0))
            .map(|phase| self.forward(speeds, [phase; 4]).clockwise)
            .sum();
        sum / f64::from(SAMPLES) / self.base.forward(speeds).clockwise
    }

    /// Returns the velocity along the axis of the roller at the ground for each component of the twist. Its first element is also
    /// the contribution of a rim velocity.
    fn row(&self, wheel: usize, phase: f64) -> Vector3<f64> {
        let hand = HANDS[wheel];
        let (sin, cos) = libm::sincos(self.angle);
        let along = if wheel < 2 { self.base.half_wheelbase } else { -self.base.half_wheelbase };
        let hub = if wheel.is_multiple_of(2) { -self.base.half_track } else { self.base.half_track };
        let beside = hub - hand * self.axis_circle * libm::tan(phase) * cos / sin;
        let (forward, right) = (sin * libm::cos(phase), hand * cos);
        Vector3::new(forward, right, right * along - forward * beside)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn youbot(count: u32) -> FiniteRollers {
        let base = Mecanum { half_wheelbase: 0.235, half_track: 0.15, wheel_radius: 0.05 };
        FiniteRollers { base, count, axis_circle: 0.036, angle: std::f64::consts::FRAC_PI_4, first_rollers: [0.0; 4] }
    }

    /// Reference means: sin(pi/N)/(pi/N), and for turning the result of an independent simulation with free rollers in phase,
    /// 0.9715.
    #[test]
    fn means_are_those_of_the_literature() {
        for (count, lateral) in [(6, 0.9549), (8, 0.9745), (12, 0.9886)] {
            assert!((youbot(count).mean_lateral_ratio() - lateral).abs() < 1e-4, "{count} rollers");
        }
        let rotation = youbot(6).mean_rotation_ratio();
        assert!((rotation - 0.9716).abs() < 1e-4, "{rotation}");
    }

    #[test]
    fn with_a_roller_right_below_the_hub_it_is_the_textbook() {
        let model = youbot(6);
        let twist = Twist { forward: 0.1, right: -0.2, clockwise: 0.3 };
        let (finite, textbook) = (model.inverse(twist, [0.0; 4]), model.base.inverse(twist));
        assert!(finite.iter().zip(textbook).all(|(a, b)| (a - b).abs() < 1e-12), "{finite:?} {textbook:?}");
    }

    #[test]
    fn forward_undoes_inverse_at_any_phases() {
        let model = youbot(6);
        for phases in [[0.0, 0.1, 0.2, 0.3], [-0.5, 0.5, 0.1, -0.3]] {
            let twist = Twist { forward: 0.1, right: -0.2, clockwise: 0.3 };
            let got = model.forward(model.inverse(twist, phases), phases);
            let error = [got.forward - 0.1, got.right + 0.2, got.clockwise - 0.3];
            assert!(error.iter().all(|e| e.abs() < 1e-12), "{phases:?}: {got:?}");
        }
    }

    #[test]
    fn straight_ahead_the_phases_do_not_matter() {
        let got = youbot(6).forward([1.0; 4], [0.5, -0.2, 0.1, 0.4]);
        assert!(
            (got.forward - 0.05).abs() < 1e-12 && got.right.abs() < 1e-12 && got.clockwise.abs() < 1e-12,
            "{got:?}"
        );
    }

    #[test]
    fn phases_run_from_one_roller_to_the_next() {
        let model = youbot(6);
        let degrees = |angle: f64| model.phase(0, angle.to_radians()).to_degrees();
        // Six rollers: with one at the front, two straddle the bottom; 30 degrees on, one is there.
        assert!((degrees(30.0)).abs() < 1e-9);
        assert!((degrees(40.0) + 10.0).abs() < 1e-9, "it moves back under a wheel that rolls forward");
        assert!((degrees(0.0).abs() - 30.0).abs() < 1e-9);
    }
}
