//! A node of ROS 2 on DDS: topics by name, and what other nodes see in their graph.
//!
//! Names and types are those that rmw_fastrtps and rmw_cyclonedds use: `rt/` before a topic, `rq/` and `rr/` before a service's request and
//! reply. Messages go in and out as bytes of CDR, so there is one type of writers and one of readers.

use std::collections::BTreeMap;
use std::net::Ipv4Addr;

use ros2_topics::{Message, Sink, is_latched};
use rustdds::bytes::Bytes;
use rustdds::dds::no_key::{DataReaderStream, DataWriter};
use rustdds::no_key::{Decode, DefaultDecoder, DeserializerAdapter, SerializerAdapter};
use rustdds::policy::{Durability, History, ResourceLimits};
use rustdds::{
    DataWriterStatus, DomainParticipant, DomainParticipantBuilder, Duration, GUID, Publisher, QosPolicies,
    QosPolicyBuilder, RTPSEntity, RepresentationIdentifier, SampleIdentity, StatusEvented, Subscriber, TopicKind,
    WriteOptionsBuilder,
};
use serde::Serialize;
use tracing::debug;

use crate::StartError;

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
pub(crate) struct Raw(pub(crate) Bytes);

/// The encoding of [`Raw`]: none.
pub(crate) struct Plain;

/// A message that cannot be read.
#[derive(Debug, thiserror::Error)]
#[error("a message in {0:?}: expected CDR, little endian")]
pub(crate) struct Unreadable(RepresentationIdentifier);

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
pub(crate) struct Copying;

impl Decode<'_, Raw> for Copying {
    type Error = Unreadable;

    fn decode_bytes(self, bytes: &[u8], encoding: RepresentationIdentifier) -> Result<Raw, Unreadable> {
        if encoding == RepresentationIdentifier::CDR_LE {
            return Ok(Raw(Bytes::copy_from_slice(bytes)));
        }
        Err(Unreadable(encoding))
    }
}

/// Messages of others on one topic.
pub(crate) type Incoming = DataReaderStream<Raw, Plain>;

/// Owner of topics: a robot by its number, or the world.
pub(crate) type Owner = Option<u64>;

/// A participant of DDS with one node.
pub(crate) struct Node {
    participant: DomainParticipant,
    publisher: Publisher,
    subscriber: Subscriber,
    graph: DataWriter<Raw, Plain>,
    writers: BTreeMap<String, Outgoing>,
    /// Topics and services that it listens to, with their owners.
    readers: Vec<(Owner, GUID)>,
    /// Writers of replies.
    repliers: Vec<GUID>,
    /// True if the graph has changed and nobody has been told.
    has_changed: bool,
    /// Owner of the topics that the next messages open.
    owner: Owner,
    /// Messages that found no room.
    refused: u64,
}

/// A topic that it publishes.
struct Outgoing {
    writer: DataWriter<Raw, Plain>,
    owner: Owner,
    /// Subscribers now.
    matched: i32,
}

impl Outgoing {
    /// Takes the news of subscribers that came or left. True if there are any now.
    fn has_subscribers(&mut self) -> bool {
        while let Some(status) = self.writer.try_recv_status() {
            if let DataWriterStatus::PublicationMatched { current, .. } = status {
                self.matched = current.count();
            }
        }
        self.matched > 0
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

/// Returns the terms of a topic: every message arrives, or the writer says that there was no room.
fn terms(durability: Durability, depth: i32, most_waiting: i32) -> QosPolicies {
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

impl Node {
    /// Joins a domain on one address of this machine.
    pub(crate) fn join(domain: u16, address: Ipv4Addr) -> Result<Self, StartError> {
        let failed = |error: &dyn std::fmt::Display| StartError::Join(error.to_string());
        let participant = DomainParticipantBuilder::new(domain).with_only_networks([address]).build();
        let participant = participant.map_err(|error| failed(&error))?;
        let none = QosPolicies::qos_none();
        let publisher = participant.create_publisher(&none).map_err(|error| failed(&error))?;
        let subscriber = participant.create_subscriber(&none).map_err(|error| failed(&error))?;
        let graph = {
            let terms = terms(Durability::TransientLocal, 1, MOST_WAITING);
            let [name, kind] = GRAPH.map(str::to_owned);
            let topic = participant.create_topic(name, kind, &terms, TopicKind::NoKey);
            let topic = topic.map_err(|error| failed(&error))?;
            publisher.create_datawriter_no_key(&topic, Some(terms)).map_err(|error| failed(&error))?
        };
        Ok(Self {
            participant,
            publisher,
            subscriber,
            graph,
            writers: BTreeMap::new(),
            readers: Vec::new(),
            repliers: Vec::new(),
            has_changed: true,
            owner: None,
            refused: 0,
        })
    }

    /// Sets the owner of the topics that the next messages open.
    pub(crate) fn own(&mut self, owner: Owner) {
        self.owner = owner;
    }

    /// True if a topic has subscribers.
    pub(crate) fn has_subscribers(&mut self, topic: &str) -> bool {
        self.writers.get_mut(topic).is_some_and(Outgoing::has_subscribers)
    }

    /// Opens a topic without a message, so that others can subscribe to it.
    pub(crate) fn open<T: Message>(&mut self, topic: &str) {
        if !self.writers.contains_key(topic) {
            let terms = match T::NAME {
                "sensor_msgs/CompressedImage" | "sensor_msgs/Image" | "sensor_msgs/PointCloud2" => {
                    terms(Durability::Volatile, DEPTH, MOST_PICTURES_WAITING)
                }
                _ if is_latched(topic) => terms(Durability::TransientLocal, 1, MOST_WAITING),
                _ => terms(Durability::Volatile, DEPTH, MOST_WAITING),
            };
            let opened = self.writer(&format!("rt{topic}"), T::dds_name(), terms);
            let Some(writer) = opened else { return };
            self.writers.insert(topic.to_owned(), Outgoing { writer, owner: self.owner, matched: 0 });
            self.has_changed = true;
        }
    }

    fn writer(&self, name: &str, kind: String, terms: QosPolicies) -> Option<DataWriter<Raw, Plain>> {
        let topic = self.participant.create_topic(name.to_owned(), kind, &terms, TopicKind::NoKey);
        let writer = topic.and_then(|topic| self.publisher.create_datawriter_no_key(&topic, Some(terms)));
        writer.inspect_err(|error| debug!("no topic {name}: {error}")).ok()
    }

    fn reader(&self, name: &str, kind: String) -> Option<(GUID, Incoming)> {
        let terms = terms(Durability::Volatile, DEPTH, MOST_WAITING);
        let topic = self.participant.create_topic(name.to_owned(), kind, &terms, TopicKind::NoKey);
        let reader =
            topic.and_then(|topic| self.subscriber.create_datareader_no_key::<Raw, Plain>(&topic, Some(terms)));
        let reader = reader.inspect_err(|error| debug!("nothing is heard on {name}: {error}")).ok()?;
        Some((reader.guid(), reader.async_sample_stream()))
    }

    /// Subscribes to a topic.
    pub(crate) fn listen<T: Message>(&mut self, topic: &str) -> Option<Incoming> {
        let (guid, incoming) = self.reader(&format!("rt{topic}"), T::dds_name())?;
        self.readers.push((self.owner, guid));
        self.has_changed = true;
        Some(incoming)
    }

    /// Offers a service by its name and type, as in `std_srvs/Trigger`. Returns its requests and the way of its replies.
    pub(crate) fn offer(&mut self, name: &str, kind: &str) -> Option<(Incoming, Replier)> {
        let (package, kind) = kind.split_once('/')?;
        let of = |part: &str| format!("{package}::srv::dds_::{kind}_{part}_");
        let (guid, requests) = self.reader(&format!("rq{name}Request"), of("Request"))?;
        let terms = terms(Durability::Volatile, DEPTH, MOST_WAITING);
        let replies = self.writer(&format!("rr{name}Reply"), of("Response"), terms)?;
        self.readers.push((self.owner, guid));
        self.repliers.push(replies.guid());
        self.has_changed = true;
        Some((requests, Replier(replies)))
    }

    /// Closes everything of an owner.
    pub(crate) fn close(&mut self, owner: Owner) {
        self.writers.retain(|_, outgoing| outgoing.owner != owner);
        self.readers.retain(|(of, _)| *of != owner);
        self.has_changed = true;
    }

    /// Leaves the domain: its readers and writers first, so that others hear of it.
    pub(crate) async fn leave(self, farewell: std::time::Duration) {
        let Self { participant, publisher, subscriber, graph, writers, .. } = self;
        drop((writers, graph));
        drop((publisher, subscriber));
        tokio::time::sleep(farewell).await;
        drop(participant);
    }

    /// Returns the number of messages that found no room, because a subscriber did not take earlier ones.
    pub(crate) fn refused(&self) -> u64 {
        self.refused
    }

    /// Tells others of the node and its topics, if they have changed.
    pub(crate) fn publish_graph(&mut self) {
        if !std::mem::take(&mut self.has_changed) {
            return;
        }
        let writers = self.writers.values().map(|outgoing| outgoing.writer.guid());
        let node = NodeEntitiesInfo {
            node_namespace: "/".to_owned(),
            node_name: "usarsim".to_owned(),
            reader_gid_seq: self.readers.iter().map(|(_, guid)| guid.to_bytes()).collect(),
            writer_gid_seq: writers.chain(self.repliers.iter().copied()).map(|guid| guid.to_bytes()).collect(),
        };
        let gid = self.participant.guid().to_bytes();
        let info = ParticipantEntitiesInfo { gid, node_entities_info_seq: vec![node] };
        match cdr_encoding::to_vec::<_, byteorder::LittleEndian>(&info) {
            Ok(bytes) => _ = self.graph.write(Raw(bytes.into()), None),
            Err(error) => debug!("no graph: {error}"),
        }
    }
}

impl Sink for Node {
    type Error = std::convert::Infallible;

    /// Publishes a message, if somebody subscribes to it or it is for late subscribers.
    fn publish<T: Message>(&mut self, _: f64, topic: &str, message: &T) -> Result<(), Self::Error> {
        self.open::<T>(topic);
        let Some(outgoing) = self.writers.get_mut(topic) else { return Ok(()) };
        if !outgoing.has_subscribers() && !is_latched(topic) {
            return Ok(());
        }
        match message.to_cdr() {
            Ok(bytes) => {
                let is_written = outgoing.writer.write(Raw(bytes.into()), None).is_ok();
                self.refused += u64::from(!is_written);
            }
            Err(error) => debug!("no message on {topic}: {error}"),
        }
        Ok(())
    }
}

/// The way of a service's replies.
pub(crate) struct Replier(DataWriter<Raw, Plain>);

impl Replier {
    /// Replies to a request. Its client may have gone.
    pub(crate) fn reply<T: Serialize>(&self, request: SampleIdentity, response: &T) {
        let to = WriteOptionsBuilder::new().related_sample_identity(request).build();
        if let Ok(bytes) = cdr_encoding::to_vec::<_, byteorder::LittleEndian>(response) {
            let _ = self.0.write_with_options(Raw(bytes.into()), to);
        }
    }
}
