//! A robot of a world: a tree in reduced coordinates ([`super::articulated`]), or one multibody of the engine for its chassis, its wheels
//! and their rollers.

use std::collections::BTreeMap;
use std::sync::Arc;

use nalgebra::{Translation3, Vector3};
use rapier3d::prelude::*;
use scene::{Coupling, JointState, Pose, Steering};

use super::articulated::{self, ArticulatedRobot, MapObject, Surroundings};
use super::compile::{CompiledRobot, Footing, Gear, Joint, Kind, Role, Tree};
use super::identity::Identity;
use super::motor::{Servo, Torque, Value};
use super::rolling::{self, Load};
use super::{BodyState, Fault, LANDING_TIME, Physics, WheelState, convert};
use crate::RobotId;
use crate::flight::Flight;
use crate::threads::Threads;

/// A robot of which no wheel carries anything falls when it goes down so fast, m/s. Put onto a surface it comes down with
/// 0.14 m/s; what is faster has fallen off the map and lands nowhere.
const FALLING_SPEEDS: std::ops::Range<f64> = 0.2..20.0;

/// Where no ray comes, m.
const FAR_AWAY: Vector = Vector::new(1e6, 1e6, 1e6);

/// The bodies of one robot.
pub(crate) struct RobotBodies {
    robot: Arc<CompiledRobot>,
    /// The body of every link, parents before their children.
    all: Vec<RigidBodyHandle>,
    drivetrain: Drivetrain,
    /// How it flies, if it does.
    pub(super) flight: Option<Flight>,
}

/// What turns the wheels.
pub(super) enum Drivetrain {
    Multibody {
        /// Every joint that has a value, in the order of the links.
        joints: Vec<TreeJoint>,
        /// The joints of the rollers, wheel by wheel.
        rollers: Vec<MultibodyJointHandle>,
        /// Of every wheel, casters too.
        treads: Vec<Tread>,
    },
    Articulated(Box<ArticulatedRobot>),
}

/// A joint that has a value.
pub(super) struct TreeJoint {
    handle: MultibodyJointHandle,
    axis: JointAxis,
    value: Value,
    servo: Servo,
    /// Its own target; that of a wheel and of a joint that follows none is its servo's.
    target: f64,
}

/// What touches the ground of a wheel.
pub(super) struct Tread {
    pub(super) colliders: Vec<ColliderHandle>,
    /// Rolling resistance in the last step, N.
    pub(super) resistance: Vector3<f64>,
}

impl RobotBodies {
    /// What it was made of.
    pub(crate) fn robot(&self) -> &Arc<CompiledRobot> {
        &self.robot
    }

    /// The body of every link, parents before their children.
    pub(super) fn all(&self) -> &[RigidBodyHandle] {
        &self.all
    }

    pub(super) fn drivetrain(&self) -> &Drivetrain {
        &self.drivetrain
    }

    fn articulated(&self) -> Option<&ArticulatedRobot> {
        if let Drivetrain::Articulated(robot) = &self.drivetrain { Some(robot) } else { None }
    }

    /// Whether a body is one of the robot's.
    pub(super) fn contains(&self, body: RigidBodyHandle) -> bool {
        self.all.contains(&body)
    }

    /// Sets the targets of the wheel servos, rad/s.
    pub(crate) fn set_wheel_speeds(&mut self, speeds: &[f64]) {
        match &mut self.drivetrain {
            Drivetrain::Multibody { joints, .. } => {
                let wheels = joints.iter_mut().filter(|joint| joint.value.is_wheel);
                wheels.zip(speeds).for_each(|(wheel, &speed)| wheel.servo.set_target(speed));
            }
            Drivetrain::Articulated(robot) => robot.set_wheel_speeds(speeds),
        }
    }

    /// Sets the target of the servo of a joint by its number among those that have a value: rad or m within its limits, or
    /// rad/s or m/s, as its motor is a servo of.
    pub(crate) fn set_joint_target(&mut self, joint: usize, target: f64) {
        match &mut self.drivetrain {
            Drivetrain::Multibody { joints, .. } => {
                if let Some(joint) = joints.get_mut(joint) {
                    joint.target = joint.value.within_limits(target);
                    joint.servo.set_target(joint.target);
                }
            }
            Drivetrain::Articulated(robot) => robot.set_joint_target(joint, target),
        }
    }
}

impl Physics {
    /// Puts a robot at a pose of its frame, at rest.
    pub(crate) fn spawn(&mut self, robot: Arc<CompiledRobot>, id: RobotId, pose: &Pose) -> RobotBodies {
        let (all, drivetrain) = match &robot.kind {
            Kind::Tree(tree) => self.spawn_tree(tree, id, pose),
            Kind::Articulated(tree) => {
                let robot = ArticulatedRobot::spawn(&mut self.world, tree.clone(), id, pose);
                (robot.bodies().collect(), Drivetrain::Articulated(Box::new(robot)))
            }
        };
        self.is_changed = true;
        self.robots_of_engine += usize::from(!matches!(drivetrain, Drivetrain::Articulated(_)));
        let flight = (robot.def.steering == Steering::Aerial).then(Flight::default);
        let bodies = RobotBodies { robot, all, drivetrain, flight };
        self.enter_queries(&bodies);
        bodies
    }

    /// Colliders enter the engine's tree with its next step only. Rays and the next robot that is spawned have to meet them
    /// at once, however many are spawned between two steps.
    fn enter_queries(&mut self, bodies: &RobotBodies) {
        let PhysicsWorld { broad_phase, integration_parameters, colliders, bodies: engine, .. } = &mut self.world;
        for body in bodies.all.iter().filter_map(|&body| engine.get(body)) {
            for &handle in body.colliders() {
                if let Some(collider) = colliders.get(handle) {
                    broad_phase.set_aabb(integration_parameters, handle, collider.compute_aabb());
                }
            }
        }
    }

    fn spawn_tree(&mut self, tree: &Tree, id: RobotId, pose: &Pose) -> (Vec<RigidBodyHandle>, Drivetrain) {
        let (mut frames, mut all) = (Vec::new(), Vec::new());
        let (mut joints, mut rollers, mut treads) = (Vec::new(), Vec::new(), BTreeMap::new());
        for (number, link) in (0..).zip(&tree.links) {
            let parent = link.joint.as_ref().map(|joint| joint.parent);
            let frame = parent.map_or(*pose, |parent| frames[parent] * link.pose);
            let origin = if parent.is_none() { frame * Translation3::from(tree.centre) } else { frame };
            let body = match tree.footing {
                Footing::Fixed if parent.is_none() => self.world.insert_body(fixed_body(&origin, link.mass)),
                Footing::Fixed | Footing::Free => self.world.insert_body(dynamic_body(&origin, link.mass)),
                Footing::Flying => self.world.insert_body(dynamic_body(&origin, link.mass).gravity_scale(0.0)),
            };
            let identity = Identity::Link { robot: id, link: number };
            let colliders =
                link.surfaces.iter().map(|it| self.world.insert_collider(it.collider(identity), Some(body)));
            let colliders: Vec<ColliderHandle> = colliders.collect();
            if let Some(Joint { parent, joint, role, .. }) = &link.joint {
                let joint = self.world.multibody_joints.insert(all[*parent], body, *joint, true);
                match (role, joint) {
                    (&Role::Value(axis, ref value), Some(handle)) => {
                        let (value, servo) = (value.clone(), Servo::default());
                        joints.push(TreeJoint { handle, axis, value, servo, target: 0.0 });
                    }
                    (Role::Roller, handle) => rollers.extend(handle),
                    (Role::Value(..), None) | (Role::Free, _) => {}
                }
            }
            if let Some(wheel) = link.wheel {
                let tread = || Tread { colliders: Vec::new(), resistance: Vector3::zeros() };
                treads.entry(wheel).or_insert_with(tread).colliders.extend(colliders);
            }
            frames.push(frame);
            all.push(body);
        }
        self.set_joint_parameters(tree, &all);
        (all, Drivetrain::Multibody { joints, rollers, treads: treads.into_values().collect() })
    }

    /// Takes a robot out of the world.
    ///
    /// The engine forgets what a removed collider was near to only if no other one has taken its place by the next step;
    /// otherwise it keeps that for ever. So something that touches nothing takes the places until then.
    pub(crate) fn remove(&mut self, bodies: &RobotBodies) {
        self.is_changed = true;
        self.robots_of_engine -= usize::from(bodies.articulated().is_none());
        let mut places = 0;
        for &body in bodies.all.iter().rev() {
            places += self.world.remove_body_with_colliders(body, true).map_or(0, |body| body.colliders().len());
        }
        for _ in 0..places {
            let placeholder = ColliderBuilder::ball(0.001).translation(FAR_AWAY).enabled(false);
            self.placeholders.push(self.world.insert_collider(placeholder, None));
        }
    }

    /// Gives the motors and wheels of a robot that the engine moves their part in the coming step.
    pub(crate) fn before_step(&mut self, bodies: &mut RobotBodies) {
        let RobotBodies { robot, all, drivetrain, flight } = bodies;
        match drivetrain {
            Drivetrain::Multibody { joints, treads, .. } => {
                if let (Some(flight), Some(&root)) = (flight, all.first()) {
                    self.fly(root, robot.centre(), flight);
                }
                self.reset_forces(all);
                follow_targets(joints);
                self.set_motors(joints);
                if let Kind::Tree(tree) = &robot.kind {
                    self.set_rolling_resistance(tree, robot.mass, all, treads);
                }
            }
            Drivetrain::Articulated(_) => {}
        }
    }

    /// Moves the robots in reduced coordinates on by a step, all that touch each other together.
    pub(crate) fn solve_articulated<'a>(
        &mut self,
        robots: impl Iterator<Item = &'a mut RobotBodies>,
        threads: &dyn Threads,
    ) {
        let robots = robots.filter_map(|bodies| match &mut bodies.drivetrain {
            Drivetrain::Articulated(robot) => Some((&mut **robot, bodies.flight.as_ref())),
            Drivetrain::Multibody { .. } => None,
        });
        let &mut Self {
            ref mut world,
            ref materials,
            ref mut objects,
            robots_of_engine,
            is_changed,
            ref mut rooms,
            ..
        } = self;
        let surroundings = Surroundings { materials, robots_of_engine, is_changed, threads };
        self.unsettled += articulated::solve(world, surroundings, robots.collect(), objects, rooms);
    }

    /// Says to the engine where the robots in reduced coordinates come to be in its coming step.
    pub(crate) fn lead_engine<'a>(&mut self, robots: impl Iterator<Item = &'a RobotBodies>) {
        let taken = self.objects.iter().filter_map(MapObject::taken);
        taken.for_each(|taken| taken.lead_engine(&mut self.world));
        robots.filter_map(RobotBodies::articulated).for_each(|robot| robot.lead_engine(&mut self.world));
    }

    /// Puts the shapes of the robots in reduced coordinates where they are, for rays, and for those who look for room.
    pub(crate) fn enter_shapes<'a>(&mut self, robots: impl Iterator<Item = &'a RobotBodies>) {
        let taken = self.objects.iter().filter_map(MapObject::taken);
        taken.for_each(|taken| taken.enter_queries(&mut self.world));
        robots.filter_map(RobotBodies::articulated).for_each(|robot| robot.enter_queries(&mut self.world));
    }

    /// Numbers that say where a robot in reduced coordinates is and how it moves; the engine's are its bodies'.
    pub(crate) fn numbers(&self, bodies: &RobotBodies) -> Vec<f64> {
        bodies.articulated().map_or_else(Vec::new, ArticulatedRobot::numbers)
    }

    /// Every joint that has a value, in the order of the links.
    pub(crate) fn joints(&self, bodies: &RobotBodies) -> Vec<JointState> {
        match &bodies.drivetrain {
            Drivetrain::Multibody { joints, .. } => joints.iter().map(|joint| joint.state(&self.world)).collect(),
            Drivetrain::Articulated(robot) => robot.joints().map(|(_, state)| state).collect(),
        }
    }

    /// The driven wheels, in order.
    pub(crate) fn wheels(&self, bodies: &RobotBodies) -> Vec<WheelState> {
        let of_wheel = |JointState { position, speed }: JointState| WheelState { angle: position, speed };
        match &bodies.drivetrain {
            Drivetrain::Multibody { joints, .. } => {
                let wheels = joints.iter().filter(|joint| joint.value.is_wheel);
                wheels.map(|wheel| of_wheel(wheel.state(&self.world))).collect()
            }
            Drivetrain::Articulated(robot) => {
                robot.joints().filter(|(is_wheel, _)| *is_wheel).map(|(_, state)| of_wheel(state)).collect()
            }
        }
    }

    /// Ends the forces of the last step: rolling resistance, and what the wheels of others did.
    fn reset_forces(&mut self, bodies: &[RigidBodyHandle]) {
        for &handle in bodies {
            let pushed = |body: &RigidBody| body.user_force() != Vector::ZERO || body.user_torque() != Vector::ZERO;
            if self.world.bodies.get(handle).is_some_and(pushed)
                && let Some(body) = self.world.bodies.get_mut(handle)
            {
                body.reset_forces(false);
                body.reset_torques(false);
            }
        }
    }

    fn set_motors(&mut self, joints: &mut [TreeJoint]) {
        let time_step = self.world.integration_parameters.dt;
        for joint in joints {
            let JointState { position, speed } = joint.state(&self.world);
            let TreeJoint { handle, axis, value, servo, .. } = joint;
            let Some(motor) = &value.motor else { continue };
            let Torque { at_rest, gain } = servo.torque(motor, position, speed, time_step);
            if let Some((multibody, link)) = self.world.multibody_joints.get_mut(*handle)
                && let Some(link) = multibody.link_mut(link)
            {
                link.joint.data.set_motor_velocity(*axis, at_rest / gain, gain);
            }
        }
    }

    /// Gives the hubs their rolling resistance, and notices whether the robot falls: both follow from the loads.
    fn set_rolling_resistance(&mut self, tree: &Tree, mass: f64, all: &[RigidBodyHandle], treads: &mut [Tread]) {
        let time_step = self.world.integration_parameters.dt;
        let fall = convert::from_vector(self.world.gravity) * time_step;
        let share = mass / treads.len() as f64;
        let load = |tread: &Tread| rolling::load(&self.world, &self.materials, &tread.colliders);
        let loads: Vec<Load> = treads.iter().map(load).collect();
        let Some(chassis) = self.world.bodies.get(all[0]) else { return };
        let down = fall.normalize().dot(&convert::from_vector(chassis.linvel()));
        if FALLING_SPEEDS.contains(&down) && loads.iter().all(|load| load.normal == Vector3::zeros()) {
            self.landing = LANDING_TIME;
        }
        for ((wheel, load), tread) in tree.wheels.iter().zip(&loads).zip(treads) {
            let Some(carrier) = self.world.bodies.get_mut(all[wheel.parent]) else { continue };
            let hub = carrier.position() * convert::vector(wheel.hub);
            let mut velocity = convert::from_vector(carrier.velocity_at_point(hub)) + fall;
            if wheel.rolls_ahead_only {
                let ahead = convert::from_vector(carrier.rotation() * Vector::X);
                velocity = ahead * ahead.dot(&velocity);
            }
            tread.resistance = rolling::impulse(load, velocity, share) / time_step;
            carrier.add_force_at_point(convert::vector(tread.resistance), hub, true);
        }
    }

    /// The fault of a robot's state, if it has one. The engine holds a body whose state is not finite where it was last, which is no
    /// better.
    pub(crate) fn fault(&self, bodies: &RobotBodies) -> Option<Fault> {
        if let Some(robot) = bodies.articulated() {
            return robot.fault();
        }
        let joints = self.joints(bodies);
        let mut joints = joints.iter().flat_map(|joint| [joint.position, joint.speed]);
        let held = self.world.quarantine();
        let is_held = |&collider: &ColliderHandle| {
            let parent = self.world.colliders.get(collider).and_then(Collider::parent);
            parent.is_some_and(|body| bodies.contains(body))
        };
        let is_finite = joints.all(f64::is_finite)
            && !held.bodies().iter().any(|&body| bodies.contains(body))
            && !held.colliders().iter().any(is_held);
        if is_finite { Fault::of(&self.body(bodies)) } else { Some(Fault::NotFinite) }
    }

    /// Pose and velocity of the robot frame.
    pub(crate) fn body(&self, bodies: &RobotBodies) -> BodyState {
        if let Some(robot) = bodies.articulated() {
            return robot.state();
        }
        let (body, centre) = (&self.world.bodies[bodies.all[0]], bodies.robot.centre());
        frame_at(body, body.linvel(), centre)
    }

    /// The robot frame as it moves with a link by its number in the definition, when every joint was at 0. `None` of the body,
    /// whose own it is.
    pub(crate) fn carrier(&self, bodies: &RobotBodies, link: usize) -> Option<BodyState> {
        let origin = bodies.robot.def.links.get(link).filter(|_| link > 0)?.origin();
        if let Some(robot) = bodies.articulated() {
            return robot.carrier(link, origin.into());
        }
        let Kind::Tree(tree) = &bodies.robot.kind else { return None };
        let body = self.world.bodies.get(bodies.all[*tree.numbers.get(link)?])?;
        Some(frame_at(body, body.velocity_at_point(body.translation()), origin.into()))
    }

    /// The robot does not collide with itself (the thesis lists 81 disabled pairs, all within one robot;
    /// collision groups could not tell 64 robots apart). Damping: by default the engine brakes every turning
    /// joint with 0.1 N m s/rad, far too much for a roller, so each is set.
    fn set_joint_parameters(&mut self, tree: &Tree, all: &[RigidBodyHandle]) {
        let ids: Vec<_> = all.iter().map(|&body| self.world.multibody_joints.rigid_body_link(body).copied()).collect();
        let Some(multibody) = ids[0].and_then(|id| self.world.multibody_joints.get_multibody_mut(id.multibody)) else {
            return;
        };
        multibody.set_self_contacts_enabled(false);
        let [linear, angular] = tree.root_damping;
        multibody.damping_mut().fill(0.0);
        multibody.damping_mut().rows_mut(0, 3).fill(linear);
        multibody.damping_mut().rows_mut(3, 3).fill(angular);
        for (link, id) in tree.links.iter().zip(&ids) {
            let (Some(joint), Some(id)) = (&link.joint, id) else { continue };
            let Some(of_engine) = multibody.link(id.id) else { continue };
            let (first, count) = (of_engine.assembly_id(), of_engine.joint().ndofs());
            multibody.damping_mut().rows_mut(first, count).fill(joint.damping);
            multibody.armature_mut().rows_mut(first, count).fill(joint.armature);
            multibody.frictions_mut().rows_mut(first, count).fill(joint.friction);
        }
        for &Gear { leader, follower, multiplier, offset } in &tree.gears {
            let ([Some(leader), Some(follower)], [axis1, axis2]) =
                ([leader.0, follower.0].map(|link| ids[link]), [leader.1, follower.1])
            else {
                continue;
            };
            multibody.add_dof_coupling(MultibodyDofCoupling {
                link1: leader.id,
                dof1: 0,
                axis1: axis1 as usize,
                link2: follower.id,
                dof2: 0,
                axis2: axis2 as usize,
                coeff: multiplier,
                offset,
            });
        }
    }
}

/// The frame in which a body has its origin at `origin`, and that moves with it; `linear` is the velocity there.
fn frame_at(body: &RigidBody, linear: Vector, origin: Vector3<f64>) -> BodyState {
    let pose = convert::from_pose(body.position()) * Translation3::from(-origin);
    let (linear, angular) = (convert::from_vector(linear), convert::from_vector(body.angvel()));
    BodyState { pose, linear: linear - angular.cross(&(pose.rotation * origin)), angular }
}

/// The engine puts bodies to sleep below 0.4 m/s; a youBot drives at 0.05.
fn dynamic_body(pose: &Pose, mass: MassProperties) -> RigidBodyBuilder {
    RigidBodyBuilder::dynamic().pose(convert::pose(pose)).additional_mass_properties(mass).can_sleep(false)
}

fn fixed_body(pose: &Pose, mass: MassProperties) -> RigidBodyBuilder {
    RigidBodyBuilder::fixed().pose(convert::pose(pose)).additional_mass_properties(mass)
}

/// Gives the servos that follow the target of another theirs.
fn follow_targets(joints: &mut [TreeJoint]) {
    for number in 0..joints.len() {
        let follower = &joints[number];
        let Some(Coupling { leader, multiplier, offset, .. }) = follower.value.follows else { continue };
        let Some(leader) = joints.get(leader) else { continue };
        let target = follower.value.within_limits(follower.target + multiplier * leader.servo.target() + offset);
        joints[number].servo.set_target(target);
    }
}

impl TreeJoint {
    fn state(&self, world: &PhysicsWorld) -> JointState {
        joint_state(world, self.handle, self.axis)
    }
}

/// Where a joint with one value along an axis is, and how fast.
pub(super) fn joint_state(world: &PhysicsWorld, handle: MultibodyJointHandle, axis: JointAxis) -> JointState {
    let found = world.multibody_joints.get(handle);
    let Some((multibody, Some(link))) = found.map(|(multibody, link)| (multibody, multibody.link(link))) else {
        return JointState::default();
    };
    let speed = multibody.joint_velocity(link).iter().next().map_or(0.0, |&speed| speed);
    JointState { position: link.joint.coords()[axis as usize], speed }
}
