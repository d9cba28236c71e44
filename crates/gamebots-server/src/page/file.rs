//! The files of the page, built into the program. Without them, a page that says how to get them.

use std::collections::BTreeMap;
use std::path::Path;

use axum::body::Bytes;
use axum::http::{HeaderMap, StatusCode, Uri, header};
use axum::response::{IntoResponse, Response};
use flate2::Compression;
use include_dir::{Dir, File, include_dir};
use tokio::sync::Mutex;
use tokio::task::spawn_blocking;

use crate::page::packed::{named_packed, pack, takes_gzip};

/// Output of `npm run build`, if it ran before this program was built, and the page that replaces it.
static FILES: Dir = include_dir!("$CARGO_MANIFEST_DIR/../../viewer/dist");

/// Packed forms of files: a network carries a third of them. Each is packed when somebody first asks for it.
static PACKED: Mutex<BTreeMap<&Path, Bytes>> = Mutex::const_new(BTreeMap::new());

pub(crate) async fn file(uri: Uri, headers: HeaderMap) -> Response {
    let path = match uri.path().trim_start_matches('/') {
        "" => "index.html",
        path => path,
    };
    let missing = || FILES.get_file("missing.html").filter(|_| path == "index.html");
    let Some(file) = FILES.get_file(format!("page/{path}")).or_else(missing) else {
        return (StatusCode::NOT_FOUND, format!("nothing is at /{path}\n")).into_response();
    };
    let kind = match file.path().extension().and_then(|extension| extension.to_str()) {
        Some("html") => "text/html; charset=utf-8",
        Some("js") => "text/javascript; charset=utf-8",
        Some("css") => "text/css; charset=utf-8",
        Some("svg") => "image/svg+xml",
        Some("wasm") => "application/wasm",
        Some("woff2") => "font/woff2",
        Some("txt") => "text/plain; charset=utf-8",
        _ => "application/octet-stream",
    };
    // Names of built files contain a hash; the page's own name does not.
    let keep = if path.starts_with("assets/") { "public, max-age=31536000, immutable" } else { "no-cache" };
    let head = [(header::CONTENT_TYPE, kind), (header::CACHE_CONTROL, keep), (header::VARY, "accept-encoding")];
    let is_packed_already = matches!(kind, "font/woff2" | "application/octet-stream");
    let packed = if !is_packed_already && takes_gzip(&headers) { packed(file).await } else { None };
    match packed {
        Some(packed) => named_packed((head, packed).into_response()),
        None => (head, file.contents()).into_response(),
    }
}

async fn packed(file: &'static File<'static>) -> Option<Bytes> {
    let mut known = PACKED.lock().await;
    if let Some(packed) = known.get(file.path()) {
        return Some(packed.clone());
    }
    let packed = spawn_blocking(|| pack(file.contents(), Compression::default())).await.ok().flatten()?;
    known.insert(file.path(), packed.clone());
    Some(packed)
}
