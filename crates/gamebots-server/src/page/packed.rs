//! The scene, packed once for all pages: it is megabytes of numbers, of which a network carries a quarter.

use axum::body::Bytes;
use axum::http::{HeaderMap, HeaderValue, header};
use axum::response::Response;
use flate2::Compression;
use flate2::write::GzEncoder;
use std::io::Write;
use tokio::sync::Mutex;
use tokio::task::spawn_blocking;

/// The last body that was packed, and its packed form.
#[derive(Default)]
pub(crate) struct Packed(Mutex<Option<(Bytes, Bytes)>>);

impl Packed {
    /// Returns a body in its packed form. The first request after a change packs it, on another thread.
    async fn of(&self, body: Bytes) -> Option<Bytes> {
        let mut known = self.0.lock().await;
        if let Some((_, packed)) = known.as_ref().filter(|(of, _)| of.as_ptr() == body.as_ptr()) {
            return Some(packed.clone());
        }
        let given = body.clone();
        let packed = spawn_blocking(move || pack(&given)).await.ok().flatten()?;
        *known = Some((body, packed.clone()));
        Some(packed)
    }

    /// Replaces the body of an answer by its packed form, if the client takes that.
    pub(crate) async fn answer(&self, headers: &HeaderMap, body: Bytes, whole: impl Fn(Bytes) -> Response) -> Response {
        let packed = if takes_gzip(headers) { self.of(body.clone()).await } else { None };
        let Some(packed) = packed else { return whole(body) };
        let mut answer = whole(packed);
        answer.headers_mut().insert(header::CONTENT_ENCODING, HeaderValue::from_static("gzip"));
        answer
    }
}

fn pack(body: &[u8]) -> Option<Bytes> {
    let mut packer = GzEncoder::new(Vec::new(), Compression::fast());
    packer.write_all(body).ok()?;
    packer.finish().ok().map(Bytes::from)
}

fn takes_gzip(headers: &HeaderMap) -> bool {
    let kinds = headers.get(header::ACCEPT_ENCODING).and_then(|value| value.to_str().ok()).unwrap_or_default();
    kinds.split(',').any(|kind| kind.trim().eq_ignore_ascii_case("gzip"))
}
