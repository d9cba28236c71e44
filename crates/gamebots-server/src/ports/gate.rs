//! A gate before Foxglove's own server, which admits every page of every site and any number of clients.
//!
//! That server listens on an address of this machine that no page can guess. The gate reads the head of each request first.
//! Only then does it pass bytes through unchanged, after a
//! pass that makes that server send messages.

use std::hash::{BuildHasher, RandomState};
use std::net::{Ipv4Addr, SocketAddr};
use std::sync::Arc;
use std::time::Duration;

use axum::http::{HeaderMap, HeaderName, HeaderValue};
use recorder::Admitted;
use tokio::io::{AsyncReadExt, AsyncWriteExt, copy_bidirectional};
use tokio::net::TcpStream;
use tokio::sync::Semaphore;
use tokio::time::timeout;
use tokio_io_timeout::TimeoutStream;
use tracing::debug;

use crate::access::login::Door;
use crate::access::origin;
use crate::access::pass::Pass;
use crate::access::rights::Access;
use crate::access::tokens::Role;
use crate::access::waiting_room::{Stay, Visitor};

/// Longest head of a request, bytes, and most headers in it.
const MAX_HEAD: usize = 16 * 1024;
const MAX_HEADERS: usize = 64;
/// Longest time for the head of a request.
const HEAD_TIMEOUT: Duration = Duration::from_secs(10);
/// Time after which a client that reads nothing is disconnected.
const STALL_TIMEOUT: Duration = Duration::from_secs(30);
/// Origin of Foxglove's own page.
const FOXGLOVE_PAGE: &str = "https://app.foxglove.dev";

/// Returns a random address of this machine for the server behind the gate. On Linux all of 127.0.0.0/8 is this machine: with
/// the port, a page would have to try 2^40 combinations.
pub(crate) fn hidden_address() -> Ipv4Addr {
    if cfg!(target_os = "linux") {
        let [a, b, c, ..] = RandomState::new().hash_one(0).to_le_bytes();
        // Skips the network's own address and its broadcast address.
        return Ipv4Addr::new(127, a, b, c.clamp(1, 254));
    }
    Ipv4Addr::LOCALHOST
}

/// A gate and the server behind it.
pub(crate) struct Gate {
    /// Host name that the server was told to listen on.
    own_name: String,
    door: Door,
    /// Address of the server behind.
    behind: SocketAddr,
    pass: Pass,
    admitted: Admitted,
    /// Places for clients.
    places: Semaphore,
}

impl Gate {
    /// Creates a gate for so many clients at once.
    pub(crate) fn new(
        own_name: &str,
        most: usize,
        door: Door,
        behind: SocketAddr,
        pass: Pass,
        admitted: Admitted,
    ) -> Self {
        Self { own_name: own_name.to_owned(), door, behind, pass, admitted, places: Semaphore::new(most) }
    }

    /// Passes a client on to the server behind, if it may come in, until it leaves.
    pub(crate) async fn serve(self: Arc<Self>, Visitor { stream, peer, stay }: Visitor) {
        if let Err(reason) = self.admit(stream, stay).await {
            debug!(%peer, reason, "a client of Foxglove's protocol ended");
        }
    }

    /// Passes a client on once its head has shown that it may come in.
    async fn admit(&self, mut client: TcpStream, stay: Stay) -> Result<(), String> {
        let head = tokio::select! {
            head = timeout(HEAD_TIMEOUT, read_head(&mut client)) => head.map_err(|_| "no request within 10 s")??,
            () = stay.dropped() => return Err("dropped for another connection".to_owned()),
        };
        let (status, reason) = match (check(&head, &self.own_name, &self.door.access), self.places.try_acquire()) {
            (Ok(()), Ok(_place)) => {
                drop(stay);
                let (number, pass) = self.pass.frame();
                let result = relay(client, &head, self.behind, &pass).await;
                self.admitted.forget(number);
                return result.map_err(|error| error.to_string());
            }
            (Err(reason), _) => ("403 Forbidden", reason),
            (Ok(()), Err(_)) => {
                ("503 Service Unavailable", "too many clients are connected: try again later\n".to_owned())
            }
        };
        let length = reason.len();
        let head = format!("HTTP/1.1 {status}\r\nContent-Type: text/plain\r\nContent-Length: {length}");
        let answer = format!("{head}\r\nConnection: close\r\n\r\n{reason}");
        let _ = timeout(HEAD_TIMEOUT, client.write_all(answer.as_bytes())).await;
        Err(reason)
    }
}

/// Relays a connection to the server behind. If that accepts it, it gets the pass before anything else.
async fn relay(mut client: TcpStream, head: &[u8], behind: SocketAddr, pass: &[u8]) -> std::io::Result<()> {
    client.set_nodelay(true)?;
    let mut server = TcpStream::connect(behind).await?;
    server.set_nodelay(true)?;
    server.write_all(head).await?;
    let answer = read_head(&mut server).await.map_err(std::io::Error::other)?;
    if answer.starts_with(b"HTTP/1.1 101 ") {
        server.write_all(pass).await?;
    }
    client.write_all(&answer).await?;
    let mut client = TimeoutStream::new(client);
    client.set_write_timeout(Some(STALL_TIMEOUT));
    copy_bidirectional(&mut Box::pin(client), &mut server).await.map(|_| ())
}

/// Reads up to the end of the head. The result may include bytes after it.
async fn read_head(client: &mut TcpStream) -> Result<Vec<u8>, String> {
    let mut head = Vec::new();
    while !head.windows(4).any(|end| end == b"\r\n\r\n") {
        if head.len() > MAX_HEAD {
            return Err(format!("the head of a request is over {MAX_HEAD} bytes"));
        }
        let mut buffer = [0; 4096];
        let count = client.read(&mut buffer).await.map_err(|error| error.to_string())?;
        if count == 0 {
            return Err("closed within the head of a request".to_owned());
        }
        head.extend(buffer.iter().take(count));
    }
    Ok(head)
}

/// Checks the head of a request. With tokens, that of a viewer is in the address, as in `ws://host:8765/?token=..`, or in a header.
fn check(head: &[u8], own_name: &str, access: &Access) -> Result<(), String> {
    let mut parsed = [httparse::EMPTY_HEADER; MAX_HEADERS];
    let mut request = httparse::Request::new(&mut parsed);
    request.parse(head).map_err(|error| format!("not an HTTP request: {error}\n"))?;
    let mut headers = HeaderMap::new();
    for header in request.headers.iter() {
        let name = HeaderName::from_bytes(header.name.as_bytes()).map_err(|error| format!("{error}\n"))?;
        headers.append(name, HeaderValue::from_bytes(header.value).map_err(|error| format!("{error}\n"))?);
    }
    origin::check(&headers, own_name, is_welcome)?;
    let token = origin::token(request.path.unwrap_or_default(), &headers);
    let refused = |refusal| format!("{refusal}: expected ?token=.. in the address, of the role viewer\n");
    access.rights(token, &[Role::Viewer]).map(|_| ()).map_err(refused)
}

/// True for Foxglove's own page, and what runs on this machine.
fn is_welcome(origin: &str) -> bool {
    origin == FOXGLOVE_PAGE || origin::is_local(origin)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_of_strangers_are_not_welcome() {
        for (origin, expected) in [
            ("https://app.foxglove.dev", true),
            ("http://localhost:8080", true),
            ("http://127.0.0.1", true),
            ("http://[::1]:8080", true),
            ("app://lichtblick", true),
            ("https://evil.example", false),
            ("http://127.0.0.1:8765.evil.example", false),
            ("http://user@127.0.0.1", false),
            ("https://app.foxglove.dev.evil.example", false),
            ("http://localhost.evil.example", false),
            ("http://192.168.1.7", false),
            ("null", false),
            ("", false),
        ] {
            assert_eq!(is_welcome(origin), expected, "{origin}");
        }
    }
}
