//! rosbridge: robots and the world by JSON over a WebSocket, for programs of ROS without DDS.

use std::collections::BTreeSet;
use std::net::TcpStream;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use gamebots_server::{Listener, Service, WorldControl};
use serde_json::{Value, json};
use system_tests::{PATIENCE, Server, wait_until};
use tungstenite::client::IntoClientRequest;
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket};

fn server(robots: &[&Path], control: WorldControl) -> Server {
    Server::start("rough", robots, |config| {
        config.listeners.push(Listener::new(Service::Page, 0));
        config.world_control = control;
        let read = |text: &str| match text.strip_prefix("robot ") {
            Some(class) => {
                let shipped = scene_loader::robot("P3AT", &[]).map_err(|error| error.to_string());
                shipped.map(|def| scene::RobotDef { class: class.to_owned(), ..def })
            }
            None => Err("robot.urdf:1:1: not a robot".to_owned()),
        };
        let read_robot = Some(ros2::ReadRobot(Arc::new(read)));
        config.ros2 = Some(ros2::Options { rosbridge: true, read_robot, ..ros2::Options::default() });
    })
}

/// A client of rosbridge.
struct Client(WebSocket<MaybeTlsStream<TcpStream>>);

impl Client {
    fn open(server: &Server, path: &str) -> Self {
        let address = server.page.expect("a page");
        let (socket, _) = tungstenite::connect(format!("ws://{address}{path}")).expect("a connection");
        let MaybeTlsStream::Plain(stream) = socket.get_ref() else { panic!("not a plain socket") };
        stream.set_read_timeout(Some(PATIENCE)).expect("a timeout");
        Self(socket)
    }

    fn send(&mut self, operation: &Value) {
        self.0.send(Message::text(operation.to_string())).expect("sent");
    }

    fn next(&mut self) -> Value {
        match self.0.read().expect("a text") {
            Message::Text(text) => serde_json::from_str(&text).expect("JSON"),
            other => panic!("not a text: {other:?}"),
        }
    }

    fn wait(&mut self, fits: impl Fn(&Value) -> bool) -> Value {
        let end = Instant::now() + PATIENCE;
        while Instant::now() < end {
            let text = self.next();
            if fits(&text) {
                return text;
            }
        }
        panic!("nothing that fits");
    }

    /// Calls a service. Returns the values, or the reason why there are none.
    fn call(&mut self, service: &str, args: Value) -> Result<Value, Value> {
        self.send(&json!({ "op": "call_service", "id": "c", "service": service, "args": args }));
        let mut answer = self.wait(|text| text["op"] == "service_response");
        assert_eq!((&answer["id"], &answer["service"]), (&json!("c"), &json!(service)));
        let values = answer["values"].take();
        if answer["result"] == json!(true) { Ok(values) } else { Err(values) }
    }
}

#[test]
fn a_client_of_rosbridge_hears_drives_and_asks() {
    let server = server(&[], WorldControl::Everyone);
    let mut owner = server.client();
    owner.send("INIT {ClassName USARBot.P3AT} {Name R1} {Location 0,0,0}");
    owner.ground_truth();
    let mut client = Client::open(&server, "/");
    let has_come =
        |client: &mut Client| client.call("/rosapi/topics", json!({})).expect("topics")["topics"].to_string();
    wait_until(|| has_come(&mut client).contains("/R1/robot_description"));

    // A late client gets what does not change; a message has the fields of ROS.
    client.send(&json!({ "op": "subscribe", "topic": "/R1/robot_description", "type": "std_msgs/msg/String" }));
    let text = client.wait(|text| text["topic"] == "/R1/robot_description");
    assert!(text["msg"]["data"].as_str().expect("a text").starts_with("<?xml"));
    client.send(&json!({ "op": "subscribe", "id": "o", "topic": "/R1/odom", "throttle_rate": 100 }));
    client.send(&json!({ "op": "advertise", "topic": "/R1/cmd_vel", "type": "geometry_msgs/TwistStamped" }));
    let drives =
        |text: &Value| (text["msg"]["twist"]["twist"]["linear"]["x"].as_f64().unwrap_or(0.0) - 0.5).abs() < 0.01;
    let start = Instant::now();
    let odom = loop {
        client
            .send(&json!({ "op": "publish", "topic": "/R1/cmd_vel", "msg": { "twist": { "linear": { "x": 0.5 } } } }));
        let text = client.wait(|text| text["topic"] == "/R1/odom");
        if drives(&text) {
            break text;
        }
        assert!(start.elapsed() < PATIENCE, "{text}");
    };
    assert_eq!(odom["msg"]["pose"]["covariance"].as_array().map(Vec::len), Some(36));
    client.send(&json!({ "op": "unsubscribe", "id": "o", "topic": "/R1/odom" }));

    // A picture is base64 of JPEG.
    client.send(&json!({ "op": "subscribe", "topic": "/R1/image_raw/compressed" }));
    let picture = client.wait(|text| text["topic"] == "/R1/image_raw/compressed");
    assert!(picture["msg"]["data"].as_str().expect("a text").starts_with("/9j/"));
    client.send(&json!({ "op": "unsubscribe", "topic": "/R1/image_raw/compressed" }));

    // Services, with names of fields as the standard has them.
    assert_eq!(client.call("/usarsim/pause", json!(null)), Ok(json!({ "success": true, "message": "" })));
    let asked = json!({ "filters": { "filter": "R.*" } });
    assert_eq!(client.call("/usarsim/get_entities", asked).expect("entities")["entities"], json!(["R1"]));
    let pose = json!({ "position": { "x": 3.0, "y": 1.0, "z": 0.3 }, "orientation": { "w": 1.0 } });
    let spawn = json!({ "name": "R2", "entity_resource": { "uri": "P3AT" }, "initial_pose": { "pose": pose } });
    assert_eq!(client.call("/usarsim/spawn_entity", spawn).expect("a robot")["entity_name"], "R2");
    let put = |pose: Value| json!({ "entity": "R2", "state": { "pose": pose } });
    let pose = json!({ "position": { "x": 3.0, "y": -2.0, "z": 0.3 }, "orientation": { "w": 1.0 } });
    let done = client.call("/usarsim/set_entity_state", put(pose)).expect("done");
    assert_eq!(done["result"]["result"], 1, "{done}");
    let at = |client: &mut Client| {
        let state = client.call("/usarsim/get_entity_state", json!({ "entity": "R2" })).expect("a state");
        state["state"]["pose"]["position"]["y"].as_f64().unwrap_or(0.0)
    };
    wait_until(|| (at(&mut client) + 2.0).abs() < 0.1);
    for (text, result, part) in [("robot Brought", 1, ""), ("robots", 106, "robot.urdf:1:1: not a robot")] {
        let pose = json!({ "position": { "x": 6.0, "y": 1.0, "z": 0.3 }, "orientation": { "w": 1.0 } });
        let spawn = json!({ "name": text.replace(' ', "_"), "entity_resource": { "resource_string": text }, "initial_pose": { "pose": pose } });
        let answer = client.call("/usarsim/spawn_entity", spawn).expect("an answer");
        let said = answer["result"]["error_message"].as_str().unwrap_or_default();
        assert!(answer["result"]["result"] == result && said.contains(part), "{answer}");
    }
    assert_eq!(client.call("/usarsim/delete_entity", json!(["R2"])).expect("done")["result"]["result"], 1);
    drop(owner);
}

#[test]
fn wrong_texts_of_rosbridge_are_answered_with_the_reason() {
    let server = server(&[], WorldControl::Nobody);
    let mut owner = server.client();
    owner.send("INIT {ClassName USARBot.P3AT} {Name R1} {Location 0,0,0}");
    owner.ground_truth();
    let mut client = Client::open(&server, "/rosbridge");
    let topics = |client: &mut Client| client.call("/rosapi/topics", json!({})).expect("topics").to_string();
    wait_until(|| topics(&mut client).contains("/R1/cmd_vel"));
    let long = "x".repeat(300);
    for (text, why) in [
        ("{", "no operation of rosbridge: EOF"),
        ("[[[[", "no operation of rosbridge"),
        (r#"{"op":"dance"}"#, "no operation `dance`: expected advertise"),
        (r#"{"op":"subscribe"}"#, "subscribe: expected a `topic`"),
        (r#"{"op":"subscribe","topic":"/clock","compression":"png"}"#, "compression `png`: expected none"),
        (
            r#"{"op":"subscribe","topic":"/clock","type":"std_msgs/String"}"#,
            "type std_msgs/String: expected rosgraph_msgs/Clock",
        ),
        (&format!(r#"{{"op":"subscribe","topic":"{long}"}}"#), "a name of more than 256 bytes"),
        (r#"{"op":"advertise","topic":"/R1/cmd_vel"}"#, "advertise: expected a `type`"),
        (r#"{"op":"publish","topic":"/R1/nothing","msg":{}}"#, "publish /R1/nothing: no robot listens there"),
        (r#"{"op":"publish","topic":"/R1/cmd_vel","msg":{"speed":1}}"#, "unknown field `speed`"),
        (
            r#"{"op":"publish","topic":"/R1/cmd_vel","type":"std_msgs/Bool","msg":{}}"#,
            "type std_msgs/Bool: expected geometry_msgs/Twist",
        ),
    ] {
        client.0.send(Message::text(text)).expect("sent");
        let said = client.wait(|text| text["op"] == "status");
        assert!(said["level"] == "error" && said["msg"].as_str().is_some_and(|it| it.contains(why)), "{text}: {said}");
    }
    for (service, why) in
        [("/usarsim/pause", "--control"), ("/rosapi/secrets", "no service /rosapi/secrets: expected topics")]
    {
        let said = client.call(service, json!({})).expect_err("a refusal");
        assert!(said.as_str().is_some_and(|it| it.contains(why)), "{said}");
    }
    // Pages of strangers stay outside.
    let address = server.page.expect("a page");
    for (origin, is_welcome) in [("http://localhost:5173", true), ("https://evil.example", false), ("null", false)] {
        let mut request = format!("ws://{address}/rosbridge").into_client_request().expect("a request");
        request.headers_mut().insert("Origin", origin.parse().expect("a header"));
        assert_eq!(tungstenite::connect(request).is_ok(), is_welcome, "{origin}");
    }
    drop(owner);
}

#[test]
fn clients_of_rosbridge_that_flood_or_do_not_read_disturb_nobody() {
    let server = server(&[], WorldControl::Everyone);
    let mut bystander = server.bystander();
    let mut deaf = Client::open(&server, "/");
    for topic in ["/tf", "/clock", "/Bystander/odom", "/Bystander/image_raw/compressed", "/Bystander/scan", "/later"] {
        deaf.send(&json!({ "op": "subscribe", "topic": topic }));
    }
    let address = server.page.expect("a page");
    let texts = [
        r#"{"op":"publish","topic":"/Bystander/cmd_vel","msg":{"linear":{"x":0.1}}}"#.to_owned(),
        r#"{"op":"call_service","service":"/usarsim/get_entities","args":{}}"#.to_owned(),
        format!(r#"{{"op":"publish","topic":"/Bystander/cmd_vel","msg":{}}}"#, "[".repeat(200_000)),
        r#"{"op":"subscribe","topic":"/clock"}"#.to_owned(),
    ];
    let end = Instant::now() + Duration::from_secs(3);
    let flooding = texts.map(|text| {
        std::thread::spawn(move || {
            let (mut socket, _) = tungstenite::connect(format!("ws://{address}/")).expect("a connection");
            let MaybeTlsStream::Plain(stream) = socket.get_ref() else { panic!("not a plain socket") };
            stream.set_write_timeout(Some(Duration::from_millis(100))).expect("a timeout");
            let (text, mut sent) = (Message::text(text), 0);
            // It never reads, so it has to wait at last.
            while Instant::now() < end && socket.send(text.clone()).is_ok() {
                sent += 1;
            }
            sent
        })
    });
    bystander.lines_for(2.0);
    let sent = flooding.map(|thread| thread.join().expect("a flood"));
    assert!(sent.iter().all(|sent| *sent > 5), "{sent:?}");
    // Another client is served at once.
    let mut client = Client::open(&server, "/");
    assert!(client.call("/usarsim/get_entities", json!({})).expect("entities").to_string().contains("Bystander"));
    bystander.check_undisturbed();
    drop(deaf);
}

/// Robots with every sensor that ROS has a message for.
const EQUIPPED: &str = r#"
like = "P3AT"
description = "A P3AT with sensors of all kinds"
[[sensor]]
class = "RangeScanner3D"
name = "Rows"
position = [0.1, 0.0, -0.3]
[[sensor]]
class = "GPSSensor"
name = "GPS"
[[sensor]]
class = "IMU"
name = "IMU"
[[sensor]]
class = "Sonar"
name = "F1"
[[sensor]]
class = "Odometry"
name = "Odometry"
[[sensor]]
class = "KinectDepth"
name = "Kinect"
continuous = true
"#;

/// Returns the topics of a section of the book, each with the text that names its types.
fn table(book: &str, section: &str) -> Vec<(String, String)> {
    let (_, rest) = book.split_once(&format!("\n## {section}\n")).expect("a section");
    let rows = rest.split("\n## ").next().unwrap_or_default().lines().filter(|line| line.starts_with("| `"));
    let row = |row: &str| {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        (cells[1].trim_matches('`').trim_start_matches('/').to_owned(), cells[2].to_owned())
    };
    rows.map(row).collect()
}

#[test]
fn the_book_has_every_topic_of_ros_and_no_other() {
    let folder = tempfile::tempdir().expect("a folder");
    let equipped = folder.path().join("Equipped");
    std::fs::create_dir(&equipped).expect("a folder");
    std::fs::write(equipped.join("robot.toml"), EQUIPPED).expect("a file");
    let server = server(&[&equipped], WorldControl::Everyone);
    let mut owners = ["P3AT", "Equipped", "YouBotArm"].map(|class| (class, server.client()));
    for (number, (class, owner)) in owners.iter_mut().enumerate() {
        owner.send(&format!("INIT {{ClassName USARBot.{class}}} {{Name {class}}} {{Location {},0,0}}", 3 * number));
        owner.wait_for("its state", |line| line.starts_with("STA"));
    }
    let book = include_str!("../../docs/howto-ros2.md");
    let rows: Vec<(String, String)> = [table(book, "Topics"), table(book, "Orders")].concat();
    let written: BTreeSet<&str> = rows.iter().map(|(topic, _)| topic.as_str()).collect();
    let mut client = Client::open(&server, "/");
    // Without its robot, and without the name of a sensor that is not alone of its kind.
    let plain = |topic: &str| {
        let topic = topic.trim_start_matches('/');
        let own = owners.iter().find_map(|(class, _)| topic.strip_prefix(class)?.strip_prefix('/')).unwrap_or(topic);
        own.trim_start_matches("Rows/").trim_start_matches("Scanner/").to_owned()
    };
    let mut seen = BTreeSet::new();
    wait_until(|| {
        let values = client.call("/rosapi/topics", json!({})).expect("topics");
        let [topics, kinds] = ["topics", "types"].map(|key| values[key].as_array().expect("a list").clone());
        for (topic, kind) in topics.iter().zip(kinds) {
            let (topic, kind) =
                (plain(topic.as_str().expect("a name")), kind.as_str().expect("a type").replace("/msg/", "/"));
            seen.insert((topic, kind));
        }
        seen.iter().map(|(topic, _)| topic.as_str()).collect::<BTreeSet<_>>().len() >= written.len()
    });
    for (topic, kind) in &seen {
        let row = rows.iter().find(|(written, _)| written == topic);
        let (_, text) = row.unwrap_or_else(|| panic!("{topic} ({kind}) is not in the book"));
        let short = kind.rsplit('/').next().unwrap_or(kind);
        let has_it =
            text.contains(&format!("`{kind}`")) || text.contains(&format!("`{short}`")) || text.starts_with("the same");
        assert!(has_it, "{topic} is {kind}: the book says {text}");
    }
    let seen: BTreeSet<&str> = seen.iter().map(|(topic, _)| topic.as_str()).collect();
    assert_eq!(seen, written);
}
