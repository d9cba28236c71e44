//! Claims of a text about an experiment, compared with measurements.

use std::collections::BTreeMap;

use serde::Deserialize;

use crate::plan::Run;
use crate::plot::Quantity;
use crate::run::Outcome;
use crate::table::mean_and_deviation;

/// A file of claims.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Claims {
    /// Claims, in the order of the text.
    #[serde(rename = "claim")]
    pub claims: Vec<Claim>,
}

/// One claim.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Claim {
    /// Line numbers in the text.
    pub line: String,
    /// Statement of the text.
    pub text: String,
    /// Claimed value of the measured quantity, in `unit`.
    pub number: Option<f64>,
    /// Tolerance around the number.
    #[serde(default)]
    pub within: f64,
    /// Range of numbers that the words mean, if the text gives no number.
    pub words: Option<[f64; 2]>,
    /// `cm`, `mm`, `degrees`, `%` or nothing.
    #[serde(default)]
    pub unit: String,
    /// Measurement; without it the claim is only commented.
    pub measure: Option<Measure>,
    /// Comment for a number that agrees, or for a claim without one.
    #[serde(default)]
    pub agrees: String,
    /// Comment for a number that differs.
    #[serde(default)]
    pub differs: String,
    /// True if the text contradicts itself here.
    #[serde(default)]
    pub inconsistent: bool,
}

/// A number computed from outcomes.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measure {
    /// Name of the experiment file.
    experiment: String,
    /// Selects runs by the values of their axes.
    #[serde(default)]
    only: BTreeMap<String, String>,
    /// Quantity of these runs.
    quantity: Quantity,
    /// `mean` over the runs, `spread` (standard deviation) or `largest` magnitude.
    #[serde(default)]
    of: Statistic,
    /// Axis values of other runs; their statistic is subtracted.
    minus: Option<BTreeMap<String, String>>,
    /// Axis values of other runs; the result is the ratio to their statistic, less 1.
    over: Option<BTreeMap<String, String>>,
}

/// Statistic that reduces several runs to a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Statistic {
    #[default]
    Mean,
    Spread,
    Largest,
}

/// Result of comparing a claim with measurements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// The reference model found a value in the claimed range.
    Agrees,
    /// The reference model found another value.
    Differs,
    /// The text contradicts itself.
    Inconsistent,
    /// There is nothing to compare.
    Noted,
}

impl Verdict {
    /// Returns a word for the verdict.
    pub fn word(self) -> &'static str {
        match self {
            Self::Agrees => "agrees",
            Self::Differs => "differs",
            Self::Inconsistent => "thesis inconsistent",
            Self::Noted => "noted",
        }
    }
}

impl Claim {
    /// True if a run of an experiment counts for it.
    pub(crate) fn measures(&self, experiment: &str, run: &Run) -> bool {
        self.measure.as_ref().is_some_and(|measure| measure.experiment == experiment && measure.counts(run))
    }

    /// True if it is about how samples differ, not about their mean.
    pub(crate) fn tells_samples_apart(&self) -> bool {
        self.measure.as_ref().is_some_and(|measure| measure.of != Statistic::Mean)
    }

    /// Returns the value that a drive model found, in the claim's unit, or `None` without its runs.
    pub fn found(&self, outcomes: &[Outcome], model: &str) -> Option<f64> {
        let scale = match self.unit.as_str() {
            "cm" | "%" => 100.0,
            "mm" => 1000.0,
            "degrees" => 180.0 / std::f64::consts::PI,
            _ => 1.0,
        };
        self.measure.as_ref()?.value(outcomes, model).map(|value| scale * value)
    }

    /// Compares the claim with the value that the model `bodies` found.
    pub fn verdict(&self, outcomes: &[Outcome]) -> Verdict {
        if self.inconsistent {
            return Verdict::Inconsistent;
        }
        let around = |number: f64| [number - self.within, number + self.within];
        match (self.words.or(self.number.map(around)), self.found(outcomes, "bodies")) {
            (Some([least, most]), Some(found)) if (least..=most).contains(&found) => Verdict::Agrees,
            (Some(_), Some(_)) => Verdict::Differs,
            _ => Verdict::Noted,
        }
    }

    /// Returns the comment that goes with the verdict.
    pub fn sentence(&self, verdict: Verdict) -> &str {
        match verdict {
            Verdict::Differs | Verdict::Inconsistent => &self.differs,
            Verdict::Agrees | Verdict::Noted => &self.agrees,
        }
    }
}

impl Measure {
    /// True if a run is one of those that are measured or compared with.
    fn counts(&self, run: &Run) -> bool {
        let of = |values: &BTreeMap<String, String>| values.iter().all(|(name, value)| run.label(name) == Some(value));
        [None, self.minus.as_ref(), self.over.as_ref()].into_iter().any(|other| of(&self.wanted(other)))
    }

    /// Returns the wanted values, with some replaced by others.
    fn wanted(&self, instead: Option<&BTreeMap<String, String>>) -> BTreeMap<String, String> {
        let mut wanted = self.only.clone();
        wanted.extend(instead.into_iter().flatten().map(|(name, value)| (name.clone(), value.clone())));
        wanted
    }

    fn value(&self, outcomes: &[Outcome], model: &str) -> Option<f64> {
        let value = self.of_runs(outcomes, model, None)?;
        match (&self.minus, &self.over) {
            (Some(other), _) => Some(value - self.of_runs(outcomes, model, Some(other))?),
            (None, Some(other)) => Some(value / self.of_runs(outcomes, model, Some(other))? - 1.0),
            (None, None) => Some(value),
        }
    }

    /// Returns the statistic over the runs of `only`, with some of its values replaced.
    fn of_runs(&self, outcomes: &[Outcome], model: &str, instead: Option<&BTreeMap<String, String>>) -> Option<f64> {
        let wanted = self.wanted(instead);
        let fits = |outcome: &&Outcome| {
            outcome.experiment() == self.experiment
                && outcome.label("model") == Some(model)
                && wanted.iter().all(|(name, value)| outcome.label(name) == Some(value))
        };
        let numbers: Vec<f64> =
            outcomes.iter().filter(fits).map(|outcome| self.quantity.of(outcome, usize::MAX)).collect();
        if numbers.is_empty() {
            return None;
        }
        let (mean, deviation) = mean_and_deviation(numbers.iter().copied());
        Some(match self.of {
            Statistic::Mean => mean,
            Statistic::Spread => deviation,
            Statistic::Largest => numbers.iter().map(|number| number.abs()).fold(0.0, f64::max),
        })
    }
}
