//! What tests share that measure: one at a time, for as long as the environment says.

use std::sync::{Mutex, MutexGuard, PoisonError};

/// Waits until no other test of this process measures.
pub fn alone() -> MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A number from an environment variable, or the one that holds without it.
///
/// # Panics
/// If it is no number.
pub fn setting<T: std::str::FromStr>(name: &str, otherwise: T) -> T {
    let Ok(text) = std::env::var(name) else { return otherwise };
    text.parse().unwrap_or_else(|_| panic!("{name}={text}: expected a number"))
}
