//! A blocking client of a Gamebots server: it connects, sends lines and returns the server's lines one by one.
//!
//! [`Client`] is all there is. The crate `gamebots-proto` turns lines into typed messages and back, and has the frame and the units: x
//! forward, y right, z down, metres, radians, seconds. The example `drive` drives a robot to a place.
//!
//! # Example
//! A listener stands in for the server, which greets and waits for a robot's class.
//!
//! ```
//! use std::io::{BufRead, BufReader, Write};
//! use std::net::TcpListener;
//! use std::time::Duration;
//!
//! use gamebots_client::Client;
//! use gamebots_proto::Message;
//! use gamebots_proto::message::Nfo;
//!
//! let listener = TcpListener::bind("127.0.0.1:0")?;
//! let address = listener.local_addr()?;
//! let server = std::thread::spawn(move || {
//!     let (mut stream, _) = listener.accept()?;
//!     stream.write_all(b"NFO {Gametype BotDeathMatch} {Level hall} {TimeLimit 20}\r\n")?;
//!     BufReader::new(stream).lines().next().unwrap_or_else(|| Ok(String::new()))
//! });
//!
//! let mut client = Client::connect(address)?;
//! let line = client.next_line(Duration::from_secs(10))?.unwrap_or_default();
//! let Some(Message::Nfo(Nfo::Greeting(greeting))) = Message::read(&line) else { panic!("no greeting: {line}") };
//! assert_eq!(greeting.level, "hall");
//!
//! client.send("INIT {ClassName USARBot.P3AT} {Start PlayerStart_0}")?;
//! let received = server.join().map_err(|_| std::io::Error::other("the server panicked"))??;
//! assert_eq!(received, "INIT {ClassName USARBot.P3AT} {Start PlayerStart_0}");
//! # Ok::<(), std::io::Error>(())
//! ```

use std::collections::VecDeque;
use std::io::{ErrorKind, Read, Write};
use std::net::{Shutdown, TcpStream, ToSocketAddrs};
use std::time::{Duration, Instant};

use gamebots_proto::{Framing, Problem};

/// A connection to a server.
#[derive(Debug)]
pub struct Client {
    stream: TcpStream,
    framing: Framing,
    lines: VecDeque<Result<String, Problem>>,
}

impl Client {
    /// Connects. The greeting is the first line that comes.
    ///
    /// # Errors
    /// When the operating system reports an error.
    pub fn connect(address: impl ToSocketAddrs) -> std::io::Result<Self> {
        let stream = TcpStream::connect(address)?;
        stream.set_nodelay(true)?;
        Ok(Self { stream, framing: Framing::of_answers(), lines: VecDeque::new() })
    }

    /// Sends a line and ends it with CR LF.
    ///
    /// # Errors
    /// When the operating system reports an error.
    pub fn send(&mut self, line: &str) -> std::io::Result<()> {
        self.send_bytes(format!("{line}\r\n").as_bytes())
    }

    /// Sends bytes as they are.
    ///
    /// # Errors
    /// When the operating system reports an error.
    pub fn send_bytes(&mut self, bytes: &[u8]) -> std::io::Result<()> {
        self.stream.write_all(bytes)
    }

    /// Ends the sending side; later lines of the server can still be read.
    ///
    /// # Errors
    /// When the operating system reports an error.
    pub fn finish(&mut self) -> std::io::Result<()> {
        self.stream.shutdown(Shutdown::Write)
    }

    /// Returns the next line, without its end; `None` if no line came in time.
    ///
    /// # Errors
    /// [`ErrorKind::UnexpectedEof`] if the server has closed the connection, [`ErrorKind::InvalidData`] in place of a line of more than
    /// [`MAX_ANSWER_BYTES`](gamebots_proto::framing::MAX_ANSWER_BYTES), after which the next lines can be read; otherwise the operating
    /// system's error.
    pub fn next_line(&mut self, patience: Duration) -> std::io::Result<Option<String>> {
        let end = Instant::now() + patience;
        let mut buffer = [0; 16 * 1024];
        loop {
            if let Some(line) = self.lines.pop_front() {
                return line.map(Some).map_err(|problem| std::io::Error::new(ErrorKind::InvalidData, problem));
            }
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Ok(None);
            }
            self.stream.set_read_timeout(Some(left))?;
            match self.stream.read(&mut buffer) {
                Ok(0) => return Err(ErrorKind::UnexpectedEof.into()),
                Ok(count) => self.lines.extend(self.framing.push(&buffer[..count])),
                Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => return Ok(None),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
    }
}

/// The examples of the README, as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
