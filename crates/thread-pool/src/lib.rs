//! Thread pool for the steps of a world: [`sim_core::Threads`] by rayon.

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use sim_core::{OneThread, Threads};

/// A pool of threads; clones share it.
#[derive(Debug, Clone)]
pub struct ThreadPool(Option<Arc<rayon::ThreadPool>>);

impl ThreadPool {
    /// Creates a pool of only the calling thread.
    pub fn one() -> Self {
        Self(None)
    }

    /// Creates a pool of this many threads; a single one is the calling thread.
    ///
    /// # Errors
    /// When the threads cannot be started.
    pub fn new(threads: usize) -> io::Result<Self> {
        if threads <= 1 {
            return Ok(Self::one());
        }
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).thread_name(|number| format!("world-{number}"));
        Ok(Self(Some(Arc::new(pool.build().map_err(io::Error::other)?))))
    }

    /// Creates a pool of as many threads as this machine runs at a time.
    ///
    /// # Errors
    /// When the threads cannot be started.
    pub fn of_machine() -> io::Result<Self> {
        Self::new(std::thread::available_parallelism().map_or(1, usize::from))
    }

    /// Returns the number of threads.
    pub fn threads(&self) -> usize {
        self.0.as_ref().map_or(1, |pool| pool.current_num_threads())
    }

    /// Runs a closure on one thread of the pool. From there, work reaches the other threads without waiting for this one to wake
    /// up. Steps of a world belong in here.
    pub fn run<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        match &self.0 {
            Some(pool) => pool.install(work),
            None => work(),
        }
    }

    /// Runs a closure that hands out work all the time. The other threads wait for it awake, as waking one takes as long as ten
    /// steps of a robot.
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

/// Sets a flag when dropped, even by a panic.
struct SetAtEnd<'a>(&'a AtomicBool);

impl Drop for SetAtEnd<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}
