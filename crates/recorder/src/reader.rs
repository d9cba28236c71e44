//! Reading of logs that are whole, cut off or damaged.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::Path;

use foxglove::messages::{Log as LogMessage, log::Level};
use gamebots_proto::framing::MAX_LINE_BYTES;
use gamebots_proto::shown;
use mcap::MAGIC;
use prost::Message;
use scene::WorldDef;

use crate::classes::{CLASS, DEFINITION, Described};
use crate::records::{self, Damage, Record as Raw};
use crate::{
    END, FORMAT, LEAGUE, LEFT, LeagueScore, LeagueStandings, OBJECTS, ObjectRemoved, ObjectSpawned, ObjectState,
    PictureTaken, RUN, Record, RobotLeft, RobotState, SensorReading, WireLine,
};

/// Most bytes in memory for a byte of the file; the log of a youBot takes three. A file that takes more was made to fill the
/// memory: LZ4 alone expands one byte to 255.
const MAX_EXPANSION: u64 = 32;
/// Bytes in memory that even a small file may take.
const ALWAYS_ALLOWED: u64 = 64 << 20;
/// Longest line from a client: the limit of the server, with room for bytes that are not UTF-8 and become longer.
const MAX_LINE: usize = 3 * MAX_LINE_BYTES;
/// Most joints of a robot: a table has columns for all joints of the robot with the most joints.
const MAX_JOINTS: usize = scene::check::MAX_LINKS;
/// Longest reading, bytes: more than that of a laser with the most beams. While it is decoded, an empty quantity takes 30 times its bytes.
const MAX_READING: usize = 1 << 18;

/// One record with its simulated time, s.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// Simulated time, s.
    pub time: f64,
    /// The record.
    pub record: Record,
}

/// A log that was read.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Log {
    /// Metadata that describe the run.
    pub run: BTreeMap<String, String>,
    /// Definitions of the robot classes that it used, JSON, by name. In an old log they are in the scene.
    pub classes: BTreeMap<String, String>,
    /// Metadata of its end: `seconds`, `digest`, `dropped`, `unsettled_steps`. Empty if the log was cut off.
    pub end: BTreeMap<String, String>,
    /// The records in order.
    pub entries: Vec<Entry>,
    /// The reason why the rest of the file cannot be read; `None` if the log is whole.
    pub damage: Option<String>,
}

impl Log {
    /// Returns the scene with every number in effect, if it makes a valid world. A class that the log did not use cannot be read in it.
    ///
    /// # Errors
    /// Describes the problem.
    pub fn scene(&self) -> Result<WorldDef, String> {
        let read = |error: serde_json::Error| format!("its scene: {error}");
        let scene = self.run.get("scene").ok_or("no `scene` in its metadata")?;
        let names = self.run.get("classes").map_or("[]", String::as_str);
        let class = |(name, definition): (&String, &String)| {
            let def = serde_json::from_str(definition).map_err(|error| format!("its class {}: {error}", shown(name)));
            def.map(|def| (name.clone(), def))
        };
        Described {
            scene: serde_json::from_str(scene).map_err(read)?,
            names: serde_json::from_str(names).map_err(read)?,
            classes: self.classes.iter().map(class).collect::<Result<_, _>>()?,
        }
        .world()
    }
}

/// Reads the world of a log from JSON, if it is valid: an object with the `scene` in the metadata `run`, with `names`, which are the
/// `classes` there, and with `classes`, which are the definitions in the metadata `class/<name>` by their names. An old log has the first alone.
///
/// # Errors
/// Describes the problem.
pub fn scene(json: &[u8]) -> Result<WorldDef, String> {
    let described: Described = serde_json::from_slice(json).map_err(|error| format!("its scene: {error}"))?;
    described.world()
}

/// A log that cannot be read at all.
#[derive(Debug, thiserror::Error)]
#[error("log {file}: {reason}")]
pub struct ReadError {
    file: String,
    reason: String,
}

/// Reads a log. If it was cut off or is damaged, returns everything before the damage.
///
/// # Errors
/// When the file cannot be read, is not a log of this program, or is of a newer version.
pub fn read(path: &Path) -> Result<Log, ReadError> {
    let (file, size) = open(path)?;
    let mut room = size.saturating_mul(MAX_EXPANSION).max(ALWAYS_ALLOWED);
    let (mut log, mut topics) = (Log::default(), BTreeMap::new());
    let read = records::each(file, |record| {
        match record {
            Raw::Metadata { name: RUN, entries } => log.run = entries,
            Raw::Metadata { name: END, entries } => log.end = entries,
            Raw::Metadata { name, mut entries } => {
                let class = name.strip_prefix(CLASS).zip(entries.remove(DEFINITION));
                log.classes.extend(class.map(|(name, definition)| (name.to_owned(), definition)));
            }
            Raw::Channel { id, topic, .. } => drop(topics.insert(id, Topic::of(topic))),
            Raw::Message { header, data } => {
                let topic = topics.get(&header.channel_id).copied().unwrap_or(Topic::Other);
                let Some(mut record) = topic.parse(data)? else { return Ok(()) };
                // In an old log, the end of a connection names the robot that left with it.
                let left = match &mut record {
                    Record::Closed(line) => line.robot.take().map(Record::Left),
                    _ => None,
                };
                for record in left.into_iter().chain([record]) {
                    room = room.checked_sub(record.size() as u64).ok_or_else(|| {
                        Damage(format!("it takes more than {MAX_EXPANSION} times the memory that it has on the disk"))
                    })?;
                    log.entries.push(Entry { time: header.log_time as f64 / 1e9, record });
                }
            }
            _ => {}
        }
        Ok::<(), Damage>(())
    });
    check_format(&log.run).map_err(|reason| unreadable(path, reason))?;
    log.damage = read.err().map(|damage| damage.to_string());
    if log.run.is_empty() && log.entries.is_empty() {
        let reason = log.damage.map_or(String::new(), |damage| format!("; {damage}"));
        return Err(unreadable(
            path,
            format_args!("not a log of usarsim: expected the metadata `run`, or a message{reason}"),
        ));
    }
    Ok(log)
}

/// Refuses a log of a newer program, in which the same words may have other meanings.
fn check_format(run: &BTreeMap<String, String>) -> Result<(), String> {
    match run.get("format") {
        Some(format) if !format.parse().is_ok_and(|format: u32| (1..=FORMAT).contains(&format)) => {
            Err(format!("it is of format {format:.20}, expected 1 to {FORMAT}; a newer usarsim may read it"))
        }
        _ => Ok(()),
    }
}

/// Opens an MCAP file. Returns it from its beginning, and its size in bytes.
pub(crate) fn open(path: &Path) -> Result<(impl Read, u64), ReadError> {
    let open = || {
        let (mut magic, mut file) = (Vec::new(), File::open(path)?);
        (&mut file).take(MAGIC.len() as u64).read_to_end(&mut magic)?;
        Ok((magic, file.metadata()?.len(), file))
    };
    let (magic, size, file) = open().map_err(|reason: std::io::Error| unreadable(path, reason))?;
    if magic != MAGIC {
        return Err(unreadable(path, "not an MCAP file"));
    }
    Ok((MAGIC.chain(file), size))
}

pub(crate) fn unreadable(path: &Path, reason: impl std::fmt::Display) -> ReadError {
    ReadError { file: path.display().to_string(), reason: reason.to_string() }
}

/// The meaning of a channel to a reader.
#[derive(Debug, Clone, Copy)]
enum Topic {
    In,
    Out,
    Closed,
    Left,
    State,
    Object,
    ObjectSpawned,
    ObjectRemoved,
    Sensed,
    Picture,
    Score,
    Standings,
    Log,
    /// A channel that only shows the content of another one.
    Other,
}

impl Topic {
    fn of(topic: &str) -> Self {
        match topic {
            "/wire/in" => Self::In,
            "/wire/out" => Self::Out,
            "/wire/closed" => Self::Closed,
            LEFT => Self::Left,
            topic if topic == OBJECTS[0] => Self::ObjectSpawned,
            topic if topic == OBJECTS[1] => Self::ObjectRemoved,
            topic if topic == LEAGUE[0] => Self::Score,
            topic if topic == LEAGUE[1] => Self::Standings,
            "/log" => Self::Log,
            _ => match topic.split('/').collect::<Vec<_>>()[..] {
                ["", "robot", _, "state"] => Self::State,
                ["", "robot", _, "sensor", _, "reading"] => Self::Sensed,
                ["", "robot", _, "sensor", _, "picture"] => Self::Picture,
                ["", "map", "object", _] => Self::Object,
                _ => Self::Other,
            },
        }
    }

    fn parse(self, data: &[u8]) -> Result<Option<Record>, Damage> {
        let parsed = match self {
            Self::In => WireLine::decode(data).map(Record::In),
            Self::Out => WireLine::decode(data).map(Record::Out),
            Self::Closed => WireLine::decode(data).map(Record::Closed),
            Self::Left => RobotLeft::decode(data).map(|left| Record::Left(left.robot)),
            Self::State => RobotState::decode(data).map(Record::State),
            Self::Object => ObjectState::decode(data).map(Record::Object),
            Self::ObjectSpawned => ObjectSpawned::decode(data).map(Record::ObjectSpawned),
            Self::Sensed if data.len() > MAX_READING => {
                return Err(Damage(format!("a reading of {} bytes: expected at most {MAX_READING}", data.len())));
            }
            Self::Sensed => match SensorReading::decode(data) {
                Ok(reading) => return Ok(reading.sensed().map(Record::Sensed)),
                Err(reason) => Err(reason),
            },
            Self::Picture => PictureTaken::decode(data).map(|taken| Record::Picture(taken, Vec::new())),
            Self::ObjectRemoved => ObjectRemoved::decode(data).map(Record::ObjectRemoved),
            Self::Score => LeagueScore::decode(data).map(|score| Record::Scored(score.score())),
            Self::Standings => match LeagueStandings::decode(data) {
                Ok(standings) => return Ok(standings.read().map(|it| Record::Standings(Box::new(it)))),
                Err(reason) => Err(reason),
            },
            Self::Log => match LogMessage::decode(data) {
                Ok(log) if log.level != Level::Warning as i32 => return Ok(None),
                log => log.map(|log| Record::Warning(log.message)),
            },
            Self::Other => return Ok(None),
        };
        let record = parsed.map_err(|reason| Damage(format!("a message of {self:?}: {reason}")))?;
        match &record {
            Record::In(line) if line.line.len() > MAX_LINE => {
                Err(Damage(format!("a line of {} bytes: expected at most {MAX_LINE}", line.line.len())))
            }
            Record::State(state) if state.joint_positions.len().max(state.joint_speeds.len()) > MAX_JOINTS => {
                let joints = state.joint_positions.len().max(state.joint_speeds.len());
                Err(Damage(format!("a robot with {joints} joints: expected at most {MAX_JOINTS}")))
            }
            _ => Ok(Some(record)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{End, LogWriter, Recorder};

    fn line(number: u64) -> Record {
        Record::In(WireLine { connection: number, robot: None, line: format!("DRIVE {{Left {number}}}") })
    }

    fn written(path: &Path) {
        let mut world = WorldDef::default();
        world.map.name = "none".to_owned();
        let log = LogWriter::create(path, &world, scene::Options::default(), &[]).unwrap();
        let mut recorder = Recorder::new(log).unwrap();
        (0..1000).for_each(|number| recorder.record(number as f64 * 0.002, line(number)));
        recorder.finish(End { time: 2.0, digest: Some(0xabc), unsettled_steps: 3, dropped: 0 });
    }

    #[test]
    fn a_log_reads_back_as_it_was_recorded() {
        let file = tempfile::NamedTempFile::new().unwrap();
        written(file.path());
        let Log { run, end, entries, damage, .. } = read(file.path()).unwrap();
        assert_eq!(damage, None);
        assert_eq!((run["map"].as_str(), end["digest"].as_str()), ("none", "0000000000000abc"));
        assert_eq!(entries.len(), 1000);
        assert_eq!(entries[999], Entry { time: 1.998, record: line(999) });
    }

    #[test]
    fn the_end_of_a_connection_in_an_old_log_is_also_that_of_its_robot() {
        let file = tempfile::NamedTempFile::new().unwrap();
        let closed = |robot| Record::Closed(WireLine { connection: 1, robot, line: String::new() });
        let mut log = LogWriter::create(file.path(), &WorldDef::default(), scene::Options::default(), &[]).unwrap();
        [closed(Some(4)), Record::Left(5), closed(None)].iter().for_each(|record| log.write(0.0, record).unwrap());
        drop(log);
        let records: Vec<Record> = read(file.path()).unwrap().entries.into_iter().map(|entry| entry.record).collect();
        assert_eq!(records, [Record::Left(4), closed(None), Record::Left(5), closed(None)]);
    }

    #[test]
    fn a_log_cut_off_anywhere_reads_without_an_error() {
        let file = tempfile::NamedTempFile::new().unwrap();
        written(file.path());
        let bytes = std::fs::read(file.path()).unwrap();
        for part in [50, 90, 99] {
            std::fs::write(file.path(), &bytes[..bytes.len() * part / 100]).unwrap();
            assert!(read(file.path()).is_ok(), "{part} %");
        }
    }

    #[test]
    fn a_file_that_is_no_log_is_a_named_error() {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), "hello").unwrap();
        assert!(read(file.path()).unwrap_err().to_string().contains("log "));
    }
}
