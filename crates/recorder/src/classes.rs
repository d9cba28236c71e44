//! Robot classes of a log. A log names all classes of its world, and has the definitions of those that it used.

use std::collections::{BTreeMap, BTreeSet};

use gamebots_proto::command::Command;
use scene::{Classes, RobotDef, WorldDef};
use serde::Deserialize;

use crate::Record;

/// Name of the metadata of a class, before the class's own name.
pub(crate) const CLASS: &str = "class/";
/// Key of a class's definition in its metadata, JSON.
pub(crate) const DEFINITION: &str = "definition";
/// Most classes of a log's world; the server has 74.
const MAX_CLASSES: usize = 4096;

/// A world as a log describes it, in JSON.
#[derive(Debug, Default, Deserialize)]
pub(crate) struct Described {
    /// The scene. In formats 1 and 2 it has all classes, in format 3 none.
    pub(crate) scene: WorldDef,
    /// Names of all classes; none in formats 1 and 2.
    #[serde(default)]
    pub(crate) names: Vec<String>,
    /// The classes that the log used, by name.
    #[serde(default)]
    pub(crate) classes: BTreeMap<String, RobotDef>,
}

impl Described {
    /// Returns the world, if it is valid. A class that the log did not use cannot be read in it.
    ///
    /// # Errors
    /// Describes the problem.
    pub(crate) fn world(self) -> Result<WorldDef, String> {
        let Self { mut scene, names, classes } = self;
        let count = names.len().max(classes.len());
        if count > MAX_CLASSES {
            return Err(format!("it has {count} classes of robots: expected at most {MAX_CLASSES}"));
        }
        for name in names {
            if let Some(problem) = scene::check::wire_name("a class", &name).into_iter().next() {
                return Err(format!("its scene: {problem}"));
            }
            scene
                .robots
                .insert_unread(name, || Err("the log has no robot of it, and so not its definition".to_owned()));
        }
        classes.into_iter().for_each(|(name, def)| scene.robots.insert(name, def));
        scene.check().map_err(|problem| format!("its scene: {problem}"))?;
        Ok(scene)
    }
}

/// The classes that a log has already.
#[derive(Debug, Default)]
pub(crate) struct Used(BTreeSet<String>);

impl Used {
    /// Returns the class that a record is the first to use: a line that asks for a robot of it, or the state of one.
    pub(crate) fn first<'a>(&mut self, classes: &'a Classes, record: &Record) -> Option<(String, &'a RobotDef)> {
        let name = match record {
            Record::In(line) => wanted(&line.line, classes)?,
            Record::State(state) => &state.class,
            Record::Out(_)
            | Record::Sensed(_)
            | Record::Closed(_)
            | Record::Left(_)
            | Record::Object(_)
            | Record::ObjectSpawned(_)
            | Record::ObjectRemoved(_)
            | Record::Picture(..)
            | Record::Scored(_)
            | Record::Standings(_)
            | Record::Warning(_)
            | Record::Map(_) => return None,
        };
        if self.0.contains(name) {
            return None;
        }
        let def = classes.get(name)?;
        self.0.insert(name.clone());
        Some((name.clone(), def))
    }
}

/// Returns the class that a line wants a robot of.
fn wanted<'a>(line: &str, classes: &'a Classes) -> Option<&'a String> {
    // Nearly all lines are others, and need not be parsed.
    line.trim_start().get(..4).filter(|verb| verb.eq_ignore_ascii_case("INIT"))?;
    let Command::Init(init) = Command::parse(line, &mut Vec::new())? else { return None };
    classes.find(init.class())
}

#[cfg(test)]
mod tests {
    use scene::Options;

    use super::*;
    use crate::{Log, LogWriter, RobotState, WireLine};

    fn line(text: &str) -> Record {
        Record::In(WireLine { connection: 1, robot: None, line: text.to_owned() })
    }

    fn state(class: &str) -> Record {
        Record::State(RobotState { class: class.to_owned(), ..RobotState::default() })
    }

    /// Writes a log that is not ended. Returns its bytes and what is read of it.
    fn logged(world: &WorldDef, records: &[Record]) -> (Vec<u8>, Log) {
        let file = tempfile::NamedTempFile::new().expect("a file");
        let mut log = LogWriter::create(file.path(), world, Options::default(), &[]).expect("a log");
        for record in records {
            log.write(0.0, record).expect("a disk");
            // Replays need the class of the last line, whatever comes after it.
            log.flush().expect("a disk");
        }
        drop(log);
        (std::fs::read(file.path()).expect("its bytes"), crate::read(file.path()).expect("a log"))
    }

    #[test]
    fn a_log_has_the_classes_that_lines_and_states_name_and_the_names_of_all() {
        let world = scene_loader::load("rough", &[]).expect("a map");
        for (records, used) in [
            (vec![], vec![]),
            (vec![line("INIT {ClassName USARBot.P3AT}")], vec!["P3AT"]),
            (vec![line("init {ClassName p3at} {Name A}"), state("P3AT")], vec!["P3AT"]),
            (vec![line("DRIVE {Left 1}"), line("INIT {ClassName USARBot.P4AT}"), line("INIT"), line("in")], vec![]),
            (vec![line("INIT {ClassName USARBotAPI.WorldController}"), state("Nobody")], vec![]),
            (vec![state("P3AT"), state("Kenaf"), state("P3AT")], vec!["Kenaf", "P3AT"]),
        ] {
            let (_, log) = logged(&world, &records);
            let read = log.scene().expect("its scene");
            let names: Vec<&String> = read.robots.iter().map(|(name, _)| name).collect();
            assert_eq!(names, used, "{records:?}");
            assert!(read.robots.keys().eq(world.robots.keys()), "{records:?}");
            assert!(used.iter().all(|name| read.robots[*name] == world.robots[*name]), "{records:?}");
            let why = read.robots.problem("ATRVJr").expect("it is not used");
            assert!(why.starts_with("the log has no robot of it"), "{why}");
        }
    }

    #[test]
    fn a_log_does_not_depend_on_the_classes_that_somebody_has_read() {
        let records = [line("INIT {ClassName USARBot.P3AT}"), state("P3AT")];
        let of = |read: &[&str]| {
            let world = scene_loader::load("rough", &[]).expect("a map");
            assert!(read.iter().all(|class| world.robots.get(class).is_some()));
            logged(&world, &records).0
        };
        assert!(of(&[]) == of(&["Kenaf", "YouBot", "P3AT"]));
    }

    #[test]
    fn a_log_without_robots_is_small() {
        let (bytes, _) = logged(&scene_loader::load("rough", &[]).expect("a map"), &[]);
        assert!(bytes.len() < 100_000, "{} bytes", bytes.len());
    }
}
