//! The protocol for browsers, which cannot open a TCP connection. Each WebSocket becomes one client of the protocol's own port,
//! with the same rights and limits as every other. Bytes pass through unchanged.

use std::sync::Arc;
use std::time::Duration;

use axum::Extension;
use axum::extract::State;
use axum::extract::ws::{CloseFrame, Message, WebSocket, WebSocketUpgrade};
use axum::response::Response;
use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt, StreamExt};
use gamebots_proto::ports::read_login;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::net::tcp::{ReadHalf, WriteHalf};
use tokio::time::timeout;

use crate::access::tokens::Role;
use crate::page::shared::{Site, Visit};

/// Longest message from a browser.
const MAX_MESSAGE: usize = 64 * 1024;
/// WebSocket close code: the server is unavailable now, try again later.
const TRY_LATER: u16 = 1013;

pub(crate) async fn upgrade(
    State(site): State<Arc<Site>>,
    Extension(visit): Extension<Arc<Visit>>,
    socket: WebSocketUpgrade,
) -> Response {
    socket.max_message_size(MAX_MESSAGE).on_upgrade(|socket| async move {
        tokio::select! {
            () = bridge(socket, &site, &visit) => {}
            () = visit.dropped() => {}
        }
    })
}

async fn bridge(mut socket: WebSocket, site: &Site, visit: &Visit) {
    let mut stream = match TcpStream::connect(site.protocol).await {
        Ok(stream) => stream,
        Err(error) => {
            let reason = format!("port {}: {error}", site.protocol.port());
            let _ = socket.send(Message::Close(Some(CloseFrame { code: TRY_LATER, reason: reason.into() }))).await;
            return;
        }
    };
    let (read, write) = stream.split();
    let (to_browser, from_browser) = socket.split();
    // Each direction continues while the other waits: a server may take no more input until its output is read.
    tokio::select! {
        () = to_server(from_browser, write, site, visit) => {}
        () = to_page(read, to_browser, site.stall_timeout) => {}
    }
}

/// Passes on what a browser sends. A page that sends a driver's token first has a place from then on.
async fn to_server(mut browser: SplitStream<WebSocket>, mut write: WriteHalf<'_>, site: &Site, visit: &Visit) {
    let mut is_first = true;
    while let Some(Ok(message)) = browser.next().await {
        let bytes = match message {
            Message::Text(text) => text.into(),
            Message::Binary(bytes) => bytes,
            Message::Ping(_) | Message::Pong(_) => continue,
            Message::Close(_) => return,
        };
        if std::mem::take(&mut is_first) && may_drive(&bytes, site) && !visit.admit() {
            return;
        }
        if !matches!(timeout(site.stall_timeout, write.write_all(&bytes)).await, Ok(Ok(()))) {
            return;
        }
    }
}

/// True if a message begins with a LOGIN line whose token may drive.
fn may_drive(message: &[u8], site: &Site) -> bool {
    let line = String::from_utf8_lossy(message);
    let token = line.lines().next().and_then(read_login);
    site.access.rights(token.as_deref(), &[Role::Driver, Role::Referee]).is_ok()
}

async fn to_page(mut read: ReadHalf<'_>, mut browser: SplitSink<WebSocket, Message>, stall_timeout: Duration) {
    let mut buffer = vec![0; 16 * 1024];
    while let Ok(count @ 1..) = read.read(&mut buffer).await {
        // Binary, because a piece may end within a character.
        let bytes = Message::Binary(buffer.iter().take(count).copied().collect::<Vec<u8>>().into());
        if !matches!(timeout(stall_timeout, browser.send(bytes)).await, Ok(Ok(()))) {
            return;
        }
    }
    let _ = browser.send(Message::Close(None)).await;
}
