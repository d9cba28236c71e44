//! Experiment files and the runs that follow from them.

use std::collections::HashSet;
use std::ops::Range;
use std::path::{Path, PathBuf};

use scene::DriveModel;
use scene::check::TIME_STEP;
use scene_loader::Override;
use serde::Deserialize;

use crate::plot::{Plot, file_name};

/// Maximum number of runs of one file.
const MAX_RUNS: usize = 1_000_000;
/// Maximum number of values of an axis.
const MAX_VALUES: usize = 10_000;
/// Longest run, simulated s.
const MAX_SECONDS: f64 = 24.0 * 3600.0;

/// An experiment file.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// Name of the file without its ending; set by [`Plan::read`].
    #[serde(skip)]
    pub name: String,
    /// Text of the file; set by [`Plan::read`].
    #[serde(skip)]
    pub text: String,
    /// Question in a sentence.
    pub description: String,
    /// Names of the drive models; without any, the robot's own model runs.
    #[serde(default, rename = "drive_models")]
    model_names: Vec<String>,
    /// Drive models, or `None` for the robot's own; set by [`Plan::read`].
    #[serde(skip)]
    models: Vec<Option<DriveModel>>,
    /// Repetitions of every combination, each with its own [`Tolerances`].
    #[serde(default = "one")]
    pub samples: u32,
    /// Seed from which the samples' seeds are derived.
    #[serde(default)]
    pub seed: u64,
    /// Length of a time step, s.
    #[serde(default = "time_step")]
    pub time_step: f64,
    /// Time that the robot stands before it drives, s.
    #[serde(default = "settling")]
    pub settling: f64,
    /// Variation between samples.
    #[serde(default)]
    pub tolerances: Tolerances,
    /// Setup that every run starts from.
    #[serde(default)]
    pub setup: Setup,
    /// Axes of variation; each combination of their values is a run.
    #[serde(default, rename = "axis")]
    pub axes: Vec<Axis>,
    /// Pictures of the results.
    #[serde(default, rename = "plot")]
    pub plots: Vec<Plot>,
    /// Numbers of the runs that are done, in their order; `None` for all.
    #[serde(skip)]
    kept: Option<Vec<usize>>,
}

fn one() -> u32 {
    1
}

fn time_step() -> f64 {
    sim_core::TIME_STEP
}

fn settling() -> f64 {
    0.5
}

/// Half widths of the uniform distributions that the samples are drawn from. Sample `n` has the same draw in every combination, so
/// that combinations differ only by their values.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Tolerances {
    /// Start position in the plane, m.
    pub position: f64,
    /// Heading at the start, rad.
    pub yaw: f64,
    /// Angle of the first roller of each wheel, rad.
    pub wheel_phase: f64,
    /// Friction of each wheel, as a fraction of it.
    pub friction: f64,
    /// Mass of the body, as a fraction of it.
    pub mass: f64,
}

/// Setup of a run. In an axis, given fields replace those of the setup before it; overrides add up.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Setup {
    /// Name of an axis value.
    pub name: String,
    /// Map by name or file.
    pub map: Option<String>,
    /// Robot by class or file.
    pub robot: Option<String>,
    /// Overrides `PATH=VALUE`, as for `--set`.
    pub set: Vec<String>,
    /// Start position, m; a robot inside the floor is lifted onto it.
    pub position: Option<[f64; 3]>,
    /// Roll, pitch and yaw at the start, rad.
    pub rotation: Option<[f64; 3]>,
    /// A DRIVE line, with or without its verb, sent at the beginning of every step.
    pub drive: Option<String>,
    /// Number of measured steps.
    pub steps: Option<u32>,
    /// Time of a step in motion, s.
    pub step_seconds: Option<f64>,
    /// Time of standing after each step, s.
    pub stop_seconds: Option<f64>,
    /// Lines at individual times, instead of `drive`.
    pub script: Vec<Event>,
    /// Direction of the main movement, forward and left, or its name.
    #[serde(deserialize_with = "direction")]
    pub main: Option<[f64; 2]>,
    /// Direction of the error, in the same form.
    #[serde(deserialize_with = "direction")]
    pub error: Option<[f64; 2]>,
}

/// Directions by name: forward, left.
const DIRECTIONS: [(&str, [f64; 2]); 4] =
    [("forward", [1.0, 0.0]), ("backward", [-1.0, 0.0]), ("left", [0.0, 1.0]), ("right", [0.0, -1.0])];

fn direction<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<Option<[f64; 2]>, D::Error> {
    #[derive(Deserialize)]
    #[serde(untagged, expecting = "expected forward, backward, left, right, or [forward, left] as in [1.0, 0.0]")]
    enum Direction {
        Name(String),
        Vector([f64; 2]),
    }
    match Direction::deserialize(deserializer)? {
        Direction::Vector(direction) => Ok(Some(direction)),
        Direction::Name(name) => match DIRECTIONS.iter().find(|(known, _)| *known == name) {
            Some((_, direction)) => Ok(Some(*direction)),
            None => Err(serde::de::Error::custom(format!(
                "unknown direction `{name}`{}: expected forward, backward, left, right, or [forward, left] as in [1.0, 0.0]",
                names::did_you_mean(&name, DIRECTIONS.map(|(known, _)| known))
            ))),
        },
    }
}

/// Returns a DRIVE line, with its verb added if it is missing.
pub fn drive_line(text: &str) -> String {
    if text.trim_start().starts_with('{') { format!("DRIVE {text}") } else { text.to_owned() }
}

/// A line or a velocity sent at a time.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Event {
    /// Time after the start of the measurement, s.
    pub at: f64,
    /// A line of the wire.
    pub line: Option<String>,
    /// A velocity to drive from this time on: forward (m/s), left (m/s), counterclockwise (rad/s).
    pub velocity: Option<[f64; 3]>,
}

/// An axis of variation.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Axis {
    /// Name in tables and plots.
    pub name: String,
    /// Setups by name.
    #[serde(default)]
    values: Vec<Setup>,
    /// Overrides with `{}` for the number.
    #[serde(default)]
    set: Vec<String>,
    /// Numbers.
    #[serde(default)]
    numbers: Vec<f64>,
    /// First, last and distance of the numbers, instead of a list.
    range: Option<[f64; 3]>,
}

/// One run.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// `plan/value-value-model-sample`, a name for files.
    pub id: String,
    /// Values of the axes by name, then `model` and `sample`.
    pub labels: Vec<(String, String)>,
    /// Complete setup.
    pub setup: Setup,
    /// Drive model, or `None` for the robot's own.
    pub drive_model: Option<DriveModel>,
    /// Sample number, from 1.
    pub sample: u32,
}

/// An experiment file that cannot be run.
#[derive(Debug, thiserror::Error)]
#[error("{file}: {reason}")]
pub struct PlanError {
    file: String,
    reason: String,
}

impl Plan {
    /// Reads an experiment from its text. Relative paths of maps and robots refer to the file's folder.
    ///
    /// # Errors
    /// Gives the line of a mistake, or the number that is out of bounds.
    pub fn read(file: &Path, text: &str) -> Result<Self, PlanError> {
        let plan = Self::read_checked(file, text)?;
        let error = |reason| PlanError { file: file.display().to_string(), reason };
        plan.check().map_err(error)?;
        Ok(plan)
    }

    /// Reads an experiment that was checked before, without a look at every run.
    ///
    /// # Errors
    /// Gives the line of a mistake.
    pub fn read_checked(file: &Path, text: &str) -> Result<Self, PlanError> {
        let error =
            |reason: String| PlanError { file: file.display().to_string(), reason: reason.trim_end().to_owned() };
        let mut plan: Self = toml::from_str(text).map_err(|reason| error(reason.to_string()))?;
        plan.name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        text.clone_into(&mut plan.text);
        plan.beside(file.parent().unwrap_or(Path::new("")));
        let models = plan.model_names.iter().map(|name| name.parse().map(Some)).collect::<Result<Vec<_>, _>>();
        plan.models = models.map_err(error)?;
        if plan.models.is_empty() {
            plan.models = vec![None];
        }
        Ok(plan)
    }

    /// Returns every run that is kept, in the order of the axes, then models, then samples.
    pub fn runs(&self) -> Vec<Run> {
        let Some(kept) = &self.kept else { return self.runs_in(0..self.count()).collect() };
        kept.iter().flat_map(|&number| self.runs_in(number..number + 1)).collect()
    }

    /// Keeps only some runs.
    pub fn keep(&mut self, is_kept: impl Fn(&Run) -> bool) {
        let runs = self.runs_in(0..self.count()).enumerate();
        self.kept = Some(runs.filter(|(_, run)| is_kept(run)).map(|(number, _)| number).collect());
    }

    /// Returns the number of runs, whether they are kept or not.
    pub fn count(&self) -> usize {
        let values = self.axes.iter().map(|axis| axis.setups().len());
        values.fold(self.models.len().saturating_mul(self.samples as usize), usize::saturating_mul)
    }

    /// Returns the runs with these numbers in the order of all. Others take no time or memory.
    pub fn runs_in(&self, numbers: Range<usize>) -> impl Iterator<Item = Run> + '_ {
        let axes: Vec<Vec<Setup>> = self.axes.iter().map(Axis::setups).collect();
        (numbers.start..numbers.end.min(self.count())).map(move |number| self.run(&axes, number))
    }

    /// Returns a run by its number. Samples change fastest, then models, then the last axis.
    fn run(&self, axes: &[Vec<Setup>], number: usize) -> Run {
        let samples = self.samples as usize;
        let (sample, model) = (number % samples + 1, number / samples % self.models.len());
        let mut rest = number / samples / self.models.len();
        let mut values = Vec::new();
        for axis in axes.iter().rev() {
            values.push(&axis[rest % axis.len()]);
            rest /= axis.len();
        }
        values.reverse();
        let setup = values.iter().fold(self.setup.clone(), |setup, value| setup.with(value));
        let drive_model = self.models[model];
        let name = drive_model.map_or("own", DriveModel::name);
        let axes = self.axes.iter().zip(&values).map(|(axis, value)| (axis.name.clone(), value.name.clone()));
        let others = [("model", name.to_owned()), ("sample", sample.to_string())].map(|(k, v)| (k.to_owned(), v));
        let labels: Vec<(String, String)> = axes.chain(others).collect();
        let values: Vec<String> = labels.iter().map(|(_, value)| file_name(value)).collect();
        let id = format!("{}/{}", self.name, values.join("-"));
        Run { id, labels, setup, drive_model, sample: sample as u32 }
    }

    /// Returns its plots. A plan without any has the main movement against each axis.
    pub fn shown_plots(&self) -> Vec<Plot> {
        let colours: Vec<String> = Some("model".to_owned()).filter(|_| self.models.len() > 1).into_iter().collect();
        let plot = |axis: &Axis| Plot::of_axis(&axis.name, &colours);
        if self.plots.is_empty() { self.axes.iter().map(plot).collect() } else { self.plots.clone() }
    }

    /// Returns every value of a label, in the order of the runs; none if no run has the label.
    pub(crate) fn values_of(&self, label: &str) -> Vec<String> {
        let axis = self.axes.iter().filter(|axis| axis.name == label).flat_map(Axis::setups).map(|value| value.name);
        match label {
            "model" => self.models.iter().map(|model| model.map_or("own", DriveModel::name).to_owned()).collect(),
            "sample" => (1..=self.samples).map(|sample| sample.to_string()).collect(),
            _ => axis.collect(),
        }
    }

    /// Keeps only these models, in their order, with all runs. A plan without named models gets all of them. A plan that names none of them has no
    /// runs.
    pub fn keep_models(&mut self, models: &[DriveModel]) {
        let any = self.models == [None];
        let kept = models.iter().map(|&model| Some(model)).filter(|model| any || self.models.contains(model));
        self.models = kept.collect();
        self.kept = None;
    }

    fn beside(&mut self, folder: &Path) {
        let setups = self.axes.iter_mut().flat_map(|axis| &mut axis.values).chain([&mut self.setup]);
        let known = [scene_loader::map_names(), scene_loader::robot_names()].concat();
        for path in setups.flat_map(|setup| [&mut setup.map, &mut setup.robot]).flatten() {
            let file: PathBuf = folder.join(&path);
            // A folder is a map or a robot, unless it only has the name of a shipped one.
            if file.is_file() || file.is_dir() && !known.iter().any(|known| known.eq_ignore_ascii_case(path)) {
                *path = file.display().to_string();
            }
        }
    }

    fn check(&self) -> Result<(), String> {
        let within = |what: &str, value: f64, least: f64, most: f64| {
            let message = || format!("`{what}` is {value}: expected {least} to {most}");
            (least..=most).contains(&value).then_some(()).ok_or_else(message)
        };
        within("samples", f64::from(self.samples), 1.0, 10_000.0)?;
        within("time_step", self.time_step, TIME_STEP.least, TIME_STEP.most)?;
        within("settling", self.settling, 0.1, 60.0)?;
        let Tolerances { position, yaw, wheel_phase, friction, mass } = self.tolerances;
        let tolerances = [("position", position), ("yaw", yaw), ("wheel_phase", wheel_phase)];
        tolerances.into_iter().try_for_each(|(what, value)| within(what, value, 0.0, 10.0))?;
        [("friction", friction), ("mass", mass)]
            .into_iter()
            .try_for_each(|(what, value)| within(what, value, 0.0, 0.9))?;
        for axis in &self.axes {
            axis.check().map_err(|reason| format!("axis `{}`: {reason}", axis.name))?;
        }
        let count = self.count();
        if count > MAX_RUNS {
            return Err(format!("{count} runs: expected at most {MAX_RUNS}"));
        }
        let mut ids = HashSet::with_capacity(count);
        for run in self.runs_in(0..count) {
            run.setup.check().map_err(|reason| format!("run {}: {reason}", run.id))?;
            if let Some(id) = ids.replace(run.id) {
                return Err(format!("two runs are called {id}: expected values with different names"));
            }
        }
        self.plots.iter().try_for_each(|plot| plot.check(|name| self.values_of(name)))
    }
}

impl Axis {
    fn setups(&self) -> Vec<Setup> {
        let numbers = match self.range {
            Some([first, last, distance]) => {
                let count = ((last - first) / distance + 1e-9).floor() as usize + 1;
                (0..count.min(MAX_VALUES)).map(|index| first + index as f64 * distance).collect()
            }
            None => self.numbers.clone(),
        };
        let of_number = |number: f64| {
            // Rounding makes 0.1 + 2 x 0.1 read 0.3.
            let text = ((number * 1e9).round() / 1e9).to_string();
            let set = self.set.iter().map(|path| path.replace("{}", &text)).collect();
            Setup { name: text, set, ..Setup::default() }
        };
        self.values.iter().cloned().chain(numbers.into_iter().map(of_number)).collect()
    }

    fn check(&self) -> Result<(), String> {
        if let Some([first, last, distance]) = self.range
            && !(first.is_finite() && last >= first && distance > 0.0 && (last - first) / distance <= MAX_VALUES as f64)
        {
            return Err(format!(
                "`range` is [{first}, {last}, {distance}]: expected first <= last and a distance above 0"
            ));
        }
        let numbers = self.range.is_some() || !self.numbers.is_empty();
        if numbers && !self.set.iter().any(|path| path.contains("{}")) {
            return Err("numbers without a `set` that has a {} for them".to_owned());
        }
        if self.values.is_empty() && !numbers {
            return Err("expected `values`, or `set` with `numbers` or `range`".to_owned());
        }
        match self.values.iter().find(|value| value.name.is_empty()) {
            Some(_) => Err("a value without a `name`".to_owned()),
            None => Ok(()),
        }
    }
}

impl Setup {
    fn with(&self, other: &Self) -> Self {
        let set = self.set.iter().chain(&other.set).cloned().collect();
        let script = if other.script.is_empty() { &self.script } else { &other.script };
        Self {
            name: other.name.clone(),
            map: other.map.clone().or(self.map.clone()),
            robot: other.robot.clone().or(self.robot.clone()),
            set,
            position: other.position.or(self.position),
            rotation: other.rotation.or(self.rotation),
            drive: other.drive.clone().or(self.drive.clone()),
            steps: other.steps.or(self.steps),
            step_seconds: other.step_seconds.or(self.step_seconds),
            stop_seconds: other.stop_seconds.or(self.stop_seconds),
            script: script.clone(),
            main: other.main.or(self.main),
            error: other.error.or(self.error),
        }
    }

    /// Returns the map, `rough` by default.
    pub fn map(&self) -> &str {
        self.map.as_deref().unwrap_or("rough")
    }

    /// Returns the robot, `KUKA_YouBot` by default.
    pub fn robot(&self) -> &str {
        self.robot.as_deref().unwrap_or("KUKA_YouBot")
    }

    /// Returns the number of measured steps, 10 by default.
    pub fn steps(&self) -> u32 {
        self.steps.unwrap_or(10)
    }

    /// Returns the time from one measured pose to the next, s.
    pub fn interval(&self) -> f64 {
        self.step_seconds.unwrap_or(2.0) + self.stop_seconds.unwrap_or(0.0)
    }

    /// Parses the overrides.
    ///
    /// # Errors
    /// When one is not of the form `PATH=VALUE`.
    pub fn overrides(&self) -> Result<Vec<Override>, String> {
        self.set.iter().map(|text| text.parse::<Override>().map_err(|error| error.to_string())).collect()
    }

    /// Returns the lines in order of their times.
    pub fn lines(&self) -> Vec<(f64, String)> {
        let mut lines: Vec<(f64, String)> = self.script.iter().map(|event| (event.at, event.text())).collect();
        if let Some(drive) = &self.drive {
            let stop = self.stop_seconds.unwrap_or(0.0);
            for step in 0..self.steps() {
                let start = f64::from(step) * self.interval();
                lines.push((start, drive_line(drive)));
                if stop > 0.0 {
                    lines.push((start + self.interval() - stop, STOP.to_owned()));
                }
            }
            lines.push((f64::from(self.steps()) * self.interval(), STOP.to_owned()));
        }
        lines.sort_by(|a, b| a.0.total_cmp(&b.0));
        lines
    }

    fn check(&self) -> Result<(), String> {
        let seconds = f64::from(self.steps()) * self.interval();
        if !(self.step_seconds.unwrap_or(2.0) >= 0.1 && self.stop_seconds.unwrap_or(0.0) >= 0.0 && self.steps() > 0) {
            return Err(
                "expected `steps` of at least 1, `step_seconds` of at least 0.1 and no negative stop".to_owned()
            );
        }
        if seconds > MAX_SECONDS {
            return Err(format!("{seconds} s: expected at most {MAX_SECONDS}"));
        }
        if self.drive.is_none() == self.script.is_empty() {
            return Err("expected either `drive` or [[setup.script]]".to_owned());
        }
        let places = [self.position, self.rotation].into_iter().flatten().flatten();
        if places
            .chain(self.main.into_iter().flatten())
            .chain(self.error.into_iter().flatten())
            .any(|number| !number.is_finite() || number.abs() > 1e5)
        {
            return Err("a position, rotation or direction is not a number within 1e5".to_owned());
        }
        for event in &self.script {
            if !(0.0..=MAX_SECONDS).contains(&event.at) || event.line.is_some() == event.velocity.is_some() {
                return Err(format!("the event at {} s: expected a time and either `line` or `velocity`", event.at));
            }
        }
        self.overrides().map(drop)
    }
}

/// Line that stops the robot before standing, and at the end of a run. It has every key that moves a shipped robot.
const STOP: &str = "DRIVE {Front-Left 0}{Front-Right 0}{Back-Left 0}{Back-Right 0}{Left 0}{Right 0}";

impl Event {
    fn text(&self) -> String {
        match (&self.line, self.velocity) {
            (Some(line), _) => line.clone(),
            // The wire's lateral and rotational velocities are to the right and clockwise.
            (None, Some([forward, left, turn])) => format!(
                "DRIVE {{LinearVelocity {forward}}} {{LateralVelocity {}}} {{RotationalVelocity {}}}",
                -left, -turn
            ),
            (None, None) => String::new(),
        }
    }
}

impl Run {
    /// Returns the value of a label.
    pub(crate) fn label(&self, name: &str) -> Option<&str> {
        self.labels.iter().find(|(label, _)| label == name).map(|(_, value)| value.as_str())
    }
}
