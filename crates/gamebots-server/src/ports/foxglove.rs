//! The port of Foxglove. Its services control the world's time.

use std::net::SocketAddr;

use foxglove::Schema;
use foxglove::websocket::service::{Request, Service, ServiceSchema};
use page_protocol::{Actor, Control};
use recorder::Admitted;
use scene::WorldDef;
use served_world::{Entrance, Inquiry, Kind, Question};

use crate::access::login::Door;
use crate::access::pass::Pass;
use crate::error::ServeError;
use crate::ports::gate::{Gate, hidden_address};
use crate::subscribers::foxglove::{self as server, FoxgloveServer};

/// Starts Foxglove's server, and returns it with the gate before it, for so many clients at once. Their requests go in by `entrance`;
/// without it, no services are offered.
pub(crate) async fn start(
    host: &str,
    most: usize,
    door: &Door,
    world: &WorldDef,
    entrance: Option<&Entrance>,
) -> Result<(FoxgloveServer, Gate), ServeError> {
    let (pass, admitted, hidden) = (Pass::new(), Admitted::default(), hidden_address());
    let services = entrance.map(services).unwrap_or_default();
    let (server, port) = server::start(hidden, world, services, pass.clone(), admitted.clone()).await?;
    let behind = SocketAddr::from((hidden, port));
    Ok((server, Gate::new(host, most, door.clone(), behind, pass, admitted)))
}

/// Builds the services pause, step, speed and reset, with the page's requests.
fn services(entrance: &Entrance) -> Vec<Service> {
    let inquiry = entrance.guest(Kind::Foxglove);
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
