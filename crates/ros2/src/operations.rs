//! Operations of clients of rosbridge: JSON of rosbridge_suite's protocol (ROSBRIDGE_PROTOCOL.md, version 2), with the services of rosapi
//! that clients ask first.

use std::time::Duration;

use ros2_topics::{interfaces as ros, json, stamp};
use serde::Deserialize;
use serde_json::value::RawValue;
use serde_json::{Value, json};

use crate::node::Node;
use crate::rosbridge::{Asking, Said};

/// Longest name or identity, bytes.
const LONGEST_NAME: usize = 256;
/// Version and distribution of ROS (rosapi_msgs/srv/GetROSVersion).
const VERSION: u8 = 2;
const DISTRO: &str = "jazzy";

/// An operation of the protocol. Which fields count depends on `op`.
#[derive(Deserialize)]
struct Operation<'a> {
    op: String,
    id: Option<String>,
    topic: Option<String>,
    service: Option<String>,
    #[serde(rename = "type")]
    kind: Option<String>,
    #[serde(borrow)]
    msg: Option<&'a RawValue>,
    #[serde(borrow)]
    args: Option<&'a RawValue>,
    /// Least time between two messages, ms.
    throttle_rate: Option<u32>,
    compression: Option<String>,
}

/// Takes news of a client.
pub(crate) fn take(node: &mut Node, said: Said) {
    let Some((client, text)) = node.hub.take(said) else { return };
    match serde_json::from_str::<Operation>(&text) {
        Ok(operation) => {
            let id = operation.id.clone().filter(|id| id.len() <= LONGEST_NAME);
            if let Err(why) = operate(node, client, operation) {
                node.hub.complain(client, id.as_deref(), &why);
            }
        }
        Err(error) => node.hub.complain(client, None, &format!("no operation of rosbridge: {error}")),
    }
}

fn operate(node: &mut Node, client: u64, operation: Operation<'_>) -> Result<(), String> {
    let Operation { op, id, topic, service, kind, msg, args, throttle_rate, compression } = operation;
    let names = [&id, &topic, &service, &kind];
    if names.into_iter().flatten().any(|name| name.len() > LONGEST_NAME) {
        return Err(format!("{op}: a name of more than {LONGEST_NAME} bytes"));
    }
    let rooted = |name: String| if name.starts_with('/') { name } else { format!("/{name}") };
    let topic = || topic.map(rooted).ok_or(format!("{op}: expected a `topic`"));
    let kind = kind.map(|kind| short(&kind));
    match op.as_str() {
        "subscribe" => {
            if let Some(compression) = compression.filter(|it| it != "none") {
                return Err(format!("subscribe: compression `{compression}`: expected none"));
            }
            let interval = Duration::from_millis(throttle_rate.unwrap_or(0).into());
            let topic = topic()?;
            if let Some((kind, known)) = kind.zip(node.kind(&topic)).filter(|(kind, known)| kind != known) {
                return Err(format!("subscribe {topic}: type {kind}: expected {known}"));
            }
            let last = node.latched(&topic);
            node.hub.subscribe(client, topic, id.unwrap_or_default(), interval, last.as_ref())
        }
        "unsubscribe" => {
            node.hub.unsubscribe(client, &topic()?, id.as_deref());
            Ok(())
        }
        "advertise" => {
            let kind = kind.ok_or("advertise: expected a `type`")?;
            node.hub.advertise(client, topic()?, Some(kind))
        }
        "unadvertise" => node.hub.advertise(client, topic()?, None),
        "publish" => {
            let (topic, msg) = (topic()?, msg.map_or("{}", RawValue::get));
            let kind = kind.as_deref().or(node.hub.advertised(client, &topic));
            node.hear_json(&topic, kind, msg).map_err(|why| format!("publish {topic}: {why}"))
        }
        "call_service" => {
            let service = service.map(rooted).ok_or("call_service: expected a `service`")?;
            let args = args.map(RawValue::get).filter(|args| *args != "null").unwrap_or("{}");
            let asking = Asking { client, id, service };
            let outcome = match asking.service.strip_prefix("/rosapi/") {
                Some(called) => rosapi(node, called, args).map(Some),
                None if !node.hub.may_control(client) => {
                    Err("who may control the world is said by the server's --control and --token-file".to_owned())
                }
                None => node.ask_json(&asking, args).map(|()| None),
            };
            match outcome {
                Ok(None) => {}
                Ok(Some(values)) => node.hub.answer(asking, Ok(values)),
                Err(why) => node.hub.answer(asking, Err(why)),
            }
            Ok(())
        }
        "set_level" | "status" => Ok(()),
        _ => Err(format!(
            "no operation `{}`: expected advertise, unadvertise, publish, subscribe, unsubscribe, call_service",
            op.chars().take(LONGEST_NAME).collect::<String>()
        )),
    }
}

/// Returns the name of a type in short: `geometry_msgs/Twist` for `geometry_msgs/msg/Twist`.
fn short(kind: &str) -> String {
    kind.replace("/msg/", "/").replace("/srv/", "/")
}

/// Returns the whole name of a type: `geometry_msgs/msg/Twist` for `geometry_msgs/Twist`.
fn whole(kind: &str, part: &str) -> String {
    kind.replacen('/', &format!("/{part}/"), 1)
}

/// The argument of a service of rosapi.
#[derive(Deserialize, Default)]
#[serde(default)]
struct Named {
    topic: String,
    service: String,
    #[serde(rename = "type")]
    kind: String,
}

/// The services of rosapi that are answered (rosapi_msgs).
const ROSAPI: [&str; 9] = [
    "topics",
    "topics_for_type",
    "topic_type",
    "services",
    "services_for_type",
    "service_type",
    "nodes",
    "get_time",
    "get_ros_version",
];

fn rosapi(node: &Node, called: &str, args: &str) -> Result<Value, String> {
    let wanted: Named = json::read(args).map_err(|error| error.to_string())?;
    let topics = || node.topics().map(|(topic, kind)| (topic, whole(kind, "msg")));
    let services = || node.services().map(|(service, kind)| (service, whole(kind, "srv")));
    Ok(match called {
        "topics" => {
            let (topics, types): (Vec<_>, Vec<_>) = topics().unzip();
            json!({ "topics": topics, "types": types })
        }
        "topics_for_type" => {
            let topics = topics().filter(|(_, kind)| short(kind) == short(&wanted.kind)).map(|(topic, _)| topic);
            json!({ "topics": topics.collect::<Vec<_>>() })
        }
        "topic_type" => {
            let kind = topics().find(|(topic, _)| *topic == wanted.topic).map(|(_, kind)| kind);
            json!({ "type": kind.unwrap_or_default() })
        }
        "services" => {
            let own = ROSAPI.iter().map(|called| format!("/rosapi/{called}"));
            let services = services().map(|(service, _)| service.to_owned()).chain(own);
            json!({ "services": services.collect::<Vec<_>>() })
        }
        "services_for_type" => {
            let services = services().filter(|(_, kind)| short(kind) == short(&wanted.kind));
            json!({ "services": services.map(|(service, _)| service).collect::<Vec<_>>() })
        }
        "service_type" => {
            let kind = services().find(|(service, _)| *service == wanted.service).map(|(_, kind)| kind);
            json!({ "type": kind.unwrap_or_default() })
        }
        "nodes" => json!({ "nodes": [Node::NAME] }),
        "get_time" => {
            let ros::Time { sec, nanosec } = stamp(node.hub.clock.time());
            json!({ "time": { "sec": sec, "nanosec": nanosec } })
        }
        "get_ros_version" => json!({ "version": VERSION, "distro": DISTRO }),
        _ => return Err(format!("no service /rosapi/{called}: expected {}", ROSAPI.join(", "))),
    })
}
