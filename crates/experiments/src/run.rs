//! One run: a robot is spawned, driven by lines of the wire, and measured.

use std::path::Path;

use gamebots_proto::Command;
use gamebots_proto::command::Init;
use logbook::LoggedSessions;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use recorder::{LogWriter, RecordError};
use scene::{MapDef, Pose, Reading, RobotDef, WorldDef};
use scene_loader::LoadError;
use serde::{Deserialize, Serialize};
use sessions::{Request, SessionId};
use sim_core::{Options, World};

use crate::course::in_words;
use crate::plan::{Plan, Run, Setup, Tolerances};

/// Interval between two ground truth readings, s. Every n-th reading, from the first on, is a measured pose (thesis 7.2).
const READING_INTERVAL: f64 = 0.1;

/// Motion from one measured pose to the next, in the frame of the robot at the start.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// Travel along the main direction, m.
    pub main: f64,
    /// Travel along the error direction, m.
    pub error: f64,
    /// Counterclockwise turn, rad.
    pub yaw: f64,
}

/// Result of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// Identifier of the run, see [`Run::id`].
    pub id: String,
    /// See [`Run::labels`].
    pub labels: Vec<(String, String)>,
    /// Seed of the world and of the variation between samples.
    pub seed: u64,
    /// The steps.
    pub steps: Vec<Step>,
    /// Mean angle that the driven wheels turned in all steps, in either direction, rad.
    pub wheels_turned: f64,
    /// Digest of the world at the end.
    pub digest: String,
    /// Simulated time of the whole run, s.
    pub seconds: f64,
}

impl Outcome {
    /// Returns the name of the experiment.
    pub fn experiment(&self) -> &str {
        self.id.split('/').next().unwrap_or_default()
    }

    /// Returns the value of a label.
    pub fn label(&self, name: &str) -> Option<&str> {
        self.labels.iter().find(|(label, _)| label == name).map(|(_, value)| value.as_str())
    }
}

/// Errors of a run.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// A map, a robot or an override does not load.
    #[error("{id}: {reason}")]
    Load {
        /// Identifier of the run.
        id: String,
        /// All problems found.
        reason: Box<LoadError>,
    },
    /// The robot cannot execute the setup.
    #[error("{id}: {reason}")]
    Setup {
        /// Identifier of the run.
        id: String,
        /// Description of the problem.
        reason: String,
    },
    /// The log cannot be written.
    #[error(transparent)]
    Log(#[from] RecordError),
}

/// A run with its scene loaded and its sample drawn.
pub struct Prepared {
    /// World to simulate.
    pub world: WorldDef,
    /// Run options.
    pub options: Options,
    /// Spawn of the robot.
    pub init: Init,
    /// Lines with their times after the first measured pose, s.
    pub lines: Vec<(f64, String)>,
}

/// Loads a run's map and robot, and draws the variation of its sample.
///
/// # Errors
/// When something does not load.
pub fn prepare(plan: &Plan, run: &Run) -> Result<Prepared, RunError> {
    let load = |reason| RunError::Load { id: run.id.clone(), reason: Box::new(reason) };
    let refuse = |reason: String| RunError::Setup { id: run.id.clone(), reason };
    let overrides = run.setup.overrides().map_err(refuse)?;
    let map = scene_loader::map(run.setup.map(), &overrides).map_err(load)?;
    let mut robot = scene_loader::robot(run.setup.robot(), &overrides).map_err(load)?;
    scene_loader::check_used(&overrides).map_err(load)?;
    robot.set_drive_model(run.drive_model);
    let seed = plan.seed.wrapping_mul(1000).wrapping_add(u64::from(run.sample));
    let mut draw = Draw(ChaCha8Rng::seed_from_u64(seed));
    let Tolerances { position, yaw, .. } = plan.tolerances;
    let off = scene::pose([draw.within(position), draw.within(position), 0.0], [0.0, 0.0, draw.within(yaw)]);
    draw.vary(&mut robot, plan.tolerances);
    let start = start(&run.setup, &map) * off;
    let (position, rotation) = scene::position_and_rotation(&start);
    // A tenth of a micrometre is finer than anybody draws.
    let [location, rotation] = [position, rotation].map(|vector| vector.map(|number| (number * 1e7).round() / 1e7));
    let init = Init { class_name: format!("USARBot.{}", robot.class), location, rotation, ..Init::default() };
    let options = Options { seed, time_step: plan.time_step, ..Options::default() };
    let robots = [(robot.class.clone(), robot)].into();
    Ok(Prepared { world: WorldDef { map, robots, ..WorldDef::default() }, options, init, lines: run.setup.lines() })
}

/// Returns the start pose of the setup, or the map's first start.
fn start(setup: &Setup, map: &MapDef) -> Pose {
    let first = map.starts.first().map(|start| (start.position, start.rotation)).unwrap_or_default();
    let rotation = setup.rotation.or(setup.position.map(|_| [0.0; 3])).unwrap_or(first.1);
    scene::pose(setup.position.unwrap_or(first.0), rotation)
}

/// Random numbers of a sample, drawn in a fixed order.
struct Draw(ChaCha8Rng);

impl Draw {
    /// Draws uniformly from minus to plus the half width.
    fn within(&mut self, half_width: f64) -> f64 {
        (2.0 * self.0.random::<f64>() - 1.0) * half_width
    }

    fn vary(&mut self, robot: &mut RobotDef, tolerances: Tolerances) {
        for wheel in robot.wheels_mut() {
            let (phase, friction) = (self.within(tolerances.wheel_phase), 1.0 + self.within(tolerances.friction));
            match &mut wheel.rollers {
                Some(rollers) => {
                    rollers.first_roller += phase;
                    rollers.material.friction *= friction;
                }
                None => wheel.material.friction *= friction,
            }
        }
        let mass = 1.0 + self.within(tolerances.mass);
        for part in robot.parts_mut() {
            part.mass *= mass;
            part.inertia *= mass;
        }
    }
}

/// Executes a run in this process, as fast as possible, and logs it if a file is given.
///
/// # Errors
/// When something does not load, the robot has no ground truth at 10 Hz, or the log cannot be written.
pub fn run(plan: &Plan, run: &Run, log: Option<&Path>) -> Result<Outcome, RunError> {
    let Prepared { world, options, init, lines } = prepare(plan, run)?;
    let refuse = |reason: &str| RunError::Setup { id: run.id.clone(), reason: reason.to_owned() };
    let log = log.map(|path| LogWriter::create(path, &world, options, &run.metadata(options.seed))).transpose()?;
    let mut sessions = LoggedSessions::new(World::new(world, options), log);
    sessions.open(SESSION)?;
    let problems = sessions.take(SESSION, &Request::order(Command::Init(init)), &mut |_| {})?;
    let Some(robot) = sessions.newest(SESSION) else { return Err(refuse(&in_words(&problems))) };

    let mut poses = Vec::new();
    let mut lines = lines.into_iter().peekable();
    let wanted = run.setup.steps() as usize + 1;
    let every = run.readings_a_step();
    let patience = plan.settling + 2.0 * READING_INTERVAL;
    let (mut began, mut readings, mut turned, mut before) = (None, 0, 0.0, Vec::new());
    loop {
        let mut reading = false;
        sessions.step(&mut |sensed| reading |= matches!(sensed.reading, Reading::GroundTruth(_)))?;
        let time = sessions.world().time();
        let Some((body, wheels)) = sessions.world().state(robot) else { return Err(refuse("the robot is gone")) };
        let angles: Vec<f64> = wheels.iter().map(|wheel| wheel.angle).collect();
        if began.is_none() && reading && time >= plan.settling - 1e-9 {
            began = Some(time);
            before.clone_from(&angles);
        }
        let Some(start) = began else {
            if time > patience {
                return Err(refuse("no ground truth at 10 Hz: expected a robot that has the sensor"));
            }
            continue;
        };
        turned += angles.iter().zip(&before).map(|(now, before)| (now - before).abs()).sum::<f64>();
        before = angles;
        if reading {
            if readings % every == 0 {
                poses.push(body.pose);
            }
            readings += 1;
        }
        if poses.len() == wanted {
            break;
        }
        while let Some((_, line)) = lines.next_if(|(at, _)| time - start >= at - 1e-9) {
            let problems = sessions.take(SESSION, &Request::read(Ok(line.clone())), &mut |_| {})?;
            if !problems.is_empty() {
                return Err(refuse(&format!("{line}: {}", in_words(&problems))));
            }
        }
    }
    sessions.finish()?;
    let (digest, seconds) = (sessions.world().digest(), sessions.world().time());
    Ok(Outcome {
        id: run.id.clone(),
        labels: run.labels.clone(),
        seed: options.seed,
        steps: measure(&run.setup, &poses),
        wheels_turned: turned / before.len().max(1) as f64,
        digest: format!("{digest:016x}"),
        seconds,
    })
}

/// Returns the steps between measured poses, in the frame of the first.
pub fn measure(setup: &Setup, poses: &[Pose]) -> Vec<Step> {
    poses.windows(2).map(|pair| step(setup, &poses[0], &pair[0], &pair[1])).collect()
}

fn step(setup: &Setup, start: &Pose, from: &Pose, to: &Pose) -> Step {
    let displacement = start.rotation.inverse() * (to.translation.vector - from.translation.vector);
    // On the wire, y and yaw are positive to the right.
    let (forward, left) = (displacement.x, -displacement.y);
    let along = |[f, l]: [f64; 2]| forward * f + left * l;
    let (_, _, clockwise) = (from.rotation.inverse() * to.rotation).euler_angles();
    let (main, error) = (setup.main.unwrap_or([1.0, 0.0]), setup.error.unwrap_or([0.0, 1.0]));
    Step { main: along(main), error: along(error), yaw: -clockwise }
}

impl Run {
    /// Returns the number of ground truth readings per step.
    pub fn readings_a_step(&self) -> u32 {
        (self.setup.interval() / READING_INTERVAL).round().max(1.0) as u32
    }

    fn metadata(&self, seed: u64) -> Vec<(String, String)> {
        let run = ("run".to_owned(), self.id.clone());
        let set = ("set".to_owned(), self.setup.set.join(" "));
        [run, set, ("sample_seed".to_owned(), seed.to_string())].into_iter().chain(self.labels.clone()).collect()
    }
}

/// Number of the only session of a run.
const SESSION: SessionId = 1;
