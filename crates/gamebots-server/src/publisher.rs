//! Everything that looks at the world: the log, Foxglove, viewers, and the journal from which a panic is made again. What
//! happens is published here and nowhere else.

use std::path::{Path, PathBuf};
use std::time::Instant;

use gamebots_proto::message::Message;
use recorder::{Record, RecordError, WireLine};
use scene::Snapshot;
use sim_core::{RobotId, World};

use crate::connection::ConnectionId;
use crate::journal::Journal;
use crate::live::{Broadcast, Line, Status};
use crate::recording::{BeginError, Recording};

pub(crate) struct Publisher {
    recording: Recording,
    live: Broadcast,
    journal: Journal,
    /// Where everything is, made when it is first looked at after something has changed.
    snapshot: Option<Snapshot>,
}

impl Publisher {
    pub(crate) fn new(recording: Recording, live: Broadcast) -> Self {
        Self { recording, live, journal: Journal::default(), snapshot: None }
    }

    /// A client has sent a line, to the robot that it has.
    pub(crate) fn received(&mut self, world: &World, connection: ConnectionId, pawn: Option<RobotId>, line: &str) {
        self.snapshot = None;
        let robot = pawn.map(|robot| robot.0);
        self.keep(world, Record::In(WireLine { connection, robot, line: line.to_owned() }));
        self.live.line(|| Line { time: world.time(), direction: "in", connection, robot, text: line.to_owned() });
    }

    /// Messages of a robot, or one about none, go to a client as this line.
    pub(crate) fn sent(
        &mut self,
        world: &World,
        connection: ConnectionId,
        robot: Option<RobotId>,
        messages: &[&Message],
        line: &str,
    ) {
        let robot = robot.map(|robot| robot.0);
        if self.recording.is_wanted() {
            self.recording.record(world, Record::Out(WireLine { connection, robot, line: line.to_owned() }));
            for sensed in messages.iter().filter_map(|message| Record::sensed(robot, message)) {
                self.recording.record(world, sensed);
            }
        }
        self.live.line(|| Line { time: world.time(), direction: "out", connection, robot, text: line.to_owned() });
    }

    /// A robot reports something, whether or not it has a client.
    pub(crate) fn reported(&mut self, world: &World, robot: RobotId, message: &Message) {
        self.live.scan(world, robot, message);
    }

    /// Something is otherwise: a client or a robot has come, or time passes otherwise.
    pub(crate) fn changed(&mut self, now: Instant) {
        self.snapshot = None;
        self.live.changed(now);
    }

    /// A robot has left the world.
    pub(crate) fn left(&mut self, world: &World, robot: RobotId) {
        self.snapshot = None;
        self.live.forget(robot);
        self.keep(world, Record::Left(robot.0));
    }

    /// A connection has ended.
    pub(crate) fn closed(&mut self, world: &World, connection: ConnectionId) {
        self.keep(world, Record::Closed(WireLine { connection, robot: None, line: String::new() }));
        self.live.changed(Instant::now());
    }

    /// Something in the world is wrong, in words.
    pub(crate) fn warn(&mut self, world: &World, warning: &str) {
        self.note(world, warning);
        self.live.say(warning);
    }

    /// Keeps a warning in the log. Viewers see it in their status, so they are not told in words.
    pub(crate) fn note(&mut self, world: &World, warning: &str) {
        if self.recording.is_wanted() {
            self.recording.record(world, Record::Warning(warning.to_owned()));
        }
    }

    /// Something has become of a request of a viewer, in words.
    pub(crate) fn announce(&mut self, now: Instant, text: &str) {
        self.live.say(text);
        self.live.changed(now);
    }

    /// The world has taken a step.
    pub(crate) fn stepped(&mut self, world: &World) {
        self.snapshot = None;
        if self.recording.wants_states(world.time()) {
            let snapshot = self.snapshot.get_or_insert_with(|| world.snapshot());
            self.recording.record_states(&world.def().map, snapshot);
        }
    }

    /// What is due by the clock: where everything is, the status, made with the path of the log that is being written, and what has
    /// become of logs. To be called often.
    pub(crate) fn publish(&mut self, now: Instant, world: &World, status: impl FnOnce(Option<&Path>) -> Status) {
        if let Some(due) = self.live.due(now) {
            let status = due.status.then(|| status(self.recording.path()));
            let snapshot = self.snapshot.get_or_insert_with(|| world.snapshot());
            self.live.publish(now, world.def(), snapshot, status);
        }
        self.recording.publish(now, world.time());
        for news in self.recording.news() {
            self.announce(now, &news);
        }
    }

    /// Begins a log that nobody has named, or ends the one that is being written.
    pub(crate) fn record(&mut self, now: Instant, world: &World, on: bool) {
        if !on {
            return self.recording.stop(world);
        }
        match self.recording.start_unnamed(now, world) {
            Ok(()) => {
                let path = self.recording.path().map(|path| format!("recording to {}", path.display()));
                path.into_iter().for_each(|text| self.live.say(&text));
            }
            Err(error) => self.warn(world, &error.to_string()),
        }
    }

    /// Whether the world may begin anew now.
    ///
    /// # Errors
    /// When a log would be followed by another too soon.
    pub(crate) fn may_start_over(&self, now: Instant) -> Result<(), BeginError> {
        self.recording.may_start_over(now)
    }

    /// A fresh world has taken the place of the old.
    pub(crate) fn start_over(&mut self, now: Instant, old: &World, new: &World) {
        (self.snapshot, self.journal) = (None, Journal::default());
        if old.def().map.name != new.def().map.name {
            self.live.show(new.def());
        }
        if let Err(error) = self.recording.start_over(now, old, new) {
            self.live.say(&error.to_string());
        }
    }

    /// Ends the log.
    pub(crate) fn end(mut self, world: &World) {
        self.recording.stop(world);
    }

    /// Ends the log of a world that has panicked, and writes from what the panic can be made again.
    ///
    /// # Errors
    /// When that file cannot be written.
    pub(crate) fn end_broken(mut self, world: &World, reason: &str) -> Result<PathBuf, RecordError> {
        self.recording.stop_broken(world);
        self.journal.write(Path::new(""), world, reason)
    }

    /// Records what happened to the world, for logs and for the report of a panic.
    fn keep(&mut self, world: &World, record: Record) {
        if self.recording.is_wanted() {
            self.recording.record(world, record.clone());
        }
        self.journal.add(world.time(), record);
    }
}
