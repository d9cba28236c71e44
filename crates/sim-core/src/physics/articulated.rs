//! Robots as trees in reduced coordinates (the crate `articulated`): how they are made, driven and read.
//!
//! The engine has their shapes, on bodies that it does not move, so that rays and its own bodies meet them.

mod compile;
mod contact;
mod finding;
mod following;
mod object;
mod ring;
mod shape_contact;
mod together;
mod wheel;

use std::sync::Arc;

use articulated::{Body, Drive, Frame, JointRow};
use friction::Constraint;
use nalgebra::{Rotation3, UnitQuaternion, Vector3};
use rapier3d::parry::bounding_volume::Aabb;
use rapier3d::prelude::*;
use scene::{BodyState, Contact, JointState, Pose};

use super::convert;
use super::fault::Fault;
use super::identity::Identity;
use super::motor::{Servo, Torque, follow_targets};
use super::rolling::Load;
use crate::RobotId;
use crate::flight::Flight;

pub(super) use compile::{Articulated, CompiledObject};
use compile::{JointValue, Ring};
use finding::{Found, Key, Placed};
pub(super) use object::MapObject;
pub(super) use together::{Room, Surroundings, solve};

/// The end of a joint gives way over this time, s: what is beyond it comes back in it.
const END_TIME: f64 = 0.02;

/// Gain of what does what it is asked for, whatever it takes: the wheels of a base that follows its commands, the attitude of one that
/// flies, N m s/rad.
const STIFF: f64 = 1e6;

/// Angle that a body may turn by in a step before its energy is watched, rad.
const MAX_TURN: f64 = 0.1;

/// Largest acceleration of a flying robot that touches something, m/s²: a quadrotor's rotors lift three times its weight at most.
const MAX_FLIGHT_ACCELERATION: f64 = 30.0;

/// A robot and its state; or an object, which has no joints.
pub(crate) struct ArticulatedRobot {
    id: RobotId,
    made_of: Arc<Articulated>,
    body: Body,
    servos: Vec<Servo>,
    /// Targets of the joints with a value as they were set, before couplings.
    targets: Vec<f64>,
    /// Angles of rollers that are no links, ring by ring, rad: to be looked at.
    roller_angles: Vec<Vec<f64>>,
    /// Impulses of the rows of its joints in the last step.
    joint_impulses: Vec<f64>,
    /// What each wheel stood on in the last step.
    loads: Vec<Load>,
    /// Forces of the ground on each wheel in the last step that no contact has, N: rolling resistance, and what makes it follow.
    resistances: Vec<Vector3<f64>>,
    /// What pushed it in the last step, with the wheel that it pushed.
    contacts: Vec<(Option<usize>, Contact)>,
    /// Where its surfaces are, in the step that is made.
    placed: Vec<Placed>,
    standing: Standing,
    /// Whether it flies.
    flies: bool,
    /// What they touch in the step that is made, but for what notes it itself, and the impulses of the last.
    found: Vec<Found>,
    known: Vec<(Key, Vector3<f64>)>,
    /// The engine's bodies of its links, and their colliders.
    in_engine: Vec<(RigidBodyHandle, Vec<(ColliderHandle, usize)>)>,
    /// Fixed colliders that it may touch until it leaves a box.
    near: Option<(Aabb, Vec<ColliderHandle>)>,
}

/// What whoever has others to look at needs to know of a robot after a step: one line of a cache, as another core made it.
#[repr(align(64))]
struct Standing {
    /// A box around all of its surfaces.
    around: Option<Aabb>,
    /// Whether that is where they are now, and what they touch that does not move is known.
    is_known: bool,
    /// The fault of its state.
    fault: Option<Fault>,
}

impl ArticulatedRobot {
    /// Puts a robot at a pose of its frame, at rest.
    pub(super) fn spawn(world: &mut PhysicsWorld, made_of: Arc<Articulated>, id: RobotId, pose: &Pose) -> Self {
        let body = Body::new(made_of.tree.clone(), *pose);
        let mut in_engine = Vec::new();
        for link in 0..made_of.tree.links().len() {
            let place = link_pose(&body, link);
            let handle = world.insert_body(RigidBodyBuilder::kinematic_position_based().pose(convert::pose(&place)));
            let own = made_of.surfaces.iter().enumerate().filter(|(_, surface)| surface.link == link);
            let colliders = own.map(|(number, surface)| {
                let identity = Identity::Link { robot: id, link: link as u32 };
                (
                    world.insert_collider(
                        surface.seen.collider(identity).solver_groups(InteractionGroups::none()),
                        Some(handle),
                    ),
                    number,
                )
            });
            in_engine.push((handle, colliders.collect()));
        }
        Self::at_rest(made_of, id, pose, in_engine)
    }

    /// One whose shapes the engine has already, by link.
    fn at_rest(
        made_of: Arc<Articulated>,
        id: RobotId,
        pose: &Pose,
        in_engine: Vec<(RigidBodyHandle, Vec<(ColliderHandle, usize)>)>,
    ) -> Self {
        let (joints, wheels) = (made_of.joints.len(), made_of.wheels.len());
        Self {
            id,
            body: Body::new(made_of.tree.clone(), *pose),
            servos: vec![Servo::default(); joints],
            targets: vec![0.0; joints],
            roller_angles: made_of.rings.iter().map(|ring| vec![0.0; ring.shape.len()]).collect(),
            joint_impulses: Vec::new(),
            loads: vec![Load::default(); wheels],
            resistances: vec![Vector3::zeros(); wheels],
            contacts: Vec::new(),
            placed: Vec::new(),
            standing: Standing { around: None, is_known: false, fault: None },
            flies: false,
            found: Vec::new(),
            known: Vec::new(),
            in_engine,
            near: None,
            made_of,
        }
    }

    /// Puts it at a pose of its frame, at rest, as if it had just been spawned.
    fn return_to(&mut self, pose: &Pose) {
        let in_engine = std::mem::take(&mut self.in_engine);
        *self = Self::at_rest(self.made_of.clone(), self.id, pose, in_engine);
    }

    /// The engine's bodies.
    pub(super) fn bodies(&self) -> impl Iterator<Item = RigidBodyHandle> {
        self.in_engine.iter().map(|(body, _)| *body)
    }

    /// Sets the targets of the wheels' servos, rad/s.
    pub(super) fn set_wheel_speeds(&mut self, speeds: &[f64]) {
        let wheels = self.made_of.joints.iter().zip(&mut self.servos).filter(|(joint, _)| joint.value.is_wheel);
        wheels.zip(speeds).for_each(|((_, servo), &speed)| servo.set_target(speed));
    }

    /// Sets the target of a joint by its number among those with a value.
    pub(super) fn set_joint_target(&mut self, joint: usize, target: f64) {
        if let Some(made_of) = self.made_of.joints.get(joint) {
            self.targets[joint] = made_of.value.within_limits(target);
            self.servos[joint].set_target(self.targets[joint]);
        }
    }

    /// Gives a flying robot its velocities for the coming step. In free air it simply has them (AerialVehicle.uc:276-288). While it
    /// touches something it reaches them by a bounded force and torque, so that it pushes no harder than its rotors could.
    fn fly(&mut self, flight: &Flight, time_step: f64) {
        let (linear, angular) = flight.velocity(self.body.pose(), self.body.tree().links()[0].mass.centre, time_step);
        let is_touching = !self.contacts.is_empty();
        let velocity = self.body.velocity_mut();
        if is_touching {
            let present = Vector3::from_column_slice(&velocity[3..6]);
            let change = (linear - present).cap_magnitude(MAX_FLIGHT_ACCELERATION * time_step);
            velocity[3..6].copy_from_slice((present + change).as_slice());
        } else {
            velocity[..3].copy_from_slice(angular.as_slice());
            velocity[3..6].copy_from_slice(linear.as_slice());
        }
        let reach = self.made_of.surfaces.iter().map(|surface| surface.middle.norm() + surface.half.norm());
        let most = self.made_of.mass * MAX_FLIGHT_ACCELERATION * reach.fold(0.0, f64::max);
        for axis in 0..3 {
            self.body.set_drive(axis, Drive { at_rest: STIFF * angular[axis], gain: STIFF, most });
        }
        self.body.place();
        self.flies = true;
        self.standing.is_known = false;
    }

    /// Gives servos and rolling resistance their part in the coming step.
    fn before_step(&mut self, gravity: Vector3<f64>, time_step: f64) {
        let Self { made_of, body, servos, targets, loads, resistances, .. } = self;
        body.set_gravity(if self.flies { Vector3::zeros() } else { gravity });
        follow_targets(made_of.joints.iter().map(|joint| &joint.value), targets, servos);
        for (number, joint) in made_of.joints.iter().enumerate() {
            let Some(motor) = &joint.value.motor else { continue };
            if made_of.following.is_some() && joint.value.is_wheel {
                let target = servos[number].target();
                body.set_drive(joint.dof, Drive { at_rest: STIFF * target, gain: STIFF, most: f64::INFINITY });
                continue;
            }
            let JointState { position, speed } = joint.state(body);
            let Torque { at_rest, gain } = servos[number].torque(motor, position, speed, time_step);
            body.set_drive(joint.dof, Drive { at_rest, gain, most: motor.max_torque });
        }
        let share = made_of.mass / made_of.wheels.len().max(1) as f64;
        for ((hub, load), resistance) in made_of.wheels.iter().zip(loads).zip(resistances) {
            *resistance = Vector3::zeros();
            if load.resistance == 0.0 {
                continue;
            }
            let frame = &body.frames()[hub.carrier];
            let centre = body.centre() + frame.origin + frame.rotation * hub.centre;
            let velocity = body.velocity_at(hub.carrier, centre) + gravity * time_step;
            *resistance = hub.resistance(load, velocity, frame.rotation * Vector3::x(), share, time_step);
            body.push(hub.carrier, centre, *resistance);
        }
    }

    /// Ends, dry friction and couplings of its joints in the coming step; it is the body of a number.
    fn joint_rows(&self, number: usize, time_step: f64) -> impl Iterator<Item = JointRow> {
        let row = move |terms, constraint, target| JointRow {
            body: number,
            terms,
            root: [0.0; 6],
            constraint,
            target,
            compliance: 0.0,
            impulse: 0.0,
        };
        let back = move |beyond: f64| if beyond > 0.0 { beyond / (time_step + END_TIME) } else { beyond / time_step };
        let end = Constraint::Contact { friction: 0.0, tangents: 0 };
        let of_joints = self.made_of.joints.iter().flat_map(move |joint| {
            let JointState { position, speed } = joint.state(&self.body);
            let [low, high] = joint.value.limits.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
            // Ends that are far away are left out: of what a joint does in a few steps.
            let reach = 0.01 + 4.0 * speed.abs() * time_step;
            let low = (position - low < reach).then(|| row([Some((joint.dof, 1.0)), None], end, back(low - position)));
            let high =
                (high - position < reach).then(|| row([Some((joint.dof, -1.0)), None], end, back(position - high)));
            let friction = (joint.friction > 0.0)
                .then(|| row([Some((joint.dof, 1.0)), None], Constraint::Within(joint.friction * time_step), 0.0));
            [low, high, friction].into_iter().flatten()
        });
        let of_gears = self.made_of.gears.iter().map(move |gear| {
            let at = |link: usize| self.body.position(link);
            let off = gear.multiplier * at(gear.leader.0) + gear.offset - at(gear.follower.0);
            let terms = [Some((gear.follower.1, 1.0)), Some((gear.leader.1, -gear.multiplier))];
            row(terms, Constraint::Within(f64::INFINITY), off / (time_step + END_TIME))
        });
        of_joints.chain(of_gears)
    }

    /// Adds the rows of its joints, with the impulses of the last step, and of what makes it follow its commands while it touches
    /// something. `gravity` is what a kilogram weighs.
    fn add_joint_rows(&self, number: usize, gravity: f64, time_step: f64, rows: &mut Vec<JointRow>) {
        let before = rows.len();
        rows.extend(self.joint_rows(number, time_step));
        if !self.found.is_empty() {
            rows.extend(self.following_rows(number, gravity, time_step).into_iter().flatten());
        }
        let rows = &mut rows[before..];
        if rows.len() == self.joint_impulses.len() {
            rows.iter_mut().zip(&self.joint_impulses).for_each(|(row, &impulse)| row.impulse = impulse);
        }
    }

    /// What makes it follow its commands in the coming step, if it does; it is the body of a number. `gravity` is what a kilogram weighs.
    fn following_rows(&self, number: usize, gravity: f64, time_step: f64) -> Option<[JointRow; 3]> {
        let following = self.made_of.following.as_ref()?;
        let mut wheels = self.made_of.joints.iter().zip(&self.servos).filter(|(joint, _)| joint.value.is_wheel);
        let wheels: [(f64, f64); 4] = std::array::from_fn(|_| {
            let wheel = wheels.next();
            wheel.map_or((0.0, 0.0), |(joint, servo)| (servo.target(), self.body.position(joint.link)))
        });
        let weight = gravity * self.made_of.mass;
        Some(following.rows(number, &self.body, [wheels.map(|it| it.0), wheels.map(|it| it.1)], weight, time_step))
    }

    /// How far a wheel has turned beyond its frame, rad.
    fn turned(&self, ring: &Ring) -> f64 {
        if ring.first_link.is_some() { 0.0 } else { self.body.position(ring.wheel) }
    }

    /// Angles of its rollers about their own axes, wheel by wheel, rad.
    pub(super) fn roller_angles(&self) -> Vec<f64> {
        let of_ring = |(ring, angles): (&Ring, &Vec<f64>)| -> Vec<f64> {
            ring.first_link.map_or_else(
                || angles.clone(),
                |first| (first..first + angles.len()).map(|link| self.body.position(link)).collect(),
            )
        };
        self.made_of.rings.iter().zip(&self.roller_angles).flat_map(of_ring).collect()
    }

    /// True if it turns or flies so fast that a step of the integrator may gain energy.
    fn is_fast(&self, time_step: f64) -> bool {
        let Frame { angular, linear, .. } = &self.body.frames()[0];
        angular.norm() * time_step > MAX_TURN || linear.norm() * time_step > finding::MAX_PREDICTION
    }

    /// Computes the work that its servos can have done in the last step at most, J.
    fn servo_work(&self, time_step: f64) -> f64 {
        let joints = self.made_of.joints.iter().filter_map(|joint| Some((joint, joint.value.motor.as_ref()?)));
        let work = joints.map(|(joint, motor)| motor.max_torque * self.body.velocity()[joint.dof].abs() * time_step);
        work.sum()
    }

    /// Scales its velocities.
    fn slow_down(&mut self, share: f64) {
        self.body.velocity_mut().iter_mut().for_each(|speed| *speed *= share);
        self.body.place();
    }

    /// Tells the engine where its shapes come to be in the coming step of the engine.
    pub(super) fn lead_engine(&self, world: &mut PhysicsWorld) {
        for (link, (handle, _)) in self.in_engine.iter().enumerate() {
            let place = convert::pose(&link_pose(&self.body, link));
            if let Some(body) = world.bodies.get_mut(*handle) {
                body.set_next_kinematic_position(place);
            }
        }
    }

    /// Puts its shapes where they are, for rays and for those who look for room.
    pub(super) fn enter_queries(&self, world: &mut PhysicsWorld) {
        for (link, (handle, colliders)) in self.in_engine.iter().enumerate() {
            let place = convert::pose(&link_pose(&self.body, link));
            if let Some(body) = world.bodies.get_mut(*handle) {
                body.set_position(place, false);
            }
            for &(handle, number) in colliders {
                let PhysicsWorld { broad_phase, integration_parameters, colliders, .. } = world;
                if let Some(collider) = colliders.get_mut(handle) {
                    collider.set_position(place * self.made_of.surfaces[number].pose);
                    broad_phase.set_aabb(integration_parameters, handle, collider.compute_aabb());
                }
            }
        }
    }

    /// Pose and velocity of the robot frame.
    pub(super) fn state(&self) -> BodyState {
        let frame = &self.body.frames()[0];
        BodyState { pose: *self.body.pose(), linear: frame.linear, angular: frame.angular }
    }

    /// The robot frame as it moves with a link of the definition, whose origin is at `origin` in it when every joint is at 0.
    pub(super) fn carrier(&self, link: usize, origin: Vector3<f64>) -> Option<BodyState> {
        let &(own, offset) = self.made_of.places.get(link)?;
        let (frame, pose) = (&self.body.frames()[own], link_pose(&self.body, own));
        let pose = pose * nalgebra::Translation3::from(offset - origin);
        let lever = pose.translation.vector - (self.body.centre() + frame.origin);
        Some(BodyState { pose, linear: frame.linear + frame.angular.cross(&lever), angular: frame.angular })
    }

    /// Every joint with a value, in the order of the links.
    pub(super) fn joints(&self) -> impl Iterator<Item = (bool, JointState)> {
        self.made_of.joints.iter().map(|joint| (joint.value.is_wheel, joint.state(&self.body)))
    }

    /// What pushed it in the last step, with the wheel that it pushed.
    pub(super) fn contacts(&self) -> &[(Option<usize>, Contact)] {
        &self.contacts
    }

    /// Rolling resistance of each wheel in the last step, N.
    pub(super) fn resistances(&self) -> &[Vector3<f64>] {
        &self.resistances
    }

    /// The fault of its state, if it has one.
    pub(super) fn fault(&self) -> Option<Fault> {
        self.standing.fault
    }

    /// Pose and generalised velocity.
    pub(super) fn numbers(&self) -> Vec<f64> {
        let pose = self.body.pose();
        let numbers = pose.translation.vector.iter().chain(pose.rotation.coords.iter()).chain(self.body.velocity());
        numbers.copied().collect()
    }
}

impl JointValue {
    fn state(&self, body: &Body) -> JointState {
        JointState { position: body.position(self.link), speed: body.velocity()[self.dof] }
    }
}

/// Pose of a link in the world.
fn link_pose(body: &Body, link: usize) -> Pose {
    let frame = &body.frames()[link];
    let of = &body.tree().links()[link];
    let rotation = match link {
        0 => body.pose().rotation,
        // It turns with its parent alone.
        _ if of.is_round && of.parent == 0 => body.pose().rotation,
        _ => UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(frame.rotation)),
    };
    Pose::from_parts((body.centre() + frame.origin).into(), rotation)
}
