//! Sensors, one file each, with measurement, CONF and the reading on the wire. Their parameters and readings are in the crate `scene`.
//!
//! To add one, write its parameters there and its file here, then add its lines to [`Mounted`], [`mount`] and [`wire`].

mod acceleration;
mod altitude;
mod battery;
mod camera;
mod compass;
mod encoder;
mod ground_truth;
mod imu;
mod ins;
mod mission_time;
mod odometry;
mod range_scanner;
mod sonar;
mod tachometer;
mod touch;

use gamebots_proto::command::Set;
use gamebots_proto::message::{self, ItemConf};
use nalgebra::Point3;
use rand_chacha::ChaCha8Rng;
use scene::sensor::{Config, Reading};
use scene::{JointState, Pose, RobotDef, SensorDef};
use serde::{Deserialize, Serialize};

use crate::PawnId;
use crate::kinds::kinds;
use crate::physics::{Physics, RobotBodies, Sight};
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
        self.physics.sight(origin, max_distance, self.id)
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
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Effect {
    /// No side effect.
    None,
    /// One reading goes out at once.
    Scan,
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
        Altitude(altitude::Mounted),
        Battery(battery::Mounted),
        Camera(camera::Mounted),
        Compass(compass::Mounted),
        Encoder(encoder::Mounted),
        GroundTruth(ground_truth::Mounted),
        Imu(imu::Mounted),
        Ins(ins::Mounted),
        MissionTime(mission_time::Mounted),
        Odometry(odometry::Mounted),
        RangeScanner(range_scanner::Mounted),
        Sonar(sonar::Mounted),
        Tachometer(tachometer::Mounted),
        Touch(touch::Mounted),
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
        Config::RangeScanner(config) | Config::Sick(config) | Config::HokuyoUrg04Lx(config) => {
            Mounted::RangeScanner(range_scanner::build(config, mount))
        }
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

/// Converts a vector for a message.
pub(crate) fn floats(vector: [f64; 3]) -> [f32; 3] {
    vector.map(|component| component as f32)
}
