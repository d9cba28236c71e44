//! The radio between robots: bytes over its ports, links that break and come back, robots that leave.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};

use gamebots_server::{Listener, Propagation, Service};
use system_tests::{PATIENCE, Peer, Server, wait_until};

fn server(map: &str, propagation: Propagation) -> Server {
    Server::start(map, &[], |config| {
        config.listeners.push(Listener::new(Service::Wireless, 0));
        config.propagation = propagation;
    })
}

/// A robot on the radio, with a port at which it listens.
struct Radio {
    control: Peer,
    listener: TcpListener,
}

impl Radio {
    fn new(server: &Server, name: &str) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        let port = listener.local_addr().expect("an address").port();
        let mut radio = Self { control: server.beside(server.wireless), listener };
        let answer = radio.ask(&format!("INIT {{Robot {name}}} {{Port {port}}}"));
        assert_eq!(answer, "INITREPLY {Status OK}");
        radio
    }

    fn ask(&mut self, line: &str) -> String {
        self.control.send(line);
        self.control.line()
    }

    /// Returns the strength of the signal of another robot as it is said.
    fn strength(&mut self, other: &str) -> String {
        let answer = self.ask(&format!("GETSS {{Robot {other}}}"));
        let rest = answer.strip_prefix(&format!("SS {{Robot {other}}} {{Strength ")).expect("SS");
        rest.trim_end_matches('}').to_owned()
    }

    /// Returns the address at which another robot is reached.
    fn way_to(&mut self, other: &str) -> SocketAddr {
        let answer = self.ask(&format!("DNS {{Robot {other}}}"));
        let port = answer.rsplit(' ').next().and_then(|it| it.trim_end_matches('}').parse().ok());
        SocketAddr::from(([127, 0, 0, 1], port.unwrap_or_else(|| panic!("{answer}"))))
    }

    fn accept(&self) -> TcpStream {
        let (stream, _) = self.listener.accept().expect("a connection");
        stream.set_read_timeout(Some(PATIENCE)).expect("a timeout");
        stream
    }
}

fn robot(server: &Server, name: &str, place: &str) -> Peer {
    let mut peer = server.client();
    peer.send(&format!("INIT {{ClassName USARBot.P3AT}} {{Name {name}}} {{Location {place}}}"));
    peer.ground_truth();
    peer
}

/// MRL's programs connect, send a message and close at once.
#[test]
fn no_byte_is_lost_when_the_sender_closes_at_once() {
    let server = server("rough", Propagation::Everywhere);
    let (mut a, b) = (Radio::new(&server, "A"), Radio::new(&server, "B"));
    let way = a.way_to("B");
    assert_eq!(a.way_to("B"), way, "the port stays");
    let message: Vec<u8> = (0..200_000_u32).map(|number| (number % 251) as u8).collect();
    for _ in 0..5 {
        let mut stream = TcpStream::connect(way).expect("a connection");
        stream.write_all(&message).expect("to send");
        drop(stream);
        let mut received = Vec::new();
        b.accept().read_to_end(&mut received).expect("the message");
        assert!(received == message, "{} of {} bytes", received.len(), message.len());
    }
}

#[test]
fn bytes_go_both_ways_and_the_receiver_learns_who_sends() {
    let server = server("rough", Propagation::Everywhere);
    let (mut a, mut b) = (Radio::new(&server, "A"), Radio::new(&server, "B"));
    let mut here = TcpStream::connect(a.way_to("B")).expect("a connection");
    here.write_all(b"ping").expect("to send");
    let mut there = b.accept();
    let mut buffer = [0; 4];
    there.read_exact(&mut buffer).expect("bytes");
    assert_eq!(&buffer, b"ping");
    there.write_all(b"pong").expect("to send");
    here.set_read_timeout(Some(PATIENCE)).expect("a timeout");
    here.read_exact(&mut buffer).expect("bytes");
    assert_eq!(&buffer, b"pong");
    let port = there.peer_addr().expect("an address").port();
    assert_eq!(b.ask(&format!("REVERSEDNS {{Port {port}}}")), format!("REVERSEDNSREPLY {{Port {port}}} {{Robot A}}"));
    // A robot that leaves the radio frees its name and its ports, and its relays end.
    let way = a.way_to("B");
    drop(b);
    wait_until(|| a.strength("B") == "NaN} {Error Robot.Does.Not.Exist");
    wait_until(|| TcpStream::connect(way).is_err());
    for end in [&mut here, &mut there] {
        assert!(matches!(end.read(&mut buffer), Ok(0) | Err(_)), "the relay goes on");
    }
}

/// Otherwise one pair of robots takes the descriptors of everybody.
#[test]
fn an_address_has_half_of_the_relays_and_what_is_over_is_closed() {
    let server = server("rough", Propagation::Everywhere);
    let (mut a, _b) = (Radio::new(&server, "A"), Radio::new(&server, "B"));
    let way = a.way_to("B");
    let mut relays: Vec<TcpStream> = (0..200).filter_map(|_| TcpStream::connect(way).ok()).collect();
    let is_open = |relay: &mut TcpStream| {
        relay.set_nonblocking(true).expect("a stream");
        matches!(relay.read(&mut [0; 4]), Err(error) if error.kind() == std::io::ErrorKind::WouldBlock)
    };
    wait_until(|| relays.iter_mut().map(is_open).filter(|is_open| *is_open).count() == 64);
    robot(&server, "C", "0,0,0");
}

#[test]
fn signals_weaken_with_distance() {
    let server = server("rough", Propagation::Distance);
    let _robots = [robot(&server, "A", "0,0,0"), robot(&server, "B", "10,0,0")];
    let (mut a, mut b) = (Radio::new(&server, "A"), Radio::new(&server, "B"));
    let strength: f64 = a.strength("B").parse().expect("a number");
    assert!((strength + 56.6597).abs() < 0.001, "{strength}");
    assert_eq!(b.strength("A"), a.strength("B"));
}

/// In the arena a wall stands between them. The sixth would break the link; one weakens it by 6.325 dBm.
#[test]
fn a_wall_weakens_a_signal() {
    let server = server("arena", Propagation::Walls);
    let _robots = [robot(&server, "A", "0.5,2.5,0"), robot(&server, "B", "0.5,4.5,0")];
    let (mut a, _b) = (Radio::new(&server, "A"), Radio::new(&server, "B"));
    let strength: f64 = a.strength("B").parse().expect("a number");
    assert!((strength + 49.67 + 6.325).abs() < 0.01, "{strength}");
}

/// A robot that the world does not have is dropped within seconds, and one that is far off is not reached until it is near again, at the same
/// port.
#[test]
fn links_break_with_distance_and_come_back() {
    let server = server("rough", Propagation::Distance);
    let _near = robot(&server, "A", "0,0,0");
    let far = robot(&server, "B", "90000,0,0");
    let (mut a, b) = (Radio::new(&server, "A"), Radio::new(&server, "B"));
    let way = a.way_to("B");
    wait_until(|| TcpStream::connect(way).is_err());
    let mut controller = server.client();
    controller.send("INIT {ClassName USARBotAPI.WorldController}");
    controller.send("CONTROL {Type AbsMove} {Name B} {Location 5,0,0}");
    wait_until(|| TcpStream::connect(way).is_ok());
    let mut here = TcpStream::connect(way).expect("a connection");
    here.set_read_timeout(Some(PATIENCE)).expect("a timeout");
    here.write_all(b"x").expect("to send");
    assert_eq!(a.way_to("B"), way);
    controller.send("CONTROL {Type AbsMove} {Name B} {Location 90000,0,0}");
    // The running connection breaks, too.
    assert!(matches!(here.read(&mut [0]), Ok(0) | Err(_)));
    drop(far);
    let Radio { mut control, .. } = b;
    wait_until(|| control.line_or_end().is_none());
    assert_eq!(a.strength("B"), "NaN} {Error Robot.Does.Not.Exist");
}

/// Eight robots send messages of 4 kB to each other while twenty others drive and one client floods.
#[test]
fn eight_robots_talk_while_others_drive_and_one_floods() {
    let server = server("arena", Propagation::Walls);
    let mut bystander = server.bystander();
    let names: Vec<String> = (0..8).map(|number| format!("R{number}")).collect();
    let _robots: Vec<Peer> =
        names.iter().enumerate().map(|(number, name)| robot(&server, name, &format!("{number},-1,0"))).collect();
    let mut radios: Vec<Radio> = names.iter().map(|name| Radio::new(&server, name)).collect();
    let mut flood = TcpStream::connect(server.wireless.expect("a port")).expect("a connection");
    flood.set_nonblocking(true).expect("no waiting");
    let _ = flood.write(&b"INIT {Robot Flood}\r\nGETSS {Robot R1}\r\n".repeat(5000));
    for from in 0..8 {
        let to = (from + 1) % 8;
        let way = radios[from].way_to(&names[to]);
        let mut stream = TcpStream::connect(way).expect("a connection");
        stream.write_all(&[from as u8; 4096]).expect("to send");
        drop(stream);
        let mut received = Vec::new();
        radios[to].accept().read_to_end(&mut received).expect("a message");
        assert_eq!(received, [from as u8; 4096]);
    }
    bystander.check_undisturbed();
}

#[test]
fn a_page_of_the_web_and_a_half_closed_client_register_nobody() {
    let server = server("rough", Propagation::Everywhere);
    let lines = b"POST / HTTP/1.1\r\n\r\nINIT {Robot A} {Port 1}\r\n";
    let mut page = TcpStream::connect(server.wireless.expect("a port")).expect("a connection");
    page.write_all(lines).expect("to send");
    let mut text = Vec::new();
    // The server closes with unread bytes, which may reset the connection.
    let _ = page.read_to_end(&mut text);
    assert_eq!(text, b"");
    let mut half = TcpStream::connect(server.wireless.expect("a port")).expect("a connection");
    half.write_all(b"INIT {Robot A} {Port 1}\r\nGETSS {Robot A}\r\nINIT {Robot").expect("to send");
    half.shutdown(std::net::Shutdown::Write).expect("to end");
    let mut text = String::new();
    half.read_to_string(&mut text).expect("answers");
    assert_eq!(text, "INITREPLY {Status OK}\r\nSS {Robot A} {Strength INF} {Error SS.To.Self}\r\n");
    // The name is free again.
    Radio::new(&server, "A");
}
