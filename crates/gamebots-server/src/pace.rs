//! Keeping simulated time in step with the clock. Pure: the clock's time is an argument.

use std::time::{Duration, Instant};

/// Lagging by more than this, the lag is forgiven: the world runs slower, it does not catch up in a rush.
const MAX_LAG: Duration = Duration::from_millis(100);
/// How often falling behind is reported.
const REPORT_INTERVAL: Duration = Duration::from_secs(5);

/// Part of the pace that counts as kept: one pause of the machine in five seconds is no lag.
const KEPT: f64 = 0.95;

/// Decides when the next step is due.
pub(crate) struct Pace {
    /// Simulated seconds a real second; 0 is as fast as possible.
    factor: f64,
    start: Instant,
    /// Simulated time at `start`, s.
    start_time: f64,
    window: Instant,
    window_time: f64,
}

impl Pace {
    pub(crate) fn new(factor: f64, now: Instant, time: f64) -> Self {
        Self { factor, start: now, start_time: time, window: now, window_time: time }
    }

    /// How long to wait before the step that leads on from the simulated `time`; zero when it is due.
    pub(crate) fn wait(&mut self, now: Instant, time: f64) -> Duration {
        if self.factor <= 0.0 {
            return Duration::ZERO;
        }
        // A factor that makes time stand still is waited for, but no clock can say until when.
        let wait = Duration::try_from_secs_f64((time - self.start_time) / self.factor).unwrap_or(Duration::MAX);
        let Some(due) = self.start.checked_add(wait) else { return Duration::MAX };
        if now > due + MAX_LAG {
            (self.start, self.start_time) = (now, time);
        }
        due.saturating_duration_since(now)
    }

    /// Every five seconds in which less than [`KEPT`] of the pace was kept, the factor that was reached.
    pub(crate) fn lag_report(&mut self, now: Instant, time: f64) -> Option<f64> {
        let elapsed = now.duration_since(self.window);
        if elapsed < REPORT_INTERVAL {
            return None;
        }
        let reached = (time - self.window_time) / elapsed.as_secs_f64();
        (self.window, self.window_time) = (now, time);
        (reached < KEPT * self.factor).then_some(reached)
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
    fn a_short_pause_of_the_machine_is_not_reported() {
        let start = Instant::now();
        let mut pace = Pace::new(1.0, start, 0.0);
        let at = |seconds: f64| start + Duration::from_secs_f64(seconds);
        assert_eq!(pace.wait(at(0.15), 0.0), Duration::ZERO);
        assert_eq!(pace.lag_report(at(5.0), 4.85), None);
        assert!(pace.lag_report(at(10.0), 9.5).is_some());
    }

    #[test]
    fn a_factor_next_to_nothing_waits_and_does_not_overflow() {
        for factor in [1e-300, 1e-22, 1e-9, f64::MIN_POSITIVE] {
            let mut pace = Pace::new(factor, Instant::now(), 0.0);
            assert!(pace.wait(Instant::now(), STEP) > Duration::from_secs(3600), "{factor}");
        }
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
