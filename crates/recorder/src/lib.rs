//! The log of a run: every line in and out, and where the robots are, in an MCAP file.
//!
//! Simulated time is log time. Messages are protobuf; [`native`] has the channels, `proto/usarsim.proto` our own messages. Beside
//! them stand Foxglove's, so that a log opens as a moving scene. The metadata `run` holds the scene with every number in
//! effect, seed and time step; `end` the digest of the world. [`ros2`] writes the same as messages of ROS 2 to a file of its
//! own.
//!
//! [`Live`] gives the same messages to who watches.
//! For a live world writing happens on a thread of its own, so that a slow disk does not hold up the world; what is written reaches
//! the file at least once a second, so a killed process leaves a file that reads up to there.

mod drawing;
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
mod table;
mod writer;

pub use file::{Storage, storage};
pub use live::{Latched, Live};
pub use messages::{ObjectState, Quaternion, RobotLeft, RobotState, Vector, WireLine};
pub use reader::{Entry, Log, ReadError, read, scene};
pub use recover::{RecoverError, Recovered, recover};
pub use table::{Column, Table};
pub use writer::{Closing, LogWriter, RecordError, Recorder, Sink, ros2_path};

use foxglove::Encode;
use gamebots_proto::message::{Message, Reading, Sen};
use mcap::McapResult;
use scene::{MapDef, Pose, Snapshot};

/// Seconds between two recorded states of the robots.
pub const STATE_INTERVAL: f64 = 0.02;
/// The newest format of logs that is read, and the one that is written. 1, which logs do not say of themselves: robots are
/// bodies with wheels. 2: robots are trees of links.
const FORMAT: u32 = 2;
/// Name of the metadata that describes a run.
const RUN: &str = "run";
/// Name of the metadata that ends a log.
const END: &str = "end";
/// Topic of the robots that leave.
const LEFT: &str = "/robots/left";

/// Says when the states of robots and objects are to be recorded.
#[derive(Debug, Default)]
pub struct StateTimer {
    taken: u64,
    objects: Vec<Pose>,
}

impl StateTimer {
    /// Whether another interval has passed at a simulated time, s; to be asked after every step.
    pub fn is_due(&self, time: f64) -> bool {
        intervals(time) > self.taken
    }

    /// The states of all robots of a map, and of its objects that have moved since the last call.
    pub fn records(&mut self, map: &MapDef, snapshot: &Snapshot) -> Vec<Record> {
        self.taken = intervals(snapshot.time);
        let mut records: Vec<Record> = snapshot.robots.iter().map(RobotState::new).map(Record::State).collect();
        for (number, (pose, object)) in snapshot.objects.iter().zip(&map.objects).enumerate() {
            if self.objects.get(number) != Some(pose) {
                records.push(Record::Object(ObjectState::new(number as u32, &object.solid.name, pose)));
            }
        }
        self.objects.clone_from(&snapshot.objects);
        records
    }
}

fn intervals(time: f64) -> u64 {
    (time / STATE_INTERVAL + 1e-6) as u64
}

/// How a world ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct End {
    /// Simulated time, s.
    pub time: f64,
    /// A number that two worlds share only if every body has the same bits; none of a world that has panicked.
    pub digest: Option<u64>,
    /// Steps of robots that ended before every contact did what it should.
    pub unsettled_steps: u64,
    /// Records that did not get into the log; what writes it counts them.
    pub dropped: u64,
}

/// Where messages go.
pub(crate) trait Publish {
    /// Takes a message of a simulated time in seconds; the channel is made when it is first used.
    fn publish<T: Encode>(&mut self, time: f64, topic: &str, message: &T) -> McapResult<()>;

    /// Nothing that was said on the topics that begin so is true any more.
    fn forget(&mut self, _topics: &str) {}
}

/// One thing to record.
#[derive(Debug, Clone, PartialEq)]
pub enum Record {
    /// A line that came.
    In(WireLine),
    /// A line that was sent.
    Out(WireLine),
    /// What a sensor measured, beside the line that says it; a log has the line alone.
    Sensed(Sensed),
    /// A connection that ended; without a robot or a line.
    Closed(WireLine),
    /// A robot that left the world, by its number, with its connection or by itself.
    Left(u64),
    /// Where a robot is.
    State(RobotState),
    /// Where an object is that has moved.
    Object(ObjectState),
    /// Something that is wrong, in words.
    Warning(String),
    /// Another map than before, for those who watch; a log has one.
    Map(Box<MapDef>),
}

/// What a sensor of a robot measured.
#[derive(Debug, Clone, PartialEq)]
pub struct Sensed {
    /// The robot's number.
    pub robot: u64,
    /// The number of the sensor among those of the robot's class.
    pub sensor: usize,
    /// What it measured.
    pub reading: Reading,
}

impl Record {
    /// What is to be recorded of a message beside its line, which is sent to the client of a robot.
    pub fn sensed(robot: Option<u64>, message: &Message) -> Option<Self> {
        let Message::Sen(Sen { reading, sensor, .. }) = message else { return None };
        Some(Self::Sensed(Sensed { robot: robot?, sensor: (*sensor)?, reading: reading.clone() }))
    }

    /// Bytes that it takes in memory with its time, about: what it points to has no more room than it needs.
    pub fn size(&self) -> usize {
        let held = match self {
            Self::In(line) | Self::Out(line) | Self::Closed(line) => line.line.len(),
            Self::State(state) => {
                let numbers = state.joint_positions.len() + state.joint_speeds.len();
                state.class.len() + state.name.len() + numbers * size_of::<f64>()
            }
            Self::Object(object) => object.name.len(),
            Self::Warning(text) => text.len(),
            Self::Left(_) | Self::Map(_) => 0,
            // Of a scan its ranges; the rest is small.
            Self::Sensed(Sensed { reading: Reading::RangeScanner(scan), .. }) => size_of_val(scan.ranges.as_slice()),
            Self::Sensed(_) => 0,
        };
        size_of::<(f64, Self)>() + held
    }
}
