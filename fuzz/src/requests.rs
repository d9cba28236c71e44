//! Requests of browsers and Foxglove.

use gamebots_server::fuzzing;

/// Lines: a request, the name given by `--host`, and the headers `Host` and `Origin`, the latter any number of times.
///
/// What is accepted can be done, and only pages of this server get in.
pub fn requests(bytes: &[u8]) {
    let mut lines = bytes.split(|&byte| byte == b'\n');
    let mut next = || lines.next().unwrap_or_default();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    fuzzing::control(&text(next()));
    let (own_name, host) = (text(next()), next());
    let origins: Vec<&[u8]> = lines.collect();
    if fuzzing::accepts(host, &origins, &own_name) {
        let own = |origin: &[u8]| origin.to_ascii_lowercase().ends_with(&host.to_ascii_lowercase());
        assert!(origins.len() <= 1 && origins.iter().all(|origin| own(origin)), "{host:?} {origins:?}");
        assert!(fuzzing::accepts(host, &[], &own_name), "{host:?} {origins:?}");
    }
}
