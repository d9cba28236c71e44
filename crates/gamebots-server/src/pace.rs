//! Keeping simulated time in step with the clock. Pure: the clock's time is an argument.

use std::time::{Duration, Instant};

/// Lagging by more than this, the lag is forgiven: the world runs slower, it does not catch up in a rush.
const MAX_LAG: Duration = Duration::from_millis(100);
/// How often falling behind is reported.
const REPORT_INTERVAL: Duration = Duration::from_secs(5);

/// Decides when the next step is due.
pub(crate) struct Pace {
    /// Simulated seconds a real second; 0 is as fast as possible.
    factor: f64,
    start: Instant,
    /// Simulated time at `start`, s.
    start_time: f64,
    window: Instant,
    window_time: f64,
    lagged: bool,
}

impl Pace {
    pub(crate) fn new(factor: f64, now: Instant, time: f64) -> Self {
        Self { factor, start: now, start_time: time, window: now, window_time: time, lagged: false }
    }

    /// How long to wait before the step that leads on from the simulated `time`; zero when it is due.
    pub(crate) fn wait(&mut self, now: Instant, time: f64) -> Duration {
        if self.factor <= 0.0 {
            return Duration::ZERO;
        }
        let due = self.start + Duration::from_secs_f64((time - self.start_time) / self.factor);
        if now > due + MAX_LAG {
            self.lagged = true;
            (self.start, self.start_time) = (now, time);
        }
        due.saturating_duration_since(now)
    }

    /// Every five seconds in which the pace was not kept, the factor that was reached.
    pub(crate) fn lag_report(&mut self, now: Instant, time: f64) -> Option<f64> {
        let elapsed = now.duration_since(self.window);
        if elapsed < REPORT_INTERVAL {
            return None;
        }
        let reached = (time - self.window_time) / elapsed.as_secs_f64();
        let lagged = std::mem::take(&mut self.lagged);
        (self.window, self.window_time) = (now, time);
        lagged.then_some(reached)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: f64 = 0.002;

    /// Steps a world of which each step takes `cost` real seconds for `seconds`; returns simulated time and reports.
    fn simulate(factor: f64, cost: f64, seconds: f64) -> (f64, Vec<f64>) {
        let start = Instant::now();
        let (mut now, mut time, mut reports) = (start, 0.0, Vec::new());
        let mut pace = Pace::new(factor, now, time);
        while now.duration_since(start).as_secs_f64() < seconds {
            now += pace.wait(now, time) + Duration::from_secs_f64(cost);
            time += STEP;
            reports.extend(pace.lag_report(now, time));
        }
        (time, reports)
    }

    #[test]
    fn time_runs_by_the_factor_when_steps_are_fast_enough() {
        for factor in [0.5, 1.0, 2.0] {
            let (time, reports) = simulate(factor, 1e-4, 20.0);
            assert!((time - 20.0 * factor).abs() < 0.02, "{factor}: {time}");
            assert!(reports.is_empty(), "{factor}: {reports:?}");
        }
    }

    #[test]
    fn behind_its_pace_it_reports_the_factor_reached_every_five_seconds() {
        let (time, reports) = simulate(1.0, 0.004, 21.0);
        assert!((time - 10.5).abs() < 0.1, "{time}");
        assert_eq!(reports.len(), 4);
        assert!(reports.iter().all(|factor| (factor - 0.5).abs() < 0.01), "{reports:?}");
    }

    #[test]
    fn a_pause_is_not_made_up_for_in_a_rush() {
        let start = Instant::now();
        let mut pace = Pace::new(1.0, start, 0.0);
        let after_pause = start + Duration::from_secs(60);
        assert_eq!(pace.wait(after_pause, 0.0), Duration::ZERO);
        assert!(pace.wait(after_pause, 0.01) > Duration::from_millis(9));
    }

    #[test]
    fn factor_zero_never_waits() {
        assert_eq!(Pace::new(0.0, Instant::now(), 0.0).wait(Instant::now(), 1e9), Duration::ZERO);
    }
}
