//! A short run and its records, for tests.

#![allow(dead_code, reason = "each test uses a part")]

use std::path::Path;

use gamebots_proto::{Command, Dialect};
use recorder::{End, LogWriter, Record, RobotState, StateTimer, Vector, WireLine};
use scene::{PawnId, WorldDef};
use sim_core::{Options, Report, World};

/// The map `rough` and the class of one robot.
pub(crate) fn world() -> WorldDef {
    let mut world = scene_loader::load("rough", &[]).expect("the map");
    world.robots.retain(|class| class == "P3AT");
    world
}

/// A line of the first connection.
pub(crate) fn line(text: impl Into<String>) -> WireLine {
    WireLine { connection: 1, robot: None, line: text.into() }
}

/// A state with the fewest fields.
pub(crate) fn state(robot: u64, class: &str) -> RobotState {
    RobotState {
        robot,
        class: class.to_owned(),
        position: Some(Vector { x: 1.0, y: 2.0, z: 3.0 }),
        ..RobotState::default()
    }
}

/// Two robots drive for half a second; the second leaves half way.
pub(crate) fn run() -> (Vec<(f64, Record)>, End) {
    let (mut world, mut states) = (World::new(world(), Options::default()), StateTimer::default());
    let mut records = Vec::new();
    let mut robots = Vec::new();
    let send = |world: &mut World, records: &mut Vec<_>, connection: u64, robot: Option<PawnId>, text: &str| {
        let line = WireLine { connection, robot: robot.map(|robot| robot.0), line: text.to_owned() };
        records.push((world.time(), Record::In(line)));
        let command = Command::parse(text, &mut Vec::new()).expect("a command");
        world.execute(robot, &command, &mut Vec::new()).spawned
    };
    for (connection, y) in [(1, 0), (2, 3)] {
        let init = format!("INIT {{ClassName USARBot.P3AT}} {{Name R{connection}}} {{Location 2,{y},0}}");
        let robot = send(&mut world, &mut records, connection, None, &init);
        send(&mut world, &mut records, connection, robot, "DRIVE {Left 2} {Right 1}");
        robots.extend(robot);
    }
    for step in 0..250 {
        for (robot, report) in world.step() {
            if let Report::Sensed(sensed) = &report {
                records.push((world.time(), Record::Sensed(sensed.clone())));
            }
            let message = world.message(report).expect("a message");
            let line = WireLine { connection: robot.0 + 1, robot: Some(robot.0), line: message.write(Dialect::Udk) };
            records.push((world.time(), Record::Out(line)));
        }
        if states.is_due(world.time()) {
            let due = world.snapshot().robots;
            records.extend(due.iter().map(|robot| (world.time(), Record::State(RobotState::new(robot)))));
        }
        if step == 125 {
            let robot = robots[1];
            world.remove(robot);
            records.push((world.time(), Record::Left(robot.0)));
            records.push((world.time(), Record::Closed(WireLine { connection: 2, robot: None, line: String::new() })));
        }
    }
    records.push((world.time(), Record::Warning("behind its pace".to_owned())));
    let end = End { time: world.time(), digest: Some(world.digest()), unsettled_steps: 0, dropped: 0 };
    (records, end)
}

/// Writes a log of records, ended properly.
pub(crate) fn write(path: &Path, world: &WorldDef, records: &[(f64, Record)], end: End) {
    let mut log = LogWriter::create(path, world, Options::default(), &[]).expect("a log");
    for (index, (time, record)) in records.iter().enumerate() {
        log.write(*time, record).expect("a record");
        // Makes several chunks.
        if index % 20 == 19 {
            log.flush().expect("a chunk");
        }
    }
    log.finish(end).expect("an end");
}

/// The end of a world at a time, with nothing else known.
#[allow(dead_code, reason = "not every test ends one")]
pub(crate) fn end(time: f64) -> End {
    End { time, digest: None, unsettled_steps: 0, dropped: 0 }
}
