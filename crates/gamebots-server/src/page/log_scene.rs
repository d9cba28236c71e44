//! The scene of a log as JSON. The page sends the scene and the classes from the log's metadata and gets back the scene to draw. So pages
//! draw old logs too, and no formula exists twice.

use std::sync::Arc;
use std::time::Duration;

use axum::Extension;
use axum::body::{Body, Bytes, to_bytes};
use axum::http::{HeaderMap, StatusCode, header};
use axum::response::{IntoResponse, Response};
use page_protocol::scene_json;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::task::spawn_blocking;
use tokio::time::timeout;

use crate::page::packed::json;

/// Most bytes of a scene: a map of 500 000 triangles. The largest shipped map has 100 kB.
const MAX_BYTES: usize = 32 << 20;
/// Most scenes at once, from their first byte to the last of the answer: each may take some 100 MB.
const MAX_AT_ONCE: usize = 2;
/// Longest time for a scene to arrive, and for its wait for a free place.
const PATIENCE: Duration = Duration::from_secs(30);

/// A limit of scenes that are worked out at once.
#[derive(Clone)]
pub(crate) struct Worker(Arc<Semaphore>);

impl Default for Worker {
    fn default() -> Self {
        Self(Arc::new(Semaphore::new(MAX_AT_ONCE)))
    }
}

/// An answer that keeps its place until it is sent. An answer that nobody reads must not free a place for the next.
struct Answer(String, #[expect(dead_code, reason = "held")] OwnedSemaphorePermit);

impl AsRef<[u8]> for Answer {
    fn as_ref(&self) -> &[u8] {
        self.0.as_bytes()
    }
}

pub(crate) async fn answer(Extension(Worker(places)): Extension<Worker>, headers: HeaderMap, body: Body) -> Response {
    match work(places, &headers, body).await {
        Ok(answer) => json(Bytes::from_owner(answer)),
        Err((status, reason)) => (status, format!("{reason}\n")).into_response(),
    }
}

async fn work(places: Arc<Semaphore>, headers: &HeaderMap, body: Body) -> Result<Answer, (StatusCode, String)> {
    let length = headers.get(header::CONTENT_LENGTH).and_then(|length| length.to_str().ok()?.parse::<u64>().ok());
    let too_large = |what: String| {
        (StatusCode::PAYLOAD_TOO_LARGE, format!("the scene: {what}: expected at most {MAX_BYTES} bytes"))
    };
    if let Some(length) = length.filter(|length| *length > MAX_BYTES as u64) {
        return Err(too_large(format!("{length} bytes")));
    }
    let busy =
        |_| (StatusCode::SERVICE_UNAVAILABLE, "the scenes of other logs are being worked out: try again".to_owned());
    let place = timeout(PATIENCE, places.acquire_owned()).await.map_err(busy)?;
    let closed = |_| (StatusCode::SERVICE_UNAVAILABLE, "the server ends".to_owned());
    let place = place.map_err(closed)?;
    let slow =
        |_| (StatusCode::REQUEST_TIMEOUT, format!("the scene has not come whole within {} s", PATIENCE.as_secs()));
    let scene = timeout(PATIENCE, to_bytes(body, MAX_BYTES)).await.map_err(slow)?;
    let scene = scene.map_err(|error| too_large(error.to_string()))?;
    let worked = spawn_blocking(move || {
        let world = recorder::scene(&scene)?;
        drop(scene);
        Ok(scene_json(&world, None))
    });
    // A panic would be a defect of the checks; it ends only this answer.
    let worked = worked.await.unwrap_or_else(|_| Err("a defect: its scene cannot be drawn".to_owned()));
    worked.map(|text| Answer(text, place)).map_err(|reason| (StatusCode::UNPROCESSABLE_ENTITY, reason))
}
