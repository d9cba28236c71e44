//! The old relay between robots, 5874: its answers, and the bytes that it passes on.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};

use gamebots_server::{Listener, Propagation, Service};
use system_tests::{PATIENCE, Peer, Server};

fn server(propagation: Propagation) -> Server {
    Server::start("arena", &[], |config| {
        config.listeners.push(Listener::new(Service::ComServer, 0));
        config.propagation = propagation;
    })
}

/// A client of the relay.
struct Client(TcpStream);

impl Client {
    fn connect(server: &Server) -> Self {
        let stream = TcpStream::connect(server.com_server.expect("a port")).expect("a connection");
        stream.set_read_timeout(Some(PATIENCE)).expect("a timeout");
        Self(stream)
    }

    /// Sends bytes and returns what comes up to a number of `;`.
    fn ask(&mut self, bytes: &str, answers: usize) -> String {
        self.0.write_all(bytes.as_bytes()).expect("sent");
        let mut text = String::new();
        while text.matches(';').count() < answers {
            let mut byte = [0];
            self.0.read_exact(&mut byte).unwrap_or_else(|error| panic!("{bytes}: {text}: {error}"));
            text.push(char::from(byte[0]));
        }
        text
    }
}

/// Cases 113 and 114.
#[test]
fn robots_register_and_listen() {
    let server = server(Propagation::Everywhere);
    let mut client = Client::connect(&server);
    for (command, expected) in [
        ("REGISTER R1 10.0.0.1;", "OK;"),
        ("register R1 10.0.0.1;", "OK;"),
        ("REGISTER R1 10.0.0.2;", "Fail: Robot with name R1 already registered;"),
        ("LISTEN R9 5000;", "Fail: Robot R9 not registered;"),
        ("REGISTER R1;", "Fail: Incorrect Message;"),
        ("HELLO;", "Fail: Unknown Message;"),
        (";", "Fail: Unknown Message;"),
        ("LISTEN R1 5000;", "OK;"),
        ("LISTEN R1 5000;", "Fail: Robot with name R1 already listening at port 5000;"),
        ("OPEN R1 1 R2 2;", "Fail: R2 not listening on port 2;"),
        ("GETSS R1 R1;", "Fail: Could not calculate signal strength;"),
        ("GETSS A B;", "Fail: Server does not accept third party requests;"),
    ] {
        assert_eq!(client.ask(command, 1), expected, "{command}");
    }
    assert_eq!(client.ask("REGISTER R2 10.0.0.1;HELLO;LIS", 2), "OK;Fail: Unknown Message;");
    assert_eq!(client.ask("TEN R2 7;", 1), "OK;");
}

/// Two robots that are registered, listen, and are joined.
struct Joined {
    client: Client,
    ends: [TcpStream; 2],
}

impl Joined {
    fn new(server: &Server) -> Self {
        let mut client = Client::connect(server);
        let listeners = [(); 2].map(|()| TcpListener::bind("127.0.0.1:0").expect("a port"));
        let [a, b] = listeners.each_ref().map(|it| it.local_addr().expect("an address").port());
        for command in ["REGISTER A 127.0.0.1;", "REGISTER B localhost;", &format!("LISTEN B {b};")] {
            assert_eq!(client.ask(command, 1), "OK;", "{command}");
        }
        assert_eq!(client.ask(&format!("OPEN A {a} B {b};"), 1), "OK;");
        assert_eq!(client.ask(&format!("OPEN A {a} B {b};"), 1), format!("Fail: B not listening on port {b};"));
        let ends = listeners.map(|listener| listener.accept().expect("a connection").0);
        ends.iter().for_each(|end| end.set_read_timeout(Some(PATIENCE)).expect("a timeout"));
        Self { client, ends }
    }
}

#[test]
fn joined_robots_send_and_close() {
    let server = server(Propagation::Everywhere);
    let Joined { ends: [mut a, mut b], .. } = Joined::new(&server);
    let message = vec![b';'; 100_000];
    a.write_all(b"SEND 100000 ").and_then(|()| a.write_all(&message)).expect("sent");
    a.write_all(b";NOISE;SEND 2 ok;").expect("sent");
    let mut got = vec![0; message.len() + 2];
    b.read_exact(&mut got).expect("bytes");
    assert!(got == [&message[..], b"ok"].concat());
    b.write_all(b"SEND 5 hello;CLOSE;").expect("sent");
    let mut got = String::new();
    a.read_to_string(&mut got).expect("an end");
    assert_eq!(got, "hello");
    assert_eq!(b.read(&mut [0; 8]).expect("an end"), 0);
}

#[test]
fn joined_robots_are_parted_when_one_is_out_of_reach() {
    let server = server(Propagation::Walls);
    let robot = |name: &str, place: &str| -> Peer {
        let mut peer = server.client();
        peer.send(&format!("INIT {{ClassName USARBot.P3AT}} {{Name {name}}} {{Location {place}}}"));
        peer.ground_truth();
        peer
    };
    let (_a, b) = (robot("A", "0,0,0"), robot("B", "2,2,0"));
    let Joined { mut client, ends: [mut end, _other] } = Joined::new(&server);
    let strength = client.ask("GETSS A B;", 1);
    assert!(strength.starts_with("OK:-5"), "{strength}");
    drop(b);
    assert_eq!(end.read(&mut [0; 8]).expect("an end"), 0);
    let port = client.0.local_addr().expect("an address").port();
    assert_eq!(client.ask(&format!("LISTEN B {port};OPEN A 1 B {port};"), 2), "OK;Fail: Cannot connect to B;");
}

#[test]
fn nobody_speaks_for_the_robots_of_another_address() {
    let server = server(Propagation::Everywhere);
    let mut client = Client::connect(&server);
    assert_eq!(client.ask("REGISTER A 127.0.0.1;LISTEN A 5000;", 2), "OK;OK;");
    // Another address of this machine, as of another client.
    let stranger = tokio::runtime::Builder::new_current_thread().enable_all().build().expect("a runtime");
    let stranger = stranger.block_on(async {
        let socket = tokio::net::TcpSocket::new_v4().expect("a socket");
        socket.bind(SocketAddr::from(([127, 0, 0, 2], 0))).expect("an address");
        socket.connect(server.com_server.expect("a port")).await.and_then(tokio::net::TcpStream::into_std)
    });
    let stranger = stranger.expect("a connection");
    stranger.set_nonblocking(false).and_then(|()| stranger.set_read_timeout(Some(PATIENCE))).expect("a timeout");
    let mut stranger = Client(stranger);
    for command in ["LISTEN A 22;", "OPEN A 22 A 5000;", "GETSS A A;"] {
        assert_eq!(stranger.ask(command, 1), "Fail: Server does not accept third party requests;", "{command}");
    }
}

#[test]
fn a_robot_that_does_not_read_or_listen_ends_its_own_connection_alone() {
    let server = server(Propagation::Everywhere);
    let mut bystander = server.bystander();
    let Joined { mut client, ends: [mut a, b] } = Joined::new(&server);
    a.set_write_timeout(Some(std::time::Duration::from_millis(300))).expect("a timeout");
    a.write_all(b"SEND 1000000000 ").expect("sent");
    while a.write(&[0; 65536]).is_ok_and(|count| count > 0) {}
    assert_eq!(
        client.ask("REGISTER C 127.0.0.1;LISTEN C 1;OPEN A 1 C 1;", 3),
        "OK;OK;Fail: Could not establish connection;"
    );
    bystander.check_undisturbed();
    drop(b);
}
