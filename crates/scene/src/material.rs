//! Materials of surfaces.

use nalgebra::Matrix3;
use serde::{Deserialize, Serialize};

/// A physical material.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Material {
    /// Name in `materials.toml`.
    pub name: String,
    /// Coulomb friction coefficient, for both static and sliding friction.
    pub friction: f64,
    /// Restitution, 0 to 1.
    pub restitution: f64,
    /// Rolling resistance coefficient: moment about a wheel's axle over its load and radius. A pair has the sum of both.
    pub rolling_resistance: f64,
    /// Damping of the linear velocity of a body of this material, 1/s.
    pub linear_damping: f64,
    /// Damping of the angular velocity, 1/s.
    pub angular_damping: f64,
    /// Displayed red, green and blue, 0 to 1. A scene written before colours existed reads as black.
    #[serde(default)]
    pub colour: [f64; 3],
    /// True if infrared light passes through it, as through glass.
    #[serde(default)]
    pub transparent: bool,
    /// Source of the numbers.
    pub source: String,
}

impl Material {
    /// Returns the friction and restitution between two materials: the mean of each, PhysX's rule and rapier's default.
    ///
    /// For example, the thesis's roller (0.9) on Unreal's default material (0.7) has 0.8.
    pub fn pair(&self, other: &Self) -> (f64, f64) {
        ((self.friction + other.friction) / 2.0, (self.restitution + other.restitution) / 2.0)
    }

    /// Returns the rolling resistance between two materials: the sum of both, as both deform.
    pub fn pair_rolling_resistance(&self, other: &Self) -> f64 {
        self.rolling_resistance + other.rolling_resistance
    }

    /// Returns the damping of a body's velocity, N s/m, and angular velocity, N m s/rad, from its mass, kg, and inertia, kg m².
    /// Damping a velocity by d per second takes a force of d times the mass, and a torque of d times the mean inertia.
    pub fn damping(&self, mass: f64, inertia: &Matrix3<f64>) -> [f64; 2] {
        [self.linear_damping * mass, self.angular_damping * (inertia.trace() / 3.0)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn material(friction: f64, restitution: f64) -> Material {
        Material { friction, restitution, ..Material::default() }
    }

    #[test]
    fn a_pair_of_materials_has_the_mean_of_both() {
        let (friction, restitution) = material(0.9, 0.0).pair(&material(0.7, 0.3));
        assert!((friction - 0.8).abs() < 1e-12);
        assert!((restitution - 0.15).abs() < 1e-12);
    }
}
