//! Sweeps over the contacts, and Newton's method from where they have come.

use nalgebra::{DVector, Matrix3, Vector3};

use crate::problem::{Constraint, Problem};
use crate::{local, newton};

/// How far an answer may miss, of the greatest velocity that is missing.
pub const TOLERANCE: f64 = 1e-6;
/// Sweeps before the first try of Newton's method; then twice as many before each.
const SWEEPS: usize = 5;
/// Sweeps before what there is is taken.
const MAX_SWEEPS: usize = 2000;

/// An answer, and how it was found.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// The impulse on every row, N s.
    pub impulses: DVector<f64>,
    /// Sweeps over the contacts.
    pub sweeps: usize,
    /// Steps of Newton's method.
    pub newton_steps: usize,
    /// Whether it misses by no more than [`TOLERANCE`]; otherwise it is where the last sweep has come.
    pub is_settled: bool,
}

/// Solves a problem, from the impulses of the step before, or 0 where there was none.
pub fn solve(problem: &Problem, mut impulses: DVector<f64>) -> Outcome {
    let (mut sweeps, mut newton_steps) = (0, 0);
    if impulses.iter().any(|it| !it.is_finite()) {
        impulses.fill(0.0);
    }
    // Newton's method is of no use where nothing is known.
    let is_new = impulses.iter().all(|&it| it == 0.0) && problem.residual(&impulses).worst() > TOLERANCE;
    loop {
        let is_start = sweeps > 0 || !is_new;
        if is_start && let Some(impulses) = newton::solve(problem, &impulses, TOLERANCE, &mut newton_steps) {
            return Outcome { impulses, sweeps, newton_steps, is_settled: true };
        }
        if sweeps >= MAX_SWEEPS {
            return Outcome { impulses, sweeps, newton_steps, is_settled: false };
        }
        let more = sweeps.max(SWEEPS);
        (0..more).for_each(|_| sweep(problem, &mut impulses));
        sweeps += more;
    }
}

/// Every constraint in turn, exactly, for the impulses of the others (nonsmooth Gauss-Seidel; Jean and Moreau 1992).
fn sweep(problem: &Problem, impulses: &mut DVector<f64>) {
    for (row, constraint) in problem.constraints() {
        let count = constraint.rows();
        // The response is symmetric, and its columns lie together in memory.
        let given = |row: usize| problem.response.column(row).dot(impulses);
        match constraint {
            Constraint::Within(most) => {
                let left = (problem.missing[row] - given(row)) / problem.response[(row, row)];
                impulses[row] = (impulses[row] + left).clamp(-most, most);
            }
            Constraint::Contact { friction, tangents } => {
                // Rows that it does not have respond to nothing and miss nothing.
                let mut own = Matrix3::identity();
                own.view_mut((0, 0), (count, count)).copy_from(&problem.response.view((row, row), (count, count)));
                let mut before = Vector3::zeros();
                before.rows_mut(0, count).copy_from(&impulses.rows(row, count));
                let left = Vector3::from_fn(
                    |it, _| if it < count { problem.missing[row + it] - given(row + it) } else { 0.0 },
                );
                let push = local::solve(&own, &(left + own * before), friction, tangents);
                impulses.rows_mut(row, count).copy_from(&push.rows(0, count));
            }
        }
    }
}
