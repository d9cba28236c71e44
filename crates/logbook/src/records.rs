//! Records of news: what a log says of the sessions.

use std::collections::BTreeMap;

use gamebots_proto::Problem;
use recorder::{Record, WireLine};
use scene::PawnId;
use sessions::{News, SessionId};

/// Most different problems of one session whose repetitions are counted. Each further one is told every time.
const MAX_COUNTED: usize = 50;
/// Characters of a bad line in its warning.
const SHOWN_CHARS: usize = 200;

/// Returns the record of news; `None` for arrivals, which an INIT line records, and for problems, of which [`Mistakes`] has the warnings.
pub fn record(news: &News) -> Option<Record> {
    let line = |connection: SessionId, pawn: Option<PawnId>, line: &str| WireLine {
        connection,
        robot: pawn.map(|pawn| pawn.0),
        line: line.to_owned(),
    };
    match news {
        News::Received { session, pawn, line: text } => Some(Record::In(line(*session, *pawn, text))),
        News::Sent { session, pawn, line: text, .. } => Some(Record::Out(line(*session, *pawn, text))),
        News::Sensed(sensed) => Some(Record::Sensed((*sensed).clone())),
        News::Left(pawn) => Some(Record::Left(pawn.0)),
        News::Closed(session) => Some(Record::Closed(line(*session, None, ""))),
        News::Lost(_) | News::Restored { .. } => warning(news).map(Record::Warning),
        News::Scored(score) => Some(Record::Scored((*score).clone())),
        News::TimeUp(standings) => Some(Record::Standings(Box::new((*standings).clone()))),
        News::Wrong { .. } | News::Came(_) => None,
    }
}

/// Returns the warning of news about a fault of the world, in words; `None` for other news.
pub fn warning(news: &News) -> Option<String> {
    match news {
        News::Lost(lost) => Some(lost.to_string()),
        News::Restored { name, fault } => Some(format!("object {name} is put back where the map has it: {fault}")),
        News::Received { .. }
        | News::Wrong { .. }
        | News::Came(_)
        | News::Sensed(_)
        | News::Sent { .. }
        | News::Left(_)
        | News::Closed(_)
        | News::Scored(_)
        | News::TimeUp(_) => None,
    }
}

/// Problems of a session's lines. Each is told once, and its repetitions are counted.
#[derive(Debug, Clone)]
pub struct Mistakes {
    session: SessionId,
    lines: u64,
    /// Problems that were told, with their repetitions since the last report.
    repeated: BTreeMap<String, u64>,
}

impl Mistakes {
    /// Creates the mistakes of a session: none.
    pub fn new(session: SessionId) -> Self {
        Self { session, lines: 0, repeated: BTreeMap::new() }
    }

    /// Counts a line of the session.
    pub fn count_line(&mut self) {
        self.lines += 1;
    }

    /// Returns the number of lines counted so far.
    pub fn lines(&self) -> u64 {
        self.lines
    }

    /// Returns the warning of a problem of the last line, in words; `None` for a repetition.
    pub fn warning(&mut self, line: &str, problem: &Problem) -> Option<String> {
        let problem = problem.to_string();
        if let Some(times) = self.repeated.get_mut(&problem) {
            *times += 1;
            return None;
        }
        let shown: String = line.chars().take(SHOWN_CHARS).collect();
        let text = format!("connection {}, line {}: {problem}: {shown}", self.session, self.lines);
        if self.repeated.len() < MAX_COUNTED {
            self.repeated.insert(problem, 0);
        }
        Some(text)
    }

    /// Returns the warnings of repetitions since the last call, in words. A problem that did not recur is told in full when it does.
    pub fn repetitions(&mut self) -> impl Iterator<Item = String> {
        let Self { session, repeated, .. } = self;
        repeated.retain(|_, times| *times > 0);
        repeated.iter_mut().map(move |(problem, times)| {
            let more = names::count(usize::try_from(std::mem::take(times)).unwrap_or(usize::MAX), "time");
            format!("connection {session}: {problem} ({more} more)")
        })
    }
}
