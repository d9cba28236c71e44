//! One step of all robots in reduced coordinates and of movable objects.
//!
//! Bodies that touch each other are one system, whatever their order. Systems are solved on all threads. At their new poses the bodies find
//! their contacts with fixed bodies for the next step.

use std::cell::RefCell;

use articulated::{Body, Contact, JointRow, Side};
use nalgebra::Vector3;
use rapier3d::parry::bounding_volume::{Aabb, BoundingVolume};
use rapier3d::prelude::*;

use super::super::convert;
use super::super::effort::SolverEffort;
use super::super::identity::BodyId;
use super::ArticulatedRobot;
use super::finding::{CandidateContact, Counterpart, OfEngine, touch_each_other, touch_engine};
use super::object::MovableObject;
use super::step_input::StepInput;
use super::wheel::Touch;
use crate::ObjectId;
use crate::flight::Flight;
use crate::threads::{Threads, in_parts};

/// Batch size of the contact search, bodies per task.
const TOGETHER: usize = 2;
/// Batch size of the search for contacts between bodies, pairs per task.
const PAIRS: usize = 8;
/// Largest number of parts into which systems are divided for the threads.
const PARTS: usize = 64;
/// Gap at the end of a step, without forces, beyond which a contact between bodies is left out, m.
const REACH: f64 = 0.001;
/// Largest system whose next contacts are found by the thread that solved it, while its bodies are in the cache.
const SMALL: usize = 4;

/// Scratch buffers that one thread reuses between systems.
#[derive(Default)]
struct Scratch {
    contacts: Vec<Contact>,
    joints: Vec<JointRow>,
    workspace: articulated::Workspace,
}

thread_local! {
    /// Scratch buffers of the thread, not of the world: worlds that are stepped in turn share them in its cache.
    static SCRATCH: RefCell<Scratch> = RefCell::default();
}

/// The results of systems beside the motion of their bodies.
#[derive(Default)]
struct Tally {
    effort: SolverEffort,
    /// Impulses on objects that need to know them.
    pushes: Vec<Push>,
}

/// An impulse on an object, N s, and the body that gave it.
#[derive(Clone, Copy)]
struct Push {
    object: ObjectId,
    by: BodyId,
    impulse: Vector3<f64>,
}

/// Two bodies, by number, whose boxes overlap, and their contacts, each with the body of its first surface.
struct Pair {
    bodies: (usize, usize),
    found: Vec<(usize, CandidateContact)>,
}

/// Advances robots and awake objects by one step.
pub(in super::super) fn solve<'a>(
    world: &mut PhysicsWorld,
    input: StepInput,
    mut robots: Vec<(&'a mut ArticulatedRobot, Option<&'a Flight>)>,
    objects: &'a mut [MovableObject],
) -> SolverEffort {
    let StepInput { materials, robots_of_engine, is_changed, threads, .. } = input;
    // A robot that left may have carried an object.
    let is_still = robots.is_empty() && robots_of_engine == 0 && !is_changed;
    if is_still && objects.iter().all(MovableObject::is_asleep) {
        return SolverEffort::default();
    }
    let time_step = world.integration_parameters.dt;
    let gravity = convert::from_vector(world.gravity);
    for (robot, flight) in &mut robots {
        if let Some(flight) = flight {
            robot.fly(flight, time_step);
        }
        if is_changed {
            robot.forget_near();
        }
    }
    let mut is_asleep: Vec<bool> = robots.iter().map(|_| false).collect();
    let robot_count = robots.len();
    is_asleep.extend(objects.iter().map(MovableObject::is_asleep));
    // Only the engine's robots need to know.
    let of_engine_alone = if robots_of_engine > 0 { &*objects } else { &[] };
    let held: Vec<bool> = of_engine_alone.iter().map(MovableObject::is_held).collect();
    let listening = objects.iter().filter(|object| object.is_listening(time_step));
    let listening: Vec<ObjectId> = listening.map(MovableObject::id).collect();
    let mut robots: Vec<&mut ArticulatedRobot> = robots.into_iter().map(|(robot, _)| robot).collect();
    robots.extend(objects.iter_mut().map(|object| &mut *object.body));
    look_around(robots.iter_mut().map(|robot| &mut **robot), world, input);
    let (mut of_engine, mut touching) = (Vec::new(), Vec::new());
    if robots_of_engine > 0 {
        let count = robots.len();
        // The engine's robots feel held objects as bodies of the engine.
        let is_held = |number: usize| number >= robot_count && held[number - robot_count];
        for (number, robot) in robots.iter_mut().enumerate().filter(|(number, _)| !is_held(*number)) {
            let touched = touch_engine(world, materials, robot, &mut of_engine);
            is_asleep[number] &= touched.is_empty();
            touching.extend(touched.into_iter().map(|body| (number, count + body)));
        }
    }
    for Pair { bodies: (one, other), found } in find_pairs(&robots, &is_asleep, threads) {
        if !found.is_empty() && !is_asleep[one] && !is_asleep[other] {
            touching.push((one, other));
        }
        found.into_iter().for_each(|(body, found)| robots[body].found.push(found));
    }
    let step = Step { robots: robots.len(), listening: &listening, gravity, time_step };
    let mut members = members(robots, &mut of_engine, &touching, &is_asleep);
    let mut groups: Vec<&mut [Member]> = members.chunk_by_mut(|one, other| one.group == other.group).collect();
    // A step in which all objects sleep has no groups.
    let size = groups.len().div_ceil(PARTS).max(1);
    let mut parts: Vec<(&mut [&mut [Member]], Tally)> =
        groups.chunks_mut(size).map(|groups| (groups, Tally::default())).collect();
    let seen = &*world;
    in_parts(threads, 1, &mut parts, &|parts| {
        for (groups, tally) in parts {
            for group in groups.iter_mut() {
                SCRATCH.with_borrow_mut(|scratch| step.solve(group, scratch, tally));
                if group.len() <= SMALL {
                    let robots = group.iter_mut().filter_map(Member::robot);
                    robots.for_each(|robot| robot.look_around(seen, input, time_step));
                }
            }
        }
    });
    let (mut pushes, mut effort) = (Vec::new(), SolverEffort::default());
    for (_, tally) in parts {
        pushes.extend(tally.pushes);
        effort += tally.effort;
    }
    look_around(members.iter_mut().filter_map(Member::robot), seen, input);
    for OfEngine { links, reactions, .. } in of_engine {
        for (link, point, impulse) in reactions {
            react(world, links[link], point, impulse);
        }
    }
    pushes.sort_by_key(|push| push.object);
    rest(objects, &is_asleep[robot_count..], &pushes, &gravity, time_step);
    effort
}

/// Finds contacts of bodies that moved since the last search.
fn look_around<'a>(robots: impl Iterator<Item = &'a mut ArticulatedRobot>, world: &PhysicsWorld, input: StepInput) {
    let time_step = world.integration_parameters.dt;
    let mut moved: Vec<&mut ArticulatedRobot> = robots.filter(|robot| !robot.bounds.is_known).collect();
    in_parts(input.threads, TOGETHER, &mut moved, &|robots| {
        robots.iter_mut().for_each(|robot| robot.look_around(world, input, time_step));
    });
}

/// Lets objects fall asleep, and wakes those whose neighbours push differently. `pushes` are in the order of the objects.
fn rest(
    objects: &mut [MovableObject],
    was_asleep: &[bool],
    mut pushes: &[Push],
    gravity: &Vector3<f64>,
    time_step: f64,
) {
    let mut own = |id: ObjectId| {
        let (own, others) = pushes.split_at(pushes.partition_point(|push| push.object <= id));
        pushes = others;
        own.iter().map(|push| (push.by, push.impulse)).collect::<Vec<_>>()
    };
    let ids: Vec<ObjectId> = objects.iter().map(MovableObject::id).collect();
    let is_asleep = |id: BodyId| {
        let BodyId::Object(id) = id else { return false };
        ids.binary_search(&id).is_ok_and(|other| was_asleep[other])
    };
    let was_carried: Vec<bool> = objects.iter().map(|object| object.is_carried).collect();
    let carries = |id: BodyId| match id {
        BodyId::Robot(_) => true,
        BodyId::Object(id) => ids.binary_search(&id).is_ok_and(|other| was_carried[other]),
    };
    for (number, object) in objects.iter_mut().enumerate() {
        let impulses = own(object.id());
        if !object.is_asleep() {
            object.note_rest(impulses, carries, gravity, time_step);
        } else if !was_asleep[number] || object.is_disturbed(&impulses, is_asleep, gravity.norm(), time_step) {
            object.wake();
        }
    }
}

/// Applies an impulse to a link of a robot of the engine, as a force for one step. An impulse would be lost, as the link's velocity comes
/// from the multibody.
fn react(world: &mut PhysicsWorld, handle: RigidBodyHandle, point: Vector3<f64>, impulse: Vector3<f64>) {
    let time_step = world.integration_parameters.dt;
    if let Some(link) = world.bodies.get_mut(handle) {
        link.add_force_at_point(convert::vector(impulse / time_step), convert::vector(point), true);
    }
}

/// Finds the contacts between bodies, of which at least one is awake.
fn find_pairs(robots: &[&mut ArticulatedRobot], is_asleep: &[bool], threads: &dyn Threads) -> Vec<Pair> {
    let pair = |bodies| Pair { bodies, found: Vec::new() };
    let mut pairs: Vec<Pair> = near_each_other(robots, is_asleep).into_iter().map(pair).collect();
    in_parts(threads, PAIRS, &mut pairs, &|pairs| {
        for Pair { bodies, found } in pairs {
            touch_each_other(robots, *bodies, is_asleep, found);
        }
    });
    pairs
}

/// Finds pairs of bodies, by number, whose boxes overlap and of which at least one is awake.
fn near_each_other(robots: &[&mut ArticulatedRobot], is_asleep: &[bool]) -> Vec<(usize, usize)> {
    if robots.len() < 2 {
        return Vec::new();
    }
    let boxes = robots.iter().enumerate().filter_map(|(number, robot)| Some((number, robot.around()?)));
    let mut boxes: Vec<(usize, Aabb)> = boxes.collect();
    let axis = longest_axis(&boxes);
    boxes.sort_by(|(_, one), (_, other)| one.mins[axis].total_cmp(&other.mins[axis]));
    // The sweep starts at awake bodies, so it looks for sleeping ones in both directions.
    let reach = boxes.iter().filter(|(number, _)| is_asleep[*number]);
    let reach = reach.map(|(_, around)| around.maxs[axis] - around.mins[axis]).fold(0.0, f64::max);
    let mut pairs = Vec::new();
    for (place, (one, around)) in boxes.iter().enumerate().filter(|(_, (number, _))| !is_asleep[*number]) {
        let behind = boxes[place + 1..].iter().take_while(|(_, other)| other.mins[axis] <= around.maxs[axis]);
        let before = boxes[..place].iter().rev().take_while(|(_, other)| other.mins[axis] >= around.mins[axis] - reach);
        let before = before.filter(|(other, _)| is_asleep[*other]);
        let near = behind.chain(before).filter(|(_, other)| around.intersects(other));
        pairs.extend(near.map(|(other, _)| (*one.min(other), *one.max(other))));
    }
    pairs.sort_unstable();
    pairs
}

/// Finds the axis along which boxes are spread most. The fewest overlap there.
fn longest_axis(boxes: &[(usize, Aabb)]) -> usize {
    let spread = |axis: usize| {
        let ends = boxes.iter().map(|(_, around)| around.mins[axis]);
        let [least, most] =
            ends.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], it| [least.min(it), most.max(it)]);
        most - least
    };
    if spread(1) > spread(0) { 1 } else { 0 }
}

/// A body that takes part in a step.
struct Member<'a> {
    /// Lowest number in the group of bodies that are connected by contacts.
    group: usize,
    number: usize,
    is: Is<'a>,
}

enum Is<'a> {
    Robot(&'a mut ArticulatedRobot),
    OfEngine(&'a mut OfEngine),
}

/// Collects all awake bodies, grouped by contact. `touching` has pairs of their numbers, with the engine's bodies behind the robots.
fn members<'a>(
    robots: Vec<&'a mut ArticulatedRobot>,
    of_engine: &'a mut [OfEngine],
    touching: &[(usize, usize)],
    is_asleep: &[bool],
) -> Vec<Member<'a>> {
    // Union-find: each body points to one of its group with a lower number.
    let mut lower: Vec<usize> = (0..robots.len() + of_engine.len()).collect();
    let lowest = |lower: &mut [usize], mut body: usize| {
        while lower[body] != body {
            lower[body] = lower[lower[body]];
            body = lower[body];
        }
        body
    };
    for &(one, other) in touching {
        let (one, other) = (lowest(&mut lower, one), lowest(&mut lower, other));
        lower[one.max(other)] = one.min(other);
    }
    let awake = robots.into_iter().map(Is::Robot).enumerate().filter(|(number, _)| !is_asleep[*number]);
    let of_engine = of_engine.iter_mut().map(Is::OfEngine).enumerate().map(|(body, is)| (is_asleep.len() + body, is));
    let all = awake.chain(of_engine);
    let mut members: Vec<Member> =
        all.map(|(number, is)| Member { group: lowest(&mut lower, number), number, is }).collect();
    if !touching.is_empty() {
        members.sort_by_key(|member| member.group);
    }
    members
}

impl Counterpart {
    /// Returns the number of another body among all, robots first. `None` for a fixed body, and for the robot itself.
    fn number(self, robots: usize) -> Option<usize> {
        match self {
            Self::Fixed | Self::Itself(_) => None,
            Self::Robot(robot, _) => Some(robot),
            Self::OfEngine(body, _) => Some(robots + body),
        }
    }
}

impl Member<'_> {
    fn robot(&mut self) -> Option<&mut ArticulatedRobot> {
        if let Is::Robot(robot) = &mut self.is { Some(robot) } else { None }
    }

    fn body(&self) -> &Body {
        match &self.is {
            Is::Robot(robot) => &robot.body,
            Is::OfEngine(it) => &it.body,
        }
    }

    fn body_mut(&mut self) -> &mut Body {
        match &mut self.is {
            Is::Robot(robot) => &mut robot.body,
            Is::OfEngine(it) => &mut it.body,
        }
    }
}

/// Numbers that all systems of a step share.
#[derive(Clone, Copy)]
struct Step<'a> {
    /// Number of robots and objects.
    robots: usize,
    /// Objects that need the impulses on them, by their ids.
    listening: &'a [ObjectId],
    gravity: Vector3<f64>,
    time_step: f64,
}

impl Step<'_> {
    /// Advances a group by one step, and records its contacts.
    fn solve(self, group: &mut [Member], scratch: &mut Scratch, tally: &mut Tally) {
        let Scratch { contacts, joints, workspace } = scratch;
        let Tally { effort, pushes } = tally;
        contacts.clear();
        joints.clear();
        let is_alone = group.len() == 1;
        for body in 0..group.len() {
            let Some(robot) = group[body].robot() else { continue };
            robot.before_step(self.gravity, is_alone, self.time_step);
            robot.hand_over(self.time_step);
            // The other side of a contact may be another member.
            let mut found = std::mem::take(&mut robot.found);
            if !is_alone {
                found.retain(|it| self.may_touch(body, it, group));
            }
            let Some(robot) = group[body].robot() else { continue };
            robot.recall(&mut found, is_alone);
            for it in &found {
                let second = self.side(body, it.counterpart, group);
                let moves =
                    second.map_or(it.drift, |Side { body, link }| group[body].body().velocity_at(link, it.touch.point));
                let Some(robot) = group[body].robot() else { continue };
                contacts.push(robot.contact(it, body, second, moves, is_alone, self.time_step));
            }
            let Some(robot) = group[body].robot() else { continue };
            robot.found = found;
            robot.add_joint_rows(body, self.gravity.norm(), self.time_step, joints);
        }
        let energy = self.watched_energy(group);
        let outcome = if let [single] = group {
            articulated::step(&mut [single.body_mut()], contacts, joints, self.time_step, workspace)
        } else {
            let mut bodies: Vec<&mut Body> = group.iter_mut().map(Member::body_mut).collect();
            articulated::step(&mut bodies, contacts, joints, self.time_step, workspace)
        };
        *effort += SolverEffort {
            systems: 1,
            sweeps: outcome.sweeps as u64,
            newton_steps: outcome.newton_steps as u64,
            multiplications: outcome.work,
            unsettled: u64::from(!outcome.is_settled),
        };
        let (mut contacts, mut joints) = (contacts.as_slice(), joints.as_slice());
        for robot in group.iter_mut().filter_map(Member::robot) {
            robot.forget();
            robot.advance(self.time_step);
            robot.bounds.is_known = false;
        }
        for body in 0..group.len() {
            let Some(robot) = group[body].robot() else { continue };
            let found = std::mem::take(&mut robot.found);
            let (own, rest) = contacts.split_at(found.len());
            contacts = rest;
            robot.note_treads(&found, own, self.time_step);
            robot.remember(&found, own, self.time_step);
            let (own_joints, rest) = joints.split_at(joints.partition_point(|row| row.body <= body));
            joints = rest;
            robot.note_joints(own_joints, self.time_step);
            for (it, contact) in found.iter().zip(own) {
                let slip = self.slip(group, it, contact);
                if let Some(robot) = group[body].robot() {
                    robot.note(it.key.surface, it, contact, slip, 1.0, self.time_step);
                    if let Some(other) = it.key.body() {
                        self.note_push(robot.id, other, contact.impulse, pushes);
                        self.note_push(other, robot.id, -contact.impulse, pushes);
                    }
                }
                let Some(Side { body, .. }) = contact.second else { continue };
                match (&mut group[body].is, it.counterpart) {
                    (Is::Robot(robot), Counterpart::Robot(_, surface) | Counterpart::Itself(surface)) => {
                        robot.note(surface, it, contact, slip, -1.0, self.time_step);
                    }
                    (Is::OfEngine(of_engine), Counterpart::OfEngine(_, link)) => {
                        of_engine.reactions.push((link, contact.point, -contact.impulse));
                    }
                    _ => {}
                }
            }
            if let Some(robot) = group[body].robot() {
                robot.found = found;
            }
        }
        if let Some(before) = energy {
            self.limit_energy(group, before);
        }
    }

    /// True if a contact of two members, or of one with itself, may close in the step: without forces its gap would be small at the end. Half
    /// of the contacts found between robots in a crowd are not within reach.
    fn may_touch(self, body: usize, found: &CandidateContact, group: &[Member]) -> bool {
        let Some(Side { body: other, link }) = self.side(body, found.counterpart, group) else { return true };
        let Is::Robot(robot) = &group[body].is else { return true };
        let Touch { point, normal, gap, .. } = found.touch;
        let velocity =
            robot.body.velocity_at(robot.link_of(found), point) - group[other].body().velocity_at(link, point);
        gap + normal.dot(&velocity) * self.time_step < REACH
    }

    /// Computes the energy of a group before a step, J, if one of its bodies is fast. `None` for groups with flying robots or bases that
    /// follow their commands, whose velocities are imposed, and for those that a hand pulls.
    fn watched_energy(self, group: &mut [Member]) -> Option<f64> {
        let mut robots = group.iter_mut().filter_map(Member::robot);
        if !robots.any(|robot| robot.is_fast(self.time_step)) {
            return None;
        }
        let mut robots = group.iter_mut().filter_map(Member::robot);
        let is_given = robots.any(|robot| robot.flies || robot.is_pulled || robot.compiled.following.is_some());
        (!is_given).then(|| self.energy(group).iter().sum())
    }

    /// Computes the kinetic and the potential energy of a group, J.
    fn energy(self, group: &mut [Member]) -> [f64; 2] {
        group.iter_mut().filter_map(Member::robot).fold([0.0; 2], |[motion, height], robot| {
            let weight = self.gravity * robot.compiled.mass;
            [motion + robot.body.kinetic_energy(), height - weight.dot(&robot.body.centre())]
        })
    }

    /// Slows a group that gained more energy in a step than its servos can have supplied. A step moves along the tangent, which gains
    /// energy with the square of the angle.
    fn limit_energy(self, group: &mut [Member], before: f64) {
        let [motion, height] = self.energy(group);
        let work: f64 = group.iter_mut().filter_map(Member::robot).map(|robot| robot.servo_work(self.time_step)).sum();
        let gained = motion + height - before - work;
        if gained > 0.0 && motion > 0.0 {
            let share = ((motion - gained).max(0.0) / motion).sqrt();
            group.iter_mut().filter_map(Member::robot).for_each(|robot| robot.slow_down(share));
        }
    }

    /// Computes the slip of a contact that carries at the end of a step, m/s. Nobody sees that of an object on the ground.
    fn slip(self, group: &[Member], found: &CandidateContact, contact: &Contact) -> Vector3<f64> {
        let &Contact { point, normal, first, second, impulse, .. } = contact;
        let Is::Robot(robot) = &group[first.body].is else { return Vector3::zeros() };
        let is_seen = second.is_some() || !matches!(robot.id, BodyId::Object(_));
        if !is_seen || impulse.dot(&normal) <= 0.0 {
            return Vector3::zeros();
        }
        let of_second = second.map_or(found.drift, |second| self.velocity(group, second, point, -normal));
        robot.slip(found, contact, self.velocity(group, first, point, normal) - of_second)
    }

    /// Computes the velocity of the surface of a side of a contact at the end of a step, m/s. The point is where it was before robots moved
    /// on. The normal points into the side.
    fn velocity(
        self,
        group: &[Member],
        Side { body, link }: Side,
        point: Vector3<f64>,
        normal: Vector3<f64>,
    ) -> Vector3<f64> {
        let member = &group[body];
        let body = member.body();
        let moved = match member.is {
            Is::Robot(_) => body.frames()[link].linear * self.time_step,
            Is::OfEngine(_) => Vector3::zeros(),
        };
        body.velocity_at(link, point + moved) + body.belt_velocity(link, normal)
    }

    /// Records an impulse on an object, if the object needs it.
    fn note_push(self, pushed: BodyId, by: BodyId, impulse: Vector3<f64>, pushes: &mut Vec<Push>) {
        if let BodyId::Object(object) = pushed
            && self.listening.binary_search(&object).is_ok()
        {
            pushes.push(Push { object, by, impulse });
        }
    }

    /// Returns the side of the member that a contact of another touches, or `None` for a fixed or sleeping body.
    fn side(self, own: usize, counterpart: Counterpart, group: &[Member]) -> Option<Side> {
        if let (Counterpart::Itself(surface), Is::Robot(robot)) = (counterpart, &group[own].is) {
            return Some(Side { body: own, link: robot.compiled.surfaces[surface].link });
        }
        let number = counterpart.number(self.robots)?;
        // Members of a group are in the order of their numbers. Sleeping bodies are in no group.
        let body = group.binary_search_by_key(&number, |member| member.number).ok()?;
        let link = match (&group[body].is, counterpart) {
            (Is::Robot(robot), Counterpart::Robot(_, surface)) => robot.compiled.surfaces[surface].link,
            (_, Counterpart::OfEngine(_, link)) => link,
            _ => return None,
        };
        Some(Side { body, link })
    }
}
