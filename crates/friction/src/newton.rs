//! Newton's method for all impulses at once.

use nalgebra::{DMatrix, DVector, RowDVector};

use crate::ROWS;
use crate::problem::Problem;

/// What part of Newton's steps is taken, and how many at most, one try after the other from the same start. From a good one two or
/// three whole steps are enough; where those go round in a circle, shorter ones seldom do.
const TRIES: [(f64, usize); 3] = [(1.0, 20), (0.7, 40), (0.4, 40)];

/// Newton's steps, of which each solves the conditions that hold where it is (Alart and Curnier 1991): a contact pushes or not, and
/// holds or slides. They need not make each answer better than the last: where they have to, they end where none is. `None` where
/// they do not settle.
pub(crate) fn solve(problem: &Problem, from: &DVector<f64>, tolerance: f64, steps: &mut usize) -> Option<DVector<f64>> {
    TRIES.into_iter().find_map(|(share, most)| {
        let mut impulses = from.clone();
        for _ in 0..=most {
            if problem.residual(&impulses).worst() <= tolerance {
                return Some(impulses);
            }
            *steps += 1;
            impulses -= step(problem, &impulses)? * share;
        }
        None
    })
}

/// By how much Newton's method moves the impulses: what is to be taken from them.
fn step(problem: &Problem, impulses: &DVector<f64>) -> Option<DVector<f64>> {
    let velocity = &problem.response * impulses - &problem.missing;
    // The conditions, row by row, and their slopes. One that is about a velocity is that row of the response.
    let mut slopes = problem.response.clone();
    let mut missed = velocity.clone();
    let alone = |slopes: &mut DMatrix<f64>, row: usize| {
        slopes.row_mut(row).fill(0.0);
        slopes[(row, row)] = 1.0;
    };
    for (number, contact) in problem.contacts.iter().enumerate() {
        let row = number * ROWS;
        let own = problem.response[(row, row)];
        let pushes = impulses[row] - velocity[row] / own > 0.0;
        if !pushes {
            for row in row..row + ROWS {
                alone(&mut slopes, row);
                missed[row] = impulses[row];
            }
            continue;
        }
        if !contact.is_isotropic {
            alone(&mut slopes, row + 2);
            missed[row + 2] = impulses[row + 2];
        }
        let (own, tangents) = (problem.tangent_response(number), contact.tangents());
        let wanted = impulses.rows(row + 1, tangents) - velocity.rows(row + 1, tangents) / own;
        let (length, most) = (wanted.norm(), contact.friction * impulses[row]);
        if length <= most {
            continue;
        }
        let direction = &wanted / length;
        for tangent in 0..tangents {
            let at = row + 1 + tangent;
            missed[at] = impulses[at] - most * direction[tangent];
            // Of how the direction turns: of each tangent what is across it.
            let mut slope = RowDVector::zeros(impulses.len());
            for other in 0..tangents {
                let across = f64::from(u8::from(tangent == other)) - direction[tangent] * direction[other];
                let share = across * most / length;
                slope[row + 1 + other] -= share;
                slope += problem.response.row(row + 1 + other) * (share / own);
            }
            slope[at] += 1.0;
            slope[row] -= contact.friction * direction[tangent];
            slopes.set_row(at, &slope);
        }
    }
    let step = slopes.lu().solve(&missed)?;
    step.iter().all(|it| it.is_finite()).then_some(step)
}
