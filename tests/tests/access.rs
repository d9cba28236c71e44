//! Tokens: every entrance of a server that has some, and what each role may do there.

use std::io::{ErrorKind, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::path::Path;

use gamebots_proto::Dialect;
use gamebots_server::{Listener, Playback, Service};
use recorder::Record;
use serde_json::Value;
use system_tests::{PATIENCE, Peer, Server};
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket};

const WRONG: &str = "wrong-0123456789abcdef";
const VIEWER: &str = "viewer-0123456789abcdef";
const DRIVER: &str = "driver-0123456789abcdef";
const REFEREE: &str = "referee-0123456789abcdef";

/// Returns a file of tokens with one for each role, and one of a team.
fn file() -> String {
    let token =
        |token: &str, role: &str, team: &str| format!("[[token]]\ntoken = \"{token}\"\nroles = [\"{role}\"]\n{team}");
    [token(VIEWER, "viewer", ""), token(DRIVER, "driver", "team = \"red\"\n"), token(REFEREE, "referee", "")].concat()
}

fn server(log: Option<&Path>) -> Server {
    Server::start("hall", &[], |config| {
        config.tokens = Some(file().parse().expect("good tokens"));
        config.log = log.map(Path::to_owned);
        config.report_errors = true;
        config.ros2 = Some(ros2::Options { rosbridge: true, ..ros2::Options::default() });
        let ut2004 = Service::Controllers { dialect: Some(Dialect::Ut2004) };
        let services = [Service::Page, Service::Foxglove, Service::Truth, Service::Positions, Service::Images];
        config
            .listeners
            .extend([ut2004, Service::Wireless, Service::ComServer].map(|service| Listener::new(service, 0)));
        config.listeners.extend(services.map(|service| Listener::new(service, 0)));
    })
}

/// A way into a server.
#[derive(Debug, Clone, Copy)]
enum Entrance {
    /// A port, with a question that it answers.
    Port(&'static str, &'static [u8]),
    Get(&'static str),
    PostScene,
    Live,
    Wire,
    Rosbridge,
    Foxglove,
}

use Entrance::{Foxglove, Get, Live, Port, PostScene, Rosbridge, Wire};

impl Entrance {
    /// True if a client with a token gets an answer.
    fn lets_in(self, server: &Server, token: Option<&str>) -> bool {
        let login = token.map(|token| format!("LOGIN {{Token {token}}}\r\n")).unwrap_or_default();
        match self {
            Port(name, question) => {
                let mut stream = connect(address(server, name));
                let _ = stream.write_all(login.as_bytes());
                // The server may have closed.
                let _ = stream.write_all(question);
                let answer = answer(&mut stream);
                !answer.is_empty() && !answer.starts_with("NFO {Error LOGIN refused: ")
            }
            Get(path) => status(server, &format!("GET {path}"), token) != 401,
            PostScene => status(server, "POST /scene.json", token) != 401,
            Live => {
                let mut socket = open(server, "/live");
                let first = token.map_or("{}".to_owned(), |token| format!("{{\"token\":\"{token}\"}}"));
                socket.send(Message::text(first)).expect("sent");
                matches!(socket.read(), Ok(Message::Text(text)) if text.contains("\"you\""))
            }
            Wire => {
                let mut socket = open(server, "/wire");
                socket.send(Message::text(if login.is_empty() { "GETCLASSES\r\n" } else { &login })).expect("sent");
                let Ok(Message::Binary(bytes)) = socket.read() else { return false };
                bytes.starts_with(b"NFO {Gametype")
            }
            Rosbridge => {
                let query = token.map(|token| format!("?token={token}")).unwrap_or_default();
                tungstenite::connect(format!("ws://{}/rosbridge{query}", address(server, "page"))).is_ok()
            }
            Foxglove => {
                let mut stream = connect(address(server, "foxglove"));
                let query = token.map(|token| format!("?token={token}")).unwrap_or_default();
                let head = format!(
                    "GET /{query} HTTP/1.1\r\nHost: localhost\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\
                     Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\
                     Sec-WebSocket-Protocol: foxglove.sdk.v1\r\n\r\n"
                );
                stream.write_all(head.as_bytes()).expect("sent");
                answer(&mut stream).starts_with("HTTP/1.1 101")
            }
        }
    }
}

fn address(server: &Server, name: &str) -> SocketAddr {
    let found = match name {
        "controllers" => Some(server.address),
        "truth" => server.truth,
        "positions" => server.positions,
        "images" => server.images,
        "wireless" => server.wireless,
        "relay" => server.com_server,
        "page" => server.page,
        _ => server.foxglove.map(|port| SocketAddr::new(server.address.ip(), port)),
    };
    found.unwrap_or_else(|| panic!("no port {name}"))
}

fn connect(address: SocketAddr) -> TcpStream {
    let stream = TcpStream::connect(address).unwrap_or_else(|error| panic!("{error}"));
    stream.set_read_timeout(Some(PATIENCE)).expect("a timeout");
    stream
}

/// Returns the first bytes that come; empty if the server closes instead.
fn answer(stream: &mut TcpStream) -> String {
    let mut bytes = [0; 4096];
    match stream.read(&mut bytes) {
        Ok(count) => String::from_utf8_lossy(&bytes[..count]).into_owned(),
        Err(error) if error.kind() == ErrorKind::ConnectionReset => String::new(),
        Err(error) => panic!("neither an answer nor an end: {error}"),
    }
}

fn status(server: &Server, request: &str, token: Option<&str>) -> u16 {
    let mut stream = connect(address(server, "page"));
    let token = token.map(|token| format!("Authorization: Bearer {token}\r\n")).unwrap_or_default();
    let head =
        format!("{request} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nContent-Length: 0\r\n{token}\r\n");
    stream.write_all(head.as_bytes()).expect("sent");
    let answer = answer(&mut stream);
    answer.split(' ').nth(1).and_then(|status| status.parse().ok()).unwrap_or_else(|| panic!("{request}: {answer}"))
}

fn open(server: &Server, path: &str) -> WebSocket<MaybeTlsStream<TcpStream>> {
    let (socket, _) =
        tungstenite::connect(format!("ws://{}{path}", address(server, "page"))).unwrap_or_else(|it| panic!("{it}"));
    socket
}

/// A controller that has logged in.
fn controller(server: &Server, token: &str) -> Peer {
    let mut peer = Peer::connect(server.address).expect("a connection");
    peer.send(&format!("LOGIN {{Token {token}}}"));
    assert!(peer.line().starts_with("NFO {Gametype"));
    peer
}

/// The table of docs/howto-access.md.
#[test]
fn every_entrance_is_closed_without_the_right_token() {
    let server = server(None);
    let mut robot = controller(&server, DRIVER);
    robot.send("INIT {ClassName USARBot.P3AT} {Name Rover} {Location 0,0,0}");
    robot.ground_truth();
    // Those who get in: without a token, with a wrong one, viewer, driver, referee.
    let rows: [(Entrance, [bool; 5]); 21] = [
        (Port("controllers", b"GETSTARTPOSES\r\n"), [false, false, false, true, true]),
        (Port("truth", b"\r\n"), [false, false, true, false, false]),
        (Port("positions", b"GETPOS\r\n"), [false, false, true, false, false]),
        (Port("images", b"OK"), [false, false, true, true, false]),
        (Port("wireless", b"INIT {Robot Rover} {Port 4000}\r\n"), [false, false, false, true, false]),
        (Port("relay", b"REGISTER R 127.0.0.1;"), [false, false, false, true, false]),
        (Get("/scene.json"), [false, false, true, false, false]),
        (Get("/class/P3AT"), [false, false, true, false, false]),
        (Get("/objects.json"), [false, false, true, false, false]),
        (Get("/past"), [false, false, true, false, false]),
        (Get("/map/hall/picture.png"), [false, false, true, false, false]),
        (Get("/league.json"), [false, false, true, false, false]),
        (PostScene, [false, false, true, false, false]),
        (Get("/metrics"), [false, false, true, false, false]),
        (Get("/"), [true; 5]),
        (Get("/index.html"), [true; 5]),
        (Get("/health"), [true; 5]),
        (Live, [false, false, true, false, false]),
        (Wire, [false, false, false, true, true]),
        (Rosbridge, [false, false, false, true, true]),
        (Foxglove, [false, false, true, false, false]),
    ];
    let tokens = [None, Some(WRONG), Some(VIEWER), Some(DRIVER), Some(REFEREE)];
    for (entrance, expected) in rows {
        let got = tokens.map(|token| entrance.lets_in(&server, token));
        assert_eq!(got, expected, "{entrance:?} for no token, a wrong one, viewer, driver, referee");
    }
    robot.nothing();
}

#[test]
fn a_second_controllers_port_asks_for_a_token_too() {
    let tokens = file().parse().expect("good tokens");
    let server = Server::start("hall", &[], |config| {
        config.tokens = Some(tokens);
        config.listeners = vec![Listener::new(Service::Controllers { dialect: Some(Dialect::Ut2004) }, 0)];
    });
    for (token, expected) in [(None, false), (Some(VIEWER), false), (Some(DRIVER), true)] {
        assert_eq!(Port("controllers", b"GETSTARTPOSES\r\n").lets_in(&server, token), expected, "{token:?}");
    }
}

#[test]
fn whoever_says_nothing_or_no_line_is_turned_away() {
    let server = server(None);
    let long = [b"LOGIN {Token ".as_slice(), &[b'x'; 5000]].concat();
    let bytes: [&[u8]; 4] = [b"GET / HTTP/1.1\r\nHost: x\r\n\r\n", &long, b"\xff\xfe\n", b"LOGIN {Token }\n"];
    for first in bytes {
        for name in ["controllers", "truth", "positions", "images", "wireless", "relay"] {
            let mut stream = connect(address(&server, name));
            let _ = stream.write_all(first);
            let text = answer(&mut stream);
            let is_refused = text.is_empty() || text.starts_with("NFO {Error LOGIN refused: ");
            assert!(is_refused, "{name}: {text}");
        }
    }
    let mut silent = connect(server.address);
    assert!(answer(&mut silent).contains("LOGIN refused: there is no token"));
}

#[test]
fn a_token_is_in_no_log_and_its_teams_robots_replay_without_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("run.mcap");
    let server = server(Some(&path));
    let mut robot = controller(&server, DRIVER);
    robot.send(&format!("LOGIN {{Token {DRIVER}}}"));
    robot.send("INIT {ClassName USARBot.P3AT} {Name Rover} {Location 0,0,0}");
    robot.send("DRIVE {Left 1}{Right 1}");
    (0..5).for_each(|_| _ = robot.ground_truth());
    robot.send("INIT {ClassName USARBotAPI.WorldController} {Name Boss}");
    let refusal = robot.wait_for("a refusal", |line| line.starts_with("NFO {Error"));
    assert!(refusal.contains("only a token with the role referee controls this world"), "{refusal}");
    robot.send("INIT {ClassName USARBot.P3AT} {Team blue} {Location 3,0,0}");
    let refusal = robot.wait_for("a refusal", |line| line.starts_with("NFO {Error"));
    assert!(refusal.contains("expected red, the team of the connection's token"), "{refusal}");
    let mut referee = controller(&server, REFEREE);
    referee.send("INIT {ClassName USARBot.P3AT} {Location 3,0,0}");
    let refusal = referee.wait_for("a refusal", |line| line.starts_with("NFO {Error"));
    assert!(refusal.contains("has not the role driver"), "{refusal}");
    referee.send("INIT {ClassName USARBotAPI.WorldController} {Name Boss}");
    referee.send("CONTROL {Type RelMove} {Name Rover} {Location 1,0,0}");
    referee.send("GETSTARTPOSES");
    referee.wait_for("the end of its lines", |line| line.starts_with("NFO {StartPoses"));
    drop((robot, referee));
    server.stop().expect("a good end");
    let log = recorder::read(&path).expect("a log");
    let text = format!("{log:?}");
    assert!(text.contains("INIT {Team red} {ClassName USARBot.P3AT} {Name Rover}"));
    for token in [VIEWER, DRIVER, REFEREE] {
        assert!(!text.contains(token), "the log has {token}");
    }
    let lines = |word: &str| {
        let has = |record: &Record| matches!(record, Record::In(line) if line.line.contains(word));
        log.entries.iter().filter(|entry| has(&entry.record)).count()
    };
    assert_eq!([lines("LOGIN"), lines("Rover"), lines("Boss"), lines("blue")], [0, 2, 1, 0]);
    assert!(logbook::replay(&log).expect("a replay").is_same());
}

/// A page that has logged in.
struct Page(WebSocket<MaybeTlsStream<TcpStream>>);

impl Page {
    fn open(server: &Server, token: &str) -> Self {
        let mut page = Self(open(server, "/live"));
        page.send(&format!("{{\"token\":\"{token}\"}}"));
        page
    }

    fn send(&mut self, text: &str) {
        self.0.send(Message::text(text)).unwrap_or_else(|error| panic!("{text}: {error}"));
    }

    /// Returns the first message that fits.
    fn wait<T>(&mut self, what: &str, fits: impl Fn(&Value) -> Option<T>) -> T {
        for _ in 0..10_000 {
            let Message::Text(text) = self.0.read().expect("a message") else { continue };
            if let Some(found) = serde_json::from_str(&text).ok().and_then(|message| fits(&message)) {
                return found;
            }
        }
        panic!("never came: {what}");
    }
}

#[test]
fn a_viewer_watches_and_does_nothing_else() {
    let both = "both-0123456789abcdef";
    let tokens = format!("{}[[token]]\ntoken = \"{both}\"\nroles = [\"viewer\", \"referee\"]\n", file());
    let folder = tempfile::tempdir().expect("a folder");
    let server = Server::start("hall", &[], |config| {
        config.tokens = Some(tokens.parse().expect("good tokens"));
        config.listeners.push(Listener::new(Service::Page, 0));
        config.unnamed_log = folder.path().join("page.mcap");
    });
    let mut viewer = Page::open(&server, VIEWER);
    for control in [
        "{\"pause\":true}",
        "{\"step\":1}",
        "{\"speed\":2}",
        "\"reset\"",
        "{\"record\":true}",
        "\"save\"",
        "{\"remove\":1}",
        "{\"map\":\"arena\"}",
    ] {
        viewer.send(control);
        let said = viewer.wait("a refusal", |message| message["said"].as_str().map(str::to_owned));
        assert_eq!(said, "not done: only a token with the role referee controls this world", "{control}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 0);
    let mut referee = Page::open(&server, both);
    referee.send("{\"pause\":true}");
    let said = viewer.wait("a pause", |message| message["said"].as_str().map(str::to_owned));
    assert!(said.ends_with("paused the world"), "{said}");
}

#[test]
fn a_played_log_asks_for_the_token_of_a_viewer() {
    let (stop, stopped) = tokio::sync::oneshot::channel::<()>();
    let (ready, address) = std::sync::mpsc::channel();
    let playback = Playback {
        host: "127.0.0.1".to_owned(),
        port: 0,
        real_time_factor: 0.0,
        lines: vec![(0.0, "STA {Type GroundVehicle}".to_owned())],
        tokens: Some(file().parse().expect("good tokens")),
    };
    let thread = std::thread::spawn(move || {
        let shutdown = async { drop(stopped.await) };
        gamebots_server::play(playback, |address| ready.send(address).expect("sent"), shutdown)
    });
    let address = address.recv_timeout(PATIENCE).expect("an address");
    for (token, expected) in [(None, ""), (Some(WRONG), ""), (Some(DRIVER), ""), (Some(VIEWER), "STA")] {
        let mut stream = connect(address);
        let login = token.map_or("GETCLASSES\r\n".to_owned(), |token| format!("LOGIN {{Token {token}}}\r\n"));
        stream.write_all(login.as_bytes()).expect("sent");
        let answer = answer(&mut stream);
        assert_eq!(answer.is_empty(), expected.is_empty(), "{token:?}: {answer}");
        assert!(answer.starts_with(expected), "{token:?}: {answer}");
    }
    drop(stop);
    thread.join().expect("no panic").expect("a good end");
}

#[test]
fn silent_strangers_take_nobodys_place() {
    let server = Server::start("hall", &[], |config| {
        config.tokens = Some(file().parse().expect("good tokens"));
        config.max_connections = 1;
        config.listeners.push(Listener::new(Service::Truth, 0));
    });
    let mut robot = controller(&server, DRIVER);
    robot.send("INIT {ClassName USARBot.P3AT} {Location 0,0,0}");
    // More than may wait at a door: those who came first are dropped.
    let mut strangers: Vec<TcpStream> = Vec::new();
    for _ in 0..300 {
        strangers.extend([address(&server, "controllers"), address(&server, "truth")].map(connect));
    }
    robot.check_undisturbed();
    let mut second = controller(&server, DRIVER);
    second.send("GETSTARTPOSES");
    second.wait_for("an answer", |line| line.starts_with("NFO {StartPoses"));
    let mut truth = connect(address(&server, "truth"));
    truth.write_all(format!("LOGIN {{Token {VIEWER}}}\r\n\r\n").as_bytes()).expect("sent");
    assert!(answer(&mut truth).starts_with("{Name P3AT_0}"));
    let mut first = strangers.swap_remove(0);
    assert_eq!(answer(&mut first), "", "the first stranger is dropped");
}
