//! Work on several threads. The caller supplies the threads; the world itself starts none.

/// Runs two tasks, at the same time or one after the other.
///
/// The tasks must not depend on which: the bits are the same for any number of threads.
pub trait Threads: Send + Sync {
    /// Runs both tasks and returns when both are done.
    fn join(&self, one: &mut (dyn FnMut() + Send), other: &mut (dyn FnMut() + Send));
}

/// Runs one task after the other on the calling thread.
#[derive(Debug, Clone, Copy, Default)]
pub struct OneThread;

impl Threads for OneThread {
    fn join(&self, one: &mut (dyn FnMut() + Send), other: &mut (dyn FnMut() + Send)) {
        one();
        other();
    }
}

/// Splits items into parts of at most `most` items and runs `work` on each part, possibly in parallel.
pub fn in_parts<T: Send>(threads: &dyn Threads, most: usize, items: &mut [T], work: &(impl Fn(&mut [T]) + Sync)) {
    if items.len() <= most.max(1) {
        return work(items);
    }
    let (one, other) = items.split_at_mut(items.len() / 2);
    threads.join(&mut || in_parts(threads, most, one, work), &mut || in_parts(threads, most, other, work));
}
