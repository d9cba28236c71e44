//! The thread that owns the world. It takes events, steps at its pace, and sends messages to connections.

use std::any::Any;
use std::collections::BTreeMap;
use std::panic::AssertUnwindSafe;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, TryRecvError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use page_protocol::{Actor, ClientStatus, Control, LeagueStatus, RobotStatus, Status};
use scene::PawnId;
use sessions::{News, SessionId, Sessions};
use sim_core::World;
use thread_pool::ThreadPool;
use tokio::sync::oneshot;
use tracing::{info, warn};

use crate::access::budget::{Budget, Budgets, Spent};
use crate::config::{AvailableMap, Config};
use crate::error::ServeError;
use crate::subscribers::live::Broadcast;
use crate::subscribers::log::Recording;
use crate::subscribers::publisher::Publisher;
use crate::subscribers::subscriber::{Subscriber, Told};
use crate::world::client::Client;
use crate::world::event::Event;
use crate::world::fit::fit;
use crate::world::guests::{Credit, Guests, IDLE_SHARE, SHARE};
use crate::world::pace::{self, Pace};
use crate::world::question::{Health, Question};
use crate::world::restart::{Restart, Restarts};
use crate::world::saved::Saving;

/// Longest wait for an event, so that frames and logs are published in time even when simulated time crawls.
const MAX_WAIT: Duration = Duration::from_millis(2);
/// Most events taken between two steps, so that a flood of them cannot stop time.
const MAX_EVENTS_A_STEP: usize = 1024;
/// Requests of one segment that are executed together, if all but the first take less than [`LONG_SLICE`]. A question in the segment of
/// an INIT is then answered before the first reading at any speed.
const REQUESTS_TOGETHER: usize = 16;
/// Time for one client's requests before another client has its turn.
const SLICE: Duration = Duration::from_millis(1);
/// Time for the requests behind the first of a slice, however few they are. Each may have an answer of 256 KiB.
const LONG_SLICE: Duration = Duration::from_millis(4);
/// Most time for requests that steps can earn while the world is always due. A longer step earns its whole duration.
const MAX_CREDIT: Duration = Duration::from_millis(4);
/// Time after which the cost of a client counts half.
const FORGETTING_INTERVAL: Duration = Duration::from_millis(100);
/// Least time over which the real-time factor is measured. Shorter times are too uneven.
const MEASURE_INTERVAL: Duration = Duration::from_millis(500);
/// Longest time in which robots are put back together after a restart. The rest of them are put back as INIT lines are executed, so that
/// steps go on.
const PUT_BACK_TOGETHER: Duration = Duration::from_millis(20);
/// Interval between reports of dropped lines and repeated problems.
const REPORT_INTERVAL: Duration = Duration::from_secs(5);

/// Starts the thread. It ends on request, or when every sender of events is gone. `gone` is dropped when the thread ends, even
/// by a panic.
pub(crate) fn spawn(
    config: Config,
    world: World,
    budgets: Budgets,
    events: Receiver<Event>,
    live: Broadcast,
    others: Vec<Box<dyn Subscriber>>,
    gone: oneshot::Sender<()>,
) -> Result<JoinHandle<Result<(), ServeError>>, ServeError> {
    let Config { maps, panic_at, real_time_factor, report_errors, log, ros2_log, unnamed_log, threads, .. } = config;
    let pool = Arc::new(threads.clone());
    let world = world.on_threads(pool.clone());
    let saved_as = unnamed_log.with_extension("json");
    let mut recording = Recording::new(world.options(), real_time_factor, ros2_log, unnamed_log);
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
            audience: Audience {
                publisher: Publisher::new(recording, live, others, now),
                clients: BTreeMap::new(),
                is_time_up: false,
            },
            timing: Timing { speed: real_time_factor, paused: false, steps: 0 },
            pace: Pace::new(real_time_factor, now, world.time()),
            work: Work::new(now, world.time()),
            sessions: Sessions::new(world),
            threads: pool,
            guests: Guests::default(),
            guests_credits: [SHARE, IDLE_SHARE].map(|share| Credit::new(share, now)),
            restarts: Restarts::new(now),
            maps,
            panic_at,
            resets: 0,
            saves: 0,
            report_errors,
            credit: 0.0,
            forgotten: now,
            controls: Budget::default(),
            budgets,
            saving: Saving::default(),
            saved_as,
        };
        // After a panic the world is only read.
        let result = std::panic::catch_unwind(AssertUnwindSafe(|| server.run(&events)));
        server.end(result.err())
    };
    thread.spawn(move || threads.run(run)).map_err(ServeError::Start)
}

struct Server {
    sessions: Sessions,
    audience: Audience,
    /// Threads of the world's steps.
    threads: Arc<ThreadPool>,
    /// Requests of everyone who does not drive.
    guests: Guests,
    /// Time for guests while a step is due, and while none is.
    guests_credits: [Credit; 2],
    restarts: Restarts,
    /// Simulated time at which it panics, s, to test the report of a defect.
    panic_at: Option<f64>,
    /// Maps that a viewer can change to.
    maps: Vec<AvailableMap>,
    timing: Timing,
    pace: Pace,
    work: Work,
    /// Number of times that the world started over.
    resets: u64,
    /// Number of times that the world was saved.
    saves: u64,
    report_errors: bool,
    /// Time that clients' requests may take while a step is due, s. Steps earn as much as they take, so that neither side can hold up the
    /// other. Below 0 requests took more, which steps repay first.
    credit: f64,
    /// Time when the costs of clients and guests were last halved.
    forgotten: Instant,
    /// Limit of controls in the log.
    controls: Budget,
    /// Limits of what is logged about clients.
    budgets: Budgets,
    saving: Saving,
    /// File of saves that a viewer starts; it gets a number if the file exists.
    saved_as: PathBuf,
}

/// All that hear of the world: its clients, logs and viewers.
struct Audience {
    publisher: Publisher,
    clients: BTreeMap<SessionId, Client>,
    /// True if the time of a league is up, until the world is paused for it.
    is_time_up: bool,
}

impl Audience {
    /// Passes news on.
    fn hear(&mut self, world: &World, news: News) {
        let Self { publisher, clients, is_time_up } = self;
        if let News::Wrong { session, line, problems } = news {
            let client = clients.get_mut(&session);
            let warnings = client.map(|client| client.warn_of(line, problems, Instant::now()));
            warnings.iter().flatten().for_each(|warning| publisher.tell(world, &Told::Warning(warning)));
        }
        news.warning().iter().for_each(|text| warn!("{text}"));
        publisher.news(world, &news);
        match news {
            News::Sent { session, line, is_periodic, .. } => {
                if let Some(client) = clients.get(&session) {
                    client.outbox().push(line, is_periodic);
                }
            }
            News::TimeUp(_) => *is_time_up = true,
            News::Received { .. }
            | News::Wrong { .. }
            | News::Came(_)
            | News::Sensed(_)
            | News::Left(_)
            | News::Closed(_)
            | News::Lost(_)
            | News::Restored { .. }
            | News::Scored(_) => {}
        }
    }
}

/// Timing of the world's steps.
#[derive(Clone, Copy, PartialEq)]
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

/// The work of the world's thread so far.
struct Work {
    steps: u64,
    /// Real time that steps took.
    took: Duration,
    /// Periodic lines dropped for clients that have left.
    dropped: u64,
    /// Simulated seconds per real second, as last measured.
    real_time_factor: f64,
    /// Real and simulated time, s, of that measurement.
    measured: (Instant, f64),
}

impl Work {
    fn new(now: Instant, time: f64) -> Self {
        Self { steps: 0, took: Duration::ZERO, dropped: 0, real_time_factor: 0.0, measured: (now, time) }
    }

    /// Counts a step.
    fn add(&mut self, took: Duration) {
        self.steps += 1;
        self.took += took;
    }

    /// Measures the real-time factor, if the last time is long enough ago. A world that started over counts from 0.
    fn measure(&mut self, now: Instant, time: f64) {
        let (then, before) = self.measured;
        let elapsed = now.duration_since(then);
        if elapsed >= MEASURE_INTERVAL {
            self.real_time_factor = (time - before).max(0.0) / elapsed.as_secs_f64();
            self.measured = (now, time);
        }
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
            self.audience.publisher.set_now(now);
            self.publish();
            self.forget(now);
            self.restart(now);
            self.save(now);
            self.work.measure(now, self.sessions.world().time());
            if now.duration_since(report) >= REPORT_INTERVAL {
                let Audience { publisher, clients, .. } = &mut self.audience;
                let repeated: Vec<String> = clients.values_mut().flat_map(Client::report).collect();
                repeated.iter().for_each(|text| publisher.tell(self.sessions.world(), &Told::Warning(text)));
                report = now;
            }
            let wait = self.wait(now);
            let idle_until = now + wait.min(MAX_WAIT);
            let [may_answer, may_answer_idly] = self.guests_credits.each_mut().map(|credit| credit.earn(now));
            if wait.is_zero() {
                self.work_on_credit(now);
                if may_answer {
                    self.answer_guests(None);
                }
                self.step();
            } else if !(self.work(idle_until) | (may_answer_idly && self.answer_guests(Some(idle_until)))) {
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
    fn end(mut self, panic: Option<Box<dyn Any + Send>>) -> Result<(), ServeError> {
        self.conclude();
        let (Audience { publisher, clients, .. }, world) = (self.audience, self.sessions.world());
        clients.values().for_each(|client| client.outbox().close());
        let Some(panic) = panic else {
            publisher.end(world, None);
            return Ok(());
        };
        let text = panic.downcast_ref::<String>().map(String::as_str).or(panic.downcast_ref::<&str>().copied());
        let reason = text.unwrap_or("without a message").to_owned();
        let report = match publisher.end(world, Some(&reason)) {
            Some(Ok(path)) => format!("`usarsim log replay {}` reproduces it", path.display()),
            Some(Err(error)) => format!("no report could be written: {error}"),
            None => "no journal was kept".to_owned(),
        };
        Err(ServeError::WorldPanicked { time: world.time(), reason, report })
    }

    fn step(&mut self) {
        let start = Instant::now();
        let Self { sessions, audience, .. } = self;
        assert!(self.panic_at.is_none_or(|time| sessions.world().time() < time), "asked to panic");
        sessions.step(&mut |world, news| audience.hear(world, news));
        audience.publisher.stepped(sessions.world());
        if std::mem::take(&mut audience.is_time_up) {
            self.end_round();
        }
        let took = start.elapsed();
        self.work.add(took);
        self.credit = (self.credit + took.as_secs_f64()).min(MAX_CREDIT.max(took).as_secs_f64());
    }

    /// Pauses the world because the time of its league is up.
    fn end_round(&mut self) {
        (self.timing.paused, self.timing.steps) = (true, 0);
        self.tell(&Told::Warning("the time is up: the world is paused"));
        self.tell(&Told::Changed);
    }

    /// Tells every team's points at the end of the world, if it has a league.
    fn conclude(&mut self) {
        if let Some(standings) = self.sessions.standings() {
            self.tell(&Told::Result(&standings));
        }
    }

    /// Tells subscribers of an event.
    fn tell(&mut self, event: &Told) {
        self.audience.publisher.tell(self.sessions.world(), event);
    }

    /// Returns the wait before the next step. A paused world takes only the requested steps.
    fn wait(&mut self, now: Instant) -> Duration {
        if self.timing.paused {
            let stepping = self.timing.steps > 0;
            self.timing.steps = self.timing.steps.saturating_sub(1);
            return if stepping { Duration::ZERO } else { MAX_WAIT };
        }
        let world = self.sessions.world();
        if let Some(reached) = self.pace.lag_report(now, world.time()) {
            let text = pace::lag_text(reached, self.timing.speed);
            warn!("{text}");
            self.audience.publisher.tell(world, &Told::Note(&text));
        }
        self.pace.wait(now, world.time())
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
                let (id, dialect) = (opened.id, opened.dialect);
                let Self { sessions, audience, budgets, .. } = self;
                // A new client starts at the mean cost, so that leaving and returning gains nothing.
                let clients = audience.clients.len().max(1) as u32;
                let mean = audience.clients.values().map(Client::cost).sum::<Duration>() / clients;
                let mut client = Client::new(opened, budgets.clone());
                client.outbox().set_paced(self.timing.is_real());
                client.add_cost(mean);
                audience.clients.insert(id, client);
                sessions.open(id, dialect, self.report_errors, &mut |world, news| audience.hear(world, news));
                audience.publisher.tell(sessions.world(), &Told::Changed);
            }
            Event::Requests(id, requests, turn) => {
                if let Some(client) = self.audience.clients.get_mut(&id) {
                    client.take(requests, turn);
                }
            }
            Event::Closed(id) => {
                if let Some(client) = self.audience.clients.get_mut(&id) {
                    client.close();
                    self.end_if_done(id);
                }
            }
            Event::Ask(guest, question, turn) => self.guests.add(guest, question, turn),
            Event::Stop => return Err(Stop),
        }
        Ok(())
    }

    /// Answers guests until none waits, their time is spent or the next step is due. `idle_until` is that moment; without it a step is due
    /// now. Returns false if there was nothing to do.
    fn answer_guests(&mut self, idle_until: Option<Instant>) -> bool {
        let (mut answered, mut may_answer) = (false, true);
        while may_answer && idle_until.is_none_or(|end| Instant::now() < end) {
            let Some((guest, question, _turn)) = self.guests.next() else { break };
            let start = Instant::now();
            self.answer(question);
            let took = start.elapsed();
            self.guests.charge(guest, took);
            answered = true;
            let [due, idle] = &mut self.guests_credits;
            may_answer = if idle_until.is_some() { idle } else { due }.spend(took);
        }
        answered
    }

    /// Answers a guest. It may have left.
    fn answer(&mut self, question: Question) {
        let Self { sessions, audience, .. } = self;
        match question {
            Question::Actors(answer) => _ = answer.send(audience.publisher.actors(sessions.world())),
            Question::Obstacles([from, to], answer) => _ = answer.send(sessions.world_mut().obstacles(from, to)),
            Question::Health(answer) => _ = answer.send(self.health()),
            Question::Standings(answer) => _ = answer.send(sessions.standings()),
            Question::Fit(wanted, answer) => _ = answer.send(fit(wanted, sessions.world_mut())),
            Question::Control(control, actor) => self.control(control, actor),
        }
    }

    fn health(&self) -> Health {
        let Self { sessions, audience, timing, work, resets, .. } = self;
        let world = sessions.world();
        Health {
            simulated: world.time(),
            real_time_factor: work.real_time_factor,
            speed: timing.speed,
            paused: timing.paused,
            steps: work.steps,
            step_seconds: work.took.as_secs_f64(),
            unsettled_steps: world.unsettled_steps(),
            robots: world.robots().count(),
            clients: audience.clients.len(),
            dropped_lines: work.dropped + audience.clients.values().map(Client::dropped).sum::<u64>(),
            resets: *resets,
        }
    }

    /// Halves the costs of clients and guests from time to time.
    fn forget(&mut self, now: Instant) {
        if now.duration_since(self.forgotten) >= FORGETTING_INTERVAL {
            self.forgotten = now;
            self.audience.clients.values_mut().for_each(Client::forget_half);
            self.guests.forget_half();
        }
    }

    /// Executes requests while a step is due, within the time that steps have earned.
    fn work_on_credit(&mut self, now: Instant) {
        if self.credit > 0.0 {
            self.work(now + Duration::from_secs_f64(self.credit));
            self.credit -= now.elapsed().as_secs_f64();
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
        worked
    }

    /// Returns the cheapest client that has requests and room for the answers.
    fn next_client(&self) -> Option<SessionId> {
        let ready = self.audience.clients.iter().filter(|(_, client)| client.is_ready());
        ready.min_by_key(|(_, client)| client.cost()).map(|(&id, _)| id)
    }

    fn execute_slice(&mut self, id: SessionId) {
        let start = Instant::now();
        let mut count = 0;
        let Self { sessions, audience, restarts, .. } = self;
        let put_back = audience.clients.get_mut(&id).and_then(Client::next_put_back);
        let is_put_back = put_back.is_some();
        if let Some(init) = put_back {
            sessions.take(id, &init, &mut |world, news| audience.hear(world, news));
            restarts.add_cost(start.elapsed());
        }
        // An INIT is the first request of its slice. Its time is not that of the requests behind it.
        let mut first_done = start;
        while !is_put_back
            && (start.elapsed() < SLICE || count < REQUESTS_TOGETHER && first_done.elapsed() < LONG_SLICE)
        {
            let Some(client) = audience.clients.get_mut(&id) else { break };
            let Some(request) = client.next_request() else { break };
            client.note_line();
            sessions.take(id, &request, &mut |world, news| audience.hear(world, news));
            count += 1;
            if count == 1 {
                first_done = Instant::now();
            }
            // A segment with many robots must not hold up other clients.
            if audience.clients.get(&id).is_some_and(Client::is_next_init) {
                break;
            }
        }
        if let Some(client) = audience.clients.get_mut(&id) {
            client.add_cost(start.elapsed());
        }
        self.end_if_done(id);
    }

    /// Ends a session after its last request is executed, if the client has left.
    fn end_if_done(&mut self, id: SessionId) {
        let Self { sessions, audience, work, .. } = self;
        if !audience.clients.get(&id).is_some_and(Client::is_over) {
            return;
        }
        if let Some(mut client) = audience.clients.remove(&id) {
            client.report().iter().for_each(|text| audience.publisher.tell(sessions.world(), &Told::Warning(text)));
            client.outbox().close();
            work.dropped += client.dropped();
        }
        sessions.close(id, &mut |world, news| audience.hear(world, news));
    }

    /// Executes a viewer's request to the world, and tells everyone who made it.
    fn control(&mut self, control: Control, actor: Actor) {
        let now = Instant::now();
        let Actor(name) = &actor;
        if let Spent::Granted { .. } = self.controls.spend(now) {
            info!(?control, by = name, time = %format_args!("{:.3}", self.sessions.world().time()), "control");
        }
        let before = self.timing;
        let was_paused = before.paused;
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
                self.audience.clients.values().for_each(|client| client.outbox().set_paced(self.timing.is_real()));
                let speed = if speed == 0.0 { "as fast as possible".to_owned() } else { format!("{speed}") };
                Some(format!("set the real-time factor to {speed}"))
            }
            Control::Map(_) | Control::Save if self.sessions.world().def().league.is_some() => {
                let text = "not done: a league stays on its map, and its points cannot be saved";
                self.tell(&Told::Notice(text));
                None
            }
            Control::Remove(robot) => self.remove(PawnId(robot)).map(|name| format!("removed robot {robot} ({name})")),
            Control::Reset => {
                self.restarts.ask(Restart { map: None, actor });
                return;
            }
            Control::Map(name) => {
                self.change_map(&name, actor);
                return;
            }
            Control::Save => {
                self.saving.ask();
                None
            }
            Control::Record(on) => {
                if !on && let Some(standings) = self.sessions.standings() {
                    self.tell(&Told::Standings(&standings));
                }
                self.audience.publisher.record(self.sessions.world(), on);
                None
            }
        };
        if let Some(done) = done {
            self.tell_done(&actor, &done);
        }
        if self.timing != before {
            self.pace = Pace::new(self.timing.speed, now, self.sessions.world().time());
        }
        self.tell(&Told::Changed);
    }

    /// Tells everyone what somebody did.
    fn tell_done(&mut self, Actor(name): &Actor, done: &str) {
        let text = format!("{name} {done}");
        self.tell(&Told::Note(&text));
        self.tell(&Told::Notice(&text));
    }

    /// Removes a robot from the world. Returns its class and name, or `None` if there is no such robot.
    fn remove(&mut self, robot: PawnId) -> Option<String> {
        let Self { sessions, audience, .. } = self;
        let named = sessions.world().robots().find(|(id, ..)| *id == robot);
        let Some(name) = named.map(|(_, class, name)| format!("{class} {name}").trim().to_owned()) else {
            let text = format!("not done: there is no robot {}", robot.0);
            self.tell(&Told::Notice(&text));
            return None;
        };
        sessions.remove(robot, &mut |world, news| audience.hear(world, news));
        Some(name)
    }

    /// Requests a restart on another map, if one has that name.
    fn change_map(&mut self, name: &str, actor: Actor) {
        match self.maps.iter().find(|map| map.name == name) {
            Some(map) => self.restarts.ask(Restart { map: Some(map.clone()), actor }),
            None => {
                let names: Vec<&str> = self.maps.iter().map(|map| map.name.as_str()).collect();
                let text = format!("no map `{name}`: expected {}", names.join(", "));
                self.tell(&Told::Notice(&text));
            }
        }
    }

    /// Begins a save if one is due.
    fn save(&mut self, now: Instant) {
        if self.saving.is_due(now)
            && let Err(error) = self.saving.start(now, &self.saved_as, self.sessions.world())
        {
            self.tell(&Told::Notice(&error));
        }
    }

    /// Restarts the world once a fresh one is ready.
    fn restart(&mut self, now: Instant) {
        match self.restarts.poll(now, self.sessions.world()) {
            None => {}
            Some(Err(error)) => self.tell(&Told::Notice(&error)),
            Some(Ok((Restart { map, actor }, fresh))) => {
                if !self.start_over(now, fresh) {
                    return;
                }
                let done = map.map_or("reset the world".to_owned(), |map| format!("changed the map to {}", map.name));
                self.tell_done(&actor, &done);
                self.pace = Pace::new(self.timing.speed, Instant::now(), self.sessions.world().time());
            }
        }
    }

    /// Replaces the world with a fresh one. Connected clients get their robots back at their first poses, in the same order. Robots that
    /// take long wait for their client's turn. Returns false if a log does not allow it.
    fn start_over(&mut self, now: Instant, fresh: World) -> bool {
        if let Err(error) = self.audience.publisher.may_start_over() {
            self.tell(&Told::Warning(&format!("not reset: {error}")));
            return false;
        }
        self.conclude();
        let Self { sessions, audience, .. } = self;
        let (old, inits) = sessions.replace_world(fresh.on_threads(self.threads.clone()));
        audience.publisher.start_over(&old, sessions.world());
        self.resets += 1;
        let start = Instant::now();
        for (id, init) in inits {
            if start.elapsed() < PUT_BACK_TOGETHER {
                sessions.take(id, &init, &mut |world, news| audience.hear(world, news));
            } else if let Some(client) = audience.clients.get_mut(&id) {
                client.put_back(init);
            }
        }
        drop(old);
        self.restarts.add_cost(now.elapsed());
        true
    }

    /// Publishes what is due by the clock.
    fn publish(&mut self) {
        if let Some(saved) = self.saving.news() {
            self.saves += u64::from(saved.is_ok());
            let (Ok(text) | Err(text)) = saved;
            self.tell(&Told::Notice(&text));
        }
        let Self { audience, sessions, timing, work, resets, saves, .. } = self;
        let (Audience { publisher, clients, .. }, world) = (audience, sessions.world());
        let robot = |(id, class, name): (PawnId, &str, &str)| RobotStatus {
            id: id.0,
            class: class.to_owned(),
            name: name.to_owned(),
            connection: sessions.owner(id),
            battery: world.battery(id),
        };
        let client = |(&connection, client): (&SessionId, &Client)| ClientStatus {
            connection,
            peer: client.peer(),
            lines: client.lines(),
            dropped: client.dropped(),
            waiting_bytes: client.outbox().waiting_bytes(),
        };
        publisher.publish(world, |recording| Status {
            real_time_factor: work.real_time_factor,
            speed: timing.speed,
            paused: timing.paused,
            scene: 0,
            objects: 0,
            viewers: 0,
            resets: *resets,
            saves: *saves,
            unsettled_steps: world.unsettled_steps(),
            recording: recording.map(|path| path.display().to_string()),
            league: sessions.standings().map(LeagueStatus::new),
            robots: world.robots().map(robot).collect(),
            clients: clients.iter().map(client).collect(),
        });
    }
}
