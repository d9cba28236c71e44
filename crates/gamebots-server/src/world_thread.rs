//! The thread that owns the world: takes events, steps at its pace, hands messages to the connections.

use std::any::Any;
use std::collections::BTreeMap;
use std::panic::AssertUnwindSafe;
use std::path::Path;
use std::sync::mpsc::{Receiver, RecvTimeoutError, TryRecvError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use gamebots_proto::message::Message;
use recorder::{Record, WireLine};
use sim_core::{Executed, LostRobot, RobotId, World};
use tokio::sync::oneshot;
use tracing::{info, warn};

use crate::connection::{ConnectionId, Event, Request};
use crate::control::Control;
use crate::foxglove_server::FoxgloveServer;
use crate::journal::Journal;
use crate::live::{Broadcast, ClientStatus, Line, RobotStatus, Status};
use crate::owners::Owners;
use crate::pace::Pace;
use crate::recording::Recording;
use crate::session::{Budget, Session, Spent};
use crate::{Config, ServeError};

/// Longest wait for an event, so that frames and logs are handed over in time even when simulated time crawls.
const MAX_WAIT: Duration = Duration::from_millis(2);
/// Events taken between two steps, so that a flood of them cannot stop time.
const MAX_EVENTS_A_STEP: usize = 1024;
/// Requests of one segment that are executed together whatever they cost, so that a question in INIT's own segment is
/// answered before the first reading at any speed.
const REQUESTS_TOGETHER: usize = 16;
/// How long one client's requests are executed before another client has its turn.
const SLICE: Duration = Duration::from_millis(1);
/// Time for requests that can be saved up while a world that is due all the time steps; more only when one step takes more.
const MAX_CREDIT: Duration = Duration::from_millis(4);
/// What a client has cost counts half after this long.
const FORGETTING_INTERVAL: Duration = Duration::from_millis(100);
/// How often dropped lines are reported.
const DROP_REPORT_INTERVAL: Duration = Duration::from_secs(5);

/// Starts the thread. It ends when it is told to or when every sender of events is gone; `gone` is dropped when it ends,
/// however it does.
pub(crate) fn spawn(
    config: Config,
    events: Receiver<Event>,
    live: Broadcast,
    foxglove: Option<FoxgloveServer>,
    gone: oneshot::Sender<()>,
) -> Result<JoinHandle<Result<(), ServeError>>, ServeError> {
    let Config { world, options, real_time_factor, report_errors, log, ros2_log, unnamed_log, .. } = config;
    let world = World::new(world, options);
    let mut recording = Recording::new(options, real_time_factor, ros2_log, unnamed_log, foxglove);
    if let Some(path) = log {
        recording.start(&path, &world)?;
    }
    let thread = std::thread::Builder::new().name("world".to_owned());
    let run = move || {
        let _gone = gone;
        let now = Instant::now();
        let mut server = Server {
            recording,
            live,
            timing: Timing { speed: real_time_factor, paused: false, steps: 0 },
            pace: Pace::new(real_time_factor, now, world.time()),
            world,
            resets: 0,
            report_errors,
            sessions: BTreeMap::new(),
            owners: Owners::default(),
            credit: Duration::ZERO,
            forgotten: now,
            controls: Budget::default(),
            journal: Journal::default(),
        };
        // What is left of the world after a panic is only read.
        let result = std::panic::catch_unwind(AssertUnwindSafe(|| server.run(&events)));
        server.end(result.err())
    };
    thread.spawn(run).map_err(ServeError::Start)
}

struct Server {
    world: World,
    recording: Recording,
    live: Broadcast,
    timing: Timing,
    pace: Pace,
    /// How often the world began anew.
    resets: u64,
    report_errors: bool,
    sessions: BTreeMap<ConnectionId, Session>,
    owners: Owners,
    /// Time that requests may take while the next step is due: as much as steps have taken, so that neither side can hold
    /// up the other.
    credit: Duration,
    /// When what clients have cost was last halved.
    forgotten: Instant,
    /// Controls that are logged.
    controls: Budget,
    journal: Journal,
}

/// How time is to pass.
struct Timing {
    /// Simulated seconds a real second; 0 is as fast as possible.
    speed: f64,
    paused: bool,
    /// Steps to be taken while it is paused.
    steps: u32,
}

/// The server is to stop.
struct Stop;

impl Server {
    fn run(&mut self, events: &Receiver<Event>) {
        let mut drop_report = Instant::now();
        // Nobody can tell it anything any more, or somebody has told it to stop.
        while self.take_events(events).is_ok() {
            let now = Instant::now();
            if let Some(due) = self.live.due(now) {
                let status = due.status.then(|| self.status());
                self.live.publish(now, &self.world, status);
            }
            self.recording.publish(now, &self.world);
            for news in self.recording.news() {
                self.live.say(&news);
                self.live.changed(now);
            }
            if now.duration_since(drop_report) >= DROP_REPORT_INTERVAL {
                self.sessions.values_mut().for_each(Session::report_dropped);
                drop_report = now;
            }
            let wait = self.wait(now);
            if wait.is_zero() {
                self.work_on_credit(now);
                self.step();
            } else if !self.work(now + wait.min(MAX_WAIT)) {
                let taken = match events.recv_timeout(wait.min(MAX_WAIT)) {
                    Ok(event) => self.take(event),
                    Err(RecvTimeoutError::Timeout) => Ok(()),
                    Err(RecvTimeoutError::Disconnected) => Err(Stop),
                };
                if taken.is_err() {
                    break;
                }
            }
        }
    }

    /// Ends logs and connections; after a panic with a report of it.
    fn end(mut self, panic: Option<Box<dyn Any + Send>>) -> Result<(), ServeError> {
        self.sessions.values().for_each(|session| session.outbox().close());
        let Some(panic) = panic else {
            self.recording.stop(&self.world);
            return Ok(());
        };
        let text = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
        let reason = text.unwrap_or("without a message").to_owned();
        self.recording.stop_broken(&self.world);
        let report = match self.journal.write(Path::new(""), &self.world, &reason) {
            Ok(path) => format!("`usarsim log replay {}` makes it again", path.display()),
            Err(error) => format!("no report could be written: {error}"),
        };
        Err(ServeError::WorldPanicked { time: self.world.time(), reason, report })
    }

    fn step(&mut self) {
        let start = Instant::now();
        for (robot, message) in self.world.step() {
            self.live.scan(&self.world, robot, &message);
            if let Some(owner) = self.owners.of(robot) {
                self.send(owner, Some(robot.0), &message);
            }
        }
        for LostRobot { id, class, name } in self.world.take_lost() {
            self.live.forget(id);
            self.recording.record(&self.world, || Record::Left(id.0));
            let text = format!("robot {} ({class} {name}) is removed: its state is not finite any more", id.0);
            warn!("{text}");
            self.say(&text);
        }
        self.recording.record_states(&self.world);
        let took = start.elapsed();
        self.credit = (self.credit + took).min(MAX_CREDIT.max(took));
    }

    /// How long the next step has to wait; a paused world takes only the steps that were asked for.
    fn wait(&mut self, now: Instant) -> Duration {
        if self.timing.paused {
            let stepping = self.timing.steps > 0;
            self.timing.steps = self.timing.steps.saturating_sub(1);
            return if stepping { Duration::ZERO } else { MAX_WAIT };
        }
        if let Some(reached) = self.pace.lag_report(now, self.world.time()) {
            warn!(reached = format!("{reached:.2}"), "behind its pace: the real-time factor of the last 5 s");
            self.say(&format!("behind its pace: real-time factor {reached:.2} of the last 5 s"));
        }
        self.pace.wait(now, self.world.time())
    }

    fn take_events(&mut self, events: &Receiver<Event>) -> Result<(), Stop> {
        for _ in 0..MAX_EVENTS_A_STEP {
            match events.try_recv() {
                Ok(event) => self.take(event)?,
                Err(TryRecvError::Empty) => break,
                Err(TryRecvError::Disconnected) => return Err(Stop),
            }
        }
        Ok(())
    }

    fn take(&mut self, event: Event) -> Result<(), Stop> {
        match event {
            Event::Opened(id, peer, outbox) => {
                // It begins behind those that cost little, so that leaving and coming again gains nothing.
                let clients = self.sessions.len().max(1) as u32;
                let mean = self.sessions.values().map(Session::cost).sum::<Duration>() / clients;
                let mut session = Session::new(id, peer, outbox, self.report_errors);
                session.add_cost(mean);
                self.sessions.insert(id, session);
                let greeting = self.world.greeting();
                self.send(id, None, &greeting);
                self.live.changed(Instant::now());
            }
            Event::Requests(id, requests, turn) => {
                if let Some(session) = self.sessions.get_mut(&id) {
                    session.take(requests, turn);
                }
            }
            Event::Closed(id) => {
                if let Some(session) = self.sessions.get_mut(&id) {
                    session.close();
                    self.end_if_done(id);
                }
            }
            Event::Control(control, _turn) => self.control(control),
            Event::Stop => return Err(Stop),
        }
        Ok(())
    }

    /// Executes requests while a step is due, for as long as steps have earned.
    fn work_on_credit(&mut self, now: Instant) {
        if !self.credit.is_zero() {
            self.work(now + self.credit);
            self.credit = self.credit.saturating_sub(now.elapsed());
        }
    }

    /// Executes what clients have sent until there is nothing left or time is up, the client first that has cost least; false
    /// when there was nothing to do.
    fn work(&mut self, deadline: Instant) -> bool {
        let mut worked = false;
        while let Some(id) = self.next_client() {
            worked = true;
            self.execute_slice(id);
            if Instant::now() >= deadline {
                break;
            }
        }
        if worked && self.forgotten.elapsed() >= FORGETTING_INTERVAL {
            self.forgotten = Instant::now();
            self.sessions.values_mut().for_each(Session::forget_half);
        }
        worked
    }

    /// The client whose requests are next: with something to execute and room for the answers.
    fn next_client(&self) -> Option<ConnectionId> {
        let ready = self.sessions.iter().filter(|(_, session)| session.is_ready());
        ready.min_by_key(|(_, session)| session.cost()).map(|(&id, _)| id)
    }

    fn execute_slice(&mut self, id: ConnectionId) {
        let start = Instant::now();
        let mut count = 0;
        while count < REQUESTS_TOGETHER || start.elapsed() < SLICE {
            let Some(request) = self.sessions.get_mut(&id).and_then(Session::next_request) else { break };
            self.execute(id, &request);
            count += 1;
            // Many robots in one segment are not to hold up others.
            if self.sessions.get(&id).is_some_and(Session::is_next_init) {
                break;
            }
        }
        if let Some(session) = self.sessions.get_mut(&id) {
            session.add_cost(start.elapsed());
        }
        self.end_if_done(id);
    }

    /// Ends a session that is over, once everything that the client had sent is executed.
    fn end_if_done(&mut self, id: ConnectionId) {
        if !self.sessions.get(&id).is_some_and(Session::is_over) {
            return;
        }
        if let Some(mut session) = self.sessions.remove(&id) {
            session.report_dropped();
            session.end();
            self.remove_robots(id);
        }
        self.record(Record::Closed(WireLine { connection: id, robot: None, line: String::new() }));
        self.live.changed(Instant::now());
    }

    /// The robots of a connection that has ended leave the world, or only the newest if the world keeps robots.
    fn remove_robots(&mut self, id: ConnectionId) {
        let robots = self.owners.leave(id);
        let kept = if self.world.options().keep_robots { robots.len().saturating_sub(1) } else { 0 };
        for robot in robots.into_iter().skip(kept) {
            self.live.forget(robot);
            self.world.remove(robot);
            self.record(Record::Left(robot.0));
        }
    }

    fn control(&mut self, control: Control) {
        match control {
            Control::Pause(paused) => (self.timing.paused, self.timing.steps) = (paused, 0),
            Control::Step(steps) => {
                self.timing.paused = true;
                self.timing.steps = self.timing.steps.saturating_add(steps);
            }
            Control::Speed(speed) => self.timing.speed = speed,
            Control::Reset => self.reset(),
            Control::Record(true) => match self.recording.start_unnamed(Instant::now(), &self.world) {
                Ok(()) => self.say_recording(),
                Err(error) => self.say(&error.to_string()),
            },
            Control::Record(false) => self.recording.stop(&self.world),
        }
        if let Spent::Granted { .. } = self.controls.spend(Instant::now()) {
            info!(?control, time = self.world.time(), "asked by a viewer");
        }
        self.pace = Pace::new(self.timing.speed, Instant::now(), self.world.time());
        self.live.changed(Instant::now());
    }

    fn say_recording(&mut self) {
        if let Some(path) = self.recording.path() {
            self.live.say(&format!("recording to {}", path.display()));
        }
    }

    /// A fresh world; everyone who is connected gets their robots back where they were first put, in the same order.
    fn reset(&mut self) {
        let now = Instant::now();
        if let Err(error) = self.recording.may_start_over(now) {
            return self.say(&format!("not begun anew: {error}"));
        }
        let fresh = World::new(self.world.scene().clone(), self.world.options());
        let old = std::mem::replace(&mut self.world, fresh);
        if let Err(error) = self.recording.start_over(now, &old, &self.world) {
            self.live.say(&error.to_string());
        }
        self.journal.clear();
        self.resets += 1;
        for (id, init) in self.owners.start_over() {
            self.execute(id, &Request::read(Ok(init)));
        }
        self.live.say("the world began anew");
    }

    fn execute(&mut self, id: ConnectionId, request: &Request) {
        let Request { text, command, problems } = request;
        let pawn = self.owners.newest(id);
        if !text.is_empty() {
            let robot = pawn.map(|robot| robot.0);
            self.record(Record::In(WireLine { connection: id, robot, line: text.clone() }));
            self.publish_line("in", id, robot, text);
        }
        let Some(session) = self.sessions.get_mut(&id) else { return };
        session.note(command.as_ref());
        let mut problems = problems.clone();
        let executed = command.as_ref().map(|command| self.world.execute(pawn, command, &mut problems));
        let Executed { answers, spawned } = executed.unwrap_or_default();
        let (refusals, warnings) = session.refuse(text, &problems, Instant::now());
        if let Some(robot) = spawned {
            self.owners.add(robot, id, text.clone());
            self.live.changed(Instant::now());
        }
        warnings.iter().for_each(|warning| self.say(warning));
        let robot = spawned.or(pawn).map(|robot| robot.0);
        answers.iter().chain(&refusals).for_each(|answer| self.send(id, robot, answer));
    }

    /// Records what happened to the world, for logs and for the report of a panic.
    fn record(&mut self, record: Record) {
        self.journal.add(self.world.time(), record.clone());
        self.recording.record(&self.world, || record);
    }

    fn send(&mut self, id: ConnectionId, robot: Option<u64>, message: &Message) {
        let text = message.write();
        self.recording.record(&self.world, || Record::Out(WireLine { connection: id, robot, line: text.clone() }));
        if self.recording.is_wanted()
            && let Some(sensed) = Record::sensed(robot, message)
        {
            self.recording.record(&self.world, || sensed);
        }
        self.publish_line("out", id, robot, &text);
        if let Some(session) = self.sessions.get(&id) {
            session.outbox().push(text, message.is_periodic());
        }
    }

    fn publish_line(&self, direction: &'static str, connection: ConnectionId, robot: Option<u64>, text: &str) {
        let time = self.world.time();
        self.live.line(|| Line { time, direction, connection, robot, text: text.to_owned() });
    }

    /// Says what is wrong to the log and to viewers.
    fn say(&mut self, warning: &str) {
        self.recording.record(&self.world, || Record::Warning(warning.to_owned()));
        self.live.say(warning);
    }

    fn status(&self) -> Status {
        let robot = |(id, class, name): (RobotId, &str, &str)| RobotStatus {
            id: id.0,
            class: class.to_owned(),
            name: name.to_owned(),
            connection: self.owners.of(id),
            battery: self.world.battery(id),
        };
        let client = |(&connection, session): (&ConnectionId, &Session)| ClientStatus {
            connection,
            peer: session.peer().to_owned(),
            lines: session.lines(),
            dropped: session.dropped(),
            waiting_bytes: session.outbox().waiting_bytes(),
        };
        Status {
            real_time_factor: 0.0,
            speed: self.timing.speed,
            paused: self.timing.paused,
            resets: self.resets,
            recording: self.recording.path().map(|path| path.display().to_string()),
            robots: self.world.robots().map(robot).collect(),
            clients: self.sessions.iter().map(client).collect(),
        }
    }
}
