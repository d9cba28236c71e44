//! Guarantees of a session beyond the conformance cases.

use std::f64::consts::TAU;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::Instant;

use gamebots_proto::command::{Drive, Init, Set};
use gamebots_proto::{Command, Message};
use system_tests::{PATIENCE, Server, time_of};

/// SliderController takes the line after the greeting as the answer to the GETCONF that it sends with its INIT.
#[test]
fn a_question_in_the_segment_of_init_is_answered_before_the_first_reading() {
    for factor in [0.0, 1.0] {
        let server = Server::start("rough", &[], |config| config.real_time_factor = factor);
        for _ in 0..20 {
            let mut peer = server.client();
            peer.send_bytes(b"INIT {ClassName USARBot.P3AT} {Location 1.0,2.5,1.8}\nGETCONF {Type GroundTruth}\n");
            assert_eq!(peer.line(), "CONF {Type GroundTruth} {Name GndTruth} {ScanInterval 0.1000}");
        }
    }
}

#[test]
fn wheel_speeds_can_be_revolutions_a_second_everywhere_on_the_wire() {
    let server = Server::start("rough", &[], |config| {
        config.options.speed_unit = TAU;
        config.real_time_factor = 5.0;
    });
    let mut peer = server.client();
    peer.send("INIT {ClassName USARBot.P3AT} {Location 0,0,0}");
    peer.send("GETCONF {Type Robot}");
    assert!(peer.reply().contains("{MaxSpeed 1.2999}"));
    peer.send("DRIVE {Left 0.5} {Right 0.5}");
    peer.lines_for(1.0);
    let tachometer = peer.next_of("Tachometer");
    assert!(tachometer.contains("{Vel 0.5000,0.5000,0.5000,0.5000}"), "{tachometer}");
    let (from, _) = peer.ground_truth();
    peer.lines_for(2.0);
    let (to, _) = peer.ground_truth();
    assert!(to[0] - from[0] > 0.9 * 2.0 * TAU * 0.5 * 0.098, "{from:?} {to:?}");
}

/// A program can drive robots by the protocol's typed commands and messages, as the server uses them.
#[test]
fn a_program_can_drive_by_the_types_of_the_protocol() {
    let server = Server::start("rough", &[], |config| config.real_time_factor = 5.0);
    let mut peer = server.client();
    let mut send = |command: Command| peer.send(&command.write().to_string());
    send(Command::Init(Init { class_name: "USARBot.P3AT".to_owned(), ..Init::default() }));
    send(Command::Drive(Drive::default().with("Left", 1.0).with("Right", 1.0)));
    send(Command::Set(Set { type_name: "INS".to_owned(), opcode: "POSE".to_owned(), ..Set::default() }));
    let lines = peer.lines_for(1.0);
    for line in lines.iter().filter(|line| line.starts_with("S")) {
        let message = Message::read(line).unwrap_or_else(|| panic!("not read: {line}"));
        assert!(message.is_periodic(), "{line}");
    }
}

/// Many students' scripts read a socket as if each `recv` returned one line. A busy machine may read late, so the test waits for a second
/// without a piece of two lines.
#[test]
fn a_client_that_takes_each_piece_for_a_line_gets_one_line_a_piece() {
    let server = Server::start("rough", &[], |_| {});
    let mut socket = TcpStream::connect(server.address).expect("a connection");
    socket.write_all(b"INIT {ClassName USARBot.YouBotArm} {Location 0,0,0}\r\n").expect("it is sent");
    let (end, mut buffer, mut whole) = (Instant::now() + PATIENCE, [0; 512], 0);
    // YouBotArm sends some fourteen lines in one step, ten times a second.
    while whole < 140 {
        assert!(Instant::now() < end, "{whole} lines came one by one at last");
        let count = socket.read(&mut buffer).expect("a piece");
        let piece = String::from_utf8_lossy(&buffer[..count]).into_owned();
        // A laser's scan is longer than the read buffer of such a script.
        let is_line = piece.ends_with("\r\n") && piece.matches("\r\n").count() == 1 || count == buffer.len();
        whole = if is_line { whole + 1 } else { 0 };
    }
}

#[test]
fn a_client_hears_that_its_robot_is_removed_and_nothing_more_of_it() {
    for asks in [true, false] {
        let server = Server::start("rough", &[], |config| config.real_time_factor = 5.0);
        let mut witness = server.client();
        witness.send("INIT {ClassName USARBot.P3AT} {Location 0,0,0}");
        let mut peer = server.client();
        if asks {
            peer.send("REPORT {Errors true}");
        }
        peer.send("INIT {ClassName USARBot.AirRobot} {Name Ann} {Location 99999.9,0,-2}");
        peer.send("DRIVE {LinearVelocity 2}");
        peer.next_of("STA");
        // The map ends at 100 km. A robot 10 m further is outside, which it reaches after 5 s.
        witness.lines_for(8.0);
        peer.send("GETSTARTPOSES");
        let mut lines = Vec::new();
        while !lines.last().is_some_and(|line: &String| line.starts_with("NFO {StartPoses ")) {
            lines.push(peer.line());
        }
        let text = "NFO {Error robot 1 (AirRobot Ann) is removed: it left the map: got position 1000";
        let removed = lines.iter().position(|line| line.starts_with(text));
        assert_eq!(removed.is_some(), asks, "{:?}", lines.last());
        let last = lines.iter().rposition(|line| line.starts_with("STA") || line.starts_with("SEN"));
        assert!(removed.is_none_or(|removed| last < Some(removed)), "a reading after {text}");
        let last = time_of(&lines[last.expect("readings")]).expect("a time");
        assert!((4.0..7.0).contains(&last), "the last reading is of {last} s");
        for line in lines.iter().filter(|line| line.contains("GroundTruth")) {
            let x = line.split("{Location ").nth(1).and_then(|rest| rest.split(',').next()?.parse::<f64>().ok());
            assert!(x.expect("x") <= 1e5 + 10.0, "{line}");
        }
        peer.send("DRIVE {LinearVelocity 0}");
        if asks {
            assert!(peer.reply().starts_with("NFO {Error DRIVE"), "a command for a robot that is gone");
        }
        peer.nothing();
    }
}
