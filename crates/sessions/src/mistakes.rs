//! Mistakes in the lines of a session, and their warnings.

use std::collections::BTreeMap;

use gamebots_proto::Problem;

use crate::SessionId;

/// Most different problems of one session whose repetitions are counted. Each further one is told every time.
const MAX_COUNTED: usize = 50;
/// Characters of a bad line in its warning.
const SHOWN_CHARS: usize = 200;

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
