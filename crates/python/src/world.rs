//! Worlds with their robots.
//!
//! Every robot has a session of its own, and logs have its orders as lines of the wire. So a log of a world in Python is like a log of a server, and
//! `usarsim log replay` repeats it.

mod methods;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::{Duration, Instant};

use ::scene::{ObjectId, PawnId, Sensed};
use gamebots_proto::Command;
use gamebots_proto::command::Init;
use gamebots_server::{Moment, View};
use logbook::LoggedSessions;
use picture::Stage;
use pyo3::prelude::*;
use recorder::{LogWriter, RecordError};
use sessions::{Request, SessionId};
use thread_pool::ThreadPool;

use crate::error;

/// Time between two looks at the signals of the process, for Ctrl-C.
const SIGNAL_INTERVAL: Duration = Duration::from_millis(100);
/// Time between two looks of a world that is shown, or that keeps to a pace.
const SHOWN_INTERVAL: Duration = Duration::from_millis(15);

/// A reading with its time, s.
pub(crate) type Read = (f64, Sensed);

/// A simulated world.
#[pyclass(module = "usarsim")]
pub(crate) struct World {
    pub(crate) sessions: LoggedSessions,
    pub(crate) readings: BTreeMap<(PawnId, usize), Read>,
    next_session: SessionId,
    /// The world controller that creates objects, once there is one.
    controller: Option<PawnId>,
    threads: ThreadPool,
    stage: Option<Arc<Stage>>,
    view: Option<View>,
    /// Time of the moment that its page shows, s.
    shown: f64,
}

impl World {
    pub(crate) fn world(&self) -> &sim_core::World {
        self.sessions.world()
    }

    fn with(world: sim_core::World, threads: ThreadPool, log: Option<LogWriter>) -> Self {
        let sessions = LoggedSessions::new(world.on_threads(Arc::new(threads.clone())), log);
        Self {
            sessions,
            readings: BTreeMap::new(),
            next_session: 1,
            controller: None,
            threads,
            stage: None,
            view: None,
            shown: f64::NEG_INFINITY,
        }
    }

    /// Creates sessions for a world that has robots: each takes one over.
    pub(crate) fn of(world: sim_core::World, threads: ThreadPool) -> Result<Self, RecordError> {
        let mut loaded = Self::with(world, threads, None);
        let robots = loaded.world().robots().map(|(_, class, name)| (class.to_owned(), name.to_owned()));
        for (class, name) in robots.collect::<Vec<_>>() {
            loaded.enter(Init { class_name: format!("USARBot.{class}"), name, ..Init::default() })?;
        }
        Ok(loaded)
    }

    /// Opens a session with a pawn. Returns the pawn, if it came, and problems.
    fn enter(&mut self, init: Init) -> Result<(Option<PawnId>, Vec<String>), RecordError> {
        let session = self.next_session;
        self.next_session += 1;
        self.sessions.open(session)?;
        let problems = self.take(session, &Request::order(Command::Init(init)))?;
        let pawn = self.sessions.newest(session);
        if pawn.is_none() {
            self.sessions.close(session)?;
        }
        Ok((pawn, problems))
    }

    /// Executes a request of a session. Returns its problems.
    pub(crate) fn take(&mut self, session: SessionId, request: &Request) -> Result<Vec<String>, RecordError> {
        let Self { sessions, readings, .. } = self;
        let time = sessions.world().time();
        let mut keep = |sensed: &Sensed| _ = readings.insert((sensed.robot, sensed.sensor), (time, sensed.clone()));
        let problems = sessions.take(session, request, &mut keep)?;
        Ok(problems.iter().map(ToString::to_string).collect())
    }

    /// Executes a request of a session. Returns the lines that answer it.
    pub(crate) fn ask(&mut self, session: SessionId, request: &Request) -> PyResult<Vec<String>> {
        let Self { sessions, readings, .. } = self;
        let time = sessions.world().time();
        let mut keep = |sensed: &Sensed| _ = readings.insert((sensed.robot, sensed.sensor), (time, sensed.clone()));
        let (problems, answers) = sessions.ask(session, request, &mut keep).map_err(error::log)?;
        if problems.is_empty() {
            return Ok(answers);
        }
        Err(error::command(problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")))
    }

    /// Returns the session of the world's controller. It enters the world with its first order. In a loaded world it takes over the one of
    /// the saved world.
    fn controller(&mut self) -> PyResult<SessionId> {
        if let Some(session) = self.controller.and_then(|pawn| self.sessions.owner(pawn)) {
            return Ok(session);
        }
        let [class_name, name] = [Init::CONTROLLER[0], "Python"].map(str::to_owned);
        let (pawn, problems) = self.enter(Init { class_name, name, ..Init::default() }).map_err(error::log)?;
        self.controller = pawn;
        let session = pawn.and_then(|pawn| self.sessions.owner(pawn));
        session.ok_or_else(|| error::command(problems.join("; ")))
    }

    /// Advances by at most this many steps, until the signals are due. Returns the number of steps taken.
    fn advance(&mut self, steps: u64) -> Result<u64, RecordError> {
        let Self { sessions, readings, threads, view, .. } = self;
        let start = Instant::now();
        let interval = if view.is_some() { SHOWN_INTERVAL } else { SIGNAL_INTERVAL };
        threads.run(|| {
            for step in 0..steps {
                // The step's readings are of its end.
                let time = sessions.world().time() + sessions.world().time_step();
                sessions.step(&mut |sensed| {
                    readings.insert((sensed.robot, sensed.sensor), (time, sensed.clone()));
                })?;
                if start.elapsed() >= interval {
                    return Ok(step + 1);
                }
            }
            Ok(steps)
        })
    }

    /// Shows the present on the page of the world, if it has one and a frame is due or `must` be shown.
    fn show_now(&mut self, must: bool) {
        let Self { sessions, readings, view, shown, .. } = self;
        if let Some(view) = view.as_mut().filter(|view| must || view.is_due()) {
            let snapshot = sessions.world().snapshot();
            let fresh = readings.values().filter(|(time, _)| *time > *shown).cloned().collect();
            *shown = snapshot.time;
            view.show(Moment { snapshot, readings: fresh });
        }
    }

    pub(crate) fn stage(&mut self) -> Arc<Stage> {
        let def = self.sessions.world().def();
        self.stage.get_or_insert_with(|| Arc::new(Stage::new(def))).clone()
    }

    /// Returns the object with a name.
    fn object(&self, name: &str) -> PyResult<ObjectId> {
        let known = self.world().objects().find(|object| object.def.solid.name.eq_ignore_ascii_case(name));
        known.map(|object| object.id).ok_or_else(|| {
            let names: Vec<String> = self.world().objects().map(|object| object.def.solid.name.clone()).collect();
            if names.is_empty() {
                return error::command(format_args!("unknown object `{name}`: the world has no movable objects"));
            }
            let known = names::listed(names.iter().map(String::as_str));
            error::command(format_args!("unknown object `{name}`: expected one of {known}"))
        })
    }
}
