//! Requests of browsers and Foxglove.

use std::cell::RefCell;

use gamebots_server::fuzzing;
use scene::WorldDef;
use sim_core::{Options, World};

thread_local! {
    /// A hall without robots. Questions do not change it.
    static HALL: RefCell<World> = RefCell::new(World::new(hall(), Options::default()));
}

fn hall() -> WorldDef {
    scene_loader::load("hall", &[]).expect("a built-in map")
}

/// Lines: a request, the name given by `--host`, and the headers `Host` and `Origin`, the latter any number of times.
///
/// Accepted requests can be done, questions about room have one answer and change nothing, and only pages of this server get in.
pub fn requests(bytes: &[u8]) {
    let mut lines = bytes.split(|&byte| byte == b'\n');
    let mut next = || lines.next().unwrap_or_default();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let request = text(next());
    fuzzing::control(&request);
    HALL.with_borrow_mut(|hall| {
        let before = hall.digest();
        let first = fuzzing::fit(&request, hall);
        assert_eq!(first, fuzzing::fit(&request, hall), "the same question has two answers");
        assert_eq!(hall.digest(), before, "a question changes the world");
    });
    let (own_name, host) = (text(next()), next());
    let origins: Vec<&[u8]> = lines.collect();
    if fuzzing::accepts(host, &origins, &own_name) {
        let own = |origin: &[u8]| origin.to_ascii_lowercase().ends_with(&host.to_ascii_lowercase());
        assert!(origins.len() <= 1 && origins.iter().all(|origin| own(origin)), "{host:?} {origins:?}");
        assert!(fuzzing::accepts(host, &[], &own_name), "{host:?} {origins:?}");
    }
}
