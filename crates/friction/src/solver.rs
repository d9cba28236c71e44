//! Sweeps over the contacts, alternating with Newton's method.

use nalgebra::{Matrix3, Vector3};

use crate::local;
use crate::newton::{self, Workspace};
use crate::problem::{Constraint, Problem, dot};

/// Residual up to which an answer is converged, relative to the largest entry of the right-hand side.
pub const TOLERANCE: f64 = 1e-6;
/// Sweeps before the first try of Newton's method. Their total doubles before each further try.
const SWEEPS: usize = 5;
/// Accuracy of the friction of a contact in a sweep.
const ACCURACY: f64 = 1e-12;
/// Sweeps after which the solver stops.
const MAX_SWEEPS: usize = 2000;

/// Multiplications after which the solver stops, roughly: ten milliseconds. Steady motion takes a thousandth of it, an impact a few steps
/// of it at most.
const MAX_WORK: usize = 10_000_000;

/// Outcome of a solution.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Outcome {
    /// Sweeps over the contacts.
    pub sweeps: usize,
    /// Steps of Newton's method.
    pub newton_steps: usize,
    /// True if the residual is at most [`TOLERANCE`]. Otherwise the answer is that of the last sweep.
    pub is_settled: bool,
}

/// Solves a problem. On entry `impulses` are those of the last step, or 0 if there was none. On return they are the impulse on every row, N
/// s.
pub fn solve(problem: &Problem, impulses: &mut [f64], workspace: &mut Workspace) -> Outcome {
    let (mut sweeps, mut newton_steps) = (0, 0);
    if impulses.iter().any(|it| !it.is_finite()) {
        impulses.fill(0.0);
    }
    // Newton's method needs a start.
    let is_new = impulses.iter().all(|&it| it == 0.0) && problem.residual(impulses).worst() > TOLERANCE;
    loop {
        let is_start = sweeps > 0 || !is_new;
        if is_start && newton::solve(problem, impulses, sweeps == 0, TOLERANCE, &mut newton_steps, workspace) {
            return Outcome { sweeps, newton_steps, is_settled: true };
        }
        let rows = problem.right_side.len();
        let work = rows * rows * (sweeps + newton_steps * (rows / 3 + 1));
        if sweeps >= MAX_SWEEPS || work >= MAX_WORK {
            return Outcome { sweeps, newton_steps, is_settled: false };
        }
        let more = sweeps.max(SWEEPS);
        let more = more.min((MAX_WORK - work).div_ceil(rows * rows));
        (0..more).for_each(|_| sweep(problem, impulses));
        sweeps += more;
    }
}

/// Solves every constraint in turn, exactly, for the impulses of the others (nonsmooth Gauss-Seidel; Jean and Moreau 1992).
fn sweep(problem: &Problem, impulses: &mut [f64]) {
    for (row, constraint) in problem.constraints() {
        let left = |row: usize, impulses: &[f64]| problem.right_side[row] - dot(problem.of_row(row), impulses);
        match constraint {
            Constraint::Within(most) => {
                impulses[row] = (impulses[row] + left(row, impulses) / problem.own(row)).clamp(-most, most);
            }
            Constraint::Contact { friction, tangents } => {
                // Missing rows get a unit response and no right-hand side.
                let count = 1 + tangents;
                let has = |one: usize, other: usize| one < count && other < count;
                let own = Matrix3::from_fn(|one, other| {
                    if has(one, other) {
                        problem.of_row(row + one)[row + other]
                    } else {
                        f64::from(u8::from(one == other))
                    }
                });
                let before = Vector3::from_fn(|it, _| if it < count { impulses[row + it] } else { 0.0 });
                let left = Vector3::from_fn(|it, _| if it < count { left(row + it, impulses) } else { 0.0 });
                let push = local::solve(&own, &(left + own * before), friction, tangents, ACCURACY);
                impulses[row..row + count].copy_from_slice(&push.as_slice()[..count]);
            }
        }
    }
}
