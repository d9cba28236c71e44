//! Published measurements of real robots, each beside its simulation.
//!
//! A file has one robot: its dimensions, its floor, what was measured, and the source of each number. Nothing in it is fitted to what the
//! simulation gives, but for tyres, which say so.

pub mod report;
mod robot;

use gamebots_proto::command::Init;
use include_dir::{Dir, include_dir};
use nalgebra::Vector3;
use scene::wrapped;
use serde::{Deserialize, Serialize};
use sim_core::{Options, World};

use crate::course::{Course, Motion, MotionError, drive, heading};
use crate::thesis::toml_files;
pub use robot::{Dimensions, Floor};

/// Speed of the faster side's wheels, m/s.
const SPEED: f64 = 0.4;
/// Most measurements of a file.
const MAX_ROWS: usize = 1000;
/// Greatest curvature: beyond it a robot hardly turns in the time of a measurement.
const MAX_CURVATURE: f64 = 1000.0;
/// Time in which a robot settles and comes to its speed, and time of a measurement, s.
const TIMES: [f64; 2] = [3.0, 6.0];

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
}

impl Row {
    /// True if the simulation agrees with the real robot.
    pub fn agrees(&self) -> bool {
        (self.ours - self.real).abs() <= self.within
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
        Self { what, real, spread, within, ours, curvature: None }
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
        let count = measured.turn.len() + measured.strafe.len();
        if count == 0 || count > MAX_ROWS {
            return Err(refused(format!("{count} of [[turn]] and [[strafe]]: expected 1 to {MAX_ROWS}")));
        }
        if !measured.strafe.is_empty() && measured.robot.rollers.is_none() {
            return Err(refused("[[strafe]] of a robot without `rollers`: expected a Mecanum robot".to_owned()));
        }
        if let Some(turn) = measured.turn.iter().find(|turn| !(0.0..=MAX_CURVATURE).contains(&turn.curvature)) {
            return Err(refused(format!("`curvature` is {}: expected 0 to {MAX_CURVATURE}", turn.curvature)));
        }
        let numbers = measured.turn.iter().map(|it| (it.chi, it.spread, it.within));
        let numbers = numbers.chain(measured.strafe.iter().map(|it| (it.ratio, it.spread, it.within)));
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

/// Runs every measurement of a file.
///
/// # Errors
/// When the world refuses the robot.
pub fn run(measured: &Measured) -> Result<Vec<Row>, MotionError> {
    let turn = |turn: &Turn| {
        let what = match turn.curvature {
            0.0 => "effective over geometric track, on the spot".to_owned(),
            curvature => format!("effective over geometric track, curvature {curvature}"),
        };
        let ours = chi(measured, turn.curvature)?;
        Ok(Row { curvature: Some(turn.curvature), ..Row::new(what, turn.chi, [turn.spread, turn.within], ours) })
    };
    let strafe = |strafe: &Strafe| {
        let what = if strafe.full_power { "top speed sideways over ahead" } else { "way sideways over ahead" };
        let ours = sideways(measured, strafe.full_power)?;
        Ok(Row::new(what.to_owned(), strafe.ratio, [strafe.spread, strafe.within], ours))
    };
    measured.turn.iter().map(turn).chain(measured.strafe.iter().map(strafe)).collect()
}

/// Measures the way sideways over the way ahead of a Mecanum robot: for the angle that its wheels turned, or in equal times.
fn sideways(measured: &Measured, full_power: bool) -> Result<f64, MotionError> {
    let Dimensions { radius, motor, .. } = &measured.robot;
    let speed = motor.filter(|_| full_power).map_or(SPEED / radius, |motor| motor.free_speed);
    let way = |motion: Motion| {
        let world = World::new(measured.robot.world(measured.floor), Options::default());
        let mut course = Course::start(world, robot::CLASS, 1, motion, speed)?;
        course.run(TIMES[1]);
        let travel = course.travel().ok_or_else(|| MotionError::UnknownRobot(robot::CLASS.to_owned()))?;
        let [ahead, aside, _] = travel.moved;
        Ok(ahead.hypot(aside) / if full_power { 1.0 } else { travel.turned })
    };
    Ok(way(Motion::Right)? / way(Motion::Forward)?)
}

/// Measures the effective over the geometric track at a curvature.
fn chi(measured: &Measured, curvature: f64) -> Result<f64, MotionError> {
    let Dimensions { track, radius, .. } = measured.robot;
    let mut world = World::new(measured.robot.world(measured.floor), Options::default());
    let location = Vector3::zeros().into();
    let mut problems = Vec::new();
    let init = Init { class_name: robot::CLASS.to_owned(), location, ..Init::default() };
    let id = world.init(&init, &mut problems).ok_or(MotionError::Refused(problems))?;
    let fast = SPEED / radius;
    let slow = fast * (curvature - 1.0) / (curvature + 1.0);
    world.execute(Some(id), &drive(&[("Left", fast), ("Right", slow)]), &mut Vec::new());
    let steps = |seconds: f64| (seconds / world.time_step()).round() as u64;
    let [before, during] = TIMES.map(steps);
    (0..before).for_each(|_| drop(world.step()));
    let difference = |world: &World| {
        let wheels = world.state(id).map(|(_, wheels)| wheels).unwrap_or_default();
        wheels.first().zip(wheels.get(1)).map_or(0.0, |(left, right)| left.angle - right.angle)
    };
    let heading = |world: &World| world.state(id).map_or(0.0, |(body, _)| heading(&body));
    let start = difference(&world);
    let (mut turned, mut last) = (0.0, heading(&world));
    for _ in 0..during {
        world.step();
        let now = heading(&world);
        turned += wrapped(now - last);
        last = now;
    }
    Ok((difference(&world) - start) * radius / (track * turned))
}
