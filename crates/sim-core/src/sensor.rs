//! Sensors: one file each, with its configuration, its measurement, and its CONF.
//!
//! To add one: write its file, then add its line to the list `sensors!` below.

mod battery;
mod camera;
mod encoder;
mod ground_truth;
mod ins;
mod odometry;
mod range_scanner;
mod sonar;
mod tachometer;

pub use range_scanner::Fan;

use gamebots_proto::command::Set;
use gamebots_proto::message::{ItemConf, Reading};
use nalgebra::{Point3, Vector3};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Deserializer, Serialize};

use crate::physics::{Physics, RayHit, RobotBodies};
use crate::scene::{self, Pose, RobotDef, SensorDef};
use crate::{BodyState, WheelState};

/// What a sensor may see. It cannot change the world.
pub(crate) struct View<'a> {
    /// Simulated time, s.
    pub(crate) time: f64,
    /// The body that carries the sensor.
    pub(crate) body: BodyState,
    /// The driven wheels, in order.
    pub(crate) wheels: &'a [WheelState],
    /// The class of the robot.
    pub(crate) robot: &'a RobotDef,
    /// One wheel-speed unit of the wire, rad/s.
    pub(crate) speed_unit: f64,
    pub(crate) physics: &'a Physics,
    pub(crate) bodies: &'a RobotBodies,
}

impl View<'_> {
    /// First hit of a ray from a place in world coordinates.
    pub(crate) fn cast_ray(&self, origin: &Point3<f64>, direction: &Vector3<f64>, max: f64) -> Option<RayHit> {
        self.physics.cast_ray(origin, direction, max, self.bodies)
    }
}

/// What every sensor is given when it is mounted.
pub(crate) struct Mount<'a> {
    /// Name on the wire.
    pub(crate) name: &'a str,
    /// Pose in the robot frame.
    pub(crate) pose: Pose,
    /// Seconds between two readings.
    pub(crate) scan_interval: f64,
    /// Randomness of this sensor alone: a stream named after seed, robot and sensor.
    pub(crate) rng: ChaCha8Rng,
    /// The world at that moment.
    pub(crate) view: &'a View<'a>,
}

/// What a `SET` does beside changing the sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Effect {
    /// Nothing more.
    None,
    /// One reading goes out at once.
    Scan,
}

/// A mounted sensor.
pub(crate) trait Sensor: Send {
    /// The word in `{Type ..}`.
    fn type_name(&self) -> &'static str;
    /// One measurement; `None` for what sends nothing.
    fn sense(&mut self, view: &View) -> Option<Reading>;
    /// Takes an opcode, upper case; unknown ones are ignored, as in USARSim.
    fn set(&mut self, _opcode: &str, _set: &Set, _view: &View) -> Effect {
        Effect::None
    }
    /// Its configuration.
    fn conf(&self) -> ItemConf;
}

macro_rules! sensors {
    ($($(#[$doc:meta])* $class:literal, $interval:literal => $name:ident($config:path),)*) => {
        /// The numbers of a sensor of any class.
        #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
        pub enum Config { $($(#[$doc])* $name($config),)* }

        /// Every class of sensor with its default scan interval, s.
        pub const CLASSES: &[(&str, f64)] = &[$(($class, $interval)),*];

        impl Config {
            /// Reads the settings of a class; `None` for a class that is not in [`CLASSES`].
            pub fn read<'de, D: Deserializer<'de>>(class: &str, settings: D) -> Option<Result<Self, D::Error>> {
                match class {
                    $($class => Some(<$config>::deserialize(settings).map(Self::$name)),)*
                    _ => None,
                }
            }

            fn build(&self, mount: Mount) -> Box<dyn Sensor> {
                match self { $(Self::$name(config) => Box::new(config.build(mount)),)* }
            }
        }
    };
}

/// Mounts a sensor on a robot.
pub(crate) fn mount(def: &SensorDef, rng: ChaCha8Rng, view: &View) -> Box<dyn Sensor> {
    let pose = scene::pose(def.position, def.direction);
    def.config.build(Mount { name: &def.name, pose, scan_interval: def.scan_interval, rng, view })
}

sensors! {
    /// Exact pose of the robot.
    "GroundTruth", 0.1 => GroundTruth(ground_truth::Config),
    /// Inertial navigation that drifts.
    "INS", 0.2 => Ins(ins::Config),
    /// Pose from the wheels.
    "Odometry", 0.1 => Odometry(odometry::Config),
    /// Ticks of wheel encoders.
    "Encoder", 0.1 => Encoder(encoder::Config),
    /// Speeds of the wheels.
    "Tachometer", 0.2 => Tachometer(tachometer::Config),
    /// A coarse laser.
    "RangeScanner", 0.2 => RangeScanner(range_scanner::RangeScanner),
    /// SICK LMS 200.
    "SICK", 0.2 => Sick(range_scanner::Sick),
    /// Hokuyo URG-04LX.
    "HokuyoURG04LX", 0.3 => HokuyoUrg04Lx(range_scanner::HokuyoUrg04Lx),
    /// One ultrasonic cone.
    "Sonar", 0.2 => Sonar(sonar::Config),
    /// A camera's line; pictures are another server's.
    "Camera", 0.1 => Camera(camera::Config),
    /// The battery as an item: it answers GETCONF and sends nothing.
    "Battery", 0.1 => Battery(battery::Config),
}

/// A vector for a message.
pub(crate) fn floats(vector: [f64; 3]) -> [f32; 3] {
    vector.map(|component| component as f32)
}

impl Config {
    /// The beams of a laser; `None` for every other sensor.
    pub fn fan(&self) -> Option<Fan> {
        match self {
            Self::RangeScanner(config) => Some(config.fan()),
            Self::Sick(config) => Some(config.fan()),
            Self::HokuyoUrg04Lx(config) => Some(config.fan()),
            _ => None,
        }
    }

    /// What a laser or a sonar reads where there is nothing, m; `None` for every other sensor.
    pub fn max_range(&self) -> Option<f64> {
        match self {
            Self::Sonar(config) => Some(config.max_range),
            _ => self.fan().map(|fan| fan.max_range),
        }
    }

    /// How many rays one reading casts.
    pub(crate) fn rays(&self) -> usize {
        match self {
            Self::Sonar(config) => config.rays(),
            _ => self.fan().map_or(0, |fan| fan.rays()),
        }
    }

    /// Checks the numbers.
    ///
    /// # Errors
    /// What was expected, in words.
    pub fn validate(&self) -> Result<(), &'static str> {
        match self {
            Self::RangeScanner(config) => config.validate(),
            Self::Sick(config) => config.validate(),
            Self::HokuyoUrg04Lx(config) => config.validate(),
            Self::Sonar(config) => config.validate(),
            Self::Encoder(config) => config.validate(),
            Self::Ins(config) => config.validate(),
            Self::Camera(config) => config.validate(),
            Self::GroundTruth(_) | Self::Odometry(_) | Self::Tachometer(_) | Self::Battery(_) => Ok(()),
        }
    }
}
