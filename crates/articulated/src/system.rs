//! Bodies with everything that holds them in one step, solved as one system.

use friction::{Constraint, Problem, SparseProblem};
use nalgebra::Vector3;

use crate::{Body, Drive, factor};

/// Part of a tangent's own response that is added to it: contacts of one body that say the same need it to have one answer.
const SOFTNESS: f64 = 1e-6;
/// The same part between two bodies. It makes Newton's method settle in heaps, where many contacts hold each other up; a contact that
/// holds creeps by a thousandth of the velocity that its friction stops in a step.
const SOFTNESS_BETWEEN: f64 = 1e-3;

/// Rows of a single body up to which its dense system is solved: nearly all share its root. Robots in steady motion have up to 60.
const DENSE_ROWS: usize = 96;
/// Multiplications that a step of several bodies may take: so many for each of a few, at most so many for all of these, and so many more for
/// each. A millisecond has about a million. Less is no faster: an answer that misses is a bad start for the next step.
const WORK: [u64; 3] = [500_000, 3_000_000, 30_000];

/// Most solutions of several bodies in a step: each may find servos that pass their limits, which the next one holds there.
const MAX_PASSES: usize = 4;

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
    /// Multiplications that the system took, roughly; 0 of a small single body.
    pub work: u64,
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

/// Room that one step after the other can use.
#[derive(Default)]
pub struct Workspace {
    blocks: Vec<Block>,
    /// Rows of the contacts, multiplied by the inverse of L'.
    entries: Vec<[f64; 3]>,
    compliance: Vec<f64>,
    problem: Problem,
    sparse: SparseProblem,
    impulses: Vec<f64>,
    /// Change of every body's velocity by the impulses, multiplied likewise.
    change: Vec<f64>,
    /// Where each body's part of it begins.
    places: Vec<usize>,
    friction: friction::Workspace,
    sparse_friction: friction::SparseWorkspace,
    /// Multiplications that are left for the step of several bodies.
    budget: u64,
    /// Servos that would pass their limits, as rows that do not.
    limited: Vec<JointRow>,
}

/// Returns the multiplications after which the search for the impulses of so many bodies ends with its next step.
pub fn most_work(bodies: usize) -> u64 {
    let [of_few, most, each] = WORK;
    let bodies = bodies as u64;
    (of_few * bodies).min(most) + each * bodies
}

/// Finds the velocities of bodies at the end of a step. They stay where they are: [`Body::advance`] moves them.
pub fn step(
    bodies: &mut [&mut Body],
    contacts: &mut [Contact],
    joints: &mut [JointRow],
    time_step: f64,
    workspace: &mut Workspace,
) -> Outcome {
    workspace.limited.clear();
    workspace.budget = most_work(bodies.len());
    if bodies.len() > 1 {
        // Each that turns out to be limited only later takes another solution of the whole system.
        for (number, body) in bodies.iter_mut().enumerate() {
            body.limit_servos(number, time_step, Speeds::Present, &mut workspace.limited);
        }
    }
    bodies.iter_mut().for_each(|body| body.prepare(time_step));
    let (mut work, mut passes) = (0, 0);
    loop {
        let outcome = workspace.solve(bodies, contacts, joints);
        work += outcome.work;
        passes += 1;
        let rows = workspace.impulses.as_slice();
        let mut next = 0;
        let mut take = || {
            next += 1;
            rows[next - 1]
        };
        for contact in &mut *contacts {
            contact.impulse = contact.normal * take();
            for tangent in contact.tangents.into_iter().flatten() {
                contact.impulse += tangent * take();
            }
        }
        joints.iter_mut().for_each(|joint| joint.impulse = take());
        let before = workspace.limited.len();
        for (number, body) in bodies.iter_mut().enumerate() {
            body.limit_servos(number, time_step, Speeds::Next, &mut workspace.limited);
        }
        let is_limited = workspace.limited.len() == before;
        if is_limited || bodies.len() > 1 && passes == MAX_PASSES {
            bodies.iter_mut().for_each(|body| std::mem::swap(&mut body.velocity, &mut body.free));
            return Outcome { work, is_settled: outcome.is_settled && is_limited, ..outcome };
        }
        bodies.iter_mut().for_each(|body| body.prepare(time_step));
    }
}

/// Speeds by which servos are judged.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Speeds {
    /// Those before the step.
    Present,
    /// Those after it, as far as they are known.
    Next,
}

impl Body {
    /// Makes rows of the servos that would pass their limits at some speeds: a row gives way as its servo does, and gives no more than it
    /// can. The body has a number among all.
    fn limit_servos(&mut self, number: usize, time_step: f64, speeds: Speeds, limited: &mut Vec<JointRow>) {
        let speeds = if speeds == Speeds::Present { &self.velocity } else { &self.free };
        for (dof, (drive, speed)) in self.drives.iter_mut().zip(speeds).enumerate() {
            let Drive { at_rest, gain, most } = *drive;
            let wanted = at_rest - gain * speed;
            if gain > 0.0 && wanted.abs() > most {
                *drive = Drive::default();
                limited.push(JointRow {
                    body: number,
                    terms: [Some((dof, 1.0)), None],
                    root: [0.0; 6],
                    constraint: Constraint::Within(most * time_step),
                    target: at_rest / gain,
                    compliance: 1.0 / (gain * time_step),
                    impulse: (most * time_step).copysign(wanted),
                });
            }
        }
    }
}

/// The velocity that impulses on the rows of one block give on those of another, column by column; `None` where they have no body in
/// common.
fn shared(bodies: &[&mut Body], entries: &[[f64; 3]], one: &Block, other: &Block) -> Option<[[f64; 3]; 3]> {
    let mut sum = None;
    for own in one.parts.iter().flatten() {
        for its in other.parts.iter().flatten().filter(|its| its.body == own.body) {
            let common = bodies[own.body].tree.common(own.tip, its.tip);
            let sum: &mut [[f64; 3]; 3] = sum.get_or_insert([[0.0; 3]; 3]);
            let (own, its) = (&entries[own.entries.clone()][..common], &entries[its.entries.clone()][..common]);
            for (own, its) in own.iter().zip(its) {
                for column in 0..3 {
                    for row in 0..3 {
                        sum[column][row] += own[row] * its[column];
                    }
                }
            }
        }
    }
    sum
}

impl Workspace {
    /// Solves for the impulse on every row, and leaves the velocities at the end of the step in the bodies' free ones.
    fn solve(&mut self, bodies: &mut [&mut Body], contacts: &[Contact], joints: &[JointRow]) -> Outcome {
        self.blocks.clear();
        self.entries.clear();
        self.compliance.clear();
        self.impulses.clear();
        self.problem.missing.clear();
        self.problem.constraints.clear();
        contacts.iter().for_each(|contact| self.add_contact(bodies, contact));
        joints.iter().for_each(|joint| self.add_joint(bodies, joint));
        let limited = std::mem::take(&mut self.limited);
        limited.iter().for_each(|servo| self.add_joint(bodies, servo));
        self.limited = limited;
        let count = self.impulses.len();
        if count == 0 {
            return Outcome { is_settled: true, ..Outcome::default() };
        }
        let is_small = bodies.len() == 1 && count <= DENSE_ROWS;
        let outcome = if is_small { self.solve_dense(bodies) } else { self.solve_sparse(bodies) };
        self.apply(bodies);
        outcome
    }

    /// Finds the impulses of one body, whose rows nearly all share its root, by its Delassus matrix.
    fn solve_dense(&mut self, bodies: &[&mut Body]) -> Outcome {
        let Self { blocks, entries, compliance, problem, impulses, friction, .. } = self;
        let count = impulses.len();
        let response = &mut problem.response;
        response.clear();
        response.resize(count * count, 0.0);
        for (number, block) in blocks.iter().enumerate() {
            for other in &blocks[..=number] {
                let Some(shared) = shared(bodies, entries, block, other) else { continue };
                for (its, column) in shared.iter().enumerate().take(other.rows) {
                    for (own, &velocity) in column.iter().enumerate().take(block.rows) {
                        response[(block.row + own) * count + other.row + its] = velocity;
                        response[(other.row + its) * count + block.row + own] = velocity;
                    }
                }
            }
        }
        for (row, &compliance) in compliance.iter().enumerate() {
            let own = &mut response[row * (count + 1)];
            *own += if compliance > 0.0 { compliance } else { *own * SOFTNESS };
        }
        let friction::Outcome { sweeps, newton_steps, is_settled } = friction::solve(problem, impulses, friction);
        Outcome { is_settled, sweeps, newton_steps, work: 0 }
    }

    /// Finds the impulses of several bodies, each of which touches a few others.
    fn solve_sparse(&mut self, bodies: &[&mut Body]) -> Outcome {
        let Self { blocks, entries, compliance, problem, sparse, impulses, sparse_friction, budget, .. } = self;
        sparse.clear();
        let mut next = 0;
        sparse.bodies.extend(bodies.iter().map(|body| {
            next += body.free.len();
            next - body.free.len()
        }));
        sparse.bodies.push(next);
        sparse.constraints.append(&mut problem.constraints);
        sparse.missing.append(&mut problem.missing);
        for block in blocks {
            let start = sparse.entries.len();
            for part in block.parts.iter().flatten() {
                let first = sparse.bodies[part.body];
                let chain = bodies[part.body].tree.chain(part.tip);
                for (&dof, &entry) in chain.iter().zip(&entries[part.entries.clone()]) {
                    let known = sparse.entries[start..].iter_mut().find(|(coordinate, _)| *coordinate == first + dof);
                    match known {
                        Some((_, sum)) => sum.iter_mut().zip(entry).for_each(|(sum, entry)| *sum += entry),
                        None => sparse.entries.push((first + dof, entry)),
                    }
                }
            }
            let own = &mut sparse.entries[start..];
            own.sort_unstable_by_key(|(coordinate, _)| *coordinate);
            let [first, second] = block.parts.each_ref().map(|part| part.as_ref().map(|part| part.body));
            let softness = if second.is_some() && first != second { SOFTNESS_BETWEEN } else { SOFTNESS };
            for row in 0..block.rows {
                let given = compliance[block.row + row];
                let response: f64 = own.iter().map(|(_, entry)| entry[row] * entry[row]).sum();
                sparse.compliance.push(if given > 0.0 { given } else { response * softness });
            }
            sparse.ranges.push(start..sparse.entries.len());
        }
        let found = friction::solve_sparse(sparse, impulses, *budget, sparse_friction);
        let friction::SparseOutcome { sweeps, newton_steps, work, is_settled, .. } = found;
        *budget = budget.saturating_sub(work);
        Outcome { is_settled, sweeps, newton_steps, work }
    }

    /// Adds what the impulses give to the bodies' free velocities.
    fn apply(&mut self, bodies: &mut [&mut Body]) {
        let Self { blocks, entries, impulses, change, places, .. } = self;
        places.clear();
        let mut next = 0;
        for body in bodies.iter() {
            places.push(next);
            next += body.free.len();
        }
        change.clear();
        change.resize(next, 0.0);
        for block in blocks.iter() {
            let own = &impulses[block.row..][..block.rows];
            for part in block.parts.iter().flatten() {
                let change = &mut change[places[part.body]..];
                let chain = bodies[part.body].tree.chain(part.tip);
                for (&dof, entries) in chain.iter().zip(&entries[part.entries.clone()]) {
                    change[dof] += entries.iter().zip(own).map(|(entry, impulse)| entry * impulse).sum::<f64>();
                }
            }
        }
        for (body, &place) in bodies.iter_mut().zip(&*places) {
            let change = &mut change[place..][..body.free.len()];
            factor::solve_lower(&body.tree, &body.factors, change);
            body.free.iter_mut().zip(change.iter()).for_each(|(free, change)| *free += *change);
        }
    }

    fn add_contact(&mut self, bodies: &[&mut Body], contact: &Contact) {
        let row = self.impulses.len();
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
            self.problem.missing.push(targets[number] - velocity[number]);
            self.compliance.push(contact.compliance[number]);
            self.impulses.push(contact.impulse.dot(direction));
        }
        self.problem.constraints.push(Constraint::Contact { friction: contact.friction, tangents });
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
        self.blocks.push(Block { row: self.impulses.len(), rows: 1, parts });
        self.problem.missing.push(joint.target - velocity);
        self.compliance.push(joint.compliance);
        self.impulses.push(joint.impulse);
        self.problem.constraints.push(joint.constraint);
    }
}
