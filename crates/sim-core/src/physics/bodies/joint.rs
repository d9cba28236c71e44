//! Joints of a tree in the engine's terms.

use nalgebra::Vector3;
use rapier3d::prelude::*;
use scene::JointKind;

use super::super::convert;
use super::super::motor::Value;

/// A joint to the parent.
pub(super) struct Joint {
    pub(super) parent: usize,
    pub(super) joint: GenericJoint,
    /// Damping of each degree of freedom, N m s/rad.
    pub(super) damping: f64,
    /// Dry friction of each degree of freedom, N m or N.
    pub(super) friction: f64,
    /// Inertia of the motor's rotor at the joint, kg m².
    pub(super) armature: f64,
    pub(super) role: Role,
}

/// The purpose of a joint.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Role {
    /// A value in the robot's state, along the engine's axis.
    Value(JointAxis, Value),
    /// The axle of a roller.
    Roller,
    /// A joint without a value: fixed or ball.
    Free,
}

/// A joint coupled to another. Each is given by its link's number and its axis.
pub(super) struct Gear {
    pub(super) leader: (usize, JointAxis),
    pub(super) follower: (usize, JointAxis),
    pub(super) multiplier: f64,
    /// rad or m.
    pub(super) offset: f64,
}

impl Joint {
    /// Compiles a joint of a definition. `anchor` is in the frame of the parent's body.
    pub(super) fn new(def: &scene::Joint, parent: usize, anchor: Vector3<f64>, is_wheel: bool) -> Self {
        Self {
            parent,
            joint: engine_joint(def, anchor),
            damping: def.damping,
            friction: def.friction,
            armature: def.drive.as_ref().map_or(0.0, |motor| motor.armature),
            role: axis_of(def.kind).map_or(Role::Free, |axis| Role::Value(axis, Value::new(def, is_wheel))),
        }
    }
}

/// Builds the engine's joint at an anchor in the frame of the parent's body. The child's anchor is its origin.
fn engine_joint(joint: &scene::Joint, anchor: Vector3<f64>) -> GenericJoint {
    let (anchor, axis) = (convert::vector(anchor), convert::vector(joint.axis));
    let mut built: GenericJoint = match joint.kind {
        // No robot with a belt is compiled for the engine.
        JointKind::Fixed | JointKind::Belt => FixedJointBuilder::new().local_anchor1(anchor).into(),
        JointKind::Ball => SphericalJointBuilder::new().local_anchor1(anchor).into(),
        JointKind::Revolute | JointKind::Continuous => RevoluteJointBuilder::new(axis).local_anchor1(anchor).into(),
        JointKind::Prismatic => PrismaticJointBuilder::new(axis).local_anchor1(anchor).into(),
    };
    let Some(axis) = axis_of(joint.kind) else { return built };
    if let Some(limits) = joint.limits {
        built.set_limits(axis, limits);
    }
    if let Some(motor) = &joint.drive {
        built.set_motor_velocity(axis, 0.0, motor.gain);
        built.set_motor_max_force(axis, motor.max_torque);
        built.set_motor_model(axis, MotorModel::ForceBased);
    }
    built
}

/// Returns the engine's axis of a joint with one value. The engine's x axis is the joint's axis.
pub(super) fn axis_of(kind: JointKind) -> Option<JointAxis> {
    match kind {
        JointKind::Revolute | JointKind::Continuous => Some(JointAxis::AngX),
        JointKind::Prismatic => Some(JointAxis::LinX),
        JointKind::Fixed | JointKind::Ball | JointKind::Belt => None,
    }
}
