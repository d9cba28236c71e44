//! `{Name n} {XYZAcceleration x,y,z} {AngularVel r,p,y} {AngularAccel r,p,y} {Rotation r,p,y}` (IMU.uc:25-65).

use super::Body;
use crate::field::{Field, Format, record};

record! {
    /// Acceleration and rotation of a sensor.
    Imu {
        /// Name of the sensor.
        name: String = Field::new("Name", Format::Word),
        /// Acceleration without gravity along the sensor's x, its y and against its z.
        acceleration: [f32; 3] = Field::new("XYZAcceleration", Format::Fixed(4)).unit("m/s²"),
        /// Rates of roll, pitch and yaw.
        angular_velocity: [f32; 3] = Field::new("AngularVel", Format::Fixed(4)).unit("rad/s"),
        /// Their changes.
        angular_acceleration: [f32; 3] = Field::new("AngularAccel", Format::Fixed(4)).unit("rad/s²"),
        /// Roll, pitch, yaw.
        rotation: [f32; 3] = Field::new("Rotation", Format::Fixed(4)).unit("rad"),
    }
}

impl Body for Imu {
    const TYPE: &'static str = "IMU";
    const TIME: [Format; 2] = [Format::Rounded(4), Format::Fixed(4)];

    fn name(&self) -> Option<&str> {
        Some(&self.name)
    }
}
