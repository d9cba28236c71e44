//! What a session promises beyond the conformance cases.

use std::f64::consts::TAU;

use gamebots_proto::command::{Drive, Init, Set};
use gamebots_proto::{Command, Message};
use system_tests::Server;

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

/// Typed commands and typed messages serve a program that drives robots as they serve the server.
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
