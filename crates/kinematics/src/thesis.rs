//! Jacobians of the thesis "A KUKA youBot simulation in USARSim", (6.29) to (6.35), as printed and as meant.
//!
//! They serve for comparison, not for driving. The frame of the thesis is x right, y forward, z up, so yaw is counter-clockwise.
//! Its wheels are C1 front right, C2 front left, C3 back left, C4 back right. They are at `(±T_x, ±T_y)`, with `T_x` half the track
//! and `T_y` half the wheelbase. A wheel's Jacobian maps its rates (wheel, roller, turning on the spot) to the velocity of the base
//! (x, y, yaw).
//!
//! Their errors:
//!
//! | printed | should be | consequence |
//! |---|---|---|
//! | third columns `(T_y, T_x)`, `(T_y, -T_x)`, `(-T_y, -T_x)`, `(-T_y, T_x)` in (6.30) to (6.33) | `(d_y, -d_x)` of each wheel (Muir and Neuman) | the lever arm becomes `T_y - T_x` instead of `T_y + T_x`: yaw rates of the youBot 4.5 times off |
//! | `(-d_y, -d_x)` in the general form (6.29) | `(d_y, -d_x)` | contradicts (6.30) to (6.33) as well |
//! | R and r "circumference" | radius | rates 2 pi off |
//! | (0, 1, 0) in (6.34) "a speed of 1 in the y-direction" | the rate of the roller | a factor sqrt(2)/2 for sideways motion that does not exist |
//! | (6.35) "12 x 3", four blocks side by side | one velocity for all four wheels, solved together ([`base_velocity`]) | no inverse kinematics |

use nalgebra::{Matrix3, Matrix4x3, Vector2, Vector3, Vector4};

/// Roller angles of C1 to C4, rad.
const ROLLER_ANGLES: [f64; 4] = {
    let eta = std::f64::consts::FRAC_PI_4;
    [-eta, eta, -eta, eta]
};
/// Signs of `T_x` and `T_y` in the positions of C1 to C4.
const PLACES: [[f64; 2]; 4] = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]];

/// Dimensions of a base.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sizes {
    /// Radius of the wheels, m.
    pub wheel_radius: f64,
    /// Radius of the rollers, m.
    pub roller_radius: f64,
    /// Half the track, the thesis's T_x, m.
    pub half_track: f64,
    /// Half the wheelbase, the thesis's T_y, m.
    pub half_wheelbase: f64,
}

/// Returns the Jacobians (6.30) to (6.33) exactly as printed, at theta = 0.
pub fn printed(sizes: &Sizes) -> [Matrix3<f64>; 4] {
    let (tx, ty) = (sizes.half_track, sizes.half_wheelbase);
    let third = [[ty, tx], [ty, -tx], [-ty, -tx], [-ty, tx]];
    std::array::from_fn(|wheel| jacobian(sizes, wheel, third[wheel]))
}

/// Returns the Jacobians with the third column of Muir and Neuman, `(d_y, -d_x, 1)`.
pub fn corrected(sizes: &Sizes) -> [Matrix3<f64>; 4] {
    std::array::from_fn(|wheel| {
        let [x, y] = PLACES[wheel];
        jacobian(sizes, wheel, [y * sizes.half_wheelbase, -x * sizes.half_track])
    })
}

fn jacobian(sizes: &Sizes, wheel: usize, third: [f64; 2]) -> Matrix3<f64> {
    let (sin, cos) = libm::sincos(ROLLER_ANGLES[wheel]);
    #[rustfmt::skip]
    let matrix = Matrix3::new(
        0.0,                sizes.roller_radius * sin,  third[0],
        sizes.wheel_radius, -sizes.roller_radius * cos, third[1],
        0.0,                0.0,                        1.0,
    );
    matrix
}

/// Solves the step that the thesis leaves out: the velocity (x, y, yaw) of the base on which all four wheels agree. The wheel rates
/// are in rad/s in the order C1 to C4; the rates of the rollers are eliminated. Returns `None` if the rates leave the velocity
/// open.
pub fn base_velocity(jacobians: &[Matrix3<f64>; 4], rates: [f64; 4]) -> Option<Vector3<f64>> {
    // A wheel holds the base across the direction of its roller: n . (v - rate c1 - yaw c3) = 0, with n at right angles to the
    // roller's column.
    let normals = jacobians.map(|jacobian| Vector2::new(-jacobian[(1, 1)], jacobian[(0, 1)]).normalize());
    let column = |wheel: usize, index: usize| jacobians[wheel].fixed_view::<2, 1>(0, index).into_owned();
    let rows: [_; 4] = std::array::from_fn(|wheel| {
        let normal: Vector2<f64> = normals[wheel];
        Vector3::new(normal.x, normal.y, -normal.dot(&column(wheel, 2))).transpose()
    });
    let matrix = Matrix4x3::from_rows(&rows);
    let rim = Vector4::from_fn(|wheel, _| rates[wheel] * normals[wheel].dot(&column(wheel, 0)));
    (matrix.transpose() * matrix).try_inverse().map(|inverse| inverse * matrix.transpose() * rim)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Mecanum;

    const YOUBOT: Sizes = Sizes { wheel_radius: 0.05, roller_radius: 0.014, half_track: 0.15, half_wheelbase: 0.2355 };
    const TEXTBOOK: Mecanum = Mecanum { half_wheelbase: 0.2355, half_track: 0.15, wheel_radius: 0.05 };

    /// Product of (6.34): the first Jacobian times (0, 1, 0).
    #[test]
    fn the_printed_example_comes_out() {
        let got = printed(&YOUBOT)[0] * Vector3::new(0.0, 1.0, 0.0);
        let expected = -0.014 * std::f64::consts::FRAC_1_SQRT_2;
        assert!((got - Vector3::new(expected, expected, 0.0)).norm() < 1e-12, "{got}");
    }

    /// Converts from front left, front right, back left, back right to C1 to C4, and from forward, right, clockwise to x, y, yaw.
    fn textbook([front_left, front_right, back_left, back_right]: [f64; 4]) -> ([f64; 4], Vector3<f64>) {
        let twist = TEXTBOOK.forward([front_left, front_right, back_left, back_right]);
        ([front_right, front_left, back_left, back_right], Vector3::new(twist.right, twist.forward, -twist.clockwise))
    }

    #[test]
    fn corrected_and_solved_together_they_are_the_textbook() {
        for speeds in [[1.0; 4], [1.0, -1.0, -1.0, 1.0], [1.0, -1.0, 1.0, -1.0], [2.0, 0.5, -1.0, 0.3]] {
            let (rates, expected) = textbook(speeds);
            let got = base_velocity(&corrected(&YOUBOT), rates).expect("a velocity");
            assert!((got - expected).norm() < 1e-12, "{speeds:?}: {got} instead of {expected}");
        }
    }

    #[test]
    fn as_printed_they_turn_four_and_a_half_times_as_fast() {
        let (rates, expected) = textbook([1.0, -1.0, 1.0, -1.0]);
        let got = base_velocity(&printed(&YOUBOT), rates).expect("a velocity");
        let factor = (got.z / expected.z).abs();
        assert!((factor - 0.3855 / 0.0855).abs() < 1e-9, "{factor}");
    }

    /// Equal wheel speeds give equal velocities forward and to the right: no sqrt(2)/2 in either.
    #[test]
    fn sideways_is_as_fast_as_forward_in_both() {
        for jacobians in [printed(&YOUBOT), corrected(&YOUBOT)] {
            let (forward, _) = textbook([1.0; 4]);
            let (right, _) = textbook([1.0, -1.0, -1.0, 1.0]);
            let forward = base_velocity(&jacobians, forward).expect("a velocity");
            let right = base_velocity(&jacobians, right).expect("a velocity");
            assert!((forward.y - 0.05).abs() < 1e-12 && (right.x - 0.05).abs() < 1e-12, "{forward} {right}");
        }
    }
}
