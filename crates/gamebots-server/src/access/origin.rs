//! Origin of HTTP requests.
//!
//! A foreign page in the same browser must not get in. So a WebSocket's `Origin` must be the page's own host. `Host` must be an address or a
//! name that no stranger can point here (DNS rebinding).

use std::net::IpAddr;

use axum::http::uri::Authority;
use axum::http::{HeaderMap, Uri, header};

/// Returns the token of a request, if it has one.
pub(crate) fn bearer(headers: &HeaderMap) -> Option<&str> {
    let (scheme, token) = headers.get(header::AUTHORIZATION)?.to_str().ok()?.split_once(' ')?;
    scheme.eq_ignore_ascii_case("Bearer").then(|| token.trim())
}

/// Returns the token of a request: in its address, as in `/rosbridge?token=..`, or in a header.
pub(crate) fn token<'a>(address: &'a str, headers: &'a HeaderMap) -> Option<&'a str> {
    let query = address.split_once('?').map_or("", |(_, query)| query);
    query.split('&').find_map(|pair| pair.strip_prefix("token=")).or_else(|| bearer(headers))
}

/// True for pages that this machine serves, and programs that are not a page of a site.
pub(crate) fn is_local(origin: &str) -> bool {
    let Ok(uri) = origin.parse::<Uri>() else { return false };
    let host = uri.host().unwrap_or_default();
    // The parser takes anything after a colon for a port.
    let port = uri.port_u16().map(|port| format!(":{port}")).unwrap_or_default();
    if uri.authority().is_some_and(|authority| authority.as_str() != format!("{host}{port}")) {
        return false;
    }
    let host = host.trim_matches(['[', ']']);
    match uri.scheme_str() {
        Some("http" | "https") => host == "localhost" || host.parse::<IpAddr>().is_ok_and(|ip| ip.is_loopback()),
        // A page that hides its origin sends `null`.
        scheme => scheme.is_some(),
    }
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
    use axum::http::HeaderValue;

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
