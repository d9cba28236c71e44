//! Environments of a task: what the classes of Gymnasium and PettingZoo are made of.

use std::sync::Arc;

use ::environments::{Autoreset, Outcomes, Task};
use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2, PyReadwriteArray1, PyReadwriteArray2};
use picture::Stage;
use pyo3::prelude::*;

use crate::arguments::{check_size, contiguous, pool};
use crate::batch::check_rows;
use crate::error;
use crate::picture::{array, draw};

/// Returns the names of the shipped tasks.
#[pyfunction]
pub(crate) fn tasks() -> Vec<String> {
    Task::shipped()
}

/// Environments of one task that are stepped together.
#[pyclass(module = "usarsim")]
pub(crate) struct Environments {
    environments: ::environments::Environments,
    stage: Option<Arc<Stage>>,
}

#[pymethods]
impl Environments {
    #[new]
    #[pyo3(signature = (task, count = 1, *, threads = 0))]
    fn new(py: Python, task: &str, count: usize, threads: usize) -> PyResult<Self> {
        let threads = pool(threads)?;
        let environments = py.detach(|| {
            let task = Task::load(task).map_err(error::task)?;
            ::environments::Environments::new(task, count, threads).map_err(error::task)
        })?;
        Ok(Self { environments, stage: None })
    }

    /// Begins an episode in the environments that `mask` marks, or in all, and writes their observations. Seeds begin the random numbers
    /// anew.
    #[pyo3(signature = (observations, seeds = None, mask = None))]
    fn reset(
        &mut self,
        py: Python,
        mut observations: PyReadwriteArray2<f32>,
        seeds: Option<Vec<u64>>,
        mask: Option<PyReadonlyArray1<bool>>,
    ) -> PyResult<()> {
        check_rows("observations", &observations, self.shape(self.observations()))?;
        let mask = mask.as_ref().map(|mask| mask.as_slice().map_err(|_| contiguous("mask"))).transpose()?;
        let rows = observations.as_slice_mut().map_err(|_| contiguous("observations"))?;
        let environments = &mut self.environments;
        py.detach(|| environments.reset(seeds.as_deref(), mask, rows)).map_err(error::task)
    }

    /// Plays one interval in every environment and writes the results into the arrays.
    #[pyo3(signature = (actions, autoreset, observations, rewards, terminated, truncated, successes, last_observations))]
    #[expect(clippy::too_many_arguments, reason = "one array each")]
    fn step(
        &mut self,
        py: Python,
        actions: PyReadonlyArray2<f32>,
        autoreset: &str,
        mut observations: PyReadwriteArray2<f32>,
        mut rewards: PyReadwriteArray2<f64>,
        mut terminated: PyReadwriteArray1<bool>,
        mut truncated: PyReadwriteArray1<bool>,
        mut successes: PyReadwriteArray1<bool>,
        mut last_observations: PyReadwriteArray2<f32>,
    ) -> PyResult<()> {
        let autoreset = match autoreset {
            "next_step" => Autoreset::NextStep,
            "same_step" => Autoreset::SameStep,
            "disabled" => Autoreset::Disabled,
            other => {
                let expected = "expected next_step, same_step or disabled";
                return Err(error::task(format_args!("unknown autoreset mode `{other}`: {expected}")));
            }
        };
        check_rows("actions", &actions, self.shape(self.actions()))?;
        check_rows("observations", &observations, self.shape(self.observations()))?;
        let actions = actions.as_slice().map_err(|_| contiguous("actions"))?;
        check_rows("rewards", &rewards, [self.count(), self.robots()])?;
        check_rows("last_observations", &last_observations, self.shape(self.observations()))?;
        let outcomes = Outcomes {
            observations: observations.as_slice_mut().map_err(|_| contiguous("observations"))?,
            rewards: rewards.as_slice_mut().map_err(|_| contiguous("rewards"))?,
            terminated: terminated.as_slice_mut().map_err(|_| contiguous("terminated"))?,
            truncated: truncated.as_slice_mut().map_err(|_| contiguous("truncated"))?,
            successes: successes.as_slice_mut().map_err(|_| contiguous("successes"))?,
            last_observations: last_observations.as_slice_mut().map_err(|_| contiguous("last_observations"))?,
        };
        let environments = &mut self.environments;
        py.detach(|| environments.step(actions, autoreset, outcomes)).map_err(error::task)
    }

    /// Draws the world of an environment: an array of rows, columns and colours.
    #[pyo3(signature = (environment = 0, size = [480, 320]))]
    fn picture<'py>(&mut self, py: Python<'py>, environment: usize, size: [usize; 2]) -> PyResult<Bound<'py, PyAny>> {
        check_size(size)?;
        let Some(world) = self.environments.world(environment) else {
            let count = self.environments.count();
            return Err(error::task(format_args!("environment: got {environment}, expected less than {count}")));
        };
        let stage = self.stage.get_or_insert_with(|| Arc::new(Stage::new(world.def()))).clone();
        let image = py.detach(|| draw(&stage, world, size, None, None));
        array(py, image)
    }

    fn __len__(&self) -> usize {
        self.environments.count()
    }

    fn __repr__(&self) -> String {
        let task = self.environments.task();
        let (name, count, actions, observations) = (&task.name, self.count(), task.actions(), task.observations());
        format!("Environments({name:?}, {count} with {actions} actions and {observations} observations a robot)")
    }

    /// Number of environments.
    #[getter]
    fn count(&self) -> usize {
        self.environments.count()
    }

    /// Name of the task.
    #[getter]
    fn name(&self) -> &str {
        &self.environments.task().name
    }

    /// Description of the task.
    #[getter]
    fn description(&self) -> &str {
        self.environments.task().description()
    }

    /// Number of robots in an environment.
    #[getter]
    fn robots(&self) -> usize {
        self.environments.task().robots()
    }

    /// Number of actions of a robot.
    #[getter]
    fn actions(&self) -> usize {
        self.environments.task().actions()
    }

    /// Number of observations of a robot.
    #[getter]
    fn observations(&self) -> usize {
        self.environments.task().observations()
    }

    /// Time between two actions, s.
    #[getter]
    fn control_interval(&self) -> f64 {
        self.environments.task().control_interval()
    }

    /// Actions until an episode is cut off.
    #[getter]
    fn horizon(&self) -> u32 {
        self.environments.task().horizon()
    }

    /// Hashes of the bits of every body, an environment each.
    #[getter]
    fn digests(&self) -> Vec<String> {
        let worlds = (0..self.environments.count()).filter_map(|number| self.environments.world(number));
        worlds.map(|world| format!("{:016x}", world.digest())).collect()
    }

    /// Returns new arrays for a step: observations, rewards, terminated, truncated, successes, last observations.
    #[expect(clippy::type_complexity, reason = "six arrays")]
    fn arrays<'py>(
        &self,
        py: Python<'py>,
    ) -> (
        Bound<'py, PyArray2<f32>>,
        Bound<'py, PyArray2<f64>>,
        Bound<'py, PyArray1<bool>>,
        Bound<'py, PyArray1<bool>>,
        Bound<'py, PyArray1<bool>>,
        Bound<'py, PyArray2<f32>>,
    ) {
        let (count, flags) = (self.count(), || PyArray1::zeros(py, [self.count()], false));
        let observations = || PyArray2::zeros(py, self.shape(self.observations()), false);
        let rewards = PyArray2::zeros(py, [count, self.robots()], false);
        (observations(), rewards, flags(), flags(), flags(), observations())
    }
}

impl Environments {
    /// Returns the shape of an array with this many numbers of each robot.
    fn shape(&self, numbers: usize) -> [usize; 2] {
        [self.count(), self.robots() * numbers]
    }
}
