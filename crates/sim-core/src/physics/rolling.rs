//! Rolling resistance: a force against the motion of a wheel's hub, as large as the load times a coefficient.
//!
//! The coefficient of a pair is the sum of both materials', as both are deformed. The load is that of the step before.

use nalgebra::Vector3;

/// A wheel of a tree, as its rolling resistance needs it.
pub(super) struct TreeWheel {
    /// The link that carries it.
    pub(super) parent: usize,
    /// Centre in the frame of that link's body, m.
    pub(super) hub: Vector3<f64>,
    /// A plain wheel rolls ahead; to the side it slides. Others roll every way.
    pub(super) rolls_ahead_only: bool,
}

/// What one wheel stands on.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Load {
    /// Sum of the impulses of the last step times their normals, N s.
    pub(super) normal: Vector3<f64>,
    /// Sum of the impulses times their coefficients, N s.
    pub(super) resistance: f64,
}

/// Impulse on a hub that moves with a velocity and carries a mass: never more than stops it.
pub(super) fn impulse(load: &Load, velocity: Vector3<f64>, mass: f64) -> Vector3<f64> {
    let Some(normal) = load.normal.try_normalize(0.0) else { return Vector3::zeros() };
    let along = velocity - normal * normal.dot(&velocity);
    let speed = along.norm();
    if speed > 0.0 { -along * (load.resistance.min(mass * speed) / speed) } else { Vector3::zeros() }
}
