//! Demos of scenarios: lines with the times at which clients sent them, played again in a fresh world.
//!
//! Equal lines at equal steps give equal bits. So a demo is a text of some lines, and its log is made where it is wanted.

use std::collections::BTreeSet;
use std::path::Path;

use recorder::{LogWriter, RecordError};
use scene::{Options, WorldDef};
use sessions::{Request, SessionId};
use sim_core::World;

use crate::logged::LoggedSessions;

/// Longest demo, simulated s.
const MAX_SECONDS: f64 = 300.0;
/// Time for which a demo goes on after its goals are reached, or after its last line, simulated s.
const AFTERWARDS: f64 = 2.0;
/// Simulated time below which two times are the same, s.
const SAME_TIME: f64 = 1e-9;

/// A demo that cannot be played.
#[derive(Debug, thiserror::Error)]
pub enum DemoError {
    /// A line is none of a demo.
    #[error("line {line} of the demo: {why}")]
    Line {
        /// Its number, from 1.
        line: usize,
        /// Problem, and what was expected.
        why: String,
    },
    /// The log cannot be written.
    #[error(transparent)]
    Log(#[from] RecordError),
}

/// A line of a demo.
struct TimedLine {
    /// Simulated time, s.
    time: f64,
    client: SessionId,
    line: String,
}

/// A demo that is played in a fresh world: until its goals are reached, or its lines are over, and a little longer.
pub struct Demo {
    sessions: LoggedSessions,
    /// Lines that have not been sent, the last first.
    lines: Vec<TimedLine>,
    opened: BTreeSet<SessionId>,
    finished: Option<f64>,
    /// Simulated time of its end, s.
    end: f64,
}

impl Demo {
    /// Creates a demo of lines, and its log if one is wanted.
    ///
    /// A line is `TIME CLIENT TEXT`: a simulated time that does not decrease, s, the number of a client, and what it sends. Empty lines and
    /// those that begin with `#` do not count.
    ///
    /// # Errors
    /// When a line is wrong, or the log cannot be written.
    pub fn new(world: WorldDef, lines: &str, log: Option<&Path>) -> Result<Self, DemoError> {
        let mut lines = read(lines)?;
        let end = lines.last().map_or(0.0, |line| line.time) + AFTERWARDS;
        lines.reverse();
        let options = Options::default();
        let log = log.map(|path| LogWriter::create(path, &world, options, &[])).transpose()?;
        let sessions = LoggedSessions::new(World::new(world, options), log);
        Ok(Self { sessions, lines, opened: BTreeSet::new(), finished: None, end })
    }

    /// Returns the world as it is now.
    pub fn world(&self) -> &World {
        self.sessions.world()
    }

    /// Returns the simulated time in which all goals were reached, s; `None` before that.
    pub fn finished(&self) -> Option<f64> {
        self.finished
    }

    /// Sends the lines that are due, and takes a step. Returns false at the end.
    ///
    /// # Errors
    /// When the log cannot be written.
    pub fn step(&mut self) -> Result<bool, DemoError> {
        let now = self.world().time();
        while let Some(line) = self.lines.pop_if(|line| line.time <= now + SAME_TIME) {
            if self.opened.insert(line.client) {
                self.sessions.open(line.client)?;
            }
            self.sessions.take(line.client, &Request::read(Ok(line.line)), &mut |_| {})?;
        }
        if now >= self.end {
            return Ok(false);
        }
        self.sessions.step(&mut |_| {})?;
        if self.finished.is_none() {
            let standings = self.sessions.standings();
            self.finished = standings.and_then(|it| it.teams.iter().find_map(|team| team.finished));
            self.end = if self.finished.is_some() { now + AFTERWARDS } else { self.end };
        }
        Ok(true)
    }
}

/// Plays a demo to its end and writes the log. Returns the simulated time in which all goals were reached, s; `None` if they were not.
///
/// # Errors
/// As [`Demo::new`].
pub fn write_demo(world: WorldDef, lines: &str, log: &Path) -> Result<Option<f64>, DemoError> {
    let mut demo = Demo::new(world, lines, Some(log))?;
    while demo.step()? {}
    demo.sessions.finish()?;
    Ok(demo.finished)
}

fn read(text: &str) -> Result<Vec<TimedLine>, DemoError> {
    let mut lines: Vec<TimedLine> = Vec::new();
    for (number, line) in text.lines().enumerate().filter(|(_, line)| !line.is_empty() && !line.starts_with('#')) {
        let wrong = |why: String| DemoError::Line { line: number + 1, why };
        let mut parts = line.splitn(3, ' ');
        let (time, client, text) = (parts.next(), parts.next(), parts.next());
        let parsed = time.and_then(|it| it.parse::<f64>().ok()).zip(client.and_then(|it| it.parse().ok())).zip(text);
        let ((time, client), text) = parsed.ok_or_else(|| wrong("expected `TIME CLIENT TEXT`".to_owned()))?;
        let before = lines.last().map_or(0.0, |line| line.time);
        if !(before..=MAX_SECONDS).contains(&time) {
            return Err(wrong(format!("got the time {time}, expected {before} to {MAX_SECONDS} s")));
        }
        lines.push(TimedLine { time, client, line: text.to_owned() });
    }
    Ok(lines)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_line_is_named() {
        for (text, expected) in [
            (
                "0.5 1 DRIVE {Left 1}\n0.4 1 DRIVE {Left 0}",
                "line 2 of the demo: got the time 0.4, expected 0.5 to 300 s",
            ),
            ("# a note\n\nnan 1 INIT", "line 3 of the demo: got the time NaN, expected 0 to 300 s"),
            ("1e9 1 INIT", "line 1 of the demo: got the time 1000000000, expected 0 to 300 s"),
            ("0 INIT", "line 1 of the demo: expected `TIME CLIENT TEXT`"),
            ("-1 1 INIT", "line 1 of the demo: got the time -1, expected 0 to 300 s"),
        ] {
            let error = read(text).err().map(|error| error.to_string());
            assert_eq!(error.as_deref(), Some(expected), "{text}");
        }
        assert_eq!(
            read("0 1 INIT {ClassName USARBot.P3AT}\n2.5 1 DRIVE {Left 1} {Right 1}").map_or(0, |it| it.len()),
            2
        );
    }
}
