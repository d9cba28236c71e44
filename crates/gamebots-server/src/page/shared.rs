//! State that the page's handlers share, and a connection's stay in it.

use std::net::{IpAddr, SocketAddr};
use std::sync::atomic::AtomicU64;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use served_world::{Entrance, Inquiry};
use tokio::sync::{Notify, OwnedSemaphorePermit, Semaphore};

use crate::access::rights::{Access, WorldControl};
use crate::access::waiting_room::Stay;
use crate::page::class::ClassPages;
use crate::page::map::MapPictures;
use crate::page::opener::Opener;
use crate::page::packed::Packed;
use crate::page::scenario::ScenarioPages;
use crate::subscribers::live::Channels;

/// Pages that may frame the page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Framing {
    /// None: a frame could trick its user into driving.
    Nobody,
    /// Pages of this machine, such as notebooks. For a page that only shows.
    Local,
}

impl Framing {
    /// Returns the sources of `frame-ancestors` (Content Security Policy).
    pub(crate) fn ancestors(self) -> &'static str {
        match self {
            Self::Nobody => "'none'",
            Self::Local => "http://localhost:* http://127.0.0.1:* http://[::1]:* vscode-webview:",
        }
    }
}

/// State that the page's handlers share.
pub(crate) struct Site {
    /// The host name that the server was told to listen on.
    pub(crate) host: String,
    /// Address of the protocol's port.
    pub(crate) protocol: SocketAddr,
    pub(crate) channels: Channels,
    pub(crate) entrance: Entrance,
    /// The way of all HTTP requests to the world.
    pub(crate) inquiry: Inquiry,
    /// Time after which a viewer that reads nothing is disconnected.
    pub(crate) stall_timeout: Duration,
    pub(crate) world_control: WorldControl,
    pub(crate) access: Access,
    /// Most connections of each kind.
    pub(crate) limits: Vec<(&'static str, usize)>,
    pub(crate) packed: Packed,
    pub(crate) classes: ClassPages,
    pub(crate) scenarios: ScenarioPages,
    pub(crate) maps: MapPictures,
    /// Opener of the files of other programs, if the server opens any.
    pub(crate) opener: Option<Opener>,
    /// Number of pages opened so far; it numbers the pages.
    pub(crate) pages: AtomicU64,
    pub(crate) framing: Framing,
    /// The entrance of clients of rosbridge.
    #[cfg(feature = "ros2")]
    pub(crate) rosbridge: Option<ros2::Rosbridge>,
}

/// A connection's stay: in the waiting room until it has shown that it may come in, then in one of the page's places. It is held while the
/// connection lives, also after it has become a WebSocket.
pub(crate) struct Visit {
    places: Arc<Semaphore>,
    state: Mutex<VisitState>,
    dropped: Arc<Notify>,
}

enum VisitState {
    Waiting(#[expect(dead_code, reason = "it leaves the room on drop")] Stay),
    Admitted(#[expect(dead_code, reason = "it is free again on drop")] OwnedSemaphorePermit),
}

impl Visit {
    pub(crate) fn new(places: Arc<Semaphore>, stay: Stay) -> Self {
        let dropped = stay.notify();
        Self { places, state: Mutex::new(VisitState::Waiting(stay)), dropped }
    }

    /// Gives the connection a place. Returns false if all are taken.
    pub(crate) fn admit(&self) -> bool {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        if let VisitState::Admitted(_) = *state {
            return true;
        }
        let place = self.places.clone().try_acquire_owned();
        place.map(|place| *state = VisitState::Admitted(place)).is_ok()
    }

    /// Completes when the waiting room drops the connection for another one.
    pub(crate) async fn dropped(&self) {
        self.dropped.notified().await;
    }
}

/// The ends of a page's connection.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Peer {
    pub(crate) address: IpAddr,
    /// The server's address.
    pub(crate) own: IpAddr,
}
