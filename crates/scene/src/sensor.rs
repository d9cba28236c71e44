//! Sensors: one file each with its settings, their limits and its reading.
//!
//! To add one: write its file, add its lines to the lists `sensors!` and `readings!` below, and add its measurement to `sim-core`.

#![expect(clippy::approx_constant, reason = "the numbers are those of USARSim's files")]

pub mod acceleration;
pub mod accelerometer;
pub mod acoustic;
pub mod altitude;
pub mod battery;
pub mod bumper_array;
pub mod camera;
pub mod co2;
pub mod compass;
pub mod encoder;
pub mod gps;
pub mod ground_truth;
pub mod human_motion;
pub mod imu;
pub mod infrared;
pub mod ins;
pub mod inu;
pub mod kinect_depth;
pub mod line_laser;
pub mod mission_time;
pub mod object_sensor;
pub mod odometry;
pub mod point_cloud;
pub mod range_scanner;
pub mod range_scanner_3d;
pub mod rfid;
pub mod sonar;
pub mod sound;
pub mod tachometer;
pub mod touch;
pub mod victim;

use serde::{Deserialize, Deserializer, Serialize};

pub use range_scanner::{Fan, RangeScanner};

use crate::reading::Quantity;

/// A sensor on a robot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SensorDef {
    /// Name on the wire.
    pub name: String,
    /// Number of the link that carries it.
    #[serde(default)]
    pub link: usize,
    /// Position in the robot frame when every joint is at 0, m.
    pub position: [f64; 3],
    /// Roll, pitch, yaw there, rad.
    pub direction: [f64; 3],
    /// Seconds between two readings; 0 for none.
    pub scan_interval: f64,
    /// Class and settings.
    pub config: Config,
}

macro_rules! sensors {
    ($($(#[doc = $about:literal])* $class:literal, $interval:literal => $name:ident($config:path), $read:expr;)*) => {
        /// Settings of a sensor of any class.
        #[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
        pub enum Config { $($(#[doc = $about])* $name($config),)* }

        /// Every class of sensor with its default scan interval, s.
        pub const CLASSES: &[(&str, f64)] = &[$(($class, $interval)),*];

        /// The meaning of each class, in the same order.
        pub const ABOUT: &[&str] = &[$(concat!($($about,)*)),*];

        impl Config {
            /// Returns the name of the class.
            pub fn class(&self) -> &'static str {
                match self { $(Self::$name(_) => $class,)* }
            }

            /// Reads the settings of a class; `None` for a class that is not in [`CLASSES`].
            pub fn read<'de, D: Deserializer<'de>>(class: &str, settings: D) -> Option<Result<Self, D::Error>> {
                match class {
                    $($class => Some($read(settings).map(Self::$name)),)*
                    _ => None,
                }
            }
        }
    };
}

sensors! {
    /// Exact pose of the robot.
    "GroundTruth", 0.1 => GroundTruth(ground_truth::Config), Deserialize::deserialize;
    /// Inertial navigation that drifts.
    "INS", 0.2 => Ins(ins::Config), Deserialize::deserialize;
    /// Accelerations and turn rates.
    "IMU", 0.1 => Imu(imu::Config), Deserialize::deserialize;
    /// Pose from the wheels.
    "Odometry", 0.1 => Odometry(odometry::Config), Deserialize::deserialize;
    /// Ticks of wheel encoders.
    "Encoder", 0.1 => Encoder(encoder::Config), Deserialize::deserialize;
    /// Speeds of the wheels.
    "Tachometer", 0.2 => Tachometer(tachometer::Config), Deserialize::deserialize;
    /// A coarse laser.
    "RangeScanner", 0.2 => RangeScanner(RangeScanner), |settings| range_scanner::PLAIN.changed(settings);
    /// SICK LMS 200.
    "SICK", 0.2 => Sick(RangeScanner), |settings| range_scanner::SICK.changed(settings);
    /// Hokuyo URG-04LX.
    "HokuyoURG04LX", 0.3 => HokuyoUrg04Lx(RangeScanner), |settings| range_scanner::HOKUYO_URG_04LX.changed(settings);
    /// A fan of infrared beams, which pass through glass.
    "IRScanner", 0.1 => IrScanner(RangeScanner), |settings| range_scanner::INFRARED.changed(settings);
    /// Rows of laser beams, of UT2004.
    "RangeScanner3D", 0.2 => RangeScanner3D(range_scanner_3d::Config), Deserialize::deserialize;
    /// A Kinect's depth picture.
    "KinectDepth", 0.1 => KinectDepth(kinect_depth::Config), Deserialize::deserialize;
    /// Points of a line of light.
    "LineLaser", 0.1 => LineLaser(line_laser::Config), Deserialize::deserialize;
    /// Points of a nodding fan of beams.
    "RotatingPointCloudScanner", 0.2 => RotatingPointCloud(point_cloud::Rotating), Deserialize::deserialize;
    /// Points of a grid of parallel sonars.
    "ExampleSonarArray", 0.2 => SonarArray(point_cloud::Grid), Deserialize::deserialize;
    /// One infrared beam, which passes through glass.
    "IRSensor", 0.1 => Infrared(infrared::Config), Deserialize::deserialize;
    /// A bow of bumpers.
    "BumperArray", 0.1 => BumperArray(bumper_array::Config), Deserialize::deserialize;
    /// Latitude and longitude from satellites.
    "GPSSensor", 0.2 => Gps(gps::Config), Deserialize::deserialize;
    /// Directions of sounds.
    "AcousticArraySensor", 1.0 => Acoustic(acoustic::Config), Deserialize::deserialize;
    /// Names and places of objects in view.
    "ObjectSensor", 0.5 => ObjectSensor(object_sensor::Config), Deserialize::deserialize;
    /// A reader of RFID tags, of UT2004.
    "RFIDSensor", 0.2 => Rfid(rfid::Config), Deserialize::deserialize;
    /// A releaser of RFID tags, of UT2004: it sends nothing.
    "RFIDReleaser", 0.0 => RfidReleaser(rfid::Releaser), Deserialize::deserialize;
    /// Parts of victims in view, of UT2004.
    "VictSensor", 0.2 => Victim(victim::Config), Deserialize::deserialize;
    /// Motion of victims in view, of UT2004.
    "HumanMotionSensor", 0.2 => HumanMotion(human_motion::Config), Deserialize::deserialize;
    /// The loudest sound, of UT2004.
    "SoundSensor", 0.2 => Sound(sound::Config), Deserialize::deserialize;
    /// Density of CO2, of UT2004.
    "CO2Sensor", 0.2 => Co2(co2::Config), Deserialize::deserialize;
    /// Roll, pitch and yaw, of UT2004.
    "INUSensor", 0.2 => Inu(inu::Config), Deserialize::deserialize;
    /// One ultrasonic cone.
    "Sonar", 0.2 => Sonar(sonar::Config), Deserialize::deserialize;
    /// A face that feels what is in front of it.
    "Touch", 0.1 => Touch(touch::Config), Deserialize::deserialize;
    /// Status line of a camera; another server sends its pictures.
    "Camera", 0.1 => Camera(camera::Config), Deserialize::deserialize;
    /// Acceleration without gravity.
    "Acceleration", 0.1 => Acceleration(acceleration::Config), Deserialize::deserialize;
    /// Acceleration with gravity.
    "Accelerometer", 0.1 => Accelerometer(accelerometer::Config), Deserialize::deserialize;
    /// Height above the place of the spawn.
    "AltitudeSensor", 0.1 => Altitude(altitude::Config), Deserialize::deserialize;
    /// Direction against north.
    "MagneticCompass", 0.1 => Compass(compass::Config), Deserialize::deserialize;
    /// Minutes since the spawn.
    "MissionTime", 0.1 => MissionTime(mission_time::Config), Deserialize::deserialize;
    /// Battery listed as a sensor: it answers GETCONF and sends nothing.
    "Battery", 0.1 => Battery(battery::Config), Deserialize::deserialize;
}

macro_rules! readings {
    ($($word:literal => $name:ident($file:ident),)*) => {
        /// The reading of a sensor of any type.
        #[derive(Debug, Clone, PartialEq)]
        #[expect(missing_docs, reason = "each variant is documented at its type")]
        pub enum Reading { $($name($file::Reading),)* }

        $(impl From<$file::Reading> for Reading {
            fn from(reading: $file::Reading) -> Self { Self::$name(reading) }
        })*

        impl Reading {
            /// Returns the word for its type on the wire, in `{Type ..}`.
            pub fn type_name(&self) -> &'static str {
                match self { $(Self::$name(_) => $word,)* }
            }

            /// Returns its quantities by name, for logs and viewers.
            pub fn quantities(&self) -> Vec<Quantity> {
                match self { $(Self::$name(reading) => reading.quantities(),)* }
            }

            /// Returns the bytes of memory that it takes beside itself.
            pub fn held(&self) -> usize {
                match self { $(Self::$name(reading) => reading.held(),)* }
            }

            /// Restores a reading from its type and quantities. `None` if a quantity is missing or the type is unknown.
            pub fn read<'a>(type_name: &str, find: &dyn Fn(&str) -> Option<&'a [f64]>) -> Option<Self> {
                match type_name {
                    $($word => $file::Reading::read(find).map(Self::$name),)*
                    _ => None,
                }
            }
        }
    };
}

readings! {
    "GroundTruth" => GroundTruth(ground_truth),
    "INS" => Ins(ins),
    "IMU" => Imu(imu),
    "Odometry" => Odometry(odometry),
    "Encoder" => Encoder(encoder),
    "Tachometer" => Tachometer(tachometer),
    "RangeScanner" => RangeScanner(range_scanner),
    "Sonar" => Sonar(sonar),
    "Touch" => Touch(touch),
    "Camera" => Camera(camera),
    "Accel" => Acceleration(acceleration),
    "AcceleroMeter" => Accelerometer(accelerometer),
    "AltitudeSensor" => Altitude(altitude),
    "MagneticCompass" => Compass(compass),
    "MissionTime" => MissionTime(mission_time),
    "IR" => Infrared(infrared),
    "RangeScanner3D" => RangeScanner3D(range_scanner_3d),
    "RangeImager" => KinectDepth(kinect_depth),
    "LineLaser" => LineLaser(line_laser),
    "PCL" => PointCloud(point_cloud),
    "TouchArray" => BumperArray(bumper_array),
    "GPS" => Gps(gps),
    "Acoustic" => Acoustic(acoustic),
    "ObjectSensor" => ObjectSensor(object_sensor),
    "RFID" => Rfid(rfid),
    "VictSensor" => Victim(victim),
    "HumanMotion" => HumanMotion(human_motion),
    "Sound" => Sound(sound),
    "CO2Sensor" => Co2(co2),
    "INU" => Inu(inu),
}

impl Reading {
    /// Returns the distances that a viewer draws as beams, m: those of a laser or a sonar.
    pub fn ranges(&self) -> Option<&[f64]> {
        match self {
            Self::RangeScanner(scan) => Some(&scan.ranges),
            Self::Sonar(sonar) => Some(std::slice::from_ref(&sonar.range)),
            Self::GroundTruth(_)
            | Self::Ins(_)
            | Self::Imu(_)
            | Self::Odometry(_)
            | Self::Encoder(_)
            | Self::Tachometer(_)
            | Self::Touch(_)
            | Self::Camera(_)
            | Self::Acceleration(_)
            | Self::Accelerometer(_)
            | Self::Altitude(_)
            | Self::Compass(_)
            | Self::MissionTime(_)
            | Self::Infrared(_)
            | Self::RangeScanner3D(_)
            | Self::KinectDepth(_)
            | Self::LineLaser(_)
            | Self::PointCloud(_)
            | Self::BumperArray(_)
            | Self::Gps(_)
            | Self::Acoustic(_)
            | Self::ObjectSensor(_)
            | Self::Rfid(_)
            | Self::Victim(_)
            | Self::HumanMotion(_)
            | Self::Sound(_)
            | Self::Co2(_)
            | Self::Inu(_) => None,
        }
    }
}

/// Maximum number of beams of one sensor.
const MAX_BEAMS: usize = 10_000;

/// Checks the ranges of a sensor that measures distances.
fn ranges(least: f64, most: f64) -> Result<(), &'static str> {
    let good = 0.0 <= least && least < most && most <= 10_000.0;
    if good { Ok(()) } else { Err("min_range < max_range, both 0 to 10000 m") }
}

impl Config {
    /// Returns the beams of a laser, or `None` for every other sensor.
    pub fn fan(&self) -> Option<Fan> {
        self.laser().map(RangeScanner::fan)
    }

    /// Returns the settings of a laser, or `None` for every other sensor.
    pub fn laser(&self) -> Option<&RangeScanner> {
        match self {
            Self::RangeScanner(config) | Self::Sick(config) | Self::HokuyoUrg04Lx(config) | Self::IrScanner(config) => {
                Some(config)
            }
            _ => None,
        }
    }

    /// Returns the reading of a laser or a sonar without a hit, m, or `None` for every other sensor.
    pub fn max_range(&self) -> Option<f64> {
        if let Self::Sonar(config) = self { Some(config.max_range) } else { self.fan().map(|fan| fan.max_range) }
    }

    /// True for a camera.
    pub fn is_camera(&self) -> bool {
        matches!(self, Self::Camera(_))
    }

    /// Returns the number of rays that one reading casts. Those to victims and sounds are not counted: the map bounds them.
    pub fn rays(&self) -> usize {
        match self {
            Self::Sonar(config) => config.rays(),
            Self::Touch(_) => 7,
            Self::Infrared(_) => 1,
            Self::RangeScanner3D(config) => config.counts().iter().product(),
            Self::KinectDepth(_) => kinect_depth::Config::rays(),
            Self::LineLaser(config) => config.beams as usize,
            Self::RotatingPointCloud(config) => config.beams as usize,
            Self::SonarArray(config) => (config.size * config.size) as usize,
            Self::BumperArray(_) => 140,
            Self::ObjectSensor(config) => config.rays(),
            Self::Gps(_) => 24,
            Self::RangeScanner(config) | Self::Sick(config) | Self::HokuyoUrg04Lx(config) | Self::IrScanner(config) => {
                config.fan().rays()
            }
            Self::GroundTruth(_)
            | Self::Ins(_)
            | Self::Imu(_)
            | Self::Odometry(_)
            | Self::Encoder(_)
            | Self::Tachometer(_)
            | Self::Acoustic(_)
            | Self::Rfid(_)
            | Self::RfidReleaser(_)
            | Self::Victim(_)
            | Self::HumanMotion(_)
            | Self::Sound(_)
            | Self::Co2(_)
            | Self::Inu(_)
            | Self::Camera(_)
            | Self::Acceleration(_)
            | Self::Accelerometer(_)
            | Self::Altitude(_)
            | Self::Compass(_)
            | Self::MissionTime(_)
            | Self::Battery(_) => 0,
        }
    }

    /// Checks the numbers.
    ///
    /// # Errors
    /// Describes the expected numbers.
    pub fn validate(&self) -> Result<(), &'static str> {
        match self {
            Self::Sonar(config) => config.validate(),
            Self::Encoder(config) => config.validate(),
            Self::Ins(config) => config.validate(),
            Self::Camera(config) => config.validate(),
            Self::Touch(config) => config.validate(),
            Self::Infrared(config) => config.validate(),
            Self::RangeScanner3D(config) => config.validate(),
            Self::KinectDepth(config) => config.validate(),
            Self::LineLaser(config) => config.validate(),
            Self::RotatingPointCloud(config) => config.validate(),
            Self::SonarArray(config) => config.validate(),
            Self::BumperArray(config) => config.validate(),
            Self::Gps(config) => config.validate(),
            Self::Acoustic(config) | Self::Sound(config) => config.validate(),
            Self::ObjectSensor(config) => config.validate(),
            Self::Rfid(config) => config.validate(),
            Self::Victim(config) | Self::HumanMotion(config) => config.validate(),
            Self::Co2(config) => config.validate(),
            Self::RangeScanner(config) | Self::Sick(config) | Self::HokuyoUrg04Lx(config) | Self::IrScanner(config) => {
                config.validate()
            }
            // They have no numbers.
            Self::GroundTruth(_)
            | Self::Imu(_)
            | Self::Odometry(_)
            | Self::Tachometer(_)
            | Self::RfidReleaser(_)
            | Self::Inu(_)
            | Self::Acceleration(_)
            | Self::Accelerometer(_)
            | Self::Altitude(_)
            | Self::Compass(_)
            | Self::MissionTime(_)
            | Self::Battery(_) => Ok(()),
        }
    }
}
