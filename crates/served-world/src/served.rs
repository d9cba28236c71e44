//! The served world, and one turn of its loop.

use std::collections::BTreeMap;

use sessions::{News, SessionId, Sessions};
use sim_core::World;
use tracing::warn;
use web_time::{Duration, Instant};

use crate::audience::{Audience, Told};
use crate::budget::{Budget, Budgets};
use crate::client::Client;
use crate::event::{Event, Segment};
use crate::guests::{Credit, Guests, IDLE_SHARE, SHARE};
use crate::pace::{self, Pace};
use crate::performance::Performance;
use crate::restart::{Restarts, Saving, Task};

/// Longest wait for an event, so that frames and logs are published in time even when simulated time crawls.
const MAX_WAIT: Duration = Duration::from_millis(2);
/// Most events taken in a turn, so that a flood of them cannot stop time.
const MAX_EVENTS: usize = 1024;
/// Most time for requests that steps can earn while the world is always due. A longer step earns its whole duration.
const MAX_CREDIT: Duration = Duration::from_millis(4);
/// Time after which the cost of a client counts half.
const FORGETTING_INTERVAL: Duration = Duration::from_millis(100);
/// Interval between reports of dropped lines and repeated problems.
const REPORT_INTERVAL: Duration = Duration::from_secs(5);

/// Settings of a served world.
pub struct Settings {
    /// Simulated seconds per real second; 0 is as fast as possible.
    pub real_time_factor: f64,
    /// True to tell clients what was wrong with their lines.
    pub report_errors: bool,
    /// Limits of what is logged about clients.
    pub budgets: Budgets,
}

/// A world with its clients and guests. `A` hears all that happens.
pub struct ServedWorld<A> {
    pub(crate) sessions: Sessions,
    pub(crate) circle: Circle<A>,
    /// Requests of everyone who does not drive.
    pub(crate) guests: Guests,
    /// Time for guests while a step is due, and while none is.
    pub(crate) guests_credits: [Credit; 2],
    pub(crate) restarts: Restarts,
    pub(crate) saving: Saving,
    pub(crate) settings: Settings,
    pub(crate) timing: Timing,
    pub(crate) pace: Pace,
    pub(crate) performance: Performance,
    /// Number of times that the world started over.
    pub(crate) resets: u64,
    /// Number of times that the world was saved.
    pub(crate) saves: u64,
    /// Time that clients' requests may take while a step is due, s. Steps earn as much as they take, so that neither side can hold up the
    /// other. Below 0 requests took more, which steps repay first.
    pub(crate) credit: f64,
    /// Time when the costs of clients and guests were last halved.
    forgotten: Instant,
    /// Time of the last report of dropped lines and repeated problems.
    reported: Instant,
    /// Limit of controls in the log.
    pub(crate) controls: Budget,
    /// Long work that has become due in this turn.
    pub(crate) tasks: Vec<Task>,
    /// The clock. A turn reads it often, as it measures what its work costs.
    pub(crate) clock: Box<dyn Fn() -> Instant + Send>,
}

/// Everybody who hears of the world: its clients and its audience.
pub(crate) struct Circle<A> {
    pub(crate) audience: A,
    pub(crate) clients: BTreeMap<SessionId, Client>,
    /// True if the time of a league is up, until the world is paused for it.
    pub(crate) is_time_up: bool,
    /// Real time of the turn.
    pub(crate) now: Instant,
}

impl<A: Audience> Circle<A> {
    /// Passes news on.
    pub(crate) fn hear(&mut self, world: &World, news: News) {
        let Self { audience, clients, is_time_up, now } = self;
        if let News::Wrong { session, line, problems } = news {
            let client = clients.get_mut(&session);
            let warnings = client.map(|client| client.warn_of(line, problems, *now));
            warnings.iter().flatten().for_each(|warning| audience.hear(world, &Told::Warning(warning)));
        }
        news.warning().iter().for_each(|text| warn!("{text}"));
        audience.hear(world, &Told::News(&news));
        match news {
            News::Sent { session, line, is_periodic, .. } => {
                if let Some(client) = clients.get(&session) {
                    client.push(line, is_periodic);
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
pub(crate) struct Timing {
    /// Simulated seconds per real second; 0 is as fast as possible.
    pub(crate) speed: f64,
    pub(crate) paused: bool,
    /// Steps to take while paused.
    pub(crate) steps: u32,
}

impl Timing {
    /// True if simulated time is no faster than the clock.
    pub(crate) fn is_real(&self) -> bool {
        self.speed > 0.0 && self.speed <= 1.0
    }
}

/// Something that a turn asks of its caller.
pub struct Next {
    /// Latest time of the next turn. An event is a reason for an earlier one.
    pub wake: Instant,
    /// Long work for other threads, whose outcomes are events.
    pub tasks: Vec<Task>,
}

/// The world must end.
pub(crate) struct Stop;

impl<A: Audience> ServedWorld<A> {
    /// Serves a world. Every turn reads the clock.
    pub fn new(world: World, settings: Settings, audience: A, clock: Box<dyn Fn() -> Instant + Send>) -> Self {
        let now = clock();
        let speed = settings.real_time_factor;
        Self {
            circle: Circle { audience, clients: BTreeMap::new(), is_time_up: false, now },
            timing: Timing { speed, paused: false, steps: 0 },
            pace: Pace::new(speed, now, world.time()),
            performance: Performance::new(now, world.time()),
            sessions: Sessions::new(world),
            guests: Guests::default(),
            guests_credits: [SHARE, IDLE_SHARE].map(|share| Credit::new(share, now)),
            restarts: Restarts::new(now),
            saving: Saving::default(),
            settings,
            resets: 0,
            saves: 0,
            credit: 0.0,
            forgotten: now,
            reported: now,
            controls: Budget::default(),
            tasks: Vec::new(),
            clock,
        }
    }

    /// Returns the world.
    pub fn world(&self) -> &World {
        self.sessions.world()
    }

    /// Returns the audience.
    pub fn audience(&self) -> &A {
        &self.circle.audience
    }

    /// Returns the audience, to change it.
    pub fn audience_mut(&mut self) -> &mut A {
        &mut self.circle.audience
    }

    /// Takes events, and takes a step if one is due; else executes requests until one is. Events beyond the limit of a turn are left.
    /// Returns `None` when the world is to end.
    pub fn turn(&mut self, events: &mut dyn Iterator<Item = Event>) -> Option<Next> {
        let now = (self.clock)();
        self.circle.now = now;
        self.circle.audience.set_now(now);
        for event in events.take(MAX_EVENTS) {
            self.take(event).ok()?;
        }
        self.publish();
        self.forget(now);
        self.begin_restart(now);
        self.begin_save(now);
        self.performance.measure(now, self.sessions.world().time());
        self.report(now);
        let wait = self.wait(now);
        let mut wake = now + wait.min(MAX_WAIT);
        let [may_answer, may_answer_idly] = self.guests_credits.each_mut().map(|credit| credit.earn(now));
        if wait.is_zero() {
            self.work_on_credit(now);
            if may_answer {
                self.answer_guests(None);
            }
            self.step();
        } else if self.work(wake) | (may_answer_idly && self.answer_guests(Some(wake))) {
            // More may have come meanwhile.
            wake = now;
        }
        Some(Next { wake, tasks: std::mem::take(&mut self.tasks) })
    }

    /// Ends the world: tells the last points and closes all outboxes. Returns the audience and the world.
    pub fn end(mut self) -> (A, World) {
        self.conclude();
        self.circle.clients.values().for_each(Client::close_outbox);
        (self.circle.audience, self.sessions.into_world())
    }

    fn step(&mut self) {
        let start = (self.clock)();
        let Self { sessions, circle, .. } = self;
        sessions.step(&mut |world, news| circle.hear(world, news));
        circle.audience.stepped(sessions.world());
        if std::mem::take(&mut circle.is_time_up) {
            self.end_round();
        }
        let took = (self.clock)() - start;
        self.performance.add(took);
        self.credit = (self.credit + took.as_secs_f64()).min(MAX_CREDIT.max(took).as_secs_f64());
    }

    /// Pauses the world because the time of its league is up.
    fn end_round(&mut self) {
        (self.timing.paused, self.timing.steps) = (true, 0);
        self.tell(&Told::Warning("the time is up: the world is paused"));
        self.tell(&Told::Changed);
    }

    /// Tells every team's points at the end of the world, if it has a league.
    pub(crate) fn conclude(&mut self) {
        if let Some(standings) = self.sessions.standings() {
            self.tell(&Told::Result(&standings));
        }
    }

    /// Tells the audience of an event.
    pub(crate) fn tell(&mut self, event: &Told) {
        self.circle.audience.hear(self.sessions.world(), event);
    }

    /// Returns the wait before the next step. A paused world takes only the requested steps.
    fn wait(&mut self, now: Instant) -> Duration {
        if self.timing.paused {
            let stepping = self.timing.steps > 0;
            self.timing.steps = self.timing.steps.saturating_sub(1);
            return if stepping { Duration::ZERO } else { MAX_WAIT };
        }
        let time = self.sessions.world().time();
        if let Some(reached) = self.pace.lag_report(now, time) {
            let text = pace::lag_text(reached, self.timing.speed);
            warn!("{text}");
            self.tell(&Told::Note(&text));
        }
        self.pace.wait(now, time)
    }

    fn take(&mut self, event: Event) -> Result<(), Stop> {
        match event {
            Event::Opened(opened) => {
                let (id, dialect, is_program) = (opened.id, opened.dialect, opened.outbox.is_none());
                let Self { sessions, circle, settings, .. } = self;
                // A new client starts at the mean cost, so that leaving and returning gains nothing.
                let clients = circle.clients.len().max(1) as u32;
                let mean = circle.clients.values().map(Client::cost).sum::<Duration>() / clients;
                let mut client = Client::new(opened, settings.budgets.clone());
                client.set_paced(self.timing.is_real());
                client.add_cost(mean);
                circle.clients.insert(id, client);
                if is_program {
                    sessions.open_program(id);
                } else {
                    sessions.open(id, dialect, settings.report_errors, &mut |world, news| circle.hear(world, news));
                }
                self.tell(&Told::Changed);
            }
            Event::Requests(id, Segment { requests, answer, turn }) => {
                if let Some(client) = self.circle.clients.get_mut(&id) {
                    client.take(requests, answer, turn);
                }
            }
            Event::Closed(id) => {
                if let Some(client) = self.circle.clients.get_mut(&id) {
                    client.close();
                    self.end_if_done(id);
                }
            }
            Event::Ask(guest, question, turn) => self.guests.add(guest, question, turn),
            Event::Made(fresh) => self.restart(fresh),
            Event::Saved(outcome) => self.saved(&outcome),
            Event::Stop => return Err(Stop),
        }
        Ok(())
    }

    /// Halves the costs of clients and guests from time to time.
    fn forget(&mut self, now: Instant) {
        if now.duration_since(self.forgotten) >= FORGETTING_INTERVAL {
            self.forgotten = now;
            self.circle.clients.values_mut().for_each(Client::forget_half);
            self.guests.forget_half();
        }
    }

    /// Reports dropped lines and repeated problems from time to time.
    fn report(&mut self, now: Instant) {
        if now.duration_since(self.reported) >= REPORT_INTERVAL {
            self.reported = now;
            let clients = self.circle.clients.values_mut();
            let repeated: Vec<String> = clients.flat_map(|client| client.report(now)).collect();
            repeated.iter().for_each(|text| self.tell(&Told::Warning(text)));
        }
    }
}
