//! Playback of recorded lines to every client.

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};
use tokio::task::JoinSet;
use tokio::time::{Instant, sleep_until, timeout};
use tracing::info;

use crate::access::login::{Accepted, Door, LoginQueue};
use crate::access::tokens::{Role, Tokens};
use crate::door::accept::{Limit, accept};
use crate::error::ServeError;

/// Most clients at once; more wait until one leaves.
const MAX_CLIENTS: usize = 64;
/// Most clients that have not logged in.
const MAX_WAITING: usize = 64;
/// Time after which a client that reads nothing is disconnected.
const STALL_TIMEOUT: Duration = Duration::from_secs(30);

/// Latest time at which a line is sent, s: years, but within the clock's range.
const LONGEST_WAIT: f64 = 1e8;

/// A recording to play, and the address to serve it on.
#[derive(Debug, Clone)]
pub struct Playback {
    /// Host to listen on.
    pub host: String,
    /// Port to listen on; 0 takes a free one.
    pub port: u16,
    /// Recorded seconds per real second; 0 is as fast as possible.
    pub real_time_factor: f64,
    /// Lines without line ends, with the times of their recording, s, in order.
    pub lines: Vec<(f64, String)>,
    /// Tokens of those who may listen; none if everybody may.
    pub tokens: Option<Tokens>,
}

/// Plays from the beginning to each client until `shutdown` completes. Lines from clients are ignored. `ready` is called once
/// with the address.
///
/// # Errors
/// When the address cannot be listened on.
pub fn play(
    playback: Playback,
    ready: impl FnOnce(SocketAddr),
    shutdown: impl Future<Output = ()>,
) -> Result<(), ServeError> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(ServeError::Start)?;
    runtime.block_on(async {
        let Playback { host, port, real_time_factor, lines, tokens } = playback;
        let mut logins = LoginQueue::new(Door::new(tokens, MAX_WAITING), &[Role::Viewer], false);
        let failed = |reason| ServeError::Listen { host: host.clone(), port, reason };
        let listener = TcpListener::bind((host.as_str(), port)).await.map_err(failed)?;
        ready(listener.local_addr().map_err(failed)?);
        let lines: Arc<[(f64, String)]> = lines.into();
        let mut clients = JoinSet::new();
        let next = async |listener: &TcpListener| logins.accept(listener).await;
        let serve = |Accepted { stream, peer, .. }| {
            info!(%peer, "plays");
            let lines = lines.clone();
            async move { send(stream, &lines, real_time_factor).await }
        };
        tokio::select! {
            () = accept(&mut clients, listener, Limit::Waiting(MAX_CLIENTS), next, serve) => {}
            () = shutdown => {}
        }
        Ok(())
    })
}

/// Sends each line at its time, until the end or until the client leaves.
async fn send(stream: TcpStream, lines: &[(f64, String)], real_time_factor: f64) {
    let (mut reader, mut writer) = stream.into_split();
    let began = Instant::now();
    let first = lines.first().map_or(0.0, |(time, _)| *time);
    let sending = async {
        for (time, line) in lines {
            if real_time_factor > 0.0 {
                let seconds = ((time - first).max(0.0) / real_time_factor).min(LONGEST_WAIT);
                sleep_until(began + Duration::from_secs_f64(seconds)).await;
            }
            let line = format!("{line}\r\n");
            if !matches!(timeout(STALL_TIMEOUT, writer.write_all(line.as_bytes())).await, Ok(Ok(()))) {
                return;
            }
        }
        // An error means that the client has left: nothing is lost.
        let _ = writer.shutdown().await;
    };
    let mut unread = [0; 4096];
    // Commands to a recording have no effect.
    let left = async { while reader.read(&mut unread).await.is_ok_and(|count| count > 0) {} };
    tokio::select! {
        () = sending => {}
        () = left => {}
    }
}
