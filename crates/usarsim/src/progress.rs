//! Progress of long commands on stderr: a bar on a terminal, otherwise a line every tenth part.

use std::io::{IsTerminal, Write};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Number of lines in a file.
const PARTS: u64 = 10;

/// Progress of a number of runs.
pub(crate) struct Progress {
    bar: ProgressBar,
    total: u64,
    done: AtomicU64,
    start: Instant,
    is_in_lines: bool,
}

impl Progress {
    /// Begins with no run done. Nothing is shown if quiet.
    pub(crate) fn of_runs(total: usize, quiet: bool) -> Self {
        let is_terminal = std::io::stderr().is_terminal();
        let target = if quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let style = ProgressStyle::with_template("{bar:30} {pos}/{len} runs, {eta} left, {msg}");
        let bar = ProgressBar::with_draw_target(Some(total as u64), target)
            .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        let (done, start) = (AtomicU64::new(0), Instant::now());
        Self { bar, total: total as u64, done, start, is_in_lines: !is_terminal && !quiet }
    }

    /// Says what is under way.
    pub(crate) fn say(&self, what: impl Into<String>) {
        self.bar.set_message(what.into());
    }

    /// Counts runs that are done.
    pub(crate) fn add(&self, runs: usize) {
        let runs = runs as u64;
        self.bar.inc(runs);
        let before = self.done.fetch_add(runs, Ordering::Relaxed);
        if self.is_in_lines
            && let Some(line) = line(before, before + runs, self.total, self.start.elapsed().as_secs_f64())
        {
            // The reader may be gone.
            let _ = writeln!(std::io::stderr(), "{line}");
        }
    }

    /// Ends it.
    pub(crate) fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

/// Returns a line if another tenth of all runs is done, after some seconds.
fn line(before: u64, done: u64, total: u64, seconds: f64) -> Option<String> {
    let parts = |done: u64| (PARTS * done).checked_div(total).unwrap_or_default();
    if parts(done) == parts(before) {
        return None;
    }
    let left = seconds / done as f64 * total.saturating_sub(done) as f64;
    Some(format!("{done} of {total} runs in {seconds:.0} s, about {left:.0} s left"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_tenth_part_has_a_line() {
        for (total, step, expected) in [(1106, 1, 10), (7, 1, 7), (100, 30, 4), (3, 3, 1), (0, 0, 0)] {
            let steps = (0..total).step_by(step.max(1) as usize);
            let lines: Vec<_> =
                steps.filter_map(|before| line(before, (before + step).min(total), total, 60.0)).collect();
            assert_eq!(lines.len(), expected, "{lines:?}");
        }
        assert_eq!(line(110, 111, 1106, 30.0).as_deref(), Some("111 of 1106 runs in 30 s, about 269 s left"));
    }
}
