//! Serves a world to Gamebots clients: the only crate with sockets and a clock.
//!
//! ```text
//! socket -> connection (bytes to commands) --Event, one a client--> world thread (`served_world`)
//!                ^                                                       |
//!                +------------------- outbox (bounded) <-----------------+
//! ```
//!
//! One thread owns the world and turns the loop of `served_world`. Connections are tasks that move bytes and read lines. No client can
//! hold up the world or another client.

// This crate is the first to see input from strangers.
#![warn(clippy::indexing_slicing, clippy::string_slice, clippy::expect_used)]
#![cfg_attr(test, allow(clippy::indexing_slicing, clippy::string_slice, clippy::expect_used))]

mod access;
mod config;
mod door;
mod error;
mod files;
mod maps;
mod page;
mod ports;
mod run;
mod scenarios;
mod subscribers;
mod world;

pub use access::rights::WorldControl;
pub use access::tokens::{Tokens, TokensError};
pub use config::{Config, IfTaken, ImageKind, Listener, Propagation, Ready, Service};
pub use error::ServeError;
pub use maps::{AvailableMap, Maps};
pub use page::opener::{NotOpened, Open, OpenFiles, Opened, Thing};
pub use page::view::{Moment, View};
pub use page_protocol::check_real_time_factor;
pub use page_protocol::pb as viewer_messages;
pub use ports::playback::{Playback, play};
pub use scenarios::{AvailableScenario, Scenarios};
pub use served_world::{Ended, Entrance, Session};
pub use world::saves::{SavedFileError, read_saved};

/// Entry points to the handling of strangers' requests, for the fuzz targets.
#[doc(hidden)]
pub mod fuzzing {
    use std::time::Instant;

    use axum::http::{HeaderMap, HeaderValue, header};
    use page_protocol::{Control, Request};
    use served_world::Pace;
    use sim_core::World;

    /// Reads a request of a viewer or of Foxglove. For a speed, computes the wait for an hour of simulated time.
    pub fn control(text: &str) {
        if let Ok(Control::Speed(speed)) = Control::read(text) {
            Pace::new(speed, Instant::now(), 0.0).wait(Instant::now(), 3600.0);
        }
    }

    /// Answers a question about room for a robot. Returns true if the robot can stand there; `None` if the text is no such question.
    pub fn fit(text: &str, world: &mut World) -> Option<bool> {
        let Ok(Request::Fit(wanted)) = Request::read(text) else { return None };
        serde_json::to_value(served_world::fit(wanted, world)).ok()?.get("stands")?.as_bool()
    }

    /// True if a client with these headers gets the page; false if one of them is not a valid header.
    pub fn accepts(host: &[u8], origins: &[&[u8]], own_name: &str) -> bool {
        let headers =
            std::iter::once((header::HOST, host)).chain(origins.iter().map(|origin| (header::ORIGIN, *origin)));
        let headers = headers.map(|(name, value)| HeaderValue::from_bytes(value).map(|value| (name, value)));
        let headers = headers.collect::<Result<HeaderMap, _>>();
        headers.is_ok_and(|headers| crate::access::origin::check(&headers, own_name, |_| false).is_ok())
    }
}

/// Serves until `shutdown` completes. `ready` is called once with the addresses, when clients can connect.
///
/// # Errors
/// When serving cannot start, or the world stops by itself.
pub fn run(config: Config, ready: impl FnOnce(Ready), shutdown: impl Future<Output = ()>) -> Result<(), ServeError> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(ServeError::Start)?;
    runtime.block_on(run::serve(config, ready, shutdown))
}
