//! Four Mecanum wheels with rollers at 45 degrees, the textbook model.
//!
//! Without slip along the roller axis of each wheel, `a_i . (v + w x r_i - omega_i r x) = 0`, and with `L = lx + ly` (Muir and
//! Neuman 1987):
//!
//! ```text
//! FL = (vx + vy + L w) / r     FR = (vx - vy - L w) / r
//! BL = (vx - vy + L w) / r     BR = (vx + vy - L w) / r
//! ```
//!
//! The roller axes at the ground form a diamond: FL and BR point forward-right, FR and BL forward-left.
//!
//! # Departures from the thesis
//!
//! The thesis "A KUKA youBot simulation in USARSim" derives Jacobians (6.29) to (6.35) with several errors. Their lever arm is
//! `ly - lx` instead of `lx + ly`. They take circumferences for radii. They read a roller's rate as a wheel's speed, hence a factor
//! sqrt(2)/2 for sideways motion that does not exist. They stop before the four wheels are solved together. [`crate::thesis`] has
//! them as printed and corrected, with a test that the corrected ones are this model. [`Mecanum::slip`] is the part of the wheel
//! speeds that no base velocity explains. The frame of the thesis is y forward, x right, z up.

use nalgebra::{Matrix3x4, Matrix4x3, Vector3, Vector4};

use crate::Twist;

/// A base with four Mecanum wheels. Wheel order everywhere: front left, front right, back left, back right.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mecanum {
    /// Half the distance between front and rear axle, m.
    pub half_wheelbase: f64,
    /// Half the distance between left and right wheels, m.
    pub half_track: f64,
    /// Outer radius of the wheels, m.
    pub wheel_radius: f64,
}

impl Mecanum {
    /// Returns the 4 x 3 matrix above, from twist to wheel speeds: rad/s for m/s and rad/s.
    pub fn inverse_matrix(&self) -> Matrix4x3<f64> {
        let lever = self.half_wheelbase + self.half_track;
        #[rustfmt::skip]
        let matrix = Matrix4x3::new(
            1.0,  1.0,  lever,
            1.0, -1.0, -lever,
            1.0, -1.0,  lever,
            1.0,  1.0, -lever,
        );
        matrix / self.wheel_radius
    }

    /// Returns the matrix from wheel speeds to twist: the least-squares inverse of [`Self::inverse_matrix`].
    pub fn forward_matrix(&self) -> Matrix3x4<f64> {
        let lever = self.half_wheelbase + self.half_track;
        let turn = 1.0 / lever;
        #[rustfmt::skip]
        let matrix = Matrix3x4::new(
            1.0,   1.0,  1.0,   1.0,
            1.0,  -1.0, -1.0,   1.0,
            turn, -turn, turn, -turn,
        );
        matrix * (self.wheel_radius / 4.0)
    }

    /// Returns the twist of the base from the wheel speeds, rad/s.
    pub fn forward(&self, speeds: [f64; 4]) -> Twist {
        let twist = self.forward_matrix() * Vector4::from(speeds);
        Twist { forward: twist.x, right: twist.y, clockwise: twist.z }
    }

    /// Returns the wheel speeds, rad/s, for a twist of the base.
    pub fn inverse(&self, twist: Twist) -> [f64; 4] {
        (self.inverse_matrix() * Vector3::new(twist.forward, twist.right, twist.clockwise)).into()
    }

    /// Returns the part of the wheel speeds that no twist explains, rad/s: `FL + FR - BL - BR`. If it is not zero, rollers have to
    /// slide.
    pub fn slip([front_left, front_right, back_left, back_right]: [f64; 4]) -> f64 {
        front_left + front_right - back_left - back_right
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The youBot of the thesis, Appendix A.
    const YOUBOT: Mecanum = Mecanum { half_wheelbase: 0.2355, half_track: 0.15, wheel_radius: 0.05 };

    /// Hand-checked: straight, right, left, turning clockwise, diagonal forward-right.
    const VECTORS: [([f64; 3], [f64; 4]); 5] = [
        ([0.05, 0.0, 0.0], [1.0, 1.0, 1.0, 1.0]),
        ([0.0, 0.05, 0.0], [1.0, -1.0, -1.0, 1.0]),
        ([0.0, -0.05, 0.0], [-1.0, 1.0, 1.0, -1.0]),
        ([0.0, 0.0, 0.1], [0.771, -0.771, 0.771, -0.771]),
        ([0.05, 0.05, 0.0], [2.0, 0.0, 0.0, 2.0]),
    ];

    fn twist([forward, right, clockwise]: [f64; 3]) -> Twist {
        Twist { forward, right, clockwise }
    }

    #[test]
    fn inverse_gives_the_test_vectors() {
        for (velocity, expected) in VECTORS {
            let speeds = YOUBOT.inverse(twist(velocity));
            assert!(speeds.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{velocity:?}: {speeds:?}");
        }
    }

    #[test]
    fn forward_undoes_inverse_without_slip() {
        for (velocity, speeds) in VECTORS {
            let got = YOUBOT.forward(speeds);
            let error = [got.forward - velocity[0], got.right - velocity[1], got.clockwise - velocity[2]];
            assert!(error.iter().all(|e| e.abs() < 1e-12), "{speeds:?}: {got:?}");
            assert!(Mecanum::slip(speeds).abs() < 1e-12);
        }
    }

    #[test]
    fn wheels_that_work_against_each_other_slip() {
        let speeds = [1.0, 1.0, -1.0, -1.0];
        assert_eq!(Mecanum::slip(speeds), 4.0);
        assert_eq!(YOUBOT.forward(speeds), Twist::default());
    }

    /// The thesis's lever arm would be ly - lx; a turning base shows the difference.
    #[test]
    fn the_lever_arm_is_the_sum_of_both_halves() {
        let got = YOUBOT.forward([1.0, -1.0, 1.0, -1.0]).clockwise;
        assert!((got - 0.05 / 0.3855).abs() < 1e-12);
    }
}
