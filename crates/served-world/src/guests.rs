//! Guests: everyone who asks the world for something without driving a robot. Pages, ports of referees and radios, supervisors and
//! Foxglove are guests.
//!
//! A guest's request waits here until the world has time for it. The kind that cost least lately goes first, and within it the guest
//! that cost least. So one connection that asks without pause delays no other, and many connections to one service delay no other service.

use std::collections::BTreeMap;

use web_time::{Duration, Instant};

use crate::event::{Guest, Kind, Turn};
use crate::question::Question;

/// Part of real time that guests may take while steps are due.
pub(crate) const SHARE: f64 = 0.03;
/// Part of real time that guests may take while no step is due. Drivers' connections and the threads of steps need the cores, too.
pub(crate) const IDLE_SHARE: f64 = 0.25;
/// Longest time that guests can save up, s.
const MAX_SAVED: f64 = 0.005;
/// Price of an answer beside the world's time: about what a connection's thread and the system take to send it.
const DELIVERY: Duration = Duration::from_micros(100);

/// The requests of all guests that wait. Each guest has one at most.
#[derive(Default)]
pub(crate) struct Guests(BTreeMap<Kind, Queue>);

/// The guests of a kind.
#[derive(Default)]
struct Queue {
    /// Waiting requests, by the recent cost and the number of their guest.
    waiting: BTreeMap<(Duration, u64), (Question, Turn)>,
    /// Recent cost of each guest.
    costs: BTreeMap<u64, Duration>,
    /// Recent cost of all guests.
    cost: Duration,
}

impl Guests {
    /// Adds a guest's request.
    pub(crate) fn add(&mut self, guest: Guest, question: Question, turn: Turn) {
        let queue = self.0.entry(guest.kind).or_default();
        // A new guest starts at the mean cost, so that leaving and returning gains nothing.
        let mean = queue.cost / queue.costs.len().max(1) as u32;
        let cost = *queue.costs.entry(guest.number).or_insert(mean);
        queue.waiting.insert((cost, guest.number), (question, turn));
    }

    /// Takes the next request.
    pub(crate) fn next(&mut self) -> Option<(Guest, Question, Turn)> {
        let waiting = self.0.iter_mut().filter(|(_, queue)| !queue.waiting.is_empty());
        let (&kind, queue) = waiting.min_by_key(|(_, queue)| queue.cost)?;
        let ((_, number), (question, turn)) = queue.waiting.pop_first()?;
        Some((Guest { kind, number }, question, turn))
    }

    /// Adds the cost of a request to its guest's.
    pub(crate) fn charge(&mut self, guest: Guest, cost: Duration) {
        let queue = self.0.entry(guest.kind).or_default();
        queue.cost += cost;
        *queue.costs.entry(guest.number).or_default() += cost;
    }

    /// Halves all costs, and forgets guests that cost nothing any longer.
    pub(crate) fn forget_half(&mut self) {
        for queue in self.0.values_mut() {
            queue.cost /= 2;
            queue.costs.retain(|_, cost| {
                *cost /= 2;
                !cost.is_zero()
            });
            let waiting = std::mem::take(&mut queue.waiting).into_iter();
            queue.waiting = waiting.map(|((cost, number), request)| ((cost / 2, number), request)).collect();
        }
    }
}

/// Time that guests may take. A request that takes longer makes it negative; then guests wait.
pub(crate) struct Credit {
    /// Part of real time that is earned.
    share: f64,
    /// Saved time, s.
    saved: f64,
    /// Time of the last earning.
    earned: Instant,
}

impl Credit {
    pub(crate) fn new(share: f64, now: Instant) -> Self {
        Self { share, saved: 0.0, earned: now }
    }

    /// Earns the share of the time since the last call. Returns true if guests may take time now.
    pub(crate) fn earn(&mut self, now: Instant) -> bool {
        let elapsed = now.saturating_duration_since(self.earned).as_secs_f64();
        (self.saved, self.earned) = ((self.saved + self.share * elapsed).min(MAX_SAVED), now);
        self.saved > 0.0
    }

    /// Pays for an answer that took the world this time. Returns true if some is left.
    pub(crate) fn spend(&mut self, took: Duration) -> bool {
        self.saved -= (took + DELIVERY).as_secs_f64();
        self.saved > 0.0
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use tokio::sync::{Semaphore, oneshot};

    use super::*;

    /// Lets guests ask without pause, with requests of these costs, until one of them has had `turns`. Returns the turns of each.
    fn served(guests: &[(Kind, u64, Duration)], turns: usize) -> Vec<usize> {
        let mut waiting = Guests::default();
        let mut served = vec![0; guests.len()];
        let ask = |waiting: &mut Guests, (kind, number, _): (Kind, u64, Duration)| {
            let turn = Arc::new(Semaphore::new(1)).try_acquire_owned().unwrap();
            waiting.add(Guest { kind, number }, Question::Standings(oneshot::channel().0), turn);
        };
        guests.iter().for_each(|&guest| ask(&mut waiting, guest));
        while served.iter().all(|&count| count < turns) {
            let (guest, ..) = waiting.next().unwrap();
            let index = guests.iter().position(|&(kind, number, _)| (kind, number) == (guest.kind, guest.number));
            let index = index.unwrap();
            waiting.charge(guest, guests[index].2);
            served[index] += 1;
            ask(&mut waiting, guests[index]);
        }
        served
    }

    #[test]
    fn guests_of_a_kind_share_its_time_and_kinds_share_all_of_it() {
        let [cheap, dear] = [1, 10].map(Duration::from_millis);
        let count = served(&[(Kind::Page, 1, cheap), (Kind::Page, 2, dear)], 100);
        assert!((8..=12).contains(&count[1]), "{count:?}");
        let mut many: Vec<_> = (1..=64).map(|number| (Kind::Positions, number, cheap)).collect();
        many.push((Kind::Page, 1, cheap));
        let count = served(&many, 100);
        assert_eq!(count[64], 100);
        assert!(count[..64].iter().all(|&count| count <= 2), "{count:?}");
    }

    #[test]
    fn a_guest_that_leaves_and_returns_gains_nothing() {
        let mut waiting = Guests::default();
        let turn = || Arc::new(Semaphore::new(1)).try_acquire_owned().unwrap();
        let guest = |number| Guest { kind: Kind::Page, number };
        waiting.charge(guest(1), Duration::from_millis(10));
        waiting.charge(guest(2), Duration::from_millis(2));
        for number in [3, 2, 1] {
            waiting.add(guest(number), Question::Standings(oneshot::channel().0), turn());
        }
        let order: Vec<u64> = std::iter::from_fn(|| waiting.next()).map(|(guest, ..)| guest.number).collect();
        assert_eq!(order, [2, 3, 1]);
        (0..64).for_each(|_| waiting.forget_half());
        assert!(waiting.0.values().all(|queue| queue.costs.is_empty()));
    }

    #[test]
    fn a_long_request_is_paid_back_before_the_next() {
        let start = Instant::now();
        let at = |milliseconds| start + Duration::from_millis(milliseconds);
        let mut credit = Credit::new(SHARE, start);
        assert!(!credit.earn(start));
        assert!(credit.earn(at(1)));
        assert!(!credit.spend(Duration::from_millis(2)));
        assert!(!credit.earn(at(68)));
        assert!(credit.earn(at(72)));
        credit.earn(at(100_000));
        assert!(credit.spend(Duration::from_millis(4)) && !credit.spend(Duration::from_millis(2)));
    }
}
