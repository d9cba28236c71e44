//! Sensors: one file each, with its measurement and its CONF. Their numbers are in the crate `scene`.
//!
//! To add one: write its numbers there and its file here, then add its line to [`mount`].

mod battery;
mod camera;
mod encoder;
mod ground_truth;
mod imu;
mod ins;
mod odometry;
mod range_scanner;
mod sonar;
mod tachometer;

use gamebots_proto::command::Set;
use gamebots_proto::message::{ItemConf, Reading};
use nalgebra::Point3;
use rand_chacha::ChaCha8Rng;
use scene::sensor::Config;
use scene::{Pose, RobotDef, SensorDef};

use crate::RobotId;
use crate::physics::{Physics, RobotBodies, Sight};
use crate::{BodyState, WheelState};

/// What a sensor may see. It cannot change the world.
#[derive(Clone, Copy)]
pub(crate) struct View<'a> {
    /// Simulated time, s.
    pub(crate) time: f64,
    /// The robot's body.
    pub(crate) body: BodyState,
    /// The robot frame as it moves with the link that carries the sensor, when every joint was at 0: a pose that stands there stands
    /// in the world by this. Of the body it is [`View::body`].
    pub(crate) carrier: BodyState,
    /// The driven wheels, in order.
    pub(crate) wheels: &'a [WheelState],
    /// The class of the robot.
    pub(crate) robot: &'a RobotDef,
    /// One wheel-speed unit of the wire, rad/s.
    pub(crate) speed_unit: f64,
    pub(crate) physics: &'a Physics,
    /// The robot itself, which no ray meets.
    pub(crate) id: RobotId,
}

impl View<'_> {
    /// What a sensor on a link sees, by the link's number.
    pub(crate) fn on_link(self, bodies: &RobotBodies, link: usize) -> Self {
        Self { carrier: self.physics.carrier(bodies, link).unwrap_or(self.body), ..self }
    }

    /// What rays from a place in world coordinates can meet.
    pub(crate) fn sight(&self, origin: &Point3<f64>, max_distance: f64) -> Sight<'_> {
        self.physics.sight(origin, max_distance, self.id)
    }
}

/// What every sensor is given when it is mounted.
pub(crate) struct Mount<'a> {
    /// Name on the wire.
    pub(crate) name: &'a str,
    /// Pose in the robot frame when every joint is at 0.
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

/// Mounts a sensor on a robot.
pub(crate) fn mount(def: &SensorDef, rng: ChaCha8Rng, view: &View) -> Box<dyn Sensor> {
    let pose = scene::pose(def.position, def.direction);
    let mount = Mount { name: &def.name, pose, scan_interval: def.scan_interval, rng, view };
    match &def.config {
        Config::GroundTruth(config) => Box::new(ground_truth::build(config, mount)),
        Config::Ins(config) => Box::new(ins::build(config, mount)),
        Config::Imu(_) => Box::new(imu::build(mount)),
        Config::Odometry(config) => Box::new(odometry::build(config, mount)),
        Config::Encoder(config) => Box::new(encoder::build(config, mount)),
        Config::Tachometer(_) => Box::new(tachometer::build(mount)),
        Config::RangeScanner(config) | Config::Sick(config) | Config::HokuyoUrg04Lx(config) => {
            Box::new(range_scanner::build(config, mount))
        }
        Config::Sonar(config) => Box::new(sonar::build(config, mount)),
        Config::Camera(config) => Box::new(camera::build(config, mount)),
        Config::Battery(_) => Box::new(battery::build(mount)),
    }
}

/// A vector for a message.
pub(crate) fn floats(vector: [f64; 3]) -> [f32; 3] {
    vector.map(|component| component as f32)
}
