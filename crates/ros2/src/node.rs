//! A node of ROS 2: topics by name. DDS is a process of its own, which this starts, tells, hears, and starts again if it ends. Clients of
//! rosbridge share the topics.

use std::collections::BTreeMap;
use std::io::{BufReader, BufWriter, Write};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver as Orders, SyncSender, TrySendError, sync_channel};
use std::time::{Duration, Instant};

use ros2_topics::{Message, Sink, cdr, is_latched, json};
use rustdds::SampleIdentity;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use tokio::sync::mpsc::error::TryRecvError;
use tokio::sync::mpsc::{Receiver, Sender, channel};
use tracing::{debug, warn};

use crate::pipe::{self, Event, Order, Terms};
use crate::rosbridge::{Asking, Hub};
use crate::{Dds, StartError};

/// Orders to the process that wait. Further messages are left out; if it takes nothing for [`PATIENCE`], it is ended.
const MOST_ORDERS: usize = 1024;
/// Events of the process that wait. It waits for room, and so do those who flood it.
const MOST_EVENTS: usize = 64;
/// Messages of others on a topic that wait. Further ones are left out.
const MOST_HEARD: usize = 64;
/// Longest time without taking an order.
const PATIENCE: Duration = Duration::from_secs(2);
/// Longest time to join the domain, and to leave it.
const JOIN_TIME: Duration = Duration::from_secs(10);
const LEAVE_TIME: Duration = Duration::from_secs(1);
/// Time between two starts of the process.
const REST: Duration = Duration::from_secs(1);

/// Messages of others on one topic as CDR, each with its sender, whom a reply names.
pub(crate) type Incoming = Receiver<(Caller, Vec<u8>)>;

/// A sender of a message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Caller {
    /// A node, by the identity of its request.
    Dds(SampleIdentity),
    /// A client of rosbridge that asks a service.
    Rosbridge(Asking),
    /// Nobody who waits for a reply.
    Nameless,
}

/// A reply of a service.
pub(crate) enum Reply {
    Dds(Order),
    Rosbridge(Asking, Value),
}

/// Owner of topics: a robot by its number, or the world.
pub(crate) type Owner = Option<u64>;

/// A node. Its topics, subscriptions and services stay when its process is started again.
pub(crate) struct Node {
    /// DDS, unless rosbridge is all.
    dds: Option<Dds>,
    process: Option<Process>,
    pub(crate) hub: Hub,
    /// Time of the last start.
    started: Instant,
    topics: BTreeMap<String, Outgoing>,
    readers: BTreeMap<u32, Reader>,
    /// The number of the next topic, subscription or service.
    next: u32,
    /// Owner of the topics that the next messages open.
    owner: Owner,
    /// Messages that found no room here, and in the process.
    refused: [u64; 2],
    /// True if it has been said that the process ended.
    has_complained: bool,
}

/// A topic that it publishes.
struct Outgoing {
    number: u32,
    /// Its type, as in `geometry_msgs/Twist`, and that in DDS.
    name: &'static str,
    kind: String,
    /// Makes JSON from CDR.
    json: fn(&[u8]) -> Option<Value>,
    terms: Terms,
    owner: Owner,
    /// Subscribers now.
    subscribers: i32,
    /// The last message, if late subscribers get it.
    last: Option<Vec<u8>>,
}

/// A subscription, or a service.
struct Reader {
    owner: Owner,
    /// Topic or service.
    name: String,
    /// Its type, as in `geometry_msgs/Twist`.
    kind: String,
    is_service: bool,
    /// Makes CDR from JSON.
    cdr: ReadJson,
    order: Order,
    heard: Sender<(Caller, Vec<u8>)>,
}

/// A function that makes CDR from JSON, or says why it cannot.
pub(crate) type ReadJson = fn(&str) -> Result<Vec<u8>, String>;

/// Makes the CDR of a message from its JSON.
///
/// # Errors
/// When it is no such message.
pub(crate) fn cdr_of<T: Serialize + DeserializeOwned>(text: &str) -> Result<Vec<u8>, String> {
    let message: T = json::read(text).map_err(|error| error.to_string())?;
    cdr::write(&message).map_err(|error| error.to_string())
}

/// The process of DDS.
struct Process {
    child: Child,
    orders: SyncSender<Order>,
    events: Receiver<Event>,
    /// Time of the first order of those that it did not take.
    stuck_since: Option<Instant>,
    /// True if its end of the pipe is closed.
    has_ended: bool,
}

impl Process {
    /// Starts the process and joins a domain.
    fn start(Dds { program, domain, address }: &Dds) -> Result<Self, StartError> {
        let (domain, address) = (*domain, *address);
        let failed = |why: String| StartError::Join(why);
        let (first, rest) = program.split_first().ok_or_else(|| failed("no program for the node".to_owned()))?;
        let mut command = Command::new(first);
        // What it says when its memory ends is not for users.
        command.args(rest).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        // Ctrl-C at the terminal is for the server, which then closes the pipe.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let mut child = command.spawn().map_err(|error| failed(format!("{}: {error}", first.display())))?;
        let pipes = child.stdin.take().zip(child.stdout.take());
        let (stdin, stdout) = pipes.ok_or_else(|| failed("no pipes".to_owned()))?;
        let (orders, waiting) = sync_channel(MOST_ORDERS);
        let (hear, mut events) = channel(MOST_EVENTS);
        let thread = |name: &str| std::thread::Builder::new().name(name.to_owned());
        thread("ROS 2 orders").spawn(move || hand_over(stdin, &waiting))?;
        thread("ROS 2 events").spawn(move || {
            let mut pipe = BufReader::new(stdout);
            while let Ok(event) = pipe::read::<Event>(&mut pipe) {
                if hear.blocking_send(event).is_err() {
                    return;
                }
            }
        })?;
        // There is room for the first order.
        let _ = orders.try_send(Order::Join { domain, address });
        let end = Instant::now() + JOIN_TIME;
        let joined = loop {
            match events.try_recv() {
                Ok(Event::Joined(joined)) => break joined,
                Ok(_) => {}
                Err(TryRecvError::Disconnected) => break Err("its process ended".to_owned()),
                Err(_) if Instant::now() > end => break Err(format!("not within {} s", JOIN_TIME.as_secs())),
                Err(_) => std::thread::sleep(Duration::from_millis(2)),
            }
        };
        let process = Self { child, orders, events, stuck_since: None, has_ended: false };
        joined.map(|()| process).map_err(failed)
    }

    /// Hands over an order. False if there is no room.
    fn order(&mut self, order: Order) -> bool {
        match self.orders.try_send(order) {
            Ok(()) => {
                self.stuck_since = None;
                true
            }
            Err(TrySendError::Full(_) | TrySendError::Disconnected(_)) => {
                self.stuck_since.get_or_insert_with(Instant::now);
                false
            }
        }
    }

    /// True if it has ended, or takes nothing.
    fn is_gone(&mut self) -> bool {
        self.stuck_since.is_some_and(|since| since.elapsed() > PATIENCE) || !matches!(self.child.try_wait(), Ok(None))
    }
}

impl Drop for Process {
    /// Closes the pipe, which asks the process to leave, and waits for it a little.
    fn drop(&mut self) {
        let (closed, _) = sync_channel(0);
        self.orders = closed;
        let end = Instant::now() + LEAVE_TIME;
        while matches!(self.child.try_wait(), Ok(None)) && Instant::now() < end {
            std::thread::sleep(Duration::from_millis(5));
        }
        // It may have ended.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Writes orders to the process, until it or the node is gone.
fn hand_over(stdin: ChildStdin, waiting: &Orders<Order>) {
    let mut pipe = BufWriter::new(stdin);
    while let Ok(order) = waiting.recv() {
        let written = pipe::write(&mut pipe, &order);
        // Orders that wait go with it.
        let rest = written.and_then(|()| waiting.try_iter().try_for_each(|order| pipe::write(&mut pipe, &order)));
        if rest.and_then(|()| pipe.flush()).is_err() {
            return;
        }
    }
}

impl Node {
    /// Its name.
    pub(crate) const NAME: &str = "/usarsim";

    /// Starts the process of DDS, if there shall be one, and joins its domain.
    pub(crate) fn join(dds: Option<Dds>, hub: Hub) -> Result<Self, StartError> {
        let process = dds.as_ref().map(Process::start).transpose()?;
        Ok(Self {
            dds,
            process,
            hub,
            started: Instant::now(),
            topics: BTreeMap::new(),
            readers: BTreeMap::new(),
            next: 0,
            owner: None,
            refused: [0; 2],
            has_complained: false,
        })
    }

    /// Sets the owner of the topics that the next messages open.
    pub(crate) fn own(&mut self, owner: Owner) {
        self.owner = owner;
    }

    /// True if a topic has subscribers.
    pub(crate) fn has_subscribers(&self, topic: &str) -> bool {
        self.hub.wants(topic) || self.topics.get(topic).is_some_and(|outgoing| outgoing.subscribers > 0)
    }

    /// Opens a topic without a message, so that others can subscribe to it.
    pub(crate) fn open<T: Message>(&mut self, topic: &str) {
        if self.topics.contains_key(topic) {
            return;
        }
        let terms = match T::NAME {
            "sensor_msgs/CompressedImage" | "sensor_msgs/Image" | "sensor_msgs/PointCloud2" => Terms::Large,
            _ if is_latched(topic) => Terms::Latched,
            _ => Terms::Usual,
        };
        let (number, owner) = (self.number(), self.owner);
        let json = |bytes: &[u8]| json::write(&cdr::read::<T>(bytes).ok()?).ok();
        let (name, kind) = (T::NAME, T::dds_name());
        let outgoing = Outgoing { number, name, kind, json, terms, owner, subscribers: 0, last: None };
        self.order(outgoing.order(topic));
        self.topics.insert(topic.to_owned(), outgoing);
    }

    /// Subscribes to a topic.
    pub(crate) fn listen<T: Message>(&mut self, topic: &str) -> Incoming {
        let (number, name, kind) = (self.number(), topic.to_owned(), T::NAME.to_owned());
        let order = Order::Listen { number, topic: name.clone(), kind: T::dds_name() };
        let (heard, incoming) = channel(MOST_HEARD);
        let owner = self.owner;
        self.hear(number, Reader { owner, name, kind, is_service: false, cdr: cdr_of::<T>, order, heard });
        incoming
    }

    /// Offers a service by its name and type, as in `std_srvs/Trigger`. `cdr` reads the JSON of a request. Returns its requests and its number,
    /// for replies.
    pub(crate) fn offer(&mut self, name: String, kind: String, cdr: ReadJson) -> (Incoming, u32) {
        let number = self.number();
        let order = Order::Offer { number, service: name.clone(), kind: kind.clone() };
        let (heard, incoming) = channel(MOST_HEARD);
        let owner = self.owner;
        self.hear(number, Reader { owner, name, kind, is_service: true, cdr, order, heard });
        (incoming, number)
    }

    fn hear(&mut self, number: u32, reader: Reader) {
        self.order(reader.order.clone());
        self.readers.insert(number, reader);
    }

    /// Replies to whoever asked a service.
    pub(crate) fn reply(&mut self, reply: Reply) {
        match reply {
            Reply::Dds(order) => self.order(order),
            Reply::Rosbridge(asking, values) => self.hub.answer(asking, Ok(values)),
        }
    }

    /// Lists the topics that it publishes, each with its type.
    pub(crate) fn topics(&self) -> impl Iterator<Item = (&str, &str)> {
        let topics = self.topics.iter().map(|(topic, outgoing)| (topic.as_str(), outgoing.name));
        topics.chain(self.readers(false).map(|reader| (reader.name.as_str(), reader.kind.as_str())))
    }

    /// Lists the services that it offers, each with its type.
    pub(crate) fn services(&self) -> impl Iterator<Item = (&str, &str)> {
        self.readers(true).map(|reader| (reader.name.as_str(), reader.kind.as_str()))
    }

    fn readers(&self, is_service: bool) -> impl Iterator<Item = &Reader> {
        self.readers.values().filter(move |reader| reader.is_service == is_service)
    }

    /// Returns the type of a topic that it publishes.
    pub(crate) fn kind(&self, topic: &str) -> Option<&'static str> {
        self.topics.get(topic).map(|outgoing| outgoing.name)
    }

    /// Returns the JSON of the last message of a topic, if late subscribers get it.
    pub(crate) fn latched(&self, topic: &str) -> Option<Value> {
        let Outgoing { last, json, .. } = self.topics.get(topic)?;
        json(last.as_ref()?)
    }

    /// Hears a message in JSON on a topic; without a type it is of the first that it fits.
    ///
    /// # Errors
    /// When nobody listens to such messages.
    pub(crate) fn hear_json(&self, topic: &str, kind: Option<&str>, message: &str) -> Result<(), String> {
        let mut why = None;
        for reader in self.readers(false).filter(|reader| reader.name == topic) {
            if kind.is_some_and(|kind| kind != reader.kind) {
                why.get_or_insert_with(|| format!("type {}: expected {}", kind.unwrap_or_default(), reader.kind));
                continue;
            }
            match (reader.cdr)(message) {
                // Whoever floods misses some.
                Ok(message) => {
                    let _ = reader.heard.try_send((Caller::Nameless, message));
                    return Ok(());
                }
                Err(wrong) => _ = why.get_or_insert(wrong),
            }
        }
        Err(why.unwrap_or_else(|| "no robot listens there".to_owned()))
    }

    /// Asks a service with arguments in JSON. The reply follows.
    ///
    /// # Errors
    /// When there is no such service, the arguments are not its, or too many wait for it.
    pub(crate) fn ask_json(&self, asking: &Asking, arguments: &str) -> Result<(), String> {
        let reader = self.readers(true).find(|reader| reader.name == asking.service);
        let reader = reader.ok_or_else(|| format!("no service {}: /rosapi/services lists them", asking.service))?;
        let request = (reader.cdr)(arguments)?;
        let sent = reader.heard.try_send((Caller::Rosbridge(asking.clone()), request));
        sent.map_err(|_| "too many calls wait: try again".to_owned())
    }

    /// Closes everything of an owner.
    pub(crate) fn close(&mut self, owner: Owner) {
        let topics = self.topics.extract_if(.., |_, outgoing| outgoing.owner == owner);
        let topics = topics.map(|(_, outgoing)| outgoing.number);
        let readers = self.readers.extract_if(.., |_, reader| reader.owner == owner).map(|(number, _)| number);
        let numbers: Vec<u32> = topics.chain(readers).collect();
        numbers.into_iter().for_each(|number| self.order(Order::Close { number }));
    }

    /// Returns the number of messages that found no room, because a subscriber did not take earlier ones.
    pub(crate) fn refused(&self) -> u64 {
        self.refused.iter().sum::<u64>() + self.hub.refused
    }

    /// Waits for something that the process says. It says nothing more when it has ended.
    pub(crate) async fn heard(&mut self) -> Event {
        match &mut self.process {
            Some(process) if !process.has_ended => match process.events.recv().await {
                Some(event) => event,
                None => {
                    process.has_ended = true;
                    std::future::pending().await
                }
            },
            _ => std::future::pending().await,
        }
    }

    /// Starts the process again if it has ended or stands still. To be called now and then.
    pub(crate) fn watch(&mut self) {
        if self.process.as_mut().is_some_and(Process::is_gone) {
            if !std::mem::replace(&mut self.has_complained, true) {
                warn!("ROS 2: the process of DDS ended or stood still, as after forged packets: it is started again");
            }
            // It does not leave by itself.
            self.process.iter_mut().for_each(|process| _ = process.child.kill());
            self.process = None;
        }
        if self.process.is_none() && self.started.elapsed() > REST {
            self.start_again();
        }
        self.hub.sweep();
    }

    /// Hands on what the process has said.
    pub(crate) fn take(&mut self, event: Event) {
        match event {
            Event::Joined(_) => {}
            Event::Subscribers { number, count } => {
                let outgoing = self.topics.values_mut().find(|outgoing| outgoing.number == number);
                outgoing.into_iter().for_each(|outgoing| outgoing.subscribers = count);
            }
            Event::Heard { number, message } => self.hand_on(number, Caller::Nameless, message),
            Event::Asked { number, from, message } => self.hand_on(number, Caller::Dds(from), message),
            Event::Refused(count) => self.refused[1] = count,
        }
    }

    fn hand_on(&self, number: u32, from: Caller, message: Vec<u8>) {
        // Whoever is flooded misses some.
        if let Some(reader) = self.readers.get(&number) {
            let _ = reader.heard.try_send((from, message));
        }
    }

    fn start_again(&mut self) {
        let Some(dds) = &self.dds else { return };
        self.started = Instant::now();
        self.refused = [self.refused.iter().sum(), 0];
        match Process::start(dds) {
            Ok(process) => self.process = Some(process),
            Err(error) => return debug!("{error}"),
        }
        let Self { topics, readers, process, .. } = self;
        let Some(process) = process else { return };
        for (topic, outgoing) in topics {
            outgoing.subscribers = 0;
            process.order(outgoing.order(topic));
            let last = outgoing.last.clone().map(|message| Order::Publish { number: outgoing.number, message });
            last.into_iter().for_each(|order| _ = process.order(order));
        }
        readers.values().for_each(|reader| _ = process.order(reader.order.clone()));
    }

    fn number(&mut self) -> u32 {
        self.next += 1;
        self.next
    }

    /// Gives the process an order, if it has room.
    fn order(&mut self, order: Order) {
        if self.dds.is_none() {
            return;
        }
        let is_taken = self.process.as_mut().is_some_and(|process| process.order(order));
        self.refused[0] += u64::from(!is_taken);
    }
}

impl Outgoing {
    fn order(&self, topic: &str) -> Order {
        let Self { number, kind, terms, .. } = self;
        Order::Open { number: *number, topic: topic.to_owned(), kind: kind.clone(), terms: *terms }
    }
}

impl Sink for Node {
    type Error = std::convert::Infallible;

    /// Publishes a message, if somebody subscribes to it or it is for late subscribers.
    fn publish<T: Message>(&mut self, _: f64, topic: &str, message: &T) -> Result<(), Self::Error> {
        self.open::<T>(topic);
        self.hub.publish(topic, || json::write(message).ok());
        let Some(outgoing) = self.topics.get_mut(topic) else { return Ok(()) };
        if outgoing.subscribers <= 0 && outgoing.terms != Terms::Latched {
            return Ok(());
        }
        match cdr::write(message) {
            Ok(message) => {
                if outgoing.terms == Terms::Latched {
                    outgoing.last = Some(message.clone());
                }
                let number = outgoing.number;
                self.order(Order::Publish { number, message });
            }
            Err(error) => debug!("no message on {topic}: {error}"),
        }
        Ok(())
    }
}
