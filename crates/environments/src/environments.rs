//! Many environments that are stepped in one call.

use std::sync::Arc;

use sim_core::{World, in_parts};
use thread_pool::ThreadPool;

use crate::environment::Environment;
use crate::{BatchError, Task};

/// Number of environments that a thread takes at a time.
const ENVIRONMENTS_AT_A_TIME: usize = 8;
/// Maximum number of numbers in an array: 4 GB.
const MAX_NUMBERS: usize = 1 << 30;

/// Time at which an environment whose episode has ended begins the next one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Autoreset {
    /// In the next step, whose action has no effect and whose reward is 0.
    NextStep,
    /// At once. The step's observations are the first of the next episode.
    SameStep,
    /// When it is reset. Until then its steps change nothing.
    Disabled,
}

/// Places for the results of a step, environment by environment.
pub struct Outcomes<'a> {
    /// Observations of each robot.
    pub observations: &'a mut [f32],
    /// Reward of each robot.
    pub rewards: &'a mut [f64],
    /// True if the goal was reached, or cannot be reached any longer.
    pub terminated: &'a mut [bool],
    /// True if the time of the episode was up.
    pub truncated: &'a mut [bool],
    /// True if the goal was reached.
    pub successes: &'a mut [bool],
    /// Last observations of an episode, where [`Autoreset::SameStep`] replaced them. Others stay as they are.
    pub last_observations: &'a mut [f32],
}

/// Environments of one task. Environment `i` with the seed `s + i` is the same alone and among others, bit by bit.
pub struct Environments {
    task: Arc<Task>,
    environments: Vec<Environment>,
    threads: ThreadPool,
}

/// One environment's part of a step.
struct Job<'a> {
    environment: &'a mut Environment,
    actions: &'a [f32],
    observations: &'a mut [f32],
    rewards: &'a mut [f64],
    terminated: &'a mut bool,
    truncated: &'a mut bool,
    success: &'a mut bool,
    last_observations: &'a mut [f32],
}

impl Environments {
    /// Creates environments whose first episodes have not begun, with the seeds 0, 1, 2 and so on.
    ///
    /// # Errors
    /// When there are none, or too many.
    pub fn new(task: Task, count: usize, threads: ThreadPool) -> Result<Self, BatchError> {
        let numbers = task.robots() * task.observations();
        if count == 0 || numbers.saturating_mul(count) > MAX_NUMBERS {
            return Err(BatchError::TooLarge { worlds: count, numbers });
        }
        let task = Arc::new(task);
        // The task was checked when it was read.
        let goal = || task.goal().ok();
        let environments = (0..count).filter_map(|number| Some(Environment::new(task.clone(), goal()?, number as u64)));
        Ok(Self { environments: environments.collect(), task, threads })
    }

    /// Returns the task.
    pub fn task(&self) -> &Task {
        &self.task
    }

    /// Returns the number of environments.
    pub fn count(&self) -> usize {
        self.environments.len()
    }

    /// Returns the world of an environment.
    pub fn world(&self, number: usize) -> Option<&World> {
        self.environments.get(number).map(Environment::world)
    }

    /// Begins an episode in the environments that `which` marks, or in all. `seeds` begin their random numbers anew; without them, they go
    /// on. Observations of other environments stay as they are.
    ///
    /// # Errors
    /// When an array has another size; then nothing happens. When there is no room for a robot; the other environments begin all the same.
    pub fn reset(
        &mut self,
        seeds: Option<&[u64]>,
        which: Option<&[bool]>,
        observations: &mut [f32],
    ) -> Result<(), BatchError> {
        let width = self.task.robots() * self.task.observations();
        self.check("seeds", seeds.map_or(self.count(), <[u64]>::len), 1)?;
        self.check("marks", which.map_or(self.count(), <[bool]>::len), 1)?;
        self.check("observations", observations.len(), width)?;
        let is_marked = |number: usize| which.is_none_or(|which| which[number]);
        let rows = observations.chunks_exact_mut(width.max(1));
        let all = self.environments.iter_mut().zip(rows).enumerate();
        let mut jobs: Vec<_> = all.filter(|(number, _)| is_marked(*number)).collect();
        let work = |jobs: &mut [(usize, (&mut Environment, &mut [f32]))]| {
            for (number, (environment, row)) in jobs {
                if let Some(seeds) = seeds {
                    environment.seed(seeds[*number]);
                }
                environment.reset(row);
            }
        };
        let threads = &self.threads;
        threads.run(|| in_parts(threads, ENVIRONMENTS_AT_A_TIME, &mut jobs, &work));
        self.take_failure()
    }

    /// Plays one interval in every environment. Actions beyond -1 to 1 count as these.
    ///
    /// # Errors
    /// When an array has another size, an action is not finite, or an environment has not begun; then nothing happens. When an episode ended
    /// and there is no room for a robot of the next; the other environments are stepped all the same.
    pub fn step(&mut self, actions: &[f32], autoreset: Autoreset, outcomes: Outcomes) -> Result<(), BatchError> {
        let robots = self.task.robots();
        let widths = [robots * self.task.actions(), robots * self.task.observations()];
        let Outcomes { observations, rewards, terminated, truncated, successes, last_observations } = outcomes;
        self.check("actions", actions.len(), widths[0])?;
        self.check("observations", observations.len(), widths[1])?;
        self.check("rewards", rewards.len(), robots)?;
        self.check("last observations", last_observations.len(), widths[1])?;
        for (array, flags) in [("terminated", &*terminated), ("truncated", &*truncated), ("successes", &*successes)] {
            self.check(array, flags.len(), 1)?;
        }
        if let Some(place) = actions.iter().position(|action| !action.is_finite()) {
            return Err(BatchError::Action { environment: place / widths[0].max(1), got: actions[place] });
        }
        if let Some(number) = self.environments.iter().position(|it| !it.has_begun()) {
            return Err(BatchError::NotBegun(number));
        }
        let rows = self.environments.iter_mut().zip(actions.chunks_exact(widths[0].max(1)));
        let rows = rows.zip(observations.chunks_exact_mut(widths[1].max(1))).zip(rewards.chunks_exact_mut(robots));
        let flags = terminated.iter_mut().zip(truncated).zip(successes);
        let flags = flags.zip(last_observations.chunks_exact_mut(widths[1].max(1)));
        let job = |((((environment, actions), observations), rewards), (((terminated, truncated), success), last))| {
            Job { environment, actions, observations, rewards, terminated, truncated, success, last_observations: last }
        };
        let mut jobs: Vec<Job> = rows.zip(flags).map(job).collect();
        let work = |jobs: &mut [Job]| jobs.iter_mut().for_each(|job| job.run(autoreset));
        let threads = &self.threads;
        threads.run(|| in_parts(threads, ENVIRONMENTS_AT_A_TIME, &mut jobs, &work));
        self.take_failure()
    }

    /// Takes the failures of all environments, and returns the first as an error.
    fn take_failure(&mut self) -> Result<(), BatchError> {
        let mut first = Ok(());
        for (number, environment) in self.environments.iter_mut().enumerate() {
            if let Some(reason) = environment.failure.take() {
                first = first.and(Err(BatchError::NoRoom { environment: number, reason }));
            }
        }
        first
    }

    fn check(&self, array: &'static str, got: usize, width: usize) -> Result<(), BatchError> {
        let expected = width * self.count();
        if got == expected { Ok(()) } else { Err(BatchError::Size { array, got, expected }) }
    }
}

impl Job<'_> {
    fn run(&mut self, autoreset: Autoreset) {
        let Self { environment, actions, observations, rewards, terminated, truncated, success, last_observations } =
            self;
        (**terminated, **truncated, **success) = (false, false, false);
        if environment.is_over {
            rewards.fill(0.0);
            if autoreset != Autoreset::Disabled {
                environment.reset(observations);
            }
            return;
        }
        let interval = environment.step(actions, observations);
        rewards.copy_from_slice(&interval.verdict.rewards);
        (**terminated, **truncated) = (interval.verdict.is_over, interval.is_truncated);
        **success = interval.verdict.is_success;
        if environment.is_over && autoreset == Autoreset::SameStep {
            last_observations.copy_from_slice(observations);
            environment.reset(observations);
        }
    }
}
