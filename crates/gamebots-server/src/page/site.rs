//! The page: static files, the scene of the world or of a log and classes of robots as JSON, and WebSockets. One shows the world; one leads
//! to the protocol's own port; one is of rosbridge.
//!
//! Requests of foreign pages are refused ([`crate::access::origin`]). No CORS header is ever sent, and the page cannot be framed.

use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;

use axum::body::Body;
use axum::extract::{DefaultBodyLimit, Path, Request, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use axum::{Extension, Router};
use futures_util::stream;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use served_world::Question;
use tokio::net::TcpStream;
use tokio::sync::Semaphore;
use tokio_io_timeout::TimeoutStream;
use tracing::debug;

use crate::access::origin::{bearer, check, is_local};
use crate::access::tokens::Role;
use crate::access::waiting_room::Visitor;
use crate::page::packed::json;
use crate::page::shared::{Peer, Site, Visit};
use crate::page::{file, log_scene, metrics, open, viewer, wire};

/// Longest time for the head of a request, and for a client to read its response.
const TIMEOUT: Duration = Duration::from_secs(10);

/// The page of a server: its routes, and places for its connections.
#[derive(Clone)]
pub(crate) struct Page {
    router: Router,
    places: Arc<Semaphore>,
}

impl Page {
    /// Creates the page with so many connections at once, WebSockets included.
    pub(crate) fn new(site: Arc<Site>, most: usize) -> Self {
        let for_viewers = middleware::from_fn_with_state(site.clone(), admit_viewer);
        let router = Router::new()
            .route("/scene.json", get(scene).post(log_scene::answer))
            .route("/class/{name}", get(class))
            .route("/objects.json", get(objects))
            .route("/past", get(past))
            .route("/map/{name}/picture.png", get(map_picture))
            .route("/league.json", get(league))
            .route("/scenarios.json", get(scenarios))
            .route("/scenario/{name}/demo.mcap", get(demo))
            .route_layer(for_viewers.clone())
            .route("/scenario/{name}/picture.jpg", get(picture))
            .route("/live", get(viewer::upgrade))
            .route("/wire", get(wire::upgrade))
            .route("/open", post(open::answer).layer(DefaultBodyLimit::max(open::MAX_BYTES)));
        #[cfg(feature = "ros2")]
        let router = router
            .route("/", get(crate::page::rosbridge::root))
            .route("/rosbridge", get(crate::page::rosbridge::upgrade));
        let router = router
            .fallback(file::file)
            .layer(middleware::from_fn_with_state(site.clone(), guard))
            .layer(Extension(log_scene::Worker::default()))
            .route("/metrics", get(metrics::metrics).route_layer(for_viewers))
            .route("/health", get(metrics::health))
            .with_state(site);
        Self { router, places: Arc::new(Semaphore::new(most)) }
    }

    /// Serves a connection until it ends or loses its place.
    pub(crate) async fn serve(self, Visitor { stream, peer, stay }: Visitor) {
        let visit = Arc::new(Visit::new(self.places, stay));
        let own = stream.local_addr().unwrap_or(peer);
        let peer = Peer { address: peer.ip(), own: own.ip() };
        let router = self.router.layer(Extension(visit.clone())).layer(Extension(peer));
        tokio::select! {
            () = serve_connection(stream, router) => {}
            () = visit.dropped() => {}
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
    site.packed.answer(&headers, site.channels.scene()).await
}

async fn class(State(site): State<Arc<Site>>, Path(name): Path<String>, headers: HeaderMap) -> Response {
    site.classes.answer(&name, &headers).await
}

/// Answers with the objects beside the map's.
async fn objects(State(site): State<Arc<Site>>) -> Response {
    json(site.channels.objects())
}

/// Answers with frames of the run so far. All answers share their bytes.
async fn past(State(site): State<Arc<Site>>) -> Response {
    let parts = site.channels.past().into_iter().map(Ok::<_, Infallible>);
    let body = Body::from_stream(stream::iter(parts));
    ([(header::CONTENT_TYPE, "application/x-protobuf"), (header::CACHE_CONTROL, "no-store")], body).into_response()
}

async fn map_picture(State(site): State<Arc<Site>>, Path(name): Path<String>) -> Response {
    site.maps.answer(&name).await
}

async fn scenarios(State(site): State<Arc<Site>>) -> Response {
    site.scenarios.list()
}

async fn picture(State(site): State<Arc<Site>>, Path(name): Path<String>) -> Response {
    site.scenarios.picture(&name)
}

async fn demo(State(site): State<Arc<Site>>, Path(name): Path<String>) -> Response {
    site.scenarios.demo(&name).await
}

/// Answers with every team's points; `null` without a league.
async fn league(State(site): State<Arc<Site>>) -> Response {
    match site.inquiry.ask(Question::Standings).await {
        // Standings have only text and numbers, so serialization cannot fail.
        Some(standings) => json(serde_json::to_vec(&standings).unwrap_or_default().into()),
        None => StatusCode::SERVICE_UNAVAILABLE.into_response(),
    }
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

/// Refuses foreign pages, but lets those of this machine talk by rosbridge, and tells the browser to restrict this page to what it needs.
async fn guard(
    State(site): State<Arc<Site>>,
    Extension(visit): Extension<Arc<Visit>>,
    request: Request,
    next: Next,
) -> Response {
    let is_rosbridge = match request.uri().path() {
        "/rosbridge" => true,
        "/" => request.headers().contains_key(header::UPGRADE),
        _ => false,
    };
    if let Err(reason) = check(request.headers(), &site.host, |origin| is_rosbridge && is_local(origin)) {
        return (StatusCode::FORBIDDEN, reason).into_response();
    }
    if site.access.is_open() && !visit.admit() {
        return too_many();
    }
    let mut response = next.run(request).await;
    // A program of the page runs in MicroPython, which is WebAssembly.
    let policy = format!(
        "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; connect-src 'self'; img-src 'self' data: blob:; \
         style-src 'self' 'unsafe-inline'; frame-ancestors {}; base-uri 'none'; form-action 'none'",
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
