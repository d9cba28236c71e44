//! The files of the page, built into the program. Without them, a page that says how to get them.

use axum::http::{StatusCode, Uri, header};
use axum::response::{Html, IntoResponse, Response};
use include_dir::{Dir, include_dir};

/// Output of `npm run build`, if it ran before this program was built, and the page that replaces it.
static FILES: Dir = include_dir!("$CARGO_MANIFEST_DIR/../../viewer/dist");

pub(crate) async fn file(uri: Uri) -> Response {
    let path = match uri.path().trim_start_matches('/') {
        "" => "index.html",
        path => path,
    };
    let Some(file) = FILES.get_file(format!("page/{path}")) else {
        let missing = FILES.get_file("missing.html").filter(|_| path == "index.html");
        return match missing.and_then(include_dir::File::contents_utf8) {
            Some(missing) => Html(missing).into_response(),
            None => (StatusCode::NOT_FOUND, format!("nothing is at /{path}\n")).into_response(),
        };
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
    ([(header::CONTENT_TYPE, kind), (header::CACHE_CONTROL, keep)], file.contents()).into_response()
}
