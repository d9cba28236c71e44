//! What a robot in the air is asked to do: no thrust, but velocities that it simply has (AerialVehicle.uc:47-51, 276-288).

use nalgebra::{UnitQuaternion, Vector3};
use scene::Pose;

/// How fast roll and pitch come to what is asked for, rad/s: 7000 of USARSim's units of 65536 to a turn (AerialVehicle.uc:217-273).
const ATTITUDE_SPEED: f64 = 0.671_115_6;

/// Velocities and attitude that an aerial robot keeps until it is asked for others.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Flight {
    /// Forward, to the right and up, m/s, along the robot's heading.
    pub(crate) velocity: [f64; 3],
    /// Turn rate about the vertical, rad/s, clockwise seen from above.
    pub(crate) turn: f64,
    /// Roll and pitch that it takes on, rad.
    pub(crate) attitude: [f64; 2],
}

impl Flight {
    /// The velocity of a point at `centre` in the robot frame and the angular velocity that a robot at a pose has for a step.
    pub(crate) fn velocity(&self, pose: &Pose, centre: Vector3<f64>, time_step: f64) -> (Vector3<f64>, Vector3<f64>) {
        let (roll, pitch, yaw) = pose.rotation.euler_angles();
        let heading = UnitQuaternion::from_euler_angles(0.0, 0.0, yaw);
        let [forward, right, up] = self.velocity;
        let linear = heading * Vector3::new(forward, right, -up);
        let toward = |from: f64, to: f64| ((to - from) / time_step).clamp(-ATTITUDE_SPEED, ATTITUDE_SPEED);
        let [to_roll, to_pitch] = self.attitude;
        // Roll turns about the x axis after yaw and pitch, pitch about y after yaw.
        let leaning = UnitQuaternion::from_euler_angles(0.0, pitch, yaw) * Vector3::x() * toward(roll, to_roll);
        let angular = Vector3::z() * self.turn + heading * Vector3::y() * toward(pitch, to_pitch) + leaning;
        (linear + angular.cross(&(pose.rotation * centre)), angular)
    }
}
