//! Work on several threads, by whoever has them: the world itself knows none.

/// Does two things, at the same time or one after the other.
///
/// What they do must not depend on it: the bits are the same for any number of threads.
pub trait Threads: Send + Sync {
    /// Returns when both are done.
    fn join(&self, one: &mut (dyn FnMut() + Send), other: &mut (dyn FnMut() + Send));
}

/// One thing after the other.
#[derive(Debug, Clone, Copy, Default)]
pub struct OneThread;

impl Threads for OneThread {
    fn join(&self, one: &mut (dyn FnMut() + Send), other: &mut (dyn FnMut() + Send)) {
        one();
        other();
    }
}

/// Works on items, at most so many of them together.
pub(crate) fn in_parts<T: Send>(
    threads: &dyn Threads,
    most: usize,
    items: &mut [T],
    work: &(impl Fn(&mut [T]) + Sync),
) {
    if items.len() <= most.max(1) {
        return work(items);
    }
    let (one, other) = items.split_at_mut(items.len() / 2);
    threads.join(&mut || in_parts(threads, most, one, work), &mut || in_parts(threads, most, other, work));
}
