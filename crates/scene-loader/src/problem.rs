//! Problems of files.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use scene::check::SceneProblem;

/// Maximum number of reported problems: a file with more mistakes is no file of this kind.
const MAX_PROBLEMS: usize = 100;

/// One mistake in a file, with its position. Displayed as by compilers: `file:line:column: message`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FileProblem {
    /// The file.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column, from 1, in characters.
    pub column: usize,
    /// Description of the problem and of the expected value.
    pub message: String,
}

impl FileProblem {
    /// True for a key that no reader knows.
    pub(crate) fn is_unknown_key(&self) -> bool {
        ["unknown key", "unknown field"].iter().any(|begin| self.message.starts_with(begin))
    }
}

impl fmt::Display for FileProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}: {}", self.file, self.line, self.column, self.message)
    }
}

/// Reason for which a robot, map or material could not be loaded.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// A file that cannot be read.
    #[error("{file}: cannot be read: {reason}")]
    Unreadable {
        /// The file.
        file: String,
        /// Message of the operating system.
        reason: String,
    },
    /// Neither an embedded name nor a file.
    #[error("unknown {kind} `{got}`{suggestion}: expected a file or one of {expected}")]
    UnknownName {
        /// `map` or `robot`.
        kind: &'static str,
        /// Requested name.
        got: String,
        /// Nearest known name, in words; empty if none is near.
        suggestion: String,
        /// Known names, or the command that lists them.
        expected: String,
    },
    /// A file of another kind.
    #[error("{file}: expected {expected}")]
    UnknownKind {
        /// The file.
        file: String,
        /// Known kinds.
        expected: &'static str,
    },
    /// A file that no map can be made from.
    #[error("{0}")]
    Import(String),
    /// A material that is not among the shipped ones.
    #[error("unknown material `{got}`{suggestion}: expected one of {expected}")]
    UnknownMaterial {
        /// Requested name.
        got: String,
        /// Nearest known name, in words; empty if none is near.
        suggestion: String,
        /// Known names.
        expected: String,
    },
    /// An override with an unknown path or an invalid value.
    #[error("--set {text}: {reason}")]
    Override {
        /// Text of the override.
        text: String,
        /// Description of the problem.
        reason: String,
    },
    /// Files that are valid by themselves, but not together.
    #[error(transparent)]
    Scene(#[from] SceneProblem),
    /// Mistakes in a file, one per line.
    #[error("{}", list(.0))]
    Bad(Vec<FileProblem>),
}

fn list(problems: &[FileProblem]) -> String {
    problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

/// Problems found so far; reading continues after each.
#[derive(Debug, Default)]
pub(crate) struct Problems(Vec<FileProblem>);

impl Problems {
    /// Adds a problem at a byte offset of a text.
    pub(crate) fn at(&mut self, file: &str, text: &str, offset: usize, message: impl fmt::Display) {
        if self.0.len() >= MAX_PROBLEMS {
            return;
        }
        let before = text.get(..offset).unwrap_or(text);
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        self.0.push(FileProblem {
            file: file.to_owned(),
            line: before.matches('\n').count() + 1,
            column: before[line_start..].chars().count() + 1,
            message: message.to_string(),
        });
    }

    /// Returns the number of problems so far.
    pub(crate) fn count(&self) -> usize {
        self.0.len()
    }

    /// Removes and returns the messages that all of `entries` share, among the problems after the first `from`.
    pub(crate) fn take_shared(&mut self, from: usize, entries: usize) -> BTreeSet<String> {
        let mut counts: BTreeMap<String, usize> = BTreeMap::new();
        self.0[from..].iter().for_each(|problem| *counts.entry(problem.message.clone()).or_default() += 1);
        let shared: BTreeSet<String> = counts
            .into_iter()
            .filter(|&(_, count)| count > 1 && count == entries)
            .map(|(message, _)| message)
            .collect();
        let later = self.0.split_off(from);
        self.0.extend(later.into_iter().filter(|problem| !shared.contains(&problem.message)));
        shared
    }

    /// Returns the value if there are no problems. Otherwise returns every problem once, in the order of the lines.
    pub(crate) fn into_result<T>(self, value: T) -> Result<T, LoadError> {
        let problems = self.into_list();
        if problems.is_empty() { Ok(value) } else { Err(LoadError::Bad(problems)) }
    }

    /// Returns every problem once, in the order of the lines.
    pub(crate) fn into_list(mut self) -> Vec<FileProblem> {
        self.0.sort_by(|a, b| (&a.file, a.line, a.column).cmp(&(&b.file, b.line, b.column)));
        self.0.dedup();
        self.0
    }
}

/// Marks a value that could not be read. Its problems are already reported, so that nothing else reports consequences of it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Unread;
