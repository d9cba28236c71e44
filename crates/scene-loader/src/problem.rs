//! What can be wrong with a file.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;

use scene::check::SceneProblem;

/// Most problems that are said: a file of a million mistakes is no file of this kind.
const MAX_PROBLEMS: usize = 100;

/// One mistake in a file, with its place. Written as compilers do: `file:line:column: message`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FileProblem {
    /// The file.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column, from 1, in characters.
    pub column: usize,
    /// What is wrong and what was expected.
    pub message: String,
}

impl FileProblem {
    /// Whether it is a key that nothing knows.
    pub(crate) fn is_unknown_key(&self) -> bool {
        ["unknown key", "unknown field"].iter().any(|begin| self.message.starts_with(begin))
    }
}

impl fmt::Display for FileProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}: {}", self.file, self.line, self.column, self.message)
    }
}

/// Why a robot, map or material could not be loaded.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// A file that cannot be read.
    #[error("{file}: cannot be read: {reason}")]
    Unreadable {
        /// The file.
        file: String,
        /// What the operating system says.
        reason: String,
    },
    /// Neither a name that is built in nor a file.
    #[error("unknown {kind} `{got}`: expected a file or one of {expected}{suggestion}")]
    UnknownName {
        /// `map` or `robot`.
        kind: &'static str,
        /// What was asked for.
        got: String,
        /// The nearest of them, in words; nothing where none is near.
        suggestion: String,
        /// The names there are.
        expected: String,
    },
    /// A file of another kind.
    #[error("{file}: expected {expected}")]
    UnknownKind {
        /// The file.
        file: String,
        /// The kinds there are.
        expected: &'static str,
    },
    /// An override whose path leads nowhere, or whose value is none.
    #[error("--set {text}: {reason}")]
    Override {
        /// As it was written.
        text: String,
        /// What is wrong with it.
        reason: String,
    },
    /// Files that are good, each by itself, but make no world.
    #[error(transparent)]
    Scene(#[from] SceneProblem),
    /// Mistakes in a file, one a line.
    #[error("{}", list(.0))]
    Bad(Vec<FileProblem>),
}

fn list(problems: &[FileProblem]) -> String {
    problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")
}

/// Problems as they are found; reading goes on to find the next.
#[derive(Debug, Default)]
pub(crate) struct Problems(Vec<FileProblem>);

impl Problems {
    /// Notes a problem at a byte offset of a text.
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

    /// How many there are so far.
    pub(crate) fn count(&self) -> usize {
        self.0.len()
    }

    /// Takes away, of the problems after the first `from`, what is said of each of `entries` alike, and returns it.
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

    /// The value if nothing is wrong, otherwise every problem once, in the order of the lines.
    pub(crate) fn into_result<T>(mut self, value: T) -> Result<T, LoadError> {
        self.0.sort_by(|a, b| (&a.file, a.line, a.column).cmp(&(&b.file, b.line, b.column)));
        self.0.dedup();
        if self.0.is_empty() { Ok(value) } else { Err(LoadError::Bad(self.0)) }
    }
}

/// What could not be read; the problems say why. Nothing that follows from it is a problem of its own.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Unread;
