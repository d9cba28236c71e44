//! Recorded streams of real controllers, replayed: the robot moves, Stop! stops it, questions are answered.
//!
//! The recordings are not part of this repository: `USARSIM_CAPTURES` names their folder, and `--ignored` runs these tests.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use gamebots_proto::Line;
use system_tests::{Peer, Server, recordings};

/// Speed of simulation and replay, in seconds per second.
const SPEED: f64 = 4.0;
/// Speed for the youBot of the engine: a debug build simulates at most 1.8 seconds of it per second of one core.
const ENGINE_SPEED: f64 = 1.0;

/// One connection of a recording, with all lines that the server sent.
#[derive(Default)]
struct Exchange {
    lines: Vec<String>,
    /// Number of lines that had come when Stop! was sent.
    stopped_at: Option<usize>,
}

impl Exchange {
    fn positions(&self) -> Vec<[f64; 3]> {
        let truths = self.lines.iter().filter(|line| line.contains("{Type GroundTruth}") && line.starts_with("SEN"));
        truths.filter_map(|line| position(line)).collect()
    }

    fn travelled(&self) -> f64 {
        let positions = self.positions();
        let (Some(first), Some(last)) = (positions.first(), positions.last()) else { return 0.0 };
        distance(first, last)
    }

    /// Returns the last line of a type of sensor.
    fn reading(&self, sensor: &str) -> &str {
        let head = format!("{{Type {sensor}}}");
        let line = self.lines.iter().rfind(|line| line.starts_with("SEN") && line.contains(&head));
        line.unwrap_or_else(|| panic!("no {sensor}"))
    }

    fn has(&self, start: &str) -> bool {
        self.lines.iter().any(|line| line.starts_with(start))
    }
}

fn position(line: &str) -> Option<[f64; 3]> {
    let numbers =
        Line::parse(line).get("Location")?.split(',').map(|n| n.parse().ok()).collect::<Option<Vec<f64>>>()?;
    numbers.try_into().ok()
}

fn distance(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Returns the number of consecutive sonars in a line, from F1 on.
fn grouped_sonars(line: &str) -> usize {
    let names = |number: &usize| line.contains(&format!(" {{Name F{number} Range "));
    (1..).take_while(names).count()
}

/// Replays a recording on the default map.
fn replay(name: &str) -> Vec<Exchange> {
    let events = recordings().remove(name).unwrap_or_else(|| panic!("no recording of {name}"));
    let speed = if name.contains("youbot") { ENGINE_SPEED } else { SPEED };
    let server = Server::start("rough", &[], |config| config.real_time_factor = speed);
    let start = Instant::now();
    let mut peers: BTreeMap<u64, Peer> = BTreeMap::new();
    let mut exchanges: BTreeMap<u64, Exchange> = BTreeMap::new();
    for event in events {
        let at = start + Duration::from_secs_f64(event["t"].as_f64().expect("t") / speed);
        let connection = event["connection"].as_u64().expect("connection");
        for (id, peer) in &mut peers {
            exchanges.entry(*id).or_default().lines.extend(peer.lines_until(at));
        }
        let exchange = exchanges.entry(connection).or_default();
        if event["open"].as_bool() == Some(true) {
            peers.insert(connection, Peer::connect(server.address).expect("a connection"));
        } else if let (Some(bytes), Some(peer)) = (event["send"].as_str(), peers.get_mut(&connection)) {
            peer.send_bytes(bytes.as_bytes());
            if bytes.contains("{Speed 0}") {
                exchange.stopped_at = Some(exchange.lines.len());
            }
        } else if let Some(mut peer) = peers.remove(&connection) {
            // The server still answers earlier questions, then it closes.
            peer.finish();
            exchange.lines.extend(peer.lines_until(Instant::now() + Duration::from_secs(30)));
        }
    }
    // Recordings without a close: the last question is still answered.
    for (id, mut peer) in peers {
        let lines = peer.lines_until(Instant::now() + Duration::from_millis(500));
        exchanges.entry(id).or_default().lines.extend(lines);
    }
    server.stop().expect("the server ends well");
    let exchanges: Vec<Exchange> = exchanges.into_values().collect();
    for exchange in &exchanges {
        assert!(exchange.lines.first().is_some_and(|line| line.starts_with("NFO {Gametype BotDeathMatch}")), "{name}");
    }
    exchanges
}

#[track_caller]
fn assert_moves(name: &str, at_least: f64) -> Vec<Exchange> {
    let exchanges = replay(name);
    let travelled = exchanges.iter().map(Exchange::travelled).fold(0.0, f64::max);
    assert!(travelled > at_least, "{name}: travelled {travelled:.3} m");
    exchanges
}

/// Checks that half a second after Stop! the robot no longer moves.
#[track_caller]
fn assert_stops(exchange: &Exchange) {
    let stopped_at = exchange.stopped_at.expect("Stop! was sent");
    let after = Exchange { lines: exchange.lines[stopped_at..].to_vec(), stopped_at: None }.positions();
    assert!(after.len() > 10, "{} positions after Stop!", after.len());
    let drift = distance(&after[7], &after[after.len() - 1]);
    assert!(drift < 0.003, "moved {drift:.4} m after Stop!");
}

#[test]
#[ignore = "needs USARSIM_CAPTURES"]
fn iridium_drives_the_p3at_and_stops_it() {
    let exchanges = assert_moves("iridium", 0.5);
    assert_stops(&exchanges[0]);
    for start in ["NFO {StartPoses 3} {PlayerStart_0 ", "GEO {Type GroundVehicle} {Name P3AT}", "CONF {Name P3AT}"] {
        assert!(exchanges[0].has(start), "{start}");
    }
}

#[test]
#[ignore = "needs USARSIM_CAPTURES"]
fn iridium_drives_the_youbot_by_the_thesis_command_and_stops_it() {
    let exchanges = assert_moves("iridium-youbot-raw", 0.1);
    assert_stops(&exchanges[0]);
    assert!(exchanges[0].has("CONF {Name KUKA_YouBot} {Type GroundVehicle} {SteeringType OmniDrive}"));
}

#[test]
#[ignore = "needs USARSIM_CAPTURES"]
fn iridium_drives_the_youbot_from_its_aerial_panel_and_stops_it() {
    let exchanges = assert_moves("iridium-youbot-aerial", 0.1);
    assert_stops(&exchanges[0]);
    let positions = exchanges[0].positions();
    let (first, last) = (positions[0], positions[positions.len() - 1]);
    assert!(last[0] > first[0] && last[1] > first[1], "forward and to the right: {first:?} to {last:?}");
}

#[test]
#[ignore = "needs USARSIM_CAPTURES"]
fn iridiumse_asks_on_one_connection_and_drives_on_another() {
    let exchanges = assert_moves("iridiumse", 0.5);
    assert!(exchanges[0].has("NFO {StartPoses 3}"));
    assert!(exchanges[1].has("CONF {Type GroundTruth} {Name GndTruth} {ScanInterval 0.1000}"));
}

#[test]
#[ignore = "needs USARSIM_CAPTURES"]
fn the_nist_ros_bridge_gets_the_class_of_its_robot_and_the_names_of_its_sensors() {
    let exchanges = assert_moves("usarsim_inf", 0.3);
    for start in [
        "NFO {StartPoses 3}",
        "CONF {Name P3AT} {Type GroundVehicle} {SteeringType SkidSteered}",
        "GEO {Type GroundVehicle} {Name P3AT}",
        "GEO {Type GroundTruth} {Name GndTruth}",
        "CONF {Type INS} {Name InsTest}",
        "GEO {Type INS} {Name InsTest}",
    ] {
        assert!(exchanges[0].has(start), "{start}");
    }
}

#[test]
#[ignore = "needs USARSIM_CAPTURES"]
fn usarsimcontroller_drives_the_p2at_with_spaces_in_its_vectors() {
    let exchanges = assert_moves("usarsimcontroller", 0.5);
    assert!(exchanges[0].has("CONF {Type GroundVehicle} {Name P2AT}"));
    // It splits lines between their blocks and reads by position.
    let parts = |line: &str| line.split("} {").map(str::to_owned).collect::<Vec<_>>();
    let sonar = parts(exchanges[0].reading("Sonar"));
    assert_eq!(sonar.len(), 2 + 16, "{sonar:?}");
    for (part, name) in sonar[2..].iter().zip(["F1", "F2", "F3", "F4", "F5", "F6", "F7", "F8", "R1"]) {
        let words: Vec<&str> = part.trim_end_matches('}').trim_start_matches("Name ").split(' ').collect();
        assert!(words[0] == name && words[2].parse::<f64>().is_ok(), "{part}");
    }
    let laser = parts(exchanges[0].reading("RangeScanner"));
    assert!(laser[2].starts_with("Name ") && laser[5].starts_with("Range "), "{laser:?}");
    let state = exchanges[0].lines.iter().find(|line| line.starts_with("STA")).expect("an STA");
    for key in ["LightIntensity", "Battery", "View"] {
        assert!(Line::parse(state).get(key).is_some_and(|value| value.parse::<i32>().is_ok()), "{state}");
    }
    let first = exchanges[0].positions()[0];
    assert!((first[0] - 1.5).abs() < 0.05 && (first[1] + 2.25).abs() < 0.05, "{first:?}");
}

#[test]
#[ignore = "needs USARSIM_CAPTURES"]
fn aut_toolbox_gets_ground_truth_without_a_gap() {
    assert_moves("aut-toolbox", 0.5);
}

#[test]
#[ignore = "needs USARSIM_CAPTURES"]
fn onomasticon_starts_at_its_start() {
    assert_moves("onomasticon", 0.5);
}

#[test]
#[ignore = "needs USARSIM_CAPTURES"]
fn ap2dx_drives_the_p2dx_by_percent() {
    // It was recorded until just after its DRIVE; the robot starts to move in the next half second.
    let exchanges = assert_moves("ap2dx", 0.1);
    assert_eq!(grouped_sonars(exchanges[0].reading("Sonar")), 8);
    for (sensor, key) in [("INS", "Location"), ("INS", "Orientation"), ("Odometry", "Pose"), ("RangeScanner", "Range")]
    {
        let line = exchanges[0].reading(sensor);
        let numbers =
            Line::parse(line).get(key).unwrap_or_default().split(',').map(str::parse::<f64>).collect::<Vec<_>>();
        assert!(numbers.len() >= 3 && numbers.iter().all(Result::is_ok), "{line}");
    }
}

#[test]
#[ignore = "needs USARSIM_CAPTURES"]
fn swe_thaf_drives_the_p2dx() {
    // It names one side only, so the robot swings about its other wheel.
    let exchanges = assert_moves("swe-thaf", 0.2);
    // It reads the type after the verb, and after the time if it expects one.
    assert_eq!(grouped_sonars(exchanges[0].reading("Sonar")), 8);
    let odometry = exchanges[0].reading("Odometry");
    let pose = odometry.strip_prefix("SEN {Type Odometry} {Name Odometry} {Pose ").expect(odometry);
    let theta = pose.trim_end_matches('}').split(',').nth(2).and_then(|theta| theta.parse::<f64>().ok());
    assert!(theta.is_some_and(|theta| theta.abs() <= 3.15), "{odometry}");
    let scan = exchanges[0].reading("RangeScanner");
    assert_eq!(Line::parse(scan).get("Range").map(|ranges| ranges.split(',').count()), Some(181), "{scan}");
}

#[test]
#[ignore = "needs USARSIM_CAPTURES"]
fn swe_thaf_avoid_drives_the_p2dx() {
    assert_moves("swe-thaf-avoid", 0.3);
}

/// Its robot, an arm on a platform, is not simulated yet. Its stream must do no harm.
#[test]
#[ignore = "needs USARSIM_CAPTURES"]
fn slider_is_served_without_its_robot() {
    replay("slider");
}
