//! The port of truth, 3989: poses of pawns and objects for referees (USARTruth.uc, USARTruthConnection.uc; protocol.md 7.2).
//!
//! A question is `{class USARBot.P3AT} {name P3AT_0}`, and an empty line asks for all pawns. The answer has a row for each, and `{End}`.

use std::fmt::Write;

use crate::Line;
use crate::number::rounded;

/// A question: a class and a name, each empty for any.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct TruthQuestion {
    /// Class without its package, in any case; `Pawn` if the question has none.
    pub class: String,
    /// Name, exact.
    pub name: String,
}

impl TruthQuestion {
    /// Reads a line. Verbs and unknown blocks do not count.
    pub fn read(line: &str) -> Self {
        let line = Line::parse(line);
        let part = |key| line.get(key).unwrap_or_default();
        let class = part("class").rsplit('.').next().unwrap_or_default();
        Self { class: if class.is_empty() { "Pawn" } else { class }.to_owned(), name: part("name").to_owned() }
    }
}

/// A row of an answer.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Row<'a> {
    /// Name in the engine.
    pub name: &'a str,
    /// Class without its package.
    pub class: &'a str,
    /// Simulated time, s.
    pub time: f32,
    /// Position, m.
    pub location: [f32; 3],
    /// Roll, pitch, yaw, rad.
    pub rotation: [f32; 3],
}

/// Last line of an answer, with its end.
pub const TRUTH_END: &str = "{End}\r\n";

/// Returns an answer: a line for each row and the last one.
pub fn rows<'a>(rows: impl IntoIterator<Item = Row<'a>>) -> String {
    let mut text = String::new();
    for Row { name, class, time, location, rotation } in rows {
        let vector = |vector: [f32; 3]| vector.map(|number| rounded(number, 2)).join(",");
        // Writing to a text cannot fail.
        let _ = write!(
            text,
            "{{Name {name}}} {{Class {class}}} {{Time {}}} {{Location {}}} {{Rotation {}}}\r\n",
            rounded(time, 4),
            vector(location),
            vector(rotation)
        );
    }
    text + TRUTH_END
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn questions_name_a_class_and_a_name() {
        let rows = [
            ("", "Pawn", ""),
            ("{Actors}", "Pawn", ""),
            ("{class USARBot.P3AT}", "P3AT", ""),
            ("{Class USARPhysObj.partc} {name part_c_5}", "partc", "part_c_5"),
            ("GET {name a b}{class WCObject}", "WCObject", "a b"),
            ("{class a.b.C} {class D}", "C", ""),
        ];
        for (text, class, name) in rows {
            let expected = TruthQuestion { class: class.to_owned(), name: name.to_owned() };
            assert_eq!(TruthQuestion::read(text), expected, "{text}");
        }
    }

    #[test]
    fn an_answer_has_the_bytes_of_usarsim() {
        let row = Row {
            name: "P3AT_0",
            class: "P3AT",
            time: 29.97391,
            location: [0.67, 2.3, 1.861],
            rotation: [-0.001, 0.46, 0.0],
        };
        let expected = "{Name P3AT_0} {Class P3AT} {Time 29.9739} {Location 0.67,2.30,1.86} {Rotation -0.00,0.46,0.00}\r\n{End}\r\n";
        assert_eq!(rows([row]), expected);
        assert_eq!(rows([]), "{End}\r\n");
    }
}
