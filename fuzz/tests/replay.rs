//! The committed inputs, and random changes of them.

#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use fuzz::{TARGETS, Target};
use gamebots_proto::{Command, Dialect};
use mcap::WriteOptions;
use mcap::read::{ChunkFlattener, Options as ReadOptions};
use mcap::records::Record as Raw;
use proptest::prelude::*;
use proptest::test_runner::{Config, RngSeed, TestRunner};
use recorder::{End, LogWriter, Record, StateTimer, WireLine};
use scene::WorldDef;
use sim_core::{Options, Report, World};

/// The inputs of a target in the order of their names.
fn corpus(name: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("corpus").join(name);
    let files = std::fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut paths: Vec<PathBuf> = files.map(|file| file.unwrap().path()).collect();
    paths.sort();
    paths.into_iter().map(|path| (path.clone(), std::fs::read(path).unwrap())).collect()
}

fn target(name: &str) -> Target {
    TARGETS.iter().find(|(known, _)| *known == name).unwrap().1
}

/// Every input, and so many random changes of them: bytes replaced, removed and repeated.
fn check(name: &str, changes: u32) {
    let corpus = corpus(name);
    assert!(!corpus.is_empty(), "no inputs for {name}");
    for (path, bytes) in &corpus {
        // Shown when the input fails.
        println!("{}", path.display());
        fuzz::run(target(name), bytes);
    }
    // The same changes every time: other ones are for `make fuzz`.
    let config = Config { cases: changes, rng_seed: RngSeed::Fixed(1), failure_persistence: None, ..Config::default() };
    let edit = (any::<prop::sample::Index>(), 0usize..8, proptest::collection::vec(any::<u8>(), 0..8));
    let edits = (any::<prop::sample::Index>(), proptest::collection::vec(edit, 1..4));
    let tried = TestRunner::new(config).run(&edits, |(chosen, edits)| {
        let mut bytes = corpus[chosen.index(corpus.len())].1.clone();
        for (place, removed, put) in edits {
            let from = place.index(bytes.len() + 1);
            let to = (from + removed).min(bytes.len());
            bytes.splice(from..to, put);
        }
        println!("{:?}", String::from_utf8_lossy(&bytes));
        fuzz::run(target(name), &bytes);
        Ok(())
    });
    tried.unwrap();
}

macro_rules! targets {
    ($($name:ident: $changes:literal,)*) => {
        $(#[test]
        fn $name() {
            check(stringify!($name), $changes);
        })*

        #[test]
        fn every_target_is_tried() {
            assert_eq!(TARGETS.map(|(name, _)| name), [$(stringify!($name)),*]);
        }
    };
}

targets! {
    wire: 2000,
    ports: 2000,
    world: 50,
    robot: 200,
    map: 200,
    league: 100,
    material: 200,
    ini: 200,
    sdf: 200,
    urdf: 200,
    stl: 200,
    obj: 200,
    dae: 200,
    glb: 200,
    log: 200,
    requests: 2000,
    saved: 200,
}

#[test]
fn the_committed_inputs_are_small() {
    let bytes: usize = TARGETS.iter().flat_map(|(name, _)| corpus(name)).map(|(_, bytes)| bytes.len()).sum();
    assert!(bytes <= 300_000, "{bytes} bytes");
}

/// A log of one robot that drives for a tenth of a second, as the program writes it.
fn write_log(path: &Path) {
    let WorldDef { map, mut robots, .. } = scene_loader::load("rough", &[]).unwrap();
    robots.retain(|class| class == "CasterSkidRobot");
    let world = WorldDef { map, robots, ..WorldDef::default() };
    let mut log = LogWriter::create(path, &world, Options::default(), &[]).unwrap();
    let mut world = World::new(world, Options::default());
    let (mut robot, mut states) = (None, StateTimer::default());
    let line = |connection: u64, line: &str| WireLine { connection, robot: None, line: line.to_owned() };
    for text in ["INIT {ClassName CasterSkidRobot} {Name A}", "DRIVE {Left 2} {Right 3}"] {
        log.write(0.0, &Record::In(line(1, text))).unwrap();
        let command = Command::parse(text, &mut Vec::new()).unwrap();
        robot = world.execute(robot, &command, &mut Vec::new()).spawned.or(robot);
    }
    for _ in 0..50 {
        for (robot, report) in world.step() {
            if let Report::Sensed(sensed) = &report {
                log.write(world.time(), &Record::Sensed(sensed.clone())).unwrap();
            }
            let line = world.message(report).unwrap().write(Dialect::Udk);
            log.write(world.time(), &Record::Out(WireLine { connection: 1, robot: Some(robot.0), line })).unwrap();
        }
        if states.is_due(world.time()) {
            log.write_states(&world.snapshot()).unwrap();
        }
    }
    log.write(world.time(), &Record::In(line(2, "GETSTARTPOSES"))).unwrap();
    log.write(world.time(), &Record::Closed(line(2, ""))).unwrap();
    log.write(world.time(), &Record::Warning("nothing is wrong".to_owned())).unwrap();
    log.finish(End { time: world.time(), digest: Some(world.digest()), unsettled_steps: 0, dropped: 0 }).unwrap();
}

/// Writes the records of a log without compression and checksums, so that a changed byte reaches the reader.
fn write_plain(path: &Path, plain: &Path) {
    let bytes = std::fs::read(path).unwrap();
    let options = WriteOptions::new().compression(None).use_chunks(false).calculate_data_section_crc(false);
    let file = BufWriter::new(File::create(plain).unwrap());
    let mut writer = options.calculate_summary_section_crc(false).create(file).unwrap();
    let (mut schemas, mut channels) = (BTreeMap::from([(0, 0)]), BTreeMap::new());
    for record in ChunkFlattener::new_with_options(&bytes, ReadOptions::IgnoreEndMagic.into()).unwrap() {
        match record.unwrap() {
            // The schemas' text is of no account, and long.
            Raw::Schema { header, .. } => {
                schemas.insert(header.id, writer.add_schema(&header.name, &header.encoding, b"-").unwrap());
            }
            Raw::Channel(channel) => {
                let schema = schemas[&channel.schema_id];
                let id = writer.add_channel(schema, &channel.topic, &channel.message_encoding, &channel.metadata);
                channels.insert(channel.id, id.unwrap());
            }
            Raw::Message { mut header, data } => {
                header.channel_id = channels[&header.channel_id];
                writer.write_to_known_channel(&header, &data).unwrap();
            }
            Raw::Metadata(metadata) => writer.write_metadata(&metadata).unwrap(),
            Raw::DataEnd(_) => break,
            _ => {}
        }
    }
    writer.finish().unwrap();
}

/// The logs that the corpus began with. They are left in `target/tmp`, to be copied when what a log holds has changed.
#[test]
fn a_good_log_is_replayed_in_both_spellings() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let (good, plain) = (folder.join("good"), folder.join("plain"));
    write_log(&good);
    write_plain(&good, &plain);
    for path in [good, plain] {
        let log = recorder::read(&path).unwrap();
        assert!(logbook::replay(&log).unwrap().is_same(), "{}", path.display());
        fuzz::run(fuzz::log, &std::fs::read(path).unwrap());
    }
}
