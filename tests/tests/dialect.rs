//! The dialect of UT2004, compared with the lines of a genuine server of 2011.
//!
//! Its lines are not part of this repository: `USARSIM_CAPTURES` names the folder of `usarsim-2011-server.txt`, and `--ignored` runs the
//! tests that need it.

use std::collections::{BTreeMap, BTreeSet};

use gamebots_proto::message::{self, Message};
use gamebots_proto::{Dialect, Line};
use regex::Regex;
use system_tests::{Server, server_lines};

/// Types of sensors that this server does not have.
const UNKNOWN: [&str; 3] = ["GPS", "RFID", "VictSensor"];

/// Returns the verb and the type of a line.
fn kind(line: &str) -> (String, String) {
    let parsed = Line::parse(line);
    (parsed.verb.clone(), parsed.get("Type").unwrap_or_default().to_owned())
}

/// Returns the shape of a line: keys, order, nesting and decimals. Names, words and digits are removed, and lists of the same shape become
/// equal.
fn shape(line: &str) -> String {
    let mut shape = line.to_owned();
    for (expression, by) in
        [(r"\{(Name|Level) [^ }]+", "{$1 n"), (r"(Mount|LightToggle) [^ }]+", "$1 w"), (r"-?\d+\.(\d+)", "<$1>")]
    {
        let expression = Regex::new(expression).expect("an expression");
        shape = expression.replace_all(&shape, by).into_owned();
    }
    let decimals = |found: &regex::Captures| format!("f{}", found[1].len());
    shape = Regex::new(r"<(\d+)>").expect("an expression").replace_all(&shape, decimals).into_owned();
    shape = Regex::new(r" -?\d+").expect("an expression").replace_all(&shape, " i").into_owned();
    // Lists, and sequences of items of one type, may differ in length.
    for (expression, by) in [(r"(?:f4,){9,}f4", "f4.."), (r"(?:( \{Name n [A-Z][a-z]+ [a-z0-9]+\}))+", "$1..")] {
        shape = Regex::new(expression).expect("an expression").replace_all(&shape, by).into_owned();
    }
    shape
}

/// Returns the numbers of a line.
fn numbers(line: &str) -> Vec<f64> {
    let number = Regex::new(r"-?\d+(\.\d+)?").expect("an expression");
    number.find_iter(line).map(|number| number.as_str().parse().expect("a number")).collect()
}

/// Every line that is read is written back with equal content. The last decimal may differ: it was truncated once, and is again.
#[test]
#[ignore = "needs USARSIM_CAPTURES"]
fn every_line_of_the_genuine_server_is_read_and_written_back() {
    let genuine = server_lines();
    let mut compared = BTreeMap::new();
    for line in genuine.iter().filter(|line| !UNKNOWN.contains(&kind(line).1.as_str())) {
        let messages = Message::read_all(line);
        assert!(!messages.is_empty(), "not read: {line}");
        let written = message::lines(&messages, Dialect::Ut2004);
        assert_eq!(written.len(), 1, "{line}");
        let written = &written[0].line;
        assert_eq!(shape(written), shape(line));
        let differs = |(a, b): (&f64, &f64)| (a - b).abs() > 1.01e-4;
        let (own, genuine) = (numbers(written), numbers(line));
        assert!(own.len() == genuine.len() && !own.iter().zip(&genuine).any(differs), "{written}\n{line}");
        *compared.entry(kind(line)).or_insert(0) += 1;
    }
    println!("{compared:?}");
    assert_eq!(compared.len(), 9, "kinds of lines: {compared:?}");
}

/// For each kind of line that both have, keys, order, nesting and decimals are the same.
#[test]
#[ignore = "needs USARSIM_CAPTURES"]
fn the_p2dx_sends_lines_of_the_shapes_that_the_genuine_server_sent() {
    let genuine = server_lines();
    let mut shapes: BTreeMap<(String, String), BTreeSet<String>> = BTreeMap::new();
    for line in &genuine {
        shapes.entry(kind(line)).or_default().insert(shape(line));
    }
    let server = Server::start("rough", &[], |config| config.real_time_factor = 5.0);
    let mut peer = server.client();
    peer.send("INIT {ClassName USARBot.P2DX} {Location 4.5,1.9,1.8} {Name R1}");
    peer.send("DRIVE {Left 1.0} {Right -1.0}");
    let mut compared = BTreeSet::new();
    for line in peer.lines_for(2.0) {
        let kind = kind(&line);
        if let Some(shapes) = shapes.get(&kind) {
            let own = shape(&line);
            assert!(shapes.contains(&own), "{line}\n   its shape: {own}\n   genuine: {shapes:?}");
            compared.insert(kind.1);
        }
    }
    let expected = ["Encoder", "GroundTruth", "GroundVehicle", "INS", "Odometry", "RangeScanner", "Sonar"];
    assert_eq!(compared, expected.map(str::to_owned).into());
}

/// 0.01745 rad a tick, with half a percent of noise.
#[test]
fn encoders_of_a_camera_count_its_pan_and_tilt_and_none_count_nothing() {
    for (class, expected) in [("P2AT", [14.3, 28.6]), ("P2DX", [0.0; 2])] {
        let server = Server::start("smooth", &[], |config| config.real_time_factor = 5.0);
        let mut peer = server.client();
        peer.send(&format!("INIT {{ClassName USARBot.{class}}} {{Location 0,0,0}} {{Name R1}}"));
        peer.send("MISPKG {Name CameraPanTilt} {Link 1} {Value 0.5} {Link 2} {Value 0.25}");
        let mut last = String::new();
        // The camera turns for a second. Whoever has none reports zeros at once.
        let fits = (0..2000).any(|_| {
            let line = peer.line_or_end().expect("a line");
            let Some((_, camera)) = line.split_once("{Name ECTilt Tick ") else { return false };
            let ticks: Vec<f64> = camera.split(['}', ' ']).filter_map(|word| word.parse().ok()).collect();
            last.clone_from(&line);
            ticks.len() == 2 && ticks.iter().zip(expected).all(|(tick, expected)| (tick - expected).abs() <= 1.0)
        });
        assert!(fits, "{class}: {last}");
    }
}

#[test]
fn shapes_keep_keys_order_nesting_and_decimals() {
    for (line, expected) in [
        (
            "SEN {Time 1.2500} {Type Sonar} {Name F1 Range 2.5000} {Name F2 Range 3.0000}",
            "SEN {Time f4} {Type Sonar} {Name n Range f4}..",
        ),
        ("SEN {Time 1.25} {Type Sonar} {Name F1} {Range 2.5000}", "SEN {Time f2} {Type Sonar} {Name n} {Range f4}"),
        ("SEN {Type INS} {Name INS} {Location 4.50,-1.90,1.80}", "SEN {Type INS} {Name n} {Location f2,f2,f2}"),
        ("SEN {Type Encoder} {Name ECLeft Tick -4} {Name A Tick 0}", "SEN {Type Encoder} {Name n Tick i}.."),
        ("STA {Battery 1200} {View -1}", "STA {Battery i} {View i}"),
    ] {
        assert_eq!(shape(line), expected);
    }
}
