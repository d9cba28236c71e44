//! Robots of the drive model `bodies`: one multibody of rapier per robot, with its chassis, wheels and rollers.
//!
//! This is the thesis's model, and an independent program to compare [`super::articulated`] with. It is frozen: new mechanics are added to
//! `articulated` alone.

mod apply;
mod compile;
mod contact;
mod insert;
mod joint;
mod shape;
mod solver;

use std::sync::Arc;

use nalgebra::{Translation3, Vector3};
use rapier3d::prelude::*;
use scene::{BodyState, JointState};

use super::convert;
use super::fault::Fault;
use super::motor::{self, Servo, Value};
use super::pull::{Grasped, Tug};

pub(super) use compile::Tree;
pub(super) use solver::{Landing, set_parameters};

/// A robot that the engine moves.
#[derive(Clone)]
pub(super) struct MultibodyRobot {
    tree: Arc<Tree>,
    /// Bodies of the links, parents before their children.
    links: Vec<RigidBodyHandle>,
    /// Joints that have a value, in the order of the links.
    joints: Vec<ValueJoint>,
    servos: Vec<Servo>,
    /// Targets of the joints, as they were set, before couplings.
    targets: Vec<f64>,
    /// Joints of the rollers, wheel by wheel.
    rollers: Vec<MultibodyJointHandle>,
    /// Colliders of each wheel that touch the ground. Casters count as wheels.
    treads: Vec<Vec<ColliderHandle>>,
    /// Rolling resistance of each wheel in the last step, N.
    resistances: Vec<Vector3<f64>>,
}

/// A joint that has a value.
#[derive(Clone)]
struct ValueJoint {
    handle: MultibodyJointHandle,
    axis: JointAxis,
    value: Value,
}

impl MultibodyRobot {
    /// Returns the bodies of the links, parents before their children.
    pub(super) fn bodies(&self) -> &[RigidBodyHandle] {
        &self.links
    }

    /// Sets the targets of the wheels' servos, rad/s.
    pub(super) fn set_wheel_speeds(&mut self, speeds: &[f64]) {
        motor::set_wheel_speeds(self.joints.iter().map(|joint| &joint.value), &mut self.servos, speeds);
    }

    /// Sets the target of a joint, by its number among the joints that have a value.
    pub(super) fn set_joint_target(&mut self, joint: usize, target: f64) {
        let value = self.joints.get(joint).map(|joint| &joint.value);
        motor::set_target(value, joint, target, &mut self.targets, &mut self.servos);
    }

    /// Returns every joint that has a value, in the order of the links. The flag is true for wheels.
    pub(super) fn joints(&self, world: &PhysicsWorld) -> impl Iterator<Item = (bool, JointState)> {
        self.joints.iter().map(|joint| (joint.value.is_wheel, joint.state(world)))
    }

    /// Returns the angles of the rollers about their own axes, wheel by wheel, rad.
    pub(super) fn roller_angles(&self, world: &PhysicsWorld) -> Vec<f64> {
        self.rollers.iter().map(|&roller| joint_state(world, roller, JointAxis::AngX).position).collect()
    }

    /// Returns pose and velocity of the robot frame.
    pub(super) fn state(&self, world: &PhysicsWorld) -> BodyState {
        let body = &world.bodies[self.links[0]];
        frame_at(body, body.linvel(), self.tree.centre)
    }

    /// Returns the robot frame as it moves with a link of the definition. `origin` is the link's origin in the robot frame when every joint
    /// is at 0.
    pub(super) fn carrier(&self, world: &PhysicsWorld, link: usize, origin: Vector3<f64>) -> Option<BodyState> {
        let body = world.bodies.get(self.links[*self.tree.numbers.get(link)?])?;
        Some(frame_at(body, body.velocity_at_point(body.translation()), origin))
    }

    /// Returns what a spring pulls: the first link, with the mass of all.
    pub(super) fn grasped(&self, world: &PhysicsWorld) -> Grasped {
        let root = &world.bodies[self.links[0]];
        let mass: f64 = self.links.iter().map(|&link| world.bodies[link].mass()).sum();
        let inertia = root.mass_properties().local_mprops.reconstruct_inertia_matrix().to_cols_array_2d().into();
        let centre = convert::from_vector(root.center_of_mass());
        Grasped::new(self.state(world), centre, (root.mass(), inertia), mass)
    }

    /// Applies the effect of a spring to the first link for the coming step.
    pub(super) fn pull(&self, world: &mut PhysicsWorld, tug: &Tug) {
        if let Some(root) = world.bodies.get_mut(self.links[0]) {
            root.add_force_at_point(convert::vector(tug.force), convert::vector(tug.point), true);
            root.add_torque(convert::vector(tug.torque), true);
        }
    }

    /// Returns the fault of the state, if it has one. The engine quarantines a body whose state is infinite or NaN at its last pose, which
    /// counts as a fault, too.
    pub(super) fn fault(&self, world: &PhysicsWorld) -> Option<Fault> {
        let mut joints = self.joints(world).flat_map(|(_, joint)| [joint.position, joint.speed]);
        let held = world.quarantine();
        let is_held = |&collider: &ColliderHandle| {
            let parent = world.colliders.get(collider).and_then(Collider::parent);
            parent.is_some_and(|body| self.links.contains(&body))
        };
        let is_finite = joints.all(f64::is_finite)
            && !held.bodies().iter().any(|body| self.links.contains(body))
            && !held.colliders().iter().any(is_held);
        if is_finite { Fault::of(&self.state(world)) } else { Some(Fault::NotFinite) }
    }

    /// Returns the rolling resistance of each wheel in the last step, N.
    pub(super) fn resistances(&self) -> &[Vector3<f64>] {
        &self.resistances
    }
}

impl ValueJoint {
    fn state(&self, world: &PhysicsWorld) -> JointState {
        joint_state(world, self.handle, self.axis)
    }
}

/// Returns position and speed of a joint with one value along an axis.
fn joint_state(world: &PhysicsWorld, handle: MultibodyJointHandle, axis: JointAxis) -> JointState {
    let found = world.multibody_joints.get(handle);
    let Some((multibody, Some(link))) = found.map(|(multibody, link)| (multibody, multibody.link(link))) else {
        return JointState::default();
    };
    let speed = multibody.joint_velocity(link).iter().next().map_or(0.0, |&speed| speed);
    JointState { position: link.joint.coords()[axis as usize], speed }
}

/// Returns the frame that moves with a body and has the body's origin at `origin`. `linear` is the velocity of the body's origin.
fn frame_at(body: &RigidBody, linear: Vector, origin: Vector3<f64>) -> BodyState {
    let pose = convert::from_pose(body.position()) * Translation3::from(-origin);
    let (linear, angular) = (convert::from_vector(linear), convert::from_vector(body.angvel()));
    BodyState { pose, linear: linear - angular.cross(&(pose.rotation * origin)), angular }
}
