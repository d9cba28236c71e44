//! Bodies with everything that holds them in one step, solved as one system.

use friction::{Constraint, Problem};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

use crate::{Body, Drive, factor};

/// Part of a tangent's own response that is added to it: contacts of one body that say the same need it to have one answer.
const SOFTNESS: f64 = 1e-6;
/// How often servos that come to their limits are noticed in a step.
const MAX_LIMITED: usize = 8;

/// Where a contact acts: a link of a body, by their numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Side {
    /// Among the bodies of the system.
    pub body: usize,
    /// Among the links of its tree.
    pub link: usize,
}

/// A touch of two bodies, or of one and the world.
#[derive(Debug, Clone, Copy)]
pub struct Contact {
    /// Where, m.
    pub point: Vector3<f64>,
    /// Unit vector from the second to the first.
    pub normal: Vector3<f64>,
    /// In which directions friction acts, unit vectors: of a free roller along its axis alone, otherwise two across each other.
    pub tangents: [Option<Vector3<f64>>; 2],
    /// Coefficient of friction.
    pub friction: f64,
    /// Least speed along the normal at the end of the step, m/s.
    pub target: f64,
    /// How it gives way along the normal and each tangent, m/s per N s.
    pub compliance: [f64; 3],
    /// What is pushed along the normal.
    pub first: Side,
    /// What is pushed against it; `None` is the world.
    pub second: Option<Side>,
    /// Before a step a guess of the impulse on the first, N s; after it what it was.
    pub impulse: Vector3<f64>,
}

/// What a joint does beside its servo: an end, dry friction, a coupling. Or what makes a root follow a velocity.
#[derive(Debug, Clone, Copy)]
pub struct JointRow {
    /// Among the bodies of the system.
    pub body: usize,
    /// Degrees of freedom with their factors.
    pub terms: [Option<(usize, f64)>; 2],
    /// Factors of a free root's generalised velocity, where there are no terms.
    pub root: [f64; 6],
    /// What its impulse may be: a row.
    pub constraint: Constraint,
    /// Speed, or least speed of an end, rad/s or m/s.
    pub target: f64,
    /// How it gives way, speed per impulse.
    pub compliance: f64,
    /// Before a step a guess of the impulse, N m s or N s; after it what it was.
    pub impulse: f64,
}

/// How a step was solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Outcome {
    /// Whether every contact does what it should.
    pub is_settled: bool,
    /// Sweeps over the contacts: none in steady motion.
    pub sweeps: usize,
    /// Steps of Newton's method.
    pub newton_steps: usize,
}

/// Up to three rows that belong together.
struct Block {
    /// Its first row among all.
    row: usize,
    rows: usize,
    parts: [Option<Part>; 2],
}

/// What a block does to one body: for every degree of freedom of a chain an entry for each row, from the root down.
struct Part {
    body: usize,
    tip: usize,
    entries: std::ops::Range<usize>,
}

/// The rows of a step.
#[derive(Default)]
struct Rows {
    blocks: Vec<Block>,
    entries: Vec<[f64; 3]>,
    /// Without contacts, and then multiplied by the inverse of L'.
    missing: Vec<f64>,
    compliance: Vec<f64>,
    constraints: Vec<Constraint>,
    guess: Vec<f64>,
}

/// Finds the velocities of bodies at the end of a step. They stay where they are: [`Body::advance`] moves them.
pub fn step(bodies: &mut [&mut Body], contacts: &mut [Contact], joints: &mut [JointRow], time_step: f64) -> Outcome {
    bodies.iter_mut().for_each(|body| body.prepare(time_step));
    let mut limited = 0;
    loop {
        let (impulses, outcome) = solve(bodies, contacts, joints);
        let rows = impulses.as_slice();
        let mut next = 0;
        let mut take = |count: usize| {
            next += count;
            &rows[next - count..next]
        };
        for contact in &mut *contacts {
            contact.impulse = contact.normal * take(1)[0];
            for tangent in contact.tangents.into_iter().flatten() {
                contact.impulse += tangent * take(1)[0];
            }
        }
        joints.iter_mut().for_each(|joint| joint.impulse = take(1)[0]);
        limited += 1;
        let mut again = 0;
        for body in bodies.iter_mut().filter_map(|body| body.limit_servos().then_some(body)) {
            body.prepare(time_step);
            again += 1;
        }
        if again == 0 || limited == MAX_LIMITED {
            bodies.iter_mut().for_each(|body| std::mem::swap(&mut body.velocity, &mut body.free));
            return outcome;
        }
    }
}

impl Body {
    /// Gives servos that would pass their limits those, whatever the speed. Whether there are any.
    fn limit_servos(&mut self) -> bool {
        let mut is_any = false;
        for (drive, speed) in self.drives.iter_mut().zip(&self.free) {
            let wanted = drive.at_rest - drive.gain * speed;
            if drive.gain > 0.0 && wanted.abs() > drive.most {
                *drive = Drive { at_rest: drive.most.copysign(wanted), gain: 0.0, most: drive.most };
                is_any = true;
            }
        }
        is_any
    }
}

/// Solves for the impulse on every row, and leaves the velocities at the end of the step in the bodies' free ones.
fn solve(bodies: &mut [&mut Body], contacts: &[Contact], joints: &[JointRow]) -> (DVector<f64>, Outcome) {
    let mut rows = Rows::default();
    contacts.iter().for_each(|contact| rows.add_contact(bodies, contact));
    joints.iter().for_each(|joint| rows.add_joint(bodies, joint));
    let Rows { blocks, entries, missing, compliance, constraints, guess } = rows;
    if missing.is_empty() {
        return (DVector::zeros(0), Outcome { is_settled: true, ..Outcome::default() });
    }
    let count = missing.len();
    let mut response = DMatrix::zeros(count, count);
    for (number, block) in blocks.iter().enumerate() {
        for other in &blocks[..=number] {
            let Some(shared) = shared(bodies, &entries, block, other) else { continue };
            for own in 0..block.rows {
                for its in 0..other.rows {
                    response[(block.row + own, other.row + its)] = shared[(own, its)];
                    response[(other.row + its, block.row + own)] = shared[(own, its)];
                }
            }
        }
    }
    for (row, compliance) in compliance.into_iter().enumerate() {
        let own = response[(row, row)];
        response[(row, row)] += if compliance > 0.0 { compliance } else { own * SOFTNESS };
    }
    let problem = Problem { response, missing: DVector::from_vec(missing), constraints };
    let friction::Outcome { impulses, sweeps, newton_steps, is_settled } =
        friction::solve(&problem, DVector::from_vec(guess));
    // The impulses, multiplied by the inverse of L', and then by that of L.
    let mut changes: Vec<Vec<f64>> = bodies.iter().map(|body| vec![0.0; body.free.len()]).collect();
    for block in &blocks {
        let own = &impulses.as_slice()[block.row..][..block.rows];
        for part in block.parts.iter().flatten() {
            let chain = bodies[part.body].tree.chain(part.tip);
            for (&dof, entries) in chain.iter().zip(&entries[part.entries.clone()]) {
                changes[part.body][dof] += entries.iter().zip(own).map(|(entry, impulse)| entry * impulse).sum::<f64>();
            }
        }
    }
    for (body, change) in bodies.iter_mut().zip(&mut changes) {
        factor::solve_lower(&body.tree, &body.factors, change);
        body.free.iter_mut().zip(change).for_each(|(free, change)| *free += *change);
    }
    (impulses, Outcome { is_settled, sweeps, newton_steps })
}

/// The velocity that impulses on the rows of one block give on those of another; `None` where they have no body in common.
fn shared(bodies: &[&mut Body], entries: &[[f64; 3]], one: &Block, other: &Block) -> Option<Matrix3<f64>> {
    let mut sum = None;
    for own in one.parts.iter().flatten() {
        for its in other.parts.iter().flatten().filter(|its| its.body == own.body) {
            let common = bodies[own.body].tree.common(own.tip, its.tip);
            let sum: &mut Matrix3<f64> = sum.get_or_insert_with(Matrix3::zeros);
            let (own, its) = (&entries[own.entries.clone()][..common], &entries[its.entries.clone()][..common]);
            for (own, its) in own.iter().zip(its) {
                for column in 0..3 {
                    for row in 0..3 {
                        sum[(row, column)] += own[row] * its[column];
                    }
                }
            }
        }
    }
    sum
}

impl Rows {
    fn add_contact(&mut self, bodies: &[&mut Body], contact: &Contact) {
        let row = self.missing.len();
        let directions = [Some(contact.normal), contact.tangents[0], contact.tangents[1]];
        let directions: [Vector3<f64>; 3] = directions.map(Option::unwrap_or_default);
        let tangents = contact.tangents.iter().flatten().count();
        let rows = 1 + tangents;
        let mut velocity = [0.0; 3];
        let mut part = |side: Side, sign: f64| {
            let body = &bodies[side.body];
            let (tip, axes) = body.axes_of(side.link)?;
            let at = contact.point - body.centre();
            let start = self.entries.len();
            for (dof, axis) in axes {
                let moved = axis.at(at) * sign;
                let entry = directions.map(|direction| direction.dot(&moved));
                for (velocity, entry) in velocity.iter_mut().zip(entry) {
                    *velocity += entry * body.free[dof];
                }
                self.entries.push(entry);
            }
            factor::solve_chain(&body.tree, &body.factors, tip, &mut self.entries[start..]);
            Some(Part { body: side.body, tip, entries: start..self.entries.len() })
        };
        let parts = [part(contact.first, 1.0), contact.second.and_then(|second| part(second, -1.0))];
        self.blocks.push(Block { row, rows, parts });
        let targets = [contact.target, 0.0, 0.0];
        for (number, direction) in directions.iter().enumerate().take(rows) {
            self.missing.push(targets[number] - velocity[number]);
            self.compliance.push(contact.compliance[number]);
            self.guess.push(contact.impulse.dot(direction));
        }
        self.constraints.push(Constraint::Contact { friction: contact.friction, tangents });
    }

    fn add_joint(&mut self, bodies: &[&mut Body], joint: &JointRow) {
        let body = &bodies[joint.body];
        let mut velocity = 0.0;
        let start = self.entries.len();
        let parts = if joint.terms == [None; 2] {
            velocity += joint.root.iter().zip(&body.free).map(|(factor, speed)| factor * speed).sum::<f64>();
            self.entries.extend(joint.root.map(|factor| [factor, 0.0, 0.0]));
            factor::solve_chain(&body.tree, &body.factors, 5, &mut self.entries[start..]);
            [Some(Part { body: joint.body, tip: 5, entries: start..self.entries.len() }), None]
        } else {
            joint.terms.map(|term| {
                let (dof, factor) = term?;
                velocity += factor * body.free[dof];
                let start = self.entries.len();
                self.entries.resize(start + body.tree.dofs[dof].depth, [0.0; 3]);
                self.entries.push([factor, 0.0, 0.0]);
                factor::solve_chain(&body.tree, &body.factors, dof, &mut self.entries[start..]);
                Some(Part { body: joint.body, tip: dof, entries: start..self.entries.len() })
            })
        };
        self.blocks.push(Block { row: self.missing.len(), rows: 1, parts });
        self.missing.push(joint.target - velocity);
        self.compliance.push(joint.compliance);
        self.guess.push(joint.impulse);
        self.constraints.push(joint.constraint);
    }
}
