//! The two dialects of the wire.

use std::fmt;
use std::str::FromStr;

/// A dialect of the server's lines. Clients may send the same lines in both.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Dialect {
    /// USARSim for UDK, the last version (protocol.md 4).
    #[default]
    Udk,
    /// USARSim for UT2004, for controllers written before 2010 (protocol.md 9, sensors.md 8).
    Ut2004,
}

impl Dialect {
    /// Both dialects with their names.
    pub const ALL: [(&'static str, Self); 2] = [("udk", Self::Udk), ("ut2004", Self::Ut2004)];

    /// Picks this dialect's part of a pair, UDK's first.
    pub(crate) fn of<T: Copy>(self, [udk, ut2004]: [T; 2]) -> T {
        match self {
            Self::Udk => udk,
            Self::Ut2004 => ut2004,
        }
    }
}

impl fmt::Display for Dialect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.of(["udk", "ut2004"]))
    }
}

impl FromStr for Dialect {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let known = Self::ALL.into_iter().find(|(name, _)| *name == text);
        known.map(|(_, dialect)| dialect).ok_or_else(|| format!("`{text}` is not a dialect: expected udk or ut2004"))
    }
}
