//! The door of a port: connections wait there until they have logged in. They take no place of those who have.

use std::collections::VecDeque;
use std::net::SocketAddr;
use std::time::Duration;

use gamebots_proto::Dialect;
use gamebots_proto::message::{Message, Nfo};
use tokio::io::{AsyncReadExt, AsyncWriteExt, copy, sink};
use tokio::net::{TcpListener, TcpStream};
use tokio::task::{AbortHandle, JoinSet};
use tokio::time::timeout;
use tracing::info;

use crate::access::{Access, LOGIN_TIME, Refusal, Rights, Role};
use crate::budget::Budgets;

/// Most connections that wait. One more drops the one that has waited longest: a client with a token is in before, as it needs no second.
const MAX_WAITING: usize = 256;
/// Longest time for the last words to a client that is turned away, and most of its bytes that are read meanwhile.
const FAREWELL: Duration = Duration::from_secs(1);
const MOST_UNREAD: u64 = 64 * 1024;

/// The door of a port. Without tokens it is open.
pub(crate) struct Door {
    access: Access,
    /// The roles of which one is needed.
    wanted: &'static [Role],
    /// True to tell clients why they are turned away.
    tells: bool,
    budgets: Budgets,
    waiting: JoinSet<Option<Guest>>,
    /// Those who wait, in the order of their arrival.
    handles: VecDeque<AbortHandle>,
}

/// A connection that may come in.
pub(crate) struct Guest {
    pub(crate) stream: TcpStream,
    /// Its address.
    pub(crate) peer: SocketAddr,
    pub(crate) rights: Rights,
}

impl Door {
    pub(crate) fn new(access: Access, wanted: &'static [Role], tells: bool, budgets: Budgets) -> Self {
        Self { access, wanted, tells, budgets, waiting: JoinSet::new(), handles: VecDeque::new() }
    }

    /// Returns the next connection that may come in. It can be dropped at any time.
    ///
    /// # Errors
    /// The operating system's, when a connection cannot be accepted.
    pub(crate) async fn accept(&mut self, listener: &TcpListener) -> std::io::Result<Guest> {
        if let Some(rights) = self.access.everything() {
            let (stream, peer) = listener.accept().await?;
            return Ok(Guest { stream, peer, rights });
        }
        loop {
            tokio::select! {
                accepted = listener.accept() => {
                    let (stream, peer) = accepted?;
                    self.knock(stream, peer);
                }
                Some(entered) = self.waiting.join_next() => {
                    // Those who were dropped do not come in.
                    if let Ok(Some(guest)) = entered {
                        return Ok(guest);
                    }
                }
            }
        }
    }

    /// Lets a connection log in.
    fn knock(&mut self, mut stream: TcpStream, peer: SocketAddr) {
        self.handles.retain(|handle| !handle.is_finished());
        if self.handles.len() >= MAX_WAITING
            && let Some(oldest) = self.handles.pop_front()
        {
            oldest.abort();
        }
        let (access, wanted, tells) = (self.access.clone(), self.wanted, self.tells);
        let budgets = self.budgets.clone();
        self.handles.push_back(self.waiting.spawn(async move {
            match access.log_in(&mut stream, wanted).await {
                Ok(rights) => Some(Guest { stream, peer, rights }),
                Err(refusal) => {
                    if budgets.allow(Some(peer.ip())) {
                        info!(%peer, %refusal, "client turned away");
                    }
                    if tells {
                        let _ = timeout(FAREWELL, turn_away(stream, &refusal)).await;
                    }
                    None
                }
            }
        }));
    }
}

/// Tells a client why it is not served.
async fn turn_away(mut stream: TcpStream, refusal: &Refusal) {
    let seconds = LOGIN_TIME.as_secs();
    let text = format!("LOGIN refused: {refusal}; expected LOGIN {{Token ..}} as the first line, within {seconds} s");
    let text = Message::Nfo(Nfo::Error(text)).write(Dialect::Udk) + "\r\n";
    let _ = (stream.write_all(text.as_bytes()).await, stream.shutdown().await);
    // Bytes that are not read would make the operating system take the answer back.
    let _ = copy(&mut stream.take(MOST_UNREAD), &mut sink()).await;
}
