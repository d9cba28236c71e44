//! A robot in the air: no thrust, but velocities that it simply has (AerialVehicle.uc:47-51, 276-288).

use nalgebra::{UnitQuaternion, Vector3};
use rapier3d::prelude::*;

use super::{Physics, RobotBodies, convert};
use crate::flight::Flight;

/// How fast roll and pitch come to what is asked for, rad/s: 7000 of USARSim's units of 65536 to a turn (AerialVehicle.uc:217-273).
const ATTITUDE_SPEED: f64 = 0.671_115_6;

impl Physics {
    /// Gives a robot the velocities that it is asked for; its root's body has its origin at `centre` in the robot frame. What
    /// stands in its way still stops it in the coming step.
    pub(super) fn fly(&mut self, root: RigidBodyHandle, centre: Vector3<f64>, flight: &Flight) {
        let time_step = self.world.integration_parameters.dt;
        let Some(body) = self.world.bodies.get(root) else { return };
        let attitude = convert::from_pose(body.position()).rotation;
        let (roll, pitch, yaw) = attitude.euler_angles();
        let heading = UnitQuaternion::from_euler_angles(0.0, 0.0, yaw);
        let [forward, right, up] = flight.velocity;
        let linear = heading * Vector3::new(forward, right, -up);
        let toward = |from: f64, to: f64| ((to - from) / time_step).clamp(-ATTITUDE_SPEED, ATTITUDE_SPEED);
        let [to_roll, to_pitch] = flight.attitude;
        // Roll turns about the x axis after yaw and pitch, pitch about y after yaw.
        let leaning = UnitQuaternion::from_euler_angles(0.0, pitch, yaw) * Vector3::x() * toward(roll, to_roll);
        let angular = Vector3::z() * flight.turn + heading * Vector3::y() * toward(pitch, to_pitch) + leaning;
        let linear = linear + angular.cross(&(attitude * centre));
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
