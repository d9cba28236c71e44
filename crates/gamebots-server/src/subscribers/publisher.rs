//! The publisher of all that happens: to the log, Foxglove, viewers, and the journal that reproduces a panic. Nothing is
//! published elsewhere.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use recorder::{Record, RecordError, WireLine};
use scene::{Reading, Score, Sensed, Standings};
use sessions::SessionId;
use sim_core::{PawnId, World};

use crate::subscribers::actors::Actors;
use crate::subscribers::cameras::{Shot, Shots};
use crate::subscribers::journal::Journal;
use crate::subscribers::live::{Broadcast, Line, Status};
use crate::subscribers::log::{BeginError, Recording};
use crate::subscribers::present::Present;

pub(crate) struct Publisher {
    recording: Recording,
    live: Broadcast,
    journal: Journal,
    /// Pictures of cameras for logs, if they are recorded.
    shots: Option<Shots>,
    present: Present,
}

impl Publisher {
    /// Creates the publisher of a world. `pictures` is true to record what cameras see.
    pub(crate) fn new(recording: Recording, live: Broadcast, world: &World, pictures: bool) -> Self {
        let shots = pictures.then(Shots::default);
        Self { recording, live, journal: Journal::of(world), shots, present: Present::default() }
    }

    /// Publishes a line that came from a client. `pawn` is the client's newest robot.
    pub(crate) fn received(&mut self, world: &World, connection: SessionId, pawn: Option<PawnId>, line: &str) {
        self.present.forget();
        let robot = pawn.map(|robot| robot.0);
        self.keep(world, Record::In(WireLine { connection, robot, line: line.to_owned() }));
        self.live.line(|| Line { time: world.time(), direction: "in", connection, robot, text: Line::cut(line) });
    }

    /// Publishes a line that goes to a client. `robot` is the robot that it is about, if any.
    pub(crate) fn sent(&mut self, world: &World, connection: SessionId, robot: Option<PawnId>, line: &str) {
        let robot = robot.map(|robot| robot.0);
        if self.recording.is_wanted() {
            self.recording.record(world, Record::Out(WireLine { connection, robot, line: line.to_owned() }));
        }
        self.live.line(|| Line { time: world.time(), direction: "out", connection, robot, text: Line::cut(line) });
    }

    /// Publishes a reading, whether or not the robot has a client.
    pub(crate) fn sensed(&mut self, world: &World, sensed: &Sensed) {
        self.live.sensed(world, sensed, &mut self.present);
        if !self.recording.is_wanted() {
            return;
        }
        self.recording.record(world, Record::Sensed(sensed.clone()));
        if let (Some(shots), Reading::Camera(_)) = (&mut self.shots, &sensed.reading) {
            shots.take(world, sensed, self.present.of(world));
        }
    }

    /// Notes that the status changed: a client or robot arrived, or the timing changed.
    pub(crate) fn changed(&mut self, now: Instant) {
        self.present.forget();
        self.live.changed(now);
    }

    /// Publishes that a robot left the world.
    pub(crate) fn left(&mut self, world: &World, robot: PawnId) {
        self.present.forget();
        self.live.forget(robot);
        self.keep(world, Record::Left(robot.0));
    }

    /// Publishes that a team gained or lost points.
    pub(crate) fn scored(&mut self, world: &World, score: &Score) {
        if self.recording.is_wanted() {
            self.recording.record(world, Record::Scored(score.clone()));
        }
        self.announce(Instant::now(), &score.to_string());
    }

    /// Records every team's points.
    pub(crate) fn standings(&mut self, world: &World, standings: &Standings) {
        if self.recording.is_wanted() {
            self.recording.record(world, Record::Standings(Box::new(standings.clone())));
        }
    }

    /// Publishes that a connection ended.
    pub(crate) fn closed(&mut self, world: &World, connection: SessionId) {
        self.keep(world, Record::Closed(WireLine { connection, robot: None, line: String::new() }));
        self.live.changed(Instant::now());
    }

    /// Publishes a warning about the world, in words.
    pub(crate) fn warn(&mut self, world: &World, warning: &str) {
        self.note(world, warning);
        self.live.say(warning);
    }

    /// Records a warning in the log only. Viewers see it in their status.
    pub(crate) fn note(&mut self, world: &World, warning: &str) {
        if self.recording.is_wanted() {
            self.recording.record(world, Record::Warning(warning.to_owned()));
        }
    }

    /// Tells viewers the outcome of a request, in words.
    pub(crate) fn announce(&mut self, now: Instant, text: &str) {
        self.live.say(text);
        self.live.changed(now);
    }

    /// Records the states after a step, if they are due.
    pub(crate) fn stepped(&mut self, world: &World) {
        for Shot { taken, png } in self.shots.iter_mut().flat_map(|shots| shots.due(world.time())) {
            self.recording.record(world, Record::Picture(taken, png));
        }
        self.recording.stepped(world.time(), || self.present.of(world));
    }

    /// Publishes what is due by the clock: the frame, the status, and news of logs. `status` gets the path of the open log. To
    /// be called often.
    pub(crate) fn publish(&mut self, now: Instant, world: &World, status: impl FnOnce(Option<&Path>) -> Status) {
        if let Some(due) = self.live.due(now) {
            let status = due.status.then(|| status(self.recording.path()));
            self.live.publish(now, world.def(), &self.present.of(world), status);
        }
        self.recording.publish(now, world.time());
        for news in self.recording.news() {
            self.announce(now, &news);
        }
    }

    /// Starts a log without a given name, or ends the open one.
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

    /// Returns everything that has a pose in the world.
    pub(crate) fn actors(&mut self, world: &World) -> Arc<Actors> {
        self.present.actors(world)
    }

    /// Checks if the world may start over now.
    ///
    /// # Errors
    /// When the next log would start too soon, or too many logs are incomplete.
    pub(crate) fn may_start_over(&self, now: Instant) -> Result<(), BeginError> {
        self.recording.may_start_over(now)
    }

    /// Replaces the old world with a fresh one, for viewers and logs.
    pub(crate) fn start_over(&mut self, now: Instant, old: &World, new: &World) {
        (self.present, self.journal) = (Present::default(), Journal::of(new));
        // The thread ends by itself: nobody takes the pictures of the old world.
        self.shots.iter_mut().for_each(|shots| *shots = Shots::default());
        self.live.start_over();
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

    /// Ends the log of a world that has panicked, and writes a log that reproduces the panic.
    ///
    /// # Errors
    /// When that file cannot be written.
    pub(crate) fn end_broken(mut self, world: &World, reason: &str) -> Result<PathBuf, RecordError> {
        self.recording.stop_broken(world);
        self.journal.write(Path::new(""), world, reason)
    }

    /// Records what happened to the world, in the log and in the journal.
    fn keep(&mut self, world: &World, record: Record) {
        if self.recording.is_wanted() {
            self.recording.record(world, record.clone());
        }
        self.journal.add(world.time(), record);
    }
}
