//! What surfaces are made of.

use serde::{Deserialize, Serialize};

/// A physical material.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Material {
    /// Its name in `materials.toml`.
    pub name: String,
    /// Coulomb friction, one number for static and sliding.
    pub friction: f64,
    /// Restitution, 0 to 1.
    pub restitution: f64,
    /// Rolling resistance: force against the motion of a wheel's hub over its load; a pair has the sum of both.
    pub rolling_resistance: f64,
    /// Damping of the linear velocity of a body made of it, 1/s.
    pub linear_damping: f64,
    /// Damping of its angular velocity, 1/s.
    pub angular_damping: f64,
    /// Red, green and blue in which it is shown, 0 to 1. A scene written before there were colours reads as black.
    #[serde(default)]
    pub colour: [f64; 3],
    /// Where the numbers come from.
    pub source: String,
}

impl Material {
    /// Friction and restitution between two materials: the mean of each, PhysX's rule and rapier's default.
    ///
    /// So the thesis's roller (0.9) on Unreal's default material (0.7) has 0.8.
    pub fn pair(&self, other: &Self) -> (f64, f64) {
        ((self.friction + other.friction) / 2.0, (self.restitution + other.restitution) / 2.0)
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
