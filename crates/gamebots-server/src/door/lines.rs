//! Lines of the ports: bytes become requests, and answers become bytes.

use std::time::Duration;

use gamebots_proto::ports::{ComFraming, PictureRequest, PictureRequests};
use gamebots_proto::{Framing, Problem};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::net::tcp::{OwnedReadHalf, OwnedWriteHalf};
use tokio::time::timeout;

/// Bytes read at once.
const READ_BYTES: usize = 16 * 1024;
/// First bytes of a connection that are checked for a method of HTTP: the longest method and a space.
const FIRST_BYTES: usize = 8;
/// Wait after which a fragment that ends with a whole block counts as a line: one known controller never ends its lines
/// (tamsl/swe-thaf).
const UNENDED_LINE: Duration = Duration::from_millis(500);

/// The division of a port's bytes into requests.
pub(crate) trait Requests {
    /// A request.
    type Request;

    /// Takes the next bytes and returns the requests that they complete.
    fn push(&mut self, bytes: &[u8]) -> Vec<Self::Request>;

    /// True if the bytes since the last request may be a whole one that lacks its end.
    fn may_be_whole(&self) -> bool {
        false
    }

    /// Returns the bytes since the last request as a request, if there are any.
    fn finish(&mut self) -> Option<Self::Request> {
        None
    }
}

impl Requests for Framing {
    type Request = Result<String, Problem>;

    fn push(&mut self, bytes: &[u8]) -> Vec<Self::Request> {
        self.push(bytes)
    }

    fn may_be_whole(&self) -> bool {
        self.ends_with_block()
    }

    fn finish(&mut self) -> Option<Self::Request> {
        self.finish()
    }
}

impl Requests for ComFraming {
    type Request = String;

    fn push(&mut self, bytes: &[u8]) -> Vec<String> {
        self.push(bytes)
    }
}

impl Requests for PictureRequests {
    type Request = PictureRequest;

    fn push(&mut self, bytes: &[u8]) -> Vec<PictureRequest> {
        bytes.iter().filter_map(|&byte| self.push(byte)).collect()
    }
}

/// The end of a client's requests.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum End {
    Closed,
    Reset,
    /// The client speaks HTTP. Any web page can make a browser send a request here, and its body would be read line by line.
    Http,
}

/// Reader of a client's requests.
pub(crate) struct Reader<R, D> {
    read: R,
    requests: D,
    buffer: Vec<u8>,
    first_bytes: FirstBytes,
}

impl<R: AsyncRead + Unpin, D: Requests> Reader<R, D> {
    pub(crate) fn new(read: R, requests: D) -> Self {
        Self { read, requests, buffer: vec![0; READ_BYTES], first_bytes: FirstBytes::default() }
    }

    /// Reads the next requests, perhaps none, and the end if there is one. The last fragment counts as a request.
    pub(crate) async fn next(&mut self) -> (Vec<D::Request>, Option<End>) {
        let Self { read, requests, buffer, first_bytes } = self;
        let reading = read.read(buffer);
        let read =
            if requests.may_be_whole() { timeout(UNENDED_LINE, reading).await.ok() } else { Some(reading.await) };
        let end = match read {
            Some(Ok(count @ 1..)) => {
                let bytes = buffer.get(..count).unwrap_or_default();
                first_bytes.add(bytes);
                let got = requests.push(bytes);
                return if first_bytes.are_http() { (Vec::new(), Some(End::Http)) } else { (got, None) };
            }
            Some(Ok(_)) => Some(End::Closed),
            Some(Err(_)) => Some(End::Reset),
            None => None,
        };
        (requests.finish().into_iter().collect(), end)
    }
}

/// A conversation with a client that gets an answer to each request.
pub(crate) struct Conversation<D> {
    reader: Reader<OwnedReadHalf, D>,
    write: OwnedWriteHalf,
    /// Time after which a client that reads nothing is left.
    stall_timeout: Duration,
    is_over: bool,
}

impl<D: Requests> Conversation<D> {
    pub(crate) fn new(stream: TcpStream, requests: D, stall_timeout: Duration) -> Self {
        // An answer must not wait for the next one (Nagle's algorithm).
        let _ = stream.set_nodelay(true);
        let (read, write) = stream.into_split();
        Self { reader: Reader::new(read, requests), write, stall_timeout, is_over: false }
    }

    /// Returns the next requests, perhaps none. `None` if the client has left or speaks HTTP.
    pub(crate) async fn next(&mut self) -> Option<Vec<D::Request>> {
        if self.is_over {
            return None;
        }
        let (requests, end) = self.reader.next().await;
        self.is_over = end.is_some();
        (end != Some(End::Http)).then_some(requests)
    }

    /// Sends an answer. Returns false if the client has left or does not take it in time.
    pub(crate) async fn send(&mut self, answer: &[u8]) -> bool {
        matches!(timeout(self.stall_timeout, self.write.write_all(answer)).await, Ok(Ok(())))
    }
}

/// The first bytes of a connection.
#[derive(Default)]
struct FirstBytes(Vec<u8>);

impl FirstBytes {
    /// Adds the next bytes of the connection.
    fn add(&mut self, bytes: &[u8]) {
        self.0.extend(bytes.iter().take(FIRST_BYTES - self.0.len()));
    }

    /// True if the connection begins with an HTTP request. No verb of the protocol is a method of HTTP, and the first bytes show it however
    /// long the line gets.
    fn are_http(&self) -> bool {
        const METHODS: [&[u8]; 9] =
            [b"GET ", b"POST ", b"HEAD ", b"PUT ", b"DELETE ", b"OPTIONS ", b"PATCH ", b"CONNECT ", b"TRACE "];
        METHODS.iter().any(|method| self.0.starts_with(method))
    }
}
