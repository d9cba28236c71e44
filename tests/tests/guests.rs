//! Guests, who ask for something without driving a robot: pages, and clients of the ports beside the controllers'. However many they are
//! and however often they ask, drivers and the server's end do not wait for them.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use gamebots_server::{Listener, Service};
use system_tests::{PATIENCE, Peer, Server, wait_until};
use tungstenite::Message;

/// Guests of each kind.
const GUESTS: usize = 64;
/// Ground truths that the bystander must get in [`PATIENCE`]: three simulated seconds.
const TRUTHS: usize = 30;

/// Guests that ask without pause until they are dropped.
struct Asking {
    stop: Arc<AtomicBool>,
    answers: Arc<AtomicUsize>,
    threads: Vec<JoinHandle<()>>,
}

impl Asking {
    /// Starts guests. `ask` asks once, waits for the answer, and returns false when the server is gone.
    fn start<G: Send + 'static>(connect: impl Fn() -> G, ask: fn(&mut G) -> bool) -> Self {
        let (stop, answers) = (Arc::<AtomicBool>::default(), Arc::<AtomicUsize>::default());
        let guest = |_| {
            let (mut guest, stop, answers) = (connect(), stop.clone(), answers.clone());
            std::thread::spawn(move || {
                while !stop.load(Ordering::Relaxed) && ask(&mut guest) {
                    answers.fetch_add(1, Ordering::Relaxed);
                }
            })
        };
        let threads = (0..GUESTS).map(guest).collect();
        Self { stop, answers, threads }
    }

    fn answers(&self) -> usize {
        self.answers.load(Ordering::Relaxed)
    }
}

impl Drop for Asking {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        self.threads.drain(..).for_each(|thread| _ = thread.join());
    }
}

/// Starts a server with robots at one place, and everything that guests use.
fn server(robots: usize) -> (Server, Peer, Peer) {
    let server = Server::start("hall", &[], |config| {
        let services = [Service::Page, Service::Truth, Service::Positions];
        config.listeners.extend(services.map(|service| Listener::new(service, 0)));
        config.maps = vec![scene_loader::map("arena", &[]).unwrap_or_else(|error| panic!("{error}")).into()].into();
    });
    let bystander = server.bystander();
    let mut owner = server.client();
    let inits = (0..robots).map(|number| {
        let name = format!("F{number}");
        format!("INIT {{ClassName USARBot.P3AT}} {{Name {name}}} {{Location 0,0,0}}\r\n")
    });
    owner.send_bytes(inits.collect::<String>().as_bytes());
    let mut positions = server.beside(server.positions);
    wait_until(|| {
        positions.send("GETPOS");
        positions.line().starts_with(&format!("POSITIONS {{Robots {}}}", robots + 1))
    });
    (server, bystander, owner)
}

fn connect(address: Option<SocketAddr>) -> TcpStream {
    let stream = TcpStream::connect(address.expect("a port")).expect("a connection");
    stream.set_read_timeout(Some(Duration::from_secs(1))).expect("a timeout");
    stream
}

/// Sends a question and waits for the end of the answer.
fn ask(stream: &mut TcpStream, question: &str, end: &str) -> bool {
    let (mut answer, mut buffer) = (Vec::new(), [0; 4096]);
    let mut sent = stream.write_all(question.as_bytes()).is_ok();
    while sent && !answer.ends_with(end.as_bytes()) {
        match stream.read(&mut buffer) {
            Ok(count @ 1..) => answer.extend(&buffer[..count]),
            Ok(_) => sent = false,
            // The answer may take long: guests wait for their turn.
            Err(error) => return error.kind() == std::io::ErrorKind::WouldBlock,
        }
    }
    sent
}

type Page = tungstenite::WebSocket<tungstenite::stream::MaybeTlsStream<TcpStream>>;

fn open(page: Option<SocketAddr>) -> Page {
    let (mut socket, _) = tungstenite::connect(format!("ws://{}/live", page.expect("a page"))).expect("a page");
    if let tungstenite::stream::MaybeTlsStream::Plain(stream) = socket.get_mut() {
        stream.set_read_timeout(Some(Duration::from_secs(1))).expect("a timeout");
    }
    socket
}

/// Sends a page's request and waits for a text that contains a part, or for a second.
fn request(page: &mut Page, text: &str, part: &str) -> bool {
    let end = Instant::now() + Duration::from_secs(1);
    if page.send(Message::text(text)).is_err() {
        return false;
    }
    while Instant::now() < end {
        match page.read() {
            Ok(Message::Text(text)) if text.contains(part) => return true,
            Ok(_) => {}
            Err(tungstenite::Error::Io(error)) if error.kind() == std::io::ErrorKind::WouldBlock => {}
            Err(_) => return false,
        }
    }
    true
}

/// Checks that a robot's readings go on while guests ask, and that guests get answers.
fn check(what: &str, server: &Server, bystander: &mut Peer, asking: &Asking) {
    let (start, before) = (Instant::now(), asking.answers());
    for number in 0..TRUTHS {
        bystander.next_of("GroundTruth");
        assert!(start.elapsed() < PATIENCE, "{what}: {number} ground truths in {PATIENCE:?}");
    }
    wait_until(|| asking.answers() > before);
    // It is greeted.
    server.client();
}

#[test]
fn questions_of_many_guests_do_not_stop_the_world() {
    type Question = fn(&mut TcpStream) -> bool;
    let (server, mut bystander, _owner) = server(30);
    let positions = server.positions;
    let rows: [(&str, Option<SocketAddr>, Question); 3] = [
        ("obstacles", positions, |stream| ask(stream, "GETOBS {From F1} {To F20}\r\n", "\r\n")),
        ("positions", positions, |stream| ask(stream, "GETPOS\r\n", "\r\n")),
        ("truth", server.truth, |stream| ask(stream, "{class}\r\n", "{End}\r\n")),
    ];
    for (what, address, question) in rows {
        let asking = Asking::start(|| connect(address), question);
        check(what, &server, &mut bystander, &asking);
    }
}

#[test]
fn pages_that_ask_for_room_do_not_stop_the_world() {
    let (server, mut bystander, _owner) = server(30);
    let fit =
        |page: &mut Page| request(page, r#"{"fit":{"class":"TeleMax","location":[0,0,-0.2],"yaw":0.3}}"#, r#"{"fit":"#);
    let asking = Asking::start(|| open(server.page), fit);
    check("room", &server, &mut bystander, &asking);
}

#[test]
fn pages_that_want_their_numbers_back_do_not_stop_the_world() {
    let (server, mut bystander, _owner) = server(30);
    let echo = |page: &mut Page| request(page, r#"{"echo":7}"#, r#"{"echo":7}"#);
    let asking = Asking::start(|| open(server.page), echo);
    check("echoes", &server, &mut bystander, &asking);
}

#[test]
fn resets_that_wait_become_one_and_the_server_ends_before_them() {
    for text in [r#""reset""#, r#"{"map":"arena"}"#] {
        let (server, mut bystander, _owner) = server(20);
        let mut pages: Vec<Page> = (0..GUESTS).map(|_| open(server.page)).collect();
        let mut send = || pages.iter_mut().for_each(|page| page.send(Message::text(text)).expect("a page"));
        send();
        for _ in 0..TRUTHS {
            bystander.next_of("GroundTruth");
        }
        let resets = |status: &str| {
            status.contains(r#""resets":"#).then(|| {
                let rest = status.split_once(r#""resets":"#).map_or("", |(_, rest)| rest);
                rest.split([',', '}']).next().and_then(|number| number.parse::<u64>().ok()).unwrap_or_default()
            })
        };
        let mut watching = open(server.page);
        let count = std::iter::repeat_with(|| watching.read()).find_map(|read| match read {
            Ok(Message::Text(text)) => resets(&text),
            _ => None,
        });
        assert!((1..=10).contains(&count.unwrap_or_default()), "{text}: {count:?} restarts for {GUESTS} requests");
        send();
        let stopping = Instant::now();
        server.stop().expect("a server");
        assert!(stopping.elapsed() < PATIENCE / 2, "{text}: the end took {:?}", stopping.elapsed());
    }
}

/// A controller asks for the states of its objects without pause, 180 KiB a time. Time runs as fast as it can, so a step is always due.
#[test]
fn long_answers_to_a_driver_do_not_stop_the_world() {
    let server = Server::start("hall", &[], |config| config.real_time_factor = 0.0);
    let mut bystander = server.bystander();
    let mut controller = TcpStream::connect(server.address).expect("a connection");
    let mut orders = "INIT {ClassName USARBotAPI.WorldController} {Name Orders}\r\n".to_owned();
    let memory = "m".repeat(250);
    for number in 0..500 {
        let place = format!("{{Location {},{},-9}}", number % 20, number / 20);
        orders +=
            &format!("CONTROL {{Type Create}} {{ClassName WCCrate}} {{Name {number}}} {{Memory {memory}}} {place}\r\n");
    }
    controller.write_all(orders.as_bytes()).expect("a connection");
    let mut answers = controller.try_clone().expect("a stream");
    let (start, mut truths) = (Instant::now(), 0);
    std::thread::scope(|scope| {
        scope.spawn(|| while (&controller).write_all(&b"CONTROL {Type GetSTA}\r\n".repeat(16)).is_ok() {});
        answers.read_exact(&mut vec![0; 1_000_000]).expect("answers");
        scope.spawn(|| std::io::copy(&mut answers, &mut std::io::sink()));
        // Readings from before are skipped.
        bystander.nothing();
        while truths < TRUTHS && start.elapsed() < PATIENCE {
            bystander.next_of("GroundTruth");
            truths += 1;
        }
        controller.shutdown(std::net::Shutdown::Both).expect("a connection");
    });
    assert_eq!(truths, TRUTHS, "in {PATIENCE:?}");
    server.client();
}
