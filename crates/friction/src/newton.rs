//! Newton's method for all impulses at once.

use crate::problem::{Constraint, Problem, dot};

/// Shares of Newton's step with the most steps of each try. Every try starts from the same impulses. From a good start two or three full
/// steps are enough. Where full steps cycle, shorter ones seldom do.
const TRIES: [(f64, usize); 3] = [(1.0, 20), (0.7, 40), (0.4, 40)];
/// The one try from the last step's impulses. They are nearly right, or belong to another motion.
const FIRST_TRY: [(f64, usize); 1] = [(1.0, 8)];

/// Scratch buffers that one problem after the other reuses.
#[derive(Debug, Clone, Default)]
pub struct Workspace {
    trial: Vec<f64>,
    velocity: Vec<f64>,
    equations: Equations,
}

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
    let scale = problem.scale();
    for &(share, most) in tries {
        trial.clear();
        trial.extend_from_slice(impulses);
        for _ in 0..=most {
            problem.velocity(trial, velocity);
            if problem.residual_at(trial, velocity, scale).worst() <= tolerance {
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

/// Scratch buffers of a Newton step.
#[derive(Debug, Clone, Default)]
pub(crate) struct Equations {
    /// Rows that have an equation.
    unknown: Vec<usize>,
    /// Rows whose step follows from that of another.
    tied: Vec<Tied>,
    /// One equation for each unknown, with its right-hand side behind it.
    matrix: Vec<f64>,
    /// An equation before the tied rows are put in.
    whole: Vec<f64>,
    answer: Vec<f64>,
}

/// A row whose impulse is known, or in proportion to another: its step is a multiple of that of an unknown, and an offset.
#[derive(Debug, Clone, Copy)]
struct Tied {
    row: usize,
    /// Number among the unknowns.
    to: usize,
    factor: f64,
    offset: f64,
}

/// Computes one Newton step. On entry `velocity` is the residual velocity. On return it is the step to subtract from the impulses. Returns
/// false if there is no solution.
fn step(problem: &Problem, impulses: &[f64], velocity: &mut [f64], equations: &mut Equations) -> bool {
    equations.choose(problem, impulses, velocity);
    let Equations { unknown, tied, matrix, whole, answer } = equations;
    let count = unknown.len();
    let width = width(count);
    // The padding is never read, so it may keep numbers of an earlier problem.
    matrix.resize(count * width, 0.0);
    let put_in = |equation: &mut [f64], whole: &[f64], right: f64| {
        equation.iter_mut().zip(&*unknown).for_each(|(entry, &row)| *entry = whole[row]);
        let mut right = right;
        for &Tied { row, to, factor, offset } in &*tied {
            equation[to] += whole[row] * factor;
            right -= whole[row] * offset;
        }
        equation[count] = right;
    };
    for (equation, &row) in matrix.chunks_exact_mut(width).zip(&*unknown) {
        // A condition on a velocity is its row of the Delassus matrix.
        put_in(equation, problem.of_row(row), velocity[row]);
    }
    // A contact that slides with two tangents.
    for (row, constraint) in problem.constraints() {
        let Constraint::Contact { friction, tangents: 2 } = constraint else { continue };
        let Some(slip) = Slip::of(problem, impulses, velocity, row, friction, 2) else { continue };
        let Ok(first) = unknown.binary_search(&row) else { continue };
        for tangent in 0..2 {
            let at = row + 1 + tangent;
            whole.clear();
            whole.resize(velocity.len(), 0.0);
            whole[at] = 1.0;
            // Derivative of the direction: the part of each tangent across it.
            for other in 0..2 {
                let across = f64::from(u8::from(tangent == other)) - slip.direction[tangent] * slip.direction[other];
                let share = across * slip.most / slip.length;
                let delassus = problem.of_row(row + 1 + other);
                whole.iter_mut().zip(delassus).for_each(|(to, from)| *to += share / slip.own * from);
                whole[row + 1 + other] -= share;
            }
            whole[row] -= friction * slip.direction[tangent];
            let right = impulses[at] - slip.most * slip.direction[tangent];
            put_in(&mut matrix[(first + 1 + tangent) * width..][..width], whole, right);
        }
    }
    answer.resize(count, 0.0);
    if !eliminate(matrix, answer) {
        return false;
    }
    unknown.iter().zip(&*answer).for_each(|(&row, step)| velocity[row] = *step);
    for &Tied { row, to, factor, offset } in &*tied {
        // Without an unknown there is none to follow.
        velocity[row] = if factor == 0.0 { offset } else { factor * answer[to] + offset };
    }
    velocity.iter().all(|it| it.is_finite())
}

/// A contact that slides.
struct Slip {
    /// Direction of the friction in its tangents.
    direction: [f64; 2],
    /// Limit of the friction, N s.
    most: f64,
    /// Impulse that would hold, N s.
    length: f64,
    /// Response of a tangent.
    own: f64,
}

impl Slip {
    /// Returns how a pushing contact slides, or `None` if it holds. `row` is that of its normal.
    fn of(
        problem: &Problem,
        impulses: &[f64],
        velocity: &[f64],
        row: usize,
        friction: f64,
        tangents: usize,
    ) -> Option<Self> {
        // The larger response of the two tangents, so a holding contact is not taken for a sliding one.
        let own = (row + 1..=row + tangents).map(|row| problem.own(row)).fold(0.0, f64::max);
        let wanted =
            [0, 1].map(|it| if it < tangents { impulses[row + 1 + it] - velocity[row + 1 + it] / own } else { 0.0 });
        let length =
            if tangents == 1 { wanted[0].abs() } else { (wanted[0] * wanted[0] + wanted[1] * wanted[1]).sqrt() };
        let most = friction * impulses[row];
        (length > most).then(|| Self { direction: wanted.map(|part| part / length), most, length, own })
    }
}

impl Equations {
    /// Sorts the rows into unknown and tied ones by the conditions that hold at the present impulses.
    fn choose(&mut self, problem: &Problem, impulses: &[f64], velocity: &[f64]) {
        let Self { unknown, tied, .. } = self;
        unknown.clear();
        tied.clear();
        for (row, constraint) in problem.constraints() {
            let rows = row..row + constraint.rows();
            let wanted = || impulses[row] - velocity[row] / problem.own(row);
            match constraint {
                Constraint::Within(most) => {
                    let wanted = wanted();
                    if wanted.abs() > most {
                        let offset = impulses[row] - most.copysign(wanted);
                        tied.push(Tied { row, to: 0, factor: 0.0, offset });
                    } else {
                        unknown.push(row);
                    }
                }
                Constraint::Contact { .. } if wanted() <= 0.0 => {
                    tied.extend(rows.map(|row| Tied { row, to: 0, factor: 0.0, offset: impulses[row] }));
                }
                Constraint::Contact { friction, tangents: 1 } => {
                    unknown.push(row);
                    match Slip::of(problem, impulses, velocity, row, friction, 1) {
                        // Its friction is in proportion to its normal impulse.
                        Some(Slip { direction, most, .. }) => {
                            let [row, to] = [row + 1, unknown.len() - 1];
                            let offset = impulses[row] - most * direction[0];
                            tied.push(Tied { row, to, factor: friction * direction[0], offset });
                        }
                        None => unknown.push(row + 1),
                    }
                }
                Constraint::Contact { .. } => unknown.extend(rows),
            }
        }
    }
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
    true
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
