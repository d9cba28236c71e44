//! Sessions of a world that are logged. Experiments and the Python package drive their worlds by them.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use gamebots_proto::{Dialect, Problem};
use recorder::{End, LogWriter, Record, RecordError, StateTimer};
use scene::{PawnId, Sensed, Standings};
use sessions::{Listener, Mistakes, News, Request, SessionId, Sessions};
use sim_core::World;

use crate::records::record;

/// A world with its sessions, and the log that they are written to, if any.
pub struct LoggedSessions {
    sessions: Sessions,
    /// Never locked: it makes the type `Sync`, which the writer's LZ4 encoder is not.
    log: Option<Mutex<LogWriter>>,
    states: StateTimer,
    /// Mistakes of each open session, for the log.
    mistakes: BTreeMap<SessionId, Mistakes>,
}

impl LoggedSessions {
    /// Creates the sessions of a world. A log has to be of a world at time zero, or it does not replay.
    pub fn new(world: World, log: Option<LogWriter>) -> Self {
        Self { log: log.map(Mutex::new), ..Self::without_log(Sessions::new(world)) }
    }

    /// Returns a copy that continues as the original would, without a log.
    #[must_use]
    pub fn copy(&self) -> Self {
        Self::without_log(self.sessions.clone())
    }

    fn without_log(sessions: Sessions) -> Self {
        Self { sessions, log: None, states: StateTimer::default(), mistakes: BTreeMap::new() }
    }

    /// Returns the world.
    pub fn world(&self) -> &World {
        self.sessions.world()
    }

    /// Returns the points of the league that is played, if any.
    pub fn standings(&self) -> Option<Standings> {
        self.sessions.standings()
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
        self.mistakes.insert(id, Mistakes::new(id));
        self.record(&mut |_| {}, |sessions, hear| sessions.open(id, Some(Dialect::Udk), false, hear))
    }

    /// Executes a request of a session, and returns its problems. Calls `sensed` with the readings that it causes.
    ///
    /// # Errors
    /// When the log cannot be written.
    pub fn take(
        &mut self,
        id: SessionId,
        request: &Request,
        sensed: &mut dyn FnMut(&Sensed),
    ) -> Result<Vec<Problem>, RecordError> {
        self.mistakes.get_mut(&id).into_iter().for_each(Mistakes::count_line);
        self.record(sensed, |sessions, hear| sessions.take(id, request, hear)).map(|answer| answer.problems)
    }

    /// Executes a request of a session as [`LoggedSessions::take`] does. Returns its problems, and the lines that answer it.
    ///
    /// # Errors
    /// When the log cannot be written.
    pub fn ask(
        &mut self,
        id: SessionId,
        request: &Request,
        sensed: &mut dyn FnMut(&Sensed),
    ) -> Result<(Vec<Problem>, Vec<String>), RecordError> {
        self.mistakes.get_mut(&id).into_iter().for_each(Mistakes::count_line);
        let mut answers = Vec::new();
        let answer = self.record(sensed, |sessions, hear| {
            sessions.ask(id, request, &mut |world, news| {
                if let News::Sent { line, .. } = &news {
                    answers.push(line.clone());
                }
                hear(world, news);
            })
        })?;
        Ok((answer.problems, answers))
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
        if let (Some(log), Some(mut mistakes)) = (writer(&mut self.log), self.mistakes.remove(&id)) {
            let time = self.sessions.world().time();
            mistakes.repetitions().try_for_each(|text| log.write(time, &Record::Warning(text)))?;
        }
        self.record(&mut |_| {}, |sessions, hear| sessions.close(id, hear))
    }

    /// Ends the log, if there is one. Nothing is logged from then on.
    ///
    /// # Errors
    /// When the log cannot be written.
    pub fn finish(&mut self) -> Result<(), RecordError> {
        let Some(log) = self.log.take() else { return Ok(()) };
        let world = self.sessions.world();
        let (time, digest) = (world.time(), Some(world.digest()));
        let mut log = log.into_inner().unwrap_or_else(PoisonError::into_inner);
        let repeated = std::mem::take(&mut self.mistakes).into_values();
        let repeated: Vec<String> = repeated.flat_map(|mut it| it.repetitions().collect::<Vec<_>>()).collect();
        let standings = self.sessions.standings().map(|standings| Record::Standings(Box::new(standings)));
        let last = repeated.into_iter().map(Record::Warning).chain(standings);
        last.into_iter().try_for_each(|record| log.write(time, &record))?;
        log.finish(End { time, digest, unsettled_steps: world.unsettled_steps(), dropped: 0 })
    }

    /// Does something with the sessions, and records the news.
    fn record<T>(
        &mut self,
        sensed: &mut dyn FnMut(&Sensed),
        act: impl FnOnce(&mut Sessions, Listener) -> T,
    ) -> Result<T, RecordError> {
        let mut written = Ok(());
        let Self { sessions, log, mistakes, .. } = self;
        let mut log = writer(log);
        let done = act(sessions, &mut |world, news| {
            let mut warnings = Vec::new();
            if let News::Wrong { session, line, problems } = &news {
                let told =
                    mistakes.get_mut(session).map(|it| problems.iter().filter_map(|problem| it.warning(line, problem)));
                warnings.extend(told.into_iter().flatten().map(Record::Warning));
            }
            if let News::Sensed(reading) = &news {
                sensed(reading);
            }
            if let (Some(log), Ok(())) = (log.as_mut(), &written) {
                let records = warnings.into_iter().chain(record(&news));
                written = records.into_iter().try_for_each(|record| log.write(world.time(), &record));
            }
        });
        written.map(|()| done)
    }
}

fn writer(log: &mut Option<Mutex<LogWriter>>) -> Option<&mut LogWriter> {
    log.as_mut().map(|log| log.get_mut().unwrap_or_else(PoisonError::into_inner))
}
