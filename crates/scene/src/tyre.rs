//! Tyres of plain wheels.

use serde::{Deserialize, Serialize};

/// An elastic tread: bristles on the contact patch that bend before they slide (a brush, docs/kinematics.md). A wheel without one is a rigid
/// disc, whose contact slides or holds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tyre {
    /// Slip stiffness along and across: force over load, for a small slip.
    pub stiffness: [f64; 2],
    /// Half length and half width of the contact patch, m.
    pub patch: [f64; 2],
    /// Way on which the force follows a change of slip, m. Without it half the length of the patch, as for bristles alone; a soft carcass makes
    /// it longer.
    #[serde(default)]
    pub relaxation: Option<f64>,
    /// Friction along and across over that of the pair of materials.
    #[serde(default = "isotropic")]
    pub friction: [f64; 2],
}

impl Tyre {
    /// Returns the way on which the force follows a change of slip, m.
    pub fn relaxation(&self) -> f64 {
        self.relaxation.unwrap_or(self.patch[0])
    }
}

/// Returns the ratios of equal friction in all directions.
pub const fn isotropic() -> [f64; 2] {
    [1.0; 2]
}
