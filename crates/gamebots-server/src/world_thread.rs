//! The thread that owns the world: takes events, steps at its pace, hands messages to the connections.

use std::collections::BTreeMap;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use gamebots_proto::Problem;
use gamebots_proto::message::Message;
use recorder::{LogWriter, Record, Recorder, StateTimer, WireLine};
use sim_core::{RobotId, World};
use tokio::sync::mpsc::Receiver;
use tokio::sync::mpsc::error::TryRecvError;
use tokio::sync::oneshot;
use tracing::warn;

use crate::connection::{ConnectionId, Event};
use crate::pace::Pace;
use crate::session::Session;
use crate::{Config, ServeError};

/// Longest sleep, so that commands are taken soon even when simulated time crawls.
const MAX_SLEEP: Duration = Duration::from_millis(2);
/// Events taken between two steps, so that a flood of them cannot stop time.
const MAX_EVENTS_A_STEP: usize = 256;
/// How often dropped lines are reported.
const DROP_REPORT_INTERVAL: Duration = Duration::from_secs(5);

/// Starts the thread. It ends when every sender of events is gone; `gone` is dropped when it ends, however it does.
pub(crate) fn spawn(
    config: Config,
    events: Receiver<Event>,
    gone: oneshot::Sender<()>,
) -> Result<JoinHandle<()>, ServeError> {
    let log = |path| {
        let speed = [("real_time_factor".to_owned(), config.real_time_factor.to_string())];
        let mut log = LogWriter::create(path, &config.world, config.options, &speed)?;
        if config.ros2_log {
            log = log.with_ros2(&config.world)?;
        }
        Recorder::new(log)
    };
    let recorder = config.log.as_deref().map(log).transpose()?;
    let thread = std::thread::Builder::new().name("world".to_owned());
    let run = move || {
        let _gone = gone;
        let Config { world, options, real_time_factor, report_errors, .. } = config;
        let world = World::new(world, options);
        let pace = Pace::new(real_time_factor, Instant::now(), world.time());
        Server { world, recorder, report_errors, sessions: BTreeMap::new(), owners: BTreeMap::new() }.run(events, pace);
    };
    thread.spawn(run).map_err(ServeError::Start)
}

struct Server {
    world: World,
    recorder: Option<Recorder>,
    report_errors: bool,
    sessions: BTreeMap<ConnectionId, Session>,
    /// The connection that each robot reports to.
    owners: BTreeMap<RobotId, ConnectionId>,
}

impl Server {
    fn run(mut self, mut events: Receiver<Event>, mut pace: Pace) {
        let mut drop_report = Instant::now();
        let mut states = StateTimer::default();
        loop {
            if !self.take_events(&mut events) {
                if let Some(recorder) = self.recorder.take() {
                    recorder.finish(self.world.time(), self.world.digest());
                }
                return;
            }
            let now = Instant::now();
            if let Some(reached) = pace.lag_report(now, self.world.time()) {
                warn!(reached = format!("{reached:.2}"), "behind its pace: the real-time factor of the last 5 s");
                self.record(|| {
                    Record::Warning(format!("behind its pace: real-time factor {reached:.2} of the last 5 s"))
                });
            }
            if now.duration_since(drop_report) >= DROP_REPORT_INTERVAL {
                self.sessions.values().for_each(Session::report_dropped);
                drop_report = now;
            }
            let wait = pace.wait(now, self.world.time());
            if !wait.is_zero() {
                if let Some(recorder) = &mut self.recorder {
                    recorder.hand_over();
                }
                std::thread::sleep(wait.min(MAX_SLEEP));
                continue;
            }
            for (robot, message) in self.world.step() {
                if let Some(&owner) = self.owners.get(&robot) {
                    self.send(owner, Some(robot.0), &message);
                }
            }
            self.record_states(&mut states);
        }
    }

    /// Handles what has come; false when nobody can send anything any more.
    fn take_events(&mut self, events: &mut Receiver<Event>) -> bool {
        for _ in 0..MAX_EVENTS_A_STEP {
            match events.try_recv() {
                Ok(event) => self.handle(event),
                Err(TryRecvError::Empty) => return true,
                Err(TryRecvError::Disconnected) => return false,
            }
        }
        true
    }

    fn handle(&mut self, event: Event) {
        match event {
            Event::Opened(id, outbox) => {
                self.sessions.insert(id, Session::new(id, outbox, self.report_errors));
                let greeting = self.world.greeting();
                self.send(id, None, &greeting);
            }
            Event::Lines(id, lines) => lines.into_iter().for_each(|line| self.handle_line(id, line)),
            Event::Closed(id) => {
                let robot = self.newest_robot(id);
                self.record(|| Record::Closed(WireLine { connection: id, robot, line: String::new() }));
                if let Some(session) = self.sessions.remove(&id) {
                    session.report_dropped();
                    session.robots().iter().for_each(|robot| {
                        self.owners.remove(robot);
                    });
                    session.end(&mut self.world);
                }
            }
        }
    }

    fn handle_line(&mut self, id: ConnectionId, line: Result<String, Problem>) {
        if let Ok(text) = &line {
            let robot = self.newest_robot(id);
            self.record(|| Record::In(WireLine { connection: id, robot, line: text.clone() }));
        }
        let Some(session) = self.sessions.get_mut(&id) else { return };
        let (answers, warnings) =
            session.handle(line.as_deref().map_err(Clone::clone), &mut self.world, Instant::now());
        self.owners.extend(session.robots().last().map(|&robot| (robot, id)));
        warnings.into_iter().for_each(|warning| self.record(|| Record::Warning(warning)));
        let robot = self.newest_robot(id);
        answers.iter().for_each(|answer| self.send(id, robot, answer));
    }

    /// The number of the robot that a connection's commands go to.
    fn newest_robot(&self, id: ConnectionId) -> Option<u64> {
        self.sessions.get(&id).and_then(|session| session.robots().last()).map(|robot| robot.0)
    }

    fn send(&mut self, id: ConnectionId, robot: Option<u64>, message: &Message) {
        let text = message.write();
        self.record(|| Record::Out(WireLine { connection: id, robot, line: text.clone() }));
        if let Some(session) = self.sessions.get(&id) {
            session.outbox().push(text, message.is_periodic());
        }
    }

    fn record_states(&mut self, timer: &mut StateTimer) {
        let Some(recorder) = &mut self.recorder else { return };
        let time = self.world.time();
        timer.due(&self.world).into_iter().for_each(|state| recorder.record(time, state));
    }

    fn record(&mut self, record: impl FnOnce() -> Record) {
        if let Some(recorder) = &mut self.recorder {
            recorder.record(self.world.time(), record());
        }
    }
}
