//! Malformed and malicious input: no other client is disturbed, nothing panics, and only answers that USARSim would send come back.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use system_tests::{Peer, Server};

#[test]
fn bad_lines_get_no_answer_and_leave_the_connection_working() {
    let server = Server::start("rough", &[], |config| config.real_time_factor = 5.0);
    let mut bystander = server.bystander();
    let mut peer = server.client();
    peer.send("INIT {ClassName USARBot.P3AT} {Name R1} {Location 0,0,0}");
    for line in [
        "FOO {a b}",
        "DRIVE",
        "DRIVE {Left NaN} {Right inf}",
        "DRIVE {Left 1e999} {Right -1e999}",
        "DRIVE {Left 99999999999999999999999999} {Right 0}",
        "DRIVE {WheelNumber 99999999999} {WheelSpeed x} {WheelNumber -1} {WheelSpeed 1}",
        "INIT {ClassName }",
        "INIT",
        "INIT {ClassName USARBot.NoSuch}",
        "INIT {ClassName ../../etc/passwd}",
        "SET {Type INS} {Opcode POSE} {Params NaN,NaN,NaN,NaN,NaN,NaN}",
        "SET {Type Camera} {Opcode FOV} {Params 1e308}",
        "SET",
        "GETCONF {Type Lidar}",
        "GETGEO",
        "}{}{}{}{}}}}{{{{",
        "ACT {Name nobody} {Link 0} {Value 1}",
        "CONTROL {Type KillAll}",
        "\u{0}\u{1}\u{7f}",
        "DRIVE {Left 0} {Right 0}",
    ] {
        peer.send(line);
    }
    peer.nothing();
    bystander.check_undisturbed();
    peer.ground_truth();
}

#[test]
fn places_that_make_no_sense_do_not_break_the_world() {
    let server = Server::start("rough", &[], |config| config.real_time_factor = 5.0);
    let mut bystander = server.bystander();
    for place in ["{Location NaN,inf,300}", "{Location 9e4,-9e4,0} {Rotation 1e9,1e9,1e9}"] {
        let mut peer = server.client();
        peer.send(&format!("INIT {{ClassName USARBot.P3AT}} {place}"));
        peer.send("DRIVE {Left 1} {Right 1}");
        peer.next_of("STA");
    }
    for (place, refused) in [
        ("{Location NaN,inf,1e30}", "it is outside the map: got "),
        ("{Location 1e30,-1e30,0}", "it is outside the map: got "),
        ("{Location 0,0,1e9}", "it is outside the map: got "),
        ("{Location 0,0,-2e5}", "it is outside the map: got "),
        ("{Location 0,0,3e4}", "the solid `floor` takes it"),
    ] {
        let mut peer = server.client();
        peer.send("REPORT {Errors true}");
        peer.send(&format!("INIT {{ClassName USARBot.P3AT}} {place}"));
        peer.wait_for(refused, |line| line.contains(refused) && line.contains("no robot is spawned"));
        peer.send("DRIVE {Left 1} {Right 1}");
        assert!(peer.reply().contains("there is no robot on this connection"));
    }
    bystander.check_undisturbed();
}

#[test]
fn a_megabyte_without_a_line_end_is_discarded_and_the_next_line_works() {
    let server = Server::start("rough", &[], |_| {});
    let mut bystander = server.bystander();
    let mut peer = server.client();
    peer.send_bytes(&vec![b'x'; 1 << 20]);
    peer.send_bytes(b"\r\n");
    peer.nothing();
    bystander.check_undisturbed();
}

#[test]
fn binary_is_no_line_and_harms_nobody() {
    let server = Server::start("rough", &[], |_| {});
    let mut bystander = server.bystander();
    let mut peer = server.client();
    // A fixed stream of every byte value, in an order that makes no text.
    let bytes: Vec<u8> = (0u32..200_000).map(|index| (index.wrapping_mul(2_654_435_761) >> 23) as u8).collect();
    peer.send_bytes(&bytes);
    peer.send_bytes(b"\r\n");
    peer.nothing();
    bystander.check_undisturbed();
}

#[test]
fn clients_that_vanish_take_their_robot_with_them() {
    let server = Server::start("rough", &[], |config| config.real_time_factor = 5.0);
    let mut bystander = server.bystander();
    for _ in 0..5 {
        let mut peer = server.client();
        peer.send("INIT {ClassName USARBot.P3AT} {Name Gone} {Location 0,0,0}");
        peer.next_of("STA");
        // It leaves with unread bytes, which resets the connection, in the middle of a line.
        peer.send_bytes(b"DRIVE {Left 1} {Rig");
    }
    // The place becomes free again: a robot stands on the floor, not on earlier robots.
    let mut tries = 0;
    loop {
        let mut peer = server.client();
        peer.send("INIT {ClassName USARBot.P3AT} {Name Last} {Location 0,0,0}");
        let height = peer.ground_truth().0[2];
        if (height + 0.147).abs() < 0.01 {
            break;
        }
        tries += 1;
        assert!(tries < 300, "never free: {height}");
        std::thread::sleep(Duration::from_millis(10));
    }
    bystander.check_undisturbed();
}

#[test]
fn what_was_asked_before_leaving_is_answered() {
    let server = Server::start("rough", &[], |_| {});
    let mut peer = server.client();
    // Without a line end, too.
    peer.send_bytes(b"GETSTARTPOSES");
    peer.finish();
    assert!(peer.reply().starts_with("NFO {StartPoses 3}"));
    assert_eq!(peer.line_or_end(), None);
}

#[test]
fn answers_are_never_lost_however_late_they_are_read() {
    const QUESTIONS: usize = 20_000;
    let server = Server::start("rough", &[], |_| {});
    let mut bystander = server.bystander();
    let mut stream = TcpStream::connect(server.address).expect("a connection");
    let mut sender = stream.try_clone().expect("a second handle");
    let thread = std::thread::spawn(move || {
        let questions = "GETSTARTPOSES\r\n".repeat(QUESTIONS);
        sender.write_all(questions.as_bytes()).expect("all is taken");
        sender.shutdown(std::net::Shutdown::Write).expect("the end is taken");
    });
    // No byte is read while the bystander is served.
    bystander.check_undisturbed();
    let mut text = String::new();
    stream.read_to_string(&mut text).expect("the answers");
    thread.join().expect("the sender");
    assert_eq!(text.matches("NFO {StartPoses 3}").count(), QUESTIONS);
}

#[test]
fn a_client_that_never_reads_loses_sensor_lines_and_is_thrown_out() {
    let server = Server::start("rough", &[], |config| {
        config.real_time_factor = 0.0;
        config.stall_timeout = Duration::from_secs(1);
    });
    let mut silent = TcpStream::connect(server.address).expect("a connection");
    silent.write_all(b"INIT {ClassName USARBot.P2AT} {Location 0,0,0}\r\n").expect("INIT is taken");
    let mut other = server.client();
    // While its robot is there, another one spawned at the place stands on it.
    let mut tries = 0;
    loop {
        let mut probe = server.client();
        probe.send("INIT {ClassName USARBot.P3AT} {Location 0,0,0}");
        if probe.ground_truth().0[2] > -0.2 {
            break;
        }
        tries += 1;
        assert!(tries < 3000, "never thrown out");
        std::thread::sleep(Duration::from_millis(10));
    }
    other.nothing();
}

#[test]
fn problems_are_reported_on_the_wire_only_when_asked_for() {
    let server = Server::start("rough", &[], |config| config.report_errors = true);
    let mut peer = server.client();
    peer.send("FOO {a b}");
    assert!(peer.reply().starts_with("NFO {Error unknown verb `FOO`; expected one of INIT, DRIVE,"));
    peer.send("DRIVE {Left 1} {Right 1}");
    assert_eq!(peer.reply(), "NFO {Error DRIVE ignored: there is no robot on this connection; send INIT first}");
    peer.send("INIT {ClassName USARBot.P3AT} {Start nowhere}");
    assert!(peer.reply().starts_with("NFO {Error 'Start nowhere' is unknown; expected one of PlayerStart_0,"));
}

#[test]
fn robots_without_number_are_refused_at_a_limit() {
    let server = Server::start("rough", &[], |config| config.report_errors = true);
    let mut peer = server.client();
    let init = |index: u32| format!("INIT {{ClassName USARBot.CasterSkidRobot}} {{Location {},0,-0.2}}\r\n", 3 * index);
    peer.send_bytes((0..257).map(init).collect::<String>().as_bytes());
    assert_eq!(peer.reply(), "NFO {Error INIT refused: the world holds 256 robots already}");
}

#[test]
fn a_connection_is_told_its_mistakes_when_it_asks_for_them() {
    let server = Server::start("rough", &[], |_| {});
    let mut peer = server.client();
    peer.send("FOO");
    peer.nothing();
    peer.send("REPORT {Errors true}");
    peer.send("INIT {ClassName USARBot.KUKAYouBot}");
    let reply = peer.reply();
    let expected = "NFO {Error 'ClassName USARBot.KUKAYouBot' is unknown (did you mean `USARBot.KUKA_YouBot`?); \
         `usarsim robots` lists all; ";
    assert!(reply.starts_with(expected), "{reply}");
    peer.send("INIT {ClassName USARBot.P3AT} {Start PlayerStart_1} {Naem Ann}");
    assert!(peer.reply().starts_with("NFO {Error INIT has no key `Naem` (did you mean `Name`?); expected "));
    assert!(peer.reply().starts_with("NFO {Error 'Start PlayerStart_1' is unknown (did you mean `PlayerStart_0`?); "));
    for x in [5, 8] {
        peer.send(&format!("INIT {{ClassName USARBot.P3AT}} {{Name Twin}} {{Location {x},5,0}}"));
    }
    assert!(peer.reply().starts_with("NFO {Error 'Name Twin' is the name of another robot too"));
    // Other clients do not get it.
    let mut other = server.client();
    other.send("FOO");
    other.nothing();
    peer.send("REPORT {Errors false}");
    peer.send("FOO");
    peer.nothing();
}

/// Returns the real time of a second of simulated time, for a client that also asks a question.
fn second(peer: &mut Peer) -> Duration {
    let start = Instant::now();
    peer.lines_for(1.0);
    peer.nothing();
    start.elapsed()
}

#[test]
fn clients_that_never_stop_talking_do_not_hold_up_others() {
    for line in [
        "SET {Type RangeScanner} {Opcode SCAN}\r\n".repeat(400),
        "A\r\n".repeat(5000),
        "DRIVE {Left 1} {Right 1}\r\n".repeat(600),
        format!("DRIVE {}\r\n", "{Left 1}".repeat(4096)),
        format!("A{{{}{{\r\n", "}".repeat(60_000)),
    ] {
        let server = Server::start("rough", &[], |_| {});
        let mut bystander = server.bystander();
        let alone = second(&mut bystander);
        let stop = Arc::new(AtomicBool::new(false));
        let flood = |index: usize| {
            let mut stream = TcpStream::connect(server.address).expect("a connection");
            let mut reader = stream.try_clone().expect("a second handle");
            let init = format!("INIT {{ClassName USARBot.P3AT}} {{Location {},0,0}}\r\n", 3 * index);
            let (line, stop) = (line.clone(), stop.clone());
            // It reads all that it is sent, so only the world limits it.
            std::thread::spawn(move || while reader.read(&mut [0; 65536]).is_ok_and(|count| count > 0) {});
            std::thread::spawn(move || {
                let sent = stream.write_all(init.as_bytes());
                while sent.is_ok() && !stop.load(Ordering::Relaxed) && stream.write_all(line.as_bytes()).is_ok() {}
            })
        };
        let floods: Vec<_> = (0..3).map(flood).collect();
        bystander.lines_for(0.2);
        let beside = second(&mut bystander);
        println!("{:.30}: a second takes {alone:?}, beside floods {beside:?}", line.lines().next().unwrap_or_default());
        stop.store(true, Ordering::Relaxed);
        assert!(beside < 4 * alone, "{beside:?} beside floods, {alone:?} alone");
        // They do not delay the shutdown, either.
        server.stop().expect("a clean end");
        floods.into_iter().for_each(|flood| flood.join().expect("a flood"));
    }
}

#[test]
fn web_pages_cannot_talk_to_the_port_of_the_protocol() {
    let server = Server::start("rough", &[], |_| {});
    let body = "REPORT {Errors true}\r\nINIT {ClassName USARBot.P3AT} {Location 0,0,0}\r\nGETSTARTPOSES\r\n";
    let long = format!("POST /{} HTTP/1.1", "x".repeat(100_000));
    for first in ["POST / HTTP/1.1", "GET /} HTTP/1.1", "OPTIONS * HTTP/1.1", &long] {
        for pieces in [1, 3] {
            let mut stream = TcpStream::connect(server.address).expect("a connection");
            let request = format!("{first}\r\nHost: localhost\r\nContent-Length: {}\r\n\r\n{body}", body.len());
            for piece in request.as_bytes().chunks(if pieces == 1 { request.len() } else { 3 }).take(200) {
                // The server may have closed the connection already.
                let _ = stream.write_all(piece);
            }
            let mut answer = Vec::new();
            let _ = stream.read_to_end(&mut answer);
            let answer = String::from_utf8_lossy(&answer);
            assert!(!answer.contains("StartPoses") && !answer.contains("SEN "), "{first:.40}: {answer:.400}");
        }
    }
    let mut probe = server.client();
    probe.send("INIT {ClassName USARBot.P3AT} {Location 0,0,0}");
    assert!(probe.ground_truth().0[2] > -0.2, "no robot was made there");
}

#[test]
fn a_client_that_leaves_takes_all_of_its_robots_with_it_unless_robots_are_kept() {
    for keep_robots in [false, true] {
        let server = Server::start("rough", &[], |config| config.options.keep_robots = keep_robots);
        let mut leaver = server.client();
        for x in [0, 3, 6] {
            leaver.send(&format!("INIT {{ClassName USARBot.P3AT}} {{Location {x},0,0}}"));
        }
        leaver.nothing();
        leaver.finish();
        while leaver.line_or_end().is_some() {}
        let stands = [0, 3, 6].map(|x| {
            let mut probe = server.client();
            probe.send(&format!("INIT {{ClassName USARBot.P3AT}} {{Location {x},0,0}}"));
            // Beside another robot that is still there.
            let [at, aside, _] = probe.ground_truth().0;
            (at - f64::from(x)).hypot(aside) > 0.3
        });
        assert_eq!(stands, [keep_robots, keep_robots, false]);
    }
}

/// A scan that restarts at each brace takes ten thousand times as long as one scan of the text.
#[test]
fn stray_braces_are_passed_over_once() {
    let time = |line: &str| {
        let start = Instant::now();
        (0..10).for_each(|_| assert_eq!(gamebots_proto::Line::parse(line).blocks.len(), 1));
        start.elapsed()
    };
    let braces = time(&format!("A{{{}{{", "}".repeat(64_000)));
    let text = time(&format!("A{{{}}}", "x".repeat(64_000)));
    println!("{braces:?} for braces, {text:?} for text");
    assert!(braces < 20 * text, "{braces:?} for braces, {text:?} for text");
}
