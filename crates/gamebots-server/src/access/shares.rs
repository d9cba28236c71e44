//! Places that addresses share, so that one address cannot take them all.

use std::collections::BTreeMap;
use std::net::IpAddr;
use std::sync::{Arc, Mutex, PoisonError};

/// A limited number of places, of which each address may have half. Copies are the same places.
#[derive(Clone)]
pub(crate) struct Shares {
    limit: usize,
    /// Taken places of each address.
    taken: Arc<Mutex<BTreeMap<IpAddr, usize>>>,
}

/// A place. It is free again on drop.
pub(crate) struct Share {
    of: Shares,
    address: IpAddr,
}

impl Shares {
    pub(crate) fn new(limit: usize) -> Self {
        Self { limit, taken: Arc::default() }
    }

    /// Takes a place for an address; `None` if all places, or those of the address, are taken.
    pub(crate) fn take(&self, address: IpAddr) -> Option<Share> {
        let address = address.to_canonical();
        let mut taken = self.taken.lock().unwrap_or_else(PoisonError::into_inner);
        if taken.values().sum::<usize>() >= self.limit {
            return None;
        }
        let own = taken.entry(address).or_default();
        if *own >= self.limit.div_ceil(2) {
            return None;
        }
        *own += 1;
        Some(Share { of: self.clone(), address })
    }
}

impl Drop for Share {
    fn drop(&mut self) {
        let mut taken = self.of.taken.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(own) = taken.get_mut(&self.address) {
            *own -= 1;
            if *own == 0 {
                taken.remove(&self.address);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_has_half_of_the_places_at_most() {
        let shares = Shares::new(5);
        let take = |last: u8| shares.take([10, 0, 0, last].into());
        let mut held: Vec<Share> = (0..9).filter_map(|_| take(1)).collect();
        assert_eq!(held.len(), 3);
        held.extend((0..9).filter_map(|_| take(2)));
        assert_eq!(held.len(), 5);
        assert!(take(3).is_none());
        held.clear();
        assert!(take(3).is_some());
        assert!(shares.taken.lock().unwrap().is_empty());
    }
}
