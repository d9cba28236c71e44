//! A recorded run made again: the same scene, the same lines at the same steps.

use std::collections::BTreeMap;

use sim_core::scene::WorldDef;
use sim_core::{Controller, Options, World};

use crate::{Log, Record, RobotState};

/// Longest replay, simulated seconds: a month.
const MAX_SECONDS: f64 = 31.0 * 24.0 * 3600.0;

/// What a replay came to.
#[derive(Debug, Clone, PartialEq)]
pub struct Replay {
    /// Simulated seconds replayed.
    pub seconds: f64,
    /// Digest of the world at the end.
    pub digest: u64,
    /// The digest in the log; `None` when it was cut off.
    pub recorded: Option<u64>,
    /// Recorded states of robots and objects that were compared.
    pub states: usize,
    /// Simulated time of the first of them that came out different, s.
    pub first_difference: Option<f64>,
}

impl Replay {
    /// Whether everything came out with the same bits.
    pub fn is_same(&self) -> bool {
        self.first_difference.is_none() && self.recorded.is_none_or(|recorded| recorded == self.digest)
    }
}

/// A log that does not say what to replay.
#[derive(Debug, thiserror::Error)]
#[error("the log cannot be replayed: {0}")]
pub struct ReplayError(String);

/// Makes the run of a log again.
///
/// # Panics
/// When the world does: the report of a panic is replayed to see it again.
///
/// # Errors
/// When the log has no scene or no time step, began in a running world, or has records that were dropped.
pub fn replay(log: &Log) -> Result<Replay, ReplayError> {
    let entry = |key: &str| log.run.get(key).ok_or_else(|| ReplayError(format!("no `{key}` in its metadata")));
    let number = |key: &str| entry(key)?.parse::<f64>().map_err(|_| ReplayError(format!("`{key}` is no number")));
    let def: WorldDef =
        serde_json::from_str(entry("scene")?).map_err(|error| ReplayError(format!("its scene: {error}")))?;
    let seed = entry("seed")?.parse().map_err(|_| ReplayError("`seed` is no whole number".to_owned()))?;
    let (time_step, speed_unit) = (number("time_step")?, number("speed_unit")?);
    if !(1e-4..=0.02).contains(&time_step) {
        return Err(ReplayError(format!("`time_step` is {time_step}: expected 0.0001 to 0.02")));
    }
    if let Some(began) = log.run.get("began") {
        return Err(ReplayError(format!("it began in a running world, at {began} s: expected a log from the start")));
    }
    let dropped = log.end.get("dropped").map_or("0", String::as_str);
    if dropped != "0" {
        return Err(ReplayError(format!("{dropped} records were dropped when it was written")));
    }
    let end: Option<f64> = log.end.get("seconds").and_then(|seconds| seconds.parse().ok());
    let last = log.entries.iter().map(|entry| entry.time).chain(end).fold(0.0, f64::max);
    if last > MAX_SECONDS {
        return Err(ReplayError(format!("it goes to {last} s: expected at most {MAX_SECONDS}")));
    }
    let panic_at = log.run.get("panic_at").and_then(|steps| steps.parse().ok());
    // Older logs do not say, and kept them.
    let keep_robots = log.run.get("keep_robots").is_none_or(|keep| keep == "true");
    let mut world = World::new(def, Options { seed, speed_unit, time_step, keep_robots, panic_at });
    let mut controllers: BTreeMap<u64, Controller> = BTreeMap::new();
    let (mut steps, mut states, mut first_difference) = (0, 0, None);
    let mut advance = |world: &mut World, time: f64| {
        let wanted = (time / time_step).round() as u64;
        while steps < wanted {
            world.step();
            steps += 1;
        }
    };
    for entry in &log.entries {
        advance(&mut world, entry.time);
        match &entry.record {
            Record::In(line) => {
                let controller = controllers.entry(line.connection).or_default();
                controller.execute_line(&line.line, &mut world, &mut Vec::new());
            }
            Record::Closed(line) => {
                if let Some(controller) = controllers.remove(&line.connection) {
                    controller.end(&mut world);
                }
            }
            Record::State(state) => {
                states += 1;
                if first_difference.is_none() && now(&world, state.robot).as_ref() != Some(state) {
                    first_difference = Some(entry.time);
                }
            }
            Record::Object(object) => {
                let pose = world.objects().nth(object.object as usize);
                states += 1;
                if first_difference.is_none() && pose != Some(object.pose()) {
                    first_difference = Some(entry.time);
                }
            }
            Record::Out(_) | Record::Warning(_) => {}
        }
    }
    if let Some(end) = end {
        advance(&mut world, end);
    }
    let recorded = log.end.get("digest").and_then(|digest| u64::from_str_radix(digest, 16).ok());
    Ok(Replay { seconds: world.time(), digest: world.digest(), recorded, states, first_difference })
}

fn now(world: &World, robot: u64) -> Option<RobotState> {
    RobotState::of(world, world.robots().find(|(id, _, _)| id.0 == robot)?)
}
