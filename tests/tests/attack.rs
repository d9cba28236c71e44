//! Clients that stop at any point of a good session, in every way. The world continues, and their robots leave.

use std::net::SocketAddr;
use std::sync::mpsc::{TryRecvError, channel};
use std::time::{Duration, Instant};

use gamebots_server::{Listener, Service};
use system_tests::{Honest, Seen, Server, Watch};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpSocket, TcpStream};

/// The points at which clients stop: pairs of the text sent and the text awaited after it.
const CUTS: [(&str, &[(&str, &str)]); 6] = [
    ("after the greeting", &[("", "{TimeLimit 20}\r\n")]),
    ("in the middle of a line", &[("", "{TimeLimit 20}\r\n"), ("INIT {ClassName USARBot.P2AT} {Loc", "")]),
    ("after INIT", &[(INIT, "")]),
    ("in the middle of a line, with a robot", &[(INIT, "{Type Sonar}"), ("DRIVE {Left 1} {Rig", "")]),
    ("while sensors stream", &[(INIT, "{Type Sonar}")]),
    ("in the middle of answers", &[(INIT, "{Type Sonar}"), (QUESTIONS, "NFO {StartPoses 3}")]),
];
const INIT: &str = "INIT {ClassName USARBot.P2AT} {Location 0,0,0}\r\n";
/// A question, repeated so often that the answers fill every buffer on their way.
const QUESTIONS: &str = "GETSTARTPOSES\r\n";
const QUESTION_COUNT: usize = 5_000;
/// Size of such a client's receive buffer, bytes.
const RECEIVE_BUFFER: u32 = 4096;

#[derive(Debug, Clone, Copy, PartialEq)]
enum End {
    /// Does nothing more, and does not close.
    Stall,
    /// Closes its sending side, and does nothing more.
    HalfClose,
    Close,
    Reset,
}

/// Runs a client's steps up to its stop.
async fn session(address: SocketAddr, steps: &[(&str, &str)]) -> TcpStream {
    let socket = TcpSocket::new_v4().expect("a socket");
    socket.set_recv_buffer_size(RECEIVE_BUFFER).expect("a small buffer");
    let mut stream = socket.connect(address).await.expect("a connection");
    for &(send, wait_for) in steps {
        let text = if send == QUESTIONS { QUESTIONS.repeat(QUESTION_COUNT) } else { send.to_owned() };
        stream.write_all(text.as_bytes()).await.expect("it is taken");
        let (mut seen, mut buffer) = (String::new(), [0; 512]);
        while !seen.contains(wait_for) {
            let count = stream.read(&mut buffer).await.expect("something comes");
            assert!(count > 0, "the server ended the connection");
            seen.push_str(&String::from_utf8_lossy(&buffer[..count]));
        }
    }
    stream
}

/// Ends a session. Returns the connection if it stays open.
async fn end(mut stream: TcpStream, end: End) -> Option<TcpStream> {
    match end {
        End::Stall => return Some(stream),
        End::HalfClose => {
            stream.shutdown().await.expect("its own side ends");
            return Some(stream);
        }
        End::Close => {}
        End::Reset => stream.set_zero_linger().expect("a reset"),
    }
    None
}

fn is_there(seen: &Seen, connection: u64) -> bool {
    let clients = seen.status["clients"].as_array().map_or(&[][..], Vec::as_slice);
    clients.iter().any(|client| client["connection"] == connection)
}

#[test]
fn a_client_that_stops_at_any_point_takes_its_robot_with_it_and_disturbs_nobody() {
    let server = Server::start("rough", &[], |config| {
        // Simulated time runs fast, so unread readings soon fill every buffer on their way.
        config.real_time_factor = 100.0;
        config.options.time_step = 0.02;
        config.stall_timeout = Duration::from_millis(500);
        config.listeners.push(Listener::new(Service::Page, 0));
    });
    let watch = Watch::start(server.page.expect("a page"));
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().expect("a runtime");
    let mut honest = Honest::join(server.address);
    // Dropping this end of the channel stops the bystander, also if the test fails.
    let (stop, stopped) = channel::<()>();
    let bystander = std::thread::spawn(move || {
        let answers = honest.answers();
        while stopped.try_recv() == Err(TryRecvError::Empty) {
            honest.ask_until(Instant::now() + Duration::from_millis(50), Duration::from_millis(5), &answers);
        }
        honest
    });
    // The bystander is the first connection.
    let mut connections = 1;
    for way in [End::Stall, End::HalfClose, End::Close, End::Reset] {
        let start = Instant::now();
        let mut left = Vec::new();
        for (_, steps) in CUTS {
            left.push(runtime.block_on(async { end(session(server.address, steps).await, way).await }));
        }
        // A later client is connected. The others are gone, and so are their robots. A client that stalls without a robot gets no lines, so
        // it may stay.
        let later = server.client();
        for (index, (cut, steps)) in (1..).zip(CUTS) {
            let may_stay = way == End::Stall && !steps.iter().any(|(send, _)| *send == INIT);
            watch.wait_for(&format!("{way:?} {cut}"), |seen| {
                is_there(seen, connections + 1 + CUTS.len() as u64) && is_there(seen, connections + index) == may_stay
            });
        }
        watch.wait_for("the bystander's robot alone", |seen| seen.robots() == 1);
        println!("{way:?}: all robots are gone in {:.2} s", start.elapsed().as_secs_f64());
        drop((left, later));
        watch.wait_for("the bystander alone", |seen| seen.clients() == 1);
        connections += 1 + CUTS.len() as u64;
    }
    drop(stop);
    let honest = bystander.join().expect("the bystander");
    println!("{} readings beside them in {:.0} simulated seconds", honest.readings, honest.time());
    assert_eq!(honest.gaps, Vec::<String>::new());
    assert!(honest.readings > 1000, "{} readings", honest.readings);
    drop(honest);
    server.stop().expect("a clean end");
}
