//! Questions: `GETCONF`, `GETGEO`, `GETSTARTPOSES`, `GETPATHNODES`, `GETCLOSESTPATHNODE`, and our own `GETCLASSES`.

use super::{ReadWrite, note_keys, text, with_text, with_vector};
use crate::{Line, Problem, value};

macro_rules! by_type_and_name {
    ($(#[$doc:meta])* $name:ident, $verb:literal) => {
        $(#[$doc])*
        #[derive(Debug, Clone, PartialEq, Default)]
        pub struct $name {
            /// `Robot` (exact case), or the type of an item in any case.
            pub type_name: String,
            /// Name of the item, any case; empty means all of the type.
            pub name: String,
        }

        impl ReadWrite for $name {
            const KEYS: &'static [&'static str] = &["Type", "Name"];

            fn read(line: &Line, problems: &mut Vec<Problem>) -> Self {
                note_keys($verb, line, Self::KEYS, problems);
                Self { type_name: text(line, "Type"), name: text(line, "Name") }
            }

            fn write(&self) -> Line {
                with_text(with_text(Line::new($verb), "Type", &self.type_name), "Name", &self.name)
            }
        }
    };
}

by_type_and_name! {
    /// `GETCONF {Type t} {Name n}`: one CONF line, or no line if nothing matches.
    GetConf, "GETCONF"
}
by_type_and_name! {
    /// `GETGEO {Type t} {Name n}`: one GEO line, or no line if nothing matches.
    GetGeo, "GETGEO"
}

/// `GETSTARTPOSES`: one `NFO {StartPoses n}` line.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct GetStartPoses;

impl ReadWrite for GetStartPoses {
    fn read(_line: &Line, _problems: &mut Vec<Problem>) -> Self {
        Self
    }

    fn write(&self) -> Line {
        Line::new("GETSTARTPOSES")
    }
}

/// `GETCLASSES`: one `NFO {Classes n}` line. Not part of USARSim.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct GetClasses;

impl ReadWrite for GetClasses {
    fn read(_line: &Line, _problems: &mut Vec<Problem>) -> Self {
        Self
    }

    fn write(&self) -> Line {
        Line::new("GETCLASSES")
    }
}

/// `GETPATHNODES`: one `NFO {PathNodes n}` line.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct GetPathNodes;

impl ReadWrite for GetPathNodes {
    fn read(_line: &Line, _problems: &mut Vec<Problem>) -> Self {
        Self
    }

    fn write(&self) -> Line {
        Line::new("GETPATHNODES")
    }
}

/// `GETCLOSESTPATHNODE {Location x,y,z}`: one `NFO {Pathnode ..}` line, or no line without a location.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct GetClosestPathNode {
    /// The place, m; only x and y count.
    pub location: Option<[f64; 3]>,
}

impl ReadWrite for GetClosestPathNode {
    const KEYS: &'static [&'static str] = &["Location"];

    fn read(line: &Line, problems: &mut Vec<Problem>) -> Self {
        note_keys("GETCLOSESTPATHNODE", line, Self::KEYS, problems);
        let given = line.get("Location").is_some_and(|text| !text.is_empty());
        if !given {
            problems.push(Problem::MissingKey { verb: "GETCLOSESTPATHNODE", key: "Location" });
        }
        Self { location: given.then(|| value::vector(line, "Location", problems)) }
    }

    fn write(&self) -> Line {
        let line = Line::new("GETCLOSESTPATHNODE");
        self.location.into_iter().fold(line, |line, location| with_vector(line, "Location", location))
    }
}
