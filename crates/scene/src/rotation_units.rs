//! Unreal's rotation units, 65 536 a turn: the resolution of every angle in a USARSim scan.

const PER_RADIAN: f32 = 10430.378;

/// Converts radians to whole rotation units, truncated (UnitsConverter.uc:181-184).
pub fn from_radians(radians: f64) -> i32 {
    (radians * 10430.3783505) as i32
}

/// Converts rotation units to radians, in 32 bits as USARSim does.
pub fn to_radians(rotation_units: i32) -> f32 {
    rotation_units as f32 / PER_RADIAN
}

#[cfg(test)]
#[expect(clippy::approx_constant, reason = "the numbers are what USARSim's files and clients say")]
mod tests {
    use super::*;

    #[test]
    fn angles_pass_through_rotation_units() {
        for (angle, units) in
            [(3.14159, 32767), (0.01745, 182), (4.189, 43692), (1.5707963, 16383), (1.5708, 16384), (6.2832, 65536)]
        {
            assert_eq!(from_radians(angle), units, "{angle}");
        }
        for (units, expected) in [(16384, 1.570796), (182, 0.017449), (32767, 3.141497), (65536, 6.283185)] {
            assert!((to_radians(units) - expected).abs() < 1e-6, "{units}");
        }
    }
}
