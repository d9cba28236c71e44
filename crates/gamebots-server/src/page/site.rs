//! The page: static files, the scene of the world or of a log as JSON, and two WebSockets. One shows the world; the other leads
//! to the protocol's own port.
//!
//! A foreign page in the same browser must not get in. So a WebSocket's `Origin` must be the page's own host. `Host` must be an
//! address or a name that no stranger can point here (DNS rebinding). No CORS header is ever sent, and the page cannot be framed.

use std::net::{IpAddr, SocketAddr};
use std::sync::atomic::AtomicU64;
use std::sync::mpsc::Sender;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use axum::body::Bytes;
use axum::extract::{Request, State};
use axum::http::uri::Authority;
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use axum::routing::get;
use axum::{Extension, Router};
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{Notify, OwnedSemaphorePermit, Semaphore};
use tokio::task::JoinSet;
use tokio_io_timeout::TimeoutStream;
use tracing::debug;

use crate::WorldControl;
use crate::access::budget::Budget;
use crate::access::tokens::{Access, Role};
use crate::access::waiting_room::{Stay, WaitingRoom};
use crate::ports::controllers::Event;
use crate::ports::truth::{Inquiry, Question};
use crate::run::back_off;
use crate::subscribers::live::Channels;

use super::{file, log_scene, metrics, viewer, wire};
use crate::page::packed::Packed;

/// Longest time for the head of a request, and for a client to read its response.
const TIMEOUT: Duration = Duration::from_secs(10);

/// Pages that may frame the page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Framing {
    /// None: a frame could trick its user into driving.
    Nobody,
    /// Pages of this machine, such as notebooks. For a page that only shows.
    Local,
}

impl Framing {
    /// Returns the sources of `frame-ancestors` (Content Security Policy).
    fn ancestors(self) -> &'static str {
        match self {
            Self::Nobody => "'none'",
            Self::Local => "http://localhost:* http://127.0.0.1:* http://[::1]:* vscode-webview:",
        }
    }
}

/// State that the page's handlers share.
pub(crate) struct Site {
    /// The host name that the server was told to listen on.
    pub(crate) host: String,
    /// Address of the protocol's port.
    pub(crate) protocol: SocketAddr,
    pub(crate) channels: Channels,
    pub(crate) events: Sender<Event>,
    /// The way of all HTTP requests to the world.
    pub(crate) inquiry: Inquiry,
    /// Time after which a viewer that reads nothing is disconnected.
    pub(crate) stall_timeout: Duration,
    pub(crate) world_control: WorldControl,
    pub(crate) access: Access,
    pub(crate) room: WaitingRoom,
    /// Most connections of each kind.
    pub(crate) limits: Vec<(&'static str, usize)>,
    pub(crate) packed: Packed,
    /// Number of pages opened so far; it numbers the pages.
    pub(crate) pages: AtomicU64,
    pub(crate) framing: Framing,
}

/// A connection's stay: in the waiting room until it has shown that it may come in, then in one of the page's places. It is held while the
/// connection lives, also after it has become a WebSocket.
pub(crate) struct Visit {
    places: Arc<Semaphore>,
    state: Mutex<VisitState>,
    dropped: Arc<Notify>,
}

enum VisitState {
    Waiting(#[expect(dead_code, reason = "it leaves the room on drop")] Stay),
    Admitted(#[expect(dead_code, reason = "it is free again on drop")] OwnedSemaphorePermit),
}

impl Visit {
    fn new(places: Arc<Semaphore>, stay: Stay) -> Self {
        let dropped = stay.notify();
        Self { places, state: Mutex::new(VisitState::Waiting(stay)), dropped }
    }

    /// Gives the connection a place. Returns false if all are taken.
    pub(crate) fn admit(&self) -> bool {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        if let VisitState::Admitted(_) = *state {
            return true;
        }
        let place = self.places.clone().try_acquire_owned();
        place.map(|place| *state = VisitState::Admitted(place)).is_ok()
    }

    /// Completes when the waiting room drops the connection for another one.
    pub(crate) async fn dropped(&self) {
        self.dropped.notified().await;
    }
}

/// The ends of a page's connection.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Peer {
    pub(crate) address: IpAddr,
    /// The server's address.
    pub(crate) own: IpAddr,
}

/// Serves a number of connections at once until the future is dropped, WebSockets included.
pub(crate) async fn serve(listener: TcpListener, most: usize, site: Arc<Site>) {
    let for_viewers = middleware::from_fn_with_state(site.clone(), admit_viewer);
    let router = Router::new()
        .route("/scene.json", get(scene).post(log_scene::answer))
        .route("/objects.json", get(objects))
        .route("/league.json", get(league))
        .route_layer(for_viewers.clone())
        .route("/live", get(viewer::upgrade))
        .route("/wire", get(wire::upgrade))
        .fallback(file::file)
        .layer(middleware::from_fn_with_state(site.clone(), guard))
        .layer(Extension(log_scene::Worker::default()))
        .route("/metrics", get(metrics::metrics).route_layer(for_viewers))
        .route("/health", get(metrics::health))
        .with_state(site.clone());
    let (places, mut warnings) = (Arc::new(Semaphore::new(most)), Budget::default());
    let mut connections = JoinSet::new();
    loop {
        let accept = async {
            site.room.vacancy().await;
            listener.accept().await
        };
        tokio::select! {
            accepted = accept => match accepted {
                Ok((stream, peer)) => {
                    debug!(%peer, "connected");
                    let visit = Arc::new(Visit::new(places.clone(), site.room.enter(peer.ip())));
                    let own = stream.local_addr().unwrap_or(peer);
                    let peer = Peer { address: peer.ip(), own: own.ip() };
                    let router = router.clone().layer(Extension(visit.clone())).layer(Extension(peer));
                    connections.spawn(async move {
                        tokio::select! {
                            () = serve_connection(stream, router) => {}
                            () = visit.dropped() => {}
                        }
                    });
                }
                Err(error) => back_off(&error, &mut warnings).await,
            },
            Some(_) = connections.join_next() => {}
        }
    }
}

async fn serve_connection(stream: TcpStream, router: Router) {
    // Frames are small and must not wait for each other (Nagle's algorithm).
    let _ = stream.set_nodelay(true);
    let mut http = hyper::server::conn::http1::Builder::new();
    http.timer(TokioTimer::new()).header_read_timeout(TIMEOUT);
    let mut stream = TimeoutStream::new(stream);
    stream.set_write_timeout(Some(TIMEOUT));
    let stream = TokioIo::new(Box::pin(stream));
    let connection = http.serve_connection(stream, TowerToHyperService::new(router)).with_upgrades();
    if let Err(error) = connection.await {
        debug!(%error, "a viewer's connection ended");
    }
}

async fn scene(State(site): State<Arc<Site>>, headers: HeaderMap) -> Response {
    site.packed.answer(&headers, site.channels.scene(), json).await
}

/// Answers with the objects beside the map's.
async fn objects(State(site): State<Arc<Site>>) -> Response {
    json(site.channels.objects())
}

/// Answers with every team's points; `null` without a league.
async fn league(State(site): State<Arc<Site>>) -> Response {
    match site.inquiry.ask(Question::Standings).await {
        // Standings have only text and numbers, so serialization cannot fail.
        Some(standings) => json(serde_json::to_vec(&standings).unwrap_or_default().into()),
        None => StatusCode::SERVICE_UNAVAILABLE.into_response(),
    }
}

pub(crate) fn json(body: Bytes) -> Response {
    ([(header::CONTENT_TYPE, "application/json"), (header::CACHE_CONTROL, "no-store")], body).into_response()
}

/// Refuses requests without the token of a viewer, if the server has tokens: `Authorization: Bearer <token>`.
async fn admit_viewer(
    State(site): State<Arc<Site>>,
    Extension(visit): Extension<Arc<Visit>>,
    request: Request,
    next: Next,
) -> Response {
    match site.access.rights(bearer(request.headers()), &[Role::Viewer]) {
        Ok(_) if !visit.admit() => too_many(),
        Ok(_) => next.run(request).await,
        Err(refusal) => {
            let text = format!("{refusal}: expected `Authorization: Bearer <token>` with the role viewer\n");
            (StatusCode::UNAUTHORIZED, [(header::WWW_AUTHENTICATE, "Bearer")], text).into_response()
        }
    }
}

fn too_many() -> Response {
    let text = "too many pages are open: close one, or try again later\n";
    (StatusCode::SERVICE_UNAVAILABLE, [(header::RETRY_AFTER, "5")], text).into_response()
}

/// Returns the token of a request, if it has one.
pub(crate) fn bearer(headers: &HeaderMap) -> Option<&str> {
    let (scheme, token) = headers.get(header::AUTHORIZATION)?.to_str().ok()?.split_once(' ')?;
    scheme.eq_ignore_ascii_case("Bearer").then(|| token.trim())
}

/// Refuses foreign pages, and tells the browser to restrict this page to what it needs.
async fn guard(
    State(site): State<Arc<Site>>,
    Extension(visit): Extension<Arc<Visit>>,
    request: Request,
    next: Next,
) -> Response {
    if let Err(reason) = check(request.headers(), &site.host, |_| false) {
        return (StatusCode::FORBIDDEN, reason).into_response();
    }
    if site.access.is_open() && !visit.admit() {
        return too_many();
    }
    let mut response = next.run(request).await;
    let policy = format!(
        "default-src 'self'; connect-src 'self'; img-src 'self' data: blob:; style-src 'self' 'unsafe-inline'; \
         frame-ancestors {}; base-uri 'none'; form-action 'none'",
        site.framing.ancestors()
    );
    if let Ok(policy) = HeaderValue::from_str(&policy) {
        response.headers_mut().insert(header::CONTENT_SECURITY_POLICY, policy);
    }
    for (name, value) in [
        (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (header::REFERRER_POLICY, "no-referrer"),
        (header::HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
    ] {
        response.headers_mut().insert(name, HeaderValue::from_static(value));
    }
    response
}

/// Checks that a request is meant for this server, and comes from its own page or from a welcome origin.
///
/// # Errors
/// Describes the problem.
pub(crate) fn check(headers: &HeaderMap, own_name: &str, is_welcome: impl Fn(&str) -> bool) -> Result<(), String> {
    // A header that is not text or appears twice does not come from our page in a browser. It must not count as absent.
    let text = |name: header::HeaderName| -> Option<String> {
        let values: Vec<_> =
            headers.get_all(name).iter().map(|value| String::from_utf8_lossy(value.as_bytes())).collect();
        (!values.is_empty()).then(|| values.join(", "))
    };
    let shown = |text: &str| text.chars().take(100).collect::<String>();
    let host = text(header::HOST).unwrap_or_default();
    let known = host.parse::<Authority>().is_ok_and(|authority| {
        let name = authority.host().trim_start_matches('[').trim_end_matches(']').to_ascii_lowercase();
        name.parse::<IpAddr>().is_ok() || name == "localhost" || name == own_name.to_ascii_lowercase()
    });
    if !known {
        return Err(format!(
            "Host is `{}`: expected localhost, an address, or the name given by --host\n",
            shown(&host)
        ));
    }
    let Some(origin) = text(header::ORIGIN) else { return Ok(()) };
    let own = origin.strip_prefix("http://").or(origin.strip_prefix("https://"));
    if own.is_some_and(|own| own.eq_ignore_ascii_case(&host)) || is_welcome(&origin) {
        return Ok(());
    }
    Err(format!("Origin is `{}`: expected a page of this server, http://{host}\n", shown(&origin)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_pages_of_this_server_get_in() {
        for (host, origin, own_name, good) in [
            ("localhost:8080", None, "127.0.0.1", true),
            ("127.0.0.1:8080", Some("http://127.0.0.1:8080"), "127.0.0.1", true),
            ("[::1]:8080", Some("http://[::1]:8080"), "::1", true),
            ("192.168.1.7:8080", Some("http://192.168.1.7:8080"), "0.0.0.0", true),
            ("lab-3:8080", Some("http://lab-3:8080"), "LAB-3", true),
            ("localhost:8080", Some("https://localhost:8080"), "127.0.0.1", true),
            ("localhost:8080", Some("http://evil.example"), "127.0.0.1", false),
            ("localhost:8080", Some("http://localhost:9000"), "127.0.0.1", false),
            ("localhost:8080", Some("http://localhost:8080.evil.example"), "127.0.0.1", false),
            ("localhost:8080", Some("null"), "127.0.0.1", false),
            ("rebound.example:8080", None, "127.0.0.1", false),
            ("rebound.example:8080", Some("http://rebound.example:8080"), "0.0.0.0", false),
            ("127.0.0.1.nip.example", None, "127.0.0.1", false),
            ("", None, "127.0.0.1", false),
        ] {
            let mut headers = HeaderMap::new();
            headers.insert(header::HOST, HeaderValue::from_static(host));
            if let Some(origin) = origin {
                headers.insert(header::ORIGIN, HeaderValue::from_static(origin));
            }
            assert_eq!(check(&headers, own_name, |_| false).is_ok(), good, "{host} {origin:?} {own_name}");
        }
        assert!(check(&HeaderMap::new(), "127.0.0.1", |_| false).is_err());
    }

    #[test]
    fn an_origin_that_is_no_text_or_stands_there_twice_is_not_absent() {
        let mut headers = HeaderMap::new();
        headers.insert(header::HOST, HeaderValue::from_static("localhost:8080"));
        headers.insert(header::ORIGIN, HeaderValue::from_bytes(b"http://ev\xefl.example").unwrap());
        assert!(check(&headers, "127.0.0.1", |_| false).is_err());
        headers.insert(header::ORIGIN, HeaderValue::from_static("http://localhost:8080"));
        assert!(check(&headers, "127.0.0.1", |_| false).is_ok());
        headers.append(header::ORIGIN, HeaderValue::from_static("http://evil.example"));
        assert!(check(&headers, "127.0.0.1", |_| false).is_err());
    }
}
