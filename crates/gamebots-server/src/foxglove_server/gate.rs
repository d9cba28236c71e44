//! Foxglove's own server lets every page of every site in, and any number of clients: this stands before it.
//!
//! The server listens on an address of this machine that no page can guess; here the head of each request is read first, and
//! only then do bytes pass through as they are.

use std::hash::{BuildHasher, RandomState};
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::sync::Arc;
use std::time::Duration;

use axum::http::uri::Uri;
use axum::http::{HeaderMap, HeaderName, HeaderValue};
use tokio::io::{AsyncReadExt, AsyncWriteExt, copy_bidirectional};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::Semaphore;
use tokio::time::timeout;
use tokio_io_timeout::TimeoutStream;
use tracing::{debug, warn};

use crate::web;

/// Clients at once; more wait.
const MAX_CLIENTS: usize = 64;
/// Longest head of a request, bytes, and most headers in it.
const MAX_HEAD: usize = 16 * 1024;
const MAX_HEADERS: usize = 64;
/// Longest time for the head of a request.
const HEAD_TIMEOUT: Duration = Duration::from_secs(10);
/// A client that takes nothing for this long is disconnected.
const STALL_TIMEOUT: Duration = Duration::from_secs(30);
/// Pause after an error of accept, which otherwise comes back at once.
const BACK_OFF: Duration = Duration::from_millis(100);
/// Where Foxglove's own page is.
const FOXGLOVE_PAGE: &str = "https://app.foxglove.dev";

/// An address of this machine for the server behind: on Linux all of 127.0.0.0/8 is, and a page that tries ports finds it
/// no sooner than it counts to 2^40.
pub(super) fn hidden_address() -> Ipv4Addr {
    if cfg!(target_os = "linux") {
        let [a, b, c, ..] = RandomState::new().hash_one(0).to_le_bytes();
        // Neither the network's own address nor its broadcast.
        return Ipv4Addr::new(127, a, b, c.clamp(1, 254));
    }
    Ipv4Addr::LOCALHOST
}

/// Lets clients through to the server behind until the runtime ends.
pub(super) async fn serve(listener: TcpListener, own_name: String, behind: SocketAddr) {
    let places = Arc::new(Semaphore::new(MAX_CLIENTS));
    let own_name: Arc<str> = own_name.into();
    // The semaphore is never closed.
    while let Ok(place) = places.clone().acquire_owned().await {
        match listener.accept().await {
            Ok((client, peer)) => {
                let own_name = own_name.clone();
                tokio::spawn(async move {
                    if let Err(reason) = pass(client, &own_name, behind).await {
                        debug!(%peer, reason, "a client of Foxglove's protocol ended");
                    }
                    drop(place);
                });
            }
            Err(error) => {
                warn!(%error, "cannot accept a client of Foxglove's protocol");
                tokio::time::sleep(BACK_OFF).await;
            }
        }
    }
}

async fn pass(mut client: TcpStream, own_name: &str, behind: SocketAddr) -> Result<(), String> {
    let head = timeout(HEAD_TIMEOUT, read_head(&mut client)).await.map_err(|_| "no request within 10 s")??;
    if let Err(reason) = headers(&head).and_then(|headers| web::check(&headers, own_name, is_welcome)) {
        let answer = format!(
            "HTTP/1.1 403 Forbidden\r\nContent-Type: text/plain\r\nContent-Length: {}\r\nConnection: close\r\n\r\n{reason}",
            reason.len()
        );
        let _ = timeout(HEAD_TIMEOUT, client.write_all(answer.as_bytes())).await;
        return Err(reason);
    }
    let said = |error: std::io::Error| error.to_string();
    client.set_nodelay(true).map_err(said)?;
    let mut server = TcpStream::connect(behind).await.map_err(said)?;
    server.set_nodelay(true).map_err(said)?;
    server.write_all(&head).await.map_err(said)?;
    let mut client = TimeoutStream::new(client);
    client.set_write_timeout(Some(STALL_TIMEOUT));
    copy_bidirectional(&mut Box::pin(client), &mut server).await.map(|_| ()).map_err(said)
}

/// Everything up to the end of the head, and what came with it.
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

fn headers(head: &[u8]) -> Result<HeaderMap, String> {
    let mut parsed = [httparse::EMPTY_HEADER; MAX_HEADERS];
    let mut request = httparse::Request::new(&mut parsed);
    request.parse(head).map_err(|error| format!("not an HTTP request: {error}\n"))?;
    let mut headers = HeaderMap::new();
    for header in request.headers {
        let name = HeaderName::from_bytes(header.name.as_bytes()).map_err(|error| format!("{error}\n"))?;
        headers.append(name, HeaderValue::from_bytes(header.value).map_err(|error| format!("{error}\n"))?);
    }
    Ok(headers)
}

/// Foxglove's own page, a page that this machine serves (as Lichtblick does), and programs that are no page of a site.
fn is_welcome(origin: &str) -> bool {
    if origin == FOXGLOVE_PAGE {
        return true;
    }
    let Ok(uri) = origin.parse::<Uri>() else { return false };
    let host = uri.host().unwrap_or_default().trim_matches(['[', ']']);
    match uri.scheme_str() {
        Some("http" | "https") => host == "localhost" || host.parse::<IpAddr>().is_ok_and(|ip| ip.is_loopback()),
        // `null` is a page that hides where it is from.
        scheme => scheme.is_some(),
    }
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
