//! The server: it binds the ports, starts the world's thread, and serves every port until the end.

use std::net::{IpAddr, Ipv4Addr, Ipv6Addr, SocketAddr};
use std::sync::Arc;
use std::sync::atomic::AtomicU64;
use std::time::{Duration, Instant};

use futures_util::future::join_all;
use page_protocol::About;
use served_world::{Entrance, Kind};
use sim_core::World;
use tokio::net::TcpListener;
use tokio::sync::oneshot;
use tokio::task::JoinSet;
use tracing::warn;

use crate::access::login::{Accepted, Door, LoginQueue};
use crate::access::rights::WorldControl;
use crate::access::tokens::Role;
use crate::config::{Config, Ready, Service};
use crate::door::accept::{self, Limit, listen};
use crate::door::limits::{Limits, limits};
use crate::error::ServeError;
use crate::page::class::ClassPages;
use crate::page::map::MapPictures;
use crate::page::opener::Opener;
use crate::page::packed::Packed;
use crate::page::scenario::ScenarioPages;
use crate::page::shared::{Framing, Site};
use crate::page::site::Page;
use crate::ports::com_server::{self, Registry};
use crate::ports::controllers::{self, Rules};
use crate::ports::gate::Gate;
use crate::ports::images::{self, Pictures};
use crate::ports::wireless::{self, Network};
use crate::ports::{foxglove, positions, truth};
use crate::subscribers::board::Board;
use crate::subscribers::defect::Defect;
use crate::subscribers::foxglove::FoxgloveServer;
use crate::subscribers::journal::Journal;
use crate::subscribers::live::{self, Channels};
use crate::subscribers::results::Results;
use crate::subscribers::shots::Shots;
use crate::subscribers::subscriber::Subscriber;
use crate::world::thread;

/// Longest time to send the last lines to all clients.
const FAREWELL_TIMEOUT: Duration = Duration::from_millis(500);

pub(crate) async fn serve(
    config: Config,
    ready: impl FnOnce(Ready),
    shutdown: impl Future<Output = ()>,
) -> Result<(), ServeError> {
    let (limits, lowered) = limits(&config);
    lowered.iter().for_each(|text| warn!("{text}"));
    let door = Door::new(config.tokens.clone(), limits.waiting);
    let mut bound = Vec::new();
    let mut addresses = Vec::new();
    for listener in &config.listeners {
        let Some(port) = listen(&config.host, *listener).await? else { continue };
        addresses.push((listener.service, port.local_addr().map_err(ServeError::Start)?));
        bound.push((listener.service, port));
    }
    let (entrance, events) = Entrance::new();
    let addresses = Ready { addresses, entrance: entrance.clone() };
    // Foxglove's clients cannot be told apart.
    let may_control = config.world_control == WorldControl::Everyone && door.access.is_open();
    let (foxglove, gate) = match addresses.of(Service::Foxglove) {
        Some(_) => {
            let entrance = may_control.then_some(&entrance);
            let (server, gate) = foxglove::start(&config.host, limits.foxglove, &door, &config.world, entrance).await?;
            (Some(server), Some(gate))
        }
        None => (None, None),
    };
    let (gone, mut world_gone) = oneshot::channel();
    let board = Board::default();
    let about = addresses.of(Service::Page).map(|_| about(&config, &addresses));
    let (live, channels) = live::broadcast(Instant::now(), &config.world, about, board.clone());
    let network = Network::new(entrance.clone(), door.access.clone(), &config.host, config.propagation, limits);
    let world = match &config.saved {
        Some(saved) => World::load(config.world.clone(), saved)?,
        None => World::new(config.world.clone(), config.options),
    };
    let mut site = site(&config, &door, &addresses, limits, channels, entrance.clone());
    let subscribers = subscribers(&config, &world, foxglove, &mut site)?;
    let server = Server {
        rules: Rules {
            dialect: None,
            access: door.access.clone(),
            world_control: config.world_control,
            is_league: config.world.is_contest(),
            stall_timeout: config.stall_timeout,
            budgets: door.budgets.clone(),
        },
        page: Page::new(Arc::new(site), limits.pages),
        gate: gate.map(Arc::new),
        pictures: Pictures::new(board, config.image_kind, config.image_legacy),
        registry: Registry::new(network.clone(), limits.links, config.stall_timeout),
        network,
        stall_timeout: config.stall_timeout,
        entrance,
        limits,
        door,
    };
    let world = thread::spawn(config, world, server.door.budgets.clone(), events, live, subscribers, gone)?;
    let mut clients: Vec<(Service, JoinSet<()>)> =
        bound.iter().map(|(service, _)| (*service, JoinSet::new())).collect();
    let ports = clients.iter_mut().zip(bound);
    let ports = ports.map(|((_, clients), (service, listener))| server.serve_port(service, listener, clients));
    let serve = async {
        ready(addresses);
        join_all(ports).await;
        // Without a port it waits as well.
        std::future::pending().await
    };
    let is_gone = tokio::select! {
        // The first poll of `shutdown` sets up its signal handlers, so it comes before others hear that the server is ready.
        biased;
        () = shutdown => false,
        _ = &mut world_gone => true,
        () = serve => false,
    };
    if !is_gone {
        // The world may have ended by now.
        server.entrance.stop();
        let _ = world_gone.await;
    }
    // The world has closed every outbox; clients that read still get their last lines.
    let farewell = async {
        for (service, clients) in &mut clients {
            while matches!(service, Service::Controllers { .. }) && clients.join_next().await.is_some() {}
        }
    };
    let _ = tokio::time::timeout(FAREWELL_TIMEOUT, farewell).await;
    for (_, clients) in &mut clients {
        clients.shutdown().await;
    }
    world.join().map_err(|_| ServeError::WorldStopped)?
}

/// Lists the subscribers of the world, beside its log and its viewers. The page leads to the node of ROS 2.
fn subscribers(
    config: &Config,
    world: &World,
    foxglove: Option<FoxgloveServer>,
    #[cfg_attr(not(feature = "ros2"), expect(unused_variables, reason = "it leads to ROS 2 alone"))] site: &mut Site,
) -> Result<Vec<Box<dyn Subscriber>>, ServeError> {
    let mut list: Vec<Box<dyn Subscriber>> =
        vec![Box::new(Journal::of(world)), Box::new(Results::new(config.result.clone()))];
    if let Some(at) = config.panic_at {
        list.insert(0, Box::new(Defect { at }));
    }
    if config.pictures {
        list.push(Box::new(Shots::default()));
    }
    if let Some(foxglove) = foxglove {
        list.push(Box::new(foxglove));
    }
    #[cfg(feature = "ros2")]
    if let Some(options) = &config.ros2 {
        let may_control = match config.world_control {
            WorldControl::Everyone => true,
            WorldControl::Local => options.dds.as_ref().is_none_or(|dds| dds.address.is_loopback()),
            WorldControl::Nobody => false,
        };
        let maps = config.maps.list();
        let options = ros2::Options { may_control, maps, ..options.clone() };
        let is_open = options.rosbridge;
        let (feed, rosbridge) = ros2::start(options, world.options().speed_unit, site.entrance.clone())?;
        site.rosbridge = Some(rosbridge).filter(|_| is_open);
        list.push(Box::new(feed));
    }
    Ok(list)
}

/// State that the ports share.
struct Server {
    door: Door,
    limits: Limits,
    rules: Rules,
    entrance: Entrance,
    page: Page,
    /// The gate before Foxglove's server, if it is served.
    gate: Option<Arc<Gate>>,
    pictures: Pictures,
    network: Network,
    registry: Registry,
    /// Time after which a client that reads nothing is disconnected.
    stall_timeout: Duration,
}

/// The world ends with the ports, even if a program still has a way into it.
impl Drop for Server {
    fn drop(&mut self) {
        self.entrance.stop();
    }
}

impl Server {
    /// Serves a port until the future is dropped: the table of services.
    async fn serve_port(&self, service: Service, listener: TcpListener, clients: &mut JoinSet<()>) {
        let Self { limits, stall_timeout, .. } = self;
        let stall = *stall_timeout;
        let wait = Limit::Waiting;
        match service {
            Service::Controllers { dialect } => {
                let serve = |accepted| {
                    let rules = Rules { dialect, ..self.rules.clone() };
                    controllers::serve(accepted, rules, self.entrance.clone())
                };
                let logins = LoginQueue::new(self.door.clone(), &[Role::Driver, Role::Referee], true);
                accept_logins(clients, listener, Limit::Refusing(limits.controllers), logins, serve).await;
            }
            Service::Page => {
                let serve = |visitor| self.page.clone().serve(visitor);
                let next = async |listener: &TcpListener| self.door.room.accept(listener).await;
                accept::accept(clients, listener, Limit::Elsewhere, next, serve).await;
            }
            Service::Foxglove => {
                let Some(gate) = &self.gate else { return };
                let serve = |visitor| gate.clone().serve(visitor);
                let next = async |listener: &TcpListener| self.door.room.accept(listener).await;
                accept::accept(clients, listener, Limit::Elsewhere, next, serve).await;
            }
            Service::Truth => {
                let serve = |accepted| truth::converse(self.entrance.guest(Kind::Truth), accepted, stall);
                accept_logins(clients, listener, wait(limits.truth), self.logins(&[Role::Viewer]), serve).await;
            }
            Service::Positions => {
                let serve = |accepted| positions::converse(self.entrance.guest(Kind::Positions), accepted, stall);
                accept_logins(clients, listener, wait(limits.positions), self.logins(&[Role::Viewer]), serve).await;
            }
            Service::Images => {
                let serve = |accepted| images::converse(self.pictures.clone(), accepted, stall);
                let logins = self.logins(&[Role::Viewer, Role::Driver]);
                accept_logins(clients, listener, wait(limits.images), logins, serve).await;
            }
            Service::Wireless => {
                let serve = |accepted| wireless::converse(self.network.clone(), accepted, stall);
                let logins = self.logins(&[Role::Driver]);
                let accepting = accept_logins(clients, listener, wait(limits.radio), logins, serve);
                tokio::join!(accepting, self.network.clone().watch());
            }
            Service::ComServer => {
                let serve = |accepted| com_server::converse(self.registry.clone(), accepted);
                let logins = self.logins(&[Role::Driver]);
                accept_logins(clients, listener, wait(limits.com_server), logins, serve).await;
            }
        }
    }

    fn logins(&self, wanted: &'static [Role]) -> LoginQueue {
        LoginQueue::new(self.door.clone(), wanted, false)
    }
}

/// Accepts clients that have logged in.
async fn accept_logins<S: Future<Output = ()> + Send + 'static>(
    clients: &mut JoinSet<()>,
    listener: TcpListener,
    limit: Limit,
    mut logins: LoginQueue,
    serve: impl Fn(Accepted) -> S,
) {
    accept::accept(clients, listener, limit, async |listener| logins.accept(listener).await, serve).await;
}

/// Collects the state that the page's handlers share.
fn site(
    config: &Config,
    door: &Door,
    addresses: &Ready,
    limits: Limits,
    channels: Channels,
    entrance: Entrance,
) -> Site {
    // Without controllers the page cannot drive: nothing listens at this address, and its WebSocket reports that.
    let protocol = addresses.controllers().unwrap_or_else(|| SocketAddr::from((Ipv4Addr::LOCALHOST, 0)));
    Site {
        host: config.host.clone(),
        protocol: reachable(protocol),
        channels,
        inquiry: entrance.guest(Kind::Http),
        entrance,
        stall_timeout: config.stall_timeout,
        world_control: config.world_control,
        access: door.access.clone(),
        limits: limits.named(),
        packed: Packed::default(),
        classes: ClassPages::new(&config.world.robots),
        scenarios: ScenarioPages::new(config.scenarios.clone(), &config.world),
        maps: MapPictures::new(config.maps.clone(), &config.world),
        opener: config
            .open
            .clone()
            .map(|open| Opener::new(open, config.maps.clone(), config.world.robots.clone(), config.world.is_contest())),
        pages: AtomicU64::new(0),
        framing: Framing::Nobody,
        #[cfg(feature = "ros2")]
        rosbridge: None,
    }
}

/// Collects the server's settings that the page shows beside the world.
fn about(config: &Config, addresses: &Ready) -> About {
    About {
        seed: config.options.seed,
        time_step: config.options.time_step,
        port: addresses.controllers().map_or(0, |address| address.port()),
        maps: config.maps.list(),
    }
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
