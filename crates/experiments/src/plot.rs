//! Pictures of results: lines over the steps, or one number a run over what was varied.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Once;

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::{FontStyle, register_font};
use serde::Deserialize;

use crate::plan::Run;
use crate::run::Outcome;

/// Size of a picture, pixels.
const SIZE: (u32, u32) = (760, 460);
/// Colours of the groups, told apart also by colour-blind readers (after Okabe and Ito).
const COLOURS: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(90, 90, 90),
    RGBColor(160, 140, 0),
];
/// The label that is the number of the step in place of a value of an axis.
const STEP: &str = "step";

/// A picture as an experiment file asks for it.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plot {
    /// Name of its file, and its number in the report.
    pub name: String,
    /// What it shows.
    pub title: String,
    /// `step`, or the name of an axis, `model` or `sample`.
    #[serde(default = "step")]
    x: String,
    /// What is drawn.
    pub y: Quantity,
    /// The axes by which runs are coloured.
    #[serde(default)]
    colour: Vec<String>,
    /// The mean over the samples in place of each.
    #[serde(default)]
    mean: bool,
    /// Values that are drawn, by axis.
    #[serde(default)]
    only: BTreeMap<String, Vec<String>>,
    /// Lines to compare with.
    #[serde(default, rename = "reference")]
    references: Vec<Reference>,
}

fn step() -> String {
    STEP.to_owned()
}

/// A number of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// Way along the main direction, m; up to a step, or after the last.
    Main,
    /// Way along the error direction, m.
    Error,
    /// Turned counterclockwise, rad.
    Yaw,
    /// Mean way of a step along the main direction, m.
    StepMain,
    /// Mean size of a step's error, m, whatever its sign.
    StepError,
    /// Angle that the wheels turned in all steps, rad.
    WheelsTurned,
    /// Way along the main direction over the angle that the wheels turned, m/rad.
    WayPerAngle,
}

impl Quantity {
    /// The number of a run after so many steps.
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
            Self::WayPerAngle => steps.iter().map(|step| step.main).sum::<f64>() / outcome.wheels_turned,
        }
    }

    /// Title of the axis, and what a number is multiplied with to be drawn.
    fn shown(self) -> (&'static str, f64) {
        match self {
            Self::Main => ("main movement, cm", 100.0),
            Self::Error => ("error, cm", 100.0),
            Self::Yaw => ("turned to the left, degrees", 180.0 / std::f64::consts::PI),
            Self::StepMain => ("mean step, cm", 100.0),
            Self::StepError => ("mean size of a step's error, mm", 1000.0),
            Self::WheelsTurned => ("wheels turned, rad", 1.0),
            Self::WayPerAngle => ("way over wheel angle, mm/rad", 1000.0),
        }
    }
}

/// A dashed line.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct Reference {
    /// What it is.
    label: String,
    /// Its value, in the unit of the quantity.
    #[serde(default)]
    value: f64,
    /// What each step adds to it.
    #[serde(default)]
    per_step: f64,
}

/// A picture that could not be written.
#[derive(Debug, thiserror::Error)]
#[error("{file}: {reason}")]
pub struct PlotError {
    file: String,
    reason: String,
}

/// Points of one colour that belong together.
struct Group {
    label: String,
    colour: RGBColor,
    lines: Vec<Vec<(f64, f64)>>,
}

impl Plot {
    /// Whether every label that it names is one of the runs'.
    pub(crate) fn check(&self, runs: &[Run]) -> Result<(), String> {
        let wrong = |what: String| Err(format!("plot `{}`: {what}", self.name));
        let known = |name: &str| runs.iter().any(|run| run.labels.iter().any(|(label, _)| label == name));
        let named = self.colour.iter().chain((self.x != STEP).then_some(&self.x)).chain(self.only.keys());
        for name in named {
            if !known(name) {
                return wrong(format!("unknown axis `{name}`"));
            }
        }
        for (name, values) in &self.only {
            let is = |run: &Run, value| run.labels.iter().any(|(label, v)| label == name && v == value);
            // A model that was not asked for is no mistake of the file.
            if let Some(value) = values.iter().find(|value| name != "model" && !runs.iter().any(|run| is(run, *value)))
            {
                return wrong(format!("`{name}` is never `{value}`"));
            }
        }
        if self.name.is_empty() || self.name.contains(['/', '\\']) {
            return wrong("expected a `name` for its file".to_owned());
        }
        Ok(())
    }

    /// Draws it as `<name>.svg` and `<name>.png`; false when none of the outcomes belongs to it.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn draw(&self, outcomes: &[Outcome], folder: &Path) -> Result<bool, PlotError> {
        static FONT: Once = Once::new();
        FONT.call_once(|| {
            // The font is known to be one.
            let _ = register_font("sans-serif", FontStyle::Normal, epaint_default_fonts::UBUNTU_LIGHT);
        });
        let (groups, categories) = self.groups(outcomes);
        if groups.is_empty() {
            return Ok(false);
        }
        let [svg, png] = ["svg", "png"].map(|ending| folder.join(format!("{}.{ending}", self.name)));
        let refused = |file: &Path, reason: String| PlotError { file: file.display().to_string(), reason };
        self.draw_on(&SVGBackend::new(&svg, SIZE).into_drawing_area(), &groups, &categories)
            .map_err(|reason| refused(&svg, reason.to_string()))?;
        self.draw_on(&BitMapBackend::new(&png, SIZE).into_drawing_area(), &groups, &categories)
            .map_err(|reason| refused(&png, reason.to_string()))?;
        Ok(true)
    }

    /// The lines, and the names on the x axis where its values are no numbers.
    fn groups(&self, outcomes: &[Outcome]) -> (Vec<Group>, Vec<String>) {
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
        let mut groups: Vec<Group> = Vec::new();
        for outcome in outcomes {
            let label = self.colour.iter().filter_map(|name| outcome.label(name)).collect::<Vec<_>>().join(" ");
            let index = groups.iter().position(|group| group.label == label).unwrap_or_else(|| {
                let colour = COLOURS[groups.len() % COLOURS.len()];
                groups.push(Group { label: label.clone(), colour, lines: Vec::new() });
                groups.len() - 1
            });
            groups[index].lines.push(points(outcome));
        }
        let over_axis = self.x != STEP;
        for group in &mut groups {
            if self.mean {
                group.lines = vec![mean(&group.lines.concat())];
            } else if over_axis {
                // The runs of a value above each other; only their mean would make a line.
                group.lines = vec![group.lines.concat()];
            }
        }
        (groups, categories)
    }

    fn draw_on<B: DrawingBackend>(
        &self,
        root: &DrawingArea<B, Shift>,
        groups: &[Group],
        categories: &[String],
    ) -> Result<(), DrawingAreaErrorKind<B::ErrorType>> {
        root.fill(&WHITE)?;
        let points = || groups.iter().flat_map(|group| group.lines.iter().flatten());
        let (y_title, scale) = self.y.shown();
        let [mut left, mut right] = bounds(points().map(|point| point.0));
        if categories.is_empty() {
            right += 0.02 * (right - left);
        } else {
            (left, right) = (-0.5, categories.len() as f64 - 0.5);
        }
        let reference =
            |line: &Reference, x: f64| scale * (line.value + line.per_step * if self.x == STEP { x } else { 1.0 });
        let ends = self.references.iter().flat_map(|line| [left, right].map(|x| reference(line, x)));
        let [low, high] = bounds(points().map(|point| point.1).chain(ends));
        let room = 0.06 * (high - low).max(1e-3 * scale);
        let caption = format!("{}  {}", self.name, self.title);
        let mut chart = ChartBuilder::on(root)
            .caption(caption, ("sans-serif", 17))
            .margin(12)
            .x_label_area_size(42)
            .y_label_area_size(64)
            .build_cartesian_2d(left..right, low - room..high + room)?;
        let named = |x: &f64| match categories.get(x.round() as usize) {
            Some(name) if (x - x.round()).abs() < 1e-6 && *x >= 0.0 => name.clone(),
            Some(_) | None if !categories.is_empty() => String::new(),
            _ => short(*x),
        };
        let x_labels = if categories.is_empty() { 11 } else { 2 * categories.len() + 1 };
        chart
            .configure_mesh()
            .x_labels(x_labels)
            .x_label_formatter(&named)
            .y_label_formatter(&|y| short(*y))
            .x_desc(if self.x == STEP { "step" } else { &self.x })
            .y_desc(y_title)
            .label_style(("sans-serif", 14))
            .light_line_style(WHITE)
            .bold_line_style(RGBColor(225, 225, 225))
            .draw()?;
        for group in groups {
            let colour = group.colour;
            for (index, line) in group.lines.iter().enumerate() {
                if self.mean || self.x == STEP {
                    let drawn = chart.draw_series(LineSeries::new(line.iter().copied(), colour.stroke_width(2)))?;
                    if index == 0 && !group.label.is_empty() {
                        drawn
                            .label(group.label.as_str())
                            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], colour.stroke_width(2)));
                    }
                }
                let drawn = chart.draw_series(line.iter().map(|&point| Circle::new(point, 3, colour.filled())))?;
                if index == 0 && !group.label.is_empty() && !self.mean && self.x != STEP {
                    drawn.label(group.label.as_str()).legend(move |(x, y)| Circle::new((x + 9, y), 3, colour.filled()));
                }
            }
        }
        for line in &self.references {
            let ends = [left, right].map(|x| (x, reference(line, x)));
            let dashes = DashedLineSeries::new(ends, 6, 4, BLACK.stroke_width(1));
            let label = chart.draw_series(dashes)?.label(line.label.as_str());
            label.legend(|(x, y)| PathElement::new([(x, y), (x + 18, y)], BLACK));
        }
        if !self.references.is_empty() || groups.iter().any(|group| !group.label.is_empty()) {
            chart
                .configure_series_labels()
                .position(SeriesLabelPosition::UpperLeft)
                .background_style(WHITE.mix(0.8))
                .border_style(RGBColor(200, 200, 200))
                .label_font(("sans-serif", 14))
                .draw()?;
        }
        root.present()
    }
}

/// The mean at each x, in the order of x.
fn mean(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut sorted = points.to_vec();
    sorted.sort_by(|a, b| a.0.total_cmp(&b.0));
    let of = |same: &[(f64, f64)]| (same[0].0, same.iter().map(|point| point.1).sum::<f64>() / same.len() as f64);
    sorted.chunk_by(|a, b| a.0 == b.0).map(of).collect()
}

/// Least and greatest, a little apart.
fn bounds(values: impl Iterator<Item = f64>) -> [f64; 2] {
    let [low, high] =
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)]);
    if high - low > 1e-9 { [low, high] } else { [low - 0.5, high + 0.5] }
}

/// A number of an axis without rounding noise.
fn short(value: f64) -> String {
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}
