//! Sparse problems of random heaps. Every answer is checked against the Delassus matrix, which the solver never forms.

use friction::{Constraint, Effort, Problem, SparseProblem, SparseWorkspace, TOLERANCE, solve_sparse};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A budget that no problem here should need.
const PLENTY: Effort = Effort { enough: 0.0, budget: 50_000_000, is_again: false };

/// Coordinates of a body: six of its root, and two wheels.
const SIZE: usize = 8;

/// Builds a row of bodies. Each stands on the ground at two to four contacts and touches the next at one to three. The first contact with the
/// ground is that of one wheel, and all others are that of the other.
fn heap(count: usize, rng: &mut ChaCha8Rng) -> SparseProblem {
    let bodies = (0..=count).map(|body| SIZE * body).collect();
    let mut problem = SparseProblem { bodies, ..SparseProblem::default() };
    for body in 0..count {
        for number in 0..rng.random_range(2..=4) {
            add(&mut problem, &[body], Some(6 + usize::from(number > 0)), rng);
        }
        for _ in 0..rng.random_range(1..=3) {
            if body + 1 < count {
                add(&mut problem, &[body, body + 1], None, rng);
            }
        }
    }
    problem
}

/// Adds a contact of one body or two, or sometimes a joint with dry friction. `wheel` is the coordinate of a wheel that it touches.
fn add(problem: &mut SparseProblem, bodies: &[usize], wheel: Option<usize>, rng: &mut ChaCha8Rng) {
    let constraint = match rng.random_range(0..10) {
        0 => Constraint::Within(rng.random_range(0.01..0.5)),
        1 => Constraint::Contact { friction: 0.0, tangents: 0 },
        it => Constraint::Contact { friction: rng.random_range(0.1..1.0), tangents: 1 + usize::from(it > 3) },
    };
    let start = problem.entries.len();
    let sizes = [0, 1, 2].map(|row| if row < constraint.rows() { 0.3 } else { 0.0 });
    for coordinate in bodies.iter().flat_map(|body| (0..6).chain(wheel).map(move |own| SIZE * body + own)) {
        let entry = sizes.map(|size| if size > 0.0 { rng.random_range(-size..size) } else { 0.0 });
        problem.entries.push((coordinate, entry));
    }
    for row in 0..constraint.rows() {
        let own: f64 = problem.entries[start..].iter().map(|(_, entry)| entry[row] * entry[row]).sum();
        problem.compliance.push(own * if bodies.len() > 1 { 1e-2 } else { 1e-3 });
        problem.right_side.push(rng.random_range(if row == 0 { -0.1..0.5 } else { -0.3..0.3 }));
    }
    problem.constraints.push(constraint);
    problem.ranges.push(start..problem.entries.len());
}

/// Converts the problem to one with a Delassus matrix.
fn dense(problem: &SparseProblem) -> Problem {
    let count = problem.right_side.len();
    let mut columns = vec![vec![0.0; *problem.bodies.last().unwrap_or(&0)]; count];
    let mut first = 0;
    for (constraint, range) in problem.constraints.iter().zip(&problem.ranges) {
        for (coordinate, entry) in &problem.entries[range.clone()] {
            (0..constraint.rows()).for_each(|row| columns[first + row][*coordinate] = entry[row]);
        }
        first += constraint.rows();
    }
    let dot = |one: &[f64], other: &[f64]| one.iter().zip(other).map(|(one, other)| one * other).sum::<f64>();
    let entry = |row: usize, column: usize| {
        let compliance = if row == column { problem.compliance[row] } else { 0.0 };
        dot(&columns[row], &columns[column]) + compliance
    };
    Problem {
        delassus: (0..count * count).map(|place| entry(place / count, place % count)).collect(),
        right_side: problem.right_side.clone(),
        constraints: problem.constraints.clone(),
    }
}

#[test]
fn what_settles_is_right_and_nearly_all_does() {
    let (mut rng, mut unsettled, mut worst) = (ChaCha8Rng::seed_from_u64(1), 0, 0.0_f64);
    let mut workspace = SparseWorkspace::default();
    for number in 0..300 {
        let problem = heap(2 + number % 12, &mut rng);
        let mut impulses = vec![0.0; problem.right_side.len()];
        let outcome = solve_sparse(&problem, &mut impulses, PLENTY, &mut workspace);
        let residual = dense(&problem).residual(&impulses).worst();
        assert!((residual - outcome.residual).abs() < 1e-9, "{number}: {residual:e}, said {:e}", outcome.residual);
        assert_eq!(outcome.is_settled, outcome.residual <= TOLERANCE, "{number}");
        unsettled += usize::from(!outcome.is_settled);
        worst = worst.max(residual);
        // In steady motion the last step's impulses are the answer.
        if outcome.is_settled {
            let again = solve_sparse(&problem, &mut impulses, PLENTY, &mut workspace);
            assert_eq!((again.sweeps, again.newton_steps), (0, 0), "{number}");
        }
    }
    println!("{unsettled} of 300 not settled, at worst {worst:.1e}");
    assert!(unsettled <= 3, "{unsettled} not settled");
}

/// The answer is finite for any budget, and the search ends soon after the budget.
#[test]
fn a_budget_ends_the_search() {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let problem = heap(20, &mut rng);
    let mut last = f64::INFINITY;
    for budget in [0, 100_000, PLENTY.budget] {
        let mut impulses = vec![0.0; problem.right_side.len()];
        let outcome =
            solve_sparse(&problem, &mut impulses, Effort { budget, ..PLENTY }, &mut SparseWorkspace::default());
        assert!(impulses.iter().all(|it| it.is_finite()));
        assert!(outcome.work <= budget + 400_000, "{} of {budget}", outcome.work);
        assert!(outcome.residual <= last, "more work makes no worse answer");
        last = outcome.residual;
    }
    assert!(last <= TOLERANCE, "{last:e}");
}

/// Twice as many bodies take about twice as many multiplications: work does not grow with the square.
#[test]
fn work_grows_with_the_bodies() {
    let work = |count: usize| {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let problem = heap(count, &mut rng);
        let mut impulses = vec![0.0; problem.right_side.len()];
        let outcome = solve_sparse(&problem, &mut impulses, PLENTY, &mut SparseWorkspace::default());
        outcome.work as f64 / (outcome.newton_steps + outcome.sweeps).max(1) as f64 / count as f64
    };
    let (few, many) = (work(10), work(320));
    assert!(many < 3.0 * few, "{few:.0} multiplications a body and step of 10 bodies, {many:.0} of 320");
}
