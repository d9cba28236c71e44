//! A robot in the air as a body of the engine.

use nalgebra::Vector3;
use rapier3d::prelude::*;

use super::{Physics, RobotBodies, convert};
use crate::flight::Flight;

impl Physics {
    /// Gives a robot the velocities that it is asked for; its root's body has its origin at `centre` in the robot frame. What
    /// stands in its way still stops it in the coming step.
    pub(super) fn fly(&mut self, root: RigidBodyHandle, centre: Vector3<f64>, flight: &Flight) {
        let time_step = self.world.integration_parameters.dt;
        let Some(body) = self.world.bodies.get(root) else { return };
        let (linear, angular) = flight.velocity(&convert::from_pose(body.position()), centre, time_step);
        let link = self.world.multibody_joints.rigid_body_link(root).copied();
        match link.and_then(|link| self.world.multibody_joints.get_multibody_mut(link.multibody)) {
            Some(multibody) => {
                let mut velocity = multibody.generalized_velocity_mut();
                velocity.iter_mut().zip(linear.iter().chain(&angular)).for_each(|(to, &from)| *to = from);
            }
            None => {
                if let Some(body) = self.world.bodies.get_mut(root) {
                    body.set_linvel(convert::vector(linear), true);
                    body.set_angvel(convert::vector(angular), true);
                }
            }
        }
    }
}

impl RobotBodies {
    /// Sets how a robot in the air flies.
    pub(crate) fn set_flight(&mut self, flight: Option<Flight>) {
        self.flight = flight;
    }
}
