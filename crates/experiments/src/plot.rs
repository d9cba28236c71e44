//! Plots of results: lines over the steps, or one number per run over a varied value.

mod drawn;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;

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

    /// True if a run belongs to it that has these labels, by axis.
    pub(crate) fn shows<'a>(&self, label: impl Fn(&str) -> Option<&'a str>) -> bool {
        self.only.iter().all(|(name, values)| label(name).is_some_and(|value| values.iter().any(|it| it == value)))
    }

    /// True if each sample has a line of its own.
    pub(crate) fn tells_samples_apart(&self) -> bool {
        !self.mean && (self.x == "sample" || self.colour.iter().any(|name| name == "sample"))
    }

    /// Checks that the runs have every label that the plot names. `values_of` returns the values of a label in all runs.
    pub(crate) fn check(&self, values_of: impl Fn(&str) -> Vec<String>) -> Result<(), String> {
        let wrong = |what: String| Err(format!("plot `{}`: {what}", self.name));
        let known = |name: &str| !values_of(name).is_empty();
        let named = self.colour.iter().chain((self.x != STEP).then_some(&self.x)).chain(self.only.keys());
        for name in named {
            if !known(name) {
                return wrong(format!("unknown axis `{name}`"));
            }
        }
        for (name, values) in &self.only {
            let known = values_of(name);
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

    /// Returns the files that [`Plot::draw`] writes into a folder.
    pub(crate) fn files(&self, folder: &Path) -> [PathBuf; 2] {
        ["svg", "png"].map(|ending| folder.join(format!("{}.{ending}", self.name)))
    }
}

/// Converts a value to a part of a file name.
pub(crate) fn file_name(value: &str) -> String {
    value.chars().map(|c| if c.is_alphanumeric() || "._".contains(c) { c } else { '_' }).collect()
}
