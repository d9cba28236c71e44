//! The waiting room: connections of all ports that have not shown yet that they may come in.
//!
//! It has one limit for all ports. When it is full, the address with most connections loses its oldest one. So nobody who sends a token at
//! once is locked out by others who send nothing.

use std::collections::BTreeMap;
use std::net::{IpAddr, SocketAddr};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use tokio::net::{TcpListener, TcpStream};
use tokio::sync::Notify;
use tokio::time::sleep;
use tracing::debug;

/// Time that a connection has at least before it can be dropped for another.
const LEAST_STAY: Duration = Duration::from_millis(25);

/// The waiting room. Copies are the same room.
#[derive(Clone)]
pub(crate) struct WaitingRoom(Arc<Mutex<Room>>);

struct Room {
    /// Most connections.
    limit: usize,
    /// Connections by the order of their arrival.
    waiting: BTreeMap<u64, Waiting>,
    next: u64,
}

struct Waiting {
    address: IpAddr,
    since: Instant,
    dropped: Arc<Notify>,
}

/// A connection's stay in the waiting room. It leaves on drop.
pub(crate) struct Stay {
    room: WaitingRoom,
    number: u64,
    dropped: Arc<Notify>,
}

/// A connection in the waiting room.
pub(crate) struct Visitor {
    pub(crate) stream: TcpStream,
    /// Its address.
    pub(crate) peer: SocketAddr,
    pub(crate) stay: Stay,
}

impl WaitingRoom {
    pub(crate) fn new(limit: usize) -> Self {
        Self(Arc::new(Mutex::new(Room { limit, waiting: BTreeMap::new(), next: 0 })))
    }

    fn room(&self) -> MutexGuard<'_, Room> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits until one more connection may come in.
    async fn vacancy(&self) {
        loop {
            let wait = self.room().wait(Instant::now());
            match wait {
                Some(wait) => sleep(wait).await,
                None => return,
            }
        }
    }

    /// Accepts a connection once there is a vacancy. The future can be dropped at any time.
    ///
    /// # Errors
    /// The operating system's, when a connection cannot be accepted.
    pub(crate) async fn accept(&self, listener: &TcpListener) -> std::io::Result<Visitor> {
        self.vacancy().await;
        let (stream, peer) = listener.accept().await?;
        debug!(%peer, "connected");
        Ok(Visitor { stay: self.enter(peer.ip()), stream, peer })
    }

    /// Lets a connection in, and drops another one if the room is full.
    fn enter(&self, address: IpAddr) -> Stay {
        let mut room = self.room();
        if room.waiting.len() >= room.limit
            && let Some(number) = room.next_to_go()
            && let Some(waiting) = room.waiting.remove(&number)
        {
            waiting.dropped.notify_one();
        }
        let (number, dropped) = (room.next, Arc::<Notify>::default());
        room.next += 1;
        room.waiting.insert(number, Waiting { address, since: Instant::now(), dropped: dropped.clone() });
        Stay { room: self.clone(), number, dropped }
    }
}

impl Room {
    /// Returns the oldest connection of the address that has most.
    fn next_to_go(&self) -> Option<u64> {
        let mut counts = BTreeMap::<IpAddr, usize>::new();
        for waiting in self.waiting.values() {
            *counts.entry(waiting.address).or_default() += 1;
        }
        let most = counts.values().max()?;
        let is_of_most = |waiting: &Waiting| counts.get(&waiting.address) == Some(most);
        self.waiting.iter().find(|(_, waiting)| is_of_most(waiting)).map(|(&number, _)| number)
    }

    /// Returns the wait until one more connection may come in; none if it may now.
    fn wait(&self, now: Instant) -> Option<Duration> {
        if self.waiting.len() < self.limit {
            return None;
        }
        let goes = self.waiting.get(&self.next_to_go()?)?;
        LEAST_STAY.checked_sub(now.duration_since(goes.since)).filter(|wait| !wait.is_zero())
    }
}

impl Stay {
    /// Returns the bell that rings when the connection is dropped for another one.
    pub(crate) fn notify(&self) -> Arc<Notify> {
        self.dropped.clone()
    }

    /// Completes when the connection is dropped for another one.
    pub(crate) async fn dropped(&self) {
        self.dropped.notified().await;
    }
}

impl Drop for Stay {
    fn drop(&mut self) {
        self.room.room().waiting.remove(&self.number);
    }
}

#[cfg(test)]
mod tests {
    use futures_util::FutureExt;

    use super::*;

    fn is_dropped(stay: &Stay) -> bool {
        stay.dropped().now_or_never().is_some()
    }

    #[test]
    fn a_full_room_drops_the_oldest_connection_of_the_address_with_most() {
        let room = WaitingRoom::new(4);
        let address = |last: u8| IpAddr::from([10, 0, 0, last]);
        let honest = room.enter(address(1));
        let mut flood: Vec<Stay> = (0..3).map(|_| room.enter(address(2))).collect();
        assert!(!flood.iter().any(is_dropped));
        assert!(room.room().wait(Instant::now()).is_some(), "the oldest has had no time yet");
        assert!(room.room().wait(Instant::now() + LEAST_STAY).is_none());
        flood.push(room.enter(address(2)));
        assert!(is_dropped(&flood[0]) && !flood[1..].iter().any(is_dropped) && !is_dropped(&honest));
        flood.truncate(1);
        assert!(room.room().wait(Instant::now()).is_none());
        drop((honest, flood));
        assert!(room.room().waiting.is_empty());
    }
}
