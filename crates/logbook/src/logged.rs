//! Sessions of a world that are logged: what experiments and the Python package drive their worlds by.

use std::sync::{Mutex, PoisonError};

use gamebots_proto::{Dialect, Problem};
use recorder::{End, LogWriter, Record, RecordError, StateTimer, WireLine};
use scene::{PawnId, Sensed};
use sessions::{Listener, News, Request, SessionId, Sessions};
use sim_core::World;

/// A world with its sessions, and the log that they are written to, if any.
pub struct LoggedSessions {
    sessions: Sessions,
    /// Never locked: it makes the type `Sync`, which the writer's LZ4 encoder is not.
    log: Option<Mutex<LogWriter>>,
    states: StateTimer,
}

impl LoggedSessions {
    /// Creates the sessions of a world. A log has to be of a world at time zero, or it does not replay.
    pub fn new(world: World, log: Option<LogWriter>) -> Self {
        Self { sessions: Sessions::new(world), log: log.map(Mutex::new), states: StateTimer::default() }
    }

    /// Returns a copy that continues as the original would, without a log.
    #[must_use]
    pub fn copy(&self) -> Self {
        Self { sessions: self.sessions.clone(), log: None, states: StateTimer::default() }
    }

    /// Returns the world.
    pub fn world(&self) -> &World {
        self.sessions.world()
    }

    /// Returns the world, to change it beside the sessions. A log does not tell of such changes.
    pub fn world_mut(&mut self) -> &mut World {
        self.sessions.world_mut()
    }

    /// True if there is a log that has not ended.
    pub fn is_logged(&self) -> bool {
        self.log.is_some()
    }

    /// Returns the newest pawn of a session.
    pub fn newest(&self, session: SessionId) -> Option<PawnId> {
        self.sessions.newest(session)
    }

    /// Returns the session that a pawn reports to.
    pub fn owner(&self, pawn: PawnId) -> Option<SessionId> {
        self.sessions.owner(pawn)
    }

    /// Opens a session. Its lines are computed only for a log.
    ///
    /// # Errors
    /// When the log cannot be written.
    pub fn open(&mut self, id: SessionId) -> Result<(), RecordError> {
        if self.log.is_none() {
            self.sessions.open_silent(id);
            return Ok(());
        }
        self.record(&mut |_| {}, |sessions, hear| sessions.open(id, Some(Dialect::Udk), false, hear)).map(drop)
    }

    /// Executes a line of a session, and returns its problems. Calls `sensed` with the readings that it causes.
    ///
    /// # Errors
    /// When the log cannot be written.
    pub fn take(
        &mut self,
        id: SessionId,
        line: &str,
        sensed: &mut dyn FnMut(&Sensed),
    ) -> Result<Vec<Problem>, RecordError> {
        let request = Request::read(Ok(line.to_owned()));
        self.record(sensed, |sessions, hear| sessions.take(id, &request, hear))
    }

    /// Executes a line of a session as [`LoggedSessions::take`] does. Returns its problems, and the lines that answer it.
    ///
    /// # Errors
    /// When the log cannot be written.
    pub fn ask(
        &mut self,
        id: SessionId,
        line: &str,
        sensed: &mut dyn FnMut(&Sensed),
    ) -> Result<(Vec<Problem>, Vec<String>), RecordError> {
        let request = Request::read(Ok(line.to_owned()));
        let mut answers = Vec::new();
        let problems = self.record(sensed, |sessions, hear| {
            sessions.ask(id, &request, &mut |world, news| {
                if let News::Sent { line, .. } = &news {
                    answers.push(line.clone());
                }
                hear(world, news);
            });
        })?;
        Ok((problems, answers))
    }

    /// Advances the world by one step. Calls `sensed` with the readings of the step.
    ///
    /// # Errors
    /// When the log cannot be written.
    pub fn step(&mut self, sensed: &mut dyn FnMut(&Sensed)) -> Result<(), RecordError> {
        self.record(sensed, |sessions, hear| sessions.step(hear))?;
        if let Some(log) = writer(&mut self.log) {
            let world = self.sessions.world();
            if self.states.is_due(world.time()) {
                log.write_states(&world.snapshot())?;
            }
        }
        Ok(())
    }

    /// Closes a session and removes its pawns.
    ///
    /// # Errors
    /// When the log cannot be written.
    pub fn close(&mut self, id: SessionId) -> Result<(), RecordError> {
        self.record(&mut |_| {}, |sessions, hear| sessions.close(id, hear)).map(drop)
    }

    /// Ends the log, if there is one. Nothing is logged from then on.
    ///
    /// # Errors
    /// When the log cannot be written.
    pub fn finish(&mut self) -> Result<(), RecordError> {
        let Some(log) = self.log.take() else { return Ok(()) };
        let world = self.sessions.world();
        let (time, digest) = (world.time(), Some(world.digest()));
        let log = log.into_inner().unwrap_or_else(PoisonError::into_inner);
        log.finish(End { time, digest, unsettled_steps: world.unsettled_steps(), dropped: 0 })
    }

    /// Does something with the sessions, records the news, and returns the problems among it.
    fn record(
        &mut self,
        sensed: &mut dyn FnMut(&Sensed),
        act: impl FnOnce(&mut Sessions, Listener),
    ) -> Result<Vec<Problem>, RecordError> {
        let (mut found, mut written) = (Vec::new(), Ok(()));
        let mut log = writer(&mut self.log);
        act(&mut self.sessions, &mut |world, news| {
            match &news {
                News::Wrong { problems, .. } => found.extend_from_slice(problems),
                News::Sensed(reading) => sensed(reading),
                _ => {}
            }
            if let (Some(log), Ok(())) = (log.as_mut(), &written)
                && let Some(record) = record(news)
            {
                written = log.write(world.time(), &record);
            }
        });
        written.map(|()| found)
    }
}

fn writer(log: &mut Option<Mutex<LogWriter>>) -> Option<&mut LogWriter> {
    log.as_mut().map(|log| log.get_mut().unwrap_or_else(PoisonError::into_inner))
}

/// Returns the record of news; `None` for news that a log gets in another form.
fn record(news: News) -> Option<Record> {
    let line = |connection, pawn: Option<PawnId>, line| WireLine { connection, robot: pawn.map(|pawn| pawn.0), line };
    match news {
        News::Received { session, pawn, line: text } => Some(Record::In(line(session, pawn, text.to_owned()))),
        News::Sent { session, pawn, line: text, .. } => Some(Record::Out(line(session, pawn, text))),
        News::Sensed(sensed) => Some(Record::Sensed(sensed.clone())),
        News::Left(pawn) => Some(Record::Left(pawn.0)),
        News::Closed(session) => Some(Record::Closed(line(session, None, String::new()))),
        News::Lost(lost) => Some(Record::Warning(lost.to_string())),
        News::Scored(score) => Some(Record::Scored(score.clone())),
        News::Wrong { .. } | News::Came(_) | News::Restored { .. } | News::TimeUp(_) => None,
    }
}
