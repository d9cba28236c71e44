//! One viewer. It gets frames, status and notices, and sends requests.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use axum::Extension;
use axum::extract::State;
use axum::extract::ws::{CloseFrame, Message, WebSocket, WebSocketUpgrade};
use axum::response::Response;
use page_protocol::{Actor, Fit, Line, Listen, Measured, Request, Wanted};
use served_world::{Inquiry, Kind, Question};
use tokio::sync::broadcast::Receiver;
use tokio::sync::broadcast::error::RecvError;
use tokio::sync::oneshot;
use tokio::time::timeout;

use crate::access::rights::LOGIN_TIME;
use crate::access::tokens::Role;
use crate::page::shared::{Peer, Site, Visit};
use crate::subscribers::cameras::Wish;

/// Longest text that a viewer may send.
const MAX_TEXT: usize = 1024;

/// Most lines of the wire, and readings, that one viewer gets in a window of real time; nobody can read more.
const MAX_LINES: u64 = 1000;
const LINE_WINDOW: Duration = Duration::from_secs(1);

/// Least time between two questions about room for a robot: one may take the world's thread some milliseconds.
const FIT_INTERVAL: Duration = Duration::from_millis(50);

/// WebSocket close code: against the rules of the server.
const NO_ENTRY: u16 = 1008;

pub(crate) async fn upgrade(
    State(site): State<Arc<Site>>,
    Extension(visit): Extension<Arc<Visit>>,
    Extension(peer): Extension<Peer>,
    socket: WebSocketUpgrade,
) -> Response {
    socket.max_message_size(MAX_TEXT).on_upgrade(move |socket| async move {
        let inquiry = |site: &Site| site.entrance.guest(Kind::Page);
        let (controls, fits) = (inquiry(&site), inquiry(&site));
        let actor = Actor::page(site.pages.fetch_add(1, Ordering::Relaxed) + 1, peer.address);
        let wish = site.channels.wish();
        let (listen, shown) = (Listen::default(), (Instant::now(), 0));
        let mut viewer = Viewer {
            socket,
            site,
            actor,
            peer,
            refusal: None,
            controls,
            fits,
            lines: None,
            readings: None,
            listen,
            wish,
            shown,
            wanted: None,
            fit: None,
            next_fit: tokio::time::Instant::now(),
            visit,
        };
        // A viewer that has left or does not read needs no farewell.
        let _ = viewer.run().await;
    })
}

struct Viewer {
    socket: WebSocket,
    site: Arc<Site>,
    /// Its name, as shown to everyone.
    actor: Actor,
    peer: Peer,
    /// The reason why it may not control the world, if any.
    refusal: Option<&'static str>,
    /// The ways of its requests and of its questions about room to the world.
    controls: Inquiry,
    fits: Inquiry,
    /// The lines of the wire, if it wants them.
    lines: Option<Receiver<Arc<Line>>>,
    /// The readings of robots, if it wants some.
    readings: Option<Receiver<Arc<Measured>>>,
    listen: Listen,
    wish: Wish,
    /// Start of the current window, and lines and readings counted in it.
    shown: (Instant, u64),
    /// The question about room that waits. Until it is asked, no more messages are read.
    wanted: Option<Wanted>,
    /// The answer that the world owes.
    fit: Option<oneshot::Receiver<Fit>>,
    /// Earliest time of the next question about room.
    next_fit: tokio::time::Instant,
    visit: Arc<Visit>,
}

/// The viewer has left.
struct Gone;

impl Viewer {
    async fn run(&mut self) -> Result<(), Gone> {
        self.log_in().await?;
        let mut frames = self.site.channels.frames();
        let mut statuses = self.site.channels.statuses();
        let mut notices = self.site.channels.notices();
        let mut scans = self.site.channels.scans();
        let mut pictures = self.site.channels.pictures();
        let you = self.actor.0.clone();
        self.tell(&page_protocol::Message::Greeting { you: &you, refused: self.refusal }).await?;
        loop {
            tokio::select! {
                changed = statuses.changed() => {
                    changed.map_err(|_| Gone)?;
                    let status = statuses.borrow_and_update().clone();
                    self.send(Message::text(status.as_ref())).await?;
                }
                changed = frames.changed() => {
                    changed.map_err(|_| Gone)?;
                    let frame = frames.borrow_and_update().clone();
                    self.send(Message::Binary(frame)).await?;
                }
                notice = notices.recv() => match notice {
                    Ok(notice) => self.say(&notice).await?,
                    Err(RecvError::Lagged(missed)) => self.tell(&page_protocol::Message::Missed(missed)).await?,
                    Err(RecvError::Closed) => return Err(Gone),
                },
                scan = scans.recv() => match scan {
                    Ok(scan) => self.send(Message::Binary(scan)).await?,
                    Err(RecvError::Lagged(_)) => {}
                    Err(RecvError::Closed) => return Err(Gone),
                },
                picture = pictures.recv() => match picture {
                    Ok(picture) if self.wish.has(picture.robot) => self.send(Message::Binary(picture.message)).await?,
                    // The next picture replaces those that it has missed.
                    Ok(_) | Err(RecvError::Lagged(_)) => {}
                    Err(RecvError::Closed) => return Err(Gone),
                },
                line = next(&mut self.lines) => self.send_counted(line, |line| page_protocol::Message::Line(line).text()).await?,
                measured = next(&mut self.readings) => {
                    if !measured.as_ref().is_ok_and(|measured| !self.listen.robots.contains(&measured.robot)) {
                        self.send_counted(measured, |measured| page_protocol::Message::Reading(measured).text()).await?;
                    }
                }
                fit = answer(&mut self.fit) => {
                    self.fit = None;
                    self.tell(&page_protocol::Message::Fit(fit.map_err(|_| Gone)?)).await?;
                }
                () = tokio::time::sleep_until(self.next_fit), if self.wanted.is_some() && self.fit.is_none() => {
                    self.ask_fit().await?;
                }
                received = self.socket.recv(), if self.wanted.is_none() => self.take(received).await?,
            }
        }
    }

    /// Takes the first message as the page's token, if the server has tokens.
    async fn log_in(&mut self) -> Result<(), Gone> {
        let token = match self.site.access.is_open() {
            true => None,
            false => {
                let received = tokio::select! {
                    received = timeout(LOGIN_TIME, self.socket.recv()) => received,
                    () = self.visit.dropped() => return Err(Gone),
                };
                match received {
                    Ok(Some(Ok(Message::Text(text)))) => match Request::read(&text) {
                        Ok(Request::Token(token)) => Some(token),
                        Ok(Request::Fit(_) | Request::Echo(_) | Request::Listen(_) | Request::Control(_)) | Err(_) => {
                            None
                        }
                    },
                    Ok(Some(Ok(_))) | Err(_) => None,
                    Ok(Some(Err(_)) | None) => return Err(Gone),
                }
            }
        };
        let Site { access, world_control, .. } = &*self.site;
        let refusal = match access.rights(token.as_deref(), &[Role::Viewer]) {
            Ok(_) if !self.visit.admit() => "too many pages are open".to_owned(),
            Ok(rights) => {
                self.refusal = access.refusal(&rights, *world_control, self.peer.address, self.peer.own);
                return Ok(());
            }
            Err(refusal) => format!("{refusal}: expected {{\"token\":\"..\"}} with the role viewer first"),
        };
        self.send(Message::Close(Some(CloseFrame { code: NO_ENTRY, reason: refusal.into() }))).await?;
        Err(Gone)
    }

    /// Sends a line or a reading, if not too many were sent in this window.
    async fn send_counted<T>(
        &mut self,
        news: Result<Arc<T>, RecvError>,
        text: impl FnOnce(&T) -> String,
    ) -> Result<(), Gone> {
        let missed = match &news {
            Ok(_) => 0,
            Err(RecvError::Lagged(missed)) => *missed,
            Err(RecvError::Closed) => return Err(Gone),
        };
        if self.shown.0.elapsed() >= LINE_WINDOW {
            let surplus = self.shown.1.saturating_sub(MAX_LINES);
            self.shown = (Instant::now(), 0);
            if surplus > 0 {
                self.tell(&page_protocol::Message::Missed(surplus)).await?;
            }
        }
        self.shown.1 += 1 + missed;
        match news {
            Ok(news) if self.shown.1 <= MAX_LINES => self.send(Message::text(text(&news))).await,
            _ => Ok(()),
        }
    }

    async fn take(&mut self, received: Option<Result<Message, axum::Error>>) -> Result<(), Gone> {
        let request = match received {
            Some(Ok(Message::Text(text))) => text,
            Some(Ok(Message::Binary(_) | Message::Ping(_) | Message::Pong(_))) => return Ok(()),
            Some(Ok(Message::Close(_)) | Err(_)) | None => return Err(Gone),
        };
        match Request::read(&request) {
            Err(reason) => return self.say(&format!("not understood: {reason}")).await,
            Ok(Request::Token(_)) => {}
            Ok(Request::Listen(listen)) => {
                let channels = &self.site.channels;
                self.lines = listen.wire.then(|| self.lines.take().unwrap_or_else(|| channels.lines()));
                let are_wanted = !listen.robots.is_empty();
                self.readings = are_wanted.then(|| self.readings.take().unwrap_or_else(|| channels.readings()));
                self.wish.set(&listen.cameras);
                self.listen = listen;
            }
            Ok(Request::Fit(wanted)) => self.wanted = Some(wanted),
            Ok(Request::Echo(number)) => return self.tell(&page_protocol::Message::Echo(number)).await,
            Ok(Request::Control(control)) => match self.refusal {
                Some(reason) => return self.say(&format!("not done: {reason}")).await,
                None => return self.controls.send(Question::Control(control, self.actor.clone())).await.ok_or(Gone),
            },
        }
        Ok(())
    }

    /// Asks the world if a robot has room.
    async fn ask_fit(&mut self) -> Result<(), Gone> {
        let Some(ask) = self.wanted.take() else { return Ok(()) };
        self.next_fit = tokio::time::Instant::now() + FIT_INTERVAL;
        let (answer, answered) = oneshot::channel();
        self.fit = Some(answered);
        self.fits.send(Question::Fit(ask, answer)).await.ok_or(Gone)
    }

    async fn say(&mut self, said: &str) -> Result<(), Gone> {
        self.tell(&page_protocol::Message::Said(said)).await
    }

    async fn tell(&mut self, message: &page_protocol::Message<'_>) -> Result<(), Gone> {
        self.send(Message::text(message.text())).await
    }

    async fn send(&mut self, message: Message) -> Result<(), Gone> {
        match timeout(self.site.stall_timeout, self.socket.send(message)).await {
            Ok(Ok(())) => Ok(()),
            Ok(Err(_)) => Err(Gone),
            Err(_) => {
                tracing::info!("a viewer takes nothing and is disconnected");
                Err(Gone)
            }
        }
    }
}

/// Returns the next message of a channel if it is wanted; otherwise never completes.
async fn next<T: Clone>(channel: &mut Option<Receiver<T>>) -> Result<T, RecvError> {
    match channel {
        Some(channel) => channel.recv().await,
        None => std::future::pending().await,
    }
}

/// Returns the answer to a question if one was asked; otherwise never completes.
async fn answer<T>(asked: &mut Option<oneshot::Receiver<T>>) -> Result<T, oneshot::error::RecvError> {
    match asked {
        Some(asked) => asked.await,
        None => std::future::pending().await,
    }
}
