//! Serves a world to Gamebots clients: the only crate with sockets and a clock.
//!
//! ```text
//! socket -> connection (bytes to commands) --Event, one a client--> world thread (sessions, pacing, steps)
//!                ^                                                       |
//!                +------------------- outbox (bounded) <-----------------+
//! ```
//!
//! One thread owns the world and everything in it. Connections are tasks that move bytes and read lines. No client can hold up
//! the world or another client.

// This crate is the first to see input from strangers.
#![warn(clippy::indexing_slicing, clippy::string_slice, clippy::expect_used)]
#![cfg_attr(test, allow(clippy::indexing_slicing, clippy::string_slice, clippy::expect_used))]

mod access;
mod door;
mod messages;
mod page;
mod ports;
mod run;
mod subscribers;
mod world;

pub use access::tokens::{Tokens, TokensError};
pub use messages::control::{WorldControl, check_real_time_factor};
pub use messages::pb as viewer_messages;
pub use page::view::{Moment, View};
pub use ports::images::ImageKind;
pub use ports::playback::{Playback, play};
pub use ports::wireless::Propagation;
pub use world::saved::{SavedFileError, read_saved};

use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::Duration;

use gamebots_proto::Dialect;
use scene::{MapDef, WorldDef};
use sim_core::{Options, SavedWorld};
use thread_pool::ThreadPool;

/// Entry points to the handling of strangers' requests, for the fuzz targets.
#[doc(hidden)]
pub mod fuzzing {
    use std::time::Instant;

    use axum::http::{HeaderMap, HeaderValue, header};

    use sim_core::World;

    use crate::messages::control::Control;
    use crate::messages::fit::Ask;
    use crate::world::pace::Pace;

    /// Reads a request of a viewer or of Foxglove. For a speed, computes the wait for an hour of simulated time.
    pub fn control(text: &str) {
        if let Ok(Control::Speed(speed)) = Control::read(text) {
            Pace::new(speed, Instant::now(), 0.0).wait(Instant::now(), 3600.0);
        }
    }

    /// Answers a question about room for a robot. Returns true if the robot can stand there; `None` if the text is no such question.
    pub fn fit(text: &str, world: &mut World) -> Option<bool> {
        let fit = Ask::read(text)?.answer(world);
        serde_json::to_value(&fit).ok()?.get("stands")?.as_bool()
    }

    /// True if a client with these headers gets the page; false if one of them is not a valid header.
    pub fn accepts(host: &[u8], origins: &[&[u8]], own_name: &str) -> bool {
        let headers =
            std::iter::once((header::HOST, host)).chain(origins.iter().map(|origin| (header::ORIGIN, *origin)));
        let headers = headers.map(|(name, value)| HeaderValue::from_bytes(value).map(|value| (name, value)));
        let headers = headers.collect::<Result<HeaderMap, _>>();
        headers.is_ok_and(|headers| crate::page::site::check(&headers, own_name, |_| false).is_ok())
    }
}

/// Configuration of a server.
#[derive(Debug, Clone)]
pub struct Config {
    /// The world.
    pub world: WorldDef,
    /// The state of that world to go on with; none for a new one. Its options replace those below.
    pub saved: Option<SavedWorld>,
    /// The maps that a viewer may change to.
    pub maps: Vec<MapDef>,
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
    /// Threads that move robots that do not touch, and compute sensor readings.
    pub threads: ThreadPool,
}

impl Config {
    /// Creates a configuration with the defaults of USARSim: port 3000 on this machine, real time, 64 connections.
    pub fn new(world: WorldDef) -> Self {
        Self {
            saved: None,
            maps: Vec::new(),
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

/// Addresses of a server that is ready, with their services, in the order of its configuration.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ready(pub Vec<(Service, SocketAddr)>);

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
        self.0.iter().find(|(service, _)| is(*service)).map(|(_, address)| *address)
    }
}

/// The reason why serving did not start, or stopped by itself.
#[derive(Debug, thiserror::Error)]
pub enum ServeError {
    /// The server cannot listen on the address.
    #[error("cannot listen on {host}:{port}: {reason}; is another server running? Port 0 takes a free one")]
    Listen {
        /// The address.
        host: String,
        /// The port.
        port: u16,
        /// The operating system's error.
        reason: std::io::Error,
    },
    /// The log cannot be written.
    #[error(transparent)]
    Log(#[from] recorder::RecordError),
    /// The saved state does not fit the scene.
    #[error("the saved world: {0}")]
    Saved(#[from] sim_core::LoadError),
    /// The runtime or a thread cannot be started.
    #[error("cannot start: {0}")]
    Start(std::io::Error),
    /// The world's thread ended without a report.
    #[error("the world stopped unexpectedly")]
    WorldStopped,
    /// The world's thread panicked: a defect of this program.
    #[error("a defect: the world panicked at {time:.3} s: {reason}; {report}")]
    WorldPanicked {
        /// Simulated time, s.
        time: f64,
        /// The panic's message.
        reason: String,
        /// Path of the report, or the reason why there is none.
        report: String,
    },
}

/// Serves until `shutdown` completes. `ready` is called once with the addresses, when clients can connect.
///
/// # Errors
/// When serving cannot start, or the world stops by itself.
pub fn run(config: Config, ready: impl FnOnce(Ready), shutdown: impl Future<Output = ()>) -> Result<(), ServeError> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(ServeError::Start)?;
    runtime.block_on(run::serve(config, ready, shutdown))
}
