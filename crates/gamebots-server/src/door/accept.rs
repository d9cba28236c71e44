//! Listening on ports, and acceptance of connections: one loop for all ports.

use std::net::SocketAddr;
use std::time::{Duration, Instant};

use served_world::Budget;
use tokio::net::{TcpListener, TcpSocket, lookup_host};
use tokio::task::JoinSet;
use tokio::time::sleep;
use tracing::warn;

use crate::config::{IfTaken, Listener, Service};
use crate::error::ServeError;

/// Send buffer of the operating system for one viewer, bytes.
const MAX_UNSENT_TO_VIEWER: u32 = 64 * 1024;
/// Viewers that may wait to be accepted.
const BACKLOG: u32 = 128;
/// Pause after an error of accept or bind, which would otherwise recur at once.
pub(crate) const BACK_OFF: Duration = Duration::from_millis(100);

/// Limit of a port's clients.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Limit {
    /// None here: connections are counted elsewhere.
    Elsewhere,
    /// At most so many at once. More wait to be accepted.
    Waiting(usize),
    /// As in USARSim, so many and one more: then the port closes, and the operating system refuses clients until one leaves
    /// (BotServer.uc:46-72).
    Refusing(usize),
}

/// Listens on a port. `None` if another program has it and the service is left out then.
pub(crate) async fn listen(
    host: &str,
    Listener { service, port, if_taken }: Listener,
) -> Result<Option<TcpListener>, ServeError> {
    let bind = async |port| match service {
        Service::Page => listen_for_viewers(host, port).await,
        _ => TcpListener::bind((host, port)).await,
    };
    let bound = bind(port).await;
    let bound = match (if_taken, bound) {
        (IfTaken::Another, Err(_)) => {
            warn!(port, ?service, "taken by another program: a free port is used");
            bind(0).await
        }
        (IfTaken::LeaveOut, Err(reason)) => {
            warn!(port, ?service, %reason, "the port cannot be had: this service is left out");
            return Ok(None);
        }
        (_, bound) => bound,
    };
    bound.map(Some).map_err(|reason| ServeError::Listen { host: host.to_owned(), port, reason })
}

/// Listens for viewers with a small send buffer, so that a slow viewer sees the newest frame and not one that is seconds old.
async fn listen_for_viewers(host: &str, port: u16) -> std::io::Result<TcpListener> {
    let mut result = Err(std::io::ErrorKind::AddrNotAvailable.into());
    for address in lookup_host((host, port)).await? {
        result = listen_at(address);
        if result.is_ok() {
            break;
        }
    }
    result
}

fn listen_at(address: SocketAddr) -> std::io::Result<TcpListener> {
    let socket = if address.is_ipv4() { TcpSocket::new_v4()? } else { TcpSocket::new_v6()? };
    socket.set_reuseaddr(true)?;
    // Accepted connections inherit the size.
    socket.set_send_buffer_size(MAX_UNSENT_TO_VIEWER)?;
    socket.bind(address)?;
    socket.listen(BACKLOG)
}

/// Accepts clients until the future is dropped. `next` takes one from the listener. Each is served as a task of `clients`.
pub(crate) async fn accept<T, S: Future<Output = ()> + Send + 'static>(
    clients: &mut JoinSet<()>,
    listener: TcpListener,
    limit: Limit,
    mut next: impl AsyncFnMut(&TcpListener) -> std::io::Result<T>,
    serve: impl Fn(T) -> S,
) {
    let address = listener.local_addr();
    let (mut listener, mut warnings) = (Some(listener), Budget::default());
    loop {
        let is_full = match limit {
            Limit::Elsewhere => false,
            Limit::Waiting(most) => clients.len() >= most,
            Limit::Refusing(most) => clients.len() > most,
        };
        if let (Limit::Refusing(_), Ok(address)) = (limit, &address) {
            if is_full && listener.take().is_some() && warnings.allow(Instant::now(), "connections") {
                warn!(connections = clients.len(), "too many connections: not listening until one leaves");
            } else if !is_full && listener.is_none() {
                listener = Some(listen_again(*address, &mut warnings).await);
            }
        }
        let accept = async {
            match &listener {
                Some(listener) if !is_full => next(listener).await,
                _ => std::future::pending().await,
            }
        };
        tokio::select! {
            accepted = accept => match accepted {
                Ok(accepted) => _ = clients.spawn(serve(accepted)),
                Err(error) => back_off("cannot accept a client", &error, &mut warnings).await,
            },
            Some(_) = clients.join_next() => {}
        }
    }
}

async fn listen_again(address: SocketAddr, warnings: &mut Budget) -> TcpListener {
    loop {
        match TcpListener::bind(address).await {
            Ok(listener) => return listener,
            Err(error) => back_off("cannot listen again", &error, warnings).await,
        }
    }
}

/// Reports an error, and waits: it would otherwise recur at once.
async fn back_off(what: &str, error: &std::io::Error, warnings: &mut Budget) {
    if warnings.allow(Instant::now(), "connections") {
        warn!(%error, "{what}");
    }
    sleep(BACK_OFF).await;
}
