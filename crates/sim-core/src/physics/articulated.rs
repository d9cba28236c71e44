//! Robots as trees in reduced coordinates (the crate `articulated`): spawning, driving and reading them.
//!
//! The engine holds their shapes on kinematic bodies, so rays and the engine's own bodies meet them.

mod area;
mod compile;
mod contact;
mod finding;
mod following;
mod form;
mod itself;
mod object;
mod ring;
mod saved;
mod shape_contact;
mod step_input;
mod together;
mod track;
mod tread;
mod tyre;
mod wheel;

use std::sync::Arc;

use articulated::{Body, Drive, Frame, JointRow};
use friction::Constraint;
use nalgebra::{Rotation3, UnitQuaternion, Vector3};
use rapier3d::parry::bounding_volume::Aabb;
use rapier3d::prelude::*;
use scene::{BodyState, Contact, JointState, Motor, Pose, WHEEL_AXIS};

use super::convert;
use super::fault::Fault;
use super::identity::{BodyId, Identity};
use super::motor::{self, Servo, Torque};
use super::pull::{Grasped, Tug};
use super::query::set_box;
use super::rolling::Load;
use crate::PawnId;
use crate::flight::Flight;

pub(super) use compile::{Articulated, CompiledObject};
use compile::{JointValue, Ring};
use finding::{CandidateContact, Key, Known, Placed};
pub(super) use object::{MovableObject, uniform};
pub(crate) use saved::{SavedObject, SavedTree};
pub(super) use step_input::StepInput;
pub(super) use together::solve;
use tyre::{Deflection, Grip};

/// Time over which the end of a joint gives way, s. A joint beyond its end returns within it.
const END_TIME: f64 = 0.02;

/// Largest speed at which a joint returns from beyond its end or to its coupling, rad/s or m/s. A load may force a light joint far beyond.
const MAX_RETURN: f64 = 1.0;

/// Ratio of the largest speed of a joint that is not a wheel to its motor's. A motor that is driven faster is a generator, which brakes.
/// Joints that turn less than [`MAX_TURN`] in a step may be faster: the integrator gains no energy by them.
const MAX_OVERSPEED: f64 = 2.0;

/// Largest turn of a joint without a motor in a step, rad or m.
const MAX_SWING: f64 = 0.5;

/// Gain of a drive that reaches its target against any load, N m s/rad: wheels of a base that follows its commands, and the attitude of a
/// flying robot.
const STIFF: f64 = 1e6;

/// Turn in one step up to which a step of the integrator gains no energy, rad. Bodies and joints that turn more are limited.
const MAX_TURN: f64 = 0.1;

/// Largest acceleration of a flying robot that touches something, m/s². A quadrotor's rotors lift three times its weight at most.
const MAX_FLIGHT_ACCELERATION: f64 = 30.0;

/// A tree in motion: a robot, or an object without joints.
#[derive(Clone)]
pub(crate) struct ArticulatedRobot {
    id: BodyId,
    compiled: Arc<Articulated>,
    body: Body,
    servos: Vec<Servo>,
    /// Targets of the joints that have a value, as they were set, before couplings.
    targets: Vec<f64>,
    /// Angles of rollers that are not links, ring by ring, rad. Only viewers use them.
    roller_angles: Vec<Vec<f64>>,
    /// Impulses of the joints' rows in the last step.
    joint_impulses: Vec<f64>,
    /// Loads of the wheels in the last step.
    loads: Vec<Load>,
    /// Ground forces on each wheel in the last step that are not in a contact, N: rolling resistance at a hub, and the forces that make a
    /// base follow its commands.
    resistances: Vec<Vector3<f64>>,
    /// Contacts of the last step, each with the wheel that it pushed.
    contacts: Vec<Contact>,
    /// Poses and bounds of the surfaces in the current step.
    placed: Vec<Placed>,
    bounds: Bounds,
    /// True if the robot flies.
    flies: bool,
    /// True if a hand pulls it in the coming step.
    is_pulled: bool,
    /// Contacts of the current step that this robot holds, and impulses of those of the last step.
    found: Vec<CandidateContact>,
    known: Vec<Known>,
    /// Tyres in contact in the current step, and deflections of those of the last step.
    grips: Vec<(Key, Grip)>,
    deflections: Vec<(Key, Deflection)>,
    /// The engine's bodies of the links, with their colliders.
    in_engine: Vec<(RigidBodyHandle, Vec<(ColliderHandle, usize)>)>,
    /// A box, and the fixed colliders near it. They are valid until the robot leaves the box.
    near: Option<(Aabb, Vec<ColliderHandle>)>,
}

/// The state that a search over all robots needs. It fills one cache line, as other cores write it.
#[derive(Clone)]
#[repr(align(64))]
struct Bounds {
    /// A box around all surfaces.
    around: Option<Aabb>,
    /// True if the box and the contacts with fixed bodies are up to date.
    is_known: bool,
    /// Fault of the state, if any.
    fault: Option<Fault>,
}

impl ArticulatedRobot {
    /// Spawns a robot at a pose of its frame, at rest.
    pub(super) fn spawn(world: &mut PhysicsWorld, compiled: Arc<Articulated>, id: PawnId, pose: &Pose) -> Self {
        let body = Body::new(compiled.tree.clone(), *pose);
        let mut in_engine = Vec::new();
        for link in 0..compiled.tree.links().len() {
            let place = link_pose(&body, link);
            let handle = world.insert_body(RigidBodyBuilder::kinematic_position_based().pose(convert::pose(&place)));
            let own = compiled.surfaces.iter().enumerate().filter(|(_, surface)| surface.link == link);
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
        Self::at_rest(compiled, BodyId::Robot(id), pose, in_engine)
    }

    /// Creates a robot at rest, with bodies and colliders that the engine already has, by link.
    fn at_rest(
        compiled: Arc<Articulated>,
        id: BodyId,
        pose: &Pose,
        in_engine: Vec<(RigidBodyHandle, Vec<(ColliderHandle, usize)>)>,
    ) -> Self {
        let (joints, wheels) = (compiled.joints.len(), compiled.wheels.len());
        Self {
            id,
            body: Body::new(compiled.tree.clone(), *pose),
            servos: vec![Servo::default(); joints],
            targets: vec![0.0; joints],
            roller_angles: compiled.rings.iter().map(|ring| vec![0.0; ring.shape.len()]).collect(),
            joint_impulses: Vec::new(),
            loads: vec![Load::default(); wheels],
            resistances: vec![Vector3::zeros(); wheels],
            contacts: Vec::new(),
            placed: Vec::new(),
            bounds: Bounds { around: None, is_known: false, fault: None },
            flies: false,
            is_pulled: false,
            found: Vec::new(),
            known: Vec::new(),
            grips: Vec::new(),
            deflections: Vec::new(),
            in_engine,
            near: None,
            compiled,
        }
    }

    /// Returns the robot to a pose of its frame, at rest, as if just spawned.
    fn return_to(&mut self, pose: &Pose) {
        let in_engine = std::mem::take(&mut self.in_engine);
        *self = Self::at_rest(self.compiled.clone(), self.id, pose, in_engine);
    }

    /// Puts the robot at a pose of its frame, at rest. Its joints stay as they are.
    pub(super) fn put(&mut self, pose: &Pose) {
        self.body.velocity_mut().fill(0.0);
        self.body.set_pose(*pose);
        self.forget();
        self.forget_near();
    }

    /// Returns the engine's bodies.
    pub(super) fn bodies(&self) -> impl Iterator<Item = RigidBodyHandle> {
        self.in_engine.iter().map(|(body, _)| *body)
    }

    /// Sets the targets of the wheels' servos, rad/s.
    pub(super) fn set_wheel_speeds(&mut self, speeds: &[f64]) {
        motor::set_wheel_speeds(self.compiled.joints.iter().map(|joint| &joint.value), &mut self.servos, speeds);
    }

    /// Sets the target of a joint, by its number among the joints that have a value.
    pub(super) fn set_joint_target(&mut self, joint: usize, target: f64) {
        let value = self.compiled.joints.get(joint).map(|joint| &joint.value);
        motor::set_target(value, joint, target, &mut self.targets, &mut self.servos);
    }

    /// Sets the velocity of a flying robot for the coming step. In free air the velocity is set directly (AerialVehicle.uc:276-288). A
    /// robot in contact reaches it by a bounded force and torque, so it pushes no harder than its rotors could.
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
        let reach = self.compiled.surfaces.iter().map(|surface| surface.middle.norm() + surface.half.norm());
        let most = self.compiled.mass * MAX_FLIGHT_ACCELERATION * reach.fold(0.0, f64::max);
        for axis in 0..3 {
            self.body.set_drive(axis, Drive { at_rest: STIFF * angular[axis], gain: STIFF, most });
        }
        self.body.place();
        self.flies = true;
        self.bounds.is_known = false;
    }

    /// Applies servos, gravity, rolling resistance and friction of bearings for the coming step.
    fn before_step(&mut self, gravity: Vector3<f64>, is_alone: bool, time_step: f64) {
        self.brake_rollers(gravity, time_step);
        let Self { compiled, body, servos, targets, loads, resistances, .. } = self;
        body.set_gravity(if self.flies { Vector3::zeros() } else { gravity });
        motor::follow_targets(compiled.joints.iter().map(|joint| &joint.value), targets, servos);
        for (number, joint) in compiled.joints.iter().enumerate() {
            let Some(motor) = &joint.value.motor else { continue };
            if compiled.following.is_some() && joint.value.is_wheel {
                let target = servos[number].target();
                body.set_drive(joint.dof, Drive { at_rest: STIFF * target, gain: STIFF, most: f64::INFINITY });
                continue;
            }
            let JointState { position, speed } = joint.state(body);
            let Torque { at_rest, gain } = servos[number].torque(motor, position, speed, time_step);
            body.set_drive(joint.dof, Drive { at_rest, gain, most: motor.max_torque });
        }
        let share = compiled.mass / compiled.wheels.len().max(1) as f64;
        for ((hub, load), resistance) in compiled.wheels.iter().zip(loads).zip(resistances) {
            *resistance = Vector3::zeros();
            if load.resistance == 0.0 {
                continue;
            }
            let frame = &body.frames()[hub.carrier];
            let fall = gravity * time_step;
            if let Some(driven) = hub.driven {
                let (ahead, axle) = (frame.rotation * Vector3::x(), frame.rotation * Vector3::from(WHEEL_AXIS));
                let dof = body.tree().dof_of(driven.link);
                let speed = driven.radius * body.velocity()[dof] + ahead.dot(&fall);
                // In a heap a wheel turns a little without its robot, as tangents give way there. What stops both would turn it back.
                let wheel = body.tree().links()[driven.link].mass.inertia[(1, 1)] / driven.radius.powi(2);
                let mass = if is_alone { share } else { wheel.min(share) };
                let moment = load.moment(driven.radius, speed, mass, time_step);
                body.twist(driven.link, axle * moment);
                continue;
            }
            let centre = body.centre() + frame.origin + frame.rotation * hub.centre;
            let velocity = body.velocity_at(hub.carrier, centre) + fall;
            *resistance = load.force(velocity, share, time_step);
            body.push(hub.carrier, centre, *resistance);
        }
    }

    /// Adds the rows of joint ends, dry friction and couplings for the coming step. `number` is the robot's number among the bodies.
    fn joint_rows(&self, number: usize, time_step: f64, rows: &mut Vec<JointRow>) {
        let row = |terms, constraint, target| JointRow {
            body: number,
            terms,
            root: [0.0; 6],
            constraint,
            target,
            compliance: 0.0,
            impulse: 0.0,
        };
        let back = |beyond: f64| {
            if beyond > 0.0 { (beyond / (time_step + END_TIME)).min(MAX_RETURN) } else { beyond / time_step }
        };
        let end = Constraint::Contact { friction: 0.0, tangents: 0 };
        for joint in &self.compiled.joints {
            if let Some([low, high]) = joint.value.limits {
                let JointState { position, speed } = joint.state(&self.body);
                // Only ends that the joint can reach in a few steps get a row.
                let reach = 0.01 + 4.0 * speed.abs() * time_step;
                if position - low < reach {
                    rows.push(row([Some((joint.dof, 1.0)), None], end, back(low - position)));
                }
                if high - position < reach {
                    rows.push(row([Some((joint.dof, -1.0)), None], end, back(position - high)));
                }
            }
            if joint.friction > 0.0 {
                rows.push(row([Some((joint.dof, 1.0)), None], Constraint::Within(joint.friction * time_step), 0.0));
            }
        }
        for gear in &self.compiled.gears {
            let at = |link: usize| self.body.position(link);
            let off = gear.multiplier * at(gear.leader.0) + gear.offset - at(gear.follower.0);
            let terms = [Some((gear.follower.1, 1.0)), Some((gear.leader.1, -gear.multiplier))];
            let back = (off / (time_step + END_TIME)).clamp(-MAX_RETURN, MAX_RETURN);
            rows.push(row(terms, Constraint::Within(f64::INFINITY), back));
        }
    }

    /// Adds the rows of the joints, warm-started with the last step's impulses. A robot in contact also gets the rows that make it follow
    /// its commands. `gravity` is the weight of a kilogram, N.
    fn add_joint_rows(&self, number: usize, gravity: f64, time_step: f64, rows: &mut Vec<JointRow>) {
        let before = rows.len();
        self.joint_rows(number, time_step, rows);
        if !self.found.is_empty() {
            rows.extend(self.following_rows(number, gravity, time_step).into_iter().flatten());
        }
        let rows = &mut rows[before..];
        if rows.len() == self.joint_impulses.len() {
            rows.iter_mut().zip(&self.joint_impulses).for_each(|(row, &impulse)| row.impulse = impulse);
        }
    }

    /// Returns the rows that make a base follow its commands, if it does. `gravity` is the weight of a kilogram, N.
    fn following_rows(&self, number: usize, gravity: f64, time_step: f64) -> Option<[JointRow; 3]> {
        let following = self.compiled.following.as_ref()?;
        let mut wheels = self.compiled.joints.iter().zip(&self.servos).filter(|(joint, _)| joint.value.is_wheel);
        let wheels: [(f64, f64); 4] = std::array::from_fn(|_| {
            let wheel = wheels.next();
            wheel.map_or((0.0, 0.0), |(joint, servo)| (servo.target(), self.body.position(joint.link)))
        });
        let weight = gravity * self.compiled.mass;
        Some(following.rows(number, &self.body, [wheels.map(|it| it.0), wheels.map(|it| it.1)], weight, time_step))
    }

    /// Returns the angle of a wheel beyond the one in its link's frame, rad.
    fn turned(&self, ring: &Ring) -> f64 {
        if ring.first_link.is_some() { 0.0 } else { self.body.position(ring.wheel) }
    }

    /// Returns the angles of the rollers about their own axes, wheel by wheel, rad.
    pub(super) fn roller_angles(&self) -> Vec<f64> {
        let of_ring = |(ring, angles): (&Ring, &Vec<f64>)| -> Vec<f64> {
            ring.first_link.map_or_else(
                || angles.clone(),
                |first| (first..first + angles.len()).map(|link| self.body.position(link)).collect(),
            )
        };
        self.compiled.rings.iter().zip(&self.roller_angles).flat_map(of_ring).collect()
    }

    /// True if the robot turns or moves so fast that a step of the integrator may gain energy.
    fn is_fast(&self, time_step: f64) -> bool {
        let Frame { angular, linear, .. } = &self.body.frames()[0];
        angular.norm() * time_step > MAX_TURN || linear.norm() * time_step > finding::MAX_PREDICTION
    }

    /// Computes the most work that the servos can have done in the last step, J. A servo drives no faster than its speed limit; it brakes
    /// a joint that turns faster.
    fn servo_work(&self, time_step: f64) -> f64 {
        let joints = self.compiled.joints.iter().filter_map(|joint| Some((joint, joint.value.motor.as_ref()?)));
        let driven = |speed: f64, motor: &Motor| speed.abs().min(motor.max_speed);
        joints.map(|(joint, motor)| motor.max_torque * driven(self.body.velocity()[joint.dof], motor) * time_step).sum()
    }

    /// Returns what a spring pulls: the root, with the mass of all.
    pub(super) fn grasped(&self) -> Grasped {
        let root = &self.body.tree().links()[0].mass;
        Grasped::new(self.state(), self.body.centre(), (root.mass, root.inertia), self.compiled.mass)
    }

    /// Applies the effect of a spring to the root for the coming step.
    pub(super) fn pull(&mut self, tug: &Tug) {
        self.body.push(0, tug.point, tug.force);
        self.body.twist(0, tug.torque);
        self.is_pulled = true;
    }

    /// Moves the robot by a step. If a load turns a joint too fast, the robot's motion about its centre of mass is slowed.
    fn advance(&mut self, time_step: f64) {
        let joints = self.compiled.joints.iter().filter(|joint| !joint.value.is_wheel);
        let of_motor = |motor: &Motor| f64::max(motor.max_speed * MAX_OVERSPEED, MAX_TURN / time_step);
        let most = |motor: Option<&Motor>| motor.map_or(MAX_SWING / time_step, of_motor);
        let velocity = self.body.velocity();
        let share = joints.map(|joint| most(joint.value.motor.as_ref()) / velocity[joint.dof].abs());
        let share = share.fold(1.0, f64::min);
        if share < 1.0 {
            self.body.scale_motion(share);
        }
        self.body.advance(time_step);
        self.is_pulled = false;
    }

    /// Scales the velocities.
    fn slow_down(&mut self, share: f64) {
        self.body.velocity_mut().iter_mut().for_each(|speed| *speed *= share);
        self.body.place();
    }

    /// Tells the engine the poses of the shapes at the end of its coming step.
    pub(super) fn lead_engine(&self, world: &mut PhysicsWorld) {
        for (link, (handle, _)) in self.in_engine.iter().enumerate() {
            let place = convert::pose(&link_pose(&self.body, link));
            if let Some(body) = world.bodies.get_mut(*handle) {
                body.set_next_kinematic_position(place);
            }
        }
    }

    /// Moves the engine's shapes to their current poses, for rays and the search for free places.
    pub(super) fn enter_queries(&self, world: &mut PhysicsWorld) {
        for (link, (handle, colliders)) in self.in_engine.iter().enumerate() {
            let place = convert::pose(&link_pose(&self.body, link));
            if let Some(body) = world.bodies.get_mut(*handle) {
                body.set_position(place, false);
            }
            for &(handle, number) in colliders {
                let PhysicsWorld { broad_phase, integration_parameters, colliders, .. } = world;
                if let Some(collider) = colliders.get_mut(handle) {
                    collider.set_position(place * self.compiled.surfaces[number].pose);
                    set_box(broad_phase, integration_parameters, handle, collider);
                }
            }
        }
    }

    /// Returns pose and velocity of the robot frame.
    pub(super) fn state(&self) -> BodyState {
        let frame = &self.body.frames()[0];
        BodyState { pose: *self.body.pose(), linear: frame.linear, angular: frame.angular }
    }

    /// Returns the robot frame as it moves with a link of the definition. `origin` is the link's origin in the robot frame when every joint
    /// is at 0.
    pub(super) fn carrier(&self, link: usize, origin: Vector3<f64>) -> Option<BodyState> {
        let &(own, offset) = self.compiled.places.get(link)?;
        let (frame, pose) = (&self.body.frames()[own], link_pose(&self.body, own));
        let pose = pose * nalgebra::Translation3::from(offset - origin);
        let lever = pose.translation.vector - (self.body.centre() + frame.origin);
        Some(BodyState { pose, linear: frame.linear + frame.angular.cross(&lever), angular: frame.angular })
    }

    /// Returns every joint that has a value, in the order of the links. The flag is true for wheels.
    pub(super) fn joints(&self) -> impl Iterator<Item = (bool, JointState)> {
        self.compiled.joints.iter().map(|joint| (joint.value.is_wheel, joint.state(&self.body)))
    }

    /// Returns the contacts of the last step.
    pub(super) fn contacts(&self) -> &[Contact] {
        &self.contacts
    }

    /// Returns the ground forces on each wheel in the last step that are not in a contact, N.
    pub(super) fn resistances(&self) -> &[Vector3<f64>] {
        &self.resistances
    }

    /// Returns the fault of the state, if it has one.
    pub(super) fn fault(&self) -> Option<Fault> {
        self.bounds.fault
    }

    /// Returns pose and generalised velocity as numbers.
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

/// Computes the pose of a link in the world.
fn link_pose(body: &Body, link: usize) -> Pose {
    let frame = &body.frames()[link];
    let of = &body.tree().links()[link];
    let rotation = match link {
        0 => body.pose().rotation,
        // A round link's frame turns with its parent alone.
        _ if of.is_round && of.parent == 0 => body.pose().rotation,
        _ => UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(frame.rotation)),
    };
    Pose::from_parts((body.centre() + frame.origin).into(), rotation)
}
