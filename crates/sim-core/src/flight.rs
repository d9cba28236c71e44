//! Targets of a robot in the air. As in USARSim it has no thrust and takes its target velocities at once
//! (AerialVehicle.uc:47-51, 276-288).

use nalgebra::{UnitQuaternion, Vector3};
use scene::{Aerial, Pose};

/// Speed at which roll and pitch approach their targets, rad/s: 7000 of USARSim's units of 65536 to a turn (AerialVehicle.uc:217-273).
const ATTITUDE_SPEED: f64 = 0.671_115_6;

/// Target velocities and attitude of an aerial robot, kept until a command replaces them.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub struct Flight {
    /// Forward, to the right and up, m/s, along the robot's heading.
    pub velocity: [f64; 3],
    /// Turn rate about the vertical, rad/s, clockwise seen from above.
    pub turn: f64,
    /// Target roll and pitch, rad.
    pub attitude: [f64; 2],
}

impl Flight {
    /// Returns the targets within the limits of a class.
    pub(crate) fn within(&self, limits: &Aerial) -> Self {
        let clamp = |value: f64, limit: f64| value.clamp(-limit, limit);
        Self {
            velocity: std::array::from_fn(|axis| clamp(self.velocity[axis], limits.max_velocity[axis])),
            turn: clamp(self.turn, limits.max_turn),
            attitude: self.attitude.map(|angle| clamp(angle, limits.max_tilt)),
        }
    }

    /// Returns the linear and the angular velocity for one step of a robot at a pose. The linear one is that of the point at `centre` in
    /// the robot frame.
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
