//! Sessions: the clients of a world, without sockets and without a clock.
//!
//! A session opens, sends lines and closes. Its INIT lines spawn pawns; its other lines go to the newest of them. A program's session can
//! address any pawn. [`Sessions`] executes lines and steps in the order in which it is told of them, and returns everything that happens as [`News`]. The server, experiments,
//! replays and the fuzzer drive their worlds by it, so they agree.

mod mistakes;
mod owners;
mod round;

use std::collections::{BTreeMap, BTreeSet};

use gamebots_proto::command::Init;
use gamebots_proto::message::{self, Message, Nfo, WrittenLine};
use gamebots_proto::{Command, Dialect, MAX_BLOCKS, Problem, shown};
use scene::{PawnId, Score, Sensed, Standings};
use sim_core::{Executed, Fault, LostRobot, Report, World};

pub use mistakes::Mistakes;
use owners::Owners;
use round::{Admission, Round};

/// Number of a session.
pub type SessionId = u64;

/// One line, parsed as far as possible.
#[derive(Debug, Clone)]
pub struct Request {
    /// The line as it was sent; empty if it was too long to keep.
    pub text: String,
    /// Its command; `None` if it has none.
    pub command: Option<Command>,
    /// Problems found in the text.
    pub problems: Vec<Problem>,
    /// The pawn that it is for; none for the session's newest. Only programs name one: it may be another session's.
    pub pawn: Option<PawnId>,
}

impl Request {
    /// Parses a line. The world is not needed.
    pub fn read(line: Result<String, Problem>) -> Self {
        match line {
            Ok(text) => {
                let mut problems = Vec::new();
                let command = Command::parse(&text, &mut problems);
                Self { text, command, problems, pawn: None }
            }
            Err(problem) => Self { text: String::new(), command: None, problems: vec![problem], pawn: None },
        }
    }

    /// Creates the request of a program that has a command and no line. Its text is for logs and the other clients' news; nobody parses it.
    pub fn order(command: Command) -> Self {
        let line = command.write();
        let (command, problems) = match line.blocks.len() {
            ..=MAX_BLOCKS => (Some(command), Vec::new()),
            _ => (None, vec![Problem::TooManyBlocks { limit: MAX_BLOCKS }]),
        };
        Self { text: line.to_string(), command, problems, pawn: None }
    }

    /// Addresses it to a pawn.
    #[must_use]
    pub fn to(self, pawn: Option<PawnId>) -> Self {
        Self { pawn, ..self }
    }
}

/// The answer to a request of a session.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Answer {
    /// The pawn that it spawned.
    pub spawned: Option<PawnId>,
    /// Its problems.
    pub problems: Vec<Problem>,
    /// The messages that answer it; none for a session that hears nothing.
    pub messages: Vec<Message>,
}

/// An event of a session or of its world.
#[derive(Debug)]
pub enum News<'a> {
    /// A session sent a line. It is executed next.
    Received {
        /// The session.
        session: SessionId,
        /// The pawn that the line is for.
        pawn: Option<PawnId>,
        /// The line without its end.
        line: &'a str,
    },
    /// Something is wrong with a line of a session.
    Wrong {
        /// The session.
        session: SessionId,
        /// The line; empty if it was too long to keep.
        line: &'a str,
        /// Its problems.
        problems: &'a [Problem],
    },
    /// A pawn of a session came into the world.
    Came(PawnId),
    /// A sensor measured.
    Sensed(&'a Sensed),
    /// A session gets a line.
    Sent {
        /// The session.
        session: SessionId,
        /// The pawn that the line is about, if any.
        pawn: Option<PawnId>,
        /// The line without its end.
        line: String,
        /// True for a line on a timer: a newer one replaces it.
        is_periodic: bool,
    },
    /// A pawn left the world.
    Left(PawnId),
    /// A session ended.
    Closed(SessionId),
    /// The world removed a robot because of its state; it has left.
    Lost(&'a LostRobot),
    /// The world put an object back because of its state.
    Restored {
        /// Its name.
        name: &'a str,
        /// The fault of its state.
        fault: Fault,
    },
    /// A team gained or lost points.
    Scored(&'a Score),
    /// The time of the league is up.
    TimeUp(&'a Standings),
}

impl News<'_> {
    /// Returns the warning of news about a fault of the world, in words; `None` for other news.
    pub fn warning(&self) -> Option<String> {
        match self {
            Self::Lost(lost) => Some(lost.to_string()),
            Self::Restored { name, fault } => Some(format!("object {name} is put back where the map has it: {fault}")),
            Self::Received { .. }
            | Self::Wrong { .. }
            | Self::Came(_)
            | Self::Sensed(_)
            | Self::Sent { .. }
            | Self::Left(_)
            | Self::Closed(_)
            | Self::Scored(_)
            | Self::TimeUp(_) => None,
        }
    }
}

/// A world and its sessions. A copy is independent and continues as the original would.
#[derive(Clone)]
pub struct Sessions {
    world: World,
    sessions: BTreeMap<SessionId, Session>,
    owners: Owners,
    /// Pawns of a loaded world, until a session takes them over.
    orphans: BTreeSet<PawnId>,
    /// The round that is played, if the world has a league.
    round: Option<Round>,
}

/// A session.
#[derive(Clone, Default)]
struct Session {
    /// The dialect of all its lines; if none, its robots decide.
    dialect: Option<Dialect>,
    /// True if it gets an NFO line for each problem.
    hears_problems: bool,
    hears: Hears,
}

/// Forms in which a session hears.
#[derive(Clone, Copy, Default, PartialEq)]
enum Hears {
    /// Lines: answers, and reports of its pawns.
    #[default]
    Lines,
    /// Answers as messages, from [`Sessions::take`].
    Answers,
    /// Nothing at all.
    Nothing,
}

/// A listener to the news of a world.
pub type Listener<'a> = &'a mut dyn FnMut(&World, News);

impl Sessions {
    /// Creates the sessions of a world: none. Pawns that the world has already wait for an INIT of their class and name.
    pub fn new(world: World) -> Self {
        let orphans = world.pawns().map(|(id, ..)| id).collect();
        let round = round_of(&world);
        Self { world, sessions: BTreeMap::new(), owners: Owners::default(), orphans, round }
    }

    /// Returns the world.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Returns the world, to change it beside the sessions.
    pub fn world_mut(&mut self) -> &mut World {
        &mut self.world
    }

    /// Returns the world, and drops the sessions.
    pub fn into_world(self) -> World {
        self.world
    }

    /// Returns every team's points, if the world has a league.
    pub fn standings(&self) -> Option<Standings> {
        self.round.as_ref().map(|round| round.standings(&self.world))
    }

    /// Returns the session that a pawn reports to.
    pub fn owner(&self, pawn: PawnId) -> Option<SessionId> {
        self.owners.of(pawn)
    }

    /// Returns the newest pawn of a session.
    pub fn newest(&self, session: SessionId) -> Option<PawnId> {
        self.owners.newest(session)
    }

    /// Opens a session, and greets it. Without a dialect its robots decide. `hears_problems` is true to send it its problems.
    pub fn open(&mut self, id: SessionId, dialect: Option<Dialect>, hears_problems: bool, hear: Listener) {
        self.sessions.insert(id, Session { dialect, hears_problems, hears: Hears::Lines });
        let greeting = self.world.greeting();
        self.send(id, None, &[greeting], hear);
    }

    /// Opens a session that gets no lines.
    pub fn open_silent(&mut self, id: SessionId) {
        self.sessions.insert(id, Session { hears: Hears::Nothing, ..Session::default() });
    }

    /// Opens a session of a program: it gets no lines, and [`Sessions::take`] returns its answers.
    pub fn open_program(&mut self, id: SessionId) {
        self.sessions.insert(id, Session { hears: Hears::Answers, ..Session::default() });
    }

    /// True if a session is open.
    pub fn is_open(&self, id: SessionId) -> bool {
        self.sessions.contains_key(&id)
    }

    /// Executes a line of a session, and returns its answer. Nothing happens if the session is not open.
    pub fn take(&mut self, id: SessionId, request: &Request, hear: Listener) -> Answer {
        let Request { text, command, problems, pawn } = request;
        let pawn = pawn.or_else(|| self.owners.newest(id));
        if !text.is_empty() {
            hear(&self.world, News::Received { session: id, pawn, line: text });
        }
        let adopted = command.as_ref().and_then(|command| self.adopt(command));
        let Some(session) = self.sessions.get_mut(&id) else { return Answer::default() };
        if let Some(Command::Report(report)) = command {
            session.hears_problems = report.errors;
        }
        let (hears_problems, hears) = (session.hears_problems, session.hears);
        let mut problems = problems.clone();
        let executed = match adopted {
            Some(pawn) => Some(Executed { spawned: Some(pawn), ..Executed::default() }),
            None => command.as_ref().map(|command| self.execute(pawn, command, &mut problems)),
        };
        let Executed { answers, found, spawned } = executed.unwrap_or_default();
        if !problems.is_empty() {
            hear(&self.world, News::Wrong { session: id, line: text, problems: &problems });
        }
        if let Some(pawn) = spawned {
            self.owners.add(pawn, id, text.clone());
            hear(&self.world, News::Came(pawn));
        }
        let mut answers = self.messages(hears != Hears::Nothing, answers, hear);
        let pawn = spawned.or(pawn);
        let time = self.world.time() as f32;
        let receipt = command.as_ref().filter(|_| pawn.is_some());
        answers.extend(receipt.and_then(|command| Message::receipt(command, found, time, self.dialect(id, pawn))));
        if hears_problems {
            answers.extend(problems.iter().map(|problem| Message::Nfo(Nfo::Error(problem.to_string()))));
        }
        self.send(id, pawn, &answers, hear);
        Answer { spawned, problems, messages: answers }
    }

    /// Executes a line of a session as [`Sessions::take`] does. A session that gets no lines gets those that answer this one.
    pub fn ask(&mut self, id: SessionId, request: &Request, hear: Listener) -> Answer {
        let Some(session) = self.sessions.get_mut(&id) else { return Answer::default() };
        let before = std::mem::take(&mut session.hears);
        let answer = self.take(id, request, hear);
        self.sessions.get_mut(&id).into_iter().for_each(|session| session.hears = before);
        answer
    }

    /// Executes a command. A league decides which robots come, and where.
    fn execute(&mut self, pawn: Option<PawnId>, command: &Command, problems: &mut Vec<Problem>) -> Executed {
        let Self { world, round, .. } = self;
        let (Some(round), Command::Init(init)) = (round, command) else {
            if let Command::Init(Init { team, .. }) = command
                && !team.is_empty()
            {
                let why = "this world has no league".to_owned();
                problems.push(Problem::Ignored { what: format!("{{Team {}}}", shown(team)), why });
            }
            return world.execute(pawn, command, problems);
        };
        if !init.is_of_robot() {
            return world.execute(pawn, command, problems);
        }
        let mut init = init.clone();
        let place: Admission = match round.admit(&mut init, world) {
            Ok(place) => place,
            Err(problem) => {
                problems.push(problem);
                return Executed::default();
            }
        };
        let executed = world.execute(pawn, &Command::Init(init.clone()), problems);
        if let Some(pawn) = executed.spawned {
            round.enter(pawn, place, &init, world);
        }
        executed
    }

    /// Advances the world by one step.
    pub fn step(&mut self, hear: Listener) {
        let reports = self.world.step();
        if let Some(round) = &mut self.round {
            for (_, report) in &reports {
                if let Report::Sensed(sensed) = report {
                    round.see(sensed, &self.world);
                }
            }
        }
        let mut reports = reports.into_iter().peekable();
        while let Some(&(pawn, _)) = reports.peek() {
            let own = std::iter::from_fn(|| reports.next_if(|(next, _)| *next == pawn));
            let own: Vec<Report> = own.map(|(_, report)| report).collect();
            let owner = self.owners.of(pawn);
            let messages = self.messages(owner.is_some_and(|owner| self.hears(owner)), own, hear);
            if let Some(owner) = owner {
                self.send(owner, Some(pawn), &messages, hear);
            }
        }
        for lost in self.world.take_lost() {
            hear(&self.world, News::Left(lost.id));
            hear(&self.world, News::Lost(&lost));
            let owner = self.owners.of(lost.id);
            if let Some(id) = owner.filter(|id| self.sessions.get(id).is_some_and(|session| session.hears_problems)) {
                self.send(id, None, &[Message::Nfo(Nfo::Error(lost.to_string()))], hear);
            }
        }
        for (name, fault) in self.world.take_restored() {
            hear(&self.world, News::Restored { name: &name, fault });
        }
        let Some(round) = &mut self.round else { return };
        let (scores, is_up) = round.step(&mut self.world);
        scores.iter().for_each(|score| hear(&self.world, News::Scored(score)));
        if is_up {
            hear(&self.world, News::TimeUp(&round.standings(&self.world)));
        }
    }

    /// Removes a pawn. Its session stays.
    pub fn remove(&mut self, pawn: PawnId, hear: Listener) {
        self.owners.remove(pawn);
        self.world.remove(pawn);
        hear(&self.world, News::Left(pawn));
    }

    /// Closes a session and removes its pawns. If the world keeps robots, only the newest is removed, as in USARSim.
    pub fn close(&mut self, id: SessionId, hear: Listener) {
        self.sessions.remove(&id);
        let pawns = self.owners.leave(id);
        let kept = if self.world.options().keep_robots { pawns.len().saturating_sub(1) } else { 0 };
        for pawn in pawns.into_iter().skip(kept) {
            self.world.remove(pawn);
            hear(&self.world, News::Left(pawn));
        }
        hear(&self.world, News::Closed(id));
    }

    /// Forgets a session. Its pawns stay.
    pub fn forget(&mut self, id: SessionId) {
        self.sessions.remove(&id);
        self.owners.leave(id);
    }

    /// Replaces the world by another one. Returns the old one, and the INIT lines of all pawns with their sessions, in the order of the pawns'
    /// numbers. Taking these lines puts the pawns back.
    pub fn replace_world(&mut self, world: World) -> (World, Vec<(SessionId, Request)>) {
        self.orphans.clear();
        self.round = round_of(&world);
        let inits = self.owners.start_over().into_iter();
        let inits = inits.map(|(id, init)| (id, Request::read(Ok(init)))).collect();
        (std::mem::replace(&mut self.world, world), inits)
    }

    /// Returns the pawn of a loaded world that an INIT takes over: the first of its class and name that no session has.
    fn adopt(&mut self, command: &Command) -> Option<PawnId> {
        let Command::Init(init) = command else { return None };
        let is_it = |(id, class, name): &(PawnId, &str, &str)| {
            self.orphans.contains(id) && class.eq_ignore_ascii_case(init.class()) && *name == init.name
        };
        let (id, ..) = self.world.pawns().find(is_it)?;
        self.orphans.take(&id)
    }

    /// Returns the dialect of messages to a session: its own, else the one of the robot's class, else UDK.
    fn dialect(&self, id: SessionId, pawn: Option<PawnId>) -> Dialect {
        let of_robot = || {
            let robot = pawn.and_then(|pawn| self.world.robot(pawn));
            if robot.is_some_and(|def| def.speaks_ut2004) { Dialect::Ut2004 } else { Dialect::Udk }
        };
        self.sessions.get(&id).and_then(|session| session.dialect).unwrap_or_else(of_robot)
    }

    /// True if a session gets lines.
    fn hears(&self, id: SessionId) -> bool {
        self.sessions.get(&id).is_some_and(|session| session.hears == Hears::Lines)
    }

    /// Tells of the readings among reports, and returns all as messages; none if nobody gets them.
    fn messages(&self, are_heard: bool, reports: Vec<Report>, hear: Listener) -> Vec<Message> {
        for report in &reports {
            if let Report::Sensed(sensed) = report {
                hear(&self.world, News::Sensed(sensed));
            }
        }
        if !are_heard {
            return Vec::new();
        }
        reports.into_iter().filter_map(|report| self.world.message(report)).collect()
    }

    /// Sends messages that belong together. `pawn` is the pawn that they are about, if any.
    fn send(&self, session: SessionId, pawn: Option<PawnId>, messages: &[Message], hear: Listener) {
        if !self.hears(session) {
            return;
        }
        for WrittenLine { line, messages } in message::lines(messages, self.dialect(session, pawn)) {
            let is_periodic = messages.iter().all(|message| message.is_periodic());
            hear(&self.world, News::Sent { session, pawn, line, is_periodic });
        }
    }
}

/// Returns a new round of a world's league, if it has one.
fn round_of(world: &World) -> Option<Round> {
    let def = world.def();
    def.league.as_ref().map(|league| Round::new(league, &def.map))
}
