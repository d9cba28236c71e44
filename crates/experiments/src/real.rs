//! Published measurements of real robots, each beside its simulation.
//!
//! A file has one robot: its dimensions, its floor, what was measured, and the source of each number. Nothing in it is fitted to what the
//! simulation gives, but for tyres, which say so.

mod measure;
pub mod report;
mod robot;

use include_dir::{Dir, include_dir};
use serde::{Deserialize, Serialize};

use crate::thesis::toml_files;
pub(crate) use measure::effective_track;
pub use measure::run;
pub use robot::{Dimensions, Floor};

/// Most measurements of a file.
const MAX_ROWS: usize = 1000;
/// Greatest curvature: beyond it a robot hardly turns in the time of a measurement.
const MAX_CURVATURE: f64 = 1000.0;
/// Greatest slope of a hill, rad.
const MAX_SLOPE: f64 = 0.5;

/// Greatest friction of the bearings of a robot that coasts. With more it does not roll down the slope of the measurement.
const MAX_BEARINGS: f64 = 0.1;

/// A robot and what was measured with it.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measured {
    /// Name of the robot.
    pub name: String,
    /// Publication or file that the numbers are from.
    pub source: String,
    /// Remark for the reader.
    pub note: Option<String>,
    /// Dimensions.
    pub robot: Dimensions,
    /// Floor.
    pub floor: Floor,
    /// Turns on the spot and curves.
    #[serde(default)]
    pub turn: Vec<Turn>,
    /// Motions of a Mecanum robot sideways over those ahead.
    #[serde(default)]
    pub strafe: Vec<Strafe>,
    /// Other quantities.
    #[serde(default)]
    pub figure: Vec<Figure>,
    /// Other simulators that were asked for a turn on the spot.
    #[serde(default)]
    pub other: Vec<Other>,
}

/// The turn of a robot with wheels that slide.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Turn {
    /// Sum of the sides' wheel speeds over their difference: 0 is a turn on the spot.
    pub curvature: f64,
    /// Effective over geometric track: difference of the wheel speeds over track and yaw rate.
    pub chi: f64,
    /// Standard deviation.
    pub spread: Option<f64>,
    /// Difference that counts as agreement, as a share of the number, if it is more than the standard deviation.
    pub within: Option<f64>,
}

/// A Mecanum robot's way sideways over its way ahead, for the same turning of its wheels.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Strafe {
    /// The ratio.
    pub ratio: f64,
    /// Standard deviation.
    pub spread: Option<f64>,
    /// Difference that counts as agreement, as in [`Turn`].
    pub within: Option<f64>,
    /// True if the motors had full power, so that the ratio is that of the top speeds.
    #[serde(default)]
    pub full_power: bool,
}

/// A figure of a robot.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Figure {
    /// Quantity.
    pub what: Quantity,
    /// Its value.
    pub value: f64,
    /// Slope of the hill for [`Quantity::Uphill`], rad.
    #[serde(default)]
    pub slope: f64,
    /// Standard deviation.
    pub spread: Option<f64>,
    /// Difference that counts as agreement, as in [`Turn`].
    pub within: Option<f64>,
}

/// Quantity of a [`Figure`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Quantity {
    /// Effective over geometric lx + ly of a Mecanum robot that turns on the spot.
    #[serde(rename = "lx-ly")]
    Sum,
    /// Deceleration of a Mecanum robot without power sideways less that ahead, m/s².
    Coasting,
    /// Highest step that the robot climbs, m: a limit that its maker names.
    Step,
    /// Steepest slope that the robot climbs, rad: a limit that its maker names.
    Slope,
    /// Way up a hill over the way on level ground, in the same time.
    Uphill,
}

impl Quantity {
    /// Returns its name for the table.
    fn name(self, slope: f64) -> String {
        match self {
            Self::Sum => "effective over geometric lx + ly".to_owned(),
            Self::Coasting => "coasting deceleration, sideways less ahead (m/s²)".to_owned(),
            Self::Step => "highest step (m), at least".to_owned(),
            Self::Slope => "steepest slope (rad), at least".to_owned(),
            Self::Uphill => format!("way up {slope:.3} rad over the way on level ground"),
        }
    }

    /// True if the robot has to reach the number, and may surpass it.
    fn is_limit(self) -> bool {
        matches!(self, Self::Step | Self::Slope)
    }

    /// True if only Mecanum robots have it.
    fn needs_rollers(self) -> bool {
        matches!(self, Self::Sum | Self::Coasting)
    }
}

/// Another simulator.
#[derive(Debug, Clone, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct Other {
    /// Its name.
    pub simulator: String,
    /// Factor of the track that its user needed for the robot's turn.
    pub chi: f64,
    /// Place where that stands.
    pub source: String,
}

/// One number beside its simulation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// Quantity.
    pub what: String,
    /// Number of the real robot.
    pub real: f64,
    /// Its standard deviation.
    pub spread: Option<f64>,
    /// Difference that counts as agreement.
    pub within: f64,
    /// Number in the simulation.
    pub ours: f64,
    /// Curvature of a turn.
    pub curvature: Option<f64>,
    /// True if the real number is a limit that the simulation has to reach.
    pub is_limit: bool,
}

impl Row {
    /// True if the simulation agrees with the real robot.
    pub fn agrees(&self) -> bool {
        (self.ours - self.real).abs() <= self.within || (self.is_limit && self.ours >= self.real)
    }

    /// Returns the difference to the real robot, percent.
    pub fn percent(&self) -> f64 {
        (self.ours / self.real - 1.0) * 100.0
    }

    /// Returns `agrees` or `differs`.
    pub fn verdict(&self) -> &'static str {
        if self.agrees() { "agrees" } else { "differs" }
    }

    fn new(what: String, real: f64, [spread, within]: [Option<f64>; 2], ours: f64) -> Self {
        let within = spread.unwrap_or(0.0).max(within.unwrap_or(0.0) * real);
        Self { what, real, spread, within, ours, curvature: None, is_limit: false }
    }
}

/// A robot and its rows.
#[derive(Debug, Clone)]
pub struct Compared {
    /// Name of the file, without its ending.
    pub id: String,
    /// Contents of the file.
    pub measured: Measured,
    /// Numbers beside their simulations.
    pub rows: Vec<Row>,
}

/// A file that is no measurement of a robot.
#[derive(Debug, thiserror::Error)]
#[error("{file}: {reason}")]
pub struct RealError {
    file: String,
    reason: String,
}

impl Measured {
    /// Reads a file's text.
    ///
    /// # Errors
    /// When the text is no TOML of this form, measures nothing, or has a robot that no world can have.
    pub fn read(file: &str, text: &str) -> Result<Self, RealError> {
        let refused = |reason: String| RealError { file: file.to_owned(), reason };
        let measured: Self = toml::from_str(text).map_err(|error| refused(error.to_string()))?;
        let count = measured.turn.len() + measured.strafe.len() + measured.figure.len();
        if count == 0 || count > MAX_ROWS {
            return Err(refused(format!("{count} of [[turn]], [[strafe]] and [[figure]]: expected 1 to {MAX_ROWS}")));
        }
        let sideways = measured.figure.iter().find(|it| it.what.needs_rollers()).map(|it| it.what.name(0.0));
        let sideways = sideways.or((!measured.strafe.is_empty()).then(|| "[[strafe]]".to_owned()));
        if let Some(sideways) = sideways.filter(|_| measured.robot.rollers.is_none()) {
            return Err(refused(format!("{sideways} of a robot without `rollers`: expected a Mecanum robot")));
        }
        let bearings = measured.robot.rollers.map_or(0.0, |rollers| rollers.bearing_friction);
        if bearings > MAX_BEARINGS && measured.figure.iter().any(|it| it.what == Quantity::Coasting) {
            return Err(refused(format!("`bearing_friction` is {bearings}: expected {MAX_BEARINGS} at most")));
        }
        if let Some(figure) = measured.figure.iter().find(|it| !(0.0..=MAX_SLOPE).contains(&it.slope)) {
            return Err(refused(format!("`slope` is {}: expected 0 to {MAX_SLOPE} rad", figure.slope)));
        }
        if let Some(turn) = measured.turn.iter().find(|turn| !(0.0..=MAX_CURVATURE).contains(&turn.curvature)) {
            return Err(refused(format!("`curvature` is {}: expected 0 to {MAX_CURVATURE}", turn.curvature)));
        }
        let numbers = measured.turn.iter().map(|it| (it.chi, it.spread, it.within));
        let numbers = numbers.chain(measured.strafe.iter().map(|it| (it.ratio, it.spread, it.within)));
        let numbers = numbers.chain(measured.figure.iter().map(|it| (it.value, it.spread, it.within)));
        let is_sound = |value: f64| value.is_finite() && value >= 0.0;
        for (value, spread, within) in numbers {
            if !(value > 0.0 && [Some(value), spread, within].into_iter().flatten().all(is_sound)) {
                return Err(refused(format!("a measured {value}: expected positive numbers")));
            }
        }
        measured.robot.check().map_err(refused)?;
        measured.robot.world(measured.floor).check().map_err(|error| refused(error.to_string()))?;
        Ok(measured)
    }
}

static FILES: Dir = include_dir!("$CARGO_MANIFEST_DIR/../../experiments/real");

/// Returns name and text of every file of the project, sorted by name.
pub fn files() -> Vec<(String, &'static str)> {
    toml_files(&FILES)
}
