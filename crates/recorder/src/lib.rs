//! The log of a run: every line in and out, and the states of robots and objects, in an MCAP file.
//!
//! Simulated time is log time. Messages are protobuf: [`native`] has the channels, and `proto/usarsim.proto` our own messages.
//! Foxglove's messages stand beside them, so that a log opens as a moving scene. The metadata `run` holds the scene with every
//! number in effect, seed and time step; the metadata `class/<name>` hold the classes that were used. The metadata `end` holds
//! the digest of the world. [`ros2`] writes the run as messages of ROS 2 to a separate file.
//!
//! [`Live`] streams the messages to viewers. For a live world, a separate thread writes the file, so that a slow disk does not
//! hold up the world. Records reach the file at least once a second. So a killed process leaves a file that can be read up to
//! there.

pub mod bag;
mod classes;
mod drawing;
mod error;
pub mod export;
mod file;
mod live;
mod messages;
pub mod native;
mod reader;
mod records;
mod recover;
pub mod ros2;
mod slots;
mod states;
mod table;
mod writer;

pub use error::RecordError;
pub use file::{Storage, storage};
pub use live::{Admitted, Latched, Live};
pub use messages::{
    LeagueScore, LeagueStandings, ObjectRemoved, ObjectSpawned, ObjectState, PictureTaken, Quantity, Quaternion,
    RobotLeft, RobotState, SensorReading, Vector, WireLine,
};
pub use reader::{Entry, Log, ReadError, read, scene};
pub use recover::{RecoverError, Recovered, recover};
pub use states::{STATE_INTERVAL, StateTimer};
pub use table::{Column, Table};
pub use writer::{Closing, LogWriter, Recorder, Sink, ros2_path};

use foxglove::Encode;
use mcap::McapResult;
use scene::{MapDef, Score, Sensed, Standings};

/// The newest format of logs, which is written; older ones are read, too. In format 1, which logs do not name, robots are
/// bodies with wheels. In format 2, robots are trees of links. In format 3, classes have metadata of their own.
const FORMAT: u32 = 3;
/// Name of the metadata that describes a run.
const RUN: &str = "run";
/// Name of the metadata that ends a log.
const END: &str = "end";
/// Topic of robots that leave.
const LEFT: &str = "/robots/left";
/// Topics of objects that the map does not have, and of those that leave.
const OBJECTS: [&str; 2] = ["/objects/spawned", "/objects/removed"];
/// Topics of a league.
const LEAGUE: [&str; 2] = ["/league/score", "/league/standings"];

/// The end of a world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct End {
    /// Simulated time, s.
    pub time: f64,
    /// A number that two worlds share only if every body has the same bits; none if the world panicked.
    pub digest: Option<u64>,
    /// Steps of robots whose contacts did not converge.
    pub unsettled_steps: u64,
    /// Records that are missing in the log; its writer counts them.
    pub dropped: u64,
}

/// A destination of messages.
pub(crate) trait Publish {
    /// Publishes a message at a simulated time, s. The channel is created on its first use.
    fn publish<T: Encode>(&mut self, time: f64, topic: &str, message: &T) -> McapResult<()>;

    /// Forgets the last messages on topics with this prefix, because they are no longer true.
    fn forget(&mut self, _topics: &str) {}
}

/// A thing to record.
#[derive(Debug, Clone, PartialEq)]
pub enum Record {
    /// A received line.
    In(WireLine),
    /// A sent line.
    Out(WireLine),
    /// A reading of a robot's sensor.
    Sensed(Sensed),
    /// A connection that ended, without a robot or a line.
    Closed(WireLine),
    /// The number of a robot that left the world, with its connection or alone.
    Left(u64),
    /// State of a robot.
    State(RobotState),
    /// State of an object that has moved.
    Object(ObjectState),
    /// An object that the map does not have.
    ObjectSpawned(ObjectSpawned),
    /// An object that left the world.
    ObjectRemoved(ObjectRemoved),
    /// A picture of a robot's camera and its PNG file, which is not read back.
    Picture(PictureTaken, Vec<u8>),
    /// A change of a team's points in a league.
    Scored(Score),
    /// Every team's points in a league.
    Standings(Box<Standings>),
    /// A warning, in words.
    Warning(String),
    /// A new map, for viewers; a log has only one map.
    Map(Box<MapDef>),
}

impl Record {
    /// Returns the bytes of memory that the record takes with its time, approximately: spare capacity of buffers is not
    /// counted.
    pub fn size(&self) -> usize {
        let held = match self {
            Self::In(line) | Self::Out(line) | Self::Closed(line) => line.line.len(),
            Self::State(state) => {
                let numbers = state.joint_positions.len() + state.joint_speeds.len();
                state.class.len() + state.name.len() + numbers * size_of::<f64>()
            }
            Self::Object(object) => object.name.len(),
            Self::ObjectSpawned(object) => object.definition.len(),
            Self::Picture(_, png) => png.len(),
            Self::Warning(text) => text.len(),
            Self::Scored(score) => score.held(),
            Self::Standings(standings) => standings.teams.iter().flat_map(|team| &team.scores).map(Score::held).sum(),
            Self::Left(_) | Self::ObjectRemoved(_) | Self::Map(_) => 0,
            Self::Sensed(sensed) => sensed.reading.held(),
        };
        size_of::<(f64, Self)>() + held
    }
}
