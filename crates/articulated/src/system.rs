//! One step of bodies with their contacts and joints, solved as one system.

use friction::{Constraint, Effort, Problem, SparseProblem};
use nalgebra::Vector3;

use crate::{Body, Drive, factor, inertia, root};

/// Share of a tangent's own response that is added to it. Nearly equal contacts of one body need it for a unique answer.
const SOFTNESS: f64 = 1e-6;
/// Share that is added in a system of several bodies. It makes Newton's method converge in heaps, where many contacts hold each other up: it
/// alternates less between holding and sliding. A tangent gives way by the difference to the impulse that it remembers.
const SOFTNESS_TOGETHER: f64 = 1e-1;

/// Least compliance of a row, m/s per N s. A contact of a robot that is fixed to the ground may have a direction in which nothing moves.
const LEAST_COMPLIANCE: f64 = 1e-10;

/// Largest number of rows of a single body for the dense solver: nearly all rows share its root. Robots in steady motion have up to 60.
const DENSE_ROWS: usize = 96;
/// Multiplications that a step of several bodies may take: for each of the first [`FEW`] bodies, and for each of all. A millisecond has
/// about a million. A smaller budget is no faster, as an inaccurate answer is a bad start for the next step.
const WORK: [u64; 2] = [500_000, 30_000];
const FEW: usize = 6;
/// Residual velocity that is good enough between bodies after a Newton step, m/s. Most further steps chase single contacts that alternate
/// between holding and sliding. Bodies at rest are solved exactly, as their contacts do not change in the step.
const ENOUGH: f64 = 1e-3;

/// Most solutions of several bodies in a step. Each may find servos beyond their limits, which the next one holds there.
const MAX_PASSES: usize = 4;

/// A side of a contact: a link of a body, by their numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Side {
    /// Number among the bodies of the system.
    pub body: usize,
    /// Number among the links of the body's tree.
    pub link: usize,
}

/// A contact of two bodies, or of a body and the world.
#[derive(Debug, Clone, Copy)]
pub struct Contact {
    /// Contact point, m.
    pub point: Vector3<f64>,
    /// Unit vector from the second side to the first.
    pub normal: Vector3<f64>,
    /// Directions of friction, unit vectors: one along the axis of a free roller, otherwise two at right angles.
    pub tangents: [Option<Vector3<f64>>; 2],
    /// Coefficient of friction.
    pub friction: f64,
    /// Least speed along the normal at the end of the step, m/s.
    pub target: f64,
    /// Compliance along the normal and each tangent, m/s per N s.
    pub compliance: [f64; 3],
    /// Side that is pushed along the normal.
    pub first: Side,
    /// Side that is pushed against it; `None` is the world.
    pub second: Option<Side>,
    /// Velocity of the world's surface at the contact, m/s, in world axes; zero if the second side is a body.
    pub drift: Vector3<f64>,
    /// Impulse on the first side, N s: a guess before a step, the result after it.
    pub impulse: Vector3<f64>,
    /// Impulse that the tangents remember, N s: that of the last step if the contact is not new. Among several bodies they give way by the
    /// difference to it, so a load that stays does not make them creep.
    pub memory: Vector3<f64>,
}

/// A row of a joint besides its servo: an end, dry friction or a coupling. Also a row that makes a root follow a velocity.
#[derive(Debug, Clone, Copy)]
pub struct JointRow {
    /// Number among the bodies of the system.
    pub body: usize,
    /// Degrees of freedom with their factors.
    pub terms: [Option<(usize, f64)>; 2],
    /// Factors of a free root's generalised velocity, used if there are no terms.
    pub root: [f64; 6],
    /// Bounds of the impulse, for one row.
    pub constraint: Constraint,
    /// Target speed, or least speed of an end, rad/s or m/s.
    pub target: f64,
    /// Compliance, speed per impulse.
    pub compliance: f64,
    /// Impulse, N m s or N s: a guess before a step, the result after it.
    pub impulse: f64,
}

/// Outcome of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Outcome {
    /// True if the solver converged.
    pub is_settled: bool,
    /// Sweeps over the contacts; 0 in steady motion.
    pub sweeps: usize,
    /// Steps of Newton's method.
    pub newton_steps: usize,
    /// Multiplications that the system took, roughly; 0 for a small single body.
    pub work: u64,
}

/// Up to three rows that belong together: a contact or a joint row.
struct Block {
    /// Number of its first row.
    row: usize,
    rows: usize,
    parts: [Option<Part>; 2],
}

/// The Jacobian of a block for one body: for every degree of freedom of a chain, from the root down, an entry for each row.
struct Part {
    body: usize,
    tip: usize,
    entries: std::ops::Range<usize>,
}

/// Scratch buffers that one step after the other reuses.
#[derive(Default)]
pub struct Workspace {
    inertia: inertia::Scratch,
    blocks: Vec<Block>,
    /// Jacobian entries of the blocks, multiplied by the inverse of L'.
    entries: Vec<[f64; 3]>,
    compliance: Vec<f64>,
    problem: Problem,
    sparse: SparseProblem,
    impulses: Vec<f64>,
    /// Impulses that the contacts remember, by row.
    memory: Vec<f64>,
    /// Change of every body's velocity by the impulses, multiplied by L.
    change: Vec<f64>,
    /// First coordinate of every body, followed by the number of all coordinates.
    places: Vec<usize>,
    friction: friction::Workspace,
    sparse_friction: friction::SparseWorkspace,
    /// Aim of the next sparse solution, with the multiplications left for the step.
    effort: Effort,
    /// Servos that would exceed their limits, as rows bounded by those.
    limited: Vec<JointRow>,
}

/// Returns the multiplications after which the search for the impulses of a number of bodies ends, at its next step.
pub fn most_work(bodies: usize) -> u64 {
    let [of_few, of_all] = WORK;
    of_few * bodies.min(FEW) as u64 + of_all * bodies as u64
}

/// Finds the velocities of bodies at the end of a step. It does not move them: [`Body::advance`] does.
pub fn step(
    bodies: &mut [&mut Body],
    contacts: &mut [Contact],
    joints: &mut [JointRow],
    time_step: f64,
    workspace: &mut Workspace,
) -> Outcome {
    workspace.limited.clear();
    let enough = if bodies.len() == 1 { 0.0 } else { ENOUGH };
    workspace.effort = Effort { enough, budget: most_work(bodies.len()), is_again: false };
    if bodies.len() > 1 {
        // A servo that is found at its limit only later costs another solution of the whole system.
        for (number, body) in bodies.iter_mut().enumerate() {
            body.free.copy_from_slice(&body.velocity);
            body.limit_servos(number, time_step, &mut workspace.limited);
        }
    }
    bodies.iter_mut().for_each(|body| body.prepare(time_step, &mut workspace.inertia));
    let (mut total, mut passes) = (Outcome::default(), 0);
    loop {
        let outcome = workspace.solve(bodies, contacts, joints);
        total.sweeps += outcome.sweeps;
        total.newton_steps += outcome.newton_steps;
        total.work += outcome.work;
        passes += 1;
        workspace.effort.is_again = true;
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
        if bodies.len() > 1 {
            // The next solution starts from them. That of one body starts from the limits.
            workspace.limited.iter_mut().for_each(|servo| servo.impulse = take());
        }
        let before = workspace.limited.len();
        for (number, body) in bodies.iter_mut().enumerate() {
            body.limit_servos(number, time_step, &mut workspace.limited);
        }
        let is_limited = workspace.limited.len() == before;
        if is_limited || bodies.len() > 1 && passes == MAX_PASSES {
            bodies.iter_mut().for_each(|body| std::mem::swap(&mut body.velocity, &mut body.free));
            return Outcome { is_settled: outcome.is_settled && is_limited, ..total };
        }
        bodies.iter_mut().for_each(|body| body.prepare(time_step, &mut workspace.inertia));
    }
}

impl Body {
    /// Converts servos that would exceed their limits at the free speeds to rows. A row has its servo's compliance and limit. `number` is
    /// the body's number in the system.
    fn limit_servos(&mut self, number: usize, time_step: f64, limited: &mut Vec<JointRow>) {
        for (dof, (drive, speed)) in self.drives.iter_mut().zip(&self.free).enumerate() {
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

/// Computes a block of the Delassus matrix of one body, row by row: the velocity on the rows of `one` by impulses on those of `other`.
fn shared(body: &Body, entries: &[[f64; 3]], one: &Block, other: &Block) -> [[f64; 3]; 3] {
    let mut sum = [[0.0; 3]; 3];
    for own in one.parts.iter().flatten() {
        for its in other.parts.iter().flatten() {
            let common = body.tree.common(own.tip, its.tip);
            let (own, its) = (&entries[own.entries.start..][..common], &entries[its.entries.start..][..common]);
            match one.rows.max(other.rows) {
                1 => add_products::<1>(own, its, &mut sum),
                2 => add_products::<2>(own, its, &mut sum),
                _ => add_products::<3>(own, its, &mut sum),
            }
        }
    }
    sum
}

/// Adds the products of the first `ROWS` rows of two Jacobians.
fn add_products<const ROWS: usize>(own: &[[f64; 3]], its: &[[f64; 3]], sum: &mut [[f64; 3]; 3]) {
    // Wheels of one robot have its root in common, whose loop of a constant length is unrolled.
    if let (Ok(own), Ok(its)) = (<&[_; root::DOFS]>::try_from(own), <&[_; root::DOFS]>::try_from(its)) {
        return add_products_of::<ROWS>(own, its, sum);
    }
    add_products_of::<ROWS>(own, its, sum);
}

#[inline(always)]
fn add_products_of<const ROWS: usize>(own: &[[f64; 3]], its: &[[f64; 3]], sum: &mut [[f64; 3]; 3]) {
    for (own, its) in own.iter().zip(its) {
        for row in 0..ROWS {
            for column in 0..ROWS {
                sum[row][column] += own[row] * its[column];
            }
        }
    }
}

/// Adds the change of the velocity of a chain, multiplied by L, by the impulses on `ROWS` rows.
fn add_change<const ROWS: usize>(chain: &[usize], entries: &[[f64; 3]], impulses: &[f64], change: &mut [f64]) {
    let impulses = &impulses[..ROWS];
    for (&dof, entries) in chain.iter().zip(entries) {
        change[dof] += entries.iter().zip(impulses).map(|(entry, impulse)| entry * impulse).sum::<f64>();
    }
}

impl Workspace {
    /// Finds the impulse on every row, and stores the velocities at the end of the step in the bodies' `free`.
    fn solve(&mut self, bodies: &mut [&mut Body], contacts: &[Contact], joints: &[JointRow]) -> Outcome {
        self.blocks.clear();
        self.entries.clear();
        self.compliance.clear();
        self.impulses.clear();
        self.memory.clear();
        self.problem.right_side.clear();
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
        self.places.clear();
        self.places.push(0);
        for body in bodies.iter() {
            self.places.push(self.places[self.places.len() - 1] + body.free.len());
        }
        let is_small = bodies.len() == 1 && count <= DENSE_ROWS;
        let outcome = if is_small { self.solve_dense(bodies[0]) } else { self.solve_sparse(bodies) };
        self.change(bodies);
        if !outcome.is_settled {
            self.scale(is_small);
        }
        self.apply(bodies);
        outcome
    }

    /// Finds the impulses of one body by its Delassus matrix, as nearly all rows share its root.
    fn solve_dense(&mut self, body: &Body) -> Outcome {
        let Self { blocks, entries, compliance, problem, impulses, friction, .. } = self;
        let count = impulses.len();
        let delassus = &mut problem.delassus;
        delassus.resize(count * count, 0.0);
        for (number, block) in blocks.iter().enumerate() {
            for other in &blocks[..=number] {
                let shared = shared(body, entries, block, other);
                for (own, row) in shared.iter().enumerate().take(block.rows) {
                    for (its, &velocity) in row.iter().enumerate().take(other.rows) {
                        delassus[(block.row + own) * count + other.row + its] = velocity;
                        delassus[(other.row + its) * count + block.row + own] = velocity;
                    }
                }
            }
        }
        for (row, &compliance) in compliance.iter().enumerate() {
            let own = &mut delassus[row * (count + 1)];
            *own += if compliance > 0.0 { compliance } else { (*own * SOFTNESS).max(LEAST_COMPLIANCE) };
        }
        let friction::Outcome { sweeps, newton_steps, is_settled } = friction::solve(problem, impulses, friction);
        Outcome { is_settled, sweeps, newton_steps, work: 0 }
    }

    /// Finds the impulses of several bodies, each of which touches few others.
    fn solve_sparse(&mut self, bodies: &[&mut Body]) -> Outcome {
        let Self { blocks, entries, compliance, problem, sparse, impulses, memory, places, .. } = self;
        let Self { sparse_friction, effort, .. } = self;
        sparse.clear();
        sparse.bodies.extend_from_slice(places);
        sparse.constraints.append(&mut problem.constraints);
        sparse.right_side.append(&mut problem.right_side);
        for (number, block) in blocks.iter().enumerate() {
            let start = sparse.entries.len();
            for part in block.parts.iter().flatten() {
                let first = places[part.body];
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
            // Normals have a compliance of their own, and joints do not hold each other up.
            let is_contact = matches!(sparse.constraints[number], Constraint::Contact { tangents: 1.., .. });
            let is_soft = is_contact && bodies.len() > 1;
            let softness = if is_soft { SOFTNESS_TOGETHER } else { SOFTNESS };
            for row in 0..block.rows {
                let given = compliance[block.row + row];
                let delassus: f64 = own.iter().map(|(_, entry)| entry[row] * entry[row]).sum();
                let compliance = if given > 0.0 { given } else { (delassus * softness).max(LEAST_COMPLIANCE) };
                sparse.compliance.push(compliance);
                if given <= 0.0 && is_soft {
                    sparse.right_side[block.row + row] += compliance * memory[block.row + row];
                }
            }
            sparse.ranges.push(start..sparse.entries.len());
        }
        let found = friction::solve_sparse(sparse, impulses, *effort, sparse_friction);
        let friction::SparseOutcome { sweeps, newton_steps, work, is_settled, .. } = found;
        effort.budget = effort.budget.saturating_sub(work);
        Outcome { is_settled, sweeps, newton_steps, work }
    }

    /// Computes the velocity changes by the impulses, multiplied by L.
    fn change(&mut self, bodies: &[&mut Body]) {
        let Self { blocks, entries, impulses, change, places, .. } = self;
        change.clear();
        change.resize(places[bodies.len()], 0.0);
        for block in blocks.iter() {
            for part in block.parts.iter().flatten() {
                let change = &mut change[places[part.body]..];
                let chain = bodies[part.body].tree.chain(part.tip);
                let (own, entries) = (&impulses[block.row..], &entries[part.entries.clone()]);
                match block.rows {
                    1 => add_change::<1>(chain, entries, own, change),
                    2 => add_change::<2>(chain, entries, own, change),
                    _ => add_change::<3>(chain, entries, own, change),
                }
            }
        }
    }

    /// Scales impulses that did not settle, so that they do no more work than those that settle would: the work that brings the rows to
    /// their target speeds is used up by the change of the velocities. Impulses within a cone stay there.
    fn scale(&mut self, is_small: bool) {
        let Self { impulses, change, problem, sparse, .. } = self;
        let right_side = if is_small { &problem.right_side } else { &sparse.right_side };
        let given: f64 = impulses.iter().zip(right_side).map(|(impulse, right_side)| impulse * right_side).sum();
        let taken: f64 = change.iter().map(|change| change * change).sum();
        if given < taken {
            let share = (given / taken).max(0.0);
            impulses.iter_mut().chain(change).for_each(|it| *it *= share);
        }
    }

    /// Adds the velocity changes to the bodies' free velocities.
    fn apply(&mut self, bodies: &mut [&mut Body]) {
        for (body, &place) in bodies.iter_mut().zip(&*self.places) {
            let change = &mut self.change[place..][..body.free.len()];
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
        let mut part = |side: Side, sign: f64| match rows {
            1 => self.add_side::<1>(bodies, contact, &directions, side, sign, &mut velocity),
            2 => self.add_side::<2>(bodies, contact, &directions, side, sign, &mut velocity),
            _ => self.add_side::<3>(bodies, contact, &directions, side, sign, &mut velocity),
        };
        let parts = [part(contact.first, 1.0), contact.second.and_then(|second| part(second, -1.0))];
        self.blocks.push(Block { row, rows, parts });
        let targets = [contact.target, 0.0, 0.0];
        for (number, direction) in directions.iter().enumerate().take(rows) {
            self.problem.right_side.push(targets[number] + direction.dot(&contact.drift) - velocity[number]);
            self.compliance.push(contact.compliance[number]);
            self.impulses.push(contact.impulse.dot(direction));
            self.memory.push(contact.memory.dot(direction));
        }
        self.problem.constraints.push(Constraint::Contact { friction: contact.friction, tangents });
    }

    /// Adds the Jacobian of a contact's `ROWS` rows for one side, and the side's free velocity along them to `velocity`. `None` if nothing
    /// moves the side.
    fn add_side<const ROWS: usize>(
        &mut self,
        bodies: &[&mut Body],
        contact: &Contact,
        directions: &[Vector3<f64>; 3],
        side: Side,
        sign: f64,
        velocity: &mut [f64; 3],
    ) -> Option<Part> {
        let body = &bodies[side.body];
        let (tip, axes) = body.axes_of(side.link)?;
        let at = contact.point - body.centre();
        let belt = body.belt_at(side.link, contact.normal);
        let (chain, of_root) = (body.tree.chain(tip), body.tree.dofs_of_free_root());
        let start = self.entries.len();
        self.entries.resize(start + chain.len(), [0.0; 3]);
        let entries = &mut self.entries[start..];
        if of_root > 0 {
            for row in 0..ROWS {
                for (entry, along) in entries.iter_mut().zip(root::along(&directions[row], &at)) {
                    entry[row] = along * sign;
                }
            }
        }
        for (&dof, entry) in chain.iter().zip(&mut *entries).skip(of_root) {
            // Both sides' belts run the same way, as their outward normals are opposite.
            let run = belt.filter(|(of_belt, _)| *of_belt == dof).map_or_else(Vector3::zeros, |(_, run)| run);
            let moved = axes[dof].at(at) * sign + run;
            (0..ROWS).for_each(|row| entry[row] = directions[row].dot(&moved));
        }
        for (&dof, entry) in chain.iter().zip(&*entries) {
            (0..ROWS).for_each(|row| velocity[row] += entry[row] * body.free[dof]);
        }
        factor::solve_chain::<ROWS>(&body.tree, &body.factors, tip, &mut self.entries[start..]);
        Some(Part { body: side.body, tip, entries: start..self.entries.len() })
    }

    fn add_joint(&mut self, bodies: &[&mut Body], joint: &JointRow) {
        let body = &bodies[joint.body];
        let mut velocity = 0.0;
        let start = self.entries.len();
        let parts = if joint.terms == [None; 2] {
            velocity += joint.root.iter().zip(&body.free).map(|(factor, speed)| factor * speed).sum::<f64>();
            self.entries.extend(joint.root.map(|factor| [factor, 0.0, 0.0]));
            factor::solve_chain::<1>(&body.tree, &body.factors, 5, &mut self.entries[start..]);
            [Some(Part { body: joint.body, tip: 5, entries: start..self.entries.len() }), None]
        } else {
            joint.terms.map(|term| {
                let (dof, factor) = term?;
                velocity += factor * body.free[dof];
                let start = self.entries.len();
                self.entries.resize(start + body.tree.dofs[dof].depth, [0.0; 3]);
                self.entries.push([factor, 0.0, 0.0]);
                factor::solve_chain::<1>(&body.tree, &body.factors, dof, &mut self.entries[start..]);
                Some(Part { body: joint.body, tip: dof, entries: start..self.entries.len() })
            })
        };
        self.blocks.push(Block { row: self.impulses.len(), rows: 1, parts });
        self.problem.right_side.push(joint.target - velocity);
        self.compliance.push(joint.compliance);
        self.impulses.push(joint.impulse);
        self.problem.constraints.push(joint.constraint);
    }
}
