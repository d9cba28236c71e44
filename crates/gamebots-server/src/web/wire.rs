//! The protocol for browsers, which cannot open a TCP connection: each WebSocket becomes one client of the protocol's own
//! port, with the same rights and limits as every other. Bytes pass through as they are.

use std::sync::Arc;

use axum::extract::State;
use axum::extract::ws::{CloseFrame, Message, WebSocket, WebSocketUpgrade};
use axum::response::Response;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::time::timeout;

use super::Site;

/// Longest message from a browser.
const MAX_MESSAGE: usize = 64 * 1024;
/// Code of a WebSocket's end that says that the server cannot do it now.
const TRY_LATER: u16 = 1013;

pub(super) async fn upgrade(State(site): State<Arc<Site>>, socket: WebSocketUpgrade) -> Response {
    socket.max_message_size(MAX_MESSAGE).on_upgrade(|socket| async move { bridge(socket, &site).await })
}

async fn bridge(mut socket: WebSocket, site: &Site) {
    let mut stream = match TcpStream::connect(site.protocol).await {
        Ok(stream) => stream,
        Err(error) => {
            let reason = format!("port {}: {error}", site.protocol.port());
            let _ = socket.send(Message::Close(Some(CloseFrame { code: TRY_LATER, reason: reason.into() }))).await;
            return;
        }
    };
    let (mut read, mut write) = stream.split();
    let mut buffer = vec![0; 16 * 1024];
    loop {
        tokio::select! {
            received = socket.recv() => {
                let bytes = match received {
                    Some(Ok(Message::Text(text))) => text.into(),
                    Some(Ok(Message::Binary(bytes))) => bytes,
                    Some(Ok(Message::Ping(_) | Message::Pong(_))) => continue,
                    Some(Ok(Message::Close(_)) | Err(_)) | None => return,
                };
                if !matches!(timeout(site.stall_timeout, write.write_all(&bytes)).await, Ok(Ok(()))) {
                    return;
                }
            }
            count = read.read(&mut buffer) => {
                let Some(bytes) = count.ok().filter(|&count| count > 0).map(|count| buffer[..count].to_vec()) else {
                    let _ = socket.send(Message::Close(None)).await;
                    return;
                };
                // Binary: a piece may end within a character.
                if !matches!(timeout(site.stall_timeout, socket.send(Message::Binary(bytes.into()))).await, Ok(Ok(()))) {
                    return;
                }
            }
        }
    }
}
