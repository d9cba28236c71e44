//! Drawings of plots from the outcomes of runs.

use std::path::Path;

use charts::{Chart, ChartError, Series};

use super::{Plot, Quantity, Reference, STEP};
use crate::run::Outcome;

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
}

impl Plot {
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

    /// Returns the series, and the names on the x axis if its values are not numbers.
    fn series(&self, outcomes: &[Outcome]) -> (Vec<Series>, Vec<String>) {
        let wanted = |outcome: &&Outcome| self.shows(|name| outcome.label(name));
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
