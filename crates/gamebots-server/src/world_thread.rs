//! The thread that owns the world. It takes events, steps at its pace, and sends messages to connections.

use std::any::Any;
use std::collections::{BTreeMap, BTreeSet};
use std::panic::AssertUnwindSafe;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, TryRecvError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use gamebots_proto::message::{self, Message, Nfo, WrittenLine};
use gamebots_proto::{Command, Dialect};
use scene::{MapDef, WorldDef};
use sim_core::{Executed, LostRobot, PawnId, Report, World};
use tokio::sync::oneshot;
use tracing::{info, warn};

use crate::connection::{ConnectionId, Event, Request};
use crate::control::{Actor, Control};
use crate::foxglove_server::FoxgloveServer;
use crate::live::{Broadcast, ClientStatus, RobotStatus, Status};
use crate::owners::Owners;
use crate::pace::{self, Pace};
use crate::publisher::Publisher;
use crate::recording::Recording;
use crate::saved::Saving;
use crate::session::{Budget, Session, Spent};
use crate::{Config, ServeError};

/// Longest wait for an event, so that frames and logs are published in time even when simulated time crawls.
const MAX_WAIT: Duration = Duration::from_millis(2);
/// Most events taken between two steps, so that a flood of them cannot stop time.
const MAX_EVENTS_A_STEP: usize = 1024;
/// Requests of one segment that are executed together, however much time they take. A question in the segment of an INIT is
/// then answered before the first reading at any speed.
const REQUESTS_TOGETHER: usize = 16;
/// Time for one client's requests before another client has its turn.
const SLICE: Duration = Duration::from_millis(1);
/// Most time for requests that steps can earn while the world is always due. A longer step earns its whole duration.
const MAX_CREDIT: Duration = Duration::from_millis(4);
/// Time after which the cost of a client counts half.
const FORGETTING_INTERVAL: Duration = Duration::from_millis(100);
/// Interval between reports of dropped lines and repeated problems.
const REPORT_INTERVAL: Duration = Duration::from_secs(5);

/// Starts the thread. It ends on request, or when every sender of events is gone. `gone` is dropped when the thread ends, even
/// by a panic.
pub(crate) fn spawn(
    config: Config,
    events: Receiver<Event>,
    live: Broadcast,
    foxglove: Option<FoxgloveServer>,
    gone: oneshot::Sender<()>,
) -> Result<JoinHandle<Result<(), ServeError>>, ServeError> {
    let Config {
        world,
        maps,
        options,
        real_time_factor,
        report_errors,
        log,
        ros2_log,
        unnamed_log,
        threads,
        saved,
        pictures,
        ..
    } = config;
    let world = match saved {
        Some(saved) => World::load(world, &saved)?,
        None => World::new(world, options),
    };
    let world = world.on_threads(Arc::new(threads.clone()));
    let options = world.options();
    let orphans = world.pawns().map(|(id, ..)| id).collect();
    let saved_as = unnamed_log.with_extension("json");
    let mut recording = Recording::new(options, real_time_factor, ros2_log, unnamed_log, foxglove);
    if let Some(path) = log {
        recording.start(&path, &world)?;
        if let Some(numbered) = recording.path().filter(|it| *it != path) {
            warn!("{} exists and is kept: recording to {}", path.display(), numbered.display());
        }
    }
    let thread = std::thread::Builder::new().name("world".to_owned());
    let run = move || {
        let _gone = gone;
        let now = Instant::now();
        let mut server = Server {
            publisher: Publisher::new(recording, live, &world, pictures),
            timing: Timing { speed: real_time_factor, paused: false, steps: 0 },
            pace: Pace::new(real_time_factor, now, world.time()),
            world,
            maps,
            resets: 0,
            saves: 0,
            report_errors,
            sessions: BTreeMap::new(),
            owners: Owners::default(),
            credit: Duration::ZERO,
            forgotten: now,
            controls: Budget::default(),
            saving: Saving::default(),
            saved_as,
            orphans,
        };
        // After a panic the world is only read.
        let result = std::panic::catch_unwind(AssertUnwindSafe(|| server.run(&events)));
        server.end(result.err())
    };
    thread.spawn(move || threads.run(run)).map_err(ServeError::Start)
}

struct Server {
    world: World,
    /// Maps that a viewer can change to.
    maps: Vec<MapDef>,
    publisher: Publisher,
    timing: Timing,
    pace: Pace,
    /// Number of times that the world started over.
    resets: u64,
    /// Number of times that the world was saved.
    saves: u64,
    report_errors: bool,
    sessions: BTreeMap<ConnectionId, Session>,
    owners: Owners,
    /// Time that requests may take while a step is due. Steps earn as much as they take, so that neither side can hold up the
    /// other.
    credit: Duration,
    /// Time when the clients' costs were last halved.
    forgotten: Instant,
    /// Limit of controls in the log.
    controls: Budget,
    saving: Saving,
    /// File of saves that a viewer starts; it gets a number if the file exists.
    saved_as: PathBuf,
    /// Pawns of the file that the world was loaded from, until a client takes them over.
    orphans: BTreeSet<PawnId>,
}

/// Timing of the world's steps.
struct Timing {
    /// Simulated seconds per real second; 0 is as fast as possible.
    speed: f64,
    paused: bool,
    /// Steps to take while paused.
    steps: u32,
}

impl Timing {
    /// True if simulated time is no faster than the clock.
    fn is_real(&self) -> bool {
        self.speed > 0.0 && self.speed <= 1.0
    }
}

/// The server must stop.
struct Stop;

impl Server {
    fn run(&mut self, events: &Receiver<Event>) {
        let mut report = Instant::now();
        // An error means that every sender is gone, or that the server must stop.
        while self.take_events(events).is_ok() {
            let now = Instant::now();
            self.publish(now);
            if now.duration_since(report) >= REPORT_INTERVAL {
                let repeated: Vec<String> = self.sessions.values_mut().flat_map(Session::report).collect();
                repeated.iter().for_each(|text| self.publisher.warn(&self.world, text));
                report = now;
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

    /// Ends logs and connections. After a panic, also writes a report of it.
    fn end(self, panic: Option<Box<dyn Any + Send>>) -> Result<(), ServeError> {
        self.sessions.values().for_each(|session| session.outbox().close());
        let Some(panic) = panic else {
            self.publisher.end(&self.world);
            return Ok(());
        };
        let text = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
        let reason = text.unwrap_or("without a message").to_owned();
        let report = match self.publisher.end_broken(&self.world, &reason) {
            Ok(path) => format!("`usarsim log replay {}` reproduces it", path.display()),
            Err(error) => format!("no report could be written: {error}"),
        };
        Err(ServeError::WorldPanicked { time: self.world.time(), reason, report })
    }

    fn step(&mut self) {
        let start = Instant::now();
        let mut reports = self.world.step().into_iter().peekable();
        while let Some(&(robot, _)) = reports.peek() {
            let own = std::iter::from_fn(|| reports.next_if(|(next, _)| *next == robot));
            let own: Vec<Report> = own.map(|(_, report)| report).collect();
            self.report(robot, own);
        }
        for lost in self.world.take_lost() {
            self.report_lost(&lost);
        }
        for (name, fault) in self.world.take_restored() {
            let text = format!("object {name} is put back where the map has it: {fault}");
            warn!("{text}");
            self.publisher.warn(&self.world, &text);
        }
        self.publisher.stepped(&self.world);
        let took = start.elapsed();
        self.credit = (self.credit + took).min(MAX_CREDIT.max(took));
    }

    /// Tells everyone about a robot that the world has removed. Its client is told if it asked for errors.
    fn report_lost(&mut self, LostRobot { id, class, name, fault }: &LostRobot) {
        self.publisher.left(&self.world, *id);
        let text = format!("robot {} ({class} {name}) is removed: {fault}", id.0);
        warn!("{text}");
        self.publisher.warn(&self.world, &text);
        self.publisher.changed(Instant::now());
        let Some(owner) = self.owners.of(*id) else { return };
        if self.sessions.get(&owner).is_some_and(Session::reports_errors) {
            self.send(owner, None, &[Message::Nfo(Nfo::Error(text))]);
        }
    }

    /// Returns the wait before the next step. A paused world takes only the requested steps.
    fn wait(&mut self, now: Instant) -> Duration {
        if self.timing.paused {
            let stepping = self.timing.steps > 0;
            self.timing.steps = self.timing.steps.saturating_sub(1);
            return if stepping { Duration::ZERO } else { MAX_WAIT };
        }
        if let Some(reached) = self.pace.lag_report(now, self.world.time()) {
            let text = pace::lag_text(reached, self.timing.speed);
            warn!("{text}");
            self.publisher.note(&self.world, &text);
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
            Event::Opened(opened) => {
                let id = opened.id;
                // A new client starts at the mean cost, so that leaving and returning gains nothing.
                let clients = self.sessions.len().max(1) as u32;
                let mean = self.sessions.values().map(Session::cost).sum::<Duration>() / clients;
                let mut session = Session::new(opened, self.report_errors);
                session.outbox().set_paced(self.timing.is_real());
                session.add_cost(mean);
                self.sessions.insert(id, session);
                let greeting = self.world.greeting();
                self.send(id, None, &[greeting]);
                self.publisher.changed(Instant::now());
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
            Event::Control(control, actor, _turn) => self.control(control, &actor),
            Event::Fit(ask, answer, _turn) => {
                // The page may have left.
                let _ = answer.send(ask.answer(&mut self.world));
            }
            Event::Stop => return Err(Stop),
        }
        Ok(())
    }

    /// Executes requests while a step is due, within the time that steps have earned.
    fn work_on_credit(&mut self, now: Instant) {
        if !self.credit.is_zero() {
            self.work(now + self.credit);
            self.credit = self.credit.saturating_sub(now.elapsed());
        }
    }

    /// Executes clients' requests until none is left or the deadline has passed, the cheapest client first. Returns false if
    /// there was nothing to do.
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

    /// Returns the cheapest client that has requests and room for the answers.
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
            // A segment with many robots must not hold up other clients.
            if self.sessions.get(&id).is_some_and(Session::is_next_init) {
                break;
            }
        }
        if let Some(session) = self.sessions.get_mut(&id) {
            session.add_cost(start.elapsed());
        }
        self.end_if_done(id);
    }

    /// Ends a session after its last request is executed, if the client has left.
    fn end_if_done(&mut self, id: ConnectionId) {
        if !self.sessions.get(&id).is_some_and(Session::is_over) {
            return;
        }
        if let Some(mut session) = self.sessions.remove(&id) {
            session.report().iter().for_each(|text| self.publisher.warn(&self.world, text));
            session.outbox().close();
            self.remove_robots(id);
        }
        self.publisher.closed(&self.world, id);
    }

    /// Removes the robots of a connection that has ended. If the world keeps robots, only the newest is removed.
    fn remove_robots(&mut self, id: ConnectionId) {
        let robots = self.owners.leave(id);
        let kept = if self.world.options().keep_robots { robots.len().saturating_sub(1) } else { 0 };
        for robot in robots.into_iter().skip(kept) {
            self.world.remove(robot);
            self.publisher.left(&self.world, robot);
        }
    }

    /// Executes a viewer's request to the world, and tells everyone who made it.
    fn control(&mut self, control: Control, Actor(actor): &Actor) {
        let now = Instant::now();
        if let Spent::Granted { .. } = self.controls.spend(now) {
            info!(?control, by = actor, time = self.world.time(), "control");
        }
        let was_paused = self.timing.paused;
        let done = match control {
            Control::Pause(paused) => {
                (self.timing.paused, self.timing.steps) = (paused, 0);
                let done = if paused { "paused the world" } else { "resumed the world" };
                (paused != was_paused).then(|| done.to_owned())
            }
            Control::Step(steps) => {
                self.timing.paused = true;
                self.timing.steps = self.timing.steps.saturating_add(steps);
                (!was_paused).then(|| "paused the world to step".to_owned())
            }
            Control::Speed(speed) => {
                self.timing.speed = speed;
                self.sessions.values().for_each(|session| session.outbox().set_paced(self.timing.is_real()));
                let speed = if speed == 0.0 { "as fast as possible".to_owned() } else { format!("{speed}") };
                Some(format!("set the real-time factor to {speed}"))
            }
            Control::Reset => {
                let fresh = self.world.anew();
                self.start_over(now, fresh).then(|| "reset the world".to_owned())
            }
            Control::Map(name) => self.change_map(now, &name).then(|| format!("changed the map to {name}")),
            Control::Save => {
                if let Err(error) = self.saving.start(&self.saved_as, &self.world) {
                    self.publisher.announce(now, &error);
                }
                None
            }
            Control::Record(on) => {
                self.publisher.record(now, &self.world, on);
                None
            }
        };
        if let Some(done) = done {
            self.publisher.announce(now, &format!("{actor} {done}"));
        }
        self.pace = Pace::new(self.timing.speed, now, self.world.time());
        self.publisher.changed(now);
    }

    /// Changes to a fresh world on another map. Returns false if no map has that name, or a log does not allow it.
    fn change_map(&mut self, now: Instant, name: &str) -> bool {
        let Some(map) = self.maps.iter().find(|map| map.name == name) else {
            let names: Vec<&str> = self.maps.iter().map(|map| map.name.as_str()).collect();
            let text = format!("no map `{name}`: expected {}", names.join(", "));
            self.publisher.announce(now, &text);
            return false;
        };
        let world = WorldDef { map: map.clone(), ..self.world.def().clone() };
        let fresh = self.world.anew_with(world);
        self.start_over(now, fresh)
    }

    /// Replaces the world with a fresh one. Connected clients get their robots back at their first poses, in the same order.
    /// Returns false if a log does not allow it.
    fn start_over(&mut self, now: Instant, fresh: World) -> bool {
        if let Err(error) = self.publisher.may_start_over(now) {
            self.publisher.warn(&self.world, &format!("not reset: {error}"));
            return false;
        }
        let old = std::mem::replace(&mut self.world, fresh);
        self.publisher.start_over(now, &old, &self.world);
        self.resets += 1;
        self.orphans.clear();
        for (id, init) in self.owners.start_over() {
            self.execute(id, &Request::read(Ok(init)));
        }
        true
    }

    fn execute(&mut self, id: ConnectionId, request: &Request) {
        let Request { text, command, problems } = request;
        let pawn = self.owners.newest(id);
        if !text.is_empty() {
            self.publisher.received(&self.world, id, pawn, text);
        }
        let adopted = command.as_ref().and_then(|command| self.adopt(command));
        let Some(session) = self.sessions.get_mut(&id) else { return };
        session.note(command.as_ref());
        let mut problems = problems.clone();
        let executed = match adopted {
            Some(pawn) => Some(Executed { spawned: Some(pawn), ..Executed::default() }),
            None => command.as_ref().map(|command| self.world.execute(pawn, command, &mut problems)),
        };
        let Executed { answers, found, spawned } = executed.unwrap_or_default();
        let (refusals, warnings) = session.refuse(text, &problems, Instant::now());
        if let Some(robot) = spawned {
            self.owners.add(robot, id, text.clone());
            self.publisher.changed(Instant::now());
        }
        warnings.iter().for_each(|warning| self.publisher.warn(&self.world, warning));
        self.publish_readings(&answers);
        let mut answers: Vec<Message> = answers.into_iter().filter_map(|answer| self.world.message(answer)).collect();
        let robot = spawned.or(pawn);
        let dialect = self.dialect(id, robot);
        let time = self.world.time() as f32;
        let receipt = command.as_ref().filter(|_| robot.is_some());
        answers.extend(receipt.and_then(|command| Message::receipt(command, found, time, dialect)));
        answers.extend(refusals);
        self.send(id, robot, &answers);
    }

    /// Returns the pawn of a loaded world that an INIT takes over: the first of its class and name that no client has.
    fn adopt(&mut self, command: &Command) -> Option<PawnId> {
        let Command::Init(init) = command else { return None };
        let is_it = |(id, class, name): &(PawnId, &str, &str)| {
            self.orphans.contains(id) && class.eq_ignore_ascii_case(init.class()) && *name == init.name
        };
        let (id, ..) = self.world.pawns().find(is_it)?;
        self.orphans.take(&id)
    }

    /// Returns the dialect of messages to a connection: its listener's, else the one of the robot's class, else UDK.
    fn dialect(&self, id: ConnectionId, robot: Option<PawnId>) -> Dialect {
        let of_robot = || {
            let robot = robot.and_then(|robot| self.world.robot(robot));
            if robot.is_some_and(|def| def.speaks_ut2004) { Dialect::Ut2004 } else { Dialect::Udk }
        };
        self.sessions.get(&id).and_then(Session::dialect).unwrap_or_else(of_robot)
    }

    /// Publishes one robot's readings of a step, and sends its reports to its owner.
    fn report(&mut self, robot: PawnId, reports: Vec<Report>) {
        self.publish_readings(&reports);
        if let Some(owner) = self.owners.of(robot) {
            let messages = reports.into_iter().filter_map(|report| self.world.message(report));
            self.send(owner, Some(robot), &messages.collect::<Vec<_>>());
        }
    }

    fn publish_readings(&mut self, reports: &[Report]) {
        for report in reports {
            if let Report::Sensed(sensed) = report {
                self.publisher.sensed(&self.world, sensed);
            }
        }
    }

    /// Sends messages that belong together. `robot` is the robot that they are about, if any.
    fn send<'a>(&mut self, id: ConnectionId, robot: Option<PawnId>, messages: impl IntoIterator<Item = &'a Message>) {
        for WrittenLine { line, messages } in message::lines(messages, self.dialect(id, robot)) {
            self.publisher.sent(&self.world, id, robot, &line);
            if let Some(session) = self.sessions.get(&id) {
                session.outbox().push(line, messages.iter().all(|message| message.is_periodic()));
            }
        }
    }

    /// Publishes what is due by the clock.
    fn publish(&mut self, now: Instant) {
        if let Some(saved) = self.saving.news() {
            self.saves += u64::from(saved.is_ok());
            let (Ok(text) | Err(text)) = saved;
            self.publisher.announce(now, &text);
        }
        let Self { publisher, world, owners, sessions, timing, resets, saves, .. } = self;
        let robot = |(id, class, name): (PawnId, &str, &str)| RobotStatus {
            id: id.0,
            class: class.to_owned(),
            name: name.to_owned(),
            connection: owners.of(id),
            battery: world.battery(id),
        };
        let client = |(&connection, session): (&ConnectionId, &Session)| ClientStatus {
            connection,
            peer: session.peer().to_owned(),
            lines: session.lines(),
            dropped: session.dropped(),
            waiting_bytes: session.outbox().waiting_bytes(),
        };
        publisher.publish(now, world, |recording| Status {
            real_time_factor: 0.0,
            speed: timing.speed,
            paused: timing.paused,
            scene: 0,
            objects: 0,
            viewers: 0,
            resets: *resets,
            saves: *saves,
            unsettled_steps: world.unsettled_steps(),
            recording: recording.map(|path| path.display().to_string()),
            robots: world.robots().map(robot).collect(),
            clients: sessions.iter().map(client).collect(),
        });
    }
}
