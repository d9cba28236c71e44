//! What a text claims about an experiment, beside what was found.

use std::collections::BTreeMap;

use serde::Deserialize;

use crate::plot::Quantity;
use crate::run::Outcome;
use crate::table::mean_and_deviation;

/// A file of claims.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Claims {
    /// The claims, in the order of the text.
    #[serde(rename = "claim")]
    pub claims: Vec<Claim>,
}

/// One claim.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Claim {
    /// Lines of the text.
    pub line: String,
    /// What it says.
    pub text: String,
    /// The number that it gives for what is measured here, in `unit`.
    pub number: Option<f64>,
    /// How far from the number still agrees.
    #[serde(default)]
    pub within: f64,
    /// The range of numbers that its words mean, where it gives none.
    pub words: Option<[f64; 2]>,
    /// `cm`, `mm`, `degrees`, `%` or nothing.
    #[serde(default)]
    pub unit: String,
    /// What is measured; without it the claim is only commented.
    pub measure: Option<Measure>,
    /// What is said when the number agrees, or there is none.
    #[serde(default)]
    pub agrees: String,
    /// What is said when it does not.
    #[serde(default)]
    pub differs: String,
    /// The text contradicts itself here.
    #[serde(default)]
    pub inconsistent: bool,
}

/// A number taken from outcomes.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measure {
    /// Name of the experiment file.
    experiment: String,
    /// The runs, by the values of their axes.
    #[serde(default)]
    only: BTreeMap<String, String>,
    /// What of them.
    quantity: Quantity,
    /// `mean` over the runs, `spread` (standard deviation) or `largest` size.
    #[serde(default)]
    of: Statistic,
    /// The same of these other runs is subtracted.
    minus: Option<BTreeMap<String, String>>,
    /// Or divides it.
    over: Option<BTreeMap<String, String>>,
}

/// How many runs become a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Statistic {
    #[default]
    Mean,
    Spread,
    Largest,
}

/// What a claim came to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// The reference model found the same.
    Agrees,
    /// It did not.
    Differs,
    /// The text contradicts itself.
    Inconsistent,
    /// There is nothing to compare.
    Noted,
}

impl Verdict {
    /// A word for it.
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
    /// What a drive model found, in the claim's unit; `None` without runs of it.
    pub fn found(&self, outcomes: &[Outcome], model: &str) -> Option<f64> {
        let scale = match self.unit.as_str() {
            "cm" | "%" => 100.0,
            "mm" => 1000.0,
            "degrees" => 180.0 / std::f64::consts::PI,
            _ => 1.0,
        };
        self.measure.as_ref()?.value(outcomes, model).map(|value| scale * value)
    }

    /// By what the model `bodies` found.
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

    /// The sentence that goes with the verdict.
    pub fn sentence(&self, verdict: Verdict) -> &str {
        match verdict {
            Verdict::Differs | Verdict::Inconsistent => &self.differs,
            Verdict::Agrees | Verdict::Noted => &self.agrees,
        }
    }
}

impl Measure {
    fn value(&self, outcomes: &[Outcome], model: &str) -> Option<f64> {
        let value = self.of_runs(outcomes, model, &BTreeMap::new())?;
        match (&self.minus, &self.over) {
            (Some(other), _) => Some(value - self.of_runs(outcomes, model, other)?),
            (None, Some(other)) => Some(value / self.of_runs(outcomes, model, other)? - 1.0),
            (None, None) => Some(value),
        }
    }

    /// The statistic over the runs of `only`, with some of its values replaced.
    fn of_runs(&self, outcomes: &[Outcome], model: &str, instead: &BTreeMap<String, String>) -> Option<f64> {
        let mut wanted = self.only.clone();
        wanted.extend(instead.clone());
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
