//! Newton's method for all impulses at once.

use crate::problem::{Constraint, Problem, dot};
use crate::solver::Workspace;

/// Shares of Newton's step with the most steps of each try. Every try starts from the same impulses. From a good start two or three full
/// steps are enough. Where full steps cycle, shorter ones seldom do.
const TRIES: [(f64, usize); 3] = [(1.0, 20), (0.7, 40), (0.4, 40)];
/// The one try from the last step's impulses. They are nearly right, or belong to another motion.
const FIRST_TRY: [(f64, usize); 1] = [(1.0, 8)];

/// Runs Newton's method on the conditions that hold at the present impulses (Alart and Curnier 1991): a contact pushes or not, and holds or
/// slides. No line search: with one, the iteration stalls at points that are not solutions. Returns true if it converged; if not, the
/// impulses stay unchanged.
pub(crate) fn solve(
    problem: &Problem,
    impulses: &mut [f64],
    is_first: bool,
    tolerance: f64,
    steps: &mut usize,
    workspace: &mut Workspace,
) -> bool {
    let tries: &[(f64, usize)] = if is_first { &FIRST_TRY } else { &TRIES };
    let Workspace { trial, velocity, equations } = workspace;
    for &(share, most) in tries {
        trial.clear();
        trial.extend_from_slice(impulses);
        for _ in 0..=most {
            problem.velocity(trial, velocity);
            if problem.residual_at(trial, velocity).worst() <= tolerance {
                impulses.copy_from_slice(trial);
                return true;
            }
            *steps += 1;
            if !step(problem, trial, velocity, equations) {
                return false;
            }
            trial.iter_mut().zip(&*velocity).for_each(|(impulse, step)| *impulse -= share * step);
        }
    }
    false
}

/// Computes one Newton step. On entry `velocity` is the residual velocity. On return it is the step to subtract from the impulses. Returns
/// false if there is no solution. `equations` is a scratch buffer.
fn step(problem: &Problem, impulses: &[f64], velocity: &mut [f64], equations: &mut Vec<f64>) -> bool {
    // One equation per row, with its right-hand side behind it. A condition on a velocity is its row of the Delassus matrix.
    let count = velocity.len();
    let width = width(count);
    // The padding is never read, so it may keep numbers of an earlier problem.
    equations.resize(count * width, 0.0);
    for (row, equation) in equations.chunks_exact_mut(width).enumerate() {
        equation[..count].copy_from_slice(problem.of_row(row));
        equation[count] = velocity[row];
    }
    let set_to = |equation: &mut [f64], row: usize, impulse: f64| {
        equation.fill(0.0);
        equation[row] = 1.0;
        equation[count] = impulses[row] - impulse;
    };
    for (row, constraint) in problem.constraints() {
        let wanted = |row: usize, own: f64| impulses[row] - velocity[row] / own;
        let mut equations = equations.chunks_exact_mut(width).enumerate().skip(row).take(constraint.rows());
        match constraint {
            Constraint::Within(most) => {
                let wanted = wanted(row, problem.own(row));
                if wanted.abs() > most {
                    equations.for_each(|(row, equation)| set_to(equation, row, most.copysign(wanted)));
                }
            }
            Constraint::Contact { .. } if wanted(row, problem.own(row)) <= 0.0 => {
                equations.for_each(|(row, equation)| set_to(equation, row, 0.0));
            }
            Constraint::Contact { tangents: 0, .. } => {}
            Constraint::Contact { friction, tangents } => {
                // The larger response of the two tangents, so a holding contact is not taken for a sliding one.
                let own = (row + 1..=row + tangents).map(|row| problem.own(row)).fold(0.0, f64::max);
                let wanted = [0, 1].map(|it| if it < tangents { wanted(row + 1 + it, own) } else { 0.0 });
                let length = (wanted[0] * wanted[0] + wanted[1] * wanted[1]).sqrt();
                let most = friction * impulses[row];
                if length <= most {
                    continue;
                }
                let direction = wanted.map(|part| part / length);
                equations.next();
                for (tangent, (at, equation)) in equations.enumerate() {
                    set_to(equation, at, most * direction[tangent]);
                    // Derivative of the direction: the part of each tangent across it.
                    for other in 0..tangents {
                        let across = f64::from(u8::from(tangent == other)) - direction[tangent] * direction[other];
                        let share = across * most / length;
                        let response = problem.of_row(row + 1 + other);
                        equation.iter_mut().zip(response).for_each(|(to, from)| *to += share / own * from);
                        equation[row + 1 + other] -= share;
                    }
                    equation[row] -= friction * direction[tangent];
                }
            }
        }
    }
    eliminate(equations, velocity)
}

/// Returns the length of an equation with its right-hand side, padded to a multiple of four for SIMD.
fn width(count: usize) -> usize {
    (count + 1).next_multiple_of(4)
}

/// Solves the equations in place. Returns false if there is no solution.
fn eliminate(equations: &mut [f64], answer: &mut [f64]) -> bool {
    // The loops of the usual sizes are compiled for a constant width: they are so short that their bounds cost more than their arithmetic.
    match width(answer.len()) {
        8 => eliminate_of_width(equations, answer, 8),
        12 => eliminate_of_width(equations, answer, 12),
        16 => eliminate_of_width(equations, answer, 16),
        width => eliminate_of_width(equations, answer, width),
    }
}

/// Solves equations of a width by Gaussian elimination. Each row ends with its right-hand side.
#[inline(always)]
fn eliminate_of_width(equations: &mut [f64], answer: &mut [f64], width: usize) -> bool {
    let count = answer.len();
    // Partial pivoting. The pivot of the next column is found while the rows are at hand.
    let (mut chosen, mut most) = largest(equations.chunks_exact(width).map(|equation| equation[0]));
    for unknown in 0..count {
        if most == 0.0 {
            return false;
        }
        let (before, after) = equations.split_at_mut((unknown + 1) * width);
        let used = &mut before[unknown * width..];
        if chosen > 0 {
            used.swap_with_slice(&mut after[(chosen - 1) * width..][..width]);
        }
        let inverse = 1.0 / used[unknown];
        used[unknown] = inverse;
        // Columns before the pivot are no longer needed, so the blocks of four start at its block.
        let (used, _) = used.as_chunks::<4>();
        let first = (unknown + 1) / 4;
        (chosen, most) = (0, 0.0);
        for (number, equation) in after.chunks_exact_mut(width).enumerate() {
            let factor = equation[unknown] * inverse;
            if factor != 0.0 {
                let (equation, _) = equation.as_chunks_mut::<4>();
                subtract(&mut equation[first..], factor, &used[first..]);
            }
            let size = equation[unknown + 1].abs();
            if size > most {
                (chosen, most) = (number, size);
            }
        }
    }
    for (unknown, equation) in equations.chunks_exact(width).enumerate().rev() {
        let known = dot(&equation[unknown + 1..count], &answer[unknown + 1..]);
        answer[unknown] = (equation[count] - known) * equation[unknown];
    }
    answer.iter().all(|it| it.is_finite())
}

/// Subtracts a multiple of blocks from others. As a function of its own it tells the compiler that they do not overlap.
fn subtract(to: &mut [[f64; 4]], factor: f64, from: &[[f64; 4]]) {
    for (to, from) in to.iter_mut().zip(from) {
        (0..4).for_each(|lane| to[lane] -= factor * from[lane]);
    }
}

/// Returns the number and the size of the largest entry. Both are 0 if there is none but zeros.
fn largest(entries: impl Iterator<Item = f64>) -> (usize, f64) {
    entries.map(f64::abs).enumerate().fold((0, 0.0), |largest, it| if it.1 > largest.1 { it } else { largest })
}
