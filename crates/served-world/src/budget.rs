//! Limits of log lines, so that no client can fill the disk.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::net::IpAddr;
use std::sync::{Arc, Mutex, PoisonError};

use tracing::warn;
use web_time::{Duration, Instant};

/// Most lines in a second; the rest are counted.
const MAX_LINES: u64 = 20;
/// Most addresses with a budget at once. Lines about more are refused.
const MAX_ADDRESSES: usize = 1024;
/// Time after which a budget is fresh.
const PERIOD: Duration = Duration::from_secs(1);

/// A limit of lines per second.
#[derive(Default)]
pub struct Budget {
    second: Option<Instant>,
    spent: u64,
}

/// The answer to a request to log a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Spent {
    /// The line may be logged. `suppressed` lines were refused in the second before.
    Granted { suppressed: u64 },
    /// The line may not be logged.
    Refused,
}

impl Spent {
    /// Tells whether the line may be logged. The first line of a second logs how many were refused before it.
    fn is_granted(self, about: impl Display) -> bool {
        if let Self::Granted { suppressed: suppressed @ 1.. } = self {
            warn!(%about, suppressed, "further lines were not logged");
        }
        self != Self::Refused
    }
}

impl Budget {
    /// True if a line about something may be logged. Logs how many were refused in the second before.
    pub fn allow(&mut self, now: Instant, about: impl Display) -> bool {
        self.spend(now).is_granted(about)
    }

    fn spend(&mut self, now: Instant) -> Spent {
        let mut suppressed = 0;
        if self.is_fresh(now) {
            suppressed = self.spent.saturating_sub(MAX_LINES);
            (self.second, self.spent) = (Some(now), 0);
        }
        self.spent += 1;
        if self.spent > MAX_LINES { Spent::Refused } else { Spent::Granted { suppressed } }
    }

    fn is_fresh(&self, now: Instant) -> bool {
        self.second.is_none_or(|second| now.duration_since(second) >= PERIOD)
    }
}

/// The budgets of all addresses: a client that leaves and comes again has the same one.
#[derive(Clone, Default)]
pub struct Budgets(Arc<Mutex<BTreeMap<IpAddr, Budget>>>);

impl Budgets {
    /// True if a line about a client may be logged. Logs how many were refused in the second before.
    pub fn allow(&self, address: IpAddr, now: Instant) -> bool {
        self.spend(address, now).is_granted(address)
    }

    fn spend(&self, address: IpAddr, now: Instant) -> Spent {
        let mut budgets = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if budgets.len() >= MAX_ADDRESSES && !budgets.contains_key(&address) {
            budgets.retain(|_, budget| !budget.is_fresh(now));
            if budgets.len() >= MAX_ADDRESSES {
                return Spent::Refused;
            }
        }
        budgets.entry(address).or_default().spend(now)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_has_so_many_lines_a_second() {
        let (budgets, start) = (Budgets::default(), Instant::now());
        let spend = |host: u8, seconds: f64| {
            budgets.spend(IpAddr::from([10, 0, 0, host]), start + Duration::from_secs_f64(seconds))
        };
        let free = Spent::Granted { suppressed: 0 };
        assert!((0..20).all(|_| spend(1, 0.0) == free));
        assert!((0..5).all(|_| spend(1, 0.9) == Spent::Refused));
        assert_eq!(spend(2, 0.9), free);
        assert_eq!([spend(1, 1.0), spend(1, 1.0)], [Spent::Granted { suppressed: 5 }, free]);
    }

    #[test]
    fn more_addresses_than_are_kept_wait_for_a_second() {
        let (budgets, start) = (Budgets::default(), Instant::now());
        let spend = |number: u32, now| budgets.spend(IpAddr::from(number.to_be_bytes()), now);
        let granted = (0..2000).filter(|&number| spend(number, start) != Spent::Refused).count();
        assert_eq!(granted, MAX_ADDRESSES);
        assert_eq!(spend(1999, start + PERIOD), Spent::Granted { suppressed: 0 });
        assert_eq!(budgets.0.lock().unwrap().len(), 1);
    }
}
