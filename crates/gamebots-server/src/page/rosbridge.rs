//! rosbridge on the page's port: a WebSocket at `/rosbridge`, or at `/`, where its clients look without a path.

use std::sync::Arc;

use axum::Extension;
use axum::extract::State;
use axum::extract::ws::rejection::WebSocketUpgradeRejection;
use axum::extract::ws::{Message, WebSocket, WebSocketUpgrade};
use axum::http::{HeaderMap, StatusCode, Uri};
use axum::response::{IntoResponse, Response};
use ros2::{LONGEST_TEXT, Listener, NodeEnded, Rosbridge};
use tokio::time::timeout;

use crate::access::origin::token;
use crate::access::tokens::Role;
use crate::page::file;
use crate::page::shared::{Peer, Site, Visit};

/// Answers at `/`: a WebSocket is one of rosbridge, anything else gets the page.
pub(crate) async fn root(
    site: State<Arc<Site>>,
    visit: Extension<Arc<Visit>>,
    peer: Extension<Peer>,
    headers: HeaderMap,
    uri: Uri,
    socket: Result<WebSocketUpgrade, WebSocketUpgradeRejection>,
) -> Response {
    match socket {
        Ok(socket) => upgrade(site, visit, peer, headers, uri, socket).await,
        Err(_) => file::file(uri, headers).await,
    }
}

/// Answers at `/rosbridge`. With tokens, that of a driver or a referee is in the address, as in `ws://host:8080/rosbridge?token=..`, or in a
/// header.
pub(crate) async fn upgrade(
    State(site): State<Arc<Site>>,
    Extension(visit): Extension<Arc<Visit>>,
    Extension(peer): Extension<Peer>,
    headers: HeaderMap,
    uri: Uri,
    socket: WebSocketUpgrade,
) -> Response {
    let Some(rosbridge) = site.rosbridge.clone() else {
        return (StatusCode::NOT_FOUND, "no rosbridge here: `usarsim serve --rosbridge` has it\n").into_response();
    };
    let rights = match site.access.rights(token(&uri.to_string(), &headers), &[Role::Driver, Role::Referee]) {
        Ok(rights) => rights,
        Err(refusal) => {
            let text = format!("{refusal}: expected ?token=.. in the address, of the role driver or referee\n");
            return (StatusCode::UNAUTHORIZED, text).into_response();
        }
    };
    if !visit.admit() {
        return (StatusCode::SERVICE_UNAVAILABLE, "too many pages are open\n").into_response();
    }
    let may_control = site.access.refusal(&rights, site.world_control, peer.address, peer.own).is_none();
    socket.max_message_size(LONGEST_TEXT).on_upgrade(move |socket| async move {
        // Whoever leaves needs no farewell.
        let _ = converse(socket, &site, &rosbridge, may_control).await;
        drop(visit);
    })
}

async fn converse(
    mut socket: WebSocket,
    site: &Site,
    rosbridge: &Rosbridge,
    may_control: bool,
) -> Result<(), NodeEnded> {
    let (speaker, mut listener) = rosbridge.open(may_control).await?;
    while let Some(event) = next(&mut socket, &mut listener).await {
        match event {
            Event::Said(text) => {
                // A node that is asked much takes its time. Meanwhile this client hears nothing, so it cannot ask without reading.
                speaker.say(text).await?;
            }
            Event::Heard(text) => {
                let sent = timeout(site.stall_timeout, socket.send(Message::text(&*text))).await;
                if !matches!(sent, Ok(Ok(()))) {
                    break;
                }
            }
            Event::Other => {}
        }
    }
    Ok(())
}

enum Event {
    /// The client says a text.
    Said(String),
    /// The node has a text for it.
    Heard(Arc<str>),
    Other,
}

/// Waits for what happens next; `None` if either end has gone.
async fn next(socket: &mut WebSocket, listener: &mut Listener) -> Option<Event> {
    tokio::select! {
        text = listener.hear() => text.map(Event::Heard),
        message = socket.recv() => match message?.ok()? {
            Message::Text(text) => Some(Event::Said(text.to_string())),
            Message::Close(_) => None,
            Message::Binary(_) | Message::Ping(_) | Message::Pong(_) => Some(Event::Other),
        },
    }
}
