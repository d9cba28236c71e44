//! Replay of a recorded run: the same scene, and the same lines at the same steps.

use std::collections::VecDeque;

use picture::Stage;
use recorder::{Entry, Log, PictureTaken, Record, RobotState, STATE_INTERVAL};
use scene::check::{Range, SPEED_UNIT, TIME_STEP};
use scene::{Options, PawnId, Reading, Sensed, Snapshot};
use sessions::{News, Request, Sessions};
use sim_core::World;

/// Longest replay, simulated seconds: a month.
const MAX_SECONDS: f64 = 31.0 * 24.0 * 3600.0;
/// Longest time without a record in a world without robots, simulated seconds: a server left alone for a day.
const MAX_IDLE: f64 = 24.0 * 3600.0;
/// Longest time without a record in a world with robots, s. Each robot is recorded at every interval, or at the first step
/// after it.
const MAX_GAP: f64 = 2.0 * STATE_INTERVAL;
/// Longest time between what a picture shows and its record, s.
const MAX_DELAY: f64 = 0.2;

/// The result of a replay.
#[derive(Debug, Clone, PartialEq)]
pub struct Replay {
    /// Simulated seconds replayed.
    pub seconds: f64,
    /// Digest of the world at the end.
    pub digest: u64,
    /// The digest in the log; `None` if the log has no digest because it was cut off or the world panicked.
    pub recorded: Option<u64>,
    /// Recorded states of robots and objects, readings, pictures, and points of a league, that were compared.
    pub states: usize,
    /// Simulated time of the first state that differs, s.
    pub first_difference: Option<f64>,
}

impl Replay {
    /// True if everything has the same bits.
    pub fn is_same(&self) -> bool {
        self.first_difference.is_none() && self.recorded.is_none_or(|recorded| recorded == self.digest)
    }

    /// Returns the result as JSON, with digests in hexadecimal digits.
    pub fn to_json(&self) -> serde_json::Value {
        let Self { seconds, digest, recorded, states, first_difference } = self;
        let recorded = recorded.map(|digest| format!("{digest:016x}"));
        serde_json::json!({
            "same": self.is_same(), "seconds": seconds, "digest": format!("{digest:016x}"), "recorded": recorded,
            "states": states, "first_difference": first_difference,
        })
    }
}

/// A log that cannot be replayed.
#[derive(Debug, thiserror::Error)]
#[error("the log cannot be replayed: {0}")]
pub struct ReplayError(String);

/// Replays the run of a log.
///
/// # Panics
/// When the world panics: the report of a panic is replayed to see it again.
///
/// # Errors
/// When the log has no valid scene or time step, began in a running world, has dropped records, or has times that no run has.
pub fn replay(log: &Log) -> Result<Replay, ReplayError> {
    let entry = |key: &str| log.run.get(key).ok_or_else(|| ReplayError(format!("no `{key}` in its metadata")));
    let number = |key: &str| entry(key)?.parse::<f64>().map_err(|_| ReplayError(format!("`{key}` is no number")));
    let within = |key: &str, range: Range| {
        let number = number(key)?;
        range.problem(key, number).map_or(Ok(number), |problem| Err(ReplayError(problem)))
    };
    let def = log.scene().map_err(ReplayError)?;
    let seed = entry("seed")?.parse().map_err(|_| ReplayError("`seed` is not a whole number".to_owned()))?;
    let (time_step, speed_unit) = (within("time_step", TIME_STEP)?, within("speed_unit", SPEED_UNIT)?);
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
    // The log says which robots leave, and when: `keep_robots` has no effect.
    let world = World::new(def, Options { seed, speed_unit, time_step, ..Options::default() });
    let mut sessions = Sessions::new(world);
    let (mut states, mut first_difference) = (0, None);
    let is_picture = |entry: &Entry| matches!(entry.record, Record::Picture(..));
    let mut album = Album { is_wanted: log.entries.iter().any(is_picture), ..Album::default() };
    // Readings of the present moment.
    let mut readings = Vec::new();
    // The report of a panic has no states.
    let most = if log.run.contains_key("panic") { MAX_IDLE } else { MAX_GAP };
    for entry in &log.entries {
        advance(&mut sessions, entry.time, most, &mut album, &mut readings)?;
        match &entry.record {
            Record::In(line) => {
                if !sessions.is_open(line.connection) {
                    sessions.open_silent(line.connection);
                }
                // A program's line may be for another session's pawn.
                let request = Request::read(Ok(line.line.clone())).to(line.robot.map(PawnId));
                sessions.take(line.connection, &request, &mut |_, news| readings.extend(sensed(news)));
            }
            // Records of their own say which robots leave.
            Record::Closed(line) => sessions.forget(line.connection),
            Record::Left(robot) => sessions.world_mut().remove(PawnId(*robot)),
            Record::State(state) => {
                states += 1;
                if first_difference.is_none() && now(sessions.world(), state.robot).as_ref() != Some(state) {
                    first_difference = Some(entry.time);
                }
            }
            Record::Object(object) => {
                let pose = sessions.world().objects().find(|it| it.id.0 == u64::from(object.object)).map(|it| it.pose);
                states += 1;
                if first_difference.is_none() && pose != Some(object.pose()) {
                    first_difference = Some(entry.time);
                }
            }
            Record::Sensed(recorded) => {
                states += 1;
                if first_difference.is_none() && !readings.contains(recorded) {
                    first_difference = Some(entry.time);
                }
            }
            Record::Picture(taken, _) => {
                states += 1;
                if first_difference.is_none() && !album.has(sessions.world(), taken) {
                    first_difference = Some(entry.time);
                }
            }
            Record::Scored(recorded) => {
                states += 1;
                let standings = sessions.standings().unwrap_or_default();
                let is_known = standings.teams.iter().any(|team| team.scores.contains(recorded));
                if first_difference.is_none() && !is_known {
                    first_difference = Some(entry.time);
                }
            }
            Record::Standings(recorded) => {
                states += 1;
                if first_difference.is_none() && sessions.standings().as_ref() != Some(&**recorded) {
                    first_difference = Some(entry.time);
                }
            }
            Record::ObjectSpawned(_) | Record::ObjectRemoved(_) => {}
            Record::Out(_) | Record::Warning(_) | Record::Map(_) => {}
        }
    }
    if let Some(end) = end {
        advance(&mut sessions, end, most, &mut album, &mut readings)?;
    }
    let world = sessions.world();
    let recorded = log.end.get("digest").and_then(|digest| u64::from_str_radix(digest, 16).ok());
    Ok(Replay { seconds: world.time(), digest: world.digest(), recorded, states, first_difference })
}

/// Steps to the time of the next record, if a run can reach it from the last one. With robots, the gap is at most `most`
/// seconds. `readings` gets those of the last step, if there is one.
fn advance(
    sessions: &mut Sessions,
    time: f64,
    most: f64,
    album: &mut Album,
    readings: &mut Vec<Sensed>,
) -> Result<(), ReplayError> {
    let world = sessions.world();
    let (now, time_step) = (world.time(), world.time_step());
    // Times in a log are whole nanoseconds.
    let steps = ((time - now) / time_step).round();
    if steps < 0.0 {
        return Err(ReplayError(format!("its times go back from {now} s to {time} s")));
    }
    let (gap, most) = (time - now, if world.robots().next().is_some() { most } else { MAX_IDLE });
    if gap > most + time_step {
        let text = format!("nothing is recorded from {now} s to {time} s: expected at most {most} s without a record");
        return Err(ReplayError(text));
    }
    for _ in 0..steps as u64 {
        readings.clear();
        sessions.step(&mut |_, news| readings.extend(sensed(news)));
        album.see(sessions.world(), readings);
    }
    Ok(())
}

fn sensed(news: News) -> Option<Sensed> {
    if let News::Sensed(sensed) = news { Some(sensed.clone()) } else { None }
}

/// Recent views of cameras, if the log has pictures.
#[derive(Default)]
struct Album {
    is_wanted: bool,
    seen: VecDeque<CameraView>,
    stage: Option<Stage>,
}

/// The world when a camera looked.
struct CameraView {
    sensed: Sensed,
    snapshot: Snapshot,
}

impl Album {
    /// Keeps the present views of cameras.
    fn see(&mut self, world: &World, readings: &[Sensed]) {
        if !self.is_wanted {
            return;
        }
        let views = readings.iter().filter(|sensed| matches!(sensed.reading, Reading::Camera(_)));
        self.seen.extend(views.map(|sensed| CameraView { sensed: sensed.clone(), snapshot: world.snapshot() }));
        let is_old = |seen: &CameraView| seen.snapshot.time < world.time() - MAX_DELAY;
        while self.seen.front().is_some_and(is_old) {
            self.seen.pop_front();
        }
    }

    /// True if a camera saw the picture of a log.
    fn has(&mut self, world: &World, taken: &PictureTaken) -> bool {
        let stage = self.stage.get_or_insert_with(|| Stage::new(world.def()));
        let is_it = |CameraView { sensed, snapshot }: &&CameraView| {
            sensed.robot.0 == taken.robot && sensed.sensor == taken.sensor as usize && snapshot.time == taken.moment
        };
        let Some(CameraView { sensed, snapshot }) = self.seen.iter().find(is_it) else { return false };
        let drawn = picture::of_sensor(stage, world.def(), snapshot, sensed, picture::SENSOR_SIZE);
        let png = drawn.and_then(|image| image.to_png().ok());
        png.is_some_and(|png| PictureTaken::new(sensed, taken.moment, &png) == *taken)
    }
}

fn now(world: &World, robot: u64) -> Option<RobotState> {
    let snapshot = world.snapshot();
    snapshot.robots.iter().find(|seen| seen.id.0 == robot).map(RobotState::new)
}
