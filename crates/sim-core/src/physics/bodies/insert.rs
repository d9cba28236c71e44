//! Insertion of a robot into the engine.

use std::sync::Arc;

use nalgebra::{Translation3, Vector3};
use rapier3d::prelude::*;
use scene::{Footing, Pose};

use super::super::convert;
use super::super::identity::Identity;
use super::super::motor::Servo;
use super::compile::Tree;
use super::joint::{Gear, Joint, Role};
use super::{MultibodyRobot, ValueJoint};
use crate::PawnId;

impl MultibodyRobot {
    /// Inserts a robot at a pose of its frame, at rest.
    pub(in super::super) fn insert(world: &mut PhysicsWorld, tree: Arc<Tree>, id: PawnId, pose: &Pose) -> Self {
        let (mut frames, mut links) = (Vec::new(), Vec::new());
        let (mut joints, mut rollers) = (Vec::new(), Vec::new());
        let mut treads = vec![Vec::new(); tree.hubs.len()];
        for (number, link) in (0..).zip(&tree.links) {
            let parent = link.joint.as_ref().map(|joint| joint.parent);
            let frame = parent.map_or(*pose, |parent| frames[parent] * link.pose);
            let origin = if parent.is_none() { frame * Translation3::from(tree.centre) } else { frame };
            let body = match tree.footing {
                Footing::Fixed if parent.is_none() => world.insert_body(fixed_body(&origin, link.mass)),
                Footing::Fixed | Footing::Free => world.insert_body(dynamic_body(&origin, link.mass)),
                Footing::Flying(_) => world.insert_body(dynamic_body(&origin, link.mass).gravity_scale(0.0)),
            };
            let identity = Identity::Link { robot: id, link: number };
            let colliders = link.surfaces.iter().map(|it| world.insert_collider(it.collider(identity), Some(body)));
            let colliders: Vec<ColliderHandle> = colliders.collect();
            if let Some(Joint { parent, joint, role, .. }) = &link.joint {
                let joint = world.multibody_joints.insert(links[*parent], body, *joint, true);
                match (role, joint) {
                    (&Role::Value(axis, ref value), Some(handle)) => {
                        joints.push(ValueJoint { handle, axis, value: value.clone() });
                    }
                    (Role::Roller, handle) => rollers.extend(handle),
                    (Role::Value(..), None) | (Role::Free, _) => {}
                }
            }
            if let Some(wheel) = link.wheel {
                treads[wheel].extend(colliders);
            }
            frames.push(frame);
            links.push(body);
        }
        set_joint_parameters(world, &tree, &links);
        let resistances = vec![Vector3::zeros(); treads.len()];
        let (servos, targets) = (vec![Servo::default(); joints.len()], vec![0.0; joints.len()]);
        Self { tree, links, joints, servos, targets, rollers, treads, resistances }
    }
}

/// Sets self-contacts, damping, armature, friction and couplings. The robot does not collide with itself: the thesis lists 81 disabled
/// pairs, all within one robot, and collision groups could not tell 64 robots apart. Damping is set on every joint, as the engine's default
/// of 0.1 N m s/rad is far too much for a roller.
fn set_joint_parameters(world: &mut PhysicsWorld, tree: &Tree, links: &[RigidBodyHandle]) {
    let ids: Vec<_> = links.iter().map(|&body| world.multibody_joints.rigid_body_link(body).copied()).collect();
    let Some(multibody) = ids[0].and_then(|id| world.multibody_joints.get_multibody_mut(id.multibody)) else {
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

/// Builds a dynamic body that never sleeps. The engine puts bodies to sleep below 0.4 m/s, but a youBot drives at 0.05.
fn dynamic_body(pose: &Pose, mass: MassProperties) -> RigidBodyBuilder {
    RigidBodyBuilder::dynamic().pose(convert::pose(pose)).additional_mass_properties(mass).can_sleep(false)
}

fn fixed_body(pose: &Pose, mass: MassProperties) -> RigidBodyBuilder {
    RigidBodyBuilder::fixed().pose(convert::pose(pose)).additional_mass_properties(mass)
}
