//! The channels of a log, live, for Foxglove and Lichtblick.

use std::net::Ipv4Addr;
use std::sync::Arc;
use std::time::{Duration, Instant};

use foxglove::websocket::service::Service;
use foxglove::websocket::{Capability, ChannelView, Client, ClientChannel, ServerListener};
use foxglove::{Context, WebSocketServerHandle};
use recorder::{Admitted, Latched, Live, Record, Recorder, StateTimer};
use scene::WorldDef;
use served_world::Told;
use sim_core::World;

use crate::access::pass::Pass;
use crate::error::ServeError;
use crate::subscribers::subscriber::{Moment, Shot, Subscriber, record_of};

/// Messages that can wait for one client; if the world is fast, a client misses the oldest.
const BACKLOG: usize = 1024;
/// Real time between two announcements of the simulated time.
const TIME_INTERVAL: Duration = Duration::from_millis(33);

/// The running server, owned by the world's thread.
pub(crate) struct FoxgloveServer {
    handle: WebSocketServerHandle,
    /// Keeps the channels alive.
    _context: Arc<Context>,
    recorder: Recorder,
    states: StateTimer,
    next_time: Instant,
}

/// Starts the server on an address of this machine, with these services. Returns it and its port. It sends messages to those who show a
/// pass.
pub(crate) async fn start(
    host: Ipv4Addr,
    world: &WorldDef,
    services: Vec<Service>,
    pass: Pass,
    admitted: Admitted,
) -> Result<(FoxgloveServer, u16), ServeError> {
    let (context, latched) = (Context::new(), Latched::default());
    let live = Live::new(world, context.clone(), latched.clone(), admitted.clone())?;
    let server = context.websocket_server().name(format!("usarsim {}", world.map.name)).bind(host.to_string(), 0);
    let server = server.capabilities([Capability::Time, Capability::ClientPublish]).supported_encodings(["json"]);
    let server = server.services(services).message_backlog_size(BACKLOG);
    let server = server.listener(Arc::new(Reception { pass, admitted, latched }));
    let started = server.start().await;
    let handle = started.map_err(|error| ServeError::Start(std::io::Error::other(error.to_string())))?;
    let port = handle.port();
    let recorder = Recorder::new(live)?;
    Ok((
        FoxgloveServer {
            handle,
            _context: context,
            recorder,
            states: StateTimer::default(),
            next_time: Instant::now(),
        },
        port,
    ))
}

impl Subscriber for FoxgloveServer {
    fn hear(&mut self, moment: &mut Moment, event: &Told) {
        record_of(event).into_iter().for_each(|record| self.recorder.record(moment.world.time(), record));
    }

    fn see(&mut self, moment: &mut Moment, shot: &Shot) {
        self.recorder.record(moment.world.time(), shot.record());
    }

    fn keeps_records(&self) -> bool {
        true
    }

    fn stepped(&mut self, moment: &mut Moment) -> Vec<Shot> {
        if self.states.is_due(moment.world.time()) {
            self.recorder.record_states(moment.snapshot());
        }
        Vec::new()
    }

    /// Publishes new records and the simulated time.
    fn publish(&mut self, moment: &mut Moment) -> Vec<String> {
        if moment.now >= self.next_time {
            self.next_time = moment.now + TIME_INTERVAL;
            self.recorder.hand_over();
            self.handle.broadcast_time((moment.world.time() * 1e9).round() as u64);
        }
        Vec::new()
    }

    /// Starts a new session: time restarts, perhaps on another map.
    fn start_over(&mut self, moment: &mut Moment, old: &World) -> Vec<String> {
        self.states = StateTimer::default();
        if !moment.world.scene().is_copy_of(old.scene()) {
            let map = &moment.world.def().map;
            self.recorder.record(0.0, Record::Map(Box::new(map.clone())));
        }
        self.recorder.hand_over();
        self.handle.clear_session(None);
        Vec::new()
    }
}

/// Admits clients who show a pass, and sends late subscribers the messages that they missed.
///
/// Programs of other users of this machine can find the server behind the gate and connect to it. They get the names of the channels, and no
/// message.
struct Reception {
    pass: Pass,
    admitted: Admitted,
    latched: Latched,
}

impl ServerListener for Reception {
    /// The gate shows a pass as the topic of a channel, before anything that its client sends.
    fn on_client_advertise(&self, client: Client, channel: &ClientChannel) {
        if let Some((number, subscriber)) = self.pass.number(&channel.topic).zip(client.sink_id()) {
            self.admitted.admit(number, subscriber);
        }
    }

    fn on_subscribe(&self, client: Client, channel: ChannelView) {
        if client.sink_id().is_some_and(|subscriber| self.admitted.has(subscriber)) {
            self.latched.send(channel.topic(), client.sink_id());
        }
    }
}
