//! Effort of the contact solver.

use std::ops::AddAssign;

use serde::Serialize;

/// Effort of the contact solver over some steps. A system is a robot, or several bodies that touch each other; a step solves each once.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct SolverEffort {
    /// Systems.
    pub systems: u64,
    /// Sweeps over their contacts; 0 in steady motion.
    pub sweeps: u64,
    /// Steps of Newton's method.
    pub newton_steps: u64,
    /// Multiplications of systems of several bodies, roughly.
    pub multiplications: u64,
    /// Systems that did not converge. Their best answer was taken.
    pub unsettled: u64,
}

impl AddAssign for SolverEffort {
    fn add_assign(&mut self, other: Self) {
        self.systems += other.systems;
        self.sweeps += other.sweeps;
        self.newton_steps += other.newton_steps;
        self.multiplications += other.multiplications;
        self.unsettled += other.unsettled;
    }
}
