//! `SEN`: one reading of one sensor (protocol.md 4.3, 4.4): a header, then the body of its type.

mod camera;
mod encoder;
mod ground_truth;
mod imu;
mod ins;
mod odometry;
mod range_scanner;
mod sonar;
mod tachometer;

pub use camera::Camera;
pub use encoder::Encoder;
pub use ground_truth::GroundTruth;
pub use imu::Imu;
pub use ins::Ins;
pub use odometry::Odometry;
pub use range_scanner::RangeScanner;
pub use sonar::Sonar;
pub use tachometer::Tachometer;

use super::number;
use crate::Line;
use crate::number::engine_float;

/// The body of one type of sensor.
pub trait ReadWrite: Sized {
    /// The word in `{Type ..}`.
    const TYPE: &'static str;
    /// Whether the header has a `{Time ..}`: INS ships without (DefaultUSAR.ini:51).
    const STAMPED: bool = true;
    /// The name of the sensor.
    fn name(&self) -> Option<&str>;
    /// The blocks after the header; empty for a sensor that has nothing to say.
    fn write(&self) -> String;
    /// Reads the blocks of a whole line.
    fn read(line: &Line) -> Option<Self>;
}

/// One reading with its time.
#[derive(Debug, Clone, PartialEq)]
pub struct Sen {
    /// Simulated time, s; `None` for the types that carry none.
    pub time: Option<f32>,
    /// What the sensor measured.
    pub reading: Reading,
    /// The number of the sensor among those of its robot; `None` of a line that was read, which does not say it.
    pub sensor: Option<usize>,
}

macro_rules! readings {
    ($($name:ident,)*) => {
        /// The reading of any sensor.
        #[derive(Debug, Clone, PartialEq)]
        #[expect(missing_docs, reason = "each variant is documented at its type")]
        pub enum Reading { $($name($name),)* }

        impl Reading {
            /// The word in `{Type ..}`.
            pub fn type_name(&self) -> &'static str {
                match self { $(Self::$name(_) => $name::TYPE,)* }
            }

            /// The name of its sensor; of several encoders that of the first, and of a camera none.
            pub fn name(&self) -> Option<&str> {
                match self { $(Self::$name(reading) => reading.name(),)* }
            }

            /// The line's content with the simulated time in seconds, where the type carries it.
            pub fn at(self, time: f32) -> Sen {
                let stamped = match self { $(Self::$name(_) => $name::STAMPED,)* };
                Sen { time: stamped.then_some(time), reading: self, sensor: None }
            }

            fn write(&self) -> String {
                match self { $(Self::$name(reading) => reading.write(),)* }
            }

            fn read(line: &Line) -> Option<Self> {
                let type_name = line.get("Type")?;
                $(if type_name == $name::TYPE {
                    return $name::read(line).map(Self::$name);
                })*
                None
            }
        }

        $(impl From<$name> for Reading {
            fn from(reading: $name) -> Self { Self::$name(reading) }
        })*
    };
}

readings! { GroundTruth, Ins, Imu, Odometry, Encoder, Tachometer, RangeScanner, Sonar, Camera, }

impl Sen {
    /// The same by a sensor with a number among those of its robot.
    pub fn of(self, sensor: usize) -> Self {
        Self { sensor: Some(sensor), ..self }
    }

    /// An empty body still leaves the space before it (Item.uc:43).
    pub(super) fn write(&self) -> String {
        let time = self.time.map(|time| format!(" {{Time {}}}", engine_float(time))).unwrap_or_default();
        format!("SEN{time} {{Type {}}} {}", self.reading.type_name(), self.reading.write())
    }

    pub(super) fn read(line: &Line) -> Option<Self> {
        let time = match line.get("Time") {
            Some(_) => Some(number(line, "Time")?),
            None => None,
        };
        Some(Self { time, reading: Reading::read(line)?, sensor: None })
    }
}

/// The name of the sensor, as every body but the camera's starts with it.
fn name(line: &Line) -> Option<String> {
    line.get("Name").map(str::to_owned)
}
