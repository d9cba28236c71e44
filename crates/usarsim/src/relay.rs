//! `usarsim relay`.

use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use serde_json::json;
use tokio::io::{AsyncWriteExt, copy_bidirectional};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::Semaphore;

use crate::connect::OwnToken;
use crate::signal::stop_signal;
use crate::{Failure, exit, print};

/// Options of `relay`.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  USARSIM_TOKEN=.. usarsim relay 192.168.1.7:3000\n  \
    USARSIM_TOKEN=.. usarsim relay 192.168.1.7:5003 --port 5003    # pictures\n\n\
    A controller connects to this machine as if the server ran here. Each of its connections becomes one to the server, with \
    `LOGIN {Token ..}` before its first line. Everybody who reaches the port has the token's rights, so it is on this machine alone \
    unless --host says otherwise. It runs until Ctrl-C or SIGTERM.")]
pub(crate) struct Arguments {
    /// The server's port.
    #[arg(value_name = "HOST:PORT")]
    to: String,
    /// Address to listen on.
    #[arg(long, default_value = "127.0.0.1")]
    host: String,
    /// Port to listen on; 0 takes a free one.
    #[arg(long, default_value_t = 3000)]
    port: u16,
    #[command(flatten)]
    token: OwnToken,
    /// Print the ready line as JSON.
    #[arg(long)]
    json: bool,
}

/// Most connections at once; more wait.
const MAX_CONNECTIONS: usize = 64;
/// Pause after an error of accept, which would otherwise recur at once.
const BACK_OFF: Duration = Duration::from_millis(100);

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { to, host, port, token, json } = arguments;
    let Some(login) = token.login() else {
        return Err(Failure::new(exit::USAGE, "no token: expected --token, or the variable USARSIM_TOKEN"));
    };
    let failed = |error: std::io::Error| Failure::new(exit::UNAVAILABLE, format_args!("{host}:{port}: {error}"));
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(failed)?;
    runtime.block_on(async {
        let listener = TcpListener::bind((host.as_str(), *port)).await.map_err(failed)?;
        let address = listener.local_addr().map_err(failed)?;
        let relay = async {
            print(ready_line(address, to, *json));
            accept(listener, to, &login).await;
        };
        tokio::select! {
            // Its first poll sets up the signal handlers, so it comes before the ready line.
            biased;
            () = stop_signal() => {}
            () = relay => {}
        }
        Ok(())
    })
}

fn ready_line(address: SocketAddr, to: &str, json: bool) -> String {
    if json {
        let (host, port) = (address.ip().to_string(), address.port());
        return json!({ "event": "ready", "host": host, "port": port, "to": to }).to_string();
    }
    format!("usarsim relays {address} to {to}")
}

async fn accept(listener: TcpListener, to: &str, login: &str) {
    let (places, to, login): (_, Arc<str>, Arc<str>) =
        (Arc::new(Semaphore::new(MAX_CONNECTIONS)), to.into(), login.into());
    // The semaphore is never closed.
    while let Ok(place) = places.clone().acquire_owned().await {
        match listener.accept().await {
            Ok((client, peer)) => {
                let (to, login) = (to.clone(), login.clone());
                tokio::spawn(async move {
                    match carry(client, &to, &login).await {
                        Ok(()) => tracing::info!(%peer, "relayed to its end"),
                        Err(error) => tracing::warn!(%peer, to = &*to, %error, "the relay broke"),
                    }
                    drop(place);
                });
            }
            Err(error) => {
                tracing::warn!(%error, "cannot accept a client");
                tokio::time::sleep(BACK_OFF).await;
            }
        }
    }
}

/// Logs in and carries bytes both ways, until both ends have closed.
async fn carry(mut client: TcpStream, to: &str, login: &str) -> std::io::Result<()> {
    let mut server = TcpStream::connect(to).await?;
    client.set_nodelay(true)?;
    server.set_nodelay(true)?;
    server.write_all(format!("{login}\r\n").as_bytes()).await?;
    copy_bidirectional(&mut client, &mut server).await.map(|_| ())
}
