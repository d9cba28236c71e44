//! Programs in the server's process: they open sessions without a socket.

use std::panic::AssertUnwindSafe;
use std::sync::mpsc::channel;

use gamebots_proto::Command;
use gamebots_server::{Config, Ended, Entrance, Ready, Session};
use sessions::Answer;
use system_tests::{Server, wait_until};

fn order(program: &Session, line: &str) -> Result<Answer, Ended> {
    let command = Command::parse(line, &mut Vec::new()).expect("a command");
    let runtime = tokio::runtime::Builder::new_current_thread().build().expect("a runtime");
    runtime.block_on(program.order(command))
}

#[test]
fn a_program_shares_the_world_with_clients_and_the_log_of_both_replays() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.mcap");
    let server = Server::start("rough", &[], |config| config.log = Some(path.clone()));
    let program = server.entrance.open_program("autopilot").expect("a world");
    let robot = order(&program, "INIT {ClassName USARBot.P3AT} {Name R1} {Location 0,0,0}").expect("an answer").spawned;
    assert!(robot.is_some());
    let mut peer = server.client();
    peer.send("INIT {ClassName USARBot.P3AT} {Name R2} {Location 3,0,0}");
    peer.ground_truth();
    assert_eq!(order(&program, "DRIVE {Left 2} {Right 2}").expect("an answer"), Answer::default());
    let refused = order(&program, "INIT {ClassName USARBot.Ghost} {Location 0,3,0}").expect("an answer");
    assert_eq!((refused.spawned, refused.problems.len()), (None, 1), "{refused:?}");
    peer.lines_for(1.0);
    drop(program);
    peer.send("DRIVE {Left 1} {Right 1}");
    peer.lines_for(0.5);
    let left = server.entrance.open_program("another").expect("a world");
    wait_until(|| {
        // Its place is free again.
        let answer = order(&left, "INIT {ClassName USARBot.P3AT} {Name R1} {Location 0,0,0}").expect("an answer");
        answer.spawned.is_some() && answer.problems.is_empty()
    });
    server.stop().expect("a clean end");
    assert_eq!(order(&left, "DRIVE {Left 1}"), Err(Ended));
    let log = recorder::read(&path).expect("a log");
    let left: Vec<_> = log.entries.iter().filter(|entry| matches!(entry.record, recorder::Record::Left(_))).collect();
    assert!(!left.is_empty());
    assert!(logbook::replay(&log).expect("a replay").is_same());
}

#[test]
fn a_program_orders_the_robot_of_a_client_and_the_log_replays() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.mcap");
    let server = Server::start("rough", &[], |config| config.log = Some(path.clone()));
    let mut client = server.client();
    client.send("INIT {ClassName USARBot.P3AT} {Name R1} {Location 0,0,0}");
    let ([before, ..], _) = client.ground_truth();
    let program = server.entrance.open_program("autopilot").expect("a world");
    // The program has a robot of its own, which the order does not reach.
    let own = order(&program, "INIT {ClassName USARBot.P3AT} {Name R2} {Location 3,0,0}").expect("an answer").spawned;
    let drive = Command::parse("DRIVE {Left 3} {Right 3}", &mut Vec::new()).expect("a command");
    let runtime = tokio::runtime::Builder::new_current_thread().build().expect("a runtime");
    let robot = sim_core::PawnId(0);
    let answer = runtime.block_on(program.order_to(robot, drive)).expect("an answer");
    assert_eq!((answer, own), (Answer::default(), Some(sim_core::PawnId(1))));
    wait_until(|| {
        let ([x, ..], _) = client.ground_truth();
        x > before + 0.2
    });
    server.stop().expect("a clean end");
    let log = recorder::read(&path).expect("a log");
    let lines: Vec<_> = log
        .entries
        .iter()
        .filter_map(|entry| match &entry.record {
            recorder::Record::In(line) if line.line.starts_with("DRIVE") => Some((line.robot, line.connection)),
            _ => None,
        })
        .collect();
    assert_eq!(lines, [(Some(robot.0), program.id())]);
    let replay = logbook::replay(&log).expect("a replay");
    assert!(replay.is_same(), "{replay:?}");
}

#[test]
fn a_program_that_outlives_its_server_is_told() {
    let world = scene_loader::load("rough", &[]).expect("a map");
    let config = Config { listeners: Vec::new(), ..Config::new(world) };
    let (send, entrance) = channel();
    let run = || {
        let ready = |ready: Ready| {
            send.send(ready.entrance).expect("somebody waits");
            panic!("the program that embeds the server fails");
        };
        gamebots_server::run(config, ready, std::future::pending())
    };
    assert!(std::panic::catch_unwind(AssertUnwindSafe(run)).is_err());
    let entrance: Entrance = entrance.recv().expect("the way in");
    wait_until(|| entrance.open_program("late").map_or(true, |late| order(&late, "GETSTARTPOSES").is_err()));
}
