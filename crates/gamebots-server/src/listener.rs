//! Accepting clients, and pausing when there are too many.

use std::net::SocketAddr;
use std::time::Duration;

use tokio::net::TcpListener;
use tokio::sync::{mpsc, oneshot};
use tokio::task::JoinSet;
use tracing::{info, warn};

use crate::{Config, ServeError, connection, world_thread};

/// Events that may wait for the world; then clients wait.
const MAX_EVENTS: usize = 1024;
/// Pause after an error of accept or bind, which otherwise comes back at once.
const BACK_OFF: Duration = Duration::from_millis(100);

pub(crate) async fn serve(
    config: Config,
    ready: impl FnOnce(SocketAddr),
    shutdown: impl Future<Output = ()>,
) -> Result<(), ServeError> {
    let failed = |reason| ServeError::Listen { host: config.host.clone(), port: config.port, reason };
    let listener = TcpListener::bind((config.host.as_str(), config.port)).await.map_err(failed)?;
    let address = listener.local_addr().map_err(failed)?;
    let (events, receiver) = mpsc::channel(MAX_EVENTS);
    let (gone, world_gone) = oneshot::channel();
    let (max_connections, stall_timeout) = (config.max_connections, config.stall_timeout);
    let world = world_thread::spawn(config, receiver, gone)?;
    ready(address);
    let mut clients = JoinSet::new();
    let accepting = accept_clients(&mut clients, listener, address, max_connections, stall_timeout, events);
    let result = tokio::select! {
        () = accepting => Ok(()),
        () = shutdown => Ok(()),
        _ = world_gone => Err(ServeError::WorldStopped),
    };
    // With the last connection goes the last sender of events, and with that the world's thread.
    clients.shutdown().await;
    world.join().map_err(|_| ServeError::WorldStopped).and(result)
}

/// As in USARSim the limit is passed by one: listening stops when there are more than `max` connections, and the
/// operating system refuses clients until one leaves (BotServer.uc:46-72).
async fn accept_clients(
    clients: &mut JoinSet<()>,
    listener: TcpListener,
    address: SocketAddr,
    max: usize,
    stall_timeout: Duration,
    events: mpsc::Sender<connection::Event>,
) {
    let mut listener = Some(listener);
    let mut next_id = 0;
    loop {
        if clients.len() > max {
            if listener.take().is_some() {
                warn!(connections = clients.len(), "too many connections: not listening until one leaves");
            }
        } else if listener.is_none() {
            listener = listen_again(address).await;
        }
        let accept = async {
            match &listener {
                Some(listener) => listener.accept().await,
                None => std::future::pending().await,
            }
        };
        tokio::select! {
            accepted = accept => match accepted {
                Ok((stream, peer)) => {
                    next_id += 1;
                    info!(connection = next_id, %peer, "client connected");
                    clients.spawn(connection::serve(next_id, stream, events.clone(), stall_timeout));
                }
                Err(error) => {
                    warn!(%error, "cannot accept a client");
                    tokio::time::sleep(BACK_OFF).await;
                }
            },
            Some(_) = clients.join_next() => {}
        }
    }
}

async fn listen_again(address: SocketAddr) -> Option<TcpListener> {
    let listener = TcpListener::bind(address).await;
    match listener {
        Ok(listener) => Some(listener),
        Err(error) => {
            warn!(%error, %address, "cannot listen again");
            tokio::time::sleep(BACK_OFF).await;
            None
        }
    }
}
