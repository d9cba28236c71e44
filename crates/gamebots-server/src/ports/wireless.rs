//! The port of the wireless simulator: robots reach each other over it, as far as their radios would (USARTools/WSS).
//!
//! A robot registers a name and the ports at which it listens. Another one asks for the strength of their link, and for a port of this
//! server, whose connections are relayed to the robot while the link holds. Names are those of INIT on the controllers' port.

use std::collections::BTreeMap;
use std::net::{IpAddr, SocketAddr};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use gamebots_proto::ports::{Strength, WirelessCommand, WirelessError, origin, registered, route, strength};
use gamebots_proto::{Framing, Problem};
use nalgebra::Point3;
use served_world::{Entrance, Inquiry, Kind, Question};
use tokio::io::{AsyncWriteExt, copy, split};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{Notify, watch};
use tokio::task::AbortHandle;
use tokio::time::{interval, timeout};
use tokio_io_timeout::TimeoutStream;
use tracing::{debug, warn};

use crate::access::login::Accepted;
use crate::access::rights::Access;
use crate::access::shares::{Share, Shares};
use crate::config::Propagation;
use crate::door::accept::BACK_OFF;
use crate::door::limits::Limits;
use crate::door::lines::{Conversation, Requests};

/// Time between two looks at the links (WSS: 1 s).
pub(crate) const LOOK: Duration = Duration::from_secs(1);
/// Time for the second direction of a relayed connection after the end of the first.
const LAST_WORDS: Duration = Duration::from_secs(10);

/// Strength at the reference distance, dBm, and that distance, m (DefaultUSAR.ini, section ComServer).
const AT_REFERENCE: f64 = -49.67;
const REFERENCE: f64 = 2.0;
/// Exponent of the loss over distance.
const EXPONENT: f64 = 1.0;
/// Strength below which a link breaks, dBm.
const CUTOFF: f64 = -93.0;
/// Loss by a wall, dBm.
const WALL: f64 = 6.325;

impl Propagation {
    /// Returns the strength of a signal over a distance, m, through a number of walls, dBm.
    fn strength(self, distance: f64, walls: usize) -> f64 {
        match self {
            Self::Everywhere => 0.0,
            Self::Distance => AT_REFERENCE - 10.0 * EXPONENT * (distance / REFERENCE).log10(),
            Self::Walls => Self::Distance.strength(distance, 0) - walls as f64 * WALL,
        }
    }

    /// True if a link of a strength holds. Without a place there is none, and only the model of walls breaks such a link.
    fn holds(self, strength: f64) -> bool {
        if strength.is_nan() { self != Self::Walls } else { strength >= CUTOFF }
    }
}

/// The robots on the radio.
#[derive(Clone)]
pub(crate) struct Network {
    shared: Arc<Mutex<State>>,
    /// Places for ports that robots are given, and for relayed connections.
    routes: Shares,
    relays: Shares,
    entrance: Entrance,
    access: Access,
    host: Arc<str>,
    model: Propagation,
}

#[derive(Default)]
struct State {
    members: BTreeMap<String, Member>,
    /// Ports given to robots: from a robot, to a port of another.
    routes: BTreeMap<(String, String, u16), Route>,
    /// Robots whose connections are relayed, by the port that their target sees.
    origins: BTreeMap<u16, String>,
}

/// A registered robot.
struct Member {
    address: IpAddr,
    ports: Vec<u16>,
    /// Ends its control connection.
    kick: Arc<Notify>,
}

/// A port given to a robot. Its task ends with it.
struct Route {
    port: u16,
    holds: watch::Sender<bool>,
    task: AbortHandle,
    _share: Share,
}

impl Drop for Route {
    fn drop(&mut self) {
        self.task.abort();
    }
}

/// Places of robots, by name, m, and true for an empty battery.
type Places = BTreeMap<String, ([f64; 3], bool)>;

impl Network {
    pub(crate) fn new(entrance: Entrance, access: Access, host: &str, model: Propagation, limits: Limits) -> Self {
        let (routes, relays) = (Shares::new(limits.routes), Shares::new(limits.relays));
        Self { shared: Arc::default(), routes, relays, entrance, access, host: host.into(), model }
    }

    /// Returns the strength of a signal between two robots, dBm, as [`Self::strength`] does.
    pub(crate) async fn strength_between(&self, one: &str, other: &str) -> Option<f64> {
        let inquiry = self.entrance.guest(Kind::Radio);
        let places = if self.model == Propagation::Everywhere { Places::new() } else { places(&inquiry).await? };
        self.strength(&inquiry, &places, one, other).await
    }

    /// True if a link between two robots holds.
    pub(crate) async fn reaches(&self, one: &str, other: &str) -> bool {
        self.strength_between(one, other).await.is_some_and(|strength| self.model.holds(strength))
    }

    fn state(&self) -> MutexGuard<'_, State> {
        self.shared.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Looks at the links once a second: breaks and restores them, and removes robots that have left the world. Never ends.
    pub(crate) async fn watch(self) {
        let inquiry = self.entrance.guest(Kind::Radio);
        let mut looks = interval(LOOK);
        loop {
            looks.tick().await;
            if self.model == Propagation::Everywhere || self.state().members.is_empty() {
                continue;
            }
            let Some(places) = places(&inquiry).await else { return };
            self.remove_lost(&places);
            let links: Vec<_> = self.state().routes.keys().cloned().collect();
            for link in links {
                let (from, to, _) = &link;
                let Some(strength) = self.strength(&inquiry, &places, from, to).await else { return };
                let holds = self.model.holds(strength);
                if let Some(route) = self.state().routes.get(&link) {
                    route.holds.send_if_modified(|before| std::mem::replace(before, holds) != holds);
                }
            }
        }
    }

    /// Ends the control connections of robots that the world does not have, or whose batteries are empty.
    fn remove_lost(&self, places: &Places) {
        if places.is_empty() && self.model == Propagation::Walls {
            return;
        }
        for (name, member) in &self.state().members {
            if places.get(name).is_none_or(|(_, is_empty)| *is_empty) {
                member.kick.notify_one();
            }
        }
    }

    /// Returns the strength of a signal between two robots, dBm; not a number if one has no place. `None` if the world has ended.
    async fn strength(&self, inquiry: &Inquiry, places: &Places, one: &str, other: &str) -> Option<f64> {
        if self.model == Propagation::Everywhere {
            return Some(0.0);
        }
        // The way is the same in both directions, to the last bit.
        let (one, other) = if one < other { (one, other) } else { (other, one) };
        let (Some((from, _)), Some((to, _))) = (places.get(one), places.get(other)) else { return Some(f64::NAN) };
        let distance = (Point3::from(*from) - Point3::from(*to)).norm();
        let walls = match self.model {
            Propagation::Walls => inquiry.ask(|answer| Question::Obstacles([*from, *to], answer)).await?,
            _ => 0,
        };
        Some(self.model.strength(distance, walls))
    }
}

/// Asks the world for the places of its robots.
async fn places(inquiry: &Inquiry) -> Option<Places> {
    let actors = inquiry.ask(Question::Actors).await?;
    Some(actors.places().collect())
}

/// Serves a robot's control connection until it leaves, is kicked or does not read.
pub(crate) async fn converse(network: Network, accepted: Accepted, stall_timeout: Duration) {
    let mut client = Conversation::new(accepted.stream, WholeLines(Framing::default()), stall_timeout);
    let mut robot = Robot { network, stall_timeout, address: accepted.peer.ip(), name: None, kick: Arc::default() };
    let kick = robot.kick.clone();
    let answering = async {
        while let Some(lines) = client.next().await {
            for line in lines.into_iter().flatten() {
                let Some(answer) = robot.answer(&line).await else { return };
                if !client.send(answer.as_bytes()).await {
                    return;
                }
            }
        }
    };
    tokio::select! {
        () = answering => {}
        () = kick.notified() => {}
    }
}

/// Lines with their ends. A last fragment is no request, so a client that is cut off registers nobody.
struct WholeLines(Framing);

impl Requests for WholeLines {
    type Request = Result<String, Problem>;

    fn push(&mut self, bytes: &[u8]) -> Vec<Self::Request> {
        self.0.push(bytes)
    }
}

/// The server's end of a control connection. With it the robot leaves the radio, and its relays end.
struct Robot {
    network: Network,
    /// Time after which a relay that is not read ends.
    stall_timeout: Duration,
    address: IpAddr,
    /// Its name, once it is registered.
    name: Option<String>,
    kick: Arc<Notify>,
}

impl Drop for Robot {
    fn drop(&mut self) {
        if let Some(name) = &self.name {
            let mut state = self.network.state();
            state.members.remove(name);
            state.routes.retain(|(from, to, _), _| from != name && to != name);
        }
    }
}

impl Robot {
    /// Answers a line. `None` if the world has ended.
    async fn answer(&mut self, line: &str) -> Option<String> {
        let command = WirelessCommand::read(line);
        let Some(name) = self.name.clone() else { return Some(self.register(command)) };
        Some(match command {
            WirelessCommand::Init { .. } | WirelessCommand::Unknown => WirelessError::Unknown.line(),
            WirelessCommand::Strength(other) | WirelessCommand::Dns { robot: other, .. } if other.is_empty() => {
                WirelessError::NoName.line()
            }
            WirelessCommand::Strength(other) => {
                let known = self.network.state().members.contains_key(&other);
                let found = match (known, other == name) {
                    (_, true) => Strength::ToSelf,
                    (false, _) => Strength::NoRobot,
                    (true, false) => Strength::Model(self.network.strength_between(&name, &other).await?),
                };
                strength(&other, found)
            }
            WirelessCommand::Dns { robot, port: Some(port) } => self.route(&name, &robot, port).await?,
            WirelessCommand::Dns { port: None, .. } | WirelessCommand::ReverseDns(None) => {
                WirelessError::PortOfLine.line()
            }
            WirelessCommand::ReverseDns(Some(port)) => {
                origin(port, self.network.state().origins.get(&port).map(String::as_str))
            }
        })
    }

    fn register(&mut self, command: WirelessCommand) -> String {
        let WirelessCommand::Init { robot, ports } = command else { return WirelessError::InitFirst.line() };
        let Some(ports) = ports else { return WirelessError::PortsOfInit.line() };
        if robot.is_empty() {
            return WirelessError::NoName.line();
        }
        let mut state = self.network.state();
        if state.members.contains_key(&robot) {
            return WirelessError::Taken.line();
        }
        let member = Member { address: self.address, ports, kick: self.kick.clone() };
        state.members.insert(robot.clone(), member);
        self.name = Some(robot);
        registered()
    }

    /// Answers DNS: gives the robot a port from which it reaches a port of another one. It keeps it.
    async fn route(&mut self, name: &str, other: &str, port: u16) -> Option<String> {
        let (target, known) = {
            let state = self.network.state();
            let member = state.members.get(other).filter(|_| other != name);
            let Some(member) = member else { return Some(route(other, Err("NoSuchRobot"))) };
            let wanted = if port == 0 { member.ports.first().copied() } else { Some(port) };
            let Some(port) = wanted.filter(|port| member.ports.contains(port)) else {
                return Some(route(other, Err("RobotDoesNotListenOnThisPort")));
            };
            let key = (name.to_owned(), other.to_owned(), port);
            let known = state.routes.get(&key).map(|route| route.port);
            (SocketAddr::new(member.address, port), known.ok_or(key))
        };
        let key = match known {
            Ok(port) => return Some(route(other, Ok(port))),
            Err(key) => key,
        };
        let Some(share) = self.network.routes.take(self.address) else { return Some(WirelessError::NoPort.line()) };
        let bound = TcpListener::bind((&*self.network.host, 0)).await;
        let Some((bound, address)) = bound.ok().and_then(|bound| bound.local_addr().ok().map(|it| (bound, it))) else {
            return Some(WirelessError::NoPort.line());
        };
        let strength = self.network.strength_between(name, other).await?;
        let (holds, link) = watch::channel(self.network.model.holds(strength));
        let (network, from) = (self.network.clone(), name.to_owned());
        let stall_timeout = self.stall_timeout;
        let relay = Relay { network, from, address: self.address, target, link, stall_timeout };
        let task = tokio::spawn(relay.serve(bound, address)).abort_handle();
        self.network.state().routes.insert(key, Route { port: address.port(), holds, task, _share: share });
        Some(route(other, Ok(address.port())))
    }
}

/// A port that leads to a port of another robot.
#[derive(Clone)]
struct Relay {
    network: Network,
    from: String,
    /// Address of the robot that asked.
    address: IpAddr,
    target: SocketAddr,
    /// True while the link holds. It is closed when either robot leaves the radio.
    link: watch::Receiver<bool>,
    /// Time after which a connection that is not read ends.
    stall_timeout: Duration,
}

impl Relay {
    /// Accepts connections while the link holds. While it is broken the port refuses them.
    async fn serve(mut self, bound: TcpListener, address: SocketAddr) {
        let mut listener = Some(bound);
        loop {
            let holds = *self.link.borrow_and_update();
            if !holds {
                listener = None;
            } else if listener.is_none() {
                listener = TcpListener::bind(address).await.ok();
            }
            let accept = async {
                match &listener {
                    Some(listener) => listener.accept().await.ok(),
                    None if holds => None,
                    None => std::future::pending().await,
                }
            };
            tokio::select! {
                changed = self.link.changed() => if changed.is_err() { return },
                accepted = accept => match accepted {
                    // With tokens the port is for the robot that asked.
                    Some((_, peer)) if !self.network.access.is_open() && peer.ip() != self.address => {}
                    Some((stream, _)) => match self.network.relays.take(self.address) {
                        Some(share) => {
                            let relay = self.clone();
                            tokio::spawn(async move {
                                let _share = share;
                                relay.carry(stream).await;
                            });
                        }
                        None => debug!(from = self.from, "too many relayed connections: one is closed"),
                    },
                    None => {
                        warn!(%address, "a port of the wireless simulator cannot be had now");
                        tokio::time::sleep(BACK_OFF).await;
                    }
                },
            }
        }
    }

    /// Carries the bytes of a connection both ways until either end closes it or does not read, or the link ends.
    async fn carry(mut self, stream: TcpStream) {
        let Ok(target) = TcpStream::connect(self.target).await else {
            debug!(target = %self.target, "a robot does not listen");
            return;
        };
        let _ = (stream.set_nodelay(true), target.set_nodelay(true));
        let Ok(seen) = target.local_addr().map(|address| address.port()) else { return };
        self.network.state().origins.insert(seen, self.from.clone());
        let impatient = |stream| {
            let mut stream = TimeoutStream::new(stream);
            stream.set_write_timeout(Some(self.stall_timeout));
            split(Box::pin(stream))
        };
        let ((mut read, mut write), (mut its_read, mut its_write)) = (impatient(stream), impatient(target));
        let there = async {
            let _ = copy(&mut read, &mut its_write).await;
            let _ = its_write.shutdown().await;
        };
        let back = async {
            let _ = copy(&mut its_read, &mut write).await;
            let _ = write.shutdown().await;
        };
        tokio::pin!(there, back);
        // A robot that leaves the radio closes the channel.
        let broken = async { _ = self.link.wait_for(|holds| !holds).await };
        tokio::select! {
            () = &mut there => { let _ = timeout(LAST_WORDS, back).await; }
            () = &mut back => { let _ = timeout(LAST_WORDS, there).await; }
            () = broken => {}
        }
        self.network.state().origins.remove(&seen);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The numbers are those of the original's formula with its defaults.
    #[test]
    fn signals_weaken_with_distance_and_walls() {
        let rows = [
            (Propagation::Everywhere, 1e9, 100, 0.0, true),
            (Propagation::Distance, 2.0, 3, -49.67, true),
            (Propagation::Distance, 5.0, 0, -53.6494, true),
            (Propagation::Distance, 10.0, 0, -56.6597, true),
            (Propagation::Distance, 43_057.0, 0, -93.0001, false),
            (Propagation::Walls, 10.0, 5, -88.2847, true),
            (Propagation::Walls, 10.0, 6, -94.6097, false),
        ];
        for (model, distance, walls, expected, holds) in rows {
            let strength = model.strength(distance, walls);
            assert!((strength - expected).abs() < 1e-4, "{model:?} {distance} {walls}: {strength}");
            assert_eq!(model.holds(strength), holds, "{model:?} {distance} {walls}");
        }
        assert_eq!(Propagation::Distance.strength(0.0, 0), f64::INFINITY);
        assert!(Propagation::Distance.holds(f64::NAN) && !Propagation::Walls.holds(f64::NAN));
    }
}
