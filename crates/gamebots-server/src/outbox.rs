//! Lines on their way to one client.
//!
//! The policy for a client that does not keep up: its oldest periodic lines (STA, SEN) are dropped first and
//! counted, its answers never. As answers are never dropped, neither the connection nor the world takes a further
//! command while too many of them wait.

use std::collections::VecDeque;
use std::sync::{Mutex, MutexGuard, PoisonError};

use tokio::sync::Notify;

/// Bytes of periodic lines that may wait for a client.
const MAX_PERIODIC_BYTES: usize = 512 * 1024;
/// Bytes of answers that may wait before no further command is taken.
const MAX_ANSWER_BYTES: usize = 256 * 1024;

/// The queue of one client: filled by the world's thread, emptied by the connection's task.
#[derive(Default)]
pub(crate) struct Outbox {
    queue: Mutex<Queue>,
    filled: Notify,
    emptied: Notify,
}

#[derive(Default)]
struct Queue {
    lines: VecDeque<Outgoing>,
    periodic_bytes: usize,
    answer_bytes: usize,
    dropped: u64,
    closed: bool,
}

struct Outgoing {
    text: String,
    periodic: bool,
}

impl Outbox {
    /// Adds a line, without its end.
    pub(crate) fn push(&self, mut text: String, periodic: bool) {
        text.push_str("\r\n");
        let mut queue = self.lock();
        if queue.closed {
            return;
        }
        *queue.bytes(periodic) += text.len();
        queue.lines.push_back(Outgoing { text, periodic });
        while queue.periodic_bytes > MAX_PERIODIC_BYTES && queue.drop_oldest_periodic() {}
        drop(queue);
        self.filled.notify_one();
    }

    /// Nothing more is added; what waits is still sent.
    pub(crate) fn close(&self) {
        self.lock().closed = true;
        self.filled.notify_one();
        self.emptied.notify_one();
    }

    /// Waits for lines and takes all of them; `None` when the queue is closed and empty.
    pub(crate) async fn take(&self) -> Option<String> {
        loop {
            {
                let mut queue = self.lock();
                if !queue.lines.is_empty() {
                    let text = queue.lines.drain(..).map(|line| line.text).collect();
                    (queue.periodic_bytes, queue.answer_bytes) = (0, 0);
                    self.emptied.notify_one();
                    return Some(text);
                }
                if queue.closed {
                    return None;
                }
            }
            self.filled.notified().await;
        }
    }

    /// Whether the client has taken enough of its answers to be given more.
    pub(crate) fn has_room(&self) -> bool {
        let queue = self.lock();
        queue.closed || queue.answer_bytes < MAX_ANSWER_BYTES
    }

    /// Waits until [`Self::has_room`].
    pub(crate) async fn ready_for_answers(&self) {
        while !self.has_room() {
            self.emptied.notified().await;
        }
    }

    /// Periodic lines dropped since the last call.
    pub(crate) fn take_dropped(&self) -> u64 {
        std::mem::take(&mut self.lock().dropped)
    }

    fn lock(&self) -> MutexGuard<'_, Queue> {
        // No code panics while it holds the lock, and the queue is valid after each statement.
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Queue {
    fn bytes(&mut self, periodic: bool) -> &mut usize {
        if periodic { &mut self.periodic_bytes } else { &mut self.answer_bytes }
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
mod tests {
    use super::*;

    fn block_on<T>(future: impl Future<Output = T>) -> T {
        tokio::runtime::Builder::new_current_thread().build().unwrap().block_on(future)
    }

    #[test]
    fn the_oldest_periodic_lines_go_first_and_answers_never() {
        let outbox = Outbox::default();
        let long = "x".repeat(1000);
        outbox.push("CONF first".to_owned(), false);
        (0..1000).for_each(|number| outbox.push(format!("SEN {number} {long}"), true));
        outbox.push("CONF last".to_owned(), false);
        outbox.close();
        let text = block_on(outbox.take()).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!((lines[0], lines[lines.len() - 1]), ("CONF first", "CONF last"));
        let dropped = outbox.take_dropped();
        assert_eq!(lines.len() as u64, 1002 - dropped);
        assert!(dropped > 0 && lines[1].starts_with(&format!("SEN {dropped} ")), "{dropped}: {}", &lines[1][..10]);
        assert_eq!(block_on(outbox.take()), None);
    }
}
