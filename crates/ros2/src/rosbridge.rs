//! Clients of rosbridge, which get the topics of the node as JSON, and their subscriptions.
//!
//! This end has no sockets: whoever has one opens a [`Speaker`] and a [`Listener`] for it.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::time::Duration;

use serde_json::{Value, json};
use tokio::sync::mpsc::{Receiver, Sender, UnboundedReceiver, UnboundedSender, channel, unbounded_channel};
use tokio::time::Instant;

use crate::clock::Clock;

/// Longest text that a client may say, bytes: a trajectory of some thousand points.
pub const LONGEST_TEXT: usize = 256 << 10;
/// Texts of all clients that wait. Clients wait for room.
const MOST_SAID: usize = 32;
/// Bytes that wait for a client. Further texts are left out and counted.
const MOST_UNREAD: usize = 4 << 20;
/// Most subscriptions, and most advertised topics, of a client.
const MOST_TOPICS: usize = 200;

/// The entrance of clients.
#[derive(Debug, Clone)]
pub struct Rosbridge {
    said: Sender<Said>,
    /// Number of the last client.
    last: Arc<AtomicU64>,
}

/// News of a client.
#[derive(Debug)]
pub(crate) struct Said {
    client: u64,
    what: What,
}

#[derive(Debug)]
enum What {
    Came(Client),
    Text(String),
}

/// The end of a client by which it speaks.
#[derive(Debug)]
pub struct Speaker {
    client: u64,
    said: Sender<Said>,
}

/// The end of a client by which it hears.
#[derive(Debug)]
pub struct Listener {
    texts: UnboundedReceiver<Arc<str>>,
    unread: Arc<AtomicUsize>,
}

/// The node has ended.
#[derive(Debug, thiserror::Error)]
#[error("the node of ROS 2 has ended")]
pub struct NodeEnded;

impl Rosbridge {
    pub(crate) fn new() -> (Self, Receiver<Said>) {
        let (said, received) = channel(MOST_SAID);
        (Self { said, last: Arc::default() }, received)
    }

    /// Opens the ends of a new client, which may control the world or not. It leaves when the listener is dropped.
    ///
    /// # Errors
    /// When the node has ended.
    pub async fn open(&self, may_control: bool) -> Result<(Speaker, Listener), NodeEnded> {
        let client = self.last.fetch_add(1, Ordering::Relaxed) + 1;
        let ((send, texts), unread) = (unbounded_channel(), Arc::<AtomicUsize>::default());
        let speaker = Speaker { client, said: self.said.clone() };
        let advertised = BTreeMap::new();
        speaker.send(What::Came(Client { texts: send, unread: unread.clone(), may_control, advertised })).await?;
        Ok((speaker, Listener { texts, unread }))
    }
}

impl Speaker {
    /// Says a text of the protocol. It waits for room.
    ///
    /// # Errors
    /// When the node has ended.
    pub async fn say(&self, text: String) -> Result<(), NodeEnded> {
        self.send(What::Text(text)).await
    }

    async fn send(&self, what: What) -> Result<(), NodeEnded> {
        self.said.send(Said { client: self.client, what }).await.map_err(|_| NodeEnded)
    }
}

impl Listener {
    /// Waits for the next text; `None` when the node has ended.
    pub async fn hear(&mut self) -> Option<Arc<str>> {
        let text = self.texts.recv().await?;
        self.unread.fetch_sub(text.len(), Ordering::Relaxed);
        Some(text)
    }
}

/// A client as the node sees it.
#[derive(Debug)]
struct Client {
    texts: UnboundedSender<Arc<str>>,
    /// Bytes that wait for it.
    unread: Arc<AtomicUsize>,
    may_control: bool,
    /// Types that it has named, by topic.
    advertised: BTreeMap<String, String>,
}

/// A subscription of a client to a topic.
#[derive(Debug)]
struct Subscription {
    client: u64,
    id: String,
    /// Least real time between two messages.
    interval: Duration,
    /// Earliest time of the next.
    next: Instant,
}

/// A client that waits for a reply of a service.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Asking {
    pub(crate) client: u64,
    pub(crate) id: Option<String>,
    pub(crate) service: String,
}

/// The clients and their subscriptions.
pub(crate) struct Hub {
    clients: BTreeMap<u64, Client>,
    /// Subscriptions by topic, those of a client side by side.
    subscriptions: BTreeMap<String, Vec<Subscription>>,
    pub(crate) clock: Clock,
    /// Texts that found no room.
    pub(crate) refused: u64,
}

impl Hub {
    pub(crate) fn new(clock: Clock) -> Self {
        Self { clients: BTreeMap::new(), subscriptions: BTreeMap::new(), clock, refused: 0 }
    }

    /// Takes in a client that has come, or returns what one says.
    pub(crate) fn take(&mut self, Said { client, what }: Said) -> Option<(u64, String)> {
        match what {
            What::Came(came) => {
                self.clients.insert(client, came);
                None
            }
            What::Text(text) => Some((client, text)),
        }
    }

    /// True if a client may control the world.
    pub(crate) fn may_control(&self, client: u64) -> bool {
        self.clients.get(&client).is_some_and(|client| client.may_control)
    }

    /// Notes the type that a client publishes on a topic; without one, that it publishes there no longer.
    ///
    /// # Errors
    /// When it has named too many.
    pub(crate) fn advertise(&mut self, client: u64, topic: String, kind: Option<String>) -> Result<(), String> {
        let Some(Client { advertised, .. }) = self.clients.get_mut(&client) else { return Ok(()) };
        let Some(kind) = kind else {
            advertised.remove(&topic);
            return Ok(());
        };
        if advertised.len() >= MOST_TOPICS {
            return Err(format!("advertise: {MOST_TOPICS} topics are advertised: expected no more"));
        }
        advertised.insert(topic, kind);
        Ok(())
    }

    /// Returns the type that a client has named for a topic.
    pub(crate) fn advertised(&self, client: u64, topic: &str) -> Option<&str> {
        self.clients.get(&client)?.advertised.get(topic).map(String::as_str)
    }

    /// Subscribes a client to a topic. `last` is a message that it gets at once; `interval` is the least real time between two.
    ///
    /// # Errors
    /// When it has too many subscriptions.
    pub(crate) fn subscribe(
        &mut self,
        client: u64,
        topic: String,
        id: String,
        interval: Duration,
        last: Option<&Value>,
    ) -> Result<(), String> {
        if self.subscriptions.values().flatten().filter(|it| it.client == client).count() >= MOST_TOPICS {
            return Err(format!("subscribe: {MOST_TOPICS} subscriptions: expected no more"));
        }
        last.into_iter().for_each(|last| self.tell(client, published(&topic, last).into()));
        let list = self.subscriptions.entry(topic).or_default();
        list.retain(|it| it.client != client || it.id != id);
        list.push(Subscription { client, id, interval, next: Instant::now() });
        list.sort_by_key(|it| it.client);
        Ok(())
    }

    /// Ends a subscription of a client to a topic; without its identity all of them.
    pub(crate) fn unsubscribe(&mut self, client: u64, topic: &str, id: Option<&str>) {
        let Some(list) = self.subscriptions.get_mut(topic) else { return };
        list.retain(|it| it.client != client || id.is_some_and(|id| *id != it.id));
        if list.is_empty() {
            self.subscriptions.remove(topic);
        }
    }

    /// True if a client subscribes to a topic.
    pub(crate) fn wants(&self, topic: &str) -> bool {
        self.subscriptions.contains_key(topic)
    }

    /// Publishes a message to those whose turn it is. `message` makes its JSON.
    pub(crate) fn publish(&mut self, topic: &str, message: impl FnOnce() -> Option<Value>) {
        let Some(subscriptions) = self.subscriptions.get_mut(topic) else { return };
        let now = Instant::now();
        let mut due = Vec::new();
        for subscription in subscriptions.iter_mut().filter(|it| it.next <= now) {
            subscription.next = now + subscription.interval;
            due.push(subscription.client);
        }
        due.dedup();
        let Some(message) = Some(message).filter(|_| !due.is_empty()).and_then(|message| message()) else { return };
        let text: Arc<str> = published(topic, &message).into();
        due.into_iter().for_each(|client| self.tell(client, text.clone()));
    }

    /// Forgets clients that have left.
    pub(crate) fn sweep(&mut self) {
        self.clients.retain(|_, client| !client.texts.is_closed());
        self.subscriptions.retain(|_, list| {
            list.retain(|subscription| self.clients.contains_key(&subscription.client));
            !list.is_empty()
        });
    }

    /// Answers who asked a service: with a value, or the reason why there is none.
    pub(crate) fn answer(&mut self, Asking { client, id, service }: Asking, values: Result<Value, String>) {
        let (values, result) = match values {
            Ok(values) => (values, true),
            Err(why) => (Value::String(why), false),
        };
        let text =
            json!({ "op": "service_response", "id": id, "service": service, "values": values, "result": result });
        self.tell(client, text.to_string().into());
    }

    /// Tells a client what was wrong.
    pub(crate) fn complain(&mut self, client: u64, id: Option<&str>, why: &str) {
        self.tell(client, json!({ "op": "status", "level": "error", "msg": why, "id": id }).to_string().into());
    }

    fn tell(&mut self, client: u64, text: Arc<str>) {
        let Some(client) = self.clients.get(&client) else { return };
        let unread = client.unread.fetch_add(text.len(), Ordering::Relaxed) + text.len();
        if unread > MOST_UNREAD {
            client.unread.fetch_sub(text.len(), Ordering::Relaxed);
            self.refused += 1;
        } else {
            // It may have left.
            let _ = client.texts.send(text);
        }
    }
}

fn published(topic: &str, message: &Value) -> String {
    json!({ "op": "publish", "topic": topic, "msg": message }).to_string()
}
