//! Newton's method for all impulses at once.

use nalgebra::{DMatrix, DVector};

use crate::problem::{Constraint, Problem};

/// What part of Newton's steps is taken, and how many at most, one try after the other from the same start. From a good one two or
/// three whole steps are enough; where those go round in a circle, shorter ones seldom do.
const TRIES: [(f64, usize); 3] = [(1.0, 20), (0.7, 40), (0.4, 40)];

/// Newton's steps, of which each solves the conditions that hold where it is (Alart and Curnier 1991): a contact pushes or not, and
/// holds or slides. They need not make each answer better than the last: where they have to, they end where none is. `None` where
/// they do not settle.
pub(crate) fn solve(problem: &Problem, from: &DVector<f64>, tolerance: f64, steps: &mut usize) -> Option<DVector<f64>> {
    let mut slopes = problem.response.clone();
    TRIES.into_iter().find_map(|(share, most)| {
        let mut impulses = from.clone();
        for _ in 0..=most {
            let mut velocity = problem.velocity(&impulses);
            if problem.residual_at(&impulses, &velocity).worst() <= tolerance {
                return Some(impulses);
            }
            *steps += 1;
            step(problem, &impulses, &mut velocity, &mut slopes)?;
            impulses.axpy(-share, &velocity, 1.0);
        }
        None
    })
}

/// By how much Newton's method moves the impulses: what is to be taken from them, in the place of the velocity that they give.
/// `slopes` is room for a matrix.
fn step(
    problem: &Problem,
    impulses: &DVector<f64>,
    velocity: &mut DVector<f64>,
    slopes: &mut DMatrix<f64>,
) -> Option<()> {
    // The conditions, row by row, and their slopes, transposed, as columns lie together in memory. One that is about a velocity is
    // that row of the response, which is symmetric.
    slopes.copy_from(&problem.response);
    let missed = velocity;
    let set_to = |slopes: &mut DMatrix<f64>, missed: &mut DVector<f64>, row: usize, impulse: f64| {
        slopes.column_mut(row).fill(0.0);
        slopes[(row, row)] = 1.0;
        missed[row] = impulses[row] - impulse;
    };
    for (row, constraint) in problem.constraints() {
        let own = problem.response[(row, row)];
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
                let own = problem.tangent_response(row + 1, tangents);
                let wanted = [0, 1].map(|tangent| {
                    let row = row + 1 + tangent;
                    if tangent < tangents { impulses[row] - missed[row] / own } else { 0.0 }
                });
                let (length, most) = (wanted[0].hypot(wanted[1]), friction * impulses[row]);
                if length <= most {
                    continue;
                }
                let direction = wanted.map(|part| part / length);
                for tangent in 0..tangents {
                    let at = row + 1 + tangent;
                    set_to(slopes, missed, at, most * direction[tangent]);
                    // Of how the direction turns: of each tangent what is across it.
                    for other in 0..tangents {
                        let across = f64::from(u8::from(tangent == other)) - direction[tangent] * direction[other];
                        let share = across * most / length;
                        slopes[(row + 1 + other, at)] -= share;
                        slopes.column_mut(at).axpy(share / own, &problem.response.column(row + 1 + other), 1.0);
                    }
                    slopes[(row, at)] -= friction * direction[tangent];
                }
            }
        }
    }
    eliminate(slopes, missed).then_some(())
}

/// Solves a system of which `slopes` has the equations as columns, for their right sides, in place. Whether there is an answer.
fn eliminate(slopes: &mut DMatrix<f64>, right: &mut DVector<f64>) -> bool {
    let count = right.len();
    let (slopes, right) = (slopes.as_mut_slice(), right.as_mut_slice());
    // Equation by equation; of those that are left the one that says most of an unknown is used for it.
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
        let known: f64 =
            equation[unknown + 1..].iter().zip(&right[unknown + 1..]).map(|(slope, value)| slope * value).sum();
        right[unknown] = (right[unknown] - known) / equation[unknown];
    }
    right.iter().all(|it| it.is_finite())
}
