//! Logins: new connections of a port stay in the waiting room until their LOGIN line has come. They take no place of clients that have
//! logged in.

use std::net::SocketAddr;
use std::time::{Duration, Instant};

use gamebots_proto::Dialect;
use gamebots_proto::message::{Message, Nfo};
use served_world::Budgets;
use tokio::io::{AsyncReadExt, AsyncWriteExt, copy, sink};
use tokio::net::{TcpListener, TcpStream};
use tokio::task::JoinSet;
use tokio::time::timeout;
use tracing::{debug, info};

use crate::access::rights::{Access, LOGIN_TIME, Refusal, Rights};
use crate::access::tokens::{Role, Tokens};
use crate::access::waiting_room::{Visitor, WaitingRoom};

/// Longest time to send a refusal, and most bytes of the client that are read meanwhile.
const FAREWELL: Duration = Duration::from_secs(1);
const MOST_UNREAD: u64 = 64 * 1024;

/// Rules and state that the logins of all ports share.
#[derive(Clone)]
pub(crate) struct Door {
    pub(crate) access: Access,
    pub(crate) room: WaitingRoom,
    pub(crate) budgets: Budgets,
}

impl Door {
    /// Creates the door of a server with these tokens, if any. So many connections wait at once.
    pub(crate) fn new(tokens: Option<Tokens>, waiting: usize) -> Self {
        Self { access: Access::new(tokens), room: WaitingRoom::new(waiting), budgets: Budgets::default() }
    }
}

/// Logins of a port. Without tokens every connection is accepted at once.
pub(crate) struct LoginQueue {
    door: Door,
    /// The roles of which one is needed.
    wanted: &'static [Role],
    /// True to send refused clients the reason.
    sends_reason: bool,
    waiting: JoinSet<Option<Accepted>>,
}

/// An accepted connection.
pub(crate) struct Accepted {
    pub(crate) stream: TcpStream,
    /// Its address.
    pub(crate) peer: SocketAddr,
    pub(crate) rights: Rights,
}

impl LoginQueue {
    pub(crate) fn new(door: Door, wanted: &'static [Role], sends_reason: bool) -> Self {
        Self { door, wanted, sends_reason, waiting: JoinSet::new() }
    }

    /// Returns the next accepted connection. The future can be dropped at any time.
    ///
    /// # Errors
    /// The operating system's, when a connection cannot be accepted.
    pub(crate) async fn accept(&mut self, listener: &TcpListener) -> std::io::Result<Accepted> {
        if self.door.access.is_open() {
            let (stream, peer) = listener.accept().await?;
            debug!(%peer, "connected");
            return Ok(Accepted { stream, peer, rights: Rights::all() });
        }
        let room = self.door.room.clone();
        loop {
            tokio::select! {
                visitor = room.accept(listener) => self.start_login(visitor?),
                Some(login) = self.waiting.join_next() => {
                    if let Ok(Some(accepted)) = login {
                        return Ok(accepted);
                    }
                }
            }
        }
    }

    /// Asks a connection to log in. It stays in the waiting room meanwhile.
    fn start_login(&mut self, Visitor { mut stream, peer, stay }: Visitor) {
        let (Door { access, budgets, .. }, wanted, sends_reason) = (self.door.clone(), self.wanted, self.sends_reason);
        let log_in = async move {
            match access.log_in(&mut stream, wanted).await {
                Ok(rights) => Some(Accepted { stream, peer, rights }),
                Err(refusal) => {
                    if budgets.allow(peer.ip(), Instant::now()) {
                        info!(%peer, %refusal, "client refused");
                    }
                    if sends_reason {
                        let _ = timeout(FAREWELL, send_refusal(stream, &refusal)).await;
                    }
                    None
                }
            }
        };
        self.waiting.spawn(async move {
            // A line that has come counts, even if the place is lost at the same moment.
            tokio::select! {
                biased;
                accepted = log_in => accepted,
                () = stay.dropped() => None,
            }
        });
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
