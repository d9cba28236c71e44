//! Motors, rolling resistance and flight of a robot in the coming step.

use nalgebra::Vector3;
use rapier3d::prelude::*;
use scene::JointState;

use super::super::convert;
use super::super::motor::{Torque, follow_targets};
use super::super::rolling::Load;
use super::super::surface::Materials;
use super::{Landing, MultibodyRobot, contact};
use crate::flight::Flight;

/// Downward speeds at which a robot without a loaded wheel counts as falling, m/s. A robot put onto a surface comes down with 0.14 m/s. A
/// faster one has fallen off the map and lands nowhere.
const FALLING_SPEEDS: std::ops::Range<f64> = 0.2..20.0;

impl MultibodyRobot {
    /// Applies motors, rolling resistance and flight to the coming step.
    pub(in super::super) fn apply(
        &mut self,
        world: &mut PhysicsWorld,
        materials: &Materials,
        flight: Option<&Flight>,
        landing: &mut Landing,
    ) {
        if let Some(flight) = flight {
            self.fly(world, flight);
        }
        self.reset_forces(world);
        follow_targets(self.joints.iter().map(|joint| &joint.value), &self.targets, &mut self.servos);
        self.set_motors(world);
        self.set_rolling_resistance(world, materials, landing);
    }

    /// Gives a flying robot its velocities. An obstacle still stops it in the coming step.
    fn fly(&self, world: &mut PhysicsWorld, flight: &Flight) {
        let time_step = world.integration_parameters.dt;
        let root = self.links[0];
        let Some(body) = world.bodies.get(root) else { return };
        let (linear, angular) = flight.velocity(&convert::from_pose(body.position()), self.tree.centre, time_step);
        let link = world.multibody_joints.rigid_body_link(root).copied();
        match link.and_then(|link| world.multibody_joints.get_multibody_mut(link.multibody)) {
            Some(multibody) => {
                let mut velocity = multibody.generalized_velocity_mut();
                velocity.iter_mut().zip(linear.iter().chain(&angular)).for_each(|(to, &from)| *to = from);
            }
            None => {
                if let Some(body) = world.bodies.get_mut(root) {
                    body.set_linvel(convert::vector(linear), true);
                    body.set_angvel(convert::vector(angular), true);
                }
            }
        }
    }

    /// Clears the forces of the last step: rolling resistance, and reactions of robots in reduced coordinates.
    fn reset_forces(&self, world: &mut PhysicsWorld) {
        for &handle in &self.links {
            let pushed = |body: &RigidBody| body.user_force() != Vector::ZERO || body.user_torque() != Vector::ZERO;
            if world.bodies.get(handle).is_some_and(pushed)
                && let Some(body) = world.bodies.get_mut(handle)
            {
                body.reset_forces(false);
                body.reset_torques(false);
            }
        }
    }

    fn set_motors(&mut self, world: &mut PhysicsWorld) {
        let time_step = world.integration_parameters.dt;
        for (joint, servo) in self.joints.iter().zip(&mut self.servos) {
            let Some(motor) = &joint.value.motor else { continue };
            let JointState { position, speed } = joint.state(world);
            let Torque { at_rest, gain } = servo.torque(motor, position, speed, time_step);
            if let Some((multibody, link)) = world.multibody_joints.get_mut(joint.handle)
                && let Some(link) = multibody.link_mut(link)
            {
                link.joint.data.set_motor_velocity(joint.axis, at_rest / gain, gain);
            }
        }
    }

    /// Applies rolling resistance to the hubs, and detects a fall. Both follow from the loads.
    fn set_rolling_resistance(&mut self, world: &mut PhysicsWorld, materials: &Materials, landing: &mut Landing) {
        let Self { tree, links, treads, resistances, .. } = self;
        let time_step = world.integration_parameters.dt;
        let fall = convert::from_vector(world.gravity) * time_step;
        let share = tree.mass / treads.len() as f64;
        let loads: Vec<Load> = treads.iter().map(|tread| contact::load(world, materials, tread)).collect();
        let Some(chassis) = world.bodies.get(links[0]) else { return };
        let down = fall.normalize().dot(&convert::from_vector(chassis.linvel()));
        if FALLING_SPEEDS.contains(&down) && loads.iter().all(|load| load.normal == Vector3::zeros()) {
            landing.expect();
        }
        for ((hub, load), resistance) in tree.hubs.iter().zip(&loads).zip(resistances) {
            let Some(carrier) = world.bodies.get_mut(links[hub.carrier]) else { continue };
            let centre = carrier.position() * convert::vector(hub.centre);
            let velocity = convert::from_vector(carrier.velocity_at_point(centre)) + fall;
            let ahead = convert::from_vector(carrier.rotation() * Vector::X);
            // A driven wheel rolls ahead and slides sideways.
            let velocity = if hub.driven.is_some() { ahead * ahead.dot(&velocity) } else { velocity };
            *resistance = load.force(velocity, share, time_step);
            carrier.add_force_at_point(convert::vector(*resistance), centre, true);
        }
    }
}
