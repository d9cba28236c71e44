//! Sweeps and Newton's method for sparse problems, within a budget of work.

use nalgebra::{Matrix3, Vector3};

use crate::local;
use crate::problem::Constraint;
use crate::solver::TOLERANCE;
use crate::sparse::{Rows, SparseProblem};
use crate::sparse_newton::Newton;

/// Residual above which the impulses of the step before are no start for Newton's method, relative to the scale.
const NEAR: f64 = 1e-3;
/// Sweeps from a worse start before the first try of Newton's method: they find most of the contacts that came or left.
const FIRST_SWEEPS: usize = 4;
/// Sweeps after a try has failed; then twice as many.
const SWEEPS: usize = 5;
/// Accuracy of the friction of a contact in a sweep, which only prepares Newton's method.
const ACCURACY: f64 = 1e-3;
/// Residual up to which a sweep leaves a contact as it is, relative to the scale.
const STILL: f64 = 1e-5;
/// Share of each Newton step that is taken, and most steps, of the first try.
const FIRST_TRY: [(f64, usize); 1] = [(1.0, 8)];
/// The same of later tries, one after the other from the same start.
const TRIES: [(f64, usize); 3] = [(1.0, 20), (0.7, 40), (0.4, 40)];

/// How an answer of a sparse problem was found.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SparseOutcome {
    /// Sweeps over the contacts.
    pub sweeps: usize,
    /// Newton steps.
    pub newton_steps: usize,
    /// Multiplications that the answer took, roughly.
    pub work: u64,
    /// How far the answer misses, relative to the largest missing velocity.
    pub residual: f64,
    /// True if the answer misses by no more than [`TOLERANCE`]; otherwise it is the best that the budget allowed.
    pub is_settled: bool,
}

/// Scratch buffers that one sparse problem after the other reuses.
#[derive(Debug, Clone, Default)]
pub struct SparseWorkspace {
    rows: Vec<Rows>,
    newton: Newton,
    /// Present impulses, the coordinates and the residual velocities that they give, and every constraint's residual.
    impulses: Vec<f64>,
    coordinates: Vec<f64>,
    velocities: Vec<[f64; 3]>,
    residuals: Vec<f64>,
    /// True for bodies that the next step moves.
    moves: Vec<bool>,
    is_unsettled: Vec<bool>,
    /// Response of each contact to its own impulse; empty until the first sweep.
    responses: Vec<Matrix3<f64>>,
    /// The best impulses so far, and those from which tries start.
    best: Vec<f64>,
    start: Vec<f64>,
}

/// Finds the impulses of a sparse problem. On entry `impulses` are those of the step before, or 0. The search ends within about one Newton
/// step of `budget` multiplications.
pub fn solve_sparse(
    problem: &SparseProblem,
    impulses: &mut [f64],
    budget: u64,
    workspace: &mut SparseWorkspace,
) -> SparseOutcome {
    if impulses.iter().any(|it| !it.is_finite()) {
        impulses.fill(0.0);
    }
    let scale = Rows::collect(problem, &mut workspace.rows);
    let work = workspace.newton.pattern.find(problem);
    let mut search =
        Search { problem, scale, budget, workspace, outcome: SparseOutcome { work, ..Default::default() } };
    search.run(impulses);
    impulses.copy_from_slice(&search.workspace.best);
    search.outcome
}

/// A search for the impulses of one problem.
struct Search<'a> {
    problem: &'a SparseProblem,
    /// Unit of residuals, m/s.
    scale: f64,
    budget: u64,
    workspace: &'a mut SparseWorkspace,
    outcome: SparseOutcome,
}

impl Search<'_> {
    fn run(&mut self, impulses: &[f64]) {
        self.outcome.residual = f64::INFINITY;
        self.workspace.responses.clear();
        self.go_to(impulses);
        if self.judge() {
            return;
        }
        if self.outcome.residual > NEAR {
            self.sweep(FIRST_SWEEPS);
        }
        let mut tries = FIRST_TRY.as_slice();
        let mut sweeps = SWEEPS;
        loop {
            let mut start = std::mem::take(&mut self.workspace.start);
            start.clone_from(&self.workspace.impulses);
            let is_over = tries.iter().any(|&(share, most)| {
                self.go_to(&start);
                self.newton(share, most)
            });
            self.workspace.start = start;
            if is_over {
                return;
            }
            let best = std::mem::take(&mut self.workspace.best);
            self.go_to(&best);
            self.workspace.best = best;
            self.judge();
            self.sweep(sweeps);
            (tries, sweeps) = (TRIES.as_slice(), 2 * sweeps);
        }
    }

    /// Takes up impulses.
    fn go_to(&mut self, impulses: &[f64]) {
        let SparseWorkspace { rows, coordinates, impulses: present, .. } = &mut *self.workspace;
        present.clear();
        present.extend_from_slice(impulses);
        coordinates.clear();
        coordinates.resize(self.problem.coordinate_count(), 0.0);
        for (number, rows) in rows.iter().enumerate() {
            self.problem.push(number, &rows.of(impulses), coordinates);
        }
        self.outcome.work += 3 * self.problem.entries.len() as u64;
    }

    /// Finds what every constraint misses, and keeps the impulses if they are the best so far. Returns true at the end of the search.
    fn judge(&mut self) -> bool {
        let SparseWorkspace { rows, impulses, coordinates, velocities, residuals, best, .. } = &mut *self.workspace;
        velocities.clear();
        residuals.clear();
        let mut worst = 0.0_f64;
        for (number, rows) in rows.iter().enumerate() {
            let impulse = rows.of(impulses);
            let velocity = rows.residual_velocity(self.problem.pull(number, coordinates), &impulse);
            let residual = rows.residual(&impulse, &velocity) / self.scale;
            worst = worst.max(residual);
            velocities.push(velocity);
            residuals.push(residual);
        }
        let outcome = &mut self.outcome;
        outcome.work += 3 * self.problem.entries.len() as u64 + 20 * rows.len() as u64;
        if worst < outcome.residual || best.len() != impulses.len() {
            outcome.residual = worst;
            best.clone_from(impulses);
        }
        outcome.is_settled = worst <= TOLERANCE;
        outcome.is_settled || outcome.work >= self.budget
    }

    /// Tries Newton's method from the present impulses. Returns true at the end of the search.
    fn newton(&mut self, share: f64, most: usize) -> bool {
        for step in 0.. {
            if self.judge() {
                return true;
            }
            if step == most {
                break;
            }
            self.choose();
            let SparseWorkspace { rows, newton, impulses, coordinates, velocities, moves, .. } = &mut *self.workspace;
            self.outcome.newton_steps += 1;
            let work = &mut self.outcome.work;
            if !newton.step(self.problem, rows, moves, velocities, share, impulses, coordinates, work) {
                break;
            }
        }
        false
    }

    /// Chooses the bodies that the next step moves: those of unsettled constraints, and those that share a constraint with them.
    fn choose(&mut self) {
        let SparseWorkspace { rows, residuals, moves, is_unsettled, .. } = &mut *self.workspace;
        is_unsettled.clear();
        is_unsettled.resize(self.problem.bodies.len() - 1, false);
        for (rows, _) in rows.iter().zip(&*residuals).filter(|(_, residual)| **residual > TOLERANCE) {
            rows.bodies.into_iter().for_each(|body| is_unsettled[body] = true);
        }
        moves.clone_from(is_unsettled);
        for [one, other] in rows.iter().map(|rows| rows.bodies) {
            moves[other] |= is_unsettled[one];
            moves[one] |= is_unsettled[other];
        }
    }

    /// Solves every constraint of unsettled bodies and their neighbours in turn, exactly, for the impulses of the others, several times
    /// (nonsmooth Gauss-Seidel; Jean and Moreau 1992).
    fn sweep(&mut self, times: usize) {
        self.choose();
        let problem = self.problem;
        let SparseWorkspace { rows, impulses, coordinates, moves, responses, .. } = &mut *self.workspace;
        if responses.is_empty() {
            responses.extend(rows.iter().enumerate().map(|(number, rows)| response(problem, number, rows)));
        }
        for _ in 0..times {
            if self.outcome.work >= self.budget {
                return;
            }
            self.outcome.sweeps += 1;
            for (number, rows) in rows.iter().enumerate() {
                let [one, other] = rows.bodies;
                if !moves[one] && !moves[other] {
                    continue;
                }
                self.outcome.work += 6 * problem.ranges[number].len() as u64 + 60;
                let before = rows.of(impulses);
                let velocity = rows.residual_velocity(problem.pull(number, coordinates), &before);
                if rows.residual(&before, &velocity) <= STILL * self.scale {
                    continue;
                }
                let after: [f64; 3] = match rows.constraint {
                    Constraint::Within(most) => [(before[0] - velocity[0] / rows.own[0]).clamp(-most, most), 0.0, 0.0],
                    Constraint::Contact { friction, tangents } => {
                        let response = &responses[number];
                        let mut left = response * Vector3::from(before) - Vector3::from(velocity);
                        // Rows that it does not have miss nothing.
                        (rows.count..3).for_each(|row| left[row] = 0.0);
                        local::solve(response, &left, friction, tangents, ACCURACY).into()
                    }
                };
                let change: [f64; 3] = std::array::from_fn(|row| after[row] - before[row]);
                if change != [0.0; 3] {
                    problem.push(number, &change, coordinates);
                    impulses[rows.first..][..rows.count].copy_from_slice(&after[..rows.count]);
                }
            }
        }
    }
}

/// Computes the velocity that a constraint's impulses give on its own rows; the unit matrix on rows that it does not have.
fn response(problem: &SparseProblem, number: usize, rows: &Rows) -> Matrix3<f64> {
    let mut response = Matrix3::zeros();
    for &(_, entry) in problem.entries_of(number) {
        let entry = Vector3::from(entry);
        response += entry * entry.transpose();
    }
    for row in 0..3 {
        response[(row, row)] = if row < rows.count { rows.own[row] } else { 1.0 };
    }
    response
}
