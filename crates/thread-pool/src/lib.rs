//! Threads on which the steps of a world run: [`sim_core::Threads`] by rayon.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use sim_core::{OneThread, Threads};

/// Some threads; a copy is the same ones.
#[derive(Debug, Clone)]
pub struct ThreadPool(Option<Arc<rayon::ThreadPool>>);

impl ThreadPool {
    /// The thread that asks, and no other.
    pub fn one() -> Self {
        Self(None)
    }

    /// So many threads; one is the thread that asks.
    ///
    /// # Errors
    /// When they cannot be started.
    pub fn new(threads: usize) -> io::Result<Self> {
        if threads <= 1 {
            return Ok(Self::one());
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).thread_name(|number| format!("world-{number}"));
        Ok(Self(Some(Arc::new(pool.build().map_err(io::Error::other)?))))
    }

    /// As many threads as this machine runs at a time.
    ///
    /// # Errors
    /// When they cannot be started.
    pub fn of_machine() -> io::Result<Self> {
        Self::new(std::thread::available_parallelism().map_or(1, usize::from))
    }

    /// How many they are.
    pub fn threads(&self) -> usize {
        self.0.as_ref().map_or(1, |pool| pool.current_num_threads())
    }

    /// Does something on one of them. From there the others are reached without waiting for this one to wake up, so whoever steps a
    /// world does it here.
    pub fn run<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        match &self.0 {
            Some(pool) => pool.install(work),
            None => work(),
        }
    }

    /// The same for what gives them work all the time: the others wait for it awake, as to wake one up takes as long as a robot takes for
    /// ten steps.
    pub fn run_in_a_hurry<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        let Some(pool) = &self.0 else { return work() };
        let is_done = AtomicBool::new(false);
        let wait = || {
            while !is_done.load(Ordering::Relaxed) {
                if rayon::yield_now() != Some(rayon::Yield::Executed) {
                    std::hint::spin_loop();
                }
            }
        };
        pool.scope(|scope| {
            let _done = SetAtEnd(&is_done);
            (1..pool.current_num_threads()).for_each(|_| scope.spawn(|_| wait()));
            work()
        })
    }
}

impl Threads for ThreadPool {
    fn join(&self, one: &mut (dyn FnMut() + Send), other: &mut (dyn FnMut() + Send)) {
        match &self.0 {
            Some(pool) => {
                pool.join(one, other);
            }
            None => OneThread.join(one, other),
        }
    }
}

/// Sets a flag at its end, even if that is a panic.
struct SetAtEnd<'a>(&'a AtomicBool);

impl Drop for SetAtEnd<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}
