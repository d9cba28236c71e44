//! Helpers of tests that measure: one such test at a time, with settings from the environment.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// Waits until no other test of this process measures.
pub fn alone() -> MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Returns a number from an environment variable, or a default.
///
/// # Panics
/// If the variable is not a number.
pub fn setting<T: std::str::FromStr>(name: &str, otherwise: T) -> T {
    let Ok(text) = std::env::var(name) else { return otherwise };
    text.parse().unwrap_or_else(|_| panic!("{name}={text}: expected a number"))
}
