//! Serves a world to Gamebots clients: the only crate with sockets and a clock.
//!
//! ```text
//! socket -> connection (bytes to commands) --Event, one a client--> world thread (sessions, pacing, steps)
//!                ^                                                       |
//!                +------------------- outbox (bounded) <-----------------+
//! ```
//!
//! One thread owns the world and everything in it; connections are tasks that move bytes and read lines. Nothing a client does
//! or fails to do can hold up the world or another client.

// What strangers send gets here first.
#![warn(clippy::indexing_slicing, clippy::string_slice, clippy::expect_used)]
#![cfg_attr(test, allow(clippy::indexing_slicing, clippy::string_slice, clippy::expect_used))]

mod connection;
mod control;
mod fit;
mod foxglove_server;
mod journal;
mod listener;
mod live;
mod owners;
mod pace;
mod playback;
mod publisher;
mod recording;
mod session;
mod web;
mod world_thread;

pub use control::{WorldControl, check_real_time_factor};
pub use playback::{Playback, play};

use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::Duration;

use gamebots_proto::Dialect;
use scene::{MapDef, WorldDef};
use sim_core::Options;
use thread_pool::ThreadPool;

/// What strangers' requests go through, for the fuzz targets.
#[doc(hidden)]
pub mod fuzzing {
    use std::time::Instant;

    use axum::http::{HeaderMap, HeaderValue, header};

    use crate::control::Control;
    use crate::pace::Pace;

    /// A request of a viewer or of Foxglove; a speed is kept for an hour.
    pub fn control(text: &str) {
        if let Ok(Control::Speed(speed)) = Control::read(text) {
            Pace::new(speed, Instant::now(), 0.0).wait(Instant::now(), 3600.0);
        }
    }

    /// Whether the page is given to who sends these headers; not where one cannot be a header.
    pub fn accepts(host: &[u8], origins: &[&[u8]], own_name: &str) -> bool {
        let headers =
            std::iter::once((header::HOST, host)).chain(origins.iter().map(|origin| (header::ORIGIN, *origin)));
        let headers = headers.map(|(name, value)| HeaderValue::from_bytes(value).map(|value| (name, value)));
        let headers = headers.collect::<Result<HeaderMap, _>>();
        headers.is_ok_and(|headers| crate::web::check(&headers, own_name, |_| false).is_ok())
    }
}

/// What to serve and how.
#[derive(Debug, Clone)]
pub struct Config {
    /// The world.
    pub world: WorldDef,
    /// The maps that a viewer may change to.
    pub maps: Vec<MapDef>,
    /// Seed and units.
    pub options: Options,
    /// Address to listen on.
    pub host: String,
    /// What is served, and on which ports.
    pub listeners: Vec<Listener>,
    /// Simulated seconds a real second; 0 is as fast as possible.
    pub real_time_factor: f64,
    /// Listening for controllers pauses while there are more connections than this.
    pub max_connections: usize,
    /// Tell clients what was wrong with their lines, which USARSim does not.
    pub report_errors: bool,
    /// File of the log, numbered where it exists.
    pub log: Option<PathBuf>,
    /// Whether messages of ROS 2 are written as well, to `run.ros2.mcap` beside `run.mcap`.
    pub ros2_log: bool,
    /// File of the logs that a viewer begins, numbered where it exists.
    pub unnamed_log: PathBuf,
    /// A client that takes nothing for this long is disconnected.
    pub stall_timeout: Duration,
    /// Who may control the world over the page and Foxglove.
    pub world_control: WorldControl,
    /// Threads on which robots that do not touch are moved, and sensors measure.
    pub threads: ThreadPool,
}

impl Config {
    /// A world with the defaults of USARSim: port 3000 on this machine, real time, 64 connections.
    pub fn new(world: WorldDef) -> Self {
        Self {
            maps: Vec::new(),
            options: Options::default(),
            host: "127.0.0.1".to_owned(),
            listeners: vec![Listener::new(Service::Controllers { dialect: None }, 3000)],
            real_time_factor: 1.0,
            max_connections: 64,
            report_errors: false,
            log: None,
            ros2_log: false,
            unnamed_log: PathBuf::from(format!("usarsim-{}.mcap", world.map.name)),
            stall_timeout: Duration::from_secs(30),
            world_control: WorldControl::Everyone,
            threads: ThreadPool::one(),
            world,
        }
    }
}

/// A port and what is served there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Listener {
    /// What is served.
    pub service: Service,
    /// The port; 0 takes a free one.
    pub port: u16,
    /// Whether a free port is taken where another program has this one.
    pub or_another: bool,
}

impl Listener {
    /// A service on this very port, or on a free one for 0.
    pub fn new(service: Service, port: u16) -> Self {
        Self { service, port, or_another: false }
    }
}

/// What a server does for who connects.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Service {
    /// The protocol of USARSim, for controllers.
    Controllers {
        /// The dialect of all lines; without one, the class of a robot decides.
        dialect: Option<Dialect>,
    },
    /// The page with the 3-D view, for browsers.
    Page,
    /// The channels of a log, for Foxglove.
    Foxglove,
}

/// Where a server that is ready listens: what is served, in the order of its configuration.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ready(pub Vec<(Service, SocketAddr)>);

impl Ready {
    /// Where controllers connect.
    pub fn controllers(&self) -> Option<SocketAddr> {
        self.address(|service| matches!(service, Service::Controllers { .. }))
    }

    /// Where browsers do.
    pub fn page(&self) -> Option<SocketAddr> {
        self.address(|service| service == Service::Page)
    }

    /// Where Foxglove does.
    pub fn foxglove(&self) -> Option<SocketAddr> {
        self.address(|service| service == Service::Foxglove)
    }

    fn address(&self, is: impl Fn(Service) -> bool) -> Option<SocketAddr> {
        self.0.iter().find(|(service, _)| is(*service)).map(|(_, address)| *address)
    }
}

/// Why serving did not start, or stopped by itself.
#[derive(Debug, thiserror::Error)]
pub enum ServeError {
    /// The address cannot be listened on.
    #[error("cannot listen on {host}:{port}: {reason}; is another server running? Port 0 takes a free one")]
    Listen {
        /// The address.
        host: String,
        /// The port.
        port: u16,
        /// What the operating system says.
        reason: std::io::Error,
    },
    /// The log cannot be written.
    #[error(transparent)]
    Log(#[from] recorder::RecordError),
    /// The runtime or a thread cannot be started.
    #[error("cannot start: {0}")]
    Start(std::io::Error),
    /// The world's thread is gone without a word.
    #[error("the world stopped unexpectedly")]
    WorldStopped,
    /// The world's thread has panicked: a defect of this program.
    #[error("a defect: the world panicked at {time:.3} s: {reason}; {report}")]
    WorldPanicked {
        /// Simulated time, s.
        time: f64,
        /// The panic's message.
        reason: String,
        /// Where the report is, or why there is none.
        report: String,
    },
}

/// Serves until `shutdown` completes. `ready` is called once with the addresses, when clients can connect.
///
/// # Errors
/// When serving cannot start, or the world stops by itself.
pub fn run(config: Config, ready: impl FnOnce(Ready), shutdown: impl Future<Output = ()>) -> Result<(), ServeError> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(ServeError::Start)?;
    runtime.block_on(listener::serve(config, ready, shutdown))
}
