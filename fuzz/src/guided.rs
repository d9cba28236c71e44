//! Additions of the coverage-guided run: a limit on time, and a count of the tries.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use rustix::time::{ClockId, clock_gettime};

use crate::{Target, run};

/// Most processor time of an input. The clock on the wall would count what other programs do.
const TIME: Duration = Duration::from_secs(1);
/// Interval at which the counts are printed.
const INTERVAL: Duration = Duration::from_secs(1);

/// Runs a target as [`run`], and panics where it takes too long. Prints `tried: CASES cases, BYTES bytes` now and then.
pub fn guided(target: Target, bytes: &[u8]) {
    let before = processor_time();
    run(target, bytes);
    let took = processor_time().saturating_sub(before);
    count(bytes.len() as u64);
    assert!(took <= TIME, "{took:?} of processor time: expected at most {TIME:?}");
}

fn processor_time() -> Duration {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    Duration::new(time.tv_sec.unsigned_abs(), time.tv_nsec.unsigned_abs() as u32)
}

fn count(length: u64) {
    static CASES: AtomicU64 = AtomicU64::new(0);
    static BYTES: AtomicU64 = AtomicU64::new(0);
    static PRINTED: std::sync::Mutex<Option<Instant>> = std::sync::Mutex::new(None);
    let cases = CASES.fetch_add(1, Ordering::Relaxed) + 1;
    let bytes = BYTES.fetch_add(length, Ordering::Relaxed) + length;
    let Ok(mut printed) = PRINTED.lock() else { return };
    if printed.is_none_or(|printed| printed.elapsed() >= INTERVAL) {
        *printed = Some(Instant::now());
        eprintln!("tried: {cases} cases, {bytes} bytes");
    }
}
