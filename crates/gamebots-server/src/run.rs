//! Listeners, with a port each for controllers, viewers and Foxglove. Accepts clients, and pauses when there are too many.

use std::cell::Cell;
use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::sync::atomic::AtomicU64;
use std::sync::{Arc, mpsc};
use std::time::{Duration, Instant};

use futures_util::future::join_all;
use tokio::net::{TcpListener, TcpSocket, lookup_host};
use tokio::sync::{OwnedSemaphorePermit, Semaphore, oneshot};
use tokio::task::JoinSet;
use tracing::{debug, warn};

use crate::access::budget::{Budget, Spent};
use crate::access::login::{Accepted, Door, LoginQueue};
use crate::access::tokens::Role;
use crate::door::limits::limits;
use crate::messages::scene::About;
use crate::page::packed::Packed;
use crate::page::site::{self, Framing, Site};
use crate::ports::controllers::{BACK_OFF, Event, Rules};
use crate::ports::images::{self, Board};
use crate::ports::truth::{self, Inquiry, Port};
use crate::ports::wireless::{self, Network};
use crate::ports::{com_server, controllers};
use crate::subscribers::live::Channels;
use crate::subscribers::{foxglove as foxglove_server, live};
use crate::world::{guests, thread};
use crate::{Config, IfTaken, Listener, Ready, ServeError, Service, WorldControl};

/// Longest time to send the last lines to all clients.
const FAREWELL_TIMEOUT: Duration = Duration::from_millis(500);
/// Send buffer of the operating system for one viewer, bytes.
const MAX_UNSENT_TO_VIEWER: u32 = 64 * 1024;
/// Viewers that may wait to be accepted.
const BACKLOG: u32 = 128;

pub(crate) async fn serve(
    config: Config,
    ready: impl FnOnce(Ready),
    shutdown: impl Future<Output = ()>,
) -> Result<(), ServeError> {
    let (mut addresses, mut controllers, mut pages, mut foxglove) = (Vec::new(), Vec::new(), Vec::new(), None);
    let (mut ports, mut images, mut radios, mut relays) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let (limits, lowered) = limits(&config);
    lowered.iter().for_each(|text| warn!("{text}"));
    let door = Door::new(config.tokens.clone(), limits.waiting);
    let Door { access, budgets, .. } = door.clone();
    // Unbounded: each sender waits for a turn, see `controllers::Turn`.
    let (events, receiver) = mpsc::channel();
    for listener in &config.listeners {
        let Some(bound) = listen(&config.host, *listener).await? else { continue };
        let address = bound.local_addr().map_err(ServeError::Start)?;
        addresses.push((listener.service, address));
        match listener.service {
            Service::Controllers { dialect } => controllers.push((dialect, address, bound)),
            Service::Page => pages.push(bound),
            Service::Truth => ports.push((Port::Truth, bound)),
            Service::Positions => ports.push((Port::Positions, bound)),
            Service::Images => images.push(bound),
            Service::Wireless => radios.push(bound),
            Service::ComServer => relays.push(bound),
            Service::Foxglove => {
                // Its clients cannot be told apart.
                let may_control = config.world_control == WorldControl::Everyone && access.is_open();
                let events = may_control.then(|| events.clone());
                foxglove = Some(
                    foxglove_server::start(bound, limits.foxglove, &config.host, &door, &config.world, events).await?,
                );
            }
        }
    }
    let addresses = Ready(addresses);
    let (gone, mut world_gone) = oneshot::channel();
    let board = Board::new(config.image_kind, config.image_legacy);
    let network = Network::new(events.clone(), access.clone(), &config.host, config.propagation, limits);
    let (live, channels) = live::broadcast(
        Instant::now(),
        &config.world,
        addresses.of(Service::Page).map(|_| about(&config, &addresses)),
        board.clone(),
    );
    let site = Arc::new(Site { limits: limits.named(), ..site(&config, &door, &addresses, channels, events.clone()) });
    let stall_timeout = config.stall_timeout;
    let rules = Rules {
        dialect: None,
        access: access.clone(),
        world_control: config.world_control,
        is_league: config.world.league.is_some(),
        stall_timeout,
        budgets: budgets.clone(),
    };
    let world = thread::spawn(config, budgets.clone(), receiver, live, foxglove, gone)?;
    ready(addresses);
    let mut clients: Vec<JoinSet<()>> = controllers.iter().map(|_| JoinSet::new()).collect();
    let ids = Cell::new(0);
    let accepting = clients.iter_mut().zip(controllers).map(|(clients, (dialect, address, bound))| {
        let (ids, events, rules) = (&ids, &events, Rules { dialect, ..rules.clone() });
        let logins = LoginQueue::new(door.clone(), &[Role::Driver, Role::Referee], true);
        let serve = move |accepted| {
            ids.set(ids.get() + 1);
            controllers::serve(ids.get(), accepted, rules.clone(), events.clone())
        };
        accept_clients(clients, bound, address, limits.controllers, logins, serve)
    });
    let logins = |wanted| LoginQueue::new(door.clone(), wanted, false);
    let telling = ports.into_iter().map(|(port, bound)| {
        let most = match port {
            Port::Truth => limits.truth,
            Port::Positions => limits.positions,
        };
        truth::serve(port, bound, logins(&[Role::Viewer]), most, events.clone(), stall_timeout)
    });
    let drawing = images.into_iter().map(|bound| {
        images::serve(board.clone(), bound, logins(&[Role::Viewer, Role::Driver]), limits.images, stall_timeout)
    });
    let radioing =
        radios.into_iter().map(|bound| wireless::serve(network.clone(), bound, logins(&[Role::Driver]), stall_timeout));
    let relaying = relays
        .into_iter()
        .map(|bound| com_server::serve(network.clone(), bound, logins(&[Role::Driver]), limits, stall_timeout));
    let showing = pages.into_iter().map(|page| site::serve(page, limits.pages, site.clone()));
    let is_gone = tokio::select! {
        () = forever(accepting) => false,
        () = forever(showing) => false,
        () = forever(telling) => false,
        () = forever(drawing) => false,
        () = forever(radioing) => false,
        () = forever(relaying) => false,
        () = shutdown => false,
        _ = &mut world_gone => true,
    };
    if !is_gone {
        // The world may have ended by now.
        let _ = events.send(Event::Stop);
        let _ = world_gone.await;
    }
    // The world has closed every outbox; clients that read still get their last lines.
    let farewell = async {
        for clients in &mut clients {
            while clients.join_next().await.is_some() {}
        }
    };
    let _ = tokio::time::timeout(FAREWELL_TIMEOUT, farewell).await;
    for clients in &mut clients {
        clients.shutdown().await;
    }
    world.join().map_err(|_| ServeError::WorldStopped)?
}

/// Runs all services, and never ends.
async fn forever(services: impl Iterator<Item = impl Future<Output = ()>>) {
    join_all(services).await;
    std::future::pending().await
}

/// Collects the state that the page's handlers share.
fn site(config: &Config, door: &Door, addresses: &Ready, channels: Channels, events: mpsc::Sender<Event>) -> Site {
    // Without controllers the page cannot drive: nothing listens at this address, and its WebSocket reports that.
    let protocol = addresses.controllers().unwrap_or_else(|| SocketAddr::from((Ipv4Addr::LOCALHOST, 0)));
    Site {
        host: config.host.clone(),
        protocol: reachable(protocol),
        channels,
        inquiry: Inquiry::new(guests::Kind::Http, events.clone()),
        events,
        stall_timeout: config.stall_timeout,
        world_control: config.world_control,
        access: door.access.clone(),
        room: door.room.clone(),
        limits: Vec::new(),
        packed: Packed::default(),
        pages: AtomicU64::new(0),
        framing: Framing::Nobody,
    }
}

/// Collects the server's settings that the page shows beside the world.
fn about(config: &Config, addresses: &Ready) -> About {
    About {
        seed: config.options.seed,
        time_step: config.options.time_step,
        port: addresses.controllers().map_or(0, |address| address.port()),
        maps: config.maps.iter().map(|map| (map.name.clone(), map.description.clone())).collect(),
    }
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

/// Returns an address at which this machine reaches its own listener.
fn reachable(mut address: SocketAddr) -> SocketAddr {
    match address.ip() {
        IpAddr::V4(ip) if ip.is_unspecified() => address.set_ip(Ipv4Addr::LOCALHOST.into()),
        IpAddr::V6(ip) if ip.is_unspecified() => address.set_ip(Ipv6Addr::LOCALHOST.into()),
        _ => {}
    }
    address
}

/// Accepts clients. As in USARSim, the limit is exceeded by one: listening stops when there are more than `max` connections.
/// The operating system then refuses clients until one leaves (BotServer.uc:46-72).
async fn accept_clients<S: Future<Output = ()> + Send + 'static>(
    clients: &mut JoinSet<()>,
    listener: TcpListener,
    address: SocketAddr,
    max: usize,
    mut logins: LoginQueue,
    serve: impl Fn(Accepted) -> S,
) {
    let (mut listener, mut warnings) = (Some(listener), Budget::default());
    loop {
        if clients.len() > max {
            if listener.take().is_some() && warnings.spend(Instant::now()) != Spent::Refused {
                warn!(connections = clients.len(), "too many connections: not listening until one leaves");
            }
        } else if listener.is_none() {
            listener = listen_again(address).await;
        }
        let accept = async {
            match &listener {
                Some(listener) => logins.accept(listener).await,
                None => std::future::pending().await,
            }
        };
        tokio::select! {
            accepted = accept => match accepted {
                Ok(accepted) => _ = clients.spawn(serve(accepted)),
                Err(error) => back_off(&error, &mut warnings).await,
            },
            Some(_) = clients.join_next() => {}
        }
    }
}

/// Reports an error of accept, and waits: it would otherwise recur at once.
pub(crate) async fn back_off(error: &std::io::Error, warnings: &mut Budget) {
    if warnings.spend(Instant::now()) != Spent::Refused {
        warn!(%error, "cannot accept a client");
    }
    tokio::time::sleep(BACK_OFF).await;
}

/// One of a service's places for connections. It is held while the connection lives.
pub(crate) type Place = OwnedSemaphorePermit;

/// Accepts clients until the future is dropped, at most a number of them at once; more wait. Their futures hold their places.
pub(crate) async fn accept<S: Future<Output = ()> + Send + 'static>(
    listener: TcpListener,
    mut logins: LoginQueue,
    most: usize,
    serve: impl Fn(Accepted, Place) -> S,
) {
    let places = Arc::new(Semaphore::new(most));
    let (mut clients, mut warnings) = (JoinSet::new(), Budget::default());
    loop {
        // The semaphore is never closed.
        let Ok(place) = places.clone().acquire_owned().await else { return };
        tokio::select! {
            accepted = logins.accept(&listener) => match accepted {
                Ok(accepted) => {
                    debug!(peer = %accepted.peer, "connected");
                    clients.spawn(serve(accepted, place));
                }
                Err(error) => back_off(&error, &mut warnings).await,
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
