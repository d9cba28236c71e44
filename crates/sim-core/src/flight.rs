//! What a robot in the air is asked to do.

/// Velocities and attitude that an aerial robot keeps until it is asked for others.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Flight {
    /// Forward, to the right and up, m/s, along the robot's heading.
    pub(crate) velocity: [f64; 3],
    /// Turn rate about the vertical, rad/s, clockwise seen from above.
    pub(crate) turn: f64,
    /// Roll and pitch that it takes on, rad.
    pub(crate) attitude: [f64; 2],
}
