//! Configuration of a server: its services, their ports, and what is recorded.

use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::Duration;

use gamebots_proto::Dialect;
use scene::WorldDef;
use served_world::Entrance;
use sim_core::{Options, SavedWorld};
use thread_pool::ThreadPool;

use crate::access::rights::WorldControl;
use crate::access::tokens::Tokens;
use crate::maps::Maps;
use crate::page::opener::Open;
use crate::scenarios::Scenarios;

/// Configuration of a server.
#[derive(Debug, Clone)]
pub struct Config {
    /// The world.
    pub world: WorldDef,
    /// The state of that world to go on with; none for a new one. Its options replace those below.
    pub saved: Option<SavedWorld>,
    /// The maps that a viewer may change to.
    pub maps: Maps,
    /// The scenarios that a viewer may begin.
    pub scenarios: Scenarios,
    /// Reader of the files of other programs that pages bring; without one they are refused.
    pub open: Option<Open>,
    /// Seed and units.
    pub options: Options,
    /// Address to listen on.
    pub host: String,
    /// Services, and the ports that they are served on.
    pub listeners: Vec<Listener>,
    /// Simulated seconds per real second; 0 is as fast as possible.
    pub real_time_factor: f64,
    /// Listening for controllers pauses while there are more connections than this.
    pub max_connections: usize,
    /// True to tell clients what was wrong with their lines, which USARSim does not.
    pub report_errors: bool,
    /// File of the log; it gets a number if the file exists.
    pub log: Option<PathBuf>,
    /// True to write ROS 2 messages as well, to `run.ros2.mcap` beside `run.mcap`.
    pub ros2_log: bool,
    /// True to record what robots' cameras see.
    pub pictures: bool,
    /// File of logs that a viewer starts; it gets a number if the file exists.
    pub unnamed_log: PathBuf,
    /// Time after which a client that reads nothing is disconnected.
    pub stall_timeout: Duration,
    /// File of the results of a league; it gets a number if the file exists.
    pub result: Option<PathBuf>,
    /// Clients that may control the world over the page and Foxglove.
    pub world_control: WorldControl,
    /// Tokens of those who may watch, drive and control; none if everybody may.
    pub tokens: Option<Tokens>,
    /// Model of the radio between robots.
    pub propagation: Propagation,
    /// Kind of the image server's pictures.
    pub image_kind: ImageKind,
    /// True if the image server sends the first picture unasked.
    pub image_legacy: bool,
    /// Node of ROS 2; none by default.
    #[cfg(feature = "ros2")]
    pub ros2: Option<ros2::Options>,
    /// Simulated time at which the world's thread panics, s, to test the report of a defect.
    pub panic_at: Option<f64>,
    /// Threads that move robots that do not touch, and compute sensor readings.
    pub threads: ThreadPool,
}

impl Config {
    /// Creates a configuration with the defaults of USARSim: port 3000 on this machine, real time, 64 connections.
    pub fn new(world: WorldDef) -> Self {
        Self {
            saved: None,
            maps: Maps::default(),
            scenarios: Scenarios::default(),
            open: None,
            #[cfg(feature = "ros2")]
            ros2: None,
            panic_at: None,
            options: Options::default(),
            host: "127.0.0.1".to_owned(),
            listeners: vec![Listener::new(Service::Controllers { dialect: None }, 3000)],
            real_time_factor: 1.0,
            max_connections: 64,
            report_errors: false,
            log: None,
            ros2_log: false,
            pictures: false,
            unnamed_log: PathBuf::from(format!("usarsim-{}.mcap", world.map.name)),
            stall_timeout: Duration::from_secs(30),
            result: None,
            world_control: WorldControl::Everyone,
            tokens: None,
            propagation: Propagation::default(),
            image_kind: ImageKind::default(),
            image_legacy: false,
            threads: ThreadPool::one(),
            world,
        }
    }
}

/// A port and the service on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Listener {
    /// The service.
    pub service: Service,
    /// The port; 0 takes a free one.
    pub port: u16,
    /// Way out if another program has the port.
    pub if_taken: IfTaken,
}

/// Way out for a server when another program has a port.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum IfTaken {
    /// It does not start.
    Fail,
    /// It uses a free port.
    Another,
    /// It leaves the service out, with a warning.
    LeaveOut,
}

impl Listener {
    /// Creates a listener on exactly this port, or on a free one for 0.
    pub fn new(service: Service, port: u16) -> Self {
        Self { service, port, if_taken: IfTaken::Fail }
    }
}

/// A service for clients.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Service {
    /// The protocol of USARSim, for controllers.
    Controllers {
        /// The dialect of all lines; if none, the robot's class decides.
        dialect: Option<Dialect>,
    },
    /// The page with the 3-D view, for browsers.
    Page,
    /// The channels of a log, for Foxglove.
    Foxglove,
    /// Poses of pawns and objects, for referees (USARTruth.uc).
    Truth,
    /// Robots and the obstacles between them, for wireless simulators (ComServerInterface.uc).
    Positions,
    /// Pictures of cameras (ImageServer.cpp).
    Images,
    /// The radio between robots (WSS).
    Wireless,
    /// The old relay between robots (ComServer.uc).
    ComServer,
}

/// Ways into a server that is ready.
#[derive(Clone)]
pub struct Ready {
    /// Its services and their addresses, in the order of its configuration.
    pub addresses: Vec<(Service, SocketAddr)>,
    /// The way of programs in this process, which need no socket.
    pub entrance: Entrance,
}

impl Ready {
    /// Returns the address for controllers.
    pub fn controllers(&self) -> Option<SocketAddr> {
        self.address(|service| matches!(service, Service::Controllers { .. }))
    }

    /// Returns the address of a service.
    pub fn of(&self, service: Service) -> Option<SocketAddr> {
        self.address(|other| other == service)
    }

    fn address(&self, is: impl Fn(Service) -> bool) -> Option<SocketAddr> {
        self.addresses.iter().find(|(service, _)| is(*service)).map(|(_, address)| *address)
    }
}

/// Kinds of pictures, with the numbers of ImageServer.cpp.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ImageKind {
    /// Blue, green and red of each pixel.
    #[default]
    Raw,
    /// JPEG of quality 100.
    Super,
    /// JPEG of quality 75.
    Good,
    /// JPEG of quality 50.
    Normal,
    /// JPEG of quality 25.
    Fair,
    /// JPEG of quality 10.
    Bad,
}

/// Models of the propagation of radio.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Propagation {
    /// Every link holds.
    #[default]
    Everywhere,
    /// Signals weaken with the logarithm of the distance.
    Distance,
    /// Walls weaken them, too.
    Walls,
}
