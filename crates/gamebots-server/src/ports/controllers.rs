//! One client: bytes become commands to the world, and lines from its outbox become bytes.

use std::sync::Arc;
use std::time::Duration;

use gamebots_proto::ports::read_login;
use gamebots_proto::{Dialect, Framing, Problem};
use outbox::{Outbox, Taken};
use served_world::{Budgets, Entrance, Session};
use sessions::Request;
use tokio::io::{AsyncWrite, AsyncWriteExt};
use tokio::net::tcp::OwnedReadHalf;
use tokio::time::{Instant, sleep_until, timeout};
use tracing::info;

use crate::access::login::Accepted;
use crate::access::rights::{Access, WorldControl};
use crate::door::lines::{End, Reader};

/// Least time between two lines sent in separate segments. A script that takes one `recv` for one line has read the first by
/// then.
const LINE_INTERVAL: Duration = Duration::from_millis(2);
/// Most lines handed to the world at once. It bounds the lines that wait for one client, some 100 kB.
const MAX_REQUESTS: usize = 256;

/// Rules of a controllers' port.
#[derive(Clone)]
pub(crate) struct Rules {
    /// The dialect of all lines; if none, robots decide.
    pub(crate) dialect: Option<Dialect>,
    pub(crate) access: Access,
    pub(crate) world_control: WorldControl,
    /// True if the world has a league: in one, not everybody may be a world controller.
    pub(crate) is_league: bool,
    /// Time after which a client that reads nothing is disconnected.
    pub(crate) stall_timeout: Duration,
    /// Limits of what is logged about an address.
    pub(crate) budgets: Budgets,
}

/// Serves a client until it leaves, or is disconnected because it does not read.
pub(crate) async fn serve(accepted: Accepted, rules: Rules, entrance: Entrance) {
    let id = entrance.next_session();
    let Accepted { stream, peer: address, rights } = accepted;
    let host = address.ip();
    if rules.budgets.allow(host, std::time::Instant::now()) {
        info!(connection = id, peer = %address, "client connected");
    }
    // Lines would wait for each other (Nagle's algorithm).
    let _ = stream.set_nodelay(true);
    let refusal = match stream.local_addr().ok() {
        _ if rules.access.is_open() && !rules.is_league => None,
        Some(own) => rules.access.refusal(&rights, rules.world_control, host, own.ip()),
        None => Some("its address is unknown"),
    };
    let Rules { dialect, stall_timeout, budgets, .. } = rules;
    let admit = move |line: Result<String, Problem>| {
        let is_login = |text: &String| read_login(text).is_some();
        // A token must not get into a log, so a second LOGIN is left out, too.
        (!line.as_ref().is_ok_and(is_login)).then(|| rights.admit(Request::read(line), refusal))
    };
    let (read, write) = stream.into_split();
    let outbox = Arc::new(Outbox::default());
    let Ok(session) = entrance.open(id, address, dialect, outbox.clone()) else { return };
    let writer = write_lines(write, &outbox, stall_timeout);
    tokio::pin!(writer);
    let reader = read_lines(&session, read, admit, &outbox);
    let (reason, may_still_write) = tokio::select! {
        reason = reader => (reason, true),
        reason = &mut writer => (reason, false),
    };
    if !may_still_write {
        // Frees requests that wait for room in this client's outbox.
        outbox.close();
    }
    // The world closes the outbox after this event, so that the last answers are still sent.
    let told = session.close().is_ok();
    if told && may_still_write {
        writer.await;
    }
    if budgets.allow(host, std::time::Instant::now()) {
        info!(connection = id, reason, "client disconnected");
    }
}

/// Reads until the client ends the stream. `admit` makes a line a request, or leaves it out.
async fn read_lines(
    session: &Session,
    read: OwnedReadHalf,
    admit: impl Fn(Result<String, Problem>) -> Option<Request>,
    outbox: &Outbox,
) -> &'static str {
    let mut reader = Reader::new(read, Framing::default());
    loop {
        outbox.ready_for_answers().await;
        let (lines, end) = reader.next().await;
        let http = (end == Some(End::Http)).then(|| Request::read(Err(Problem::Http)));
        let mut requests = lines.into_iter().filter_map(&admit).chain(http).peekable();
        while requests.peek().is_some() {
            let requests = requests.by_ref().take(MAX_REQUESTS).collect();
            if session.send(requests).await.is_err() {
                return "the server stops";
            }
        }
        match end {
            None => {}
            Some(End::Closed) => return "closed by the client",
            Some(End::Reset) => return "reset by the client",
            Some(End::Http) => return "it speaks HTTP",
        }
    }
}

/// Writes lines as they come. Paced lines leave in separate segments, [`LINE_INTERVAL`] apart.
async fn write_lines(mut write: impl AsyncWrite + Unpin, outbox: &Outbox, stall_timeout: Duration) -> &'static str {
    let mut next = Instant::now();
    while let Some(Taken { text, is_paced }) = outbox.take().await {
        if is_paced {
            sleep_until(next).await;
        }
        let mut rest = text.as_bytes();
        while !rest.is_empty() {
            match timeout(stall_timeout, write.write(rest)).await {
                Ok(Ok(count)) if count > 0 => rest = rest.get(count..).unwrap_or_default(),
                Ok(_) => return "reset by the client",
                Err(_) => return "disconnected: it does not read",
            }
        }
        next = Instant::now() + LINE_INTERVAL;
    }
    "all sent"
}

#[cfg(test)]
mod tests {
    use std::pin::Pin;
    use std::sync::Mutex;
    use std::task::{Context, Poll};

    use tokio::time::sleep;

    use super::*;

    /// Every written piece, and its time.
    #[derive(Clone, Default)]
    struct Pieces(Arc<Mutex<Vec<(Instant, String)>>>);

    impl AsyncWrite for Pieces {
        fn poll_write(self: Pin<&mut Self>, _: &mut Context<'_>, bytes: &[u8]) -> Poll<std::io::Result<usize>> {
            let piece = String::from_utf8_lossy(bytes).into_owned();
            self.0.lock().unwrap_or_else(|error| panic!("{error}")).push((Instant::now(), piece));
            Poll::Ready(Ok(bytes.len()))
        }

        fn poll_flush(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<std::io::Result<()>> {
            Poll::Ready(Ok(()))
        }

        fn poll_shutdown(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<std::io::Result<()>> {
            Poll::Ready(Ok(()))
        }
    }

    /// Writes some lines of one step. Returns the number of written pieces and the shortest time between two of them.
    async fn pieces(lines: usize, is_paced: bool) -> (usize, Duration) {
        let (written, outbox) = (Pieces::default(), Outbox::default());
        outbox.set_paced(is_paced);
        (0..lines).for_each(|number| outbox.push(format!("SEN {number}"), true));
        let closer = async {
            while outbox.waiting_bytes() > 0 {
                sleep(LINE_INTERVAL).await;
            }
            outbox.close();
        };
        let writer = write_lines(written.clone(), &outbox, Duration::from_secs(30));
        assert_eq!(tokio::join!(writer, closer).0, "all sent");
        let written = written.0.lock().unwrap_or_else(|error| panic!("{error}"));
        let text: String = written.iter().map(|(_, piece)| piece.as_str()).collect();
        assert_eq!(text.lines().count(), lines);
        let gaps = written.windows(2).map(|pair| pair[1].0 - pair[0].0);
        (written.len(), gaps.min().unwrap_or_default())
    }

    #[tokio::test]
    async fn lines_of_one_step_leave_one_by_one_in_real_time_unless_the_client_is_behind() {
        for (lines, is_paced, expected) in [(12, true, 12), (12, false, 1), (1000, true, 1), (1, true, 1)] {
            let (count, gap) = pieces(lines, is_paced).await;
            assert_eq!(count, expected, "{lines} lines, paced: {is_paced}");
            assert!(count == 1 || gap >= LINE_INTERVAL, "{lines} lines: {gap:?} apart");
        }
    }
}
