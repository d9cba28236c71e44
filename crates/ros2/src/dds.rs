//! The process of the node: DDS by the crate `rustdds`, told by the server over a pipe.
//!
//! Names and types are those that rmw_fastrtps and rmw_cyclonedds use: `rt/` before a topic, `rq/` and `rr/` before a service's request and
//! reply. Messages go in and out as bytes of CDR, so there is one type of writers and one of readers.
//!
//! It is a process of its own because RustDDS believes what packets say: one forged HEARTBEAT makes it list 2^62 missing messages
//! (`missing_seqnums` in its `rtps_writer_proxy.rs`), until all memory is taken. Here its memory is limited; it ends, and the server starts
//! it again.

use std::collections::BTreeMap;
use std::io::{BufReader, Write};
use std::net::Ipv4Addr;
use std::time::Duration as Real;

use futures_util::StreamExt;
use ros2_topics::cdr;
use rustdds::bytes::Bytes;
use rustdds::dds::no_key::{DataReader, DataWriter};
use rustdds::no_key::{Decode, DefaultDecoder, DeserializerAdapter, SerializerAdapter};
use rustdds::policy::{Durability, History, ResourceLimits};
use rustdds::{
    DataWriterStatus, DomainParticipant, DomainParticipantBuilder, Duration, GUID, Publisher, QosPolicies,
    QosPolicyBuilder, RTPSEntity, RepresentationIdentifier, StatusEvented, Subscriber, TopicKind, WriteOptionsBuilder,
};
use serde::Serialize;
use tokio::sync::mpsc::{Sender, channel};
use tokio::task::JoinHandle;

use crate::pipe::{self, Event, Order, Terms};

/// Most memory of the process, bytes.
const MOST_MEMORY: u64 = 1 << 30;
/// Orders of the server that wait.
const MOST_ORDERS: usize = 256;
/// Messages of others that wait for the pipe. Those on DDS's side wait for their readers, within the process's memory.
const MOST_EVENTS: usize = 64;
/// Time between two looks at who subscribes.
const LOOK_INTERVAL: Real = Real::from_millis(20);
/// Time for others to hear that readers and writers are gone, before the participant is.
const FAREWELL: Real = Real::from_millis(300);
/// Topic on which each participant says which node has which topics, and its type (rmw_dds_common).
const GRAPH: [&str; 2] = ["ros_discovery_info", "rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_"];
/// Messages that a topic keeps for late or slow subscribers.
const DEPTH: i32 = 10;
/// Messages that wait for subscribers that do not acknowledge them. A killed one is known to be gone after 20 s, and others get nothing new
/// while the room is full: 100 messages a second fit for 40 s.
const MOST_WAITING: i32 = 4000;
/// Pictures and clouds that wait so, which are some 30 kB each and at most 10 a second.
const MOST_PICTURES_WAITING: i32 = 400;

/// A message as bytes of CDR, little endian.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Raw(Bytes);

/// The encoding of [`Raw`]: none.
struct Plain;

/// A message that cannot be read.
#[derive(Debug, thiserror::Error)]
#[error("a message in {0:?}: expected CDR, little endian")]
struct Unreadable(RepresentationIdentifier);

impl SerializerAdapter<Raw> for Plain {
    type Error = Unreadable;

    fn output_encoding() -> RepresentationIdentifier {
        RepresentationIdentifier::CDR_LE
    }

    fn to_bytes(Raw(bytes): &Raw) -> Result<Bytes, Unreadable> {
        Ok(bytes.clone())
    }
}

impl DeserializerAdapter<Raw> for Plain {
    type Error = Unreadable;
    type Decoded = Raw;

    fn supported_encodings() -> &'static [RepresentationIdentifier] {
        &[RepresentationIdentifier::CDR_LE]
    }

    fn transform_decoded(decoded: Raw) -> Raw {
        decoded
    }
}

impl DefaultDecoder<Raw> for Plain {
    type Decoder = Copying;
    const DECODER: Copying = Copying;
}

/// A decoder that keeps the bytes.
#[derive(Clone)]
struct Copying;

impl Decode<'_, Raw> for Copying {
    type Error = Unreadable;

    fn decode_bytes(self, bytes: &[u8], encoding: RepresentationIdentifier) -> Result<Raw, Unreadable> {
        if encoding == RepresentationIdentifier::CDR_LE {
            return Ok(Raw(Bytes::copy_from_slice(bytes)));
        }
        Err(Unreadable(encoding))
    }
}

/// `rmw_dds_common/msg/ParticipantEntitiesInfo`.
#[derive(Serialize)]
struct ParticipantEntitiesInfo {
    gid: [u8; 16],
    node_entities_info_seq: Vec<NodeEntitiesInfo>,
}

/// `rmw_dds_common/msg/NodeEntitiesInfo`.
#[derive(Serialize)]
struct NodeEntitiesInfo {
    node_namespace: String,
    node_name: String,
    reader_gid_seq: Vec<[u8; 16]>,
    writer_gid_seq: Vec<[u8; 16]>,
}

/// Returns terms in those of DDS: every message arrives, or the writer says that there was no room.
fn terms(terms: Terms) -> QosPolicies {
    let (durability, depth, most_waiting) = match terms {
        Terms::Usual => (Durability::Volatile, DEPTH, MOST_WAITING),
        Terms::Large => (Durability::Volatile, DEPTH, MOST_PICTURES_WAITING),
        Terms::Latched => (Durability::TransientLocal, 1, MOST_WAITING),
    };
    QosPolicyBuilder::new()
        .reliable(Duration::ZERO)
        .durability(durability)
        .history(History::KeepLast { depth })
        .resource_limits(ResourceLimits {
            max_samples: most_waiting,
            max_instances: 1,
            max_samples_per_instance: most_waiting,
        })
        .build()
}

/// A participant of DDS with one node.
struct Node {
    participant: DomainParticipant,
    publisher: Publisher,
    subscriber: Subscriber,
    graph: DataWriter<Raw, Plain>,
    open: BTreeMap<u32, Endpoint>,
    /// True if the graph has changed and nobody has been told.
    has_changed: bool,
    /// Messages that found no room.
    refused: u64,
}

/// A topic, a subscription or a service.
struct Endpoint {
    writer: Option<DataWriter<Raw, Plain>>,
    /// Subscribers as the server knows them.
    subscribers: i32,
    reader: Option<(GUID, JoinHandle<()>)>,
}

impl Drop for Endpoint {
    fn drop(&mut self) {
        self.reader.iter().for_each(|(_, task)| task.abort());
    }
}

impl Node {
    fn join(domain: u16, address: Ipv4Addr) -> Result<Self, String> {
        let participant = DomainParticipantBuilder::new(domain).with_only_networks([address]).build();
        let participant = participant.map_err(|error| error.to_string())?;
        let none = QosPolicies::qos_none();
        let publisher = participant.create_publisher(&none).map_err(|error| error.to_string())?;
        let subscriber = participant.create_subscriber(&none).map_err(|error| error.to_string())?;
        let [name, kind] = GRAPH.map(str::to_owned);
        let terms = terms(Terms::Latched);
        let topic = participant.create_topic(name, kind, &terms, TopicKind::NoKey);
        let graph = topic.and_then(|topic| publisher.create_datawriter_no_key(&topic, Some(terms)));
        let graph = graph.map_err(|error| error.to_string())?;
        Ok(Self { participant, publisher, subscriber, graph, open: BTreeMap::new(), has_changed: true, refused: 0 })
    }

    fn writer(&self, name: String, kind: String, with: Terms) -> Option<DataWriter<Raw, Plain>> {
        let terms = terms(with);
        let topic = self.participant.create_topic(name, kind, &terms, TopicKind::NoKey);
        topic.and_then(|topic| self.publisher.create_datawriter_no_key(&topic, Some(terms))).ok()
    }

    fn reader(&self, name: String, kind: String) -> Option<DataReader<Raw, Plain>> {
        let terms = terms(Terms::Usual);
        let topic = self.participant.create_topic(name, kind, &terms, TopicKind::NoKey);
        topic.and_then(|topic| self.subscriber.create_datareader_no_key(&topic, Some(terms))).ok()
    }

    /// Does what the server orders. What others say on new subscriptions goes to `events`.
    fn take(&mut self, order: Order, events: &Sender<Event>) {
        match order {
            Order::Join { .. } => {}
            Order::Open { number, topic, kind, terms } => {
                let writer = self.writer(format!("rt{topic}"), kind, terms);
                self.add(number, Endpoint { writer, subscribers: 0, reader: None });
            }
            Order::Publish { number, message } => {
                let writer = self.open.get(&number).and_then(|endpoint| endpoint.writer.as_ref());
                let is_lost = writer.is_some_and(|writer| writer.write(Raw(message.into()), None).is_err());
                self.refused += u64::from(is_lost);
            }
            Order::Listen { number, topic, kind } => {
                let Some(reader) = self.reader(format!("rt{topic}"), kind) else { return };
                let event = move |_, message| Event::Heard { number, message };
                let reader = Some((reader.guid(), hear(reader, events.clone(), event)));
                self.add(number, Endpoint { writer: None, subscribers: 0, reader });
            }
            Order::Offer { number, service, kind } => {
                let (package, kind) = kind.split_once('/').unwrap_or_default();
                let of = |part: &str| format!("{package}::srv::dds_::{kind}_{part}_");
                let Some(reader) = self.reader(format!("rq{service}Request"), of("Request")) else { return };
                let writer = self.writer(format!("rr{service}Reply"), of("Response"), Terms::Usual);
                let event = move |from, message| Event::Asked { number, from, message };
                let reader = Some((reader.guid(), hear(reader, events.clone(), event)));
                self.add(number, Endpoint { writer, subscribers: 0, reader });
            }
            Order::Reply { number, to, message } => {
                let to = WriteOptionsBuilder::new().related_sample_identity(to).build();
                let writer = self.open.get(&number).and_then(|endpoint| endpoint.writer.as_ref());
                if let Some(writer) = writer {
                    // Its client may have gone.
                    let _ = writer.write_with_options(Raw(message.into()), to);
                }
            }
            Order::Close { number } => {
                self.open.remove(&number);
                self.has_changed = true;
            }
        }
    }

    fn add(&mut self, number: u32, endpoint: Endpoint) {
        self.open.insert(number, endpoint);
        self.has_changed = true;
    }

    /// Returns news for the server: of subscribers that came or left, and of messages that found no room.
    fn look(&mut self, told: &mut u64) -> Vec<Event> {
        let mut news = Vec::new();
        for (number, Endpoint { writer, subscribers, .. }) in &mut self.open {
            let Some(writer) = writer else { continue };
            let before = *subscribers;
            while let Some(status) = writer.try_recv_status() {
                if let DataWriterStatus::PublicationMatched { current, .. } = status {
                    *subscribers = current.count();
                }
            }
            if *subscribers != before {
                news.push(Event::Subscribers { number: *number, count: *subscribers });
            }
        }
        if std::mem::replace(told, self.refused) != self.refused {
            news.push(Event::Refused(self.refused));
        }
        news
    }

    /// Tells others of the node and its topics, if they have changed.
    fn publish_graph(&mut self) {
        if !std::mem::take(&mut self.has_changed) {
            return;
        }
        let readers = self.open.values().filter_map(|endpoint| endpoint.reader.as_ref());
        let writers = self.open.values().filter_map(|endpoint| endpoint.writer.as_ref());
        let node = NodeEntitiesInfo {
            node_namespace: "/".to_owned(),
            node_name: "usarsim".to_owned(),
            reader_gid_seq: readers.map(|(guid, _)| guid.to_bytes()).collect(),
            writer_gid_seq: writers.map(|writer| writer.guid().to_bytes()).collect(),
        };
        let gid = self.participant.guid().to_bytes();
        let info = ParticipantEntitiesInfo { gid, node_entities_info_seq: vec![node] };
        // It has only numbers and texts, so it has an encoding.
        if let Ok(bytes) = cdr::write(&info) {
            let _ = self.graph.write(Raw(bytes.into()), None);
        }
    }
}

/// Hands on what a reader hears, each with its identity, until its task is aborted.
fn hear(
    reader: DataReader<Raw, Plain>,
    events: Sender<Event>,
    event: impl Fn(rustdds::SampleIdentity, Vec<u8>) -> Event + 'static,
) -> JoinHandle<()> {
    let mut incoming = reader.async_sample_stream();
    tokio::task::spawn_local(async move {
        while let Some(sample) = incoming.next().await {
            let Ok(sample) = sample else { continue };
            let from = sample.sample_info().sample_identity();
            if events.send(event(from, sample.value().0.to_vec())).await.is_err() {
                return;
            }
            tokio::task::yield_now().await;
        }
    })
}

/// Runs the node until the server closes its end of the pipe.
///
/// # Errors
/// When a pipe or a thread cannot be had.
pub fn run() -> std::io::Result<()> {
    limit_memory();
    let runtime = tokio::runtime::Builder::new_current_thread().enable_time().build()?;
    let (orders, mut received) = channel(MOST_ORDERS);
    std::thread::Builder::new().name("orders".to_owned()).spawn(move || {
        let mut pipe = BufReader::new(std::io::stdin());
        while let Ok(order) = pipe::read::<Order>(&mut pipe) {
            if orders.blocking_send(order).is_err() {
                return;
            }
        }
    })?;
    runtime.block_on(tokio::task::LocalSet::new().run_until(async {
        let Some(Order::Join { domain, address }) = received.recv().await else { return Ok(()) };
        let mut pipe = std::io::stdout();
        let mut node = match Node::join(domain, address) {
            Ok(node) => node,
            Err(why) => return tell(&mut pipe, &Event::Joined(Err(why))),
        };
        tell(&mut pipe, &Event::Joined(Ok(())))?;
        let (events, mut heard) = channel(MOST_EVENTS);
        let (mut looks, mut told) = (tokio::time::interval(LOOK_INTERVAL), 0);
        loop {
            tokio::select! {
                order = received.recv() => match order {
                    Some(order) => node.take(order, &events),
                    None => break,
                },
                Some(event) = heard.recv() => tell(&mut pipe, &event)?,
                _ = looks.tick() => {
                    node.look(&mut told).iter().try_for_each(|event| tell(&mut pipe, event))?;
                    node.publish_graph();
                }
            }
        }
        let Node { participant, publisher, subscriber, graph, open, .. } = node;
        drop((open, graph, publisher, subscriber));
        tokio::time::sleep(FAREWELL).await;
        drop(participant);
        Ok(())
    }))
}

/// Tells the server. It reads all the time, so this does not block.
fn tell(pipe: &mut impl Write, event: &Event) -> std::io::Result<()> {
    pipe::write(pipe, event)?;
    pipe.flush()
}

/// Limits the memory of this process, where the system can.
fn limit_memory() {
    #[cfg(unix)]
    {
        use rustix::process::{Resource, Rlimit, setrlimit};
        // Without the limit it works as well, but for floods.
        let _ = setrlimit(Resource::As, Rlimit { current: Some(MOST_MEMORY), maximum: Some(MOST_MEMORY) });
    }
}
