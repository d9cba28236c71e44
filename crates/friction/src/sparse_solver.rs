//! Sweeps and Newton's method for sparse problems, within a budget of work.

use nalgebra::{Matrix3, Vector3};

use crate::local;
use crate::problem::Constraint;
use crate::solver::TOLERANCE;
use crate::sparse::{Rows, SparseProblem};
use crate::sparse_newton::Newton;

/// Residual above which the last step's impulses are no start for Newton's method, relative to the scale.
const NEAR: f64 = 1e-3;
/// Sweeps from a worse start before the first try of Newton's method, of several bodies and of one. They find most of the contacts that came or
/// left.
const FIRST_SWEEPS: [usize; 2] = [4, 8];
/// Sweeps after the first failed try. They double after each further one.
const SWEEPS: usize = 5;
/// Accuracy of the friction of a contact in a sweep, if its exact solution is needed.
const ACCURACY: f64 = 1e-3;
/// Residual up to which a sweep leaves a contact as it is, relative to the scale.
const STILL: f64 = 1e-5;
/// Share of each Newton step that is taken, and most steps, in the first try with one body.
const FIRST_TRY: [(f64, usize); 1] = [(1.0, 8)];
/// Shares and most steps of later tries with one body.
const TRIES: [(f64, usize); 3] = [(1.0, 20), (0.7, 40), (0.4, 40)];
/// Most Newton steps of a try with several bodies.
const STEPS: usize = 16;
/// Newton steps of such a try that are taken whole. Then every other one is damped, which ends most cycles of contacts that alternate between
/// holding and sliding.
const WHOLE_STEPS: usize = 5;
/// Share of a damped step that is taken.
const DAMPED: f64 = 0.6;

/// Outcome of a sparse solution.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SparseOutcome {
    /// Sweeps over the contacts.
    pub sweeps: usize,
    /// Newton steps.
    pub newton_steps: usize,
    /// Multiplications that the answer took, roughly.
    pub work: u64,
    /// Residual of the answer, relative to the largest entry of the right-hand side.
    pub residual: f64,
    /// True if the residual is within [`TOLERANCE`] or [`Effort::enough`]. Otherwise the answer is the best within the budget.
    pub is_settled: bool,
}

/// Aim of a solution, and its limit.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Effort {
    /// Residual velocity that is good enough after the first Newton step, m/s. Impulses that are kept without one have to reach
    /// [`TOLERANCE`].
    pub enough: f64,
    /// Multiplications after which the search ends, at its next step.
    pub budget: u64,
    /// True if the impulses answer nearly the same problem. Then what is good enough counts from the start, and bodies that meet it keep
    /// their impulses.
    pub is_again: bool,
}

/// Scratch buffers that one sparse problem after the other reuses.
#[derive(Debug, Clone, Default)]
pub struct SparseWorkspace {
    rows: Vec<Rows>,
    newton: Newton,
    /// Present impulses; their coordinates and residual velocities; and the squared residual of every constraint.
    impulses: Vec<f64>,
    coordinates: Vec<f64>,
    velocities: Vec<[f64; 3]>,
    residuals: Vec<f64>,
    /// True for bodies that the next step moves.
    moves: Vec<bool>,
    is_unsettled: Vec<bool>,
    /// Block of each constraint in the Delassus matrix; empty until the first sweep.
    responses: Vec<Matrix3<f64>>,
    /// The best impulses so far.
    best: Vec<f64>,
}

/// Finds the impulses of a sparse problem. On entry `impulses` are those of the last step, or 0.
pub fn solve_sparse(
    problem: &SparseProblem,
    impulses: &mut [f64],
    effort: Effort,
    workspace: &mut SparseWorkspace,
) -> SparseOutcome {
    if impulses.iter().any(|it| !it.is_finite()) {
        impulses.fill(0.0);
    }
    let scale = Rows::collect(problem, &mut workspace.rows);
    let work = workspace.newton.pattern.find(problem);
    let mut search =
        Search { problem, scale, effort, workspace, outcome: SparseOutcome { work, ..Default::default() } };
    search.run(impulses);
    impulses.copy_from_slice(&search.workspace.best);
    search.outcome
}

/// A search for the impulses of one problem.
struct Search<'a> {
    problem: &'a SparseProblem,
    /// Unit of residuals, m/s.
    scale: f64,
    effort: Effort,
    workspace: &'a mut SparseWorkspace,
    outcome: SparseOutcome,
}

impl Search<'_> {
    fn run(&mut self, impulses: &[f64]) {
        self.outcome.residual = f64::INFINITY;
        self.workspace.responses.clear();
        self.go_to(impulses);
        // Drops the last problem's best impulses, in case none of this search improves on its start.
        self.workspace.best.clone_from(&self.workspace.impulses);
        if self.judge(false) {
            return;
        }
        let is_lone = self.problem.bodies.len() == 2;
        if self.outcome.residual > NEAR {
            self.sweep(FIRST_SWEEPS[usize::from(is_lone)]);
        }
        if is_lone {
            self.search_lone();
        } else {
            self.search_heap();
        }
    }

    /// Returns the residual that is good enough now, relative to the scale.
    fn tolerance(&self) -> f64 {
        let Effort { enough, is_again, .. } = self.effort;
        if is_again || self.outcome.newton_steps > 0 { TOLERANCE.max(enough / self.scale) } else { TOLERANCE }
    }

    /// Searches for the impulses of several bodies.
    fn search_heap(&mut self) {
        let is_damped = |step: usize| step >= WHOLE_STEPS && (step - WHOLE_STEPS).is_multiple_of(2);
        let mut sweeps = SWEEPS;
        while !self.newton(STEPS, |step| if is_damped(step) { DAMPED } else { 1.0 }) {
            self.sweep_best(sweeps);
            sweeps *= 2;
        }
    }

    /// Searches for the impulses of one body, whose contacts are stiffer. All tries after sweeps start from the same impulses.
    fn search_lone(&mut self) {
        let mut tries = FIRST_TRY.as_slice();
        let mut sweeps = SWEEPS;
        loop {
            let start = self.workspace.impulses.clone();
            let is_over = tries.iter().any(|&(share, most)| {
                self.go_to(&start);
                self.newton(most, |_| share)
            });
            if is_over {
                return;
            }
            self.sweep_best(sweeps);
            (tries, sweeps) = (TRIES.as_slice(), 2 * sweeps);
        }
    }

    /// Sweeps from the best impulses so far.
    fn sweep_best(&mut self, sweeps: usize) {
        let best = std::mem::take(&mut self.workspace.best);
        self.go_to(&best);
        self.workspace.best = best;
        self.judge(false);
        self.sweep(sweeps);
    }

    /// Sets the present impulses and their coordinates.
    fn go_to(&mut self, impulses: &[f64]) {
        let SparseWorkspace { rows, newton, coordinates, impulses: present, .. } = &mut *self.workspace;
        present.clear();
        present.extend_from_slice(impulses);
        coordinates.clear();
        coordinates.resize(self.problem.coordinate_count(), 0.0);
        for (number, rows) in rows.iter().enumerate() {
            newton.pattern.parts.push(number, &rows.of(impulses), coordinates);
        }
        self.outcome.work += 3 * self.problem.entries.len() as u64;
    }

    /// Computes the residual of every constraint, and keeps the impulses if they are the best so far. After a step only the bodies that it moved
    /// have changed. Returns true if the search is over.
    fn judge(&mut self, is_after_step: bool) -> bool {
        let tolerance = self.tolerance();
        let SparseWorkspace { rows, newton, impulses, coordinates, velocities, residuals, moves, best, .. } =
            &mut *self.workspace;
        velocities.resize(rows.len(), [0.0; 3]);
        residuals.resize(rows.len(), 0.0);
        let mut worst = 0.0_f64;
        for (number, rows) in rows.iter().enumerate() {
            if !is_after_step || rows.bodies.iter().any(|body| moves[*body]) {
                let impulse = rows.of(impulses);
                let pulled = newton.pattern.parts.pull(number, coordinates);
                velocities[number] = rows.residual_velocity(pulled, &impulse);
                residuals[number] = rows.squared_residual(&impulse, &velocities[number]);
                self.outcome.work += 3 * self.problem.ranges[number].len() as u64 + 20;
            }
            worst = worst.max(residuals[number]);
        }
        let worst = worst.sqrt() / self.scale;
        let outcome = &mut self.outcome;
        if worst < outcome.residual {
            outcome.residual = worst;
            best.clone_from(impulses);
        }
        outcome.is_settled = worst <= tolerance;
        outcome.is_settled || outcome.work >= self.effort.budget
    }

    /// Tries Newton's method from the present impulses, in at most `most` steps, of each of which a share is taken. Returns true if the search
    /// is over.
    fn newton(&mut self, most: usize, share: impl Fn(usize) -> f64) -> bool {
        for step in 0.. {
            if self.judge(step > 0) {
                return true;
            }
            if step == most {
                break;
            }
            self.choose();
            let SparseWorkspace { rows, newton, impulses, coordinates, velocities, moves, .. } = &mut *self.workspace;
            self.outcome.newton_steps += 1;
            let work = &mut self.outcome.work;
            let share = share(step);
            if !newton.step(self.problem, rows, moves, velocities, share, impulses, coordinates, work) {
                break;
            }
        }
        false
    }

    /// Chooses the bodies that the next step moves: those of unsettled constraints, and their neighbours.
    fn choose(&mut self) {
        let most = (self.tolerance() * self.scale).powi(2);
        let SparseWorkspace { rows, residuals, moves, is_unsettled, .. } = &mut *self.workspace;
        is_unsettled.clear();
        is_unsettled.resize(self.problem.bodies.len() - 1, false);
        for (rows, _) in rows.iter().zip(&*residuals).filter(|(_, residual)| **residual > most) {
            rows.bodies.into_iter().for_each(|body| is_unsettled[body] = true);
        }
        moves.clone_from(is_unsettled);
        for [one, other] in rows.iter().map(|rows| rows.bodies) {
            moves[other] |= is_unsettled[one];
            moves[one] |= is_unsettled[other];
        }
    }

    /// Solves every constraint of unsettled bodies and their neighbours in turn for the impulses of the others, several times (nonsmooth
    /// Gauss-Seidel; Jean and Moreau 1992). Sliding contacts keep their direction in a sweep.
    fn sweep(&mut self, times: usize) {
        self.choose();
        let problem = self.problem;
        let SparseWorkspace { rows, newton, impulses, coordinates, moves, responses, .. } = &mut *self.workspace;
        if responses.is_empty() {
            responses.extend(rows.iter().enumerate().map(|(number, rows)| delassus(problem, number, rows)));
        }
        let still = (STILL * self.scale).powi(2);
        for _ in 0..times {
            if self.outcome.work >= self.effort.budget {
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
                let velocity = rows.residual_velocity(newton.pattern.parts.pull(number, coordinates), &before);
                if rows.squared_residual(&before, &velocity) <= still {
                    continue;
                }
                let after: [f64; 3] = match rows.constraint {
                    Constraint::Within(most) => [(before[0] - velocity[0] / rows.own[0]).clamp(-most, most), 0.0, 0.0],
                    Constraint::Contact { friction, tangents } => {
                        let delassus = &responses[number];
                        let mut left = delassus * Vector3::from(before) - Vector3::from(velocity);
                        // Missing rows have no right-hand side.
                        (rows.count..3).for_each(|row| left[row] = 0.0);
                        let holding = rows.holding(&before, &velocity);
                        local::approach(delassus, &left, friction, tangents, holding, ACCURACY).into()
                    }
                };
                let change: [f64; 3] = std::array::from_fn(|row| after[row] - before[row]);
                if change != [0.0; 3] {
                    newton.pattern.parts.push(number, &change, coordinates);
                    impulses[rows.first..][..rows.count].copy_from_slice(&after[..rows.count]);
                }
            }
        }
    }
}

/// Computes a constraint's block of the Delassus matrix. Missing rows have a unit diagonal.
fn delassus(problem: &SparseProblem, number: usize, rows: &Rows) -> Matrix3<f64> {
    let mut delassus = Matrix3::zeros();
    for &(_, entry) in problem.entries_of(number) {
        let entry = Vector3::from(entry);
        delassus += entry * entry.transpose();
    }
    for row in 0..3 {
        delassus[(row, row)] = if row < rows.count { rows.own[row] } else { 1.0 };
    }
    delassus
}
