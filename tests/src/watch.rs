//! A viewer of the page's WebSocket that keeps the newest status.

use std::net::{SocketAddr, TcpStream};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use serde_json::Value;
use tungstenite::Message;
use tungstenite::stream::MaybeTlsStream;

use crate::server::PATIENCE;

/// A viewer that watches until the server ends or it is dropped.
pub struct Watch {
    newest: Arc<Mutex<Seen>>,
    socket: TcpStream,
    thread: Option<JoinHandle<()>>,
}

/// Data that a viewer received.
#[derive(Debug, Clone, Default)]
pub struct Seen {
    /// Number of frames and scans.
    pub frames: u64,
    /// Dropped sensor lines of the clients that are connected, by the newest status.
    pub dropped: u64,
    /// Most dropped sensor lines in any status.
    pub most_dropped: u64,
    /// Bytes that wait to be sent to clients, by the newest status.
    pub waiting_bytes: u64,
    /// Most robots in any status.
    pub most_robots: usize,
    /// The newest status.
    pub status: Value,
    /// Number of wire lines that were checked.
    pub lines: u64,
    /// Lines with an infinite or NaN number or a place outside the map, up to a maximum.
    pub absurd: Vec<String>,
}

/// Most absurd lines that are kept.
const MAX_ABSURD: usize = 10;
/// Largest coordinate of a robot within the map, m.
const MAP_END: f64 = 1e5 + 10.0;

/// True for a line of the server with an infinite or NaN number, or with a place outside the map.
fn is_absurd(line: &str) -> bool {
    let place = line.split_once("{Location ").and_then(|(_, rest)| rest.split('}').next()).unwrap_or_default();
    let is_far = |number: &str| number.parse::<f64>().is_ok_and(|number| number.abs() > MAP_END);
    let words = line.split(|letter: char| !letter.is_alphanumeric());
    place.split(',').any(is_far) || words.into_iter().any(|word| word == "NaN" || word == "inf")
}

impl Seen {
    fn take(&mut self, message: &Message) {
        let Message::Text(text) = message else {
            self.frames += 1;
            return;
        };
        let Ok(message) = serde_json::from_str::<Value>(text) else { return };
        if let Some(line) = message["line"]["text"].as_str().filter(|_| message["line"]["direction"] == "out") {
            self.lines += 1;
            if is_absurd(line) && self.absurd.len() < MAX_ABSURD {
                self.absurd.push(line.to_owned());
            }
        }
        let Some(status) = message.get("status").cloned() else { return };
        let clients = status["clients"].as_array().map_or(&[][..], Vec::as_slice);
        let sum = |key: &str| clients.iter().filter_map(|client| client[key].as_u64()).sum();
        (self.dropped, self.waiting_bytes) = (sum("dropped"), sum("waiting_bytes"));
        self.most_dropped = self.most_dropped.max(self.dropped);
        self.status = status;
        self.most_robots = self.most_robots.max(self.robots());
    }

    /// Returns the number of robots.
    pub fn robots(&self) -> usize {
        self.status["robots"].as_array().map_or(0, Vec::len)
    }

    /// Returns the number of connected clients.
    pub fn clients(&self) -> usize {
        self.status["clients"].as_array().map_or(0, Vec::len)
    }
}

impl Watch {
    /// Starts to watch a page.
    ///
    /// # Panics
    /// If the server refuses the viewer.
    pub fn start(page: SocketAddr) -> Self {
        Self::start_with(page, None)
    }

    /// Starts to watch a page and every line of the wire.
    ///
    /// # Panics
    /// If the server refuses the viewer.
    pub fn start_with_lines(page: SocketAddr) -> Self {
        Self::start_with(page, Some(r#"{"wire":true}"#))
    }

    fn start_with(page: SocketAddr, request: Option<&'static str>) -> Self {
        let (mut viewer, _) =
            tungstenite::connect(format!("ws://{page}/live")).unwrap_or_else(|error| panic!("{error}"));
        if let Some(request) = request {
            viewer.send(Message::text(request)).unwrap_or_else(|error| panic!("{error}"));
        }
        let MaybeTlsStream::Plain(socket) = viewer.get_ref() else { panic!("not a plain socket") };
        let socket = socket.try_clone().unwrap_or_else(|error| panic!("{error}"));
        let newest = Arc::new(Mutex::new(Seen::default()));
        let shared = newest.clone();
        let thread = std::thread::spawn(move || {
            while let Ok(message) = viewer.read() {
                shared.lock().unwrap_or_else(PoisonError::into_inner).take(&message);
            }
        });
        Self { newest, socket, thread: Some(thread) }
    }

    /// Returns the data received so far.
    pub fn seen(&self) -> Seen {
        self.newest.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Waits until a status fits.
    ///
    /// # Panics
    /// If none does within half a minute.
    pub fn wait_for(&self, what: &str, fits: impl Fn(&Seen) -> bool) {
        let end = Instant::now() + PATIENCE;
        loop {
            let seen = self.seen();
            if fits(&seen) {
                return;
            }
            assert!(Instant::now() < end, "never seen: {what}; newest status: {}", seen.status);
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

impl Drop for Watch {
    fn drop(&mut self) {
        let _ = self.socket.shutdown(std::net::Shutdown::Both);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
