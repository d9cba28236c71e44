//! Parameters of a robot from measured steps: the values whose simulated steps come nearest, how sure they are, and which of
//! them the measurements say nothing about.
//!
//! The distance of a simulated from a measured step is that of two points of the robot: the way in the plane, and what it turned
//! as the way of a point 0.3 m from its middle. What is minimised is its root mean square over all measured steps.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use argmin::core::{CostFunction, Executor, State};
use argmin::solver::neldermead::NelderMead;
use charts::{Chart, Series};
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};
use sim_core::scene::DriveModel;

use crate::plan::{Plan, PlanError, Run};
use crate::run::{self, RunError, Step};

/// Where a turn counts as a way, m from the middle: about where a youBot's wheels are.
const TURN_ARM: f64 = 0.3;
/// What no one measures better than, m.
const FINEST: f64 = 1e-4;
/// Values of a parameter in its profile.
const PROFILE: usize = 9;
/// Part of a range that a derivative is taken over, either way.
const DIFFERENCE: f64 = 0.02;
/// Times that the measurements are drawn again.
const RESAMPLES: usize = 2000;
/// Blocks of which at least so many are drawn from; with fewer runs, steps are drawn.
const LEAST_BLOCKS: usize = 8;
/// Correlation from which on two parameters with wide intervals are only known together.
const CORRELATED: f64 = 0.9;
/// Iterations of the search for each parameter.
const ITERATIONS: u64 = 60;
/// The search ends when its last values are this near to each other in distance, m.
const SETTLED: f64 = 1e-8;
/// Part of its range from which on an interval asks for caution.
const WIDE: f64 = 0.2;
/// Most parameters.
const MAX_PARAMETERS: usize = 8;

/// A fit as its file says it.
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

/// A number that is looked for.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Parameter {
    /// Its name in the report.
    pub name: String,
    /// Overrides `PATH=VALUE` with `{}` where the number goes.
    pub set: Vec<String>,
    /// Least and greatest value.
    pub range: [f64; 2],
    /// Where the search begins; the middle of the range unless given.
    pub start: Option<f64>,
}

/// What was measured in a step of a run.
#[derive(Debug, Clone, PartialEq)]
struct Measured {
    /// Index into [`Fit::settings`].
    setting: usize,
    /// Which repetition of which run it is of.
    block: usize,
    /// Number of the step, from 0.
    step: usize,
    way: Step,
}

/// Everything that a fit needs.
#[derive(Debug, Clone)]
pub struct Fit {
    /// Name of the file without its ending.
    pub name: String,
    /// What is asked, in a sentence.
    pub description: String,
    /// What is looked for.
    pub parameters: Vec<Parameter>,
    plan: Plan,
    /// The samples of each setting that was measured; their mean is what the simulation says.
    settings: Vec<Vec<Run>>,
    measured: Vec<Measured>,
    seed: u64,
}

/// A fit that cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum FitError {
    /// A file of the fit is wrong.
    #[error("{file}: {reason}")]
    File {
        /// The file.
        file: String,
        /// What is wrong, and what was expected.
        reason: String,
    },
    /// Its experiment is wrong.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// A run cannot be made.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The optimiser gave up.
    #[error("the search failed: {0}")]
    Search(String),
}

/// What a fit found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Found {
    /// Root mean square distance at the start, m.
    pub distance_before: f64,
    /// The same with what was found, m.
    pub distance: f64,
    /// How much repetitions of the same step differ, m, where there are any.
    pub scatter: Option<f64>,
    /// What the distance says about the model, where it is clearly more than the scatter.
    pub caution: Option<String>,
    /// Measured steps.
    pub steps: usize,
    /// Runs that were simulated.
    pub simulated: usize,
    /// Whether runs or steps were drawn again for the intervals.
    pub resampled: &'static str,
    /// The parameters in the order of the file.
    pub parameters: Vec<Estimate>,
}

/// What is known of a parameter.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Estimate {
    /// Its name.
    pub name: String,
    /// Where the search began.
    pub start: f64,
    /// What fits best; the start where nothing does better.
    pub value: f64,
    /// What 95 % of the resampled measurements give.
    pub interval: [f64; 2],
    /// Largest change of the steps when it goes through its range, root mean square, m.
    pub effect: f64,
    /// What to be wary of; none for a parameter that is well known.
    pub caution: Option<String>,
    /// Value and distance through its range with the others as found, m.
    pub profile: Vec<[f64; 2]>,
}

impl Fit {
    /// Reads a fit, its experiment and its measurements, which are beside its file.
    ///
    /// # Errors
    /// With what is wrong in which file.
    pub fn read(file: &Path, model: Option<DriveModel>) -> Result<Self, FitError> {
        let wrong = |file: &Path, reason: &dyn std::fmt::Display| FitError::File {
            file: file.display().to_string(),
            reason: reason.to_string().trim_end().to_owned(),
        };
        let text = |file: &Path| std::fs::read_to_string(file).map_err(|reason| wrong(file, &reason));
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
        Ok(Self { name, description, parameters, plan, settings, measured, seed })
    }

    /// Looks for the values, `jobs` runs at a time; `progress` is told the distance, m, after every set of runs.
    ///
    /// # Errors
    /// When a run cannot be made.
    pub fn find(&self, jobs: usize, progress: impl Fn(f64) + Sync) -> Result<Found, FitError> {
        let search = Search { fit: self, jobs: jobs.max(1), simulated: AtomicUsize::new(0), progress: &progress };
        let start: Vec<f64> = self.parameters.iter().map(Parameter::begin).collect();
        let before = search.predict(&start)?;
        let scatter = self.scatter();
        // What moves nothing through its whole range is left where it is.
        let mut effects = Vec::new();
        for index in 0..start.len() {
            let profile = search.profile(&start, index)?;
            effects.push(profile.iter().map(|(_, steps)| rms(steps, &before)).fold(0.0, f64::max));
        }
        let threshold = FINEST.max(2.0 * scatter.unwrap_or(0.0) / (self.measured.len() as f64).sqrt());
        let active: Vec<usize> = (0..start.len()).filter(|&index| effects[index] > threshold).collect();
        let best = search.minimise(&start, &active)?;
        let predicted = search.predict(&best)?;
        let bootstrap = self.bootstrap(&search, &best, &active)?;
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
        Ok(Found {
            distance_before: self.distance(&before),
            distance,
            caution: left,
            scatter,
            steps: self.measured.len(),
            simulated: search.simulated.into_inner(),
            resampled: bootstrap.resampled,
            parameters,
        })
    }

    /// What to be wary of in the parameter at a place among those that act.
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
        let ([least, greatest], [low, high]) = (range(place), bootstrap.intervals[place]);
        let wide = high - low > WIDE * (greatest - least);
        let correlated = |other: &usize| *other != place && bootstrap.correlation[(place, *other)].abs() > CORRELATED;
        if let Some(other) = (0..active.len()).filter(correlated).find(|&other| wide || at_end(other)) {
            let name = &self.parameters[active[other]].name;
            return Some(format!("known only together with `{name}`: what one gains the other can lose"));
        }
        if !(low..=high).contains(&best[active[place]]) {
            return Some("the search did not settle: look at its picture (--out)".to_owned());
        }
        wide.then(|| "poorly known: the interval is much of the range".to_owned())
    }

    /// Root mean square distance of predicted steps from the measured ones, m.
    fn distance(&self, predicted: &[Step]) -> f64 {
        let measured: Vec<Step> = self.measured.iter().map(|measured| measured.way).collect();
        rms(predicted, &measured)
    }

    /// Standard deviation of repetitions about the mean of their step, m; `None` where nothing was repeated.
    fn scatter(&self) -> Option<f64> {
        let mut groups: BTreeMap<(usize, usize), Vec<[f64; 3]>> = BTreeMap::new();
        for measured in &self.measured {
            groups.entry((measured.setting, measured.step)).or_default().push(parts(&measured.way));
        }
        let (mut squares, mut freedom) = (0.0, 0);
        for group in groups.values() {
            let mean = |part: usize| group.iter().map(|way| way[part]).sum::<f64>() / group.len() as f64;
            let means = [mean(0), mean(1), mean(2)];
            squares += group.iter().flat_map(|way| (0..3).map(|part| (way[part] - means[part]).powi(2))).sum::<f64>();
            freedom += group.len() - 1;
        }
        (freedom > 0).then(|| (squares / freedom as f64).sqrt())
    }

    /// What other measurements of the same kind would have given: the measured runs or steps, and the samples of the simulation, are
    /// drawn again with replacement, and each time the least squares are solved with the derivatives at the best values.
    fn bootstrap<P: Fn(f64) + Sync>(
        &self,
        search: &Search<P>,
        best: &[f64],
        active: &[usize],
    ) -> Result<Bootstrap, FitError> {
        let count = active.len();
        let mut slopes = DMatrix::zeros(3 * self.measured.len(), count);
        for (column, &index) in active.iter().enumerate() {
            let [least, greatest] = self.parameters[index].range;
            let at = |value: f64| {
                let mut values = best.to_vec();
                values[index] = value.clamp(least, greatest);
                search.predict(&values).map(|steps| (values[index], steps))
            };
            let (low, below) = at(best[index] - DIFFERENCE * (greatest - least))?;
            let (high, above) = at(best[index] + DIFFERENCE * (greatest - least))?;
            for (row, (below, above)) in below.iter().zip(&above).enumerate() {
                for (part, (below, above)) in parts(below).iter().zip(parts(above)).enumerate() {
                    slopes[(3 * row + part, column)] = (above - below) / (high - low);
                }
            }
        }
        let blocks = self.measured.iter().map(|measured| measured.block).max().map_or(0, |last| last + 1);
        let by_run = blocks >= LEAST_BLOCKS;
        let mut members: Vec<Vec<usize>> = vec![Vec::new(); if by_run { blocks } else { self.measured.len() }];
        self.measured.iter().enumerate().for_each(|(row, m)| members[if by_run { m.block } else { row }].push(row));
        let samples = search.simulate(best)?;
        let mut draw = ChaCha8Rng::seed_from_u64(self.seed);
        let mut drawn: Vec<Vec<f64>> = vec![Vec::with_capacity(RESAMPLES); count];
        for _ in 0..RESAMPLES {
            // The simulation's samples are as much chance as the measured runs.
            let simulated: Vec<Vec<Step>> = samples
                .iter()
                .map(|samples| mean((0..samples.len()).map(|_| &samples[draw.random_range(0..samples.len())])))
                .collect();
            let (mut matrix, mut right) = (DMatrix::zeros(count, count), DVector::zeros(count));
            for _ in 0..members.len() {
                for &row in &members[draw.random_range(0..members.len())] {
                    let Measured { setting, step, way, .. } = &self.measured[row];
                    let slope = slopes.rows(3 * row, 3);
                    let missing = parts(way).into_iter().zip(parts(&simulated[*setting][*step])).map(|(m, p)| m - p);
                    matrix += slope.transpose() * slope;
                    right += slope.transpose() * DVector::from_iterator(3, missing);
                }
            }
            let Ok(change) = matrix.svd(true, true).solve(&right, 1e-12) else { continue };
            for (place, &index) in active.iter().enumerate() {
                let [least, greatest] = self.parameters[index].range;
                drawn[place].push((best[index] + change[place]).clamp(least, greatest));
            }
        }
        let few = samples.iter().map(Vec::len).filter(|&count| count > 1).chain([members.len()]).min().unwrap_or(1);
        let wider = small_sample_factor(few);
        let intervals = drawn.iter_mut().zip(active).map(|(values, &index)| {
            values.sort_by(f64::total_cmp);
            let at = |part: f64| values.get((part * (values.len() as f64 - 1.0)).round() as usize).copied();
            let [least, greatest] = self.parameters[index].range;
            [at(0.025), at(0.975)]
                .map(|end| (best[index] + wider * (end.unwrap_or(f64::NAN) - best[index])).clamp(least, greatest))
        });
        let intervals = intervals.collect();
        // Correlation of the estimates: of the inverse of the normal matrix, whose columns are scaled to be of one size first.
        let sizes: Vec<f64> = slopes.column_iter().map(|column| column.norm().max(f64::MIN_POSITIVE)).collect();
        let scaled = DMatrix::from_fn(slopes.nrows(), count, |row, column| slopes[(row, column)] / sizes[column]);
        let inverse = (scaled.transpose() * scaled + DMatrix::identity(count, count) * 1e-9).try_inverse();
        let inverse = inverse.unwrap_or_else(|| DMatrix::identity(count, count));
        let correlation = DMatrix::from_fn(count, count, |row, column| {
            inverse[(row, column)] / (inverse[(row, row)] * inverse[(column, column)]).sqrt()
        });
        Ok(Bootstrap { intervals, correlation, resampled: if by_run { "runs" } else { "steps" } })
    }
}

struct Bootstrap {
    /// Of the parameters that act.
    intervals: Vec<[f64; 2]>,
    correlation: DMatrix<f64>,
    resampled: &'static str,
}

/// Simulated steps for values of the parameters.
struct Search<'a, P> {
    fit: &'a Fit,
    jobs: usize,
    simulated: AtomicUsize,
    progress: &'a P,
}

impl<P: Fn(f64) + Sync> Search<'_, P> {
    /// The steps that the simulation has in the place of the measured ones.
    fn predict(&self, values: &[f64]) -> Result<Vec<Step>, FitError> {
        let samples = self.simulate(values)?;
        let means: Vec<Vec<Step>> = samples.iter().map(|samples| mean(samples.iter())).collect();
        let measured = self.fit.measured.iter();
        let predicted: Vec<Step> = measured.map(|measured| means[measured.setting][measured.step]).collect();
        (self.progress)(self.fit.distance(&predicted));
        Ok(predicted)
    }

    /// The steps of every sample of every setting.
    fn simulate(&self, values: &[f64]) -> Result<Vec<Vec<Vec<Step>>>, FitError> {
        let Fit { parameters, plan, settings, .. } = self.fit;
        let runs: Vec<&Run> = settings.iter().flatten().collect();
        let set: Vec<String> = parameters
            .iter()
            .zip(values)
            .flat_map(|(parameter, value)| parameter.set.iter().map(move |path| path.replace("{}", &value.to_string())))
            .collect();
        let (next, results) = (AtomicUsize::new(0), Mutex::new(BTreeMap::new()));
        let work = || {
            loop {
                let index = next.fetch_add(1, Ordering::Relaxed);
                let Some(run) = runs.get(index) else { return };
                let mut run = Run::clone(run);
                run.setup.set.extend(set.iter().cloned());
                let outcome = run::run(plan, &run, None);
                results.lock().unwrap_or_else(std::sync::PoisonError::into_inner).insert(index, outcome);
            }
        };
        std::thread::scope(|scope| (0..self.jobs.min(runs.len())).for_each(|_| drop(scope.spawn(work))));
        self.simulated.fetch_add(runs.len(), Ordering::Relaxed);
        let results = results.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
        let steps = results.into_values().map(|outcome| outcome.map(|outcome| outcome.steps));
        let steps = steps.collect::<Result<Vec<_>, _>>()?;
        let mut of_runs = steps.into_iter();
        Ok(settings.iter().map(|samples| of_runs.by_ref().take(samples.len()).collect()).collect())
    }

    /// The steps for values of one parameter through its range.
    fn profile(&self, values: &[f64], index: usize) -> Result<Vec<(f64, Vec<Step>)>, FitError> {
        let [least, greatest] = self.fit.parameters[index].range;
        (0..PROFILE)
            .map(|place| {
                let mut values = values.to_vec();
                values[index] = least + (greatest - least) * place as f64 / (PROFILE - 1) as f64;
                self.predict(&values).map(|steps| (values[index], steps))
            })
            .collect()
    }

    /// The values of least distance (Nelder and Mead), of the parameters that act.
    fn minimise(&self, start: &[f64], active: &[usize]) -> Result<Vec<f64>, FitError> {
        if active.is_empty() {
            return Ok(start.to_vec());
        }
        let cost = Distance { search: self, start, active };
        let first: Vec<f64> = active.iter().map(|&index| self.fit.parameters[index].part_of(start[index])).collect();
        let mut simplex = vec![first.clone()];
        simplex.extend((0..active.len()).map(|place| {
            let mut corner = first.clone();
            corner[place] += if corner[place] > 0.5 { -0.25 } else { 0.25 };
            corner
        }));
        let failed = |error: argmin::core::Error| match error.downcast::<FitError>() {
            Ok(error) => error,
            Err(error) => FitError::Search(error.to_string()),
        };
        let solver = NelderMead::new(simplex).with_sd_tolerance(SETTLED).map_err(failed)?;
        let iterations = ITERATIONS * active.len() as u64;
        let result =
            Executor::new(cost, solver).configure(|state| state.max_iters(iterations)).run().map_err(failed)?;
        let best = result.state().get_best_param().cloned().unwrap_or(first);
        Ok(self.values(start, active, &best))
    }

    /// Parts of the ranges as values.
    fn values(&self, start: &[f64], active: &[usize], parts: &[f64]) -> Vec<f64> {
        let mut values = start.to_vec();
        for (&index, part) in active.iter().zip(parts) {
            let [least, greatest] = self.fit.parameters[index].range;
            values[index] = least + (greatest - least) * part.clamp(0.0, 1.0);
        }
        values
    }
}

/// What is minimised, over parts of the ranges.
struct Distance<'a, P> {
    search: &'a Search<'a, P>,
    start: &'a [f64],
    active: &'a [usize],
}

impl<P: Fn(f64) + Sync> CostFunction for Distance<'_, P> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, parts: &Vec<f64>) -> Result<f64, argmin::core::Error> {
        let steps = self.search.predict(&self.search.values(self.start, self.active, parts))?;
        // Outside of the ranges it only gets worse.
        let outside: f64 = parts.iter().map(|part| (part - part.clamp(0.0, 1.0)).abs()).sum();
        Ok(self.search.fit.distance(&steps) * (1.0 + outside) + FINEST * outside)
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
        let name: String = self.name.chars().map(|c| if c.is_alphanumeric() { c } else { '-' }).collect();
        ["svg", "png"].iter().try_for_each(|ending| chart.write(&folder.join(format!("{name}.{ending}"))))
    }
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

/// The runs that were measured, and what was measured in them, from a table `run,step,main,error,yaw`. A run is called by the values
/// of its axes, or as in the steps.csv of an experiment.
fn measurements(text: &str, names: &[Run], runs: Vec<Run>) -> Result<(Vec<Vec<Run>>, Vec<Measured>), String> {
    #[derive(Deserialize)]
    struct Row {
        run: String,
        step: usize,
        main: f64,
        error: f64,
        yaw: f64,
    }
    let setting = |run: &Run| {
        let axes = run.labels.iter().filter(|(name, _)| name != "model" && name != "sample");
        let values = axes.map(|(_, value)| value.as_str()).collect::<Vec<_>>().join(" ");
        // An experiment that varies nothing is called by its name.
        if values.is_empty() { run.id.split('/').next().unwrap_or_default().to_owned() } else { values }
    };
    let mut kept: Vec<Vec<Run>> = Vec::new();
    let mut measured: Vec<Measured> = Vec::new();
    // How often a step of a run came, and the block of each repetition.
    let mut repeated: BTreeMap<(String, usize), usize> = BTreeMap::new();
    let mut blocks: BTreeMap<(String, usize), usize> = BTreeMap::new();
    for row in csv::Reader::from_reader(text.as_bytes()).deserialize() {
        let Row { run: name, step, main, error, yaw } = row.map_err(|error: csv::Error| error.to_string())?;
        let wrong = |what: String| format!("run `{name}`, step {step}: {what}");
        // In a steps.csv the sample is the last part; there may be more of them than the simulation has.
        let stem = |id: &str| id.rsplit_once('-').map(|(stem, _)| stem.to_owned());
        let same = |run: &&Run| run.id == name || stem(&run.id).is_some_and(|of| stem(&name) == Some(of));
        let wanted = names.iter().find(same).map_or_else(|| name.clone(), setting);
        let Some(run) = runs.iter().find(|run| setting(run) == wanted) else {
            let mut known: Vec<String> = runs.iter().map(setting).collect();
            known.dedup();
            return Err(wrong(format!("the experiment has no such run: expected one of {}", known.join(", "))));
        };
        if step == 0 || step > run.setup.steps() as usize {
            return Err(wrong(format!("expected a step from 1 to {}", run.setup.steps())));
        }
        if ![main, error, yaw].iter().all(|number| number.is_finite()) {
            return Err(wrong("a number is not finite".to_owned()));
        }
        let index = kept.iter().position(|samples| samples[0].id == run.id).unwrap_or_else(|| {
            let same = |other: &&Run| setting(other) == wanted && other.drive_model == run.drive_model;
            kept.push(runs.iter().filter(same).cloned().collect());
            kept.len() - 1
        });
        let times = repeated.entry((name.clone(), step)).or_default();
        let new = blocks.len();
        let block = *blocks.entry((name, *times)).or_insert(new);
        *times += 1;
        measured.push(Measured { setting: index, block, step: step - 1, way: Step { main, error, yaw } });
    }
    if measured.is_empty() {
        return Err("expected a table `run,step,main,error,yaw`, m and rad, with at least one step".to_owned());
    }
    Ok((kept, measured))
}

/// How much wider an interval of 95 % is that was drawn from few things: draws scatter by too little, and their scatter is itself
/// uncertain (Hesterberg, "What teachers should know about the bootstrap", 2015, section 4.3; Student's t by its expansion in 1 / n).
fn small_sample_factor(count: usize) -> f64 {
    const NORMAL: f64 = 1.959964;
    let freedom = (count.max(3) - 1) as f64;
    let (cube, fifth) = (NORMAL.powi(3), NORMAL.powi(5));
    let student = NORMAL
        + (cube + NORMAL) / (4.0 * freedom)
        + (5.0 * fifth + 16.0 * cube + 3.0 * NORMAL) / (96.0 * freedom * freedom);
    student / NORMAL * ((freedom + 1.0) / freedom).sqrt()
}

/// The mean of the steps of several runs.
fn mean<'a>(runs: impl Iterator<Item = &'a Vec<Step>>) -> Vec<Step> {
    let runs: Vec<&Vec<Step>> = runs.collect();
    let of = |index: usize, part: fn(&Step) -> f64| {
        runs.iter().filter_map(|steps| steps.get(index)).map(part).sum::<f64>() / runs.len() as f64
    };
    let count = runs.first().map_or(0, |steps| steps.len());
    let step = |index| Step { main: of(index, |s| s.main), error: of(index, |s| s.error), yaw: of(index, |s| s.yaw) };
    (0..count).map(step).collect()
}

/// A step as ways, m.
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_of_few_samples_are_wider_as_student_says() {
        // Quantiles of Student's t at 97.5 % over the normal one, times sqrt(n / (n - 1)).
        for (count, expected) in [(6, 2.571 / 1.96 * 1.0954), (11, 2.228 / 1.96 * 1.0488), (101, 1.984 / 1.96 * 1.005)]
        {
            let factor = small_sample_factor(count);
            assert!((factor - expected).abs() < 0.02 * expected, "{count}: {factor}, expected {expected}");
        }
    }
}
