//! The channels of a log, streamed live by Foxglove's WebSocket server, with the topics and messages of the file.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use foxglove::{Context, Encode, PartialMetadata, RawChannel, SinkId};
use mcap::McapResult;
use scene::{Snapshot, WorldDef};

use crate::error::refused;
use crate::file::nanoseconds;
use crate::native::Native;
use crate::states::States;
use crate::writer::Sink;
use crate::{End, LEFT, Publish, Record, RecordError};

/// Topics whose last message says nothing about the present.
const PASSING: [&str; 4] = ["/wire/", "/log", LEFT, "/objects/"];

/// Converts records to messages on the channels of a Foxglove context.
pub struct Live {
    native: Native,
    states: States,
    channels: Channels,
    /// Simulated time of the last record, s. An earlier record belongs to a fresh world.
    time: f64,
}

/// The last message of each channel, for late subscribers: the map and the robots are published only once.
#[derive(Clone, Default)]
pub struct Latched(Arc<Mutex<BTreeMap<String, Last>>>);

/// The subscribers that may have messages, by a number that their entrance gave them. Others get nothing.
#[derive(Clone, Default)]
pub struct Admitted(Arc<Mutex<BTreeMap<u64, SinkId>>>);

struct Last {
    channel: Arc<RawChannel>,
    message: Vec<u8>,
    time: PartialMetadata,
}

struct Channels {
    context: Arc<Context>,
    by_topic: BTreeMap<String, Arc<RawChannel>>,
    latched: Latched,
    admitted: Admitted,
}

impl Live {
    /// Creates the channels and publishes the static messages.
    ///
    /// # Errors
    /// When a channel cannot be created.
    pub fn new(
        world: &WorldDef,
        context: Arc<Context>,
        latched: Latched,
        admitted: Admitted,
    ) -> Result<Self, RecordError> {
        let mut channels = Channels { context, by_topic: BTreeMap::new(), latched, admitted };
        let native = Native::new(world, &mut channels).map_err(|reason| refused("of Foxglove", reason))?;
        Ok(Self { native, states: States::default(), channels, time: 0.0 })
    }

    /// Prepares for records of a simulated time, s.
    fn enter(&mut self, time: f64) -> McapResult<()> {
        let is_fresh = time < self.time;
        self.time = time;
        if !is_fresh {
            return Ok(());
        }
        self.states = States::default();
        self.native.start_over(time, &mut self.channels)
    }
}

impl Sink for Live {
    fn write(&mut self, time: f64, record: &Record) -> Result<(), RecordError> {
        if let Record::Map(_) = record {
            self.states = States::default();
        }
        let written = self.enter(time).and_then(|()| self.native.write(time, record, &mut self.channels));
        written.map_err(|reason| refused("of Foxglove", reason))
    }

    fn write_states(&mut self, snapshot: &Snapshot) -> Result<(), RecordError> {
        let time = snapshot.time;
        let written = self.enter(time).and_then(|()| {
            let records = self.states.records(self.native.objects_of_map(), snapshot);
            records.iter().try_for_each(|record| self.native.write(time, record, &mut self.channels))
        });
        written.map_err(|reason| refused("of Foxglove", reason))
    }

    fn flush(&mut self) -> Result<(), RecordError> {
        Ok(())
    }

    fn finish(self, _end: End) -> Result<(), RecordError> {
        Ok(())
    }
}

impl Admitted {
    /// Admits a subscriber.
    pub fn admit(&self, number: u64, subscriber: SinkId) {
        self.lock().insert(number, subscriber);
    }

    /// Forgets a subscriber that has left.
    pub fn forget(&self, number: u64) {
        self.lock().remove(&number);
    }

    /// True if a subscriber is admitted.
    pub fn has(&self, subscriber: SinkId) -> bool {
        self.lock().values().any(|admitted| *admitted == subscriber)
    }

    /// Sends a message to all who are admitted and have subscribed to its channel.
    fn send(&self, channel: &RawChannel, message: &[u8], time: PartialMetadata) {
        for &subscriber in self.lock().values() {
            channel.log_with_meta_to_sink(message, time, Some(subscriber));
        }
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<u64, SinkId>> {
        // The map is valid after each statement.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Latched {
    /// Sends the last message of a channel to one subscriber.
    pub fn send(&self, topic: &str, subscriber: Option<SinkId>) {
        if let Some(Last { channel, message, time }) = self.lock().get(topic) {
            channel.log_with_meta_to_sink(message, *time, subscriber);
        }
    }

    fn lock(&self) -> MutexGuard<'_, BTreeMap<String, Last>> {
        // The map is valid after each statement.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Publish for Channels {
    fn publish<T: Encode>(&mut self, time: f64, topic: &str, message: &T) -> McapResult<()> {
        let channel = match self.by_topic.get(topic) {
            Some(channel) => channel.clone(),
            None => self.open::<T>(topic)?,
        };
        let is_passing = PASSING.iter().any(|passing| topic.starts_with(passing));
        if is_passing && !channel.has_sinks() {
            return Ok(());
        }
        let mut buffer = Vec::with_capacity(message.encoded_len().unwrap_or(0));
        message.encode(&mut buffer).map_err(|error| std::io::Error::other(error.to_string()))?;
        let time = PartialMetadata::with_log_time(nanoseconds(time));
        if is_passing {
            self.admitted.send(&channel, &buffer, time);
            return Ok(());
        }
        // The lock stays held, so that a new subscriber gets this message once and not an older one after it.
        let mut latched = self.latched.lock();
        self.admitted.send(&channel, &buffer, time);
        latched.insert(topic.to_owned(), Last { channel, message: buffer, time });
        Ok(())
    }

    fn forget(&mut self, topics: &str) {
        self.latched.lock().retain(|topic, _| !topic.starts_with(topics));
    }
}

impl Channels {
    fn open<T: Encode>(&mut self, topic: &str) -> McapResult<Arc<RawChannel>> {
        let builder = self.context.channel_builder(topic).message_encoding(T::get_message_encoding());
        let channel = builder.schema(T::get_schema()).build_raw();
        let channel = channel.map_err(|error| std::io::Error::other(error.to_string()))?;
        self.by_topic.insert(topic.to_owned(), channel.clone());
        Ok(channel)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::RobotState;

    #[test]
    fn nothing_is_kept_of_robots_that_left() {
        let (world, latched) = (WorldDef::default(), Latched::default());
        let mut live = Live::new(&world, Context::new(), latched.clone(), Admitted::default()).expect("channels");
        let topics = || latched.lock().keys().cloned().collect::<Vec<_>>();
        let before = topics();
        for robot in 0..1000 {
            let state = RobotState { robot, class: "none".to_owned(), ..RobotState::default() };
            live.write(0.0, &Record::State(state)).expect("a message");
            assert!(topics().contains(&"/robot/0/pose".to_owned()));
            live.write(0.0, &Record::Left(robot)).expect("a message");
            assert_eq!(topics(), before, "robot {robot}");
        }
        assert!(live.channels.by_topic.len() < 12, "{:?}", live.channels.by_topic.keys());
    }
}
