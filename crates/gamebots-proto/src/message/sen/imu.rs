//! `{Name n} {XYZAcceleration x,y,z} {AngularVel r,p,y} {AngularAccel r,p,y} {Rotation r,p,y}`, four decimals, truncated
//! (IMU.uc:25-65).

use super::super::float_array;
use super::{ReadWrite, name};
use crate::Line;
use crate::number::fixed_vector;

/// How a sensor is accelerated and turns.
#[derive(Debug, Clone, PartialEq)]
pub struct Imu {
    /// Name of the sensor.
    pub name: String,
    /// Acceleration without gravity along the sensor's x, its y and against its z, m/s².
    pub acceleration: [f32; 3],
    /// Rates of roll, pitch and yaw, rad/s.
    pub angular_velocity: [f32; 3],
    /// Their changes, rad/s².
    pub angular_acceleration: [f32; 3],
    /// Roll, pitch, yaw, rad.
    pub rotation: [f32; 3],
}

impl ReadWrite for Imu {
    const TYPE: &'static str = "IMU";

    fn name(&self) -> Option<&str> {
        Some(&self.name)
    }

    fn write(&self) -> String {
        let vectors = [self.acceleration, self.angular_velocity, self.angular_acceleration, self.rotation];
        let [acceleration, velocity, change, rotation] = vectors.map(|vector| fixed_vector(vector, 4));
        format!(
            "{{Name {}}} {{XYZAcceleration {acceleration}}} {{AngularVel {velocity}}} {{AngularAccel {change}}} \
             {{Rotation {rotation}}}",
            self.name
        )
    }

    fn read(line: &Line) -> Option<Self> {
        Some(Self {
            name: name(line)?,
            acceleration: float_array(line.get("XYZAcceleration")?)?,
            angular_velocity: float_array(line.get("AngularVel")?)?,
            angular_acceleration: float_array(line.get("AngularAccel")?)?,
            rotation: float_array(line.get("Rotation")?)?,
        })
    }
}
