//! Texts between the page and the server, in JSON: each is defined here, and the page's types are generated from these.

use scene::{Score, Sensed, Standing, Standings};
use serde::{Deserialize, Serialize};

/// Longest text of a line for viewers, bytes. Longer ones are cut.
const MAX_TEXT: usize = 4096;
/// Most numbers of a quantity for viewers. Further ones are left out.
const MAX_VALUES: usize = 1024;

/// Most changes of points that a status has of each team.
const MAX_SCORES: usize = 8;

/// A request of a page.
#[derive(Debug, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub enum Request {
    /// The page's token, as in `{"token":".."}`. It comes first; a server without tokens ignores it.
    Token(String),
    /// A question, as in `{"fit":{"class":"P3AT","location":[1,0,0],"yaw":0.5}}`.
    Fit(Wanted),
    /// A number to be sent back, as in `{"echo":7}`. Frames after it are later than what the page had sent before.
    Echo(u32),
    /// `{"wire":true,"robots":[1]}`.
    #[serde(untagged)]
    Listen(Listen),
    /// `{"pause":true}`, `{"step":1}`, `{"speed":2.5}`, `"reset"`, `{"record":true}`, `"save"`, `{"remove":3}`, `{"map":"arena"}`, `{"scenario":"stairs"}`.
    #[serde(untagged)]
    Control(Control),
}

/// Lines, readings and pictures that a viewer wants beside frames and status.
#[derive(Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Listen {
    /// True for every line of the wire.
    pub wire: bool,
    /// Numbers of the robots whose readings it wants.
    #[serde(default)]
    pub robots: Vec<u64>,
    /// Numbers of the robots whose cameras' pictures it wants.
    #[serde(default)]
    pub cameras: Vec<u64>,
}

/// A request to the world's thread.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Control {
    /// Stops or resumes time.
    Pause(bool),
    /// A number of steps, after which time stops.
    Step(u32),
    /// Simulated seconds per real second; 0 is as fast as possible.
    Speed(f64),
    /// A fresh world of the same scene and seed. Connected clients get their robots back at their first poses.
    Reset,
    /// Starts or ends a log.
    Record(bool),
    /// Saves the world to a file.
    Save,
    /// Removes a robot, by its number. Its client stays.
    Remove(u64),
    /// A fresh world on another map, by name. Connected clients get their robots back.
    Map(String),
    /// A fresh world for a scenario, by name.
    Scenario(String),
}

/// A robot, and the pose at which it may have room.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(test, derive(ts_rs::TS))]
#[cfg_attr(test, ts(rename = "Fit"))]
pub struct Wanted {
    /// Its class.
    pub class: String,
    /// As in INIT, m.
    pub location: [f64; 3],
    /// Heading, rad.
    pub yaw: f64,
}

/// A text to a page.
#[derive(Debug, Serialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(test, derive(ts_rs::TS))]
pub enum Message<'a> {
    /// State that seldom changes.
    Status(Status),
    /// A line of the wire, for those who listen.
    Line(&'a Line),
    /// A reading of a sensor, for those who listen.
    Reading(&'a Measured),
    /// A notice, in words.
    Said(&'a str),
    /// Number of lines, readings and notices that came too fast.
    Missed(u64),
    /// An answer about room for a robot.
    Fit(Fit),
    /// A number that the page has sent.
    Echo(u32),
    /// The first text to a page.
    #[serde(untagged)]
    Greeting {
        /// Name of the page, as shown to everyone.
        you: &'a str,
        /// Reason why it may not control the world, if any.
        refused: Option<&'a str>,
    },
}

/// An answer: the question and its result.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
#[cfg_attr(test, ts(rename = "FitAnswer"))]
pub struct Fit {
    /// The question.
    #[serde(flatten)]
    pub wanted: Wanted,
    /// True if the robot can stand right there.
    pub stands: bool,
    /// The obstacle, in words.
    pub why: Option<String>,
}

/// A line of the wire.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
#[cfg_attr(test, ts(rename = "WireLine"))]
pub struct Line {
    /// Simulated time, s.
    pub time: f64,
    /// `in` from a client, `out` to it.
    #[cfg_attr(test, ts(type = "'in' | 'out'"))]
    pub direction: &'static str,
    /// The client's connection.
    pub connection: u64,
    /// The robot that it is for or about, if any.
    pub robot: Option<u64>,
    /// The line, cut if it is long.
    pub text: String,
}

/// A reading of a sensor, for viewers that show its numbers.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
#[cfg_attr(test, ts(rename = "Reading"))]
pub struct Measured {
    /// Simulated time, s.
    time: f64,
    /// Number of its robot.
    pub robot: u64,
    /// Number of the sensor in the robot's class.
    sensor: usize,
    #[serde(rename = "type")]
    type_name: &'static str,
    #[cfg_attr(test, ts(type = "{ name: string, unit: string, values: number[] }[]"))]
    quantities: Vec<scene::Quantity>,
}

impl Line {
    /// Cuts a text that is too long for viewers.
    pub fn cut(text: &str) -> String {
        if text.len() <= MAX_TEXT {
            return text.to_owned();
        }
        let start = text.char_indices().take_while(|(index, letter)| index + letter.len_utf8() <= MAX_TEXT);
        let start: String = start.map(|(_, letter)| letter).collect();
        format!("{start}.. ({} bytes in all)", text.len())
    }
}

impl Measured {
    /// Creates the text of a reading at a simulated time, s.
    pub fn new(time: f64, Sensed { robot, sensor, reading }: &Sensed) -> Self {
        let (type_name, mut quantities) = (reading.type_name(), reading.quantities());
        quantities.iter_mut().for_each(|quantity| quantity.values.truncate(MAX_VALUES));
        Self { time, robot: robot.0, sensor: *sensor, type_name, quantities }
    }
}

/// State that seldom changes.
#[derive(Debug, Default, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct Status {
    /// Simulated seconds per real second, over the last half second.
    pub real_time_factor: f64,
    /// Requested real-time factor; 0 is as fast as possible.
    pub speed: f64,
    /// True while time stands still.
    pub paused: bool,
    /// Number of the scene. When it changes, a page must fetch the scene again.
    pub scene: u64,
    /// Number of changes of the objects beside the map's. When it changes, a page must fetch them again.
    pub objects: u64,
    /// Open pages.
    pub viewers: usize,
    /// Number of times that the world started over.
    pub resets: u64,
    /// Number of times that the world was saved.
    pub saves: u64,
    /// Steps of robots whose contacts did not converge.
    pub unsettled_steps: u64,
    /// File of the log that is being written.
    pub recording: Option<String>,
    /// The league that is played, if any.
    pub league: Option<LeagueStatus>,
    /// All robots.
    pub robots: Vec<RobotStatus>,
    /// All clients.
    pub clients: Vec<ClientStatus>,
}

/// A league.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
#[cfg_attr(test, ts(rename = "League"))]
pub struct LeagueStatus {
    name: String,
    /// Simulated time that is left, s.
    time_left: f64,
    /// True from the first robot's arrival.
    has_begun: bool,
    /// True if the time is up.
    is_over: bool,
    /// Teams, the best first.
    teams: Vec<TeamStatus>,
}

/// A team of a league.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
struct TeamStatus {
    /// Place, from 1; equal points share one.
    place: usize,
    name: String,
    points: i64,
    /// Number of victims that it found.
    found: usize,
    /// Simulated time from the first robot's arrival to its last goal, when it has reached all, s.
    finished: Option<f64>,
    /// Names of the goals that it has reached, in that order.
    reached: Vec<String>,
    /// Numbers of the robots that entered for it.
    robots: Vec<u64>,
    /// The last changes of its points, newest first.
    #[cfg_attr(test, ts(type = "{ time: number, robot: number, reason: string, points: number, total: number }[]"))]
    scores: Vec<Score>,
}

impl LeagueStatus {
    /// Creates the status of a league.
    pub fn new(standings: Standings) -> Self {
        let team = |(place, team): (usize, &Standing)| TeamStatus {
            place,
            name: team.team.clone(),
            points: team.points,
            finished: team.finished,
            reached: team.scores.iter().filter_map(|score| Some(score.goal()?.to_owned())).collect(),
            found: team.scores.iter().filter(|score| score.is_found_victim()).count(),
            robots: team.robots.iter().map(|entrant| entrant.robot).collect(),
            scores: team.scores.iter().rev().take(MAX_SCORES).cloned().collect(),
        };
        Self {
            time_left: standings.time_left(),
            has_begun: standings.began.is_some(),
            is_over: standings.is_over,
            teams: standings.ranking().into_iter().map(team).collect(),
            name: standings.league,
        }
    }
}

/// A robot in the world.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct RobotStatus {
    /// Its number.
    pub id: u64,
    /// Its class.
    pub class: String,
    /// Its name; empty if it has none.
    pub name: String,
    /// The connection that it reports to.
    pub connection: Option<u64>,
    /// Battery life left, whole s.
    pub battery: Option<i32>,
}

/// A connected client.
#[derive(Debug, Serialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub struct ClientStatus {
    /// Its connection.
    pub connection: u64,
    /// Its address.
    pub peer: String,
    /// Lines received from it.
    pub lines: u64,
    /// Periodic lines dropped because it was too slow.
    pub dropped: u64,
    /// Bytes that wait to be sent to it.
    pub waiting_bytes: usize,
}

impl Request {
    /// Reads a request.
    ///
    /// # Errors
    /// Describes the problem.
    pub fn read(text: &str) -> Result<Self, String> {
        match serde_json::from_str(text) {
            Ok(Self::Control(control)) => control.checked().map(Self::Control),
            Ok(request) => Ok(request),
            // The error of an untagged enum says only that nothing fits. Most requests are controls.
            Err(error) => Err(format!(
                "{}: expected {{\"pause\":bool}}, {{\"step\":n}}, {{\"speed\":x}}, \"reset\", {{\"record\":bool}}, \"save\", \
                 {{\"remove\":robot}}, {{\"map\":name}}, {{\"scenario\":name}}, {{\"fit\":{{..}}}}, {{\"echo\":n}} or {{\"wire\":bool}}",
                serde_json::from_str::<Control>(text).err().unwrap_or(error)
            )),
        }
    }
}

impl Message<'_> {
    /// Returns the text.
    pub fn text(&self) -> String {
        // Every key is a string, so serialization cannot fail.
        serde_json::to_string(self).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use ts_rs::{Config, TS};

    use super::*;

    /// `UPDATE_FIGURES=1` renews the file.
    #[test]
    fn the_page_has_the_types_of_texts() {
        let config = Config::default().with_large_int("number");
        let declarations = [
            Request::decl(&config),
            Listen::decl(&config),
            Control::decl(&config),
            Wanted::decl(&config),
            Message::decl(&config),
            Fit::decl(&config),
            Line::decl(&config),
            Measured::decl(&config),
            Status::decl(&config),
            LeagueStatus::decl(&config),
            TeamStatus::decl(&config),
            RobotStatus::decl(&config),
            ClientStatus::decl(&config),
        ];
        let types: String = declarations.iter().map(|it| format!("\nexport {it}\n")).collect();
        let text = format!("// Generated from crates/page-protocol/src/live.rs by `make figures`.\n{types}");
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../viewer/src/protocol/live.gen.ts");
        if std::env::var_os("UPDATE_FIGURES").is_some() {
            std::fs::write(&path, &text).expect("a file");
        }
        let found = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(found == text, "{} is out of date: `make figures` renews it", path.display());
    }

    #[test]
    fn long_texts_are_cut_between_letters() {
        for (text, expected) in [
            ("short".to_owned(), "short".to_owned()),
            ("x".repeat(MAX_TEXT), "x".repeat(MAX_TEXT)),
            ("ä".repeat(5000), format!("{}.. (10000 bytes in all)", "ä".repeat(MAX_TEXT / 2))),
            (format!("x{}", "ä".repeat(5000)), format!("x{}.. (10001 bytes in all)", "ä".repeat(MAX_TEXT / 2 - 1))),
        ] {
            assert_eq!(Line::cut(&text), expected);
        }
    }

    #[test]
    fn a_wrong_request_is_told_what_was_expected() {
        for (text, expected) in [
            ("{\"pause\":1}", "invalid type: integer `1`, expected a boolean"),
            ("{\"drive\":1}", "unknown variant `drive`, expected one of `pause`, `step`"),
            ("{\"step\":0}", "`step` is 0: expected 1 to 100000"),
            ("{", "EOF while parsing"),
        ] {
            let error = Request::read(text).expect_err(text);
            assert!(error.contains(expected), "{text}: {error}");
        }
    }

    #[test]
    fn requests_are_read_and_limited() {
        let control = |control| Some(Request::Control(control));
        for (text, expected) in [
            ("{\"token\":\"secret\"}", Some(Request::Token("secret".to_owned()))),
            ("{\"token\":1}", None),
            ("{\"wire\":true}", Some(Request::Listen(Listen { wire: true, ..Listen::default() }))),
            ("{\"wire\":true,\"pause\":true}", None),
            ("{\"pause\":true,\"step\":1}", None),
            ("{\"fit\":{\"class\":\"P3AT\"}}", None),
            ("{\"echo\":7}", Some(Request::Echo(7))),
            ("{\"echo\":-1}", None),
            ("{\"echo\":4294967296}", None),
            ("{\"pause\":true}", control(Control::Pause(true))),
            ("{\"step\":5}", control(Control::Step(5))),
            ("{\"speed\":0}", control(Control::Speed(0.0))),
            ("\"reset\"", control(Control::Reset)),
            ("{\"record\":false}", control(Control::Record(false))),
            ("{\"map\":\"arena\"}", control(Control::Map("arena".to_owned()))),
            ("{\"scenario\":\"stairs\"}", control(Control::Scenario("stairs".to_owned()))),
            ("{\"remove\":3}", control(Control::Remove(3))),
            ("{\"remove\":-1}", None),
            ("{\"step\":0}", None),
            ("{\"step\":100001}", None),
            ("{\"speed\":-1}", None),
            ("{\"speed\":1e300}", None),
            ("{\"speed\":1e-300}", None),
            ("{\"speed\":1e-22}", None),
            ("{\"speed\":0.001}", control(Control::Speed(0.001))),
            ("{\"drive\":1}", None),
            ("{\"pause\":1}", None),
            ("", None),
        ] {
            assert_eq!(Request::read(text).ok(), expected, "{text}");
        }
    }
}
