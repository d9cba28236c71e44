//! A blocking Gamebots client on `gamebots-proto`.
//!
//! ```no_run
//! use std::time::Duration;
//!
//! let mut client = gamebots_client::Client::connect("127.0.0.1:3000")?;
//! client.send("INIT {ClassName USARBot.KUKA_YouBot} {Start PlayerStart_0}")?;
//! client.send("DRIVE {Left 1.0} {Right 1.0}")?;
//! while let Some(line) = client.next_line(Duration::from_secs(1))? {
//!     println!("{line}");
//! }
//! # Ok::<(), std::io::Error>(())
//! ```

use std::collections::VecDeque;
use std::io::{ErrorKind, Read, Write};
use std::net::{Shutdown, TcpStream, ToSocketAddrs};
use std::time::{Duration, Instant};

use gamebots_proto::Framing;

/// A connection to a server.
pub struct Client {
    stream: TcpStream,
    framing: Framing,
    lines: VecDeque<String>,
}

impl Client {
    /// Connects. The greeting is the first line that comes.
    ///
    /// # Errors
    /// When the operating system reports an error.
    pub fn connect(address: impl ToSocketAddrs) -> std::io::Result<Self> {
        let stream = TcpStream::connect(address)?;
        stream.set_nodelay(true)?;
        Ok(Self { stream, framing: Framing::default(), lines: VecDeque::new() })
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
    /// [`ErrorKind::UnexpectedEof`] if the server has closed the connection; otherwise the operating system's error.
    pub fn next_line(&mut self, patience: Duration) -> std::io::Result<Option<String>> {
        let end = Instant::now() + patience;
        let mut buffer = [0; 16 * 1024];
        loop {
            if let Some(line) = self.lines.pop_front() {
                return Ok(Some(line));
            }
            let left = end.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return Ok(None);
            }
            self.stream.set_read_timeout(Some(left))?;
            match self.stream.read(&mut buffer) {
                Ok(0) => return Err(ErrorKind::UnexpectedEof.into()),
                Ok(count) => self.lines.extend(self.framing.push(&buffer[..count]).into_iter().flatten()),
                Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => return Ok(None),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
    }
}
