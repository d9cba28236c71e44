//! Services of lines beside the controllers': truth for referees (USARTruth.uc) and positions for wireless simulators
//! (ComServerInterface.uc).
//!
//! A connection asks the world one question at a time. Questions change nothing, so logs do not have them.
//!
//! The rows of truth leave in one write, and the end of them a moment later. MetricTool asks how many bytes are there at the first one and reads
//! so many, again and again, until fewer come. Without a shorter rest it waits for 4 s.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::Sender;
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use gamebots_proto::Framing;
use gamebots_proto::ports::{Place, PositionsQuestion, Row, Stand, TRUTH_END, TruthQuestion, positions, rows};
use nalgebra::Vector3;
use scene::{Pose, Standings};
use sim_core::{Actor, ActorKind, World};
use tokio::io::AsyncReadExt;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{Semaphore, oneshot};
use tokio::time::{sleep, timeout};

use crate::access::login::LoginQueue;
use crate::messages::control::{self, Control};
use crate::messages::fit::{Ask, Fit};
use crate::page::metrics::Health;
use crate::ports::controllers::{Event, FirstBytes, UNENDED_LINE, send};
use crate::run::accept;
use crate::world::guests::{Guest, Kind};

/// Time between the rows of truth and their end.
const BEFORE_END: Duration = Duration::from_millis(20);
/// Bytes read at once.
const READ_BYTES: usize = 4096;

/// A service of lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Port {
    /// Poses of pawns and objects.
    Truth,
    /// Robots, and the obstacles between them.
    Positions,
}

/// A guest's request to the world's thread, and the way of its answer.
pub(crate) enum Question {
    /// Everything with a pose.
    Actors(oneshot::Sender<Arc<Actors>>),
    /// The number of walls between two points, m.
    Obstacles([[f64; 3]; 2], oneshot::Sender<usize>),
    /// The state of the server in numbers.
    Health(oneshot::Sender<Health>),
    /// Every team's points; none without a league.
    Standings(oneshot::Sender<Option<Standings>>),
    /// Room for a robot.
    Fit(Ask, oneshot::Sender<Fit>),
    /// A change of the world, by a viewer.
    Control(Control, control::Actor),
}

/// Everything with a pose at a time.
pub(crate) struct Actors {
    /// Simulated time, s.
    time: f64,
    all: Vec<Actor>,
    /// Answer to GETPOS, once it was asked for.
    stands: OnceLock<String>,
}

impl Actors {
    /// Returns the simulated time, s.
    pub(crate) fn time(&self) -> f64 {
        self.time
    }

    pub(crate) fn of(world: &World) -> Self {
        Self { time: world.time(), all: world.actors(), stands: OnceLock::new() }
    }
}

/// The way of one guest to the world. It has one question at a time there.
#[derive(Clone)]
pub(crate) struct Inquiry {
    guest: Guest,
    events: Sender<Event>,
    turns: Arc<Semaphore>,
}

impl Inquiry {
    pub(crate) fn new(kind: Kind, events: Sender<Event>) -> Self {
        /// Number of the next guest.
        static NEXT: AtomicU64 = AtomicU64::new(0);
        let guest = Guest { kind, number: NEXT.fetch_add(1, Ordering::Relaxed) };
        Self { guest, events, turns: Arc::new(Semaphore::new(1)) }
    }

    /// Asks the world. `None` if it has ended.
    pub(crate) async fn ask<T>(&self, question: impl FnOnce(oneshot::Sender<T>) -> Question) -> Option<T> {
        let (answer, answered) = oneshot::channel();
        self.send(question(answer)).await?;
        answered.await.ok()
    }

    /// Sends a request to the world. `None` if it has ended.
    pub(crate) async fn send(&self, question: Question) -> Option<()> {
        let turn = self.turns.clone().acquire_owned().await.ok()?;
        self.events.send(Event::Ask(self.guest, question, turn)).ok()
    }
}

/// Serves a port of lines to a number of clients at once until the future is dropped; more wait.
pub(crate) async fn serve(
    port: Port,
    listener: TcpListener,
    logins: LoginQueue,
    most: usize,
    events: Sender<Event>,
    stall_timeout: Duration,
) {
    accept(listener, logins, most, |accepted, place| {
        let inquiry = Inquiry::new(port.kind(), events.clone());
        async move {
            let _place = place;
            converse(port, accepted.stream, &inquiry, stall_timeout).await;
        }
    })
    .await;
}

/// Answers a client until it leaves, speaks HTTP or does not read.
async fn converse(port: Port, mut stream: TcpStream, inquiry: &Inquiry, stall_timeout: Duration) {
    // An answer must not wait for the next one (Nagle's algorithm).
    let _ = stream.set_nodelay(true);
    let mut framing = match port {
        Port::Truth => Framing::with_empty_lines(),
        Port::Positions => Framing::default(),
    };
    let (mut buffer, mut first_bytes) = (vec![0; READ_BYTES], FirstBytes::default());
    loop {
        let read = stream.read(&mut buffer);
        let result = if framing.ends_with_block() { timeout(UNENDED_LINE, read).await.ok() } else { Some(read.await) };
        let (lines, is_over) = match result {
            Some(Ok(count)) if count > 0 => {
                let bytes = buffer.get(..count).unwrap_or_default();
                first_bytes.add(bytes);
                (framing.push(bytes), false)
            }
            None => (framing.finish().into_iter().collect(), false),
            Some(_) => (framing.finish().into_iter().collect(), true),
        };
        if first_bytes.are_http() {
            return;
        }
        // A line that is too long has no answer.
        for line in lines.into_iter().flatten() {
            let Some(answer) = port.answer(&line, inquiry).await else { return };
            let (rows, end) = answer.split_at(answer.strip_suffix(TRUTH_END).map_or(answer.len(), str::len));
            if !send(&mut stream, rows.as_bytes(), stall_timeout).await {
                return;
            }
            if !rows.is_empty() && !end.is_empty() {
                sleep(BEFORE_END).await;
            }
            if !send(&mut stream, end.as_bytes(), stall_timeout).await {
                return;
            }
        }
        if is_over {
            return;
        }
    }
}

impl Port {
    fn kind(self) -> Kind {
        match self {
            Self::Truth => Kind::Truth,
            Self::Positions => Kind::Positions,
        }
    }

    /// Answers a line. `None` if the world has ended.
    async fn answer(self, line: &str, inquiry: &Inquiry) -> Option<String> {
        match self {
            Self::Truth => Some(truth(&TruthQuestion::read(line), &*inquiry.ask(Question::Actors).await?)),
            Self::Positions => answer_positions(line, inquiry).await,
        }
    }
}

fn truth(question: &TruthQuestion, actors: &Actors) -> String {
    let TruthQuestion { class, name } = question;
    let is_asked = |actor: &&Actor| actor.is_a(class) && (name.is_empty() || actor.name == *name);
    rows(actors.all.iter().filter(is_asked).map(|actor| {
        let (location, rotation) = scene::position_and_rotation(&actor.pose);
        Row {
            name: &actor.name,
            class: &actor.class,
            time: actors.time as f32,
            location: location.map(|number| number as f32),
            // The zero of an angle has no sign.
            rotation: rotation.map(|number| (number + 0.0) as f32),
        }
    }))
}

/// Answers a line of the port of positions; with an empty text if it has no answer.
async fn answer_positions(line: &str, inquiry: &Inquiry) -> Option<String> {
    let between = match PositionsQuestion::read(line) {
        None => return Some(String::new()),
        Some(PositionsQuestion::Nothing) => return Some("\r\n".to_owned()),
        Some(PositionsQuestion::Positions) => return Some(inquiry.ask(Question::Actors).await?.stands().to_owned()),
        Some(PositionsQuestion::Obstacles(between)) => between,
    };
    let actors = inquiry.ask(Question::Actors).await?;
    let point = |place: Place| match place {
        Place::Point(point) => Some(point),
        Place::Robot(name) => actors.robots().find(|robot| robot.called == name).map(|robot| point_of(&robot.pose)),
    };
    let [from, to] = between.places().map(point);
    let count = match from.zip(to) {
        Some((from, to)) => inquiry.ask(|answer| Question::Obstacles([from, to], answer)).await? as f32,
        None => -1.0,
    };
    Some(between.answer(count))
}

fn point_of(pose: &Pose) -> [f64; 3] {
    Vector3::into(pose.translation.vector)
}

impl Actors {
    /// Returns names and places of the robots, m, each with true if its battery is empty.
    pub(crate) fn places(&self) -> impl Iterator<Item = (String, ([f64; 3], bool))> {
        self.robots().map(|robot| (robot.called.clone(), (point_of(&robot.pose), robot.battery_is_empty)))
    }

    fn robots(&self) -> impl Iterator<Item = &Actor> {
        self.all.iter().filter(|actor| actor.kind == ActorKind::Robot)
    }

    /// Returns the answer to GETPOS. Clients that ask in the same step share it.
    fn stands(&self) -> &str {
        self.stands.get_or_init(|| {
            let robots = self.robots().map(|Actor { called, pose, battery_is_empty, .. }| Stand {
                name: called,
                location: point_of(pose).map(|number| number as f32),
                battery_is_empty: *battery_is_empty,
            });
            positions(&robots.collect::<Vec<_>>())
        })
    }
}
