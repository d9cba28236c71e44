//! Inputs of a step.

use super::super::conveyor::Conveyor;
use super::super::surface::Materials;
use crate::threads::Threads;

/// Inputs that all systems of a step share.
#[derive(Clone, Copy)]
pub(in super::super) struct StepInput<'a> {
    pub(in super::super) materials: &'a Materials,
    pub(in super::super) conveyors: &'a [Conveyor],
    pub(in super::super) robots_of_engine: usize,
    /// True if a robot came or left since the last step.
    pub(in super::super) is_changed: bool,
    pub(in super::super) threads: &'a dyn Threads,
}
