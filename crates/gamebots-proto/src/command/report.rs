//! `REPORT {Errors true}`: an extension for people and tools; no controller of USARSim sends it.

use super::{ReadWrite, note_keys};
use crate::value::boolean;
use crate::{Line, Problem};

/// Chooses the reports that a connection gets beside its answers.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Report {
    /// True to report problems with its lines as `NFO {Error ..}`.
    pub errors: bool,
}

impl ReadWrite for Report {
    const KEYS: &'static [&'static str] = &["Errors"];

    fn read(line: &Line, problems: &mut Vec<Problem>) -> Self {
        note_keys("REPORT", line, Self::KEYS, problems);
        Self { errors: boolean(line, "Errors", problems).unwrap_or_default() }
    }

    fn write(&self) -> Line {
        Line::new("REPORT").with("Errors", self.errors)
    }
}
