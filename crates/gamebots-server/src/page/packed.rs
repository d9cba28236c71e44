//! Answers of JSON, and long ones packed once for all pages: they are numbers, of which a network carries a quarter.

use axum::body::Bytes;
use axum::http::{HeaderMap, HeaderValue, header};
use axum::response::{IntoResponse, Response};
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
        let packed = spawn_blocking(move || pack(&given, Compression::fast())).await.ok().flatten()?;
        *known = Some((body, packed.clone()));
        Some(packed)
    }

    /// Returns an answer of JSON, in its packed form if the client takes that.
    pub(crate) async fn answer(&self, headers: &HeaderMap, body: Bytes) -> Response {
        let packed = if takes_gzip(headers) { self.of(body.clone()).await } else { None };
        answer(headers, body, packed)
    }
}

/// Returns an answer of JSON, in its packed form if there is one and the client takes that.
pub(crate) fn answer(headers: &HeaderMap, body: Bytes, packed: Option<Bytes>) -> Response {
    let Some(packed) = packed.filter(|_| takes_gzip(headers)) else { return json(body) };
    named_packed(json(packed))
}

/// Says that the body of an answer is packed.
pub(crate) fn named_packed(mut answer: Response) -> Response {
    answer.headers_mut().insert(header::CONTENT_ENCODING, HeaderValue::from_static("gzip"));
    answer
}

/// Returns an answer of JSON, which is not kept.
pub(crate) fn json(body: Bytes) -> Response {
    ([(header::CONTENT_TYPE, "application/json"), (header::CACHE_CONTROL, "no-store")], body).into_response()
}

/// Returns a body in its packed form: fast for what changes, well for what stays.
pub(crate) fn pack(body: &[u8], how: Compression) -> Option<Bytes> {
    let mut packer = GzEncoder::new(Vec::new(), how);
    packer.write_all(body).ok()?;
    packer.finish().ok().map(Bytes::from)
}

/// True if a client takes packed answers.
pub(crate) fn takes_gzip(headers: &HeaderMap) -> bool {
    let kinds = headers.get(header::ACCEPT_ENCODING).and_then(|value| value.to_str().ok()).unwrap_or_default();
    kinds.split(',').any(|kind| kind.trim().eq_ignore_ascii_case("gzip"))
}
