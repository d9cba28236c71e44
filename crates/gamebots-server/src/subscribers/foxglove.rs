//! The channels of a log, live, for Foxglove and Lichtblick. Their services control the world's time.

use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::mpsc::Sender;
use std::time::{Duration, Instant};

use foxglove::websocket::service::{Request, Service, ServiceSchema};
use foxglove::websocket::{Capability, ChannelView, Client, ClientChannel, ServerListener};
use foxglove::{Context, Schema, WebSocketServerHandle};
use recorder::{Admitted, Latched, Live, Record, Recorder};
use scene::{MapDef, Snapshot, WorldDef};
use tokio::net::TcpListener;

use crate::ServeError;
use crate::access::login::Door;
use crate::access::pass::Pass;
use crate::messages::control::{Actor, Control};
use crate::ports::controllers::Event;
use crate::ports::gate::{self, Gate};
use crate::ports::truth::{Inquiry, Question};
use crate::world::guests;

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
    next_time: Instant,
}

/// Starts serving a number of clients at once on a listener. Clients' requests go to `events`; without it, no services are offered.
pub(crate) async fn start(
    listener: TcpListener,
    most: usize,
    host: &str,
    door: &Door,
    world: &WorldDef,
    events: Option<Sender<Event>>,
) -> Result<FoxgloveServer, ServeError> {
    let (context, latched, admitted) = (Context::new(), Latched::default(), Admitted::default());
    let live = Live::new(world, context.clone(), latched.clone(), admitted.clone())?;
    let pass = Pass::new();
    let hidden = gate::hidden_address();
    let server = context.websocket_server().name(format!("usarsim {}", world.map.name)).bind(hidden.to_string(), 0);
    let server = server.capabilities([Capability::Time, Capability::ClientPublish]).supported_encodings(["json"]);
    let server = server.services(events.iter().flat_map(services)).message_backlog_size(BACKLOG);
    let server = server.listener(Arc::new(Reception { pass: pass.clone(), admitted: admitted.clone(), latched }));
    let started = server.start().await;
    let handle = started.map_err(|error| ServeError::Start(std::io::Error::other(error.to_string())))?;
    tokio::spawn(gate::serve(
        listener,
        most,
        Gate {
            own_name: host.to_owned(),
            door: door.clone(),
            behind: SocketAddr::from((hidden, handle.port())),
            pass,
            admitted,
        },
    ));
    let recorder = Recorder::new(live)?;
    Ok(FoxgloveServer { handle, _context: context, recorder, next_time: Instant::now() })
}

impl FoxgloveServer {
    pub(crate) fn record(&mut self, time: f64, record: Record) {
        self.recorder.record(time, record);
    }

    pub(crate) fn record_states(&mut self, snapshot: Arc<Snapshot>) {
        self.recorder.record_states(snapshot);
    }

    /// Publishes new records and the simulated time; to be called often.
    pub(crate) fn publish(&mut self, now: Instant, time: f64) {
        if now >= self.next_time {
            self.next_time = now + TIME_INTERVAL;
            self.recorder.hand_over();
            self.handle.broadcast_time((time * 1e9).round() as u64);
        }
    }

    /// Starts a new session: time restarts, perhaps on another map.
    pub(crate) fn start_over(&mut self, another_map: Option<&MapDef>) {
        if let Some(map) = another_map {
            self.recorder.record(0.0, Record::Map(Box::new(map.clone())));
        }
        self.recorder.hand_over();
        self.handle.clear_session(None);
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

/// Builds the services pause, step, speed and reset, with the page's requests.
fn services(events: &Sender<Event>) -> Vec<Service> {
    let inquiry = Inquiry::new(guests::Kind::Foxglove, events.clone());
    let service = |name: &'static str, argument: &'static str| {
        let request = format!("{{\"type\":\"object\",\"properties\":{{{argument}}}}}");
        let response = "{\"type\":\"object\",\"properties\":{\"success\":{\"type\":\"boolean\"}}}";
        let schema = |part: &str, schema: &str| {
            Schema::new(format!("usarsim.{name}.{part}"), "jsonschema", schema.as_bytes().to_vec())
        };
        let schema = ServiceSchema::new(format!("usarsim.{name}"))
            .with_request("json", schema("Request", &request))
            .with_response("json", schema("Response", response));
        let inquiry = inquiry.clone();
        Service::builder(name, schema).async_handler_fn(move |request: Request| {
            let control = read(name, request.payload());
            answer(control, inquiry.clone())
        })
    };
    vec![
        service("pause", "\"pause\":{\"type\":\"boolean\"}"),
        service("step", "\"step\":{\"type\":\"integer\"}"),
        service("speed", "\"speed\":{\"type\":\"number\"}"),
        service("reset", ""),
    ]
}

/// Reads the request of a service: `{"pause":true}`, `{"step":1}`, `{"speed":2}`, or nothing.
fn read(service: &str, payload: &[u8]) -> Result<Control, String> {
    if service == "reset" {
        return Ok(Control::Reset);
    }
    let control = Control::read(&String::from_utf8_lossy(payload))?;
    match (service, &control) {
        ("pause", Control::Pause(_)) | ("step", Control::Step(_)) | ("speed", Control::Speed(_)) => Ok(control),
        _ => Err(format!("expected `{service}` in the request")),
    }
}

async fn answer(control: Result<Control, String>, inquiry: Inquiry) -> Result<&'static [u8], String> {
    let sent = inquiry.send(Question::Control(control?, Actor::foxglove())).await;
    sent.map(|()| &b"{\"success\":true}"[..]).ok_or_else(|| "the server stops".to_owned())
}
