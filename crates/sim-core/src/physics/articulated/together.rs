//! A step of all robots in reduced coordinates: what they touch, and what they do then.
//!
//! Robots that touch each other are one system, whatever their order; the others are solved each by itself.

use articulated::{Contact, JointRow, Side};
use nalgebra::Vector3;
use rapier3d::math::Pose as EnginePose;
use rapier3d::parry::bounding_volume::{Aabb, BoundingVolume};
use rapier3d::prelude::*;
use scene::Material;

use super::super::compile::Materials;
use super::super::convert;
use super::super::rolling::Load;
use super::compile::{Form, Surface};
use super::object::{MapObject, take_near};
use super::shape_contact::{around, touches};
use super::wheel::Touch;
use super::{ArticulatedRobot, link_pose};

/// Stiffness of what touches, N/m. It shares the load between contacts.
const STIFFNESS: f64 = 1e8;
/// Time in which an overlap is pushed out, s.
const RECOVERY_TIME: f64 = 0.02;
/// Fastest that it is, m/s.
const MAX_RECOVERY: f64 = 1.0;
/// Contacts are looked for over this distance and what a surface does in a step, m.
const PREDICTION: f64 = 0.001;
/// What does not move is looked for over this distance around a robot, and looked for again when it has left that, m.
const NEAR: f64 = 0.1;
/// Below this speed nothing bounces, m/s.
const LEAST_BOUNCE: f64 = 0.2;

/// What is kept of one step for the next.
#[derive(Default)]
pub(in super::super) struct Contacts {
    impulses: Vec<(Key, Vector3<f64>)>,
    /// Steps of a system in which not every contact came to do what it should.
    pub(in super::super) unsettled: u64,
}

/// What touches what: a surface of a robot, a surface of another or a collider, and which of their touches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Key {
    own: (u64, usize),
    other: (Option<u64>, usize),
    number: usize,
}

/// A touch of a surface.
struct Found {
    key: Key,
    first: (usize, usize),
    /// A robot's surface; `None` is what does not move.
    second: Option<(usize, usize)>,
    touch: Touch,
    /// Friction, restitution and rolling resistance of the pair.
    friction: f64,
    restitution: f64,
    resistance: f64,
}

/// Moves robots on by a step, and the objects that are near them.
pub(in super::super) fn solve<'a>(
    world: &mut PhysicsWorld,
    materials: &Materials,
    mut robots: Vec<&'a mut ArticulatedRobot>,
    objects: &'a mut [MapObject],
    known: &mut Contacts,
) {
    let time_step = world.integration_parameters.dt;
    let mut placed: Vec<Vec<Placed>> = robots.iter().map(|robot| all_placed(robot, time_step)).collect();
    if !objects.is_empty() {
        let around: Vec<Aabb> = placed.iter().filter_map(|placed| whole(placed)).collect();
        take_near(world, objects, &around);
        let gravity = convert::from_vector(world.gravity);
        for taken in objects.iter_mut().filter_map(|object| object.taken.as_deref_mut()) {
            taken.body.set_gravity(gravity);
            placed.push(all_placed(taken, time_step));
            robots.push(taken);
        }
    }
    let robots = robots.as_mut_slice();
    let mut found = Vec::new();
    for (number, robot) in robots.iter_mut().enumerate() {
        touch_fixed(world, materials, number, robot, &placed[number], &mut found);
    }
    for one in 0..robots.len() {
        for other in 0..one {
            let near = whole(&placed[one]).zip(whole(&placed[other])).is_some_and(|(one, other)| one.intersects(&other));
            if near {
                touch_each_other(robots, &placed, other, one, &mut found);
            }
        }
    }
    let groups = groups(robots.len(), &found);
    let mut impulses = Vec::with_capacity(found.len());
    for group in groups {
        solve_group(robots, &group, &found, known, &mut impulses, time_step);
    }
    known.impulses = impulses;
    for robot in robots {
        robot.body.advance(time_step);
    }
}

/// A surface where it is.
struct Placed {
    pose: EnginePose,
    around: Aabb,
    /// How far it looks for contacts, m.
    prediction: f64,
}

fn all_placed(robot: &ArticulatedRobot, time_step: f64) -> Vec<Placed> {
    let poses: Vec<EnginePose> =
        (0..robot.body.frames().len()).map(|link| convert::pose(&link_pose(&robot.body, link))).collect();
    let of_surface = |surface: &Surface| {
        let pose = poses[surface.link] * surface.pose;
        let frame = &robot.body.frames()[surface.link];
        let arm = frame.rotation * surface.middle;
        let speed = (frame.linear + frame.angular.cross(&arm)).norm() + frame.angular.norm() * surface.half.norm();
        // A wheel's own turning brings it nowhere.
        let speed = if surface.form == Form::Solid { speed } else { frame.linear.norm() };
        let prediction = PREDICTION + speed * time_step;
        Placed { pose, around: around(surface, &pose).loosened(prediction), prediction }
    };
    robot.made_of.surfaces.iter().map(of_surface).collect()
}

/// A box around all of them.
fn whole(placed: &[Placed]) -> Option<Aabb> {
    placed.iter().map(|placed| placed.around).reduce(|one, other| one.merged(&other))
}

/// Adds what a robot touches that does not move.
fn touch_fixed(
    world: &PhysicsWorld,
    materials: &Materials,
    number: usize,
    robot: &mut ArticulatedRobot,
    placed: &[Placed],
    found: &mut Vec<Found>,
) {
    let Some(whole) = whole(placed) else { return };
    let near = match robot.near.take() {
        Some((around, near)) if around.contains(&whole) => (around, near),
        _ => {
            let around = whole.loosened(NEAR);
            let query = world.query_pipeline_with_filter(QueryFilter::only_fixed());
            let mut near: Vec<ColliderHandle> =
                query.intersect_aabb_conservative(around).map(|(handle, _)| handle).collect();
            near.sort_by_key(|handle| handle.into_raw_parts());
            (around, near)
        }
    };
    let mut met = Vec::new();
    for &handle in &near.1 {
        let Some(collider) = world.colliders.get(handle) else { continue };
        let shape = collider.shape();
        let bounds = shape.as_halfspace().is_none().then(|| collider.compute_aabb());
        let material = materials.of(collider);
        for (index, (surface, at)) in robot.made_of.surfaces.iter().zip(placed).enumerate() {
            if bounds.is_some_and(|bounds| !bounds.intersects(&at.around)) {
                continue;
            }
            met.clear();
            touches(surface, &at.pose, shape, collider.position(), at.prediction, &mut met);
            let own = (robot.id.0, index);
            let other = (None, handle.into_raw_parts().0 as usize);
            let pair = Pair::of(&surface.material, material);
            found.extend(met.drain(..).enumerate().map(|(touch_number, touch)| {
                pair.found(Key { own, other, number: touch_number }, (number, index), None, touch)
            }));
        }
    }
    robot.near = Some(near);
}

/// Adds where two robots touch each other.
fn touch_each_other(
    robots: &[&mut ArticulatedRobot],
    placed: &[Vec<Placed>],
    one: usize,
    other: usize,
    found: &mut Vec<Found>,
) {
    let mut met = Vec::new();
    for (own_index, own_at) in placed[one].iter().enumerate() {
        for (its_index, its_at) in placed[other].iter().enumerate() {
            if !own_at.around.intersects(&its_at.around) {
                continue;
            }
            // Wheels and balls have a geometry of their own, so they are the ones that touch.
            let is_plain = robots[one].made_of.surfaces[own_index].form == Form::Solid;
            let ((first, index, at), (second, its_index, its_at)) = if is_plain {
                ((other, its_index, its_at), (one, own_index, own_at))
            } else {
                ((one, own_index, own_at), (other, its_index, its_at))
            };
            let (surface, its) = (&robots[first].made_of.surfaces[index], &robots[second].made_of.surfaces[its_index]);
            met.clear();
            let prediction = at.prediction + its_at.prediction;
            touches(surface, &at.pose, its.shape.as_ref(), &its_at.pose, prediction, &mut met);
            let (own, its_key) = ((robots[first].id.0, index), (Some(robots[second].id.0), its_index));
            let pair = Pair::of(&surface.material, &its.material);
            found.extend(met.drain(..).enumerate().map(|(number, touch)| {
                let key = Key { own, other: its_key, number };
                pair.found(key, (first, index), Some((second, its_index)), touch)
            }));
        }
    }
}

/// What two materials do to each other.
struct Pair {
    friction: f64,
    restitution: f64,
    resistance: f64,
}

impl Pair {
    fn of(one: &Material, other: &Material) -> Self {
        let (friction, restitution) = one.pair(other);
        Self { friction, restitution, resistance: one.rolling_resistance + other.rolling_resistance }
    }

    fn found(&self, key: Key, first: (usize, usize), second: Option<(usize, usize)>, touch: Touch) -> Found {
        let &Self { friction, restitution, resistance } = self;
        Found { key, first, second, touch, friction, restitution, resistance }
    }
}

/// Robots that touch each other, group by group, in the order of the first of each.
fn groups(count: usize, found: &[Found]) -> Vec<Vec<usize>> {
    let mut group: Vec<usize> = (0..count).collect();
    for (one, other) in found.iter().filter_map(|it| Some((it.first.0, it.second?.0))) {
        let (kept, given_up) = (group[one].min(group[other]), group[one].max(group[other]));
        group.iter_mut().filter(|it| **it == given_up).for_each(|it| *it = kept);
    }
    let members = |first: usize| (first..count).filter(|&number| group[number] == first).collect();
    (0..count).filter(|&number| group[number] == number).map(members).collect()
}

/// Finds the velocities of some robots at the end of the step, and notes what pushed them.
fn solve_group(
    robots: &mut [&mut ArticulatedRobot],
    group: &[usize],
    found: &[Found],
    known: &mut Contacts,
    impulses: &mut Vec<(Key, Vector3<f64>)>,
    time_step: f64,
) {
    let body_of = |robot: usize| group.iter().position(|&member| member == robot);
    let own: Vec<&Found> = found.iter().filter(|it| body_of(it.first.0).is_some()).collect();
    let mut contacts: Vec<Contact> = own
        .iter()
        .map(|it| {
            let side = |(robot, surface): (usize, usize)| Side {
                body: body_of(robot).unwrap_or_default(),
                link: robots[robot].made_of.surfaces[surface].link,
            };
            contact(robots, it, side(it.first), it.second.map(side), known, time_step)
        })
        .collect();
    let mut joints: Vec<JointRow> = Vec::new();
    for (body, &robot) in group.iter().enumerate() {
        let rows = robots[robot].joint_rows(body, time_step);
        let guesses = &robots[robot].joint_impulses;
        let before = joints.len();
        joints.extend(rows);
        let rows = &mut joints[before..];
        if rows.len() == guesses.len() {
            rows.iter_mut().zip(guesses).for_each(|(row, &impulse)| row.impulse = impulse);
        }
    }
    let outcome = {
        let mut members = robots.iter_mut().enumerate().filter(|(number, _)| group.contains(number));
        let mut bodies: Vec<_> = members.by_ref().map(|(_, robot)| &mut robot.body).collect();
        articulated::step(&mut bodies, &mut contacts, &mut joints, time_step)
    };
    known.unsettled += u64::from(!outcome.is_settled);
    for (body, &robot) in group.iter().enumerate() {
        let robot = &mut robots[robot];
        robot.contacts.clear();
        robot.loads.fill(Load::default());
        robot.joint_impulses = joints.iter().filter(|row| row.body == body).map(|row| row.impulse).collect();
    }
    for (it, contact) in own.into_iter().zip(&contacts) {
        impulses.push((it.key, contact.impulse));
        let push = contact.impulse.dot(&contact.normal);
        if push <= 0.0 {
            continue;
        }
        let sides = [Some((it.first, 1.0)), it.second.map(|second| (second, -1.0))];
        for ((robot, surface), sign) in sides.into_iter().flatten() {
            let robot = &mut robots[robot];
            let wheel = robot.made_of.surfaces[surface].wheel;
            let force = contact.impulse * (sign / time_step);
            robot.contacts.push((wheel, scene::Contact { point: contact.point, force }));
            if let Some(load) = wheel.map(|wheel| &mut robot.loads[wheel]) {
                load.normal += contact.normal * (sign * push);
                load.resistance += it.resistance * push;
            }
        }
    }
}

/// A touch as the solver takes it.
fn contact(
    robots: &[&mut ArticulatedRobot],
    found: &Found,
    first: Side,
    second: Option<Side>,
    known: &Contacts,
    time_step: f64,
) -> Contact {
    let Touch { point, normal, gap } = found.touch;
    let velocity = |(robot, _): (usize, usize), side: Side| robots[robot].body.velocity_at(side.link, point);
    let other = found.second.zip(second).map_or_else(Vector3::zeros, |(it, side)| velocity(it, side));
    let speed = normal.dot(&(velocity(found.first, first) - other));
    let push = if gap > 0.0 { -gap / time_step } else { (-gap / (time_step + RECOVERY_TIME)).min(MAX_RECOVERY) };
    let bounces = gap <= 0.0 && speed < -LEAST_BOUNCE;
    let surface = &robots[found.first.0].made_of.surfaces[found.first.1];
    let axle = robots[found.first.0].body.frames()[surface.link].rotation * Vector3::y();
    let ahead = normal.cross(&axle).try_normalize(0.1);
    let ahead = ahead.filter(|_| matches!(surface.form, Form::Wheel { .. })).unwrap_or_else(|| any_tangent(&normal));
    let guess = known.impulses.iter().find(|(key, _)| *key == found.key);
    Contact {
        point,
        normal,
        tangents: [Some(ahead), Some(normal.cross(&ahead))],
        friction: found.friction,
        target: if bounces { push.max(-speed * found.restitution) } else { push },
        compliance: 1.0 / (time_step * STIFFNESS * (time_step + RECOVERY_TIME)),
        first,
        second,
        impulse: guess.map_or_else(Vector3::zeros, |(_, impulse)| *impulse),
    }
}

fn any_tangent(normal: &Vector3<f64>) -> Vector3<f64> {
    let aside = if normal.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() };
    normal.cross(&aside).normalize()
}
