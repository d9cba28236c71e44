//! A step of all robots in reduced coordinates, and of the objects that are near them.
//!
//! Robots that touch each other are one system, whatever their order; the others are solved each by itself, on as many threads as there
//! are. Where they have come then, each finds for itself what it touches that does not move.

use articulated::{Body, Contact, JointRow, Side};
use nalgebra::Vector3;
use rapier3d::parry::bounding_volume::{Aabb, BoundingVolume};
use rapier3d::prelude::*;

use super::super::convert;
use super::super::surface::Materials;
use super::ArticulatedRobot;
use super::finding::{OfEngine, Second, touch_each_other, touch_engine};
use super::object::{MapObject, take_near};
use crate::flight::Flight;
use crate::threads::{Threads, in_parts};

/// Most robots that one thread has look around before another may take some.
const TOGETHER: usize = 2;
/// Parts in which systems are handed to threads at most.
const PARTS: usize = 64;

/// Room for systems that one thread solves one after the other.
#[derive(Default)]
pub(in super::super) struct Room {
    contacts: Vec<Contact>,
    joints: Vec<JointRow>,
    workspace: articulated::Workspace,
    /// Systems solved in which not every contact came to do what it should.
    unsettled: u64,
}

/// What all of them share in a step.
#[derive(Clone, Copy)]
pub(in super::super) struct Surroundings<'a> {
    pub(in super::super) materials: &'a Materials,
    pub(in super::super) robots_of_engine: usize,
    /// Whether something came or left since the last step.
    pub(in super::super) is_changed: bool,
    pub(in super::super) threads: &'a dyn Threads,
}

/// Moves robots on by a step, and the objects that are near them. Says how many systems did not settle.
pub(in super::super) fn solve<'a>(
    world: &mut PhysicsWorld,
    surroundings: Surroundings,
    mut robots: Vec<(&'a mut ArticulatedRobot, Option<&'a Flight>)>,
    objects: &'a mut [MapObject],
    rooms: &mut Vec<Room>,
) -> u64 {
    if robots.is_empty() && objects.iter().all(|object| object.taken().is_none()) {
        return 0;
    }
    let Surroundings { materials, robots_of_engine, is_changed, threads } = surroundings;
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
    let mut robots: Vec<&mut ArticulatedRobot> = robots.into_iter().map(|(robot, _)| robot).collect();
    look_around(&mut robots, world, materials, threads);
    if !objects.is_empty() {
        let around: Vec<Aabb> = robots.iter().filter_map(|robot| robot.around()).collect();
        take_near(world, objects, &around);
        let before = robots.len();
        robots.extend(objects.iter_mut().filter_map(|object| object.taken.as_deref_mut()));
        look_around(&mut robots[before..], world, materials, threads);
    }
    let (mut of_engine, mut touching) = (Vec::new(), Vec::new());
    if robots_of_engine > 0 {
        let count = robots.len();
        for (number, robot) in robots.iter_mut().enumerate() {
            let touched = touch_engine(world, materials, robot, &mut of_engine);
            touching.extend(touched.into_iter().map(|body| (number, count + body)));
        }
    }
    let near = near_each_other(&robots);
    touching.extend(near.into_iter().filter(|&(one, other)| touch_each_other(&mut robots, one, other)));
    let (step, seen) = (Step { robots: robots.len(), gravity, time_step }, &*world);
    let mut members = members(robots, &mut of_engine, &touching);
    let mut groups: Vec<&mut [Member]> = members.chunk_by_mut(|one, other| one.group == other.group).collect();
    // No group is left in the step in which the last robot leaves an object that it pushed.
    let size = groups.len().div_ceil(PARTS).max(1);
    rooms.resize_with(PARTS, Room::default);
    let mut parts: Vec<(&mut [&mut [Member]], &mut Room)> = groups.chunks_mut(size).zip(rooms.iter_mut()).collect();
    in_parts(threads, 1, &mut parts, &|parts| {
        for (groups, room) in parts {
            for group in groups.iter_mut() {
                step.solve(group, room);
                // While it is at hand, for the next step.
                group
                    .iter_mut()
                    .filter_map(Member::robot)
                    .for_each(|robot| robot.look_around(seen, materials, time_step));
            }
        }
    });
    for OfEngine { links, reactions, .. } in of_engine {
        for (link, point, impulse) in reactions {
            react(world, links[link], point, impulse);
        }
    }
    rooms.iter_mut().map(|room| std::mem::take(&mut room.unsettled)).sum()
}

/// Has those look around that have not since they moved.
fn look_around(
    robots: &mut [&mut ArticulatedRobot],
    world: &PhysicsWorld,
    materials: &Materials,
    threads: &dyn Threads,
) {
    if robots.iter().any(|robot| !robot.standing.is_known) {
        let time_step = world.integration_parameters.dt;
        in_parts(threads, TOGETHER, robots, &|robots| {
            let moved = robots.iter_mut().filter(|robot| !robot.standing.is_known);
            moved.for_each(|robot| robot.look_around(world, materials, time_step));
        });
    }
}

/// Gives an impulse to a link of a robot of the engine. It has its velocity from the multibody, and an impulse on it is lost: it gets a
/// force for one step.
fn react(world: &mut PhysicsWorld, handle: RigidBodyHandle, point: Vector3<f64>, impulse: Vector3<f64>) {
    let time_step = world.integration_parameters.dt;
    if let Some(link) = world.bodies.get_mut(handle) {
        link.add_force_at_point(convert::vector(impulse / time_step), convert::vector(point), true);
    }
}

/// Pairs of robots, by their numbers, whose boxes overlap.
fn near_each_other(robots: &[&mut ArticulatedRobot]) -> Vec<(usize, usize)> {
    if robots.len() < 2 {
        return Vec::new();
    }
    let boxes = robots.iter().enumerate().filter_map(|(number, robot)| Some((number, robot.around()?)));
    let mut boxes: Vec<(usize, Aabb)> = boxes.collect();
    boxes.sort_by(|(_, one), (_, other)| one.mins.x.total_cmp(&other.mins.x));
    let mut pairs = Vec::new();
    for (place, (one, around)) in boxes.iter().enumerate() {
        let behind = boxes[place + 1..].iter().take_while(|(_, other)| other.mins.x <= around.maxs.x);
        let near = behind.filter(|(_, other)| around.intersects(other));
        pairs.extend(near.map(|(other, _)| (*one.min(other), *one.max(other))));
    }
    pairs.sort_unstable();
    pairs
}

/// What takes part in a step.
struct Member<'a> {
    /// The number of the first of those that it touches, or that they touch.
    group: usize,
    number: usize,
    is: Is<'a>,
}

enum Is<'a> {
    Robot(&'a mut ArticulatedRobot),
    OfEngine(&'a mut OfEngine),
}

/// Everything that takes part, those that touch each other together; `touching` has their numbers, the engine's bodies behind the
/// robots.
fn members<'a>(
    robots: Vec<&'a mut ArticulatedRobot>,
    of_engine: &'a mut [OfEngine],
    touching: &[(usize, usize)],
) -> Vec<Member<'a>> {
    let mut group: Vec<usize> = (0..robots.len() + of_engine.len()).collect();
    for &(one, other) in touching {
        let (one, other) = (group[one], group[other]);
        let (kept, given_up) = (one.min(other), one.max(other));
        group.iter_mut().filter(|it| **it == given_up).for_each(|it| *it = kept);
    }
    let robots = robots.into_iter().map(Is::Robot);
    let all = robots.chain(of_engine.iter_mut().map(Is::OfEngine)).enumerate();
    let mut members: Vec<Member> = all.map(|(number, is)| Member { group: group[number], number, is }).collect();
    if !touching.is_empty() {
        members.sort_by_key(|member| member.group);
    }
    members
}

impl Second {
    /// Its number among all that take part, robots first; `None` of what does not move.
    fn number(self, robots: usize) -> Option<usize> {
        match self {
            Self::Fixed => None,
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

/// What all systems of a step share.
#[derive(Clone, Copy)]
struct Step {
    /// How many robots there are.
    robots: usize,
    gravity: Vector3<f64>,
    time_step: f64,
}

impl Step {
    /// Moves a group on by the step, and notes what pushed it.
    fn solve(self, group: &mut [Member], room: &mut Room) {
        let Room { contacts, joints, workspace, unsettled } = room;
        contacts.clear();
        joints.clear();
        for body in 0..group.len() {
            let Some(robot) = group[body].robot() else { continue };
            robot.before_step(self.gravity, self.time_step);
            robot.hand_over(self.time_step);
            // The second of a touch is another member.
            let found = std::mem::take(&mut robot.found);
            for it in &found {
                let second = self.side(it.second, group);
                let moves = second.map_or_else(Vector3::zeros, |Side { body, link }| {
                    group[body].body().velocity_at(link, it.touch.point)
                });
                let Some(robot) = group[body].robot() else { continue };
                contacts.push(robot.contact(it, body, second, moves, self.time_step));
            }
            let Some(robot) = group[body].robot() else { continue };
            robot.found = found;
            robot.add_joint_rows(body, self.gravity.norm(), self.time_step, joints);
        }
        let outcome = if let [single] = group {
            articulated::step(&mut [single.body_mut()], contacts, joints, self.time_step, workspace)
        } else {
            let mut bodies: Vec<&mut Body> = group.iter_mut().map(Member::body_mut).collect();
            articulated::step(&mut bodies, contacts, joints, self.time_step, workspace)
        };
        *unsettled += u64::from(!outcome.is_settled);
        let (mut contacts, mut joints) = (contacts.as_slice(), joints.as_slice());
        group.iter_mut().filter_map(Member::robot).for_each(ArticulatedRobot::forget);
        for body in 0..group.len() {
            let Some(robot) = group[body].robot() else { continue };
            let found = std::mem::take(&mut robot.found);
            let (own, rest) = contacts.split_at(found.len());
            contacts = rest;
            robot.known.extend(found.iter().zip(own).map(|(it, contact)| (it.key, contact.impulse)));
            let (own_joints, rest) = joints.split_at(joints.partition_point(|row| row.body <= body));
            joints = rest;
            robot.note_joints(own_joints, self.time_step);
            for (it, contact) in found.iter().zip(own) {
                if let Some(robot) = group[body].robot() {
                    robot.note(it.key.surface, it, contact, 1.0, self.time_step);
                }
                let Some(Side { body, .. }) = contact.second else { continue };
                match (&mut group[body].is, it.second) {
                    (Is::Robot(robot), Second::Robot(_, surface)) => {
                        robot.note(surface, it, contact, -1.0, self.time_step);
                    }
                    (Is::OfEngine(of_engine), Second::OfEngine(_, link)) => {
                        of_engine.reactions.push((link, contact.point, -contact.impulse));
                    }
                    _ => {}
                }
            }
            if let Some(robot) = group[body].robot() {
                robot.found = found;
                robot.body.advance(self.time_step);
            }
        }
    }

    /// The side of a member of a group that is touched; `None` of what does not move.
    fn side(self, second: Second, group: &[Member]) -> Option<Side> {
        let number = second.number(self.robots)?;
        let body = group.iter().position(|member| member.number == number)?;
        let link = match (&group[body].is, second) {
            (Is::Robot(robot), Second::Robot(_, surface)) => robot.made_of.surfaces[surface].link,
            (_, Second::OfEngine(_, link)) => link,
            _ => return None,
        };
        Some(Side { body, link })
    }
}
