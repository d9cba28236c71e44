//! A step of all robots in reduced coordinates: what they touch, and what they do then.
//!
//! Robots that touch each other are one system, whatever their order; the others are solved each by itself.

use articulated::{Body, Contact, JointRow, Side};
use nalgebra::Vector3;
use rapier3d::parry::bounding_volume::{Aabb, BoundingVolume};
use rapier3d::prelude::*;

use super::super::compile::Materials;
use super::super::convert;
use super::super::rolling::Load;
use super::ArticulatedRobot;
use super::compile::Form;
use super::finding::{
    Found, Key, MARGIN, OfEngine, Second, hand_over, touch_each_other, touch_engine, touch_fixed, velocity_of,
};
use super::object::{MapObject, take_near};
use super::wheel::{RollerTouch, SIDE, Touch};

/// Stiffness of what touches, N/m. It shares the load between contacts.
const STIFFNESS: f64 = 1e8;
/// Time in which an overlap is pushed out, s.
const RECOVERY_TIME: f64 = 0.02;
/// Fastest that it is, m/s.
const MAX_RECOVERY: f64 = 1.0;
/// Below this speed nothing bounces, m/s.
const LEAST_BOUNCE: f64 = 0.2;
/// A bearing that gives way by more than so many times the robot's own speed under a push brakes next to nothing.
const WEAK: f64 = 1e4;

/// What is kept of one step for the next.
#[derive(Default)]
pub(in super::super) struct Contacts {
    impulses: Vec<(Key, Vector3<f64>)>,
    /// Those of the step that is made.
    next: Vec<(Key, Vector3<f64>)>,
    /// What robots of the engine get of it: which link of which, where and how much.
    reactions: Vec<(usize, usize, Vector3<f64>, Vector3<f64>)>,
    found: Vec<Found>,
    contacts: Vec<Contact>,
    joints: Vec<JointRow>,
    workspace: articulated::Workspace,
    /// Systems solved in which not every contact came to do what it should.
    pub(in super::super) unsettled: u64,
}

/// Moves robots on by a step, and the objects that are near them.
pub(in super::super) fn solve<'a>(
    world: &mut PhysicsWorld,
    materials: &Materials,
    mut robots: Vec<&'a mut ArticulatedRobot>,
    objects: &'a mut [MapObject],
    robots_of_engine: usize,
    known: &mut Contacts,
) {
    if robots.is_empty() && objects.iter().all(|object| object.taken().is_none()) {
        return;
    }
    let time_step = world.integration_parameters.dt;
    let gravity = convert::from_vector(world.gravity);
    robots.iter_mut().for_each(|robot| robot.place_surfaces(time_step));
    if !objects.is_empty() {
        let around: Vec<Aabb> = robots.iter().filter_map(|robot| robot.around()).collect();
        take_near(world, objects, &around);
        for taken in objects.iter_mut().filter_map(|object| object.taken.as_deref_mut()) {
            taken.body.set_gravity(gravity);
            taken.place_surfaces(time_step);
            robots.push(taken);
        }
    }
    let robots = robots.as_mut_slice();
    let (mut found, mut of_engine) = (std::mem::take(&mut known.found), Vec::new());
    found.clear();
    for (number, robot) in robots.iter_mut().enumerate() {
        touch_fixed(world, materials, number, robot, &mut found);
        if robots_of_engine > 0 {
            touch_engine(world, materials, number, robot, &mut of_engine, &mut found);
        }
    }
    for one in 0..robots.len() {
        for other in 0..one {
            let near = robots[one].around().zip(robots[other].around());
            if near.is_some_and(|(one, other)| one.intersects(&other)) {
                touch_each_other(robots, other, one, &mut found);
            }
        }
    }
    hand_over(robots, &mut found, time_step);
    let mut step = Step { robots, of_engine: &mut of_engine, found: &found, weight: gravity.norm(), time_step };
    known.next.clear();
    for group in step.groups() {
        step.solve(&group, known);
    }
    std::mem::swap(&mut known.impulses, &mut known.next);
    known.found = found;
    for (number, link, point, impulse) in known.reactions.drain(..) {
        react(world, of_engine[number].links[link], point, impulse);
    }
    for robot in robots {
        robot.body.advance(time_step);
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

/// What takes part in a step.
struct Step<'s, 'r> {
    robots: &'s mut [&'r mut ArticulatedRobot],
    of_engine: &'s mut [OfEngine],
    found: &'s [Found],
    /// What a kilogram weighs, N.
    weight: f64,
    time_step: f64,
}

impl Step<'_, '_> {
    /// Robots that touch each other, group by group, in the order of the first of each. The engine's bodies come behind the robots.
    fn groups(&self) -> Vec<Vec<usize>> {
        let count = self.robots.len() + self.of_engine.len();
        let mut group: Vec<usize> = (0..count).collect();
        for it in self.found {
            let Some(other) = self.second_body(it.second) else { continue };
            let (one, other) = (group[it.first.0], group[other]);
            let (kept, given_up) = (one.min(other), one.max(other));
            group.iter_mut().filter(|it| **it == given_up).for_each(|it| *it = kept);
        }
        let members = |first: usize| (first..count).filter(|&number| group[number] == first).collect();
        (0..count).filter(|&number| group[number] == number).map(members).collect()
    }

    fn second_body(&self, second: Second) -> Option<usize> {
        match second {
            Second::Fixed => None,
            Second::Robot(robot, _) => Some(robot),
            Second::OfEngine(body, _) => Some(self.robots.len() + body),
        }
    }

    /// Finds the velocities of a group at the end of the step, and notes what pushed it.
    fn solve(&mut self, group: &[usize], known: &mut Contacts) {
        let body_of = |number: usize| group.iter().position(|&member| member == number);
        let found = self.found;
        let own = || found.iter().filter(|it| body_of(it.first.0).is_some());
        let (mut contacts, mut joints) = (std::mem::take(&mut known.contacts), std::mem::take(&mut known.joints));
        contacts.clear();
        joints.clear();
        for it in own() {
            let first = Side { body: body_of(it.first.0).unwrap_or_default(), link: self.link_of(it) };
            let second = self.second_body(it.second).and_then(body_of).map(|body| {
                let link = match it.second {
                    Second::Robot(robot, surface) => self.robots[robot].made_of.surfaces[surface].link,
                    Second::OfEngine(_, link) => link,
                    Second::Fixed => 0,
                };
                Side { body, link }
            });
            let contact = self.contact(it, first, second, known);
            contacts.push(contact);
        }
        for (body, &number) in group.iter().enumerate().filter(|&(_, &number)| number < self.robots.len()) {
            let robot = &self.robots[number];
            let before = joints.len();
            joints.extend(robot.joint_rows(body, self.time_step));
            if contacts.iter().any(|contact| contact.first.body == body) {
                joints.extend(robot.following_rows(body, self.weight, self.time_step).into_iter().flatten());
            }
            let rows = &mut joints[before..];
            if rows.len() == robot.joint_impulses.len() {
                rows.iter_mut().zip(&robot.joint_impulses).for_each(|(row, &impulse)| row.impulse = impulse);
            }
        }
        let outcome = {
            let robots = self.robots.iter_mut().map(|robot| &mut robot.body);
            let all = robots.chain(self.of_engine.iter_mut().map(|it| &mut it.body)).enumerate();
            let mut bodies: Vec<&mut Body> =
                all.filter(|(number, _)| group.contains(number)).map(|(_, body)| body).collect();
            articulated::step(&mut bodies, &mut contacts, &mut joints, self.time_step, &mut known.workspace)
        };
        known.unsettled += u64::from(!outcome.is_settled);
        let robots = self.robots.len();
        for (body, &number) in group.iter().enumerate().filter(|&(_, &number)| number < robots) {
            let robot = &mut self.robots[number];
            robot.contacts.clear();
            robot.loads.fill(Load::default());
            robot.joint_impulses.clear();
            robot.joint_impulses.extend(joints.iter().filter(|row| row.body == body).map(|row| row.impulse));
            robot.note_following(joints.iter().filter(|row| row.body == body), self.time_step);
        }
        for (it, contact) in own().zip(&contacts) {
            self.note(it, contact);
            known.next.push((it.key, contact.impulse));
            if let Second::OfEngine(number, link) = it.second {
                known.reactions.push((number, link, contact.point, -contact.impulse));
            }
        }
        (known.contacts, known.joints) = (contacts, joints);
    }

    /// The link that a touch pushes.
    fn link_of(&self, found: &Found) -> usize {
        let made_of = &self.robots[found.first.0].made_of;
        let surface = &made_of.surfaces[found.first.1];
        let (Form::Rollers(ring), Some(roller)) = (surface.form, found.touch.roller) else { return surface.link };
        made_of.rings[ring].first_link.map_or(surface.link, |first| first + roller.index)
    }

    /// A touch as the solver takes it.
    fn contact(&mut self, found: &Found, first: Side, second: Option<Side>, known: &Contacts) -> Contact {
        let time_step = self.time_step;
        let Touch { point, normal, gap, .. } = found.touch;
        let robot = &self.robots[found.first.0];
        let velocity =
            robot.body.velocity_at(first.link, point) - velocity_of(found.second, self.robots, self.of_engine, point);
        let speed = normal.dot(&velocity);
        let push = if gap > 0.0 { -gap / time_step } else { (-gap / (time_step + RECOVERY_TIME)).min(MAX_RECOVERY) };
        let bounces = gap <= 0.0 && speed < -LEAST_BOUNCE;
        let guess = known.impulses.iter().find(|(key, _)| *key == found.key);
        let mut contact = Contact {
            point,
            normal,
            tangents: self.tangents(found),
            friction: found.friction,
            target: if bounces { push.max(-speed * found.restitution) } else { push },
            compliance: [1.0 / (time_step * STIFFNESS * (time_step + RECOVERY_TIME)), 0.0, 0.0],
            first,
            second,
            impulse: guess.map_or_else(Vector3::zeros, |(_, impulse)| *impulse),
        };
        self.free_roller(found, &mut contact, velocity);
        contact
    }

    /// In which directions friction acts: along the way that a wheel rolls, or along a roller's axis, and across.
    fn tangents(&self, found: &Found) -> [Option<Vector3<f64>>; 2] {
        let (robot, normal) = (&self.robots[found.first.0], found.touch.normal);
        let surface = &robot.made_of.surfaces[found.first.1];
        let along = match (found.touch.roller, surface.form) {
            (Some(RollerTouch { axis, .. }), _) => (axis - normal * axis.dot(&normal)).try_normalize(1e-6),
            (None, Form::Wheel { .. }) => {
                normal.cross(&(robot.body.frames()[surface.link].rotation * Vector3::y())).try_normalize(0.1)
            }
            (None, _) => None,
        };
        let along = along.unwrap_or_else(|| {
            let aside = if normal.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
            normal.cross(&aside).normalize()
        });
        [Some(along), Some(normal.cross(&along))]
    }

    /// Lets a roller without inertia turn, which carries force along its axis alone but for its bearing; a base that follows its
    /// commands slides where it has to.
    fn free_roller(&mut self, found: &Found, contact: &mut Contact, velocity: Vector3<f64>) {
        let robot = &mut *self.robots[found.first.0];
        let (Some(RollerTouch { index, radius, .. }), Form::Rollers(ring)) =
            (found.touch.roller, robot.made_of.surfaces[found.first.1].form)
        else {
            return;
        };
        let made_of = robot.made_of.clone();
        let ring_of = &made_of.rings[ring];
        let Some(across) = contact.tangents[1].filter(|_| ring_of.first_link.is_none()) else { return };
        let passing = across.dot(&velocity);
        // It rolls as fast as what it touches passes by.
        if found.touch.gap < MARGIN {
            robot.roller_angles[ring][index] -= passing / radius * self.time_step;
        }
        if made_of.following.is_some() {
            contact.tangents = [None; 2];
            return;
        }
        let axle = robot.body.frames()[ring_of.wheel].rotation * Vector3::y();
        if contact.normal.dot(&axle).abs() > SIDE {
            return;
        }
        // Torque d w of the bearing at the roller's speed w = v / rho is a force d v / rho².
        let free = radius.powi(2) / (ring_of.damping * self.time_step);
        if free * made_of.mass < WEAK {
            contact.compliance[2] = free;
        } else {
            // So little does not need to be solved for.
            contact.tangents[1] = None;
            robot.body.push(ring_of.wheel, contact.point, across * (-passing / (free * self.time_step)));
        }
    }

    /// Notes what a contact did to its robots.
    fn note(&mut self, found: &Found, contact: &Contact) {
        let push = contact.impulse.dot(&contact.normal);
        if push <= 0.0 {
            return;
        }
        let second = if let Second::Robot(robot, surface) = found.second { Some((robot, surface)) } else { None };
        for ((robot, surface), sign) in [Some((found.first, 1.0)), second.map(|it| (it, -1.0))].into_iter().flatten() {
            let robot = &mut self.robots[robot];
            let wheel = robot.made_of.surfaces[surface].wheel;
            let force = contact.impulse * (sign / self.time_step);
            robot.contacts.push((wheel, scene::Contact { point: contact.point, force }));
            if let Some(load) = wheel.map(|wheel| &mut robot.loads[wheel]) {
                load.normal += contact.normal * (sign * push);
                load.resistance += found.resistance * push;
            }
        }
    }
}
