//! Lines on their way to one client.
//!
//! If a client does not keep up, its oldest periodic lines (STA, SEN) are dropped first and counted. Answers are never dropped.
//! So while too many answers wait, neither the connection nor the world takes a further command.
//!
//! In real time, a client that keeps up gets each line in its own segment. Many scripts take one `recv` for one line, and a
//! longer piece for a line that is cut off.

use std::collections::VecDeque;
use std::future::poll_fn;
use std::sync::PoisonError;
use std::task::{Context, Poll, Waker};

// The feature `loom` tries every interleaving of the threads; see the tests.
#[cfg(feature = "loom")]
use loom::sync::{Mutex, MutexGuard};
#[cfg(not(feature = "loom"))]
use std::sync::{Mutex, MutexGuard};

/// Most bytes of periodic lines that wait for a client.
const MAX_PERIODIC_BYTES: usize = 512 * 1024;
/// Bytes of waiting answers at which no further command is taken.
const MAX_ANSWER_BYTES: usize = 256 * 1024;

/// Most lines that wait for a client that gets them one by one. With more it is behind, and gets all at once.
const MAX_PACED_LINES: usize = 64;

/// The queue of one client: filled by the world's thread, emptied by the connection's task.
#[derive(Default)]
pub struct Outbox {
    queue: Mutex<Queue>,
}

#[derive(Default)]
struct Queue {
    lines: VecDeque<Outgoing>,
    periodic_bytes: usize,
    answer_bytes: usize,
    dropped: u64,
    closed: bool,
    /// True in real time, where lines may leave one by one.
    is_paced: bool,
    /// Waker of the task that writes lines, while it waits for lines.
    writer: Option<Waker>,
    /// Waker of the task that reads commands, while it waits for room.
    reader: Option<Waker>,
}

struct Outgoing {
    text: String,
    periodic: bool,
}

/// Lines to write at once.
#[derive(Debug, PartialEq)]
pub struct Taken {
    /// Whole lines with their ends.
    pub text: String,
    /// True for a single line that needs its own segment.
    pub is_paced: bool,
}

impl Outbox {
    /// Adds a line, without its end.
    pub fn push(&self, mut text: String, periodic: bool) {
        text.push_str("\r\n");
        let mut queue = self.lock();
        if queue.closed {
            return;
        }
        *queue.bytes(periodic) += text.len();
        queue.lines.push_back(Outgoing { text, periodic });
        while queue.periodic_bytes > MAX_PERIODIC_BYTES && queue.drop_oldest_periodic() {}
        let writer = queue.writer.take();
        drop(queue);
        wake(writer);
    }

    /// Closes the queue: later lines are ignored, but waiting lines are still sent.
    pub fn close(&self) {
        let mut queue = self.lock();
        queue.closed = true;
        let (writer, reader) = (queue.writer.take(), queue.reader.take());
        drop(queue);
        wake(writer);
        wake(reader);
    }

    /// Selects if lines leave one by one or together.
    pub fn set_paced(&self, is_paced: bool) {
        self.lock().is_paced = is_paced;
    }

    /// Waits for lines and takes all of them, or only one if lines leave one by one. Returns `None` if the queue is closed and
    /// empty.
    pub async fn take(&self) -> Option<Taken> {
        poll_fn(|context| self.poll_take(context)).await
    }

    fn poll_take(&self, context: &mut Context) -> Poll<Option<Taken>> {
        let mut queue = self.lock();
        if queue.lines.is_empty() {
            if queue.closed {
                return Poll::Ready(None);
            }
            queue.writer = Some(context.waker().clone());
            return Poll::Pending;
        }
        let is_paced = queue.is_paced && !queue.closed && queue.lines.len() <= MAX_PACED_LINES;
        let count = if is_paced { 1 } else { queue.lines.len() };
        let text = (0..count).filter_map(|_| queue.pop()).collect();
        let reader = queue.has_room().then(|| queue.reader.take()).flatten();
        drop(queue);
        wake(reader);
        Poll::Ready(Some(Taken { text, is_paced }))
    }

    /// True if the client has read enough of its answers to get more.
    pub fn has_room(&self) -> bool {
        self.lock().has_room()
    }

    /// Waits until [`Self::has_room`].
    pub async fn ready_for_answers(&self) {
        poll_fn(|context| {
            let mut queue = self.lock();
            if queue.has_room() {
                return Poll::Ready(());
            }
            queue.reader = Some(context.waker().clone());
            Poll::Pending
        })
        .await;
    }

    /// Returns the number of bytes that the client has not been sent yet.
    pub fn waiting_bytes(&self) -> usize {
        let queue = self.lock();
        queue.periodic_bytes + queue.answer_bytes
    }

    /// Returns the number of periodic lines dropped since the last call.
    pub fn take_dropped(&self) -> u64 {
        std::mem::take(&mut self.lock().dropped)
    }

    fn lock(&self) -> MutexGuard<'_, Queue> {
        // No code panics while it holds the lock, and the queue is valid after each statement.
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Wakes a task. The lock must be free, because the task takes it first.
fn wake(waker: Option<Waker>) {
    if let Some(waker) = waker {
        waker.wake();
    }
}

impl Queue {
    fn has_room(&self) -> bool {
        self.closed || self.answer_bytes < MAX_ANSWER_BYTES
    }

    fn bytes(&mut self, periodic: bool) -> &mut usize {
        if periodic { &mut self.periodic_bytes } else { &mut self.answer_bytes }
    }

    fn pop(&mut self) -> Option<String> {
        let Outgoing { text, periodic } = self.lines.pop_front()?;
        *self.bytes(periodic) -= text.len();
        Some(text)
    }

    fn drop_oldest_periodic(&mut self) -> bool {
        let Some(index) = self.lines.iter().position(|line| line.periodic) else { return false };
        if let Some(line) = self.lines.remove(index) {
            self.periodic_bytes -= line.text.len();
            self.dropped += 1;
        }
        true
    }
}

#[cfg(test)]
#[cfg(feature = "loom")]
mod model {
    //! Every interleaving of world, writer and reader: `make loom`.

    use std::sync::Arc;

    use loom::future::block_on;
    use loom::thread;

    use super::*;

    #[test]
    fn no_line_is_lost_and_nobody_waits_for_ever() {
        loom::model(|| {
            let outbox = Arc::new(Outbox::default());
            let world = {
                let outbox = outbox.clone();
                thread::spawn(move || {
                    outbox.push("CONF".to_owned(), false);
                    outbox.push("SEN".to_owned(), true);
                    outbox.close();
                    outbox.push("late".to_owned(), false);
                })
            };
            let mut text = String::new();
            while let Some(part) = block_on(outbox.take()) {
                text.push_str(&part.text);
            }
            assert_eq!(text, "CONF\r\nSEN\r\n");
            world.join().unwrap();
        });
    }

    #[test]
    fn a_full_queue_is_left_as_soon_as_it_is_taken_or_closed() {
        for closes in [false, true] {
            loom::model(move || {
                let outbox = Arc::new(Outbox::default());
                outbox.push("x".repeat(MAX_ANSWER_BYTES), false);
                let reader = {
                    let outbox = outbox.clone();
                    thread::spawn(move || block_on(outbox.ready_for_answers()))
                };
                if closes {
                    outbox.close();
                } else {
                    block_on(outbox.take());
                }
                reader.join().unwrap();
                assert!(outbox.has_room());
            });
        }
    }
}

#[cfg(test)]
#[cfg(not(feature = "loom"))]
mod tests {
    use super::*;

    /// Returns the value of a future that is ready.
    fn block_on<T>(future: impl Future<Output = T>) -> T {
        match std::pin::pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
            Poll::Ready(value) => value,
            Poll::Pending => panic!("it waits"),
        }
    }

    #[test]
    fn lines_are_taken_one_by_one_while_time_is_real_and_the_client_keeps_up() {
        let fill = |count: usize, is_paced: bool| {
            let outbox = Outbox::default();
            outbox.set_paced(is_paced);
            (0..count).for_each(|number| outbox.push(format!("SEN {number}"), number % 2 == 0));
            outbox
        };
        for (count, is_paced, expected) in
            [(3, false, 3), (3, true, 1), (MAX_PACED_LINES, true, 1), (MAX_PACED_LINES + 1, true, MAX_PACED_LINES + 1)]
        {
            let outbox = fill(count, is_paced);
            let taken = block_on(outbox.take()).unwrap();
            assert_eq!((taken.text.lines().count(), taken.is_paced), (expected, expected == 1), "{count} {is_paced}");
            let rest: usize = (expected..count).map(|number| format!("SEN {number}\r\n").len()).sum();
            assert_eq!(outbox.waiting_bytes(), rest, "{count} {is_paced}");
        }
        // After closing, all lines leave together.
        let outbox = fill(3, true);
        outbox.close();
        let all = Taken { text: "SEN 0\r\nSEN 1\r\nSEN 2\r\n".to_owned(), is_paced: false };
        assert_eq!(block_on(outbox.take()), Some(all));
    }

    #[test]
    fn the_oldest_periodic_lines_go_first_and_answers_never() {
        let outbox = Outbox::default();
        let long = "x".repeat(1000);
        outbox.push("CONF first".to_owned(), false);
        (0..1000).for_each(|number| outbox.push(format!("SEN {number} {long}"), true));
        outbox.push("CONF last".to_owned(), false);
        outbox.close();
        let Taken { text, is_paced: false } = block_on(outbox.take()).unwrap() else { panic!("it is behind") };
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!((lines[0], lines[lines.len() - 1]), ("CONF first", "CONF last"));
        let dropped = outbox.take_dropped();
        assert_eq!(lines.len() as u64, 1002 - dropped);
        assert!(dropped > 0 && lines[1].starts_with(&format!("SEN {dropped} ")), "{dropped}: {}", &lines[1][..10]);
        assert_eq!(block_on(outbox.take()), None);
    }
}
