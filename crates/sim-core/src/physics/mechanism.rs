//! Robots of either mechanics behind one interface.

use nalgebra::Vector3;
use rapier3d::prelude::*;
use scene::{BodyState, Contact, JointState, Pose};

use super::articulated::ArticulatedRobot;
use super::bodies::{Landing, MultibodyRobot};
use super::compile::CompiledMechanism;
use super::fault::Fault;
use super::pull::{Grasped, Tug};
use super::surface::Materials;
use crate::PawnId;
use crate::flight::Flight;

/// A robot in one of the two mechanics.
#[derive(Clone)]
pub(super) enum Mechanism {
    /// A multibody of the engine.
    Bodies(Box<MultibodyRobot>),
    /// A tree in reduced coordinates.
    Articulated(Box<ArticulatedRobot>),
}

impl Mechanism {
    /// Inserts a robot at a pose of its frame, at rest.
    pub(super) fn insert(world: &mut PhysicsWorld, tree: &CompiledMechanism, id: PawnId, pose: &Pose) -> Self {
        match tree {
            CompiledMechanism::Bodies(tree) => {
                Self::Bodies(Box::new(MultibodyRobot::insert(world, tree.clone(), id, pose)))
            }
            CompiledMechanism::Articulated(tree) => {
                Self::Articulated(Box::new(ArticulatedRobot::spawn(world, tree.clone(), id, pose)))
            }
        }
    }

    /// True if the engine moves it.
    pub(super) fn is_of_engine(&self) -> bool {
        matches!(self, Self::Bodies(_))
    }

    /// Returns the robot in reduced coordinates, if it is one.
    pub(super) fn articulated(&self) -> Option<&ArticulatedRobot> {
        if let Self::Articulated(robot) = self { Some(robot) } else { None }
    }

    /// Returns the robot in reduced coordinates, if it is one.
    pub(super) fn articulated_mut(&mut self) -> Option<&mut ArticulatedRobot> {
        if let Self::Articulated(robot) = self { Some(robot) } else { None }
    }

    /// Returns the engine's body of every link, parents before their children.
    pub(super) fn bodies(&self) -> Vec<RigidBodyHandle> {
        match self {
            Self::Bodies(robot) => robot.bodies().to_vec(),
            Self::Articulated(robot) => robot.bodies().collect(),
        }
    }

    /// Sets the targets of the wheels' servos, rad/s.
    pub(super) fn set_wheel_speeds(&mut self, speeds: &[f64]) {
        match self {
            Self::Bodies(robot) => robot.set_wheel_speeds(speeds),
            Self::Articulated(robot) => robot.set_wheel_speeds(speeds),
        }
    }

    /// Sets the target of a joint, by its number among the joints that have a value.
    pub(super) fn set_joint_target(&mut self, joint: usize, target: f64) {
        match self {
            Self::Bodies(robot) => robot.set_joint_target(joint, target),
            Self::Articulated(robot) => robot.set_joint_target(joint, target),
        }
    }

    /// Applies motors, rolling resistance and flight to the coming step of the engine. Does nothing for robots in reduced coordinates:
    /// their own solver applies these.
    pub(super) fn apply(
        &mut self,
        world: &mut PhysicsWorld,
        materials: &Materials,
        flight: Option<&Flight>,
        landing: &mut Landing,
    ) {
        if let Self::Bodies(robot) = self {
            robot.apply(world, materials, flight, landing);
        }
    }

    /// Returns what a spring pulls.
    pub(super) fn grasped(&self, world: &PhysicsWorld) -> Grasped {
        match self {
            Self::Bodies(robot) => robot.grasped(world),
            Self::Articulated(robot) => robot.grasped(),
        }
    }

    /// Applies the effect of a spring to the body for the coming step, after the motors.
    pub(super) fn pull(&mut self, world: &mut PhysicsWorld, tug: &Tug) {
        match self {
            Self::Bodies(robot) => robot.pull(world, tug),
            Self::Articulated(robot) => robot.pull(tug),
        }
    }

    /// Returns every joint that has a value, in the order of the links. The flag is true for wheels.
    pub(super) fn joints(&self, world: &PhysicsWorld) -> Vec<(bool, JointState)> {
        match self {
            Self::Bodies(robot) => robot.joints(world).collect(),
            Self::Articulated(robot) => robot.joints().collect(),
        }
    }

    /// Returns pose and velocity of the robot frame.
    pub(super) fn state(&self, world: &PhysicsWorld) -> BodyState {
        match self {
            Self::Bodies(robot) => robot.state(world),
            Self::Articulated(robot) => robot.state(),
        }
    }

    /// Returns the robot frame as it moves with a link of the definition. `origin` is the link's origin in the robot frame when every joint
    /// is at 0.
    pub(super) fn carrier(&self, world: &PhysicsWorld, link: usize, origin: Vector3<f64>) -> Option<BodyState> {
        match self {
            Self::Bodies(robot) => robot.carrier(world, link, origin),
            Self::Articulated(robot) => robot.carrier(link, origin),
        }
    }

    /// Returns the fault of the state, if it has one.
    pub(super) fn fault(&self, world: &PhysicsWorld) -> Option<Fault> {
        match self {
            Self::Bodies(robot) => robot.fault(world),
            Self::Articulated(robot) => robot.fault(),
        }
    }

    /// Returns the state as numbers. They are empty for a robot of the engine, whose bodies hold its state.
    pub(super) fn numbers(&self) -> Vec<f64> {
        self.articulated().map_or_else(Vec::new, ArticulatedRobot::numbers)
    }

    /// Returns the angles of the rollers about their own axes, wheel by wheel, rad.
    pub(super) fn roller_angles(&self, world: &PhysicsWorld) -> Vec<f64> {
        match self {
            Self::Bodies(robot) => robot.roller_angles(world),
            Self::Articulated(robot) => robot.roller_angles(),
        }
    }

    /// Returns the contacts of the last step.
    pub(super) fn contacts(&self, world: &PhysicsWorld) -> Vec<Contact> {
        match self {
            Self::Bodies(robot) => robot.contacts(world),
            Self::Articulated(robot) => robot.contacts().to_vec(),
        }
    }

    /// Returns the ground forces on each wheel in the last step that are not in a contact, N.
    pub(super) fn resistances(&self) -> &[Vector3<f64>] {
        match self {
            Self::Bodies(robot) => robot.resistances(),
            Self::Articulated(robot) => robot.resistances(),
        }
    }
}
