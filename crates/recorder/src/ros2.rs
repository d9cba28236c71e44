//! The log as messages of ROS 2, in a separate file: the profile is `ros2`, and messages are CDR. The crate `ros2-topics` has the topics,
//! which `docs/logs.md` lists. A robot's namespace is its number.

use std::path::Path;

use mcap::{McapError, McapResult};
use ros2_topics::{Message, Namespaces, Sink, State, Topics};
use scene::WorldDef;

use crate::file::{LogFile, Storage};
use crate::{Publish, Record, RecordError, RobotState};

/// Begins a file for the messages.
pub(crate) fn begin(storage: Box<dyn Storage>, path: &Path) -> Result<LogFile, RecordError> {
    LogFile::begin(storage, path, "ros2")
}

/// Converts records to messages.
pub(crate) struct Ros2 {
    world: WorldDef,
    topics: Topics,
}

impl Ros2 {
    pub(crate) fn new(world: &WorldDef) -> Self {
        Self { world: world.clone(), topics: Topics::new(Namespaces::Numbers, true, &world.map) }
    }

    pub(crate) fn write(&mut self, time: f64, record: &Record, file: &mut LogFile) -> McapResult<()> {
        match record {
            Record::State(state) => self.write_state(time, state, file),
            Record::Object(object) => {
                self.topics.publish_clock(time, file)?;
                self.topics.place_object(time, u64::from(object.object), &object.pose());
                self.topics.publish_transforms(time, file)
            }
            Record::Sensed(sensed) => self.topics.publish_reading(time, sensed, file),
            Record::Left(robot) => {
                self.topics.leave(*robot);
                Ok(())
            }
            Record::In(_)
            | Record::Out(_)
            | Record::Closed(_)
            | Record::ObjectSpawned(_)
            | Record::ObjectRemoved(_)
            | Record::Picture(..)
            | Record::Scored(_)
            | Record::Standings(_)
            | Record::Warning(_)
            | Record::Map(_) => Ok(()),
        }
    }

    fn write_state(&mut self, time: f64, state: &RobotState, file: &mut LogFile) -> McapResult<()> {
        self.topics.publish_clock(time, file)?;
        // Without the class, as in a damaged log, there are no frames.
        let Some(def) = self.world.robots.get(&state.class) else { return Ok(()) };
        if !self.topics.has(state.robot) {
            self.topics.come(time, state.robot, &state.name, def, None, file)?;
        }
        let (linear, angular) = state.velocity();
        let now = State { pose: state.pose(), linear, angular, joints: &state.joints() };
        self.topics.publish_state(time, state.robot, &now, file)?;
        self.topics.publish_transforms(time, file)
    }
}

impl Sink for LogFile {
    type Error = McapError;

    fn publish<T: Message>(&mut self, time: f64, topic: &str, message: &T) -> McapResult<()> {
        Publish::publish(self, time, topic, message)
    }
}
