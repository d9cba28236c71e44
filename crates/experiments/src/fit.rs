//! Fits of robot parameters to measured steps. A fit finds the values with the least distance from the measurements, their
//! confidence intervals, and the parameters that the measurements do not determine.
//!
//! The distance between a simulated and a measured step combines the travel in the plane and the turn. The turn counts as the
//! displacement of a point 0.3 m from the robot's middle. The fit minimises the root mean square over all measured steps.

mod bootstrap;
mod measured;
mod search;

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use charts::{Chart, Series};
use scene::DriveModel;
use scene_loader::LoadError;
use serde::{Deserialize, Serialize};

use self::bootstrap::{Bootstrap, bootstrap};
use self::measured::{Measured, measurements};
use self::search::Search;
use crate::plan::{Plan, PlanError, Run};
use crate::run::{RunError, Step};

/// Lever arm that converts a turn to a displacement, m: about the distance of a youBot's wheels from its middle.
const TURN_ARM: f64 = 0.3;
/// Finest resolution of any measurement, m.
const FINEST: f64 = 1e-4;
/// Correlation above which two parameters are only known together, if the interval of either is wide.
const CORRELATED: f64 = 0.9;
/// Fraction of the range above which an interval is wide and asks for caution.
const WIDE: f64 = 0.2;
/// Maximum number of parameters.
const MAX_PARAMETERS: usize = 8;

/// Contents of a fit file.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    description: String,
    experiment: String,
    measured: String,
    #[serde(default)]
    seed: u64,
    #[serde(rename = "parameter")]
    parameters: Vec<Parameter>,
}

/// A parameter to fit.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameter {
    /// Name in the report.
    pub name: String,
    /// Overrides `PATH=VALUE` with `{}` for the number.
    pub set: Vec<String>,
    /// Least and greatest value.
    pub range: [f64; 2],
    /// Start of the search; the middle of the range by default.
    pub start: Option<f64>,
}

/// A fit with its experiment and measurements.
#[derive(Debug, Clone)]
pub struct Fit {
    /// Name of the file without its ending.
    pub name: String,
    /// Question in a sentence.
    pub description: String,
    /// Parameters to fit.
    pub parameters: Vec<Parameter>,
    /// Files that it was read from.
    inputs: Vec<PathBuf>,
    plan: Plan,
    /// Samples of each measured setting; the prediction is their mean.
    settings: Vec<Vec<Run>>,
    measured: Vec<Measured>,
    seed: u64,
}

/// Errors of a fit.
#[derive(Debug, thiserror::Error)]
pub enum FitError {
    /// A file of the fit is wrong.
    #[error("{file}: {reason}")]
    File {
        /// The file.
        file: String,
        /// Description of the problem and of the expected value.
        reason: String,
    },
    /// Its experiment is wrong.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// A run failed.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The optimiser failed.
    #[error("the search failed: {0}")]
    Search(String),
    /// The caller broke it off.
    #[error("the search was broken off")]
    BrokenOff,
}

/// Result of a fit.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FitResult {
    /// Root mean square distance at the start, m.
    pub distance_before: f64,
    /// Root mean square distance with the fitted values, m.
    pub distance: f64,
    /// Standard deviation of repetitions of one step, m, if there are any.
    pub scatter: Option<f64>,
    /// Warning about the model, if the distance clearly exceeds the scatter.
    pub caution: Option<String>,
    /// Number of measured steps.
    pub steps: usize,
    /// Number of simulated runs.
    pub simulated: usize,
    /// Unit drawn again for the intervals: runs or steps.
    pub resampled: &'static str,
    /// Parameters in the order of the file.
    pub parameters: Vec<Estimate>,
}

/// Estimate of a parameter.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Estimate {
    /// Its name.
    pub name: String,
    /// Start of the search.
    pub start: f64,
    /// Best value; the start if no other value is better.
    pub value: f64,
    /// Interval of 95 % of the resampled measurements.
    pub interval: [f64; 2],
    /// Largest change of the steps over its range, root mean square, m.
    pub effect: f64,
    /// Warning; none for a well-known parameter.
    pub caution: Option<String>,
    /// Value and distance through its range with the other parameters at their best values, m.
    pub profile: Vec<[f64; 2]>,
}

impl Fit {
    /// Reads a fit, and its experiment and measurements from files beside it.
    ///
    /// # Errors
    /// Describes the first problem and names its file.
    pub fn read(file: &Path, model: Option<DriveModel>) -> Result<Self, FitError> {
        let wrong = |file: &Path, reason: &dyn std::fmt::Display| FitError::File {
            file: file.display().to_string(),
            reason: reason.to_string().trim_end().to_owned(),
        };
        let text = |file: &Path| {
            scene_loader::text(file).map_err(|error| match error {
                LoadError::Unreadable { reason, .. } => wrong(file, &reason),
                other => wrong(file, &other),
            })
        };
        let beside = |name: &str| -> PathBuf { file.parent().unwrap_or(Path::new("")).join(name) };
        let read: File = toml::from_str(&text(file)?).map_err(|reason| wrong(file, &reason))?;
        let File { description, experiment, measured, seed, parameters } = read;
        check(&parameters).map_err(|reason| wrong(file, &reason))?;
        let experiment = beside(&experiment);
        let mut plan = Plan::read(&experiment, &text(&experiment)?)?;
        let names = plan.runs();
        if let Some(model) = model {
            plan.keep_models(&[model]);
        }
        if plan.runs().is_empty() {
            return Err(wrong(&experiment, &"no runs with the drive model that is asked for"));
        }
        let table = beside(&measured);
        let (settings, measured) =
            measurements(&text(&table)?, &names, plan.runs()).map_err(|reason| wrong(&table, &reason))?;
        let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let inputs = vec![file.to_owned(), experiment, table];
        Ok(Self { name, description, parameters, inputs, plan, settings, measured, seed })
    }

    /// Returns the files that the fit was read from.
    pub fn inputs(&self) -> &[PathBuf] {
        &self.inputs
    }

    /// Returns the files that its results are written to: `fit.json`, and the pictures of [`Estimate::draw`].
    pub fn outputs(&self, folder: &Path) -> Vec<PathBuf> {
        let pictures = self.parameters.iter().flat_map(|parameter| pictures(&parameter.name, folder));
        std::iter::once(folder.join("fit.json")).chain(pictures).collect()
    }

    /// Finds the best values, `jobs` runs at a time. Calls `progress` with the distance, m, after every set of runs; it decides if the
    /// search goes on.
    ///
    /// # Errors
    /// When a run fails, the optimiser does, or `progress` breaks the search off.
    pub fn find(&self, jobs: usize, progress: impl Fn(f64) -> ControlFlow<()> + Sync) -> Result<FitResult, FitError> {
        let search = Search::new(self, jobs, &progress);
        let start: Vec<f64> = self.parameters.iter().map(Parameter::begin).collect();
        let before = search.predict(&start)?;
        let scatter = self.scatter();
        // A parameter that changes nothing over its whole range keeps its start.
        let mut effects = Vec::new();
        for index in 0..start.len() {
            let profile = search.profile(&start, index)?;
            effects.push(profile.iter().map(|(_, steps)| rms(steps, &before)).fold(0.0, f64::max));
        }
        let threshold = FINEST.max(2.0 * scatter.unwrap_or(0.0) / (self.measured.len() as f64).sqrt());
        let active: Vec<usize> = (0..start.len()).filter(|&index| effects[index] > threshold).collect();
        let best = search.minimise(&start, &active)?;
        let predicted = search.predict(&best)?;
        let bootstrap = bootstrap(self, &search, &best, &active)?;
        let mut parameters = Vec::new();
        for (index, parameter) in self.parameters.iter().enumerate() {
            let profile = search.profile(&best, index)?;
            let place = active.iter().position(|&other| other == index);
            let interval = place.map_or(parameter.range, |place| bootstrap.intervals[place]);
            let caution = match place {
                None => Some(format!(
                    "not identifiable: from {} to {} the steps change by at most {:.3} mm",
                    parameter.range[0],
                    parameter.range[1],
                    1e3 * effects[index]
                )),
                Some(place) => self.caution(&active, place, &best, &bootstrap),
            };
            parameters.push(Estimate {
                name: parameter.name.clone(),
                start: start[index],
                value: best[index],
                interval,
                effect: effects[index],
                caution,
                profile: profile.iter().map(|(value, steps)| [*value, self.distance(steps)]).collect(),
            });
        }
        let distance = self.distance(&predicted);
        let left = scatter.filter(|scatter| distance > 2.0 * scatter).map(|scatter| {
            format!(
                "the steps are {:.3} mm from the simulation and scatter by {:.3} mm: something that is not looked for matters, and \
                 the intervals do not contain it",
                1e3 * distance,
                1e3 * scatter
            )
        });
        Ok(FitResult {
            distance_before: self.distance(&before),
            distance,
            caution: left,
            scatter,
            steps: self.measured.len(),
            simulated: search.simulated(),
            resampled: bootstrap.resampled,
            parameters,
        })
    }

    /// Returns the warning for the active parameter at an index.
    fn caution(&self, active: &[usize], place: usize, best: &[f64], bootstrap: &Bootstrap) -> Option<String> {
        let range = |place: usize| self.parameters[active[place]].range;
        let at_end = |place: usize| {
            let ([least, greatest], [low, high]) = (range(place), bootstrap.intervals[place]);
            let value = best[active[place]];
            (value - least).min(greatest - value) < 0.01 * (greatest - least) || high <= low
        };
        if at_end(place) {
            return Some("at the end of its range: widen it, or fix this parameter; the others lean on it".to_owned());
        }
        let is_wide = |place: usize| {
            let ([least, greatest], [low, high]) = (range(place), bootstrap.intervals[place]);
            high - low > WIDE * (greatest - least)
        };
        let correlated = |other: &usize| *other != place && bootstrap.correlation[(place, *other)].abs() > CORRELATED;
        let unsure = |&other: &usize| is_wide(place) || is_wide(other) || at_end(other);
        if let Some(other) = (0..active.len()).filter(correlated).find(unsure) {
            let name = &self.parameters[active[other]].name;
            return Some(format!("known only together with `{name}`: what one gains the other can lose"));
        }
        let [low, high] = bootstrap.intervals[place];
        if !(low..=high).contains(&best[active[place]]) {
            return Some("the search did not settle: look at its picture (--out)".to_owned());
        }
        is_wide(place).then(|| "poorly known: the interval is much of the range".to_owned())
    }

    /// Returns the root mean square distance of predicted steps from the measured ones, m.
    fn distance(&self, predicted: &[Step]) -> f64 {
        let measured: Vec<Step> = self.measured.iter().map(|measured| measured.travel).collect();
        rms(predicted, &measured)
    }

    /// Returns the standard deviation of repetitions about the mean of their step, m, or `None` without repetitions.
    fn scatter(&self) -> Option<f64> {
        let mut groups: BTreeMap<(usize, usize), Vec<[f64; 3]>> = BTreeMap::new();
        for measured in &self.measured {
            groups.entry((measured.setting, measured.step)).or_default().push(parts(&measured.travel));
        }
        let (mut squares, mut freedom) = (0.0, 0);
        for group in groups.values() {
            let mean = |part: usize| group.iter().map(|travel| travel[part]).sum::<f64>() / group.len() as f64;
            let means = [mean(0), mean(1), mean(2)];
            squares +=
                group.iter().flat_map(|travel| (0..3).map(|part| (travel[part] - means[part]).powi(2))).sum::<f64>();
            freedom += group.len() - 1;
        }
        (freedom > 0).then(|| (squares / freedom as f64).sqrt())
    }
}

impl Parameter {
    fn begin(&self) -> f64 {
        self.start.unwrap_or((self.range[0] + self.range[1]) / 2.0)
    }

    fn part_of(&self, value: f64) -> f64 {
        (value - self.range[0]) / (self.range[1] - self.range[0])
    }
}

impl Estimate {
    /// Draws the distance through the range as `<name>.svg` and `<name>.png`.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn draw(&self, folder: &Path) -> Result<(), charts::ChartError> {
        let line = self.profile.iter().map(|[value, distance]| (*value, 1e3 * distance)).collect();
        let found = self.profile.iter().map(|[_, distance]| 1e3 * distance).fold(f64::INFINITY, f64::min);
        let chart = Chart {
            title: format!(
                "{}: {:.6}, 95 % from {:.6} to {:.6}",
                self.name, self.value, self.interval[0], self.interval[1]
            ),
            x_title: self.name.clone(),
            y_title: "distance from the measured steps, mm".to_owned(),
            series: vec![
                Series { label: "others as found".to_owned(), lines: vec![line], joined: true, dots: true },
                Series {
                    label: "interval".to_owned(),
                    lines: vec![self.interval.map(|x| (x, found)).to_vec()],
                    joined: true,
                    dots: true,
                },
            ],
            least_height: 0.1,
            ..Chart::default()
        };
        pictures(&self.name, folder).iter().try_for_each(|file| chart.write(file))
    }
}

/// Returns the files of a parameter's picture in a folder.
fn pictures(parameter: &str, folder: &Path) -> [PathBuf; 2] {
    let name: String = parameter.chars().map(|c| if c.is_alphanumeric() { c } else { '-' }).collect();
    ["svg", "png"].map(|ending| folder.join(format!("{name}.{ending}")))
}

fn check(parameters: &[Parameter]) -> Result<(), String> {
    if parameters.is_empty() || parameters.len() > MAX_PARAMETERS {
        return Err(format!("{} parameters: expected 1 to {MAX_PARAMETERS}", parameters.len()));
    }
    for (index, Parameter { name, set, range: [least, greatest], start }) in parameters.iter().enumerate() {
        let wrong = |what: String| Err(format!("parameter `{name}`: {what}"));
        if name.is_empty() || parameters[..index].iter().any(|other| other.name == *name) {
            return wrong("expected a name of its own".to_owned());
        }
        if !(least.is_finite() && greatest.is_finite() && least < greatest) {
            return wrong(format!("`range` is [{least}, {greatest}]: expected the least value first"));
        }
        if start.is_some_and(|start| !(*least..=*greatest).contains(&start)) {
            return wrong(format!("`start` is outside of {least} to {greatest}"));
        }
        if set.is_empty() || set.iter().any(|path| !path.contains("{}")) {
            return wrong("expected `set` with a {} for the number in each of its overrides".to_owned());
        }
    }
    Ok(())
}

/// Returns the mean of the steps of several runs.
fn mean<'a>(runs: impl Iterator<Item = &'a Vec<Step>>) -> Vec<Step> {
    let runs: Vec<&Vec<Step>> = runs.collect();
    let of = |index: usize, part: fn(&Step) -> f64| {
        runs.iter().filter_map(|steps| steps.get(index)).map(part).sum::<f64>() / runs.len() as f64
    };
    let count = runs.first().map_or(0, |steps| steps.len());
    let step = |index| Step { main: of(index, |s| s.main), error: of(index, |s| s.error), yaw: of(index, |s| s.yaw) };
    (0..count).map(step).collect()
}

/// Returns a step as three distances, m.
fn parts(step: &Step) -> [f64; 3] {
    [step.main, step.error, TURN_ARM * step.yaw]
}

fn rms(steps: &[Step], others: &[Step]) -> f64 {
    let squares = steps.iter().zip(others).flat_map(|(a, b)| {
        let (a, b) = (parts(a), parts(b));
        [0, 1, 2].map(|part| (a[part] - b[part]).powi(2))
    });
    (squares.sum::<f64>() / steps.len().max(1) as f64).sqrt()
}
