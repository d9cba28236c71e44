//! The page's side of the server: messages to viewers, their requests, and the connections that it refuses.

#![expect(clippy::unwrap_used, reason = "helpers of tests")]

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use gamebots_server::viewer_messages::{self, message::Content};
use gamebots_server::{AvailableMap, AvailableScenario, Config, Listener, Service, WorldControl};
use prost::Message as _;
use recorder::Record;
use serde_json::Value;
use system_tests::{PATIENCE, Peer, Server};
use tungstenite::client::IntoClientRequest;
use tungstenite::protocol::Role;
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket};

fn serve(map: &str, change: impl FnOnce(&mut Config)) -> Server {
    Server::start(map, &[], |config| {
        config.listeners.push(Listener::new(Service::Page, 0));
        change(config);
    })
}

fn page_of(server: &Server) -> SocketAddr {
    server.page.unwrap_or_else(|| panic!("no page"))
}

struct Viewer {
    socket: WebSocket<MaybeTlsStream<TcpStream>>,
}

/// The parts of a frame that tests check.
#[derive(Debug, Clone)]
struct Frame {
    time: f64,
    bytes: usize,
    /// Number, position, and angle and target speed of the first wheel.
    robots: Vec<(u32, [f32; 3], f32, f32)>,
    contacts: usize,
    /// Numbers of the objects.
    objects: Vec<u32>,
    /// Positions of the joints with a position servo, of all robots.
    joints: Vec<f32>,
}

impl Viewer {
    fn open(server: &Server, path: &str) -> Self {
        let (socket, _) = tungstenite::connect(format!("ws://{}{path}", page_of(server)))
            .unwrap_or_else(|error| panic!("{path}: {error}"));
        Self { socket }
    }

    fn send(&mut self, text: &str) {
        self.socket.send(Message::text(text)).unwrap_or_else(|error| panic!("{text}: {error}"));
    }

    fn next(&mut self) -> Message {
        self.socket.read().unwrap_or_else(|error| panic!("the server is gone: {error}"))
    }

    /// Returns the first result of `fits` on the messages to come.
    fn wait<T>(&mut self, what: &str, mut fits: impl FnMut(&Message) -> Option<T>) -> T {
        let end = Instant::now() + PATIENCE;
        while Instant::now() < end {
            let message = self.next();
            if let Some(found) = fits(&message) {
                return found;
            }
        }
        panic!("never came: {what}");
    }

    fn frame(&mut self, what: &str, fits: impl Fn(&Frame) -> bool) -> Frame {
        self.wait(what, |message| frame(message).filter(|frame| fits(frame)))
    }

    fn status(&mut self, what: &str, fits: impl Fn(&Value) -> bool) -> Value {
        self.wait(what, |message| json(message, "status").filter(|status| fits(status)))
    }

    fn said(&mut self, part: &str) -> String {
        self.wait(part, |message| {
            json(message, "said").and_then(|said| said.as_str().map(str::to_owned)).filter(|said| said.contains(part))
        })
    }
}

fn json(message: &Message, key: &str) -> Option<Value> {
    let Message::Text(text) = message else { return None };
    serde_json::from_str::<Value>(text).ok()?.get(key).cloned()
}

/// Reads a binary message.
fn content(message: &Message) -> Option<Content> {
    let Message::Binary(bytes) = message else { return None };
    viewer_messages::Message::decode(&bytes[..]).expect("a message of live.proto").content
}

fn frame(message: &Message) -> Option<Frame> {
    let Some(Content::Frame(frame)) = content(message) else { return None };
    let robot = |it: &viewer_messages::Robot| {
        let (angle, target) = it.wheels.first().map_or((0.0, 0.0), |wheel| (wheel.angle, wheel.target));
        assert_eq!((it.pose.len(), it.contact_points.len()), (7, it.contact_forces.len()));
        (it.robot, [it.pose[0], it.pose[1], it.pose[2]], angle, target)
    };
    Some(Frame {
        time: frame.time,
        bytes: message.len(),
        robots: frame.robots.iter().map(robot).collect(),
        contacts: frame.robots.iter().map(|it| it.contact_points.len() / 3).sum(),
        objects: frame.objects.iter().map(|it| it.object).collect(),
        joints: frame.robots.iter().flat_map(|it| it.joint_positions.clone()).collect(),
    })
}

fn robot(peer: &mut Peer) {
    peer.send("INIT {ClassName USARBot.KUKA_YouBot} {Name R1} {Start RobotStart1}");
    peer.next_of("GroundTruth");
}

#[test]
fn a_viewer_sees_a_robot_come_drive_and_leave() {
    let server = serve("rough", |_| {});
    let mut viewer = Viewer::open(&server, "/live");
    viewer.frame("an empty world", |frame| frame.robots.is_empty());
    let mut peer = server.client();
    robot(&mut peer);
    let status =
        viewer.status("a robot", |status| status["robots"].as_array().is_some_and(|robots| !robots.is_empty()));
    let robot = &status["robots"][0];
    assert_eq!((&robot["class"], &robot["name"]), (&"KUKA_YouBot".into(), &"R1".into()));
    assert_eq!(robot["connection"], status["clients"][0]["connection"]);
    assert!(robot["battery"].as_i64().is_some_and(|battery| battery > 1000), "{robot}");
    peer.send("DRIVE {Left 2} {Right 2}");
    let frame = viewer.frame("it drives", |frame| frame.robots.first().is_some_and(|robot| robot.1[0] > 2.05));
    assert!(frame.robots[0].2 > 0.9 && frame.robots[0].3 == 2.0 && frame.contacts >= 4, "{frame:?}");
    drop(peer);
    viewer.frame("it leaves", |frame| frame.robots.is_empty());
}

#[test]
fn a_world_can_be_paused_stepped_and_hurried() {
    let server = serve("rough", |_| {});
    let mut viewer = Viewer::open(&server, "/live");
    viewer.frame("time passes", |frame| frame.time > 0.1);
    viewer.send("{\"pause\":true}");
    viewer.status("paused", |status| status["paused"] == true);
    let before = viewer.frame("any", |_| true).time;
    let later = (0..10).map(|_| viewer.frame("any", |_| true).time).fold(0.0, f64::max);
    assert_eq!(before, later);
    viewer.send("{\"step\":7}");
    let stepped = viewer.frame("steps", |frame| frame.time > before + 0.0135).time;
    assert!((stepped - before - 0.014).abs() < 1e-9, "{before} to {stepped}");
    viewer.send("{\"pause\":false}");
    viewer.send("{\"speed\":0}");
    let status =
        viewer.status("fast", |status| status["real_time_factor"].as_f64().is_some_and(|factor| factor > 10.0));
    assert_eq!((&status["paused"], &status["speed"]), (&false.into(), &0.0.into()));
    viewer.send("{\"fly\":1}");
    viewer.said("expected {\"pause\":bool}");
}

#[test]
fn a_page_that_may_not_control_the_world_is_told_why_and_drives_its_robot() {
    let server = serve("rough", |config| config.world_control = WorldControl::Nobody);
    let mut viewer = Viewer::open(&server, "/live");
    let refused = viewer.wait("whether it may", |message| json(message, "refused"));
    assert_eq!(refused, "no page controls this world");
    for request in
        ["{\"pause\":true}", "{\"step\":1}", "{\"speed\":0}", "\"reset\"", "{\"record\":true}", "{\"map\":\"arena\"}"]
    {
        viewer.send(request);
        assert_eq!(viewer.said("not done"), "not done: no page controls this world", "{request}");
    }
    let mut peer = server.client();
    robot(&mut peer);
    peer.send("DRIVE {Left 2} {Right 2}");
    viewer.frame("it drives", |frame| frame.robots.first().is_some_and(|robot| robot.1[0] > 2.1));
    let status = viewer.status("any", |_| true);
    assert_eq!((&status["paused"], &status["resets"], &status["recording"]), (&false.into(), &0.into(), &Value::Null));
}

#[test]
fn a_page_on_the_servers_own_machine_is_local() {
    let server = serve("rough", |config| config.world_control = WorldControl::Local);
    let mut viewer = Viewer::open(&server, "/live");
    let refused = viewer.wait("whether it may", |message| json(message, "refused"));
    assert_eq!(refused, Value::Null);
    viewer.send("{\"pause\":true}");
    viewer.status("paused", |status| status["paused"] == true);
}

#[test]
fn after_a_reset_robots_are_back_and_their_clients_drive_on() {
    let server = serve("rough", |_| {});
    let mut viewer = Viewer::open(&server, "/live");
    let mut peers = [server.client(), server.client()];
    robot(&mut peers[0]);
    peers[1].send("INIT {ClassName USARBot.P3AT} {Name second} {Start RobotStart2}");
    peers[1].next_of("GroundTruth");
    peers[0].send("DRIVE {Left 2} {Right 2}");
    viewer.frame("it drives", |frame| frame.robots.len() == 2 && frame.robots[0].1[0] > 2.1);
    viewer.send("\"reset\"");
    assert_eq!(viewer.said("reset the world"), "page 1 (127.0.0.1) reset the world");
    let status = viewer.status("reset", |status| status["resets"] == 1);
    assert_eq!(status["robots"].as_array().map(Vec::len), Some(2));
    let frame = viewer.frame("back at the start", |frame| frame.robots.len() == 2);
    assert!(frame.time < 5.0 && (frame.robots[0].1[0] - 2.0).abs() < 0.01, "{frame:?}");
    assert_eq!(frame.robots[0].3, 0.0, "it stands");
    peers[0].send("DRIVE {Left 2} {Right 2}");
    viewer.frame("it drives on", |frame| frame.robots[0].1[0] > 2.1);
    peers[1].send("GETCONF {Type Robot}");
    assert!(peers[1].reply().contains("P3AT"));
}

#[test]
fn a_viewer_changes_the_map_and_everyone_is_told_who_did() {
    let other_maps = ["rough", "arena"].map(|name| scene_loader::map(name, &[]).unwrap());
    let server = serve("rough", |config| {
        config.maps = other_maps.iter().cloned().map(AvailableMap::from).collect::<Vec<_>>().into()
    });
    let mut viewers = [Viewer::open(&server, "/live"), Viewer::open(&server, "/live")];
    let mut peer = server.client();
    robot(&mut peer);
    let before = viewers[1].status("a robot", |status| status["robots"].as_array().is_some_and(|it| it.len() == 1));
    viewers[0].send("{\"map\":\"moon\"}");
    viewers[1].said("no map `moon`: expected rough, arena");
    viewers[0].send("{\"map\":\"arena\"}");
    assert_eq!(viewers[1].said("changed the map"), "page 1 (127.0.0.1) changed the map to arena");
    let after = viewers[1].status("another scene", |status| status["scene"] != before["scene"]);
    assert_eq!((&after["viewers"], after["robots"].as_array().map(Vec::len)), (&2.into(), Some(1)));
    let (_, scene) = get(&server, "/scene.json", "Host: localhost\r\n");
    assert!(scene.contains("\"name\":\"arena\""), "{scene}");
    // RobotStart1 is at another place on this map.
    let frame = viewers[1].frame("the robot is back", |frame| frame.robots.len() == 1);
    let start = other_maps[1].starts.iter().find(|start| start.name == "RobotStart1").unwrap();
    assert!((f64::from(frame.robots[0].1[0]) - start.position[0]).abs() < 0.05, "{frame:?}");
    peer.send("GETSTARTPOSES");
    assert!(peer.reply().contains("RobotStart1"));
}

/// A scenario has solids of its own on a map of the same name, and begins anew when it is asked for again.
#[test]
fn a_scenario_is_another_scene_on_a_map_of_the_same_name_and_a_reset_is_not() {
    let mut setting = scene::Setting::from(scene_loader::map("rough", &[]).unwrap());
    setting.map.description = "of a scenario".to_owned();
    let available = AvailableScenario {
        card: scene::ScenarioCard { name: "walk".to_owned(), ..scene::ScenarioCard::default() },
        picture: None,
        read: Arc::new(move || Ok(setting.clone())),
        demo: None,
    };
    let server = serve("rough", |config| config.scenarios = vec![available].into());
    let mut viewer = Viewer::open(&server, "/live");
    let mut status = viewer.status("the first one", |_| true);
    viewer.send("{\"scenario\":\"run\"}");
    viewer.said("no scenario `run`: expected walk");
    for _ in 0..2 {
        viewer.send("{\"scenario\":\"walk\"}");
        assert_eq!(viewer.said("began"), "page 1 (127.0.0.1) began the scenario walk");
        status = viewer.status("another scene", |after| after["scene"] != status["scene"]);
    }
    let (_, scene) = get(&server, "/scene.json", "Host: localhost\r\n");
    assert!(scene.contains("of a scenario"), "{scene}");
    viewer.send("\"reset\"");
    let after = viewer.status("a reset", |after| after["resets"] != status["resets"]);
    assert_eq!(after["scene"], status["scene"]);
}

#[test]
fn positions_of_an_arms_joints_are_in_the_frames() {
    let server = serve("rough", |_| {});
    let mut viewer = Viewer::open(&server, "/live");
    let mut peer = server.client();
    peer.send("INIT {ClassName USARBot.YouBotArm} {Name arm} {Start RobotStart1}");
    peer.next_of("GroundTruth");
    peer.send("SET {Type Joint} {Name ArmJoint1} {Opcode Angle} {Params 0.5}");
    viewer.frame("it arrives", |frame| frame.joints.first().is_some_and(|joint| (joint - 0.5).abs() < 0.01));
}

#[test]
fn a_viewer_hears_the_sensors_of_the_robots_that_it_names_alone() {
    let server = serve("rough", |_| {});
    let mut viewer = Viewer::open(&server, "/live");
    let mut peers = [server.client(), server.client()];
    for (number, peer) in peers.iter_mut().enumerate() {
        peer.send(&format!("INIT {{ClassName USARBot.P3AT}} {{Name R{number}}} {{Start RobotStart{}}}", number + 1));
        peer.next_of("GroundTruth");
    }
    viewer.send("{\"wire\":false,\"robots\":[1]}");
    for _ in 0..20 {
        let reading = viewer.wait("a reading", |message| json(message, "reading"));
        assert_eq!(reading["robot"], 1, "{reading}");
        let values = &reading["quantities"][0]["values"];
        assert!(values.as_array().is_some_and(|values| !values.is_empty()), "{reading}");
    }
}

#[test]
fn a_viewer_begins_and_ends_a_log_and_a_reset_begins_the_next() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let server = serve("rough", |config| config.unnamed_log = path.clone());
    let mut viewer = Viewer::open(&server, "/live");
    let mut peer = server.client();
    robot(&mut peer);
    viewer.send("{\"record\":true}");
    viewer.said("recording to");
    let status = viewer.status("recording", |status| status["recording"].is_string());
    assert_eq!(status["recording"].as_str(), path.to_str());
    // The next log begins at least a second later.
    let begun = Instant::now();
    while begun.elapsed() < Duration::from_secs(1) {
        peer.line();
    }
    viewer.send("\"reset\"");
    viewer.said(&format!("recorded {}", path.display()));
    viewer.status("reset", |status| status["resets"] == 1 && status["recording"].as_str() != path.to_str());
    peer.wait_for("the fresh world", |line| system_tests::time_of(line).is_some_and(|time| time < 0.5));
    peer.lines_for(0.5);
    viewer.send("{\"record\":false}");
    viewer.said(&format!("recorded {}", folder.path().join("run-2.mcap").display()));
    viewer.status("no recording", |status| status["recording"].is_null());
    let read = |path: &std::path::Path| recorder::read(path).unwrap_or_else(|error| panic!("{error}"));
    let refused = logbook::replay(&read(&path)).unwrap_err().to_string();
    assert!(refused.contains("began in a running world"), "{refused}");
    let second = logbook::replay(&read(&folder.path().join("run-2.mcap"))).unwrap_or_else(|error| panic!("{error}"));
    assert!(second.is_same() && second.states > 10 && second.recorded.is_some(), "{second:?}");
}

/// A page saves a world; a server goes on with it, and a client that names its robot has it again.
#[test]
fn a_saved_world_goes_on_in_another_server_and_clients_take_their_robots_over() {
    let folder = tempfile::tempdir().unwrap();
    let init = "INIT {ClassName USARBot.P3AT} {Name R1} {Location -3,0,-0.2}";
    let server = serve("hall", |config| config.unnamed_log = folder.path().join("world.mcap"));
    let mut viewer = Viewer::open(&server, "/live");
    let mut peer = server.client();
    peer.send(init);
    let mut controller = server.client();
    controller.send("INIT {ClassName USARBotAPI.WorldController} {Name WC}");
    controller.send("CONTROL {Type Create} {ClassName WCCrate} {Name c} {Location -3,2,-0.25}");
    peer.send("DRIVE {Left 1} {Right 1}");
    peer.lines_for(1.0);
    viewer.send("\"save\"");
    viewer.said("saved the world at");
    let (before, _) = peer.ground_truth();
    viewer.send("\"save\"");
    viewer.said("world-2.json");
    server.stop().unwrap();

    let (scene, saved) = gamebots_server::read_saved(&folder.path().join("world.json")).unwrap();
    let server = Server::start("rough", &[], |config| (config.world, config.saved) = (scene, Some(saved)));
    let mut peer = server.client();
    // One of another name is another robot.
    peer.send("INIT {ClassName USARBot.P3AT} {Name R2} {Location -3,-2,-0.2}");
    let mut again = server.client();
    again.send(init);
    let (after, _) = again.ground_truth();
    assert!((after[0] - before[0]).abs() < 1.0 && after[0] > -2.95, "{after:?} after {before:?}");
    again.send("DRIVE {Left 0} {Right 0}");
    let mut controller = server.client();
    controller.send("INIT {ClassName USARBotAPI.WorldController} {Name WC}");
    controller.send("CONTROL {Type GetSTA}");
    assert!(controller.reply().starts_with("STA {Name c} {Size "));
    // Robots that a client has taken over leave with it.
    again.finish();
    while again.line_or_end().is_some() {}
    let mut third = server.client();
    third.send(init);
    let (fresh, _) = third.ground_truth();
    assert!((fresh[0] + 3.0).abs() < 0.05, "{fresh:?}");
}

/// A page that asks for a robot's pictures gets what its camera sees; one that does not costs nothing.
#[test]
fn a_viewer_gets_pictures_of_the_cameras_that_it_asks_for() {
    let server = serve("hall", |_| {});
    let mut peers = [server.client(), server.client()];
    for (peer, y) in peers.iter_mut().zip([0, 2]) {
        peer.send(&format!("INIT {{ClassName USARBot.P3AT}} {{Location -3,{y},-0.2}}"));
        peer.next_of("GroundTruth");
    }
    let (_, class) = get(&server, "/class/P3AT", "Host: localhost\r\n");
    let class: Value = serde_json::from_str(&class).unwrap();
    let sensors = class["sensors"].as_array().unwrap();
    let camera = sensors.iter().position(|sensor| sensor["camera"]["width"] == 320).unwrap();
    let mut viewer = Viewer::open(&server, "/live");
    viewer.send("{\"wire\":false,\"robots\":[],\"cameras\":[1,1,7]}");
    let mut before = 0.0;
    for _ in 0..3 {
        let picture = viewer.wait("a picture", |message| match content(message) {
            Some(Content::Picture(picture)) => Some(picture),
            _ => None,
        });
        assert_eq!((picture.robot, picture.sensor as usize), (1, camera));
        let time = picture.time;
        assert!(time >= before + 0.09, "{time} after {before}");
        before = time;
        let reader = png::Decoder::new(std::io::Cursor::new(&picture.png)).read_info().unwrap();
        assert_eq!((reader.info().width, reader.info().height), (320, 240));
    }
    viewer.send("{\"wire\":false,\"robots\":[],\"cameras\":[]}");
    viewer.frame("a frame after the wish", |_| true);
    let is_picture = |message: &Message| matches!(content(message), Some(Content::Picture(_)));
    let (mut frames, mut late) = (0, 0);
    while frames < 30 {
        let message = viewer.next();
        frames += usize::from(frame(&message).is_some());
        late += usize::from(is_picture(&message));
    }
    assert!(late <= 2, "{late} pictures after the wish ended");
}

/// A log has the picture of every tenth of a second, and its replay draws the same.
#[test]
fn pictures_of_cameras_are_in_the_log_and_replayed() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let server = Server::start("hall", &[], |config| {
        (config.log, config.pictures, config.real_time_factor) = (Some(path.clone()), true, 0.0);
    });
    let mut peer = server.client();
    peer.send("INIT {ClassName USARBot.P3AT} {Location -3,0,-0.2}");
    peer.send("DRIVE {Left 2} {Right 1}");
    peer.lines_for(1.5);
    peer.finish();
    server.stop().unwrap();
    let mut log = recorder::read(&path).unwrap_or_else(|error| panic!("{error}"));
    let pictures = |log: &recorder::Log| {
        let taken = |entry: &recorder::Entry| match &entry.record {
            Record::Picture(taken, _) => Some((entry.time, *taken)),
            _ => None,
        };
        log.entries.iter().filter_map(taken).collect::<Vec<_>>()
    };
    let taken = pictures(&log);
    assert!(taken.len() >= 10, "{} pictures", taken.len());
    for pair in taken.windows(2) {
        assert!((pair[1].1.moment - pair[0].1.moment - 0.1).abs() < 1e-6, "{pair:?}");
        assert!((pair[1].0 - pair[1].1.moment - 0.1).abs() < 1e-6, "recorded late: {pair:?}");
        assert_ne!(pair[0].1.digest, pair[1].1.digest);
    }
    let replay = logbook::replay(&log).unwrap_or_else(|error| panic!("{error}"));
    assert!(replay.is_same() && replay.recorded.is_some(), "{replay:?}");
    // One pixel would be another digest.
    for entry in &mut log.entries {
        if let Record::Picture(taken, _) = &mut entry.record {
            taken.digest ^= 1;
        }
    }
    let other = logbook::replay(&log).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(other.first_difference, Some(taken[0].0));
}

/// A page hears of objects that a controller creates and removes; the log has them, too, and replays.
#[test]
fn objects_of_a_world_controller_are_on_the_page_and_in_the_log() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.mcap");
    let server = serve("hall", |config| config.log = Some(path.clone()));
    let mut viewer = Viewer::open(&server, "/live");
    let of_map = viewer.frame("the map's objects", |frame| !frame.objects.is_empty()).objects;
    assert_eq!(of_map, (0..of_map.len() as u32).collect::<Vec<_>>());
    let before = viewer.status("a status", |_| true)["objects"].as_u64();
    let mut peer = server.client();
    robot(&mut peer);
    let mut controller = server.client();
    controller.send("INIT {ClassName USARBotAPI.WorldController} {Name WC}");
    controller
        .send("CONTROL {Type Create} {ClassName WCCrate} {Name my_crate} {Location -3,0,-0.5} {Physics RigidBody}");
    let created = of_map.len() as u32;
    viewer.frame("the crate", |frame| frame.objects.contains(&created));
    viewer.status("other objects", |status| status["objects"].as_u64() != before);
    let (_, objects) = get(&server, "/objects.json", "Host: localhost\r\n");
    let objects: Value = serde_json::from_str(&objects).unwrap();
    assert_eq!((&objects[0]["number"], &objects[0]["name"]), (&created.into(), &"my_crate".into()), "{objects}");
    assert!(objects[0]["shape"]["Box"]["size"].is_array() && objects[0]["pose"].is_array(), "{objects}");
    peer.lines_for(0.5);
    controller.send("CONTROL {Type Kill} {Name MY_CRATE}");
    viewer.frame("no crate", |frame| frame.objects == of_map);
    controller.send("CONTROL {Type Create} {ClassName WCPallet} {Name lift} {Location -3,0,-0.5}");
    viewer.frame("a pallet", |frame| frame.objects.contains(&(created + 1)));
    controller.finish();
    let removed = viewer.frame("no pallet", |frame| frame.objects == of_map).time;
    // The log has states every 20 ms.
    viewer.frame("a state in the log", |frame| frame.time > removed + 0.05);
    server.stop().unwrap();
    let log = recorder::read(&path).unwrap_or_else(|error| panic!("{error}"));
    assert!(log.damage.is_none(), "{:?}, {:?}", log.damage, log.end);
    let count = |is_it: fn(&Record) -> bool| log.entries.iter().filter(|entry| is_it(&entry.record)).count();
    assert_eq!(count(|it| matches!(it, Record::ObjectSpawned(it) if it.def().is_some())), 2);
    let gone = log.entries.iter().filter(|entry| matches!(entry.record, Record::ObjectRemoved(_)));
    let gone: Vec<f64> = gone.map(|entry| entry.time).collect();
    assert_eq!(gone.len(), 2, "removed at {gone:?} s in the log, at {removed} s on the page; its end: {:?}", log.end);
    let falls = |it: &Record| matches!(it, Record::Object(state) if state.name == "my_crate");
    assert!(count(falls) > 5);
    let replay = logbook::replay(&log).unwrap_or_else(|error| panic!("{error}"));
    assert!(replay.is_same() && replay.recorded.is_some(), "{replay:?}");
}

#[test]
fn the_lines_of_the_wire_are_told_to_who_asks() {
    let server = serve("rough", |_| {});
    let mut viewer = Viewer::open(&server, "/live");
    viewer.send("{\"wire\":true}");
    viewer.frame("a frame after the wish", |_| true);
    let mut peer = server.client();
    robot(&mut peer);
    let line = |direction: &'static str, part: &'static str| {
        move |message: &Message| {
            json(message, "line").filter(|line| {
                line["direction"] == direction && line["text"].as_str().is_some_and(|text| text.contains(part))
            })
        }
    };
    let init = viewer.wait("INIT", line("in", "INIT"));
    let truth = viewer.wait("GroundTruth", line("out", "GroundTruth"));
    assert_eq!((&init["connection"], &truth["robot"]), (&truth["connection"], &0.into()));
}

#[test]
fn the_wire_of_a_page_is_a_client_like_every_other() {
    let server = serve("rough", |_| {});
    let mut wire = Viewer::open(&server, "/wire");
    let mut text = String::new();
    wire.send("INIT {ClassName USARBot.P3AT} {Start PlayerStart_0}\r\nGETCONF {Type Robot}\r\n");
    while !(text.contains("CONF {Name P3AT}") && text.contains("{Type GroundTruth}")) {
        if let Message::Binary(bytes) = wire.next() {
            text.push_str(&String::from_utf8_lossy(&bytes));
        }
    }
    assert!(text.starts_with("NFO {Gametype BotDeathMatch} {Level rough} {TimeLimit 20}\r\n"), "{text}");
    let mut viewer = Viewer::open(&server, "/live");
    viewer.frame("its robot", |frame| frame.robots.len() == 1);
    wire.socket.close(None).unwrap();
    viewer.frame("its robot leaves with it", |frame| frame.robots.is_empty());
}

/// Requests a path. Returns the answer's head and body.
fn get(server: &Server, path: &str, headers: &str) -> (String, String) {
    ask(server, &format!("GET {path} HTTP/1.1\r\nConnection: close\r\n{headers}\r\n"), &[])
}

/// Returns the world of a log as pages send it: its scene, which has all classes in an old log.
fn of_log(scene: &[u8]) -> Vec<u8> {
    [b"{\"scene\":", scene, b"}"].concat()
}

/// Posts the world of a log. Returns the answer's head and body.
fn post_scene(server: &Server, body: &[u8]) -> (String, String) {
    let head = "POST /scene.json HTTP/1.1\r\nConnection: close\r\nHost: localhost\r\n";
    ask(server, &format!("{head}Content-Length: {}\r\n\r\n", body.len()), body)
}

fn ask(server: &Server, head: &str, body: &[u8]) -> (String, String) {
    let mut stream = TcpStream::connect(page_of(server)).unwrap();
    stream.write_all(&[head.as_bytes(), body].concat()).unwrap();
    let mut text = Vec::new();
    stream.read_to_end(&mut text).unwrap();
    let text = String::from_utf8_lossy(&text).into_owned();
    let (head, body) = text.split_once("\r\n\r\n").unwrap_or((&text, ""));
    (head.to_owned(), body.to_owned())
}

/// Browsers take packed bodies.
#[test]
fn the_page_its_scene_and_classes_are_packed_for_those_who_can_unpack_them() {
    let server = serve("rough", |_| {});
    for path in ["/scene.json", "/scene.json", "/class/KUKA_YouBot", "/class/KUKA_YouBot", "/", "/"] {
        let (_, whole) = get(&server, path, "Host: localhost\r\n");
        let head =
            format!("GET {path} HTTP/1.1\r\nConnection: close\r\nHost: localhost\r\nAccept-Encoding: br, gzip\r\n\r\n");
        let mut stream = TcpStream::connect(page_of(&server)).unwrap();
        stream.write_all(head.as_bytes()).unwrap();
        let mut bytes = Vec::new();
        stream.read_to_end(&mut bytes).unwrap();
        let end = bytes.windows(4).position(|four| four == b"\r\n\r\n").unwrap();
        assert!(String::from_utf8_lossy(&bytes[..end]).contains("content-encoding: gzip"));
        let packed = &bytes[end + 4..];
        let mut text = String::new();
        flate2::read::GzDecoder::new(packed).read_to_string(&mut text).unwrap();
        assert!(text == whole);
        // Without Node.js the page is a few lines.
        let most = if path == "/" { whole.len() } else { whole.len() / 2 };
        assert!(packed.len() < most, "{path}: {} of {} bytes", packed.len(), whole.len());
    }
}

/// Supervisors call the machine as they like, and Prometheus reads lines of comments and of a name and a number.
#[test]
fn a_supervisor_reads_numbers() {
    let server = serve("rough", |_| {});
    let mut robot = server.bystander();
    robot.ground_truth();
    let (head, body) = get(&server, "/health", "Host: usarsim\r\n");
    assert!(head.starts_with("HTTP/1.1 200") && body.starts_with("{\"status\":\"ok\",\"time\":"), "{body}");
    let numbers = || {
        let (head, body) = get(&server, "/metrics", "Host: usarsim\r\n");
        assert!(head.contains("content-type: text/plain; version=0.0.4"), "{head}");
        let lines = body.lines().filter(|line| !line.starts_with('#'));
        let number =
            |line: &str| line.split_once(' ').map(|(name, value)| (name.to_owned(), value.parse::<f64>().unwrap()));
        lines.map(|line| number(line).unwrap()).collect::<std::collections::BTreeMap<String, f64>>()
    };
    let before = numbers();
    robot.lines_for(0.5);
    let after = numbers();
    assert_eq!((after["usarsim_robots"], after["usarsim_clients"], after["usarsim_paused"]), (1.0, 1.0, 0.0));
    for name in ["usarsim_simulated_seconds", "usarsim_steps_total", "usarsim_step_seconds_total"] {
        assert!(after[name] > before[name], "{name}: {} and {}", before[name], after[name]);
    }
}

#[test]
fn pages_of_strangers_are_turned_away() {
    let server = serve("rough", |_| {});
    let (head, body) = get(&server, "/", "Host: rebound.example\r\n");
    assert!(head.starts_with("HTTP/1.1 403") && body.contains("expected localhost"), "{head}\n{body}");
    for path in ["/live", "/wire"] {
        let mut request = format!("ws://{}{path}", page_of(&server)).into_client_request().unwrap();
        request.headers_mut().insert("Origin", "http://evil.example".parse().unwrap());
        let refused = tungstenite::connect(request);
        assert!(
            matches!(&refused, Err(tungstenite::Error::Http(response)) if response.status() == 403),
            "{path}: {refused:?}"
        );
    }
    let (head, body) = get(&server, "/", "Host: localhost\r\n");
    assert!(head.starts_with("HTTP/1.1 200") && body.contains("usarsim"), "{head}");
    assert!(head.to_ascii_lowercase().contains("frame-ancestors 'none'"), "{head}");
    assert!(!head.to_ascii_lowercase().contains("access-control-allow-origin"), "{head}");
    let (head, _) = get(&server, "/../../Cargo.toml", "Host: localhost\r\n");
    assert!(head.starts_with("HTTP/1.1 404"), "{head}");
}

#[test]
fn the_scene_has_what_a_viewer_draws() {
    let server = serve("arena", |_| {});
    let (_, body) = get(&server, "/scene.json", "Host: localhost\r\n");
    let scene: Value = serde_json::from_str(&body).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(scene["map"]["name"], "arena");
    let solids = scene["map"]["solids"].as_array().unwrap();
    assert!(
        solids.iter().all(|solid| solid["pose"].as_array().unwrap().len() == 7 && solid["shape"].get("Hull").is_none())
    );
    assert_eq!(scene["classes"], serde_json::json!({}));
    assert!(scene["names"].as_array().unwrap().contains(&"KUKA_YouBot".into()));
    let (_, body) = get(&server, "/class/KUKA_YouBot", "Host: localhost\r\n");
    let class: Value = serde_json::from_str(&body).unwrap_or_else(|error| panic!("{error}"));
    let wheels = class["wheels"].as_array().unwrap();
    assert_eq!(wheels.len(), 4);
    let rollers = &wheels[0]["rollers"];
    assert_eq!(rollers["poses"].as_array().unwrap().len(), 6);
    let outline = rollers["outline"].as_array().unwrap();
    // The roller is 14 mm thick at the middle, and the ring of rollers is round.
    assert!((outline[outline.len() / 2][1].as_f64().unwrap() - 0.014).abs() < 1e-12);
}

#[test]
fn a_class_that_the_world_lacks_or_cannot_read_is_refused_by_name() {
    let server = serve("rough", |config| config.world.robots.insert_unread("Broken", || Err("no wheels".to_owned())));
    for (path, status, text) in [
        ("/class/Nobody", 404, "no class `Nobody`: expected one of "),
        ("/class/%0a%F0%9F%92%A9", 404, "no class `\\n\u{1f4a9}`: expected one of "),
        ("/class/P3AT/more", 404, ""),
        ("/class/Broken", 422, "class Broken: no wheels"),
    ] {
        let (head, body) = get(&server, path, "Host: localhost\r\n");
        assert!(head.starts_with(&format!("HTTP/1.1 {status}")) && body.starts_with(text), "{path}: {head}\n{body}");
    }
    let mut peer = server.client();
    peer.send("REPORT {Errors true}");
    peer.send("INIT {ClassName USARBot.Broken}");
    peer.wait_for("the reason", |line| line.contains("no wheels"));
}

#[test]
fn the_scene_of_a_log_is_answered_like_that_of_the_world() {
    let mut stored = String::new();
    let server = serve("arena", |config| stored = serde_json::to_string(&config.world).unwrap());
    let scene = |body: &str| serde_json::from_str::<Value>(body).unwrap_or_else(|error| panic!("{error}: {body:.200}"));
    let (_, own) = get(&server, "/scene.json", "Host: localhost\r\n");
    let (head, answer) = post_scene(&server, &of_log(stored.as_bytes()));
    assert!(head.starts_with("HTTP/1.1 200") && head.contains("application/json"), "{head}");
    let (mut own, answer) = (scene(&own), scene(&answer));
    let (_, class) = get(&server, "/class/YouBotArm", "Host: localhost\r\n");
    assert!(scene(&class) == answer["classes"]["YouBotArm"]);
    // A log has its seed and time step beside the scene, and no server.
    for server in ["seed", "time_step", "port"] {
        own[server] = Value::Null;
    }
    own["maps"] = serde_json::json!([]);
    // It has its classes beside the scene.
    own["classes"] = answer["classes"].clone();
    assert!(own == answer, "{answer:.300}");
    let values = answer["classes"]["YouBotArm"]["values"].as_array().unwrap();
    let joints = answer["classes"]["YouBotArm"]["joints"].as_array().unwrap();
    assert!(joints.len() >= 5 && joints.iter().all(|joint| values.contains(&joint["name"])), "{values:?}");
    // A log from before robots were trees of links.
    let old = Path::new(env!("CARGO_MANIFEST_DIR")).join("../crates/logbook/tests/logs/before-trees.mcap");
    let (head, answer) = post_scene(&server, &of_log(recorder::read(&old).unwrap().run["scene"].as_bytes()));
    assert!(head.starts_with("HTTP/1.1 200"), "{head}\n{answer}");
    assert_eq!(scene(&answer)["classes"]["KUKA_YouBot"]["wheels"].as_array().map(Vec::len), Some(4));
}

#[test]
fn a_scene_that_no_world_can_be_made_of_is_refused_by_name() {
    let mut world = scene::WorldDef::default();
    let server = serve("arena", |config| world = config.world.clone());
    let changed = |change: fn(&mut scene::WorldDef)| {
        let mut world = world.clone();
        change(&mut world);
        of_log(&serde_json::to_vec(&world).unwrap())
    };
    let stored = of_log(&serde_json::to_vec(&world).unwrap());
    let named = |names: &str| format!("{{\"scene\":{},\"names\":{names}}}", serde_json::to_string(&world).unwrap());
    for (body, status, what) in [
        (Vec::new(), 422, "EOF"),
        (b"hello".to_vec(), 422, "expected value"),
        (b"{}".to_vec(), 422, "missing field"),
        (vec![b'['; 1 << 20], 422, "column"),
        (b"\xff\xfe{\"map\":\"\xed\xa0\x80\"}".to_vec(), 422, "its scene"),
        (stored[..stored.len() / 2].to_vec(), 422, "EOF"),
        (changed(|world| world.map.gravity = f64::NAN), 422, "expected f64"),
        (changed(|world| world.map.gravity = 1e300), 422, "gravity"),
        (changed(|world| world.map.name = "a".repeat(100_000)), 422, "name"),
        (
            changed(|world| {
                let mesh = scene::Shape::Mesh { vertices: vec![[0.0; 3]; 3], triangles: vec![[0, 1, 4_000_000_000]] };
                world.map.solids[0].shape = mesh;
            }),
            422,
            "a triangle has the corner",
        ),
        (named("[\"a b\"]").into(), 422, "a class `a b`: expected a name without spaces"),
        (
            named(&format!("[{}\"\"]", "\"a\",".repeat(5000))).into(),
            422,
            "5001 classes of robots: expected at most 4096",
        ),
        (changed(|world| hull_of(world, vec![[0.0; 3]; 9_000])), 422, "in one plane"),
        (changed(|world| hull_of(world, vec![[1e308, -1e308, 1e-308]; 4])), 422, "corner"),
    ] {
        let (head, answer) = post_scene(&server, &body);
        assert!(head.starts_with(&format!("HTTP/1.1 {status}")) && answer.contains(what), "{what}: {head}\n{answer}");
    }
    let head = "POST /scene.json HTTP/1.1\r\nConnection: close\r\nHost: localhost\r\n";
    let (answer, body) = ask(&server, &format!("{head}Content-Length: 99999999999\r\n\r\n"), b"{}");
    assert!(answer.starts_with("HTTP/1.1 413") && body.contains("expected at most 33554432 bytes"), "{answer}\n{body}");
    let (answer, _) = ask(&server, &format!("{head}Origin: http://evil.example\r\nContent-Length: 2\r\n\r\n"), b"{}");
    assert!(answer.starts_with("HTTP/1.1 403"), "{answer}");
}

fn hull_of(world: &mut scene::WorldDef, points: Vec<[f64; 3]>) {
    world.map.solids[0].shape = scene::Shape::Hull { points };
}

/// Clients that never finish a request block the few places for 30 s at most. The world does not wait, and its own scene is still served.
#[test]
fn scenes_that_never_come_hold_up_nothing_else() {
    let server = serve("rough", |_| {});
    let stuck: Vec<TcpStream> = (0..20)
        .map(|_| {
            let mut stream = TcpStream::connect(page_of(&server)).unwrap();
            stream.write_all(b"POST /scene.json HTTP/1.1\r\nHost: localhost\r\nContent-Length: 1000\r\n\r\n{").unwrap();
            stream
        })
        .collect();
    let (head, _) = get(&server, "/scene.json", "Host: localhost\r\n");
    assert!(head.starts_with("HTTP/1.1 200"), "{head}");
    let mut viewer = Viewer::open(&server, "/live");
    viewer.frame("time passes", |frame| frame.time > 0.1);
    // The places are free after the clients left.
    drop(stuck);
    let (head, _) = post_scene(&server, b"{}");
    assert!(head.starts_with("HTTP/1.1 422"), "{head}");
}

/// The limit is 200 kB/s for ten youBots at 30 Hz.
#[test]
fn the_state_of_ten_youbots_is_small() {
    let server = serve("rough", |_| {});
    let mut peers: Vec<Peer> = (0..10).map(|_| server.client()).collect();
    for (number, peer) in peers.iter_mut().enumerate() {
        peer.send(&format!("INIT {{ClassName USARBot.KUKA_YouBot}} {{Location {number},0,0}}"));
        peer.send("DRIVE {Left 1} {Right 1}");
    }
    let mut viewer = Viewer::open(&server, "/live");
    let frame = viewer.frame("all robots stand", |frame| frame.robots.len() == 10 && frame.contacts >= 40);
    println!("{} bytes a frame, {} contacts", frame.bytes, frame.contacts);
    assert!(frame.bytes * 30 < 200_000, "{frame:?}");
}

#[test]
fn a_stalled_viewer_is_dropped_and_holds_nobody_up() {
    let server = serve("rough", |config| config.stall_timeout = Duration::from_millis(300));
    let mut peer = server.client();
    peer.send("INIT {ClassName USARBot.KUKA_YouBot} {Start RobotStart1}");
    let mut stalled = TcpStream::connect(page_of(&server)).unwrap();
    let head = "GET /live HTTP/1.1\r\nHost: localhost\r\nConnection: Upgrade\r\nUpgrade: websocket\r\n\
        Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n";
    stalled.write_all(head.as_bytes()).unwrap();
    let mut viewer = Viewer::open(&server, "/live");
    // Lines of the wire fill the operating system's buffers: about 6 MB on the reader's side.
    let mut byte = [0];
    stalled.read_exact(&mut byte).unwrap();
    assert_eq!(&byte, b"H");
    let wish = b"{\"wire\":true}";
    let mut masked = vec![0x81, 0x80 | wish.len() as u8, 0, 0, 0, 0];
    masked.extend(wish);
    stalled.write_all(&masked).unwrap();
    viewer.send("{\"speed\":0}");
    let end = Instant::now() + PATIENCE;
    stalled.set_nonblocking(true).unwrap();
    // Writing to a connection that the other side has closed fails sooner or later.
    while stalled.write(&[0x8a, 0x80, 0, 0, 0, 0]).is_ok() {
        assert!(Instant::now() < end, "it is still there");
        viewer.frame("the world goes on", |_| true);
    }
}

#[test]
fn a_speed_that_no_clock_can_keep_is_refused() {
    let server = serve("rough", |_| {});
    let mut viewer = Viewer::open(&server, "/live");
    for speed in ["1e-300", "1e-22", "1e-4", "-1", "1e5"] {
        viewer.send(&format!("{{\"speed\":{speed}}}"));
        viewer.said("expected 0.001 to 10000, or 0 for as fast as possible");
    }
    viewer.send("{\"speed\":0.001}");
    viewer.status("the slowest speed", |status| status["speed"] == 0.001);
    viewer.send("{\"speed\":1}");
    let now = viewer.frame("a frame", |_| true).time;
    viewer.frame("time goes on", |frame| frame.time > now + 0.1);
}

#[test]
fn a_websocket_keeps_its_place_among_the_connections() {
    let server = serve("rough", |_| {});
    let mut viewers: Vec<Viewer> = (0..256).map(|_| Viewer::open(&server, "/live")).collect();
    let status = || {
        let mut late = TcpStream::connect(page_of(&server)).unwrap();
        late.write_all(b"GET /objects.json HTTP/1.1\r\nHost: localhost\r\n\r\n").unwrap();
        let mut status = [0; 12];
        late.read_exact(&mut status).unwrap();
        String::from_utf8_lossy(&status).into_owned()
    };
    assert_eq!(status(), "HTTP/1.1 503", "every place is taken");
    viewers.pop();
    system_tests::wait_until(|| status() == "HTTP/1.1 200");
}

#[test]
fn a_page_that_asks_faster_than_it_is_answered_gets_every_answer() {
    const QUESTIONS: usize = 120_000;
    let server = serve("rough", |_| {});
    let mut viewer = Viewer::open(&server, "/wire");
    let MaybeTlsStream::Plain(stream) = viewer.socket.get_ref() else { panic!("no plain stream") };
    let stream = stream.try_clone().unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    let mut reader = WebSocket::from_raw_socket(stream, Role::Client, None);
    // The spaces make the lines exceed the operating system's buffers.
    let questions = format!("GETSTARTPOSES{}\r\n", " ".repeat(240)).repeat(250);
    let sending = std::thread::spawn(move || {
        (0..QUESTIONS / 250).for_each(|_| viewer.send(&questions));
        viewer
    });
    let (mut text, mut answers) = (Vec::new(), 0);
    while answers < QUESTIONS {
        match reader.read().unwrap() {
            Message::Binary(bytes) => text.extend(bytes),
            Message::Close(_) => panic!("closed after {answers} answers"),
            _ => {}
        }
        // Keep the incomplete last line.
        let whole = text.iter().rposition(|&byte| byte == b'\n').map_or(0, |end| end + 1);
        answers += String::from_utf8_lossy(&text[..whole]).matches("{StartPoses 3}").count();
        text.drain(..whole);
    }
    drop(sending.join().unwrap());
}

#[test]
fn the_server_stops_while_viewers_ask_for_more_than_it_does() {
    let server = serve("rough", |config| config.real_time_factor = 0.0);
    let address = page_of(&server);
    let viewers: Vec<_> = (0..8)
        .map(|_| {
            let (mut socket, _) = tungstenite::connect(format!("ws://{address}/live")).unwrap();
            std::thread::spawn(move || while socket.send(Message::text("{\"step\":1000}")).is_ok() {})
        })
        .collect();
    Viewer::open(&server, "/live").status("a pause", |status| status["paused"] == true);
    let (ended, end) = std::sync::mpsc::channel();
    std::thread::spawn(move || ended.send(server.stop().is_ok()));
    assert_eq!(end.recv_timeout(PATIENCE), Ok(true), "it hangs");
    viewers.into_iter().for_each(|viewer| viewer.join().unwrap());
}

/// Connects to a server of Foxglove's protocol and subscribes to its channels.
fn subscribed(address: SocketAddr) -> WebSocket<MaybeTlsStream<TcpStream>> {
    let mut request = format!("ws://{address}").into_client_request().unwrap();
    request.headers_mut().insert("sec-websocket-protocol", "foxglove.sdk.v1".parse().unwrap());
    let (mut socket, _) = tungstenite::connect(request).unwrap();
    let MaybeTlsStream::Plain(stream) = socket.get_ref() else { panic!("no plain stream") };
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    let channels = std::iter::repeat_with(|| socket.read().unwrap()).find_map(|message| json(&message, "channels"));
    let channels = channels.unwrap().as_array().unwrap().clone();
    let subscriptions: Vec<Value> = channels
        .iter()
        .enumerate()
        .map(|(number, channel)| serde_json::json!({ "id": number, "channelId": channel["id"] }))
        .collect();
    let text = serde_json::json!({ "op": "subscribe", "subscriptions": subscriptions }).to_string();
    socket.send(Message::text(text)).unwrap();
    socket
}

/// Returns the listeners of this machine at loopback addresses that nobody chooses (Linux).
fn hidden_listeners() -> Vec<SocketAddr> {
    let table = std::fs::read_to_string("/proc/net/tcp").unwrap();
    let rows = table.lines().skip(1).map(|line| line.split_whitespace().collect::<Vec<_>>());
    let listening = rows.filter(|row| row.get(3) == Some(&"0A")).filter_map(|row| {
        let (address, port) = row.get(1)?.split_once(':')?;
        let address = u32::from_str_radix(address, 16).ok()?.to_le_bytes();
        Some(SocketAddr::from((address, u16::from_str_radix(port, 16).ok()?)))
    });
    let is_hidden =
        |address: &SocketAddr| address.ip().is_loopback() && address.ip() != std::net::IpAddr::from([127, 0, 0, 1]);
    listening.filter(is_hidden).collect()
}

/// Programs of other users of the machine find the server behind the gate.
#[cfg(target_os = "linux")]
#[test]
fn foxgloves_own_server_sends_nothing_to_those_who_go_around_the_gate() {
    let server = serve("rough", |config| config.listeners.push(Listener::new(Service::Foxglove, 0)));
    let mut peer = server.client();
    robot(&mut peer);
    // A test beside this one may have a server of its own, which can end at any time.
    let port = server.foxglove.unwrap();
    let hidden = hidden_listeners();
    assert!(!hidden.is_empty());
    let (sent, received) = std::sync::mpsc::channel();
    for address in hidden {
        let sent = sent.clone();
        std::thread::spawn(move || {
            let mut socket = subscribed(address);
            while let Ok(message) = socket.read() {
                // The time is for everybody.
                if let Message::Binary(bytes) = message
                    && bytes.first() == Some(&1)
                {
                    let _ = sent.send(address);
                }
            }
        });
    }
    let mut admitted = subscribed(SocketAddr::from(([127, 0, 0, 1], port)));
    let mut messages = 0;
    while messages < 200 {
        let message = admitted.read().unwrap();
        messages += usize::from(matches!(message, Message::Binary(bytes) if bytes.first() == Some(&1)));
    }
    assert_eq!(received.try_recv().ok(), None);
}

#[test]
fn pages_of_strangers_are_turned_away_from_foxgloves_port() {
    let server = serve("rough", |config| config.listeners.push(Listener::new(Service::Foxglove, 0)));
    let port = server.foxglove.unwrap_or_else(|| panic!("no port"));
    for (origin, expected) in [
        ("", "101"),
        ("Origin: https://app.foxglove.dev\r\n", "101"),
        ("Origin: http://localhost:8080\r\n", "101"),
        ("Origin: https://evil.example\r\n", "403"),
        ("Origin: null\r\n", "403"),
        ("Origin: http://localhost:8080\r\nOrigin: https://evil.example\r\n", "403"),
    ] {
        let mut stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
        let head = "GET / HTTP/1.1\r\nConnection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n\
                    Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: foxglove.sdk.v1\r\n";
        stream.write_all(format!("{head}Host: localhost:{port}\r\n{origin}\r\n").as_bytes()).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let mut status = [0; 12];
        stream.read_exact(&mut status).unwrap();
        assert_eq!(&status[9..], expected.as_bytes(), "{origin}");
    }
}

#[test]
fn a_page_gets_its_numbers_back_between_frames() {
    let server = serve("arena", |_| {});
    let mut viewer = Viewer::open(&server, "/live");
    for number in [7, u32::MAX, 7, 0] {
        viewer.send(&format!("{{\"echo\":{number}}}"));
        assert_eq!(viewer.wait("an echo", |message| json(message, "echo")), number);
        viewer.frame("a frame", |_| true);
    }
    viewer.send("{\"echo\":-1}");
    viewer.said("not understood");
}

#[test]
fn a_page_is_told_where_a_robot_can_stand() {
    let server = serve("arena", |_| {});
    let mut peer = server.client();
    robot(&mut peer);
    let mut viewer = Viewer::open(&server, "/live");
    for (class, place, stands, why) in [
        ("P3AT", "0,0,0", true, ""),
        ("P3AT", "-3,2,0", false, "the solid `pillar-2` takes it"),
        ("P3AT", "-5,4.2,0", false, "robot 0 `R1` takes it"),
        ("P3AT", "1e300,0,0", false, "it is outside the map"),
        ("NoSuch", "0,0,0", false, "no class `NoSuch`"),
    ] {
        viewer.send(&format!("{{\"fit\":{{\"class\":\"{class}\",\"location\":[{place}],\"yaw\":0.5}}}}"));
        let fit = viewer.wait("an answer", |message| json(message, "fit"));
        let said = fit["why"].as_str().unwrap_or_default();
        assert_eq!((fit["class"].as_str(), fit["stands"].as_bool()), (Some(class), Some(stands)), "{fit}");
        assert!(said.starts_with(why) && said.is_empty() == why.is_empty(), "{fit}");
    }
    viewer.send("{\"fit\":{\"class\":\"P3AT\",\"location\":[0,0],\"yaw\":0}}");
    viewer.said("not understood");
    // The request spawned no robot.
    assert_eq!(viewer.frame("a frame", |_| true).robots.len(), 1);
}

/// The points of a round with a pause and a robot that a referee takes out are those of its replay.
#[test]
fn what_a_referee_does_in_a_round_is_in_its_log() {
    let folder = tempfile::tempdir().expect("a folder");
    let log = folder.path().join("run.mcap");
    let league = scene_loader::league(Path::new("rescue"), None).expect("a league").league;
    let server = serve("rescue", |config| {
        config.world.league = Some(scene::League { time_limit: 10.0, ..league });
        config.real_time_factor = 0.0;
        config.log = Some(log.clone());
    });
    let mut referee = Viewer::open(&server, "/live");
    referee.send("{\"pause\":true}");
    referee.status("paused", |status| status["paused"] == true);
    let mut clients = ["red", "blue"].map(|team| {
        let mut client = server.client();
        client.send(&format!("INIT {{ClassName P3AT}} {{Team {team}}}"));
        client.send("DRIVE {Left 3} {Right 3}");
        client
    });
    let status = referee.status("two robots", |status| status["robots"].as_array().is_some_and(|it| it.len() == 2));
    // The world has a time already, from which the clock counts: the difference of two times is rounded.
    let left = status["league"]["time_left"].as_f64().expect("a time");
    assert!((left - 10.0).abs() < 1e-9, "the clock stands: {status}");
    referee.send("{\"pause\":false}");
    referee.said("resumed the world");
    referee.send("{\"remove\":1}");
    referee.said("removed robot 1 (P3AT)");
    referee.status("the end", |status| status["league"]["is_over"] == true && status["paused"] == true);
    clients.iter_mut().for_each(Peer::finish);
    server.stop().expect("a good end");
    let log = recorder::read(&log).expect("a log");
    for done in ["paused the world", "resumed the world", "removed robot 1 (P3AT)", "the time is up"] {
        let is_it = |record: &Record| matches!(record, Record::Warning(text) if text.contains(done));
        assert!(log.entries.iter().any(|entry| is_it(&entry.record)), "{done}");
    }
    assert!(logbook::replay(&log).expect("a replay").is_same());
}
