//! Faults that remove a robot: states that no protocol, log or page can carry.

use std::fmt;

use scene::{BodyState, check};

/// Largest speed of a robot, m/s, reached by a fall from 50 km.
const MAX_SPEED: f64 = 1e3;
/// Distance beyond the reach of a map at which a robot counts as outside, m. A robot at the edge of the map extends beyond it.
const MARGIN: f64 = 10.0;
/// Largest turn rate of a robot's body, rad/s.
const MAX_TURN: f64 = 1e4;

/// Reason to remove a robot, or to put an object back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Fault {
    /// A number of its state became infinite or NaN.
    NotFinite,
    /// It left the map.
    OutsideMap {
        /// Its position, m.
        position: [f64; 3],
    },
    /// It moved faster than any body here can.
    TooFast {
        /// Its speed, m/s.
        speed: f64,
        /// Its turn rate, rad/s.
        turn: f64,
    },
}

impl Fault {
    /// Returns the fault of a body's state, if it has one.
    pub(super) fn of(state: &BodyState) -> Option<Self> {
        let BodyState { pose, linear, angular } = state;
        let position: [f64; 3] = pose.translation.vector.into();
        let numbers = position.iter().chain(pose.rotation.coords.iter()).chain(linear).chain(angular);
        let (speed, turn) = (linear.norm(), angular.norm());
        if !numbers.copied().all(f64::is_finite) || !speed.is_finite() || !turn.is_finite() {
            return Some(Self::NotFinite);
        }
        if position.iter().any(|it| it.abs() > check::MAP_REACH.most + MARGIN) {
            return Some(Self::OutsideMap { position });
        }
        (speed > MAX_SPEED || turn > MAX_TURN).then_some(Self::TooFast { speed, turn })
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotFinite => write!(f, "its state became infinite or NaN"),
            Self::OutsideMap { position: [x, y, z] } => {
                write!(f, "it left the map: got position {x:.0},{y:.0},{z:.0}, expected {}", check::MAP_REACH)
            }
            Self::TooFast { speed, turn } => write!(
                f,
                "it moved at {speed:.0} m/s and {turn:.0} rad/s: expected at most {MAX_SPEED} m/s and {MAX_TURN} rad/s"
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use scene::Pose;

    use super::*;

    #[test]
    fn a_state_that_no_wire_may_carry_is_a_fault() {
        let at = |x: f64, speed: f64, turn: f64| {
            let pose = Pose::translation(x, 0.0, 0.0);
            Fault::of(&BodyState { pose, linear: [0.0, speed, 0.0].into(), angular: [turn, 0.0, 0.0].into() })
        };
        for (x, speed, turn, expected) in [
            (0.0, 0.0, 0.0, ""),
            (-1e5, 999.0, 9999.0, ""),
            (f64::NAN, 0.0, 0.0, "its state became infinite or NaN"),
            (0.0, f64::NEG_INFINITY, 0.0, "its state became infinite or NaN"),
            (0.0, 1e200, 0.0, "its state became infinite or NaN"),
            (1.1e5, 0.0, 0.0, "it left the map: got position 110000,0,0, expected -100000 to 100000 m"),
            (0.0, 2e3, 0.0, "it moved at 2000 m/s and 0 rad/s: expected at most 1000 m/s and 10000 rad/s"),
            (0.0, 0.0, 2e4, "it moved at 0 m/s and 20000 rad/s: expected at most 1000 m/s and 10000 rad/s"),
        ] {
            let got = at(x, speed, turn).map_or(String::new(), |fault| fault.to_string());
            assert_eq!(got, expected, "{x} {speed} {turn}");
        }
    }
}
