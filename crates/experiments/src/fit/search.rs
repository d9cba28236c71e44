//! Simulated steps, and the search for the parameters with the least distance from the measured ones.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use argmin::core::{CostFunction, Executor, State};
use argmin::solver::neldermead::NelderMead;

use super::{FINEST, Fit, FitError, mean};
use crate::plan::Run;
use crate::run::{self, Step};

/// Number of values in the profile of a parameter.
const PROFILE: usize = 9;
/// Iterations of the search per parameter.
const ITERATIONS: u64 = 60;
/// Standard deviation of the simplex's distances at which the search ends, m.
const SETTLED: f64 = 1e-8;

/// Simulates steps for values of the parameters.
pub(super) struct Search<'a, P> {
    fit: &'a Fit,
    jobs: usize,
    simulated: AtomicUsize,
    progress: &'a P,
}

impl<'a, P: Fn(f64) -> ControlFlow<()> + Sync> Search<'a, P> {
    /// Creates a search; `progress` is called with the distance, m, after every set of runs, and decides if the search goes on.
    pub(super) fn new(fit: &'a Fit, jobs: usize, progress: &'a P) -> Self {
        Self { fit, jobs: jobs.max(1), simulated: AtomicUsize::new(0), progress }
    }

    /// Returns the number of simulated runs.
    pub(super) fn simulated(&self) -> usize {
        self.simulated.load(Ordering::Relaxed)
    }

    /// Returns the simulated counterparts of the measured steps.
    pub(super) fn predict(&self, values: &[f64]) -> Result<Vec<Step>, FitError> {
        let samples = self.simulate(values)?;
        let means: Vec<Vec<Step>> = samples.iter().map(|samples| mean(samples.iter())).collect();
        let measured = self.fit.measured.iter();
        let predicted: Vec<Step> = measured.map(|measured| means[measured.setting][measured.step]).collect();
        match (self.progress)(self.fit.distance(&predicted)) {
            ControlFlow::Continue(()) => Ok(predicted),
            ControlFlow::Break(()) => Err(FitError::BrokenOff),
        }
    }

    /// Returns the steps of every sample of every setting.
    pub(super) fn simulate(&self, values: &[f64]) -> Result<Vec<Vec<Vec<Step>>>, FitError> {
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

    /// Returns the steps for values of one parameter across its range.
    pub(super) fn profile(&self, values: &[f64], index: usize) -> Result<Vec<(f64, Vec<Step>)>, FitError> {
        let [least, greatest] = self.fit.parameters[index].range;
        (0..PROFILE)
            .map(|place| {
                let mut values = values.to_vec();
                values[index] = least + (greatest - least) * place as f64 / (PROFILE - 1) as f64;
                self.predict(&values).map(|steps| (values[index], steps))
            })
            .collect()
    }

    /// Finds the values of the active parameters with the least distance (Nelder and Mead).
    pub(super) fn minimise(&self, start: &[f64], active: &[usize]) -> Result<Vec<f64>, FitError> {
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

    /// Converts fractions of the ranges to values.
    fn values(&self, start: &[f64], active: &[usize], parts: &[f64]) -> Vec<f64> {
        let mut values = start.to_vec();
        for (&index, part) in active.iter().zip(parts) {
            let [least, greatest] = self.fit.parameters[index].range;
            values[index] = least + (greatest - least) * part.clamp(0.0, 1.0);
        }
        values
    }
}

/// Objective of the search, over fractions of the ranges.
struct Distance<'a, P> {
    search: &'a Search<'a, P>,
    start: &'a [f64],
    active: &'a [usize],
}

impl<P: Fn(f64) -> ControlFlow<()> + Sync> CostFunction for Distance<'_, P> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, parts: &Vec<f64>) -> Result<f64, argmin::core::Error> {
        let steps = self.search.predict(&self.search.values(self.start, self.active, parts))?;
        // A penalty keeps the search within the ranges.
        let outside: f64 = parts.iter().map(|part| (part - part.clamp(0.0, 1.0)).abs()).sum();
        Ok(self.search.fit.distance(&steps) * (1.0 + outside) + FINEST * outside)
    }
}
