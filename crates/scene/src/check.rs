//! Limits of a scene: the range of every number, and the rules between numbers. They apply to files and logs alike.
//!
//! The engine never reports a failure: with a mass near zero, every number of that robot is NaN after one step. The ranges go far
//! beyond any rescue robot and its arena, and end well before the engine fails. The ends were tested with 1200 random robots drawn
//! from the ranges and their ends, in every drive model. They stood on a plane of any friction and gravity; none lost a finite
//! state.

mod goal;
mod league;
mod limits;
mod map;
mod robot;
mod scenario;
mod shape;

use std::fmt;

use crate::WorldDef;
pub use goal::{goal, within};
pub use league::{league, missing_on_map, scored_goal, team, victim_rule};
pub use limits::*;
pub use map::{conveyor, map, map_solid, material, named_pose, object, smoke, sound, spawned_object, tag, victim};
pub use robot::{
    actuator, aerial, battery, body_solid, check_robot, gripper, link, part, robot, rollers, sensor, tool_changer,
    vacuum, visual, wheel,
};
pub use scenario::scenario;

/// A closed range of numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    /// Lower end.
    pub least: f64,
    /// Upper end.
    pub most: f64,
    /// Unit of both ends with a space before it; empty for plain numbers.
    pub unit: &'static str,
}

/// A problem found in a scene.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SceneProblem {
    /// Location, such as `robot P3AT, wheel FLWheel`.
    pub place: String,
    /// Description of the problem and of the expected value.
    pub message: String,
}

impl fmt::Display for SceneProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.place, self.message)
    }
}

impl std::error::Error for SceneProblem {}

impl Range {
    /// Describes a number outside the range, named `key`; `None` if it is within.
    pub fn problem(self, key: &str, value: f64) -> Option<String> {
        (!self.holds(value)).then(|| format!("`{key}` is {}: expected {self}", Number(value)))
    }

    /// Describes a list with a number outside the range; `None` if all are within.
    pub fn problem_in(self, key: &str, values: &[f64]) -> Option<String> {
        let all = || values.iter().map(|&value| Number(value).to_string()).collect::<Vec<_>>().join(", ");
        (!values.iter().all(|&value| self.holds(value)))
            .then(|| format!("`{key}` is [{}]: expected numbers of {self}", all()))
    }

    /// True if a number is within the range.
    pub fn holds(self, value: f64) -> bool {
        (self.least..=self.most).contains(&value)
    }
}

impl fmt::Display for Range {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} to {}{}", Number(self.least), Number(self.most), self.unit)
    }
}

/// A number in its most readable form: 1e300 is not written with 300 zeros.
struct Number(f64);

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = self.0.abs();
        if size == 0.0 {
            f.write_str("0")
        } else if (1e-4..1e7).contains(&size) {
            write!(f, "{}", self.0)
        } else {
            write!(f, "{:e}", self.0)
        }
    }
}

impl WorldDef {
    /// Checks a whole scene. A world with a scene that passes neither panics nor loses a finite state.
    ///
    /// # Errors
    /// Describes the first invalid number, name or count.
    pub fn check(&self) -> Result<(), SceneProblem> {
        first("the scene", count("classes of robots", self.robots.len(), MAX_ROBOTS))?;
        map::check_map(&self.map)?;
        map::check_classes(&self.objects)?;
        self.league.iter().try_for_each(|league| league::check_league(league, &self.map, &self.robots))?;
        self.scenario.iter().try_for_each(|it| scenario::check_scenario(it, self.league.as_ref(), &self.robots))?;
        // Those that are read later are checked by their readers.
        self.robots.read().try_for_each(|(_, robot)| robot::check_robot(robot))
    }
}

fn first(place: &str, messages: impl IntoIterator<Item = String>) -> Result<(), SceneProblem> {
    let problem = |message| SceneProblem { place: place.to_owned(), message };
    messages.into_iter().next().map_or(Ok(()), |message| Err(problem(message)))
}

/// Shortens and escapes a name from an untrusted scene for a message.
fn shown(name: &str) -> String {
    name.chars().take(60).flat_map(char::escape_debug).collect()
}

fn count(what: &str, got: usize, most: usize) -> Option<String> {
    (got > most).then(|| format!("{got} {what}: expected at most {most}"))
}

fn text(key: &str, got: &str) -> Option<String> {
    let length = got.chars().count();
    (length > MAX_TEXT).then(|| format!("`{key}` has {length} characters: expected at most {MAX_TEXT}"))
}

/// Checks a name that is only displayed.
fn name(key: &str, got: &str) -> Vec<String> {
    let length = got.chars().count();
    let good = (1..=MAX_NAME).contains(&length) && !got.contains(char::is_control);
    let problem = || format!("{key} `{}`: expected 1 to {MAX_NAME} characters, none of control", shown(got));
    (!good).then(problem).into_iter().collect()
}

/// Checks a name that is sent on the wire.
pub fn wire_name(key: &str, got: &str) -> Vec<String> {
    let length = got.chars().count();
    let apart = |c: char| c.is_whitespace() || c.is_control() || c == '{' || c == '}';
    let good = (1..=MAX_NAME).contains(&length) && !got.contains(apart);
    let problem = || format!("{key} `{}`: expected a name without spaces and braces", shown(got));
    (!good).then(problem).into_iter().collect()
}
