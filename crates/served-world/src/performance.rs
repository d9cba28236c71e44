//! The speed of a served world: its steps, their real time, and its real-time factor.

use web_time::{Duration, Instant};

/// Least time over which the real-time factor is measured. Shorter times are too uneven.
const MEASURE_INTERVAL: Duration = Duration::from_millis(500);

/// Counts and times of the world's work so far.
pub(crate) struct Performance {
    pub(crate) steps: u64,
    /// Real time that steps took.
    pub(crate) took: Duration,
    /// Periodic lines dropped for clients that have left.
    pub(crate) dropped: u64,
    /// Simulated seconds per real second, as last measured.
    pub(crate) real_time_factor: f64,
    /// Real and simulated time, s, of that measurement.
    measured: (Instant, f64),
}

impl Performance {
    pub(crate) fn new(now: Instant, time: f64) -> Self {
        Self { steps: 0, took: Duration::ZERO, dropped: 0, real_time_factor: 0.0, measured: (now, time) }
    }

    /// Counts a step.
    pub(crate) fn add(&mut self, took: Duration) {
        self.steps += 1;
        self.took += took;
    }

    /// Measures the real-time factor, if the last time is long enough ago. A world that started over counts from 0.
    pub(crate) fn measure(&mut self, now: Instant, time: f64) {
        let (then, before) = self.measured;
        let elapsed = now.duration_since(then);
        if elapsed >= MEASURE_INTERVAL {
            self.real_time_factor = (time - before).max(0.0) / elapsed.as_secs_f64();
            self.measured = (now, time);
        }
    }
}
