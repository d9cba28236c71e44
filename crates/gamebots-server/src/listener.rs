//! Accepting clients, and pausing when there are too many.

use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::sync::mpsc;
use std::time::{Duration, Instant};

use tokio::net::{TcpListener, TcpSocket, lookup_host};
use tokio::sync::oneshot;
use tokio::task::JoinSet;
use tracing::{info, warn};

use crate::connection::Event;
use crate::foxglove_server::FoxgloveServer;
use crate::web::Site;
use crate::{Config, Page, Ready, ServeError, connection, foxglove_server, live, web, world_thread};

/// Longest that the last lines to all clients may take.
const FAREWELL_TIMEOUT: Duration = Duration::from_millis(500);
/// Bytes that may wait in the operating system for one viewer.
const MAX_UNSENT_TO_VIEWER: u32 = 64 * 1024;
/// Viewers that may wait to be accepted.
const BACKLOG: u32 = 128;
/// Pause after an error of accept or bind, which otherwise comes back at once.
const BACK_OFF: Duration = Duration::from_millis(100);

pub(crate) async fn serve(
    config: Config,
    ready: impl FnOnce(Ready),
    shutdown: impl Future<Output = ()>,
) -> Result<(), ServeError> {
    let listener = listen(&config.host, config.port).await?;
    let address = local_address(&listener, &config.host, config.port)?;
    let page = match config.page {
        Page::None => None,
        Page::On(port) => Some(listen_for_viewers(&config.host, port).await?),
        Page::Near(port) => Some(listen_near(&config.host, port).await?),
    };
    let page_address = page.as_ref().map(|page| local_address(page, &config.host, 0)).transpose()?;
    // Not bounded by itself: whoever sends waits for a turn, see `connection::Turn`.
    let (events, receiver) = mpsc::channel();
    let (gone, world_gone) = oneshot::channel();
    let (live, channels) = live::broadcast(Instant::now());
    let (max_connections, stall_timeout) = (config.max_connections, config.stall_timeout);
    let scene = page.as_ref().map(|_| live::scene_json(&config.world, config.options.seed, address.port()).to_string());
    let site = Site {
        host: config.host.clone(),
        protocol: reachable(address),
        scene: scene.unwrap_or_default().into(),
        channels,
        events: events.clone(),
        stall_timeout,
    };
    let foxglove = match config.foxglove {
        Some(port) => {
            let listener = listen(&config.host, port).await?;
            Some(foxglove_server::start(listener, &config.host, &config.world, events.clone()).await?)
        }
        None => None,
    };
    let addresses = Ready { address, page: page_address, foxglove: foxglove.as_ref().map(FoxgloveServer::port) };
    let world = world_thread::spawn(config, receiver, live, foxglove, gone)?;
    ready(addresses);
    let mut clients = JoinSet::new();
    let accepting = accept_clients(&mut clients, listener, address, max_connections, stall_timeout, events.clone());
    let showing = async {
        match page {
            Some(page) => web::serve(page, site).await,
            None => std::future::pending().await,
        }
    };
    let mut world_gone = world_gone;
    let is_gone = tokio::select! {
        () = accepting => false,
        () = showing => false,
        () = shutdown => false,
        _ = &mut world_gone => true,
    };
    if !is_gone {
        // A world that is gone by now needs not be told.
        let _ = events.send(Event::Stop);
        let _ = world_gone.await;
    }
    // It has closed every outbox; what waits there is sent to those who take it.
    let _ = tokio::time::timeout(FAREWELL_TIMEOUT, async { while clients.join_next().await.is_some() {} }).await;
    clients.shutdown().await;
    world.join().map_err(|_| ServeError::WorldStopped)?
}

async fn listen(host: &str, port: u16) -> Result<TcpListener, ServeError> {
    let listener = TcpListener::bind((host, port)).await;
    listener.map_err(|reason| ServeError::Listen { host: host.to_owned(), port, reason })
}

/// The page's listener. Little waits in its connections, so that a slow viewer sees the newest frame and not one of
/// seconds ago.
async fn listen_for_viewers(host: &str, port: u16) -> Result<TcpListener, ServeError> {
    let failed = |reason| ServeError::Listen { host: host.to_owned(), port, reason };
    let mut result = Err(failed(std::io::ErrorKind::AddrNotAvailable.into()));
    for address in lookup_host((host, port)).await.map_err(failed)? {
        let listen = || {
            let socket = if address.is_ipv4() { TcpSocket::new_v4()? } else { TcpSocket::new_v6()? };
            socket.set_reuseaddr(true)?;
            // Those that are accepted inherit it.
            socket.set_send_buffer_size(MAX_UNSENT_TO_VIEWER)?;
            socket.bind(address)?;
            socket.listen(BACKLOG)
        };
        result = listen().map_err(failed);
        if result.is_ok() {
            break;
        }
    }
    result
}

async fn listen_near(host: &str, port: u16) -> Result<TcpListener, ServeError> {
    let wanted = listen_for_viewers(host, port).await;
    if wanted.is_err() {
        warn!(port, "taken by another program: the page is on a free port");
        return listen_for_viewers(host, 0).await;
    }
    wanted
}

fn local_address(listener: &TcpListener, host: &str, port: u16) -> Result<SocketAddr, ServeError> {
    listener.local_addr().map_err(|reason| ServeError::Listen { host: host.to_owned(), port, reason })
}

/// An address at which this machine reaches what it listens on.
fn reachable(mut address: SocketAddr) -> SocketAddr {
    match address.ip() {
        IpAddr::V4(ip) if ip.is_unspecified() => address.set_ip(Ipv4Addr::LOCALHOST.into()),
        IpAddr::V6(ip) if ip.is_unspecified() => address.set_ip(Ipv6Addr::LOCALHOST.into()),
        _ => {}
    }
    address
}

/// As in USARSim the limit is passed by one: listening stops when there are more than `max` connections, and the
/// operating system refuses clients until one leaves (BotServer.uc:46-72).
async fn accept_clients(
    clients: &mut JoinSet<()>,
    listener: TcpListener,
    address: SocketAddr,
    max: usize,
    stall_timeout: Duration,
    events: mpsc::Sender<Event>,
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
