//! Logins: new connections of a port wait in a queue until their LOGIN line has come. They take no place of clients that have logged in.

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

/// Most connections that wait. One more drops the oldest. A client with a token logs in at once, so it is not among them.
const MAX_WAITING: usize = 256;
/// Longest time to send a refusal, and most bytes of the client that are read meanwhile.
const FAREWELL: Duration = Duration::from_secs(1);
const MOST_UNREAD: u64 = 64 * 1024;

/// Logins of a port. Without tokens every connection is accepted at once.
pub(crate) struct LoginQueue {
    access: Access,
    /// The roles of which one is needed.
    wanted: &'static [Role],
    /// True to send refused clients the reason.
    sends_reason: bool,
    budgets: Budgets,
    waiting: JoinSet<Option<Accepted>>,
    /// Waiting connections, oldest first.
    handles: VecDeque<AbortHandle>,
}

/// An accepted connection.
pub(crate) struct Accepted {
    pub(crate) stream: TcpStream,
    /// Its address.
    pub(crate) peer: SocketAddr,
    pub(crate) rights: Rights,
}

impl LoginQueue {
    pub(crate) fn new(access: Access, wanted: &'static [Role], sends_reason: bool, budgets: Budgets) -> Self {
        Self { access, wanted, sends_reason, budgets, waiting: JoinSet::new(), handles: VecDeque::new() }
    }

    /// Returns the next accepted connection. The future can be dropped at any time.
    ///
    /// # Errors
    /// The operating system's, when a connection cannot be accepted.
    pub(crate) async fn accept(&mut self, listener: &TcpListener) -> std::io::Result<Accepted> {
        if self.access.is_open() {
            let (stream, peer) = listener.accept().await?;
            return Ok(Accepted { stream, peer, rights: Rights::all() });
        }
        loop {
            tokio::select! {
                accepted = listener.accept() => {
                    let (stream, peer) = accepted?;
                    self.start_login(stream, peer);
                }
                Some(login) = self.waiting.join_next() => {
                    // A dropped connection is an error of its task.
                    if let Ok(Some(accepted)) = login {
                        return Ok(accepted);
                    }
                }
            }
        }
    }

    /// Adds a connection to the queue.
    fn start_login(&mut self, mut stream: TcpStream, peer: SocketAddr) {
        self.handles.retain(|handle| !handle.is_finished());
        if self.handles.len() >= MAX_WAITING
            && let Some(oldest) = self.handles.pop_front()
        {
            oldest.abort();
        }
        let (access, wanted, sends_reason) = (self.access.clone(), self.wanted, self.sends_reason);
        let budgets = self.budgets.clone();
        self.handles.push_back(self.waiting.spawn(async move {
            match access.log_in(&mut stream, wanted).await {
                Ok(rights) => Some(Accepted { stream, peer, rights }),
                Err(refusal) => {
                    if budgets.allow(peer.ip()) {
                        info!(%peer, %refusal, "client refused");
                    }
                    if sends_reason {
                        let _ = timeout(FAREWELL, send_refusal(stream, &refusal)).await;
                    }
                    None
                }
            }
        }));
    }
}

/// Sends a client the reason why it is not served.
async fn send_refusal(mut stream: TcpStream, refusal: &Refusal) {
    let seconds = LOGIN_TIME.as_secs();
    let text = format!("LOGIN refused: {refusal}; expected LOGIN {{Token ..}} as the first line, within {seconds} s");
    let text = Message::Nfo(Nfo::Error(text)).write(Dialect::Udk) + "\r\n";
    let _ = (stream.write_all(text.as_bytes()).await, stream.shutdown().await);
    // Bytes that are not read would make the operating system take the answer back.
    let _ = copy(&mut stream.take(MOST_UNREAD), &mut sink()).await;
}
