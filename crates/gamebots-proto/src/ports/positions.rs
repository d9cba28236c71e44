//! The port of positions, 7435: where robots are and what stands between them, for a wireless simulator (ComServerInterface.uc,
//! ComServerNewCon.uc; protocol.md 7.4).

use std::fmt::Write;

use crate::Line;
use crate::number::fixed;
use crate::value;

/// A question.
#[derive(Debug, Clone, PartialEq)]
pub enum PositionsQuestion {
    /// `GETPOS`: all robots.
    Positions,
    /// `GETOBS`: the obstacles between two places.
    Obstacles(Obstacles),
    /// `GETOBS` without two places, which has an empty answer.
    Nothing,
}

/// Two places, as they were sent.
#[derive(Debug, Clone, PartialEq)]
pub struct Obstacles {
    keys: [&'static str; 2],
    texts: [String; 2],
}

/// An end of the line between two places.
#[derive(Debug, Clone, PartialEq)]
pub enum Place {
    /// The robot of a name.
    Robot(String),
    /// A point, m.
    Point([f64; 3]),
}

/// A robot in an answer.
#[derive(Debug, Clone, PartialEq)]
pub struct Stand<'a> {
    /// Name from INIT.
    pub name: &'a str,
    /// Position, m.
    pub location: [f32; 3],
    /// True if its battery is empty.
    pub battery_is_empty: bool,
}

impl PositionsQuestion {
    /// Reads a line. `None` for other verbs, which have no answer.
    pub fn read(line: &str) -> Option<Self> {
        let line = Line::parse(line);
        if line.verb.eq_ignore_ascii_case("GETPOS") {
            return Some(Self::Positions);
        }
        if !line.verb.eq_ignore_ascii_case("GETOBS") {
            return None;
        }
        // Robots count before points, and one of a pair counts as none.
        let pair = |keys: [&'static str; 2]| {
            let [from, to] = keys.map(|key| line.get(key).filter(|text| !text.is_empty()));
            Some(Self::Obstacles(Obstacles { keys, texts: [from?.to_owned(), to?.to_owned()] }))
        };
        Some(pair(["From", "To"]).or_else(|| pair(["Start", "End"])).unwrap_or(Self::Nothing))
    }
}

impl Obstacles {
    /// Returns the places.
    pub fn places(&self) -> [Place; 2] {
        let is_robots = self.keys == ["From", "To"];
        self.texts
            .each_ref()
            .map(|text| if is_robots { Place::Robot(text.clone()) } else { Place::Point(value::vector_of(text)) })
    }

    /// Returns the answer with a number of obstacles; -1 if a robot is unknown.
    pub fn answer(&self, count: f32) -> String {
        let ([from, to], [first, second]) = (self.keys, &self.texts);
        format!("NUMOBS {{{from} {first}}} {{{to} {second}}} {{ObstCount {}}}\r\n", fixed(count, 4))
    }
}

/// Returns the answer to `GETPOS`.
pub fn positions(robots: &[Stand]) -> String {
    let mut text = format!("POSITIONS {{Robots {}}}", robots.len());
    for Stand { name, location, battery_is_empty } in robots {
        let location = location.map(|number| fixed(number, 4)).join(",");
        let is_empty = if *battery_is_empty { "True" } else { "False" };
        // Writing to a text cannot fail.
        let _ = write!(text, " {{Name {name} Location {location} BatteryEmpty {is_empty}}}");
    }
    text + "\r\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn questions_are_answered_with_the_bytes_of_usarsim() {
        let robots = [
            Stand { name: "R1", location: [1.0, 2.0, -0.1], battery_is_empty: false },
            Stand { name: "ComStation", location: [0.0; 3], battery_is_empty: true },
        ];
        let expected = "POSITIONS {Robots 2} {Name R1 Location 1.0000,2.0000,-0.1000 BatteryEmpty False} \
                        {Name ComStation Location 0.0000,0.0000,0.0000 BatteryEmpty True}\r\n";
        assert_eq!(positions(&robots), expected);
        assert_eq!(positions(&[]), "POSITIONS {Robots 0}\r\n");
        let rows = [
            ("GETOBS {From R1} {To Nobody}", -1.0, "NUMOBS {From R1} {To Nobody} {ObstCount -1.0000}\r\n"),
            (
                "getobs {Start 0,0,-0.5} {End 5,0,-0.5}",
                1.0,
                "NUMOBS {Start 0,0,-0.5} {End 5,0,-0.5} {ObstCount 1.0000}\r\n",
            ),
            (
                "GETOBS {End 5,0,-0.5} {Start 0,0,-0.5} {To B} {From A}",
                2.0,
                "NUMOBS {From A} {To B} {ObstCount 2.0000}\r\n",
            ),
        ];
        for (text, count, expected) in rows {
            let Some(PositionsQuestion::Obstacles(between)) = PositionsQuestion::read(text) else { panic!("{text}") };
            assert_eq!(between.answer(count), expected, "{text}");
        }
        for text in ["GETOBS", "GETOBS {From R1}", "GETOBS {Start 1,2,3} {To B}"] {
            assert_eq!(PositionsQuestion::read(text), Some(PositionsQuestion::Nothing), "{text}");
        }
        assert_eq!(PositionsQuestion::read("GetPos"), Some(PositionsQuestion::Positions));
        assert_eq!(PositionsQuestion::read("DRIVE {Left 1}"), None);
    }
}
