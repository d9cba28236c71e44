//! Skid steering: the wheels of one side turn together.

use crate::Twist;

/// A base steered by the difference between its sides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Skid {
    /// Radius of the wheels, m.
    pub wheel_radius: f64,
    /// Distance between the wheels of the left and of the right, m.
    pub track: f64,
}

impl Skid {
    /// Returns the twist of the base from the wheel speeds of left and right, rad/s, without slip.
    pub fn forward(&self, [left, right]: [f64; 2]) -> Twist {
        Twist {
            forward: self.wheel_radius * (left + right) / 2.0,
            right: 0.0,
            clockwise: self.wheel_radius * (left - right) / self.track,
        }
    }

    /// Returns the wheel speeds of left and right, rad/s. A velocity to the right is impossible and ignored.
    pub fn inverse(&self, twist: Twist) -> [f64; 2] {
        let turn = twist.clockwise * self.track / 2.0;
        [twist.forward + turn, twist.forward - turn].map(|speed| speed / self.wheel_radius)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// P3AT with wheels and track from P3AT.uc.
    const P3AT: Skid = Skid { wheel_radius: 0.098, track: 0.36 };

    #[test]
    fn forward_of_the_p3at() {
        for (speeds, forward, clockwise) in
            [([1.0, 1.0], 0.098, 0.0), ([1.0, -1.0], 0.0, 0.5444), ([1.0, 0.0], 0.049, 0.2722)]
        {
            let twist = P3AT.forward(speeds);
            assert!((twist.forward - forward).abs() < 1e-9, "{speeds:?}: {twist:?}");
            assert!((twist.clockwise - clockwise).abs() < 1e-4, "{speeds:?}: {twist:?}");
        }
    }

    #[test]
    fn inverse_undoes_forward() {
        for speeds in [[1.0, 2.0], [-3.0, 0.5], [0.0, 0.0]] {
            let again = P3AT.inverse(P3AT.forward(speeds));
            assert!(again.iter().zip(speeds).all(|(a, b)| (a - b).abs() < 1e-12), "{speeds:?} {again:?}");
        }
    }
}
