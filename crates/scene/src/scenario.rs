//! Scenarios: something to do on a map, with robots, a goal and a time.

use serde::{Deserialize, Serialize};

use crate::{League, MapDef};

/// The description of a scenario. Its goals and starts are those of the world's league, in which it is the only team.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Scenario {
    /// Name, as in `usarsim serve --scenario stairs`.
    pub name: String,
    /// Title for people.
    pub title: String,
    /// One line about what is to be done.
    pub text: String,
    /// Keys that matter, in one line.
    pub keys: String,
    /// Robots that play, each at the start of its number.
    pub robots: Vec<ScenarioRobot>,
    /// Simulated times from the first robot's arrival within which all goals bring three stars and two, s. Later ones bring one.
    pub stars: [f64; 2],
    /// First place of the camera; the page looks at the first robot without it.
    pub camera: Option<Viewpoint>,
}

/// A map, and what is played on it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Setting {
    /// The map.
    pub map: MapDef,
    /// The league, if one is played.
    pub league: Option<League>,
    /// The scenario, if one is played.
    pub scenario: Option<Scenario>,
}

impl From<MapDef> for Setting {
    fn from(map: MapDef) -> Self {
        Self { map, ..Self::default() }
    }
}

/// A robot that plays.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct ScenarioRobot {
    /// Its class.
    pub class: String,
    /// Its name, which its start has as well.
    pub name: String,
}

/// A place to look from.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Viewpoint {
    /// Position of the camera, m.
    pub from: [f64; 3],
    /// Point in its middle, m.
    pub at: [f64; 3],
}

/// A scenario as a list shows it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ScenarioCard {
    /// Name.
    pub name: String,
    /// Title for people.
    pub title: String,
    /// One line about what is to be done.
    pub text: String,
    /// Keys that matter, in one line.
    pub keys: String,
    /// Name of the map.
    pub map: String,
    /// Classes of the robots.
    pub robots: Vec<String>,
    /// Simulated time to its end, s.
    pub time_limit: f64,
    /// Times for three stars and two, s.
    pub stars: [f64; 2],
    /// Place in lists: those with a smaller number come first.
    pub rank: u32,
}
