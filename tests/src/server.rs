//! A server in this process, and clients that talk to it over a real socket.

use std::net::SocketAddr;
use std::path::Path;
use std::sync::mpsc::channel;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use gamebots_client::Client;
use gamebots_proto::message::is_periodic_line;
use gamebots_proto::{Dialect, Line};
use gamebots_server::{Config, Entrance, Listener, ServeError, Service};
use tokio::sync::oneshot;

/// Longest wait of a test for an expected event.
pub const PATIENCE: Duration = Duration::from_secs(30);

/// A running server. It stops on drop.
pub struct Server {
    /// Address of the controllers' port.
    pub address: SocketAddr,
    /// Address of the page.
    pub page: Option<SocketAddr>,
    /// Address of the port of truth.
    pub truth: Option<SocketAddr>,
    /// Address of the port of positions.
    pub positions: Option<SocketAddr>,
    /// Address of the radio between robots.
    pub wireless: Option<SocketAddr>,
    /// Address of the old relay between robots.
    pub com_server: Option<SocketAddr>,
    /// Address of the image server's port.
    pub images: Option<SocketAddr>,
    /// Port for Foxglove.
    pub foxglove: Option<u16>,
    /// The way of programs in this process.
    pub entrance: Entrance,
    stop: Option<oneshot::Sender<()>>,
    thread: Option<JoinHandle<Result<(), ServeError>>>,
}

impl Server {
    /// Starts a server on a free port, with a built-in map and additional robots. `change` edits its configuration.
    ///
    /// # Panics
    /// If it does not start.
    pub fn start(map: &str, robots: &[&Path], change: impl FnOnce(&mut Config)) -> Self {
        let world = scene_loader::load(map, robots).unwrap_or_else(|error| panic!("{error}"));
        let listeners = vec![Listener::new(Service::Controllers { dialect: None }, 0)];
        let mut config = Config { listeners, ..Config::new(world) };
        change(&mut config);
        let (stop, stopped) = oneshot::channel::<()>();
        let (ready, addresses) = channel();
        let run = move || {
            let shutdown = async {
                // Dropping the sender stops the server, too.
                let _ = stopped.await;
            };
            gamebots_server::run(
                config,
                |addresses| assert!(ready.send(addresses).is_ok(), "nobody waits for the server"),
                shutdown,
            )
        };
        let thread = std::thread::spawn(run);
        let addresses = addresses.recv_timeout(PATIENCE).unwrap_or_else(|_| panic!("the server does not start"));
        let address = addresses.controllers().unwrap_or_else(|| panic!("no port for controllers"));
        let of = |service| addresses.of(service);
        Self {
            address,
            page: of(Service::Page),
            truth: of(Service::Truth),
            positions: of(Service::Positions),
            wireless: of(Service::Wireless),
            com_server: of(Service::ComServer),
            images: of(Service::Images),
            foxglove: of(Service::Foxglove).map(|address| address.port()),
            entrance: addresses.entrance.clone(),
            stop: Some(stop),
            thread: Some(thread),
        }
    }

    /// Connects a client and reads its greeting.
    ///
    /// # Panics
    /// If there is no greeting.
    pub fn client(&self) -> Peer {
        let mut peer = Peer::connect(self.address).unwrap_or_else(|error| panic!("cannot connect: {error}"));
        let greeting = peer.line();
        assert!(greeting.starts_with("NFO {Gametype BotDeathMatch} {Level "), "greeting: {greeting}");
        peer
    }

    /// Connects to a port beside the controllers'.
    ///
    /// # Panics
    /// If nothing listens there.
    pub fn beside(&self, address: Option<SocketAddr>) -> Peer {
        let address = address.unwrap_or_else(|| panic!("the server has no such port"));
        Peer::connect(address).unwrap_or_else(|error| panic!("cannot connect: {error}"))
    }

    /// Connects a client with a robot that other clients must not disturb.
    ///
    /// # Panics
    /// If no ground truth comes.
    pub fn bystander(&self) -> Peer {
        let mut peer = self.client();
        peer.send("INIT {ClassName USARBot.P3AT} {Name Bystander} {Location 10,10,0}");
        peer.ground_truth();
        peer
    }

    /// Stops the server and returns its result.
    ///
    /// # Panics
    /// If the server panicked.
    pub fn stop(mut self) -> Result<(), ServeError> {
        self.stop = None;
        let thread = self.thread.take().unwrap_or_else(|| panic!("stopped twice"));
        thread.join().unwrap_or_else(|_| panic!("the server panicked"))
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.stop = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

/// A client that fails the test if an expected line does not come.
pub struct Peer {
    client: Client,
    /// Dialect of the lines that it expects.
    pub dialect: Dialect,
}

impl Peer {
    /// Checks that a bystander's readings come at their rate, and nothing else.
    ///
    /// # Panics
    /// If they do not.
    pub fn check_undisturbed(&mut self) {
        let lines = self.lines_for(1.0);
        let truths = lines.iter().filter(|line| line.contains("{Type GroundTruth}")).count();
        assert!((9..=11).contains(&truths), "{truths} ground truths in a second");
        self.nothing();
    }

    /// Connects without reading the greeting.
    ///
    /// # Errors
    /// The operating system's error if the connection fails.
    pub fn connect(address: SocketAddr) -> std::io::Result<Self> {
        Ok(Self { client: Client::connect(address)?, dialect: Dialect::Udk })
    }

    /// Sends a line.
    ///
    /// # Panics
    /// If the connection is gone.
    pub fn send(&mut self, line: &str) {
        self.client.send(line).unwrap_or_else(|error| panic!("sending {line}: {error}"));
    }

    /// Sends bytes.
    ///
    /// # Panics
    /// If the connection is gone.
    pub fn send_bytes(&mut self, bytes: &[u8]) {
        self.client.send_bytes(bytes).unwrap_or_else(|error| panic!("sending: {error}"));
    }

    /// Closes the sending side.
    ///
    /// # Panics
    /// If the connection is gone.
    pub fn finish(&mut self) {
        self.client.finish().unwrap_or_else(|error| panic!("ending: {error}"));
    }

    /// Returns the next line of any kind. Checks that a session in UDK's dialect gets no lines that only older versions sent.
    ///
    /// # Panics
    /// If no line comes.
    pub fn line(&mut self) -> String {
        let line = self.client.next_line(PATIENCE);
        let line = line.unwrap_or_else(|error| panic!("reading: {error}")).unwrap_or_else(|| panic!("no line comes"));
        let older = ["RES", "MISSTA", "DIE"].iter().any(|verb| line.starts_with(verb));
        assert!(self.dialect == Dialect::Ut2004 || !older, "{line}");
        line
    }

    /// Returns the next line, or `None` if the server closes the connection.
    pub fn line_or_end(&mut self) -> Option<String> {
        self.client.next_line(PATIENCE).ok().flatten()
    }

    /// Returns all lines until a deadline, or until the server closes the connection.
    pub fn lines_until(&mut self, end: Instant) -> Vec<String> {
        let next = || self.client.next_line(end.saturating_duration_since(Instant::now())).ok().flatten();
        std::iter::from_fn(next).collect()
    }

    /// Returns the next line that is not on a timer.
    pub fn reply(&mut self) -> String {
        std::iter::repeat_with(|| self.line()).find(|line| !is_periodic_line(line)).unwrap_or_default()
    }

    /// Checks that earlier lines got no answer: the answer to a question asked now comes next.
    ///
    /// # Panics
    /// If there was an answer.
    pub fn nothing(&mut self) {
        self.send("GETSTARTPOSES");
        let reply = self.reply();
        assert!(reply.starts_with("NFO {StartPoses "), "expected no answer, got: {reply}");
    }

    /// Returns the first line that fits, within half a minute.
    ///
    /// # Panics
    /// If none comes.
    pub fn wait_for(&mut self, what: &str, fits: impl Fn(&str) -> bool) -> String {
        let end = Instant::now() + PATIENCE;
        let mut last = String::new();
        while Instant::now() < end {
            last = self.line();
            if fits(&last) {
                return last;
            }
        }
        panic!("never came: {what}; last line: {last}");
    }

    /// Returns the next reading of a type, or for `STA`, `ASTA`, `MISSTA` and `EFF` the next line of that kind.
    pub fn next_of(&mut self, kind: &str) -> String {
        let head = format!("{{Type {kind}}}");
        let fits = |line: &str| {
            let verb = line.split(' ').next().unwrap_or_default();
            if ["STA", "ASTA", "MISSTA", "EFF"].contains(&kind) {
                verb == kind
            } else {
                verb == "SEN" && line.contains(&head)
            }
        };
        self.wait_for(kind, fits)
    }

    /// Reads lines for a span of simulated time, by the times in the lines, and returns them.
    pub fn lines_for(&mut self, seconds: f64) -> Vec<String> {
        let mut lines = Vec::new();
        let mut start = None;
        loop {
            let line = self.line();
            if let Some(time) = time_of(&line)
                && time >= *start.get_or_insert(time) + seconds
            {
                return lines;
            }
            lines.push(line);
        }
    }

    /// Returns the next ground truth: position, and roll, pitch, yaw.
    ///
    /// # Panics
    /// If it cannot be read.
    pub fn ground_truth(&mut self) -> ([f64; 3], [f64; 3]) {
        let line = self.next_of("GroundTruth");
        let parsed = Line::parse(&line);
        let vector = |key: &str| -> [f64; 3] {
            let numbers: Vec<f64> =
                parsed.get(key).unwrap_or_default().split(',').filter_map(|number| number.parse().ok()).collect();
            numbers.try_into().unwrap_or_else(|_| panic!("no {key} in {line}"))
        };
        (vector("Location"), vector("Orientation"))
    }
}

/// Returns the simulated time in a line.
pub fn time_of(line: &str) -> Option<f64> {
    line.split_once("{Time ")?.1.split('}').next()?.parse().ok()
}
