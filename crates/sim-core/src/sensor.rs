//! Sensors, one file each, with measurement, CONF and the reading on the wire. Their parameters and readings are in the crate `scene`.
//!
//! To add one, write its parameters there and its file here, then add its lines to [`Mounted`], [`mount`] and [`wire`].

mod acceleration;
mod acoustic;
mod altitude;
mod battery;
mod bumper_array;
mod camera;
mod co2;
mod compass;
mod encoder;
mod gps;
mod ground_truth;
mod hearing;
mod human_motion;
mod imu;
mod infrared;
mod ins;
mod inu;
mod kinect_depth;
mod line_laser;
mod mission_time;
mod object_sensor;
mod odometry;
mod point_cloud;
mod range_scanner;
mod range_scanner_3d;
mod rfid;
mod sonar;
mod sound;
mod tachometer;
mod touch;
mod victim;

use gamebots_proto::command::Set;
use gamebots_proto::message::{self, ItemConf};
use nalgebra::{Point3, Vector3};
use rand_chacha::ChaCha8Rng;
use scene::sensor::{Config, Reading};
use scene::{JointState, Pose, RobotDef, SensorDef};
use serde::{Deserialize, Serialize};

use crate::PawnId;
use crate::kinds::kinds;
use crate::physics::{Light, Physics, RobotBodies, Sight};
use crate::{BodyState, WheelState};

/// The data that a sensor may read. A sensor cannot change the world.
#[derive(Clone, Copy)]
pub(crate) struct View<'a> {
    /// Simulated time, s.
    pub(crate) time: f64,
    /// The robot's body.
    pub(crate) body: BodyState,
    /// The frame that moves with the link that carries the sensor and is the robot frame when every joint is at 0. It maps poses in the
    /// robot frame, such as the sensor's, into the world. For a sensor on the body it is [`View::body`].
    pub(crate) carrier: BodyState,
    /// The driven wheels, in order.
    pub(crate) wheels: &'a [WheelState],
    /// The class of the robot.
    pub(crate) robot: &'a RobotDef,
    pub(crate) bodies: &'a RobotBodies,
    pub(crate) physics: &'a Physics,
    /// The robot's number. Rays do not hit this robot.
    pub(crate) id: PawnId,
}

impl View<'_> {
    /// Returns the view of a sensor on a link, by the link's number.
    pub(crate) fn on_link(self, link: usize) -> Self {
        Self { carrier: self.physics.carrier(self.bodies, link).unwrap_or(self.body), ..self }
    }

    /// Returns the states of the joints that have a value.
    pub(crate) fn joints(&self) -> Vec<JointState> {
        self.physics.joints(self.bodies)
    }

    /// Prepares a query for rays from a point in world coordinates.
    pub(crate) fn sight(&self, origin: &Point3<f64>, max_distance: f64) -> Sight<'_> {
        self.sight_in(Light::Visible, origin, max_distance)
    }

    /// Prepares a query for rays of a kind.
    pub(crate) fn sight_in(&self, light: Light, origin: &Point3<f64>, max_distance: f64) -> Sight<'_> {
        self.physics.sight(light, origin, max_distance, self.id)
    }
}

/// The data that a sensor gets when it is mounted.
pub(crate) struct Mount<'a> {
    /// Name on the wire.
    pub(crate) name: &'a str,
    /// Pose in the robot frame when every joint is at 0.
    pub(crate) pose: Pose,
    /// Seconds between two readings.
    pub(crate) scan_interval: f64,
    /// Random stream of this sensor alone, named after seed, robot and sensor.
    pub(crate) rng: ChaCha8Rng,
    /// The world at the time of mounting.
    pub(crate) view: &'a View<'a>,
}

/// Side effect of a `SET`, beside changing the sensor.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Effect {
    /// No side effect.
    None,
    /// One reading goes out at once.
    Scan,
    /// A change of the world's RFID tags.
    Tag(TagOrder),
}

/// A change of the world's RFID tags.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum TagOrder {
    /// A new tag lies at a position in the world, m.
    Release([f64; 3]),
    /// A text is written to a tag.
    Write {
        /// Number of the tag.
        id: u32,
        /// The text.
        memory: String,
    },
}

/// The part of an item that changes, to be saved or loaded.
#[derive(Default)]
pub(crate) struct State<'a> {
    pub(crate) numbers: Vec<&'a mut f64>,
    pub(crate) flags: Vec<&'a mut bool>,
    pub(crate) random: Option<&'a mut ChaCha8Rng>,
}

/// An item's state as plain data.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct SavedState {
    numbers: Vec<f64>,
    flags: Vec<bool>,
    random: Option<ChaCha8Rng>,
}

impl State<'_> {
    /// Returns the state.
    pub(crate) fn save(self) -> SavedState {
        SavedState {
            numbers: self.numbers.into_iter().map(|number| *number).collect(),
            flags: self.flags.into_iter().map(|flag| *flag).collect(),
            random: self.random.cloned(),
        }
    }

    /// Takes a saved state. Returns false, and changes nothing, if the state is another item's.
    pub(crate) fn load(self, saved: &SavedState) -> bool {
        let Self { numbers, flags, random } = self;
        let fits = numbers.len() == saved.numbers.len()
            && saved.numbers.iter().all(|number| number.is_finite())
            && flags.len() == saved.flags.len()
            && random.is_some() == saved.random.is_some();
        if fits {
            numbers.into_iter().zip(&saved.numbers).for_each(|(own, saved)| *own = *saved);
            flags.into_iter().zip(&saved.flags).for_each(|(own, saved)| *own = *saved);
            random.into_iter().zip(&saved.random).for_each(|(own, saved)| *own = saved.clone());
        }
        fits
    }
}

/// Verbs of a mounted sensor.
pub(crate) trait Sensor {
    /// Returns the word in `{Type ..}`.
    fn type_name(&self) -> &'static str;
    /// Takes one measurement. `None` if the sensor sends nothing.
    fn sense(&mut self, view: &View) -> Option<Reading>;
    /// Executes an opcode, given in upper case. Unknown ones are ignored, as in USARSim.
    fn set(&mut self, _opcode: &str, _set: &Set, _view: &View) -> Effect {
        Effect::None
    }
    /// Returns the part of the sensor that changes; nothing by default.
    fn state(&mut self) -> State<'_> {
        State::default()
    }
    /// Returns its configuration.
    fn conf(&self) -> ItemConf;
}

kinds! {
    /// A mounted sensor of any kind.
    pub(crate) enum Mounted of Sensor {
        Acceleration(acceleration::Mounted),
        Acoustic(acoustic::Mounted),
        Altitude(altitude::Mounted),
        Battery(battery::Mounted),
        BumperArray(bumper_array::Mounted),
        Camera(camera::Mounted),
        Co2(co2::Mounted),
        Compass(compass::Mounted),
        Encoder(encoder::Mounted),
        Gps(gps::Mounted),
        GroundTruth(ground_truth::Mounted),
        HumanMotion(human_motion::Mounted),
        Imu(imu::Mounted),
        Infrared(infrared::Mounted),
        Ins(ins::Mounted),
        Inu(inu::Mounted),
        KinectDepth(kinect_depth::Mounted),
        LineLaser(line_laser::Mounted),
        MissionTime(mission_time::Mounted),
        ObjectSensor(object_sensor::Mounted),
        Odometry(odometry::Mounted),
        PointCloud(point_cloud::Mounted),
        RangeScanner(range_scanner::Mounted),
        RangeScanner3D(range_scanner_3d::Mounted),
        Rfid(rfid::Mounted),
        Sonar(sonar::Mounted),
        Sound(sound::Mounted),
        Tachometer(tachometer::Mounted),
        Touch(touch::Mounted),
        Victim(victim::Mounted),
    }
}

/// Mounts a sensor on a robot.
pub(crate) fn mount(def: &SensorDef, rng: ChaCha8Rng, view: &View) -> Mounted {
    let pose = scene::pose(def.position, def.direction);
    let mount = Mount { name: &def.name, pose, scan_interval: def.scan_interval, rng, view };
    match &def.config {
        Config::GroundTruth(config) => Mounted::GroundTruth(ground_truth::build(config, mount)),
        Config::Ins(config) => Mounted::Ins(ins::build(config, mount)),
        Config::Imu(_) => Mounted::Imu(imu::build(mount)),
        Config::Odometry(config) => Mounted::Odometry(odometry::build(config, mount)),
        Config::Encoder(config) => Mounted::Encoder(encoder::build(config, mount)),
        Config::Tachometer(_) => Mounted::Tachometer(tachometer::build(mount)),
        Config::RangeScanner(config)
        | Config::Sick(config)
        | Config::HokuyoUrg04Lx(config)
        | Config::IrScanner(config) => Mounted::RangeScanner(range_scanner::build(config, mount)),
        Config::RangeScanner3D(config) => Mounted::RangeScanner3D(range_scanner_3d::build(config, mount)),
        Config::KinectDepth(config) => Mounted::KinectDepth(kinect_depth::build(config, mount)),
        Config::LineLaser(config) => Mounted::LineLaser(line_laser::build(config, mount)),
        Config::RotatingPointCloud(config) => Mounted::PointCloud(point_cloud::build_rotating(config, mount)),
        Config::SonarArray(config) => Mounted::PointCloud(point_cloud::build_grid(config, mount)),
        Config::Infrared(config) => Mounted::Infrared(infrared::build(config, mount)),
        Config::BumperArray(config) => Mounted::BumperArray(bumper_array::build(config, mount)),
        Config::Gps(config) => Mounted::Gps(gps::build(config, mount)),
        Config::Acoustic(config) => Mounted::Acoustic(acoustic::build(config, mount)),
        Config::ObjectSensor(config) => Mounted::ObjectSensor(object_sensor::build(config, mount)),
        Config::Rfid(config) => Mounted::Rfid(rfid::build(config, mount)),
        Config::RfidReleaser(_) => Mounted::Rfid(rfid::build_releaser(mount)),
        Config::Victim(config) => Mounted::Victim(victim::build(config, mount)),
        Config::HumanMotion(config) => Mounted::HumanMotion(human_motion::build(config, mount)),
        Config::Sound(config) => Mounted::Sound(sound::build(config, mount)),
        Config::Co2(config) => Mounted::Co2(co2::build(config, mount)),
        Config::Inu(_) => Mounted::Inu(inu::build(mount)),
        Config::Sonar(config) => Mounted::Sonar(sonar::build(config, mount)),
        Config::Touch(config) => Mounted::Touch(touch::build(config, mount)),
        Config::Camera(config) => Mounted::Camera(camera::build(config, mount)),
        Config::Acceleration(_) => Mounted::Acceleration(acceleration::build(false, mount)),
        Config::Accelerometer(_) => Mounted::Acceleration(acceleration::build(true, mount)),
        Config::Altitude(_) => Mounted::Altitude(altitude::build(mount)),
        Config::Compass(_) => Mounted::Compass(compass::build(mount)),
        Config::MissionTime(_) => Mounted::MissionTime(mission_time::build(mount)),
        Config::Battery(_) => Mounted::Battery(battery::build(mount)),
    }
}

/// Returns a reading as the wire says it. `speed_unit` is one wheel-speed unit of the wire, rad/s.
pub(crate) fn wire(robot: &RobotDef, def: &SensorDef, reading: &Reading, speed_unit: f64) -> message::Reading {
    match reading {
        Reading::RangeScanner(reading) if matches!(def.config, Config::IrScanner(_)) => {
            range_scanner::wire_infrared(def, reading).into()
        }
        Reading::PointCloud(reading) if matches!(def.config, Config::SonarArray(_)) => {
            point_cloud::wire_grid(def, reading).into()
        }
        Reading::RangeScanner3D(reading) => range_scanner_3d::wire(def, reading).into(),
        Reading::KinectDepth(reading) => kinect_depth::wire(def, reading).into(),
        Reading::LineLaser(reading) => line_laser::wire(def, reading).into(),
        Reading::PointCloud(reading) => point_cloud::wire(def, reading).into(),
        Reading::Infrared(reading) => infrared::wire(def, reading).into(),
        Reading::BumperArray(reading) => bumper_array::wire(def, reading).into(),
        Reading::Gps(reading) => gps::wire(def, reading).into(),
        Reading::Acoustic(reading) => acoustic::wire(def, reading).into(),
        Reading::ObjectSensor(reading) => object_sensor::wire(def, reading).into(),
        Reading::Rfid(reading) => rfid::wire(def, reading).into(),
        Reading::Victim(reading) => victim::wire(def, reading).into(),
        Reading::HumanMotion(reading) => human_motion::wire(def, reading).into(),
        Reading::Sound(reading) => sound::wire(def, reading).into(),
        Reading::Co2(reading) => co2::wire(def, reading).into(),
        Reading::Inu(reading) => inu::wire(def, reading).into(),
        Reading::GroundTruth(reading) => ground_truth::wire(def, reading).into(),
        Reading::Ins(reading) => ins::wire(def, reading).into(),
        Reading::Imu(reading) => imu::wire(def, reading).into(),
        Reading::Odometry(reading) => odometry::wire(def, reading).into(),
        Reading::Encoder(reading) => encoder::wire(robot, def, reading).into(),
        Reading::Tachometer(reading) => tachometer::wire(def, reading, speed_unit).into(),
        Reading::RangeScanner(reading) => range_scanner::wire(def, reading).into(),
        Reading::Sonar(reading) => sonar::wire(def, reading).into(),
        Reading::Touch(reading) => touch::wire(def, reading).into(),
        Reading::Acceleration(reading) => acceleration::wire(def, reading).into(),
        Reading::Accelerometer(reading) => acceleration::wire_with_gravity(def, reading).into(),
        Reading::Altitude(reading) => altitude::wire(def, reading).into(),
        Reading::Compass(reading) => compass::wire(def, reading).into(),
        Reading::MissionTime(reading) => mission_time::wire(def, reading).into(),
        Reading::Camera(_) => message::Camera {}.into(),
    }
}

/// Returns the direction of a beam in the sensor frame: yaw to the right and pitch up, rad.
fn beam(yaw: f64, pitch: f64) -> Vector3<f64> {
    nalgebra::UnitQuaternion::from_euler_angles(0.0, pitch, yaw) * Vector3::x()
}

/// Converts the coordinates of points for a message.
fn points(coordinates: &[f64]) -> Vec<[f32; 3]> {
    coordinates.as_chunks().0.iter().map(|point| floats(*point)).collect()
}

/// Converts a vector for a message.
pub(crate) fn floats(vector: [f64; 3]) -> [f32; 3] {
    vector.map(|component| component as f32)
}
