//! Limits of connections. Together they need no more descriptors than the process may have, so that no service can lock out another.

use crate::config::{Config, Service};

/// Descriptors for everything that is no client's connection: listeners, logs, saves, standard streams and the runtime.
const RESERVED: u64 = 96;
#[cfg(not(unix))]
/// Descriptors if the operating system does not tell its limit.
const USUAL_DESCRIPTORS: u64 = 1024;

/// Most connections of each kind at once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Limits {
    /// Controllers. As in USARSim, one more is let in.
    pub(crate) controllers: usize,
    /// Connections of all ports that have not logged in yet.
    pub(crate) waiting: usize,
    pub(crate) pages: usize,
    pub(crate) foxglove: usize,
    pub(crate) truth: usize,
    pub(crate) positions: usize,
    pub(crate) images: usize,
    /// Robots on the radio.
    pub(crate) radio: usize,
    /// Ports that robots are given.
    pub(crate) routes: usize,
    /// Relayed connections between robots.
    pub(crate) relays: usize,
    /// Robots at the old relay.
    pub(crate) com_server: usize,
    /// Connections that the old relay joins.
    pub(crate) links: usize,
}

/// A limit, its name and the descriptors that a connection takes.
type Row<'a> = (&'static str, &'a mut usize, u64);

impl Limits {
    /// Returns the limits of a configuration, without regard to descriptors. A service that is not offered has none.
    fn wanted(config: &Config) -> Self {
        let limit = |limit: usize, is_it: fn(&Service) -> bool| {
            if config.listeners.iter().any(|listener| is_it(&listener.service)) { limit } else { 0 }
        };
        let radio = |most| limit(most, |service| *service == Service::Wireless);
        let com_server = |most| limit(most, |service| *service == Service::ComServer);
        Self {
            controllers: config.max_connections,
            waiting: 256,
            pages: limit(256, |service| *service == Service::Page),
            foxglove: limit(64, |service| *service == Service::Foxglove),
            truth: limit(64, |service| *service == Service::Truth),
            positions: limit(64, |service| *service == Service::Positions),
            images: limit(16, |service| *service == Service::Images),
            radio: radio(64),
            routes: radio(256),
            relays: radio(128),
            com_server: com_server(64),
            links: com_server(64),
        }
    }

    fn rows(&mut self) -> [Row<'_>; 12] {
        [
            // A page that drives connects to the controllers' port: two more descriptors.
            ("controllers", &mut self.controllers, 2),
            ("waiting", &mut self.waiting, 1),
            ("pages", &mut self.pages, 1),
            // The gate's connection to the server behind it has two ends.
            ("foxglove", &mut self.foxglove, 3),
            ("truth", &mut self.truth, 1),
            ("positions", &mut self.positions, 1),
            ("images", &mut self.images, 1),
            ("radio", &mut self.radio, 1),
            ("routes", &mut self.routes, 1),
            ("relays", &mut self.relays, 2),
            ("com_server", &mut self.com_server, 1),
            ("links", &mut self.links, 2),
        ]
    }

    /// Returns each limit with its name.
    pub(crate) fn named(mut self) -> Vec<(&'static str, usize)> {
        self.rows().into_iter().map(|(name, limit, _)| (name, *limit)).collect()
    }

    /// Returns the limits of a configuration under a number of descriptors, and what had to be lowered, in words. Controllers get up to half
    /// of the descriptors; the others are lowered in proportion.
    fn under(config: &Config, descriptors: u64) -> (Self, Option<String>) {
        let wanted = Self::wanted(config);
        let mut limits = wanted;
        let free = descriptors.saturating_sub(RESERVED);
        let [controllers, others @ ..] = limits.rows();
        *controllers.1 = (*controllers.1).min((free / 2 / controllers.2) as usize).max(1);
        let free = free.saturating_sub((*controllers.1 as u64 + 1) * controllers.2);
        let needed: u64 = others.iter().map(|(_, limit, each)| **limit as u64 * each).sum();
        if needed > free {
            for (_, limit, _) in others {
                *limit = (*limit as u64 * free / needed).max(u64::from(*limit > 0)) as usize;
            }
        }
        let lowered = limits.named().into_iter().zip(wanted.named()).filter(|(now, before)| now != before);
        let lowered: Vec<String> =
            lowered.map(|((name, now), (_, before))| format!("{name} {now} of {before}")).collect();
        let text = format!(
            "{descriptors} descriptors: fewer connections at once: {}; `ulimit -n` sets more",
            lowered.join(", ")
        );
        (limits, (!lowered.is_empty()).then_some(text))
    }
}

/// Raises the process's limit of descriptors as far as it may, and returns the limits of connections under it, and what had to be lowered,
/// in words.
pub(crate) fn limits(config: &Config) -> (Limits, Option<String>) {
    Limits::under(config, raise())
}

/// Raises the soft limit of descriptors to the hard one. Returns the number of descriptors that the process may have.
#[cfg(unix)]
fn raise() -> u64 {
    use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
    let Rlimit { current, maximum } = getrlimit(Resource::Nofile);
    // Linux refuses none here; macOS refuses "unlimited", and keeps what is there.
    let raised = setrlimit(Resource::Nofile, Rlimit { current: maximum, maximum });
    let now = if raised.is_ok() { maximum } else { current };
    now.unwrap_or(u64::MAX)
}

#[cfg(not(unix))]
fn raise() -> u64 {
    USUAL_DESCRIPTORS
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Listener;

    fn config(max_connections: usize) -> Config {
        let services = [
            Service::Controllers { dialect: None },
            Service::Page,
            Service::Foxglove,
            Service::Truth,
            Service::Positions,
            Service::Images,
            Service::Wireless,
            Service::ComServer,
        ];
        let listeners = services.map(|service| Listener::new(service, 0)).into();
        Config { max_connections, listeners, ..Config::new(scene::WorldDef::default()) }
    }

    #[test]
    fn limits_of_all_services_together_fit_under_the_descriptors() {
        for max_connections in [1, 64, 400, 100_000] {
            for descriptors in [256, 512, 1024, 4096, 1 << 20] {
                let (mut limits, lowered) = Limits::under(&config(max_connections), descriptors);
                let used: u64 = limits.rows().into_iter().map(|(_, limit, each)| *limit as u64 * each).sum();
                assert!(used + RESERVED <= descriptors, "{max_connections} {descriptors}: {used}");
                assert!(limits.rows().iter().all(|(_, limit, _)| **limit > 0), "{limits:?}");
                let is_whole = limits == Limits::wanted(&config(max_connections));
                assert_eq!(is_whole, lowered.is_none(), "{lowered:?}");
                assert!(max_connections > 400 || descriptors < 4096 || is_whole, "{max_connections} {descriptors}");
            }
        }
    }

    #[test]
    fn what_is_lowered_is_said() {
        let (_, lowered) = Limits::under(&config(64), 1024);
        let lowered = lowered.unwrap();
        assert!(lowered.starts_with("1024 descriptors: fewer connections at once: waiting "), "{lowered}");
        assert!(!lowered.contains("controllers"), "{lowered}");
    }
}
