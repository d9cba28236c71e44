//! One client: bytes in, events to the world; lines out of its outbox.

use std::sync::Arc;
use std::time::Duration;

use gamebots_proto::{Framing, Problem};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::net::tcp::{OwnedReadHalf, OwnedWriteHalf};
use tokio::sync::mpsc::Sender;
use tracing::{info, warn};

use crate::control::Control;
use crate::outbox::Outbox;

/// Bytes read at once: bounds what one event can hold.
const READ_BYTES: usize = 16 * 1024;

/// A fragment that ends with a whole block counts as a line when nothing has followed it for this long: one known
/// controller never ends its lines (tamsl/swe-thaf).
const UNENDED_LINE: Duration = Duration::from_millis(500);

/// Number of a connection, from 1.
pub(crate) type ConnectionId = u64;

/// Everything that a connection tells the world.
pub(crate) enum Event {
    /// A client is here, from this address.
    Opened(ConnectionId, String, Arc<Outbox>),
    /// The lines of one segment, together: what a client sends in one piece is handled before time goes on.
    Lines(ConnectionId, Vec<Result<String, Problem>>),
    /// It is gone.
    Closed(ConnectionId),
    /// Somebody who watches wishes something of the world.
    Control(Control),
}

/// Serves a client until it leaves, or is thrown out because it takes nothing.
pub(crate) async fn serve(id: ConnectionId, stream: TcpStream, events: Sender<Event>, stall_timeout: Duration) {
    if let Err(error) = stream.set_nodelay(true) {
        warn!(connection = id, %error, "cannot turn off delayed sending");
    }
    let peer = stream.peer_addr().map_or_else(|_| "unknown".to_owned(), |peer| peer.to_string());
    let (read, write) = stream.into_split();
    let outbox = Arc::new(Outbox::default());
    if events.send(Event::Opened(id, peer, outbox.clone())).await.is_err() {
        return;
    }
    let writer = write_lines(write, &outbox, stall_timeout);
    tokio::pin!(writer);
    let reader = read_lines(id, read, &outbox, &events);
    let (reason, may_still_write) = tokio::select! {
        reason = reader => (reason, true),
        reason = &mut writer => (reason, false),
    };
    // The world closes the outbox when it has seen this, so that the last answers are still sent.
    let told = events.send(Event::Closed(id)).await.is_ok();
    if told && may_still_write {
        writer.await;
    }
    info!(connection = id, reason, "client disconnected");
}

/// Reads until the client ends the stream; its last fragment counts as a line.
async fn read_lines(
    id: ConnectionId,
    mut read: OwnedReadHalf,
    outbox: &Outbox,
    events: &Sender<Event>,
) -> &'static str {
    let mut framing = Framing::default();
    let mut buffer = vec![0; READ_BYTES];
    loop {
        outbox.ready_for_answers().await;
        let read = read.read(&mut buffer);
        let result = if framing.ends_with_block() {
            tokio::time::timeout(UNENDED_LINE, read).await.ok()
        } else {
            Some(read.await)
        };
        let (lines, end) = match result {
            Some(Ok(count)) if count > 0 => (framing.push(&buffer[..count]), None),
            Some(Ok(_)) => (framing.finish().into_iter().collect(), Some("closed by the client")),
            Some(Err(_)) => (framing.finish().into_iter().collect(), Some("reset by the client")),
            None => (framing.finish().into_iter().collect(), None),
        };
        if !lines.is_empty() && events.send(Event::Lines(id, lines)).await.is_err() {
            return "the server stops";
        }
        if let Some(end) = end {
            return end;
        }
    }
}

async fn write_lines(mut write: OwnedWriteHalf, outbox: &Outbox, stall_timeout: Duration) -> &'static str {
    while let Some(text) = outbox.take().await {
        let mut rest = text.as_bytes();
        while !rest.is_empty() {
            match tokio::time::timeout(stall_timeout, write.write(rest)).await {
                Ok(Ok(count)) if count > 0 => rest = &rest[count..],
                Ok(_) => return "reset by the client",
                Err(_) => return "thrown out: it takes nothing",
            }
        }
    }
    "all sent"
}
