//! Newton's method for all impulses at once.

use crate::problem::{Constraint, Problem, dot};
use crate::solver::Workspace;

/// What part of Newton's steps is taken, and how many at most, one try after the other from the same start. From a good one two or
/// three whole steps are enough; where those go round in a circle, shorter ones seldom do.
const TRIES: [(f64, usize); 3] = [(1.0, 20), (0.7, 40), (0.4, 40)];
/// The one try from the impulses of the step before, which are right or nearly so, or of another motion.
const FIRST_TRY: [(f64, usize); 1] = [(1.0, 8)];

/// Newton's steps, of which each solves the conditions that hold where it is (Alart and Curnier 1991): a contact pushes or not, and
/// holds or slides. They need not make each answer better than the last: where they have to, they end where none is. Whether they
/// settle; if not, the impulses stay as they were.
pub(crate) fn solve(
    problem: &Problem,
    impulses: &mut [f64],
    is_first: bool,
    tolerance: f64,
    steps: &mut usize,
    workspace: &mut Workspace,
) -> bool {
    let tries: &[(f64, usize)] = if is_first { &FIRST_TRY } else { &TRIES };
    let Workspace { trial, velocity, slopes } = workspace;
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
            if !step(problem, trial, velocity, slopes) {
                return false;
            }
            trial.iter_mut().zip(&*velocity).for_each(|(impulse, step)| *impulse -= share * step);
        }
    }
    false
}

/// By how much Newton's method moves the impulses: what is to be taken from them, in the place of the velocity that they give. Whether
/// there is an answer. `slopes` is room for a matrix.
fn step(problem: &Problem, impulses: &[f64], velocity: &mut [f64], slopes: &mut Vec<f64>) -> bool {
    // The conditions, row by row, and their slopes. One that is about a velocity is that row of the response.
    slopes.clear();
    slopes.extend_from_slice(&problem.response);
    let (count, missed) = (velocity.len(), velocity);
    let set_to = |slopes: &mut [f64], missed: &mut [f64], row: usize, impulse: f64| {
        slopes[row * count..][..count].fill(0.0);
        slopes[row * (count + 1)] = 1.0;
        missed[row] = impulses[row] - impulse;
    };
    for (row, constraint) in problem.constraints() {
        let own = problem.own(row);
        match constraint {
            Constraint::Within(most) => {
                let wanted = impulses[row] - missed[row] / own;
                if wanted.abs() > most {
                    set_to(slopes, missed, row, most.copysign(wanted));
                }
            }
            Constraint::Contact { tangents, .. } if impulses[row] - missed[row] / own <= 0.0 => {
                (row..=row + tangents).for_each(|row| set_to(slopes, missed, row, 0.0));
            }
            Constraint::Contact { tangents: 0, .. } => {}
            Constraint::Contact { friction, tangents } => {
                // Of the lighter tangent, so that one that holds is not taken for one that slides.
                let own = (row + 1..=row + tangents).map(|row| problem.own(row)).fold(0.0, f64::max);
                let wanted = [0, 1].map(|tangent| {
                    let row = row + 1 + tangent;
                    if tangent < tangents { impulses[row] - missed[row] / own } else { 0.0 }
                });
                let length = (wanted[0] * wanted[0] + wanted[1] * wanted[1]).sqrt();
                let most = friction * impulses[row];
                if length <= most {
                    continue;
                }
                let direction = wanted.map(|part| part / length);
                for tangent in 0..tangents {
                    let at = row + 1 + tangent;
                    set_to(slopes, missed, at, most * direction[tangent]);
                    let slope = &mut slopes[at * count..][..count];
                    // Of how the direction turns: of each tangent what is across it.
                    for other in 0..tangents {
                        let across = f64::from(u8::from(tangent == other)) - direction[tangent] * direction[other];
                        let share = across * most / length;
                        let response = problem.of_row(row + 1 + other);
                        slope.iter_mut().zip(response).for_each(|(to, from)| *to += share / own * from);
                        slope[row + 1 + other] -= share;
                    }
                    slope[row] -= friction * direction[tangent];
                }
            }
        }
    }
    eliminate(slopes, missed)
}

/// Solves equations, row after row, for their right sides, in place. Whether there is an answer.
fn eliminate(slopes: &mut [f64], right: &mut [f64]) -> bool {
    let count = right.len();
    // Of the equations that are left the one that says most of an unknown is used for it.
    for unknown in 0..count {
        let size = |equation: &usize| slopes[equation * count + unknown].abs();
        let Some(chosen) = (unknown..count).max_by(|a, b| size(a).total_cmp(&size(b))) else { return false };
        if chosen != unknown {
            let (before, after) = slopes.split_at_mut(chosen * count);
            before[unknown * count..][..count].swap_with_slice(&mut after[..count]);
            right.swap(unknown, chosen);
        }
        let (used, rest) = slopes.split_at_mut((unknown + 1) * count);
        let used = &used[unknown * count..];
        if used[unknown] == 0.0 {
            return false;
        }
        for (other, equation) in rest.chunks_exact_mut(count).enumerate() {
            let factor = equation[unknown] / used[unknown];
            if factor != 0.0 {
                right[unknown + 1 + other] -= factor * right[unknown];
                let pairs = equation[unknown + 1..].iter_mut().zip(&used[unknown + 1..]);
                pairs.for_each(|(to, from)| *to -= factor * from);
            }
        }
    }
    for unknown in (0..count).rev() {
        let equation = &slopes[unknown * count..][..count];
        let known = dot(&equation[unknown + 1..], &right[unknown + 1..]);
        right[unknown] = (right[unknown] - known) / equation[unknown];
    }
    right.iter().all(|it| it.is_finite())
}
