//! Simulated time, for whoever asks between two items of the feed.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// A clock. Copies show the same time.
#[derive(Debug, Clone, Default)]
pub(crate) struct Clock(Arc<AtomicU64>);

impl Clock {
    /// Sets the time, s.
    pub(crate) fn set(&self, time: f64) {
        self.0.store((time * 1e9) as u64, Ordering::Relaxed);
    }

    /// Returns the time, s, to a nanosecond.
    pub(crate) fn time(&self) -> f64 {
        self.0.load(Ordering::Relaxed) as f64 * 1e-9
    }
}
