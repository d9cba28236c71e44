//! The port of the old relay between robots (ComServer.uc): robots say where they wait, and the server connects to two of them.
//!
//! The original connected to any address that a client named. Here a client can name its own address alone, so that no stranger uses the
//! server to reach other machines. A client on the server's machine can name any address of that machine.

use std::collections::{BTreeSet, VecDeque};
use std::net::{IpAddr, Ipv4Addr, SocketAddr, UdpSocket};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use gamebots_proto::ports::{ComAnswer, ComCommand, ComFraming, ComLink};
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::net::tcp::{ReadHalf, WriteHalf};
use tokio::time::{interval, timeout};
use tracing::debug;

use crate::access::login::Accepted;
use crate::access::shares::Shares;
use crate::door::lines::Conversation;
use crate::ports::wireless::{LOOK, Network};

/// Most robots. One more replaces the oldest.
const MAX_ROBOTS: usize = 256;
/// Most ports of a robot.
const MAX_PORTS: usize = 16;
/// Longest name of a robot, bytes.
const MAX_NAME: usize = 64;
/// Longest time to connect to a robot.
const PATIENCE: Duration = Duration::from_secs(2);
/// Bytes read at once.
const READ_BYTES: usize = 4096;

/// The robots that are registered, and what joins them.
#[derive(Clone)]
pub(crate) struct Registry {
    robots: Arc<Mutex<VecDeque<Robot>>>,
    /// Places for joined connections.
    links: Shares,
    network: Network,
    stall_timeout: Duration,
}

struct Robot {
    name: String,
    /// Its address as it says it.
    ip: String,
    /// Address of the client that registered it.
    client: IpAddr,
    /// Ports at which it waits.
    ports: BTreeSet<u16>,
}

/// Answers a client until it leaves, speaks HTTP or does not read.
pub(crate) async fn converse(registry: Registry, accepted: Accepted) {
    let client = accepted.peer.ip();
    let mut conversation = Conversation::new(accepted.stream, ComFraming::default(), registry.stall_timeout);
    while let Some(commands) = conversation.next().await {
        for command in commands {
            let answer = registry.answer(&ComCommand::read(&command), client).await;
            if !conversation.send(answer.as_bytes()).await {
                return;
            }
        }
    }
}

impl Registry {
    /// Creates an empty registry, with places for so many joined connections.
    pub(crate) fn new(network: Network, links: usize, stall_timeout: Duration) -> Self {
        Self { robots: Arc::default(), links: Shares::new(links), network, stall_timeout }
    }

    fn robots(&self) -> MutexGuard<'_, VecDeque<Robot>> {
        self.robots.lock().unwrap_or_else(PoisonError::into_inner)
    }

    async fn answer(&self, command: &ComCommand, client: IpAddr) -> String {
        match command {
            ComCommand::Register { name, ip } => self.register(name, ip, client),
            ComCommand::Listen { name, port } => self.listen(name, *port, client),
            ComCommand::Open { name, port, other, other_port } => {
                self.open((name, *port), (other, *other_port), client).await
            }
            ComCommand::Strength([name, other]) => self.strength(name, other, client).await,
            ComCommand::Incorrect => ComAnswer::Incorrect,
            ComCommand::Unknown => ComAnswer::Unknown,
        }
        .text()
    }

    fn register<'a>(&self, name: &'a str, ip: &str, client: IpAddr) -> ComAnswer<'a> {
        if name.len() > MAX_NAME || ip.len() > MAX_NAME {
            return ComAnswer::Incorrect;
        }
        let mut robots = self.robots();
        match robots.iter().find(|robot| robot.name == name) {
            Some(robot) if robot.ip != ip => ComAnswer::Taken(name),
            Some(_) => ComAnswer::Done,
            None => {
                if robots.len() == MAX_ROBOTS {
                    robots.pop_front();
                }
                let (name, ip) = (name.to_owned(), ip.to_owned());
                robots.push_back(Robot { name, ip, client, ports: BTreeSet::new() });
                ComAnswer::Done
            }
        }
    }

    fn listen<'a>(&self, name: &'a str, port: u16, client: IpAddr) -> ComAnswer<'a> {
        let mut robots = self.robots();
        match robots.iter_mut().find(|robot| robot.name == name) {
            None => ComAnswer::NotRegistered(name),
            Some(robot) if robot.client != client => ComAnswer::ThirdParty,
            Some(robot) if robot.ports.contains(&port) => ComAnswer::Listening(name, port),
            Some(robot) => {
                if robot.ports.len() == MAX_PORTS {
                    robot.ports.pop_first();
                }
                robot.ports.insert(port);
                ComAnswer::Done
            }
        }
    }

    /// Returns where to connect to for a robot; `None` if there is no such robot, or its address is not its client's.
    fn target(&self, (name, port): (&str, u16)) -> Option<SocketAddr> {
        let robots = self.robots();
        let robot = robots.iter().find(|robot| robot.name == name)?;
        let ip = match robot.ip.as_str() {
            "localhost" => Ipv4Addr::LOCALHOST.into(),
            ip => ip.parse::<IpAddr>().ok()?,
        };
        let client = robot.client.to_canonical();
        let is_own = ip.to_canonical() == client || client.is_loopback() && is_of_this_machine(ip);
        is_own.then(|| SocketAddr::new(ip, port))
    }

    /// Returns the address of the client that registered a robot.
    fn client(&self, name: &str) -> Option<IpAddr> {
        self.robots().iter().find(|robot| robot.name == name).map(|robot| robot.client)
    }

    async fn open<'a>(&self, one: (&'a str, u16), other: (&'a str, u16), client: IpAddr) -> ComAnswer<'a> {
        let waits = |robot: &Robot| robot.name == other.0 && robot.ports.contains(&other.1);
        if !self.robots().iter().any(waits) {
            return ComAnswer::NotListening(other.0, other.1);
        }
        if self.client(one.0).is_some_and(|owner| owner != client) {
            return ComAnswer::ThirdParty;
        }
        if !self.network.reaches(one.0, other.0).await {
            return ComAnswer::OutOfReach(other.0);
        }
        let (Some(from), Some(to)) = (self.target(one), self.target(other)) else { return ComAnswer::NoConnection };
        let Some(place) = self.links.take(client) else { return ComAnswer::NoConnection };
        let connect = |address| timeout(PATIENCE, TcpStream::connect(address));
        let (Ok(Ok(first)), Ok(Ok(second))) = tokio::join!(connect(from), connect(to)) else {
            return ComAnswer::NoConnection;
        };
        self.robots()
            .iter_mut()
            .filter(|robot| robot.name == other.0)
            .for_each(|robot| _ = robot.ports.remove(&other.1));
        let (network, stall_timeout) = (self.network.clone(), self.stall_timeout);
        let names = [one.0, other.0].map(str::to_owned);
        tokio::spawn(async move {
            let _place = place;
            join([first, second], &network, &names, stall_timeout).await;
            debug!(?names, "a connection between robots has ended");
        });
        ComAnswer::Done
    }

    async fn strength<'a>(&self, name: &'a str, other: &'a str, client: IpAddr) -> ComAnswer<'a> {
        if ![name, other].iter().any(|name| self.client(name) == Some(client)) {
            return ComAnswer::ThirdParty;
        }
        match self.network.strength_between(name, other).await {
            // The original has no model, and says so. A perfect signal is none of its answers either.
            Some(strength) if strength < 0.0 => ComAnswer::Strength(strength),
            _ => ComAnswer::NoStrength,
        }
    }
}

/// True if an address is one of this machine: only those can be bound.
fn is_of_this_machine(ip: IpAddr) -> bool {
    UdpSocket::bind((ip, 0)).is_ok()
}

/// Joins two robots until one closes, does not read, or is out of reach.
async fn join([mut one, mut other]: [TcpStream; 2], network: &Network, names: &[String; 2], stall_timeout: Duration) {
    let _ = (one.set_nodelay(true), other.set_nodelay(true));
    let ((read, write), (other_read, other_write)) = (one.split(), other.split());
    let out_of_reach = async {
        let mut looks = interval(LOOK);
        while network.reaches(&names[0], &names[1]).await {
            looks.tick().await;
        }
    };
    tokio::select! {
        () = pass_on(read, other_write, stall_timeout) => {}
        () = pass_on(other_read, write, stall_timeout) => {}
        () = out_of_reach => {}
    }
}

/// Passes on what one robot sends to the other.
async fn pass_on(mut read: ReadHalf<'_>, mut write: WriteHalf<'_>, stall_timeout: Duration) {
    let (mut link, mut buffer) = (ComLink::default(), vec![0; READ_BYTES]);
    while let Ok(count @ 1..) = read.read(&mut buffer).await {
        let (bytes, is_over) = link.push(buffer.get(..count).unwrap_or_default());
        let is_sent = matches!(timeout(stall_timeout, write.write_all(&bytes)).await, Ok(Ok(())));
        if is_over || !is_sent {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::access::rights::Access;
    use crate::config::{Config, Propagation};
    use crate::door::limits::limits;

    fn registry() -> Registry {
        let (entrance, _) = served_world::Entrance::new();
        let (limits, _) = limits(&Config::new(scene::WorldDef::default()));
        let network = Network::new(entrance, Access::new(None), "127.0.0.1", Propagation::Everywhere, limits);
        Registry::new(network, 4, PATIENCE)
    }

    #[test]
    fn a_client_cannot_send_the_server_to_another_machine() {
        let registry = registry();
        for (number, (ip, client, expected)) in [
            ("10.0.0.7", [10, 0, 0, 7], Some([10, 0, 0, 7])),
            ("10.0.0.8", [10, 0, 0, 7], None),
            ("127.0.0.1", [10, 0, 0, 7], None),
            ("localhost", [10, 0, 0, 7], None),
            ("printer.example", [10, 0, 0, 7], None),
            ("10.0.0.8", [127, 0, 0, 1], None),
            ("127.0.0.1", [127, 0, 0, 1], Some([127, 0, 0, 1])),
            ("localhost", [127, 0, 0, 1], Some([127, 0, 0, 1])),
        ]
        .into_iter()
        .enumerate()
        {
            let name = format!("R{number}");
            assert_eq!(registry.register(&name, ip, client.into()), ComAnswer::Done);
            let target = expected.map(|ip| SocketAddr::from((ip, 80)));
            assert_eq!(registry.target((&name, 80)), target, "{ip} from {client:?}");
        }
    }

    #[test]
    fn robots_and_ports_are_bounded() {
        let registry = registry();
        let here = IpAddr::from(Ipv4Addr::LOCALHOST);
        for number in 0..1000 {
            assert_eq!(registry.register(&number.to_string(), "localhost", here), ComAnswer::Done);
            assert_eq!(registry.listen("999", number, here) == ComAnswer::Done, number == 999);
        }
        (0..100).for_each(|port| assert_eq!(registry.listen("999", port, here), ComAnswer::Done));
        let robots = registry.robots();
        assert_eq!((robots.len(), robots.back().map(|robot| robot.ports.len())), (MAX_ROBOTS, Some(MAX_PORTS)));
        drop(robots);
        assert_eq!(registry.register(&"n".repeat(65), "localhost", here), ComAnswer::Incorrect);
    }
}
