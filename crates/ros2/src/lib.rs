//! A served world as a node of ROS 2. Nothing of ROS is installed: DDS, the network of ROS 2, is the crate `rustdds`.
//!
//! [`start`] joins a domain and returns a [`Feed`], by which the world tells what happens. A thread of its own publishes it as the topics of
//! the crate `ros2-topics`, and gives the orders of other nodes to the world by its entrance, as programs in the server's process do. A slow
//! or dead node makes nobody wait: queues are bounded, and what finds no room is left out and counted.
//!
//! DDS runs in a process of its own with little memory ([`run_node`]), as forged packets can take all that it has. The server starts it again.
//!
//! DDS has no password. By default only this machine is spoken to, whatever the server's own address is.

mod cameras;
mod clock;
mod controller;
mod dds;
mod feed;
mod interfaces;
mod node;
mod operations;
mod orders;
mod pipe;
mod rosbridge;
mod services;
mod thread;

use std::ffi::OsString;
use std::net::Ipv4Addr;
use std::sync::Arc;

use scene::RobotDef;
use served_world::Entrance;
use tokio::sync::mpsc::channel;

pub use controller::ControllerFile;
pub use dds::run as run_node;
pub use feed::Feed;
pub use ros2_topics::{Controller, Namespaces};
pub use rosbridge::{LONGEST_TEXT, Listener, NodeEnded, Rosbridge, Speaker};

/// Greatest domain whose ports exist on every system.
pub const LAST_DOMAIN: u16 = 101;

/// Settings of DDS.
#[derive(Debug, Clone, PartialEq)]
pub struct Dds {
    /// The program of its process, with its arguments: it calls [`run_node`].
    pub program: Vec<OsString>,
    /// The domain (ROS_DOMAIN_ID), 0 to [`LAST_DOMAIN`].
    pub domain: u16,
    /// Address of this machine at which it speaks and listens. Anything but 127.0.0.1 lets other machines drive robots.
    pub address: Ipv4Addr,
}

/// Reader of the URDFs that are spawned by their texts.
#[derive(Clone)]
pub struct ReadRobot(pub Arc<ReadUrdf>);

/// The function of [`ReadRobot`]. It fails with the reason in words.
pub type ReadUrdf = dyn Fn(&str) -> Result<RobotDef, String> + Send + Sync;

impl std::fmt::Debug for ReadRobot {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("ReadRobot")
    }
}

/// Settings of the node.
#[derive(Debug, Clone)]
pub struct Options {
    /// DDS; `None` for clients of rosbridge alone.
    pub dds: Option<Dds>,
    /// True to let clients of rosbridge in, on the page's port.
    pub rosbridge: bool,
    /// Namespaces of robots.
    pub namespaces: Namespaces,
    /// True to publish `map` to `odom` from the truth, as a perfect localisation would.
    pub is_localised: bool,
    /// Controllers whose numbers count for robots of a class, by its name.
    pub controllers: Vec<(String, Controller)>,
    /// True if nodes may control the world: pause, reset, spawn.
    pub may_control: bool,
    /// Maps that the world can change to, with a sentence about each.
    pub maps: Vec<(String, String)>,
    /// Reader of robots; without one they are spawned by their classes alone.
    pub read_robot: Option<ReadRobot>,
}

impl Default for Options {
    /// A node that nobody reaches.
    fn default() -> Self {
        Self {
            dds: None,
            rosbridge: false,
            namespaces: Namespaces::default(),
            is_localised: false,
            controllers: Vec::new(),
            may_control: true,
            maps: Vec::new(),
            read_robot: None,
        }
    }
}

/// A node that cannot start.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    /// The domain cannot be joined.
    #[error("ROS 2: the domain cannot be joined: {0}")]
    Join(String),
    /// There is no thread for it.
    #[error("ROS 2: {0}")]
    Thread(#[from] std::io::Error),
}

/// Joins the domain of DDS, if there is one, and starts the thread of the node. `unit` is one wheel-speed unit of the protocol, rad/s.
/// Returns the world's end, and the entrance of clients of rosbridge.
///
/// # Errors
/// When the domain cannot be joined.
pub fn start(options: Options, unit: f64, entrance: Entrance) -> Result<(Feed, Rosbridge), StartError> {
    let (wanted, clock) = (feed::Wanted::default(), clock::Clock::default());
    let node = node::Node::join(options.dds.clone(), rosbridge::Hub::new(clock.clone()))?;
    let (items, received) = channel(feed::MOST_WAITING);
    let (rosbridge, said) = Rosbridge::new();
    let shared = thread::Shared { options, unit, entrance, wanted: wanted.clone(), clock: clock.clone() };
    let thread = std::thread::Builder::new()
        .name("ROS 2".to_owned())
        .spawn(move || thread::run(node, received, said, shared))?;
    Ok((Feed::new(items, thread, wanted, clock), rosbridge))
}
