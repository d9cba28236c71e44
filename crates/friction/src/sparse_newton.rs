//! One Newton step of a sparse problem, with the impulses eliminated instead of the velocities.
//!
//! The linearised conditions of a constraint give its impulses as `start - gain velocity`. Inserted into the equation of the coordinates,
//! they leave one system: the identity plus each constraint's gain on the coordinates that it touches.

use crate::block_lu::Pattern;
use crate::problem::Constraint;
use crate::sparse::{Rows, SparseProblem};

/// The linearised conditions of one constraint: its impulses are `start` less `gain` times its velocity.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Conditions {
    gain: [[f64; 3]; 3],
    start: [f64; 3],
}

impl Conditions {
    /// Leaves out a coordinate that no other constraint touches, given by its entries on the rows. Its equation is `speed = entries'
    /// impulses`, so the velocity on the rows follows from that of the other coordinates.
    fn leave_out(&mut self, entry: [f64; 3]) {
        let Self { gain, start } = self;
        let gained = gain.map(|row| dot(row, entry));
        let gains: [f64; 3] = std::array::from_fn(|column| (0..3).map(|row| entry[row] * gain[row][column]).sum());
        let whole = 1.0 + dot(entry, gained);
        let pushed = dot(entry, *start);
        for row in 0..3 {
            let share = gained[row] / whole;
            start[row] -= share * pushed;
            (0..3).for_each(|column| gain[row][column] -= share * gains[column]);
        }
    }
}

fn dot(one: [f64; 3], other: [f64; 3]) -> f64 {
    one[0] * other[0] + one[1] * other[1] + one[2] * other[2]
}

/// Scratch buffers of a step.
#[derive(Debug, Clone, Default)]
pub(crate) struct Newton {
    pub(crate) pattern: Pattern,
    matrix: Vec<f64>,
    /// The right-hand side; after the solution, the coordinates at the end of a full step.
    right: Vec<f64>,
    conditions: Vec<(usize, Conditions)>,
}

impl Newton {
    /// Moves the impulses by a share of one step, and the coordinates with them. Only bodies marked in `moves` take part. Constraints
    /// between these and others keep their impulses. `velocities` are the residual velocities, m/s. Adds the multiplications to `work`.
    /// Returns false if there is no solution.
    #[allow(clippy::too_many_arguments)]
    pub(crate) fn step(
        &mut self,
        problem: &SparseProblem,
        rows: &[Rows],
        moves: &[bool],
        velocities: &[[f64; 3]],
        share: f64,
        impulses: &mut [f64],
        coordinates: &mut [f64],
        work: &mut u64,
    ) -> bool {
        let Self { pattern, matrix, right, conditions } = self;
        pattern.start(moves, matrix);
        right.clear();
        right.resize(coordinates.len(), 0.0);
        conditions.clear();
        for (number, own) in rows.iter().enumerate() {
            let [one, other] = own.bodies.map(|body| moves[body]);
            if !one && !other {
                continue;
            }
            let impulse = own.of(impulses);
            if !one || !other {
                pattern.parts.push_nodes(number, &impulse, right);
                continue;
            }
            let mut linear = linearise(own, &impulse, &velocities[number]);
            if let Some(alone) = pattern.parts.alone(number) {
                linear.leave_out(alone.entry);
            }
            pattern.parts.push_nodes(number, &linear.start, right);
            if linear.gain[0][0] != 0.0 {
                *work += pattern.add(number, &linear.gain, matrix);
            }
            conditions.push((number, linear));
        }
        let Some(spent) = pattern.solve(matrix, right, moves) else { return false };
        *work += spent + 9 * problem.entries.len() as u64;
        let mut is_finite = true;
        for &(number, Conditions { gain, start }) in &*conditions {
            let own = &rows[number];
            let velocity = pattern.parts.pull_nodes(number, right);
            let mut change = [0.0; 3];
            for row in 0..own.count {
                let next = start[row] - (0..3).map(|column| gain[row][column] * velocity[column]).sum::<f64>();
                let impulse = &mut impulses[own.first + row];
                change[row] = share * (next - *impulse);
                *impulse += change[row];
                is_finite &= impulse.is_finite();
            }
            pattern.parts.push(number, &change, coordinates);
        }
        is_finite
    }
}

/// Linearises the conditions of a constraint at its impulse and residual velocity (Alart and Curnier 1991).
fn linearise(rows: &Rows, impulse: &[f64; 3], velocity: &[f64; 3]) -> Conditions {
    let Rows { own, right_side, compliance, .. } = rows;
    let mut conditions = Conditions::default();
    let hold = |row: usize, Conditions { gain, start }: &mut Conditions| {
        gain[row][row] = 1.0 / compliance[row];
        start[row] = right_side[row] / compliance[row];
    };
    let wanted = |row: usize, own: f64| impulse[row] - velocity[row] / own;
    match rows.constraint {
        Constraint::Within(most) => {
            let wanted = wanted(0, own[0]);
            if wanted.abs() > most {
                conditions.start[0] = most.copysign(wanted);
            } else {
                hold(0, &mut conditions);
            }
        }
        Constraint::Contact { .. } if wanted(0, own[0]) <= 0.0 => {}
        Constraint::Contact { friction, tangents } => {
            hold(0, &mut conditions);
            let wanted = rows.holding(impulse, velocity);
            let length = (wanted[0] * wanted[0] + wanted[1] * wanted[1]).sqrt();
            let most = friction * impulse[0].max(0.0);
            if length <= most {
                (1..=tangents).for_each(|row| hold(row, &mut conditions));
            } else if tangents > 0 {
                slide(rows, friction, wanted.map(|it| it / length), most / length, &mut conditions);
            }
        }
    }
    conditions
}

/// Linearises the friction of a contact that slides along a direction. `share` is the limit of friction over the impulse that would hold.
fn slide(rows: &Rows, friction: f64, direction: [f64; 2], share: f64, conditions: &mut Conditions) {
    let Rows { right_side, compliance, count, grip: [_, grip], .. } = rows;
    let (tangents, Conditions { gain, start }) = (count - 1, conditions);
    // `left` times the tangent impulses equals friction times the normal impulse along the direction, plus `turn` times the
    // right-hand side: the direction follows the slip.
    let (mut left, mut turn) = ([[0.0; 2]; 2], [[0.0; 2]; 2]);
    for row in 0..2 {
        for column in 0..2 {
            let unit = f64::from(u8::from(row == column));
            if row >= tangents || column >= tangents {
                left[row][column] = unit;
                continue;
            }
            let across = (unit - direction[row] * direction[column]) * share;
            left[row][column] = unit - across * (1.0 - compliance[1 + column] * grip);
            turn[row][column] = across * grip;
        }
    }
    let determinant = left[0][0] * left[1][1] - left[0][1] * left[1][0];
    let inverse = [[left[1][1], -left[0][1]], [-left[1][0], left[0][0]]].map(|row| row.map(|it| it / determinant));
    for row in 0..tangents {
        let along: f64 = (0..tangents).map(|it| inverse[row][it] * friction * direction[it]).sum();
        gain[1 + row][0] = along * gain[0][0];
        start[1 + row] = along * start[0];
        for column in 0..tangents {
            let turned: f64 = (0..tangents).map(|it| inverse[row][it] * turn[it][column]).sum();
            gain[1 + row][1 + column] = turned;
            start[1 + row] += turned * right_side[1 + column];
        }
    }
}
