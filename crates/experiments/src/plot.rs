//! Plots of results: lines over the steps, or one number per run over a varied value.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use charts::{Chart, ChartError, Series};
use serde::Deserialize;

use crate::plan::{Plan, Run, file_name};
use crate::run::Outcome;

/// Axis label for the step number instead of the value of an axis.
const STEP: &str = "step";

/// A plot requested by an experiment file.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plot {
    /// Name of its file, and its number in the report.
    pub name: String,
    /// Title.
    pub title: String,
    /// `step`, or the name of an axis, `model` or `sample`.
    #[serde(default = "step")]
    x: String,
    /// Plotted quantity.
    pub y: Quantity,
    /// Axes that set the colours of runs.
    #[serde(default)]
    colour: Vec<String>,
    /// True to plot the mean over the samples instead of each.
    #[serde(default)]
    mean: bool,
    /// Plotted values, by axis.
    #[serde(default)]
    only: BTreeMap<String, Vec<String>>,
    /// Lines for comparison.
    #[serde(default, rename = "reference")]
    references: Vec<Reference>,
}

fn step() -> String {
    STEP.to_owned()
}

/// A quantity of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// Travel along the main direction, m; up to a step, or after the last.
    Main,
    /// Travel along the error direction, m.
    Error,
    /// Counterclockwise turn, rad.
    Yaw,
    /// Mean travel of a step along the main direction, m.
    StepMain,
    /// Mean absolute error of a step, m.
    StepError,
    /// Angle that the wheels turned in all steps, rad.
    WheelsTurned,
    /// Travel along the main direction over the angle that the wheels turned, m/rad.
    #[serde(alias = "way_per_angle")]
    TravelPerAngle,
}

impl Quantity {
    /// Returns the quantity of a run after a number of steps.
    pub fn of(self, outcome: &Outcome, steps: usize) -> f64 {
        let steps = &outcome.steps[..steps.min(outcome.steps.len())];
        let count = steps.len().max(1) as f64;
        match self {
            Self::Main => steps.iter().map(|step| step.main).sum(),
            Self::Error => steps.iter().map(|step| step.error).sum(),
            Self::Yaw => steps.iter().map(|step| step.yaw).sum(),
            Self::StepMain => steps.iter().map(|step| step.main).sum::<f64>() / count,
            Self::StepError => steps.iter().map(|step| step.error.abs()).sum::<f64>() / count,
            Self::WheelsTurned => outcome.wheels_turned,
            Self::TravelPerAngle => steps.iter().map(|step| step.main).sum::<f64>() / outcome.wheels_turned,
        }
    }

    /// Returns the title of the axis, the scale to its unit, and the least height of the axis. The height keeps noise below that of
    /// any robot from being magnified.
    fn shown(self) -> (&'static str, f64, f64) {
        match self {
            Self::Main => ("main movement, cm", 100.0, 0.1),
            Self::Error => ("error, cm", 100.0, 0.1),
            Self::Yaw => ("turned to the left, degrees", 180.0 / std::f64::consts::PI, 0.1),
            Self::StepMain => ("mean step, cm", 100.0, 0.01),
            Self::StepError => ("mean size of a step's error, mm", 1000.0, 0.1),
            Self::WheelsTurned => ("wheels turned, rad", 1.0, 0.01),
            Self::TravelPerAngle => ("travel over wheel angle, mm/rad", 1000.0, 0.01),
        }
    }
}

/// A dashed line for comparison.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct Reference {
    /// Label.
    label: String,
    /// Value, in the unit of the quantity.
    #[serde(default)]
    value: f64,
    /// Increment per step.
    #[serde(default)]
    per_step: f64,
}

impl Plot {
    /// Returns a plot of the main movement against an axis.
    pub(crate) fn of_axis(axis: &str, colour: &[String]) -> Self {
        Self {
            name: format!("main-{}", file_name(axis)),
            title: format!("Main movement against {axis}"),
            x: axis.to_owned(),
            y: Quantity::Main,
            colour: colour.to_vec(),
            mean: false,
            only: BTreeMap::new(),
            references: Vec::new(),
        }
    }

    /// True if a run belongs to it.
    pub(crate) fn shows(&self, run: &Run) -> bool {
        self.only.iter().all(|(name, values)| run.label(name).is_some_and(|value| values.iter().any(|it| it == value)))
    }

    /// True if each sample has a line of its own.
    pub(crate) fn tells_samples_apart(&self) -> bool {
        !self.mean && (self.x == "sample" || self.colour.iter().any(|name| name == "sample"))
    }

    /// Checks that the runs have every label that the plot names.
    pub(crate) fn check(&self, plan: &Plan) -> Result<(), String> {
        let wrong = |what: String| Err(format!("plot `{}`: {what}", self.name));
        let known = |name: &str| !plan.values_of(name).is_empty();
        let named = self.colour.iter().chain((self.x != STEP).then_some(&self.x)).chain(self.only.keys());
        for name in named {
            if !known(name) {
                return wrong(format!("unknown axis `{name}`"));
            }
        }
        for (name, values) in &self.only {
            let known = plan.values_of(name);
            // A model that was not requested is no mistake of the file.
            if let Some(value) = values.iter().find(|value| name != "model" && !known.contains(value)) {
                return wrong(format!("`{name}` is never `{value}`"));
            }
        }
        if self.name.is_empty() || self.name.contains(['/', '\\']) {
            return wrong("expected a `name` for its file".to_owned());
        }
        Ok(())
    }

    /// True if its name is the number of a figure of a text, such as 7.2, and not only a file name.
    pub(crate) fn is_numbered(&self) -> bool {
        let parts = self.name.split_once('.');
        parts.is_some_and(|(chapter, number)| chapter.len() == 1 && number.parse::<u32>().is_ok())
    }

    /// Draws the plot as `<name>.svg` and `<name>.png`. Returns false if none of the outcomes belongs to it.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn draw(&self, outcomes: &[Outcome], folder: &Path) -> Result<bool, ChartError> {
        let (series, categories) = self.series(outcomes);
        if series.is_empty() {
            return Ok(false);
        }
        let (y_title, scale, least_height) = self.y.shown();
        let farthest = series.iter().flat_map(|series| series.lines.iter().flatten()).map(|point| point.0);
        let (left, right) = farthest.fold((0.0, 0.0), |(left, right): (f64, f64), x| (left.min(x), right.max(x)));
        // Category names are centred in their slots.
        let (left, right) = if categories.is_empty() { (left, right) } else { (-0.5, categories.len() as f64 - 0.5) };
        let reference = |line: &Reference| {
            let at = |x: f64| (x, scale * (line.value + line.per_step * if self.x == STEP { x } else { 1.0 }));
            (line.label.clone(), [at(left), at(right)])
        };
        let chart = Chart {
            title: if self.is_numbered() { format!("{}  {}", self.name, self.title) } else { self.title.clone() },
            x_title: self.x.clone(),
            y_title: y_title.to_owned(),
            references: self.references.iter().map(reference).collect(),
            least_height,
            series,
            categories,
            ..Chart::default()
        };
        self.files(folder).iter().try_for_each(|file| chart.write(file))?;
        Ok(true)
    }

    /// Returns the files that [`Plot::draw`] writes into a folder.
    pub(crate) fn files(&self, folder: &Path) -> [PathBuf; 2] {
        ["svg", "png"].map(|ending| folder.join(format!("{}.{ending}", self.name)))
    }

    /// Returns the series, and the names on the x axis if its values are not numbers.
    fn series(&self, outcomes: &[Outcome]) -> (Vec<Series>, Vec<String>) {
        let wanted = |outcome: &&Outcome| {
            self.only
                .iter()
                .all(|(name, values)| outcome.label(name).is_some_and(|value| values.iter().any(|v| v == value)))
        };
        let outcomes: Vec<&Outcome> = outcomes.iter().filter(wanted).collect();
        let scale = self.y.shown().1;
        let mut categories: Vec<String> = Vec::new();
        let values: Vec<&str> = outcomes.iter().filter_map(|outcome| outcome.label(&self.x)).collect();
        if values.iter().any(|value| value.parse::<f64>().is_err()) {
            values.iter().for_each(|value| {
                if !categories.iter().any(|known| known == value) {
                    categories.push((*value).to_owned());
                }
            });
        }
        let place = |outcome: &Outcome| {
            let value = outcome.label(&self.x).unwrap_or_default();
            let index = categories.iter().position(|known| known == value);
            index.map_or_else(|| value.parse().unwrap_or(0.0), |index| index as f64)
        };
        let points = |outcome: &Outcome| -> Vec<(f64, f64)> {
            let all = outcome.steps.len();
            if self.x == STEP {
                return (0..=all).map(|steps| (steps as f64, scale * self.y.of(outcome, steps))).collect();
            }
            vec![(place(outcome), scale * self.y.of(outcome, all))]
        };
        let mut all: Vec<Series> = Vec::new();
        for outcome in outcomes {
            let label = self.colour.iter().filter_map(|name| outcome.label(name)).collect::<Vec<_>>().join(" ");
            let index = all.iter().position(|series| series.label == label).unwrap_or_else(|| {
                let joined = self.mean || self.x == STEP;
                all.push(Series { label: label.clone(), lines: Vec::new(), joined, dots: true });
                all.len() - 1
            });
            all[index].lines.push(points(outcome));
        }
        for series in &mut all {
            if self.mean {
                series.lines = vec![mean(&series.lines.concat())];
            } else if self.x != STEP {
                // The runs of a value are above each other; only their mean would make a line.
                series.lines = vec![series.lines.concat()];
            }
        }
        (all, categories)
    }
}

/// Returns the mean at each x, in the order of x.
fn mean(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let of = |same: &[(f64, f64)]| (same[0].0, same.iter().map(|point| point.1).sum::<f64>() / same.len() as f64);
    sorted.chunk_by(|a, b| a.0 == b.0).map(of).collect()
}
