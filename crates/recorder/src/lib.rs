//! The log of a run: every line in and out, and the states of robots and objects, in an MCAP file.
//!
//! Simulated time is log time. Messages are protobuf: [`native`] has the channels, and `proto/usarsim.proto` our own messages.
//! Foxglove's messages stand beside them, so that a log opens as a moving scene. The metadata `run` holds the scene with every
//! number in effect, seed and time step. The metadata `end` holds the digest of the world. [`ros2`] writes the run as messages
//! of ROS 2 to a separate file.
//!
//! [`Live`] streams the messages to viewers. For a live world, a separate thread writes the file, so that a slow disk does not
//! hold up the world. Records reach the file at least once a second. So a killed process leaves a file that can be read up to
//! there.

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
pub use messages::{
    ObjectRemoved, ObjectSpawned, ObjectState, PictureTaken, Quantity, Quaternion, RobotLeft, RobotState,
    SensorReading, Vector, WireLine,
};
pub use reader::{Entry, Log, ReadError, read, scene};
pub use recover::{RecoverError, Recovered, recover};
pub use table::{Column, Table};
pub use writer::{Closing, LogWriter, RecordError, Recorder, Sink, ros2_path};

use foxglove::Encode;
use mcap::McapResult;
use scene::{MapDef, ObjectId, ObjectSnapshot, Sensed, Snapshot};

/// Interval between two recorded states of the robots, s.
pub const STATE_INTERVAL: f64 = 0.02;
/// The newest format of logs, which is written; older ones are read, too. In format 1, which logs do not name, robots are
/// bodies with wheels. In format 2, robots are trees of links.
const FORMAT: u32 = 2;
/// Name of the metadata that describes a run.
const RUN: &str = "run";
/// Name of the metadata that ends a log.
const END: &str = "end";
/// Topic of robots that leave.
const LEFT: &str = "/robots/left";
/// Topics of objects that the map does not have, and of those that leave.
const OBJECTS: [&str; 2] = ["/objects/spawned", "/objects/removed"];

/// Timer of the recorded states of robots and objects.
#[derive(Debug, Default)]
pub struct StateTimer {
    taken: u64,
    /// Objects at the last call, by their ids; `None` before the first one.
    objects: Option<Vec<ObjectSnapshot>>,
}

impl StateTimer {
    /// True if another interval has passed at a simulated time, s; to be called after every step.
    pub fn is_due(&self, time: f64) -> bool {
        intervals(time) > self.taken
    }

    /// Returns the states of all robots, and of the objects that were spawned, moved or removed since the last call.
    pub fn records(&mut self, map: &MapDef, snapshot: &Snapshot) -> Vec<Record> {
        self.taken = intervals(snapshot.time);
        let mut records: Vec<Record> = snapshot.robots.iter().map(RobotState::new).map(Record::State).collect();
        let find = |objects: &[ObjectSnapshot], id| objects.binary_search_by_key(&id, |object| object.id).ok();
        let of_map = map.objects.len() as u64;
        let known = self.objects.as_deref().unwrap_or_default();
        for object in &snapshot.objects {
            let before = find(known, object.id).map(|place| &known[place]);
            if before.is_none() && object.id.0 >= of_map {
                records.push(Record::ObjectSpawned(ObjectSpawned::new(object)));
            }
            if before.is_none_or(|before| before.pose != object.pose) {
                records.push(Record::Object(ObjectState::new(object)));
            }
        }
        // At the first call the log knows those of the map.
        let of_map = (0..of_map).map(ObjectId).filter(|_| self.objects.is_none());
        let before = known.iter().map(|object| object.id).chain(of_map);
        let removed = before.filter(|id| find(&snapshot.objects, *id).is_none());
        records.extend(removed.map(|id| Record::ObjectRemoved(ObjectRemoved { object: id.0 as u32 })));
        self.objects = Some(snapshot.objects.clone());
        records
    }
}

fn intervals(time: f64) -> u64 {
    (time / STATE_INTERVAL + 1e-6) as u64
}

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
            Self::Left(_) | Self::ObjectRemoved(_) | Self::Map(_) => 0,
            Self::Sensed(sensed) => sensed.reading.held(),
        };
        size_of::<(f64, Self)>() + held
    }
}
