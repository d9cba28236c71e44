//! The pace of simulated time. No clock is read here: the real time is an argument.

use web_time::{Duration, Instant};

/// Longest lag that is made up for. A longer one is forgiven: the world runs slower and does not catch up in a rush.
const MAX_LAG: Duration = Duration::from_millis(100);
/// Real time over which the real-time factor is measured.
const WINDOW: Duration = Duration::from_secs(5);
/// Part of the real-time factor that counts as reached: one pause of the machine in five seconds is no lag.
const REACHED: f64 = 0.95;
/// Further loss that is reported again, as a part of the factor.
const WORSE: f64 = 0.1;

/// Decides when the next step is due.
pub struct Pace {
    /// Simulated seconds per real second; 0 is as fast as possible.
    factor: f64,
    start: Instant,
    /// Simulated time at `start`, s.
    start_time: f64,
    window: Instant,
    window_time: f64,
    /// Part of the factor that was reached at the last report; none while the factor is reached.
    said: Option<f64>,
}

impl Pace {
    /// Begins at a real and a simulated time, s.
    pub fn new(factor: f64, now: Instant, time: f64) -> Self {
        Self { factor, start: now, start_time: time, window: now, window_time: time, said: None }
    }

    /// Returns the wait before the step that starts at simulated `time`; zero if it is due.
    pub fn wait(&mut self, now: Instant, time: f64) -> Duration {
        if self.factor <= 0.0 {
            return Duration::ZERO;
        }
        // A tiny factor makes the wait longer than the clock can express.
        let wait = Duration::try_from_secs_f64((time - self.start_time) / self.factor).unwrap_or(Duration::MAX);
        let Some(due) = self.start.checked_add(wait) else { return Duration::MAX };
        if now > due + MAX_LAG {
            (self.start, self.start_time) = (now, time);
        }
        due.saturating_duration_since(now)
    }

    /// Returns the real-time factor of the last five seconds if it has just become too small, or smaller still.
    pub(crate) fn lag_report(&mut self, now: Instant, time: f64) -> Option<f64> {
        let elapsed = now.duration_since(self.window);
        if elapsed < WINDOW || self.factor <= 0.0 {
            return None;
        }
        let reached = (time - self.window_time) / elapsed.as_secs_f64();
        (self.window, self.window_time) = (now, time);
        let part = reached / self.factor;
        if part >= REACHED {
            self.said = None;
        } else if self.said.is_none_or(|said| part <= said - WORSE) {
            self.said = Some(part);
            return Some(reached);
        }
        None
    }
}

/// Describes a lag to the user, and what helps.
pub(crate) fn lag_text(reached: f64, factor: f64) -> String {
    // At most half the factor, to leave some reserve.
    let slower = (factor / 2.0).min((reached * 10.0).floor() / 10.0).max(0.01);
    format!(
        "behind real time: real-time factor {reached:.2} in place of {factor} in the last 5 s; `--drive-model analytic`, a larger \
         `--dt`, fewer robots or viewers, or `--rtf {slower}` help"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: f64 = 0.002;

    /// Runs a world for `seconds`, in which each step takes `cost` real seconds. Returns simulated time and reports.
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
    fn behind_real_time_it_reports_once_the_factor_that_is_reached() {
        let (time, reports) = simulate(1.0, 0.004, 21.0);
        assert!((time - 10.5).abs() < 0.1, "{time}");
        assert!(matches!(reports[..], [factor] if (factor - 0.5).abs() < 0.01), "{reports:?}");
        assert!(simulate(0.0, 0.004, 21.0).1.is_empty());
    }

    #[test]
    fn what_is_reported_again_has_become_worse_or_is_new() {
        let start = Instant::now();
        let mut pace = Pace::new(2.0, start, 0.0);
        let mut time = 0.0;
        // One factor for each window of five seconds.
        let factors = [1.98, 1.6, 1.5, 1.42, 1.39, 1.96, 1.6];
        let mut said = Vec::new();
        for (window, factor) in factors.into_iter().enumerate() {
            time += 5.0 * factor;
            let now = start + Duration::from_secs(5 * (window as u64 + 1));
            said.extend(pace.lag_report(now, time).map(|reached| (100.0 * reached).round() as u32));
        }
        assert_eq!(said, [160, 139, 160]);
    }

    #[test]
    fn the_advice_is_a_factor_that_can_be_reached() {
        for (reached, factor, advice) in [(0.62, 1.0, "--rtf 0.5`"), (0.33, 1.0, "--rtf 0.3`"), (3.0, 10.0, "--rtf 3`")]
        {
            let text = lag_text(reached, factor);
            assert!(text.contains(advice), "{text}");
        }
        assert!(
            lag_text(0.62, 1.0).starts_with("behind real time: real-time factor 0.62 in place of 1 in the last 5 s; ")
        );
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
