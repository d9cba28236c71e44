//! Transcripts: the lines that clients send and the expected answers, as data.
//!
//! ```text
//! serve map=rough rtf=5 dialect=udk   # once, before the first case; all are optional
//! case 48 STA of the P3AT        # starts with no connections
//! a connect                      # and reads the greeting; `a connect ut2004` to be spoken to in that dialect
//! a connect truth                # to the port of truth, positions or wireless, which do not greet
//! a send GETCONF {Type Robot}    # ends with CR LF
//! a raw GETSTART                 # as it is; \r \n \t are escapes
//! a reply CONF {Name P3AT} ...   # the next line that is not on a timer matches
//! a nothing                      # what was sent before got no answer
//! a sees PATTERN                 # some line to come matches
//! a next Tachometer PATTERN      # the next reading of that type (or STA) matches
//! a after 0.5                    # simulated seconds pass
//! a count STA 1 9 11             # in 1 simulated second come 9 to 11 of them
//! a close
//! ```
//!
//! A pattern is literal, apart from `<f4>`, `<f3>`, `<f2>` (numbers with that many decimals), `<int>`, `<any>`, and `/regular expression/`
//! as a whole.

use std::collections::BTreeMap;
use std::path::Path;

use gamebots_proto::Dialect;
use gamebots_server::{Listener, Service};
use regex::Regex;

use crate::server::time_of;
use crate::{Peer, Server};

/// A transcript file.
pub struct Transcript {
    /// Path of the file.
    pub name: String,
    map: String,
    rtf: f64,
    dialect: Option<Dialect>,
    cases: Vec<Case>,
}

struct Case {
    title: String,
    steps: Vec<(usize, String)>,
}

impl Transcript {
    /// Reads a transcript.
    ///
    /// # Panics
    /// If it cannot be read.
    pub fn read(path: &Path) -> Self {
        let text = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let name = path.display().to_string();
        let mut transcript = Self { name, map: "rough".to_owned(), rtf: 5.0, dialect: None, cases: Vec::new() };
        for (index, line) in text.lines().enumerate().filter(|(_, line)| !line.is_empty() && !line.starts_with('#')) {
            match (line.split_once(' '), transcript.cases.last_mut()) {
                (Some(("serve", settings)), None) => transcript.set(settings),
                (Some(("case", title)), _) => {
                    transcript.cases.push(Case { title: title.to_owned(), steps: Vec::new() });
                }
                (_, Some(case)) => case.steps.push((index + 1, line.to_owned())),
                (_, None) => panic!("{}:{}: expected a case first", transcript.name, index + 1),
            }
        }
        transcript
    }

    /// Returns the numbers of the conformance cases in it.
    pub fn case_numbers(&self) -> Vec<u32> {
        let numbers = |case: &Case| -> Vec<u32> {
            let words = case.title.split_whitespace().map_while(|word| word.trim_end_matches(',').parse().ok());
            words.collect()
        };
        self.cases.iter().flat_map(numbers).collect()
    }

    fn set(&mut self, settings: &str) {
        for setting in settings.split_whitespace() {
            match setting.split_once('=') {
                Some(("map", map)) => self.map = map.to_owned(),
                Some(("rtf", rtf)) => self.rtf = rtf.parse().unwrap_or_else(|_| panic!("{setting}")),
                Some(("dialect", name)) => self.dialect = Some(name.parse().unwrap_or_else(|error| panic!("{error}"))),
                _ => panic!("{}: unknown setting {setting}", self.name),
            }
        }
    }
}

/// Runs every case of a transcript against one server.
///
/// # Panics
/// If a case fails. The message names file, line and case.
pub fn run_transcript(transcript: &Transcript, robots: &[&Path]) {
    let server = Server::start(&transcript.map, robots, |config| {
        config.real_time_factor = transcript.rtf;
        let controllers = Service::Controllers { dialect: transcript.dialect };
        config.listeners = [controllers, Service::Truth, Service::Positions, Service::Wireless]
            .map(|service| Listener::new(service, 0))
            .into();
    });
    for case in &transcript.cases {
        let mut peers = BTreeMap::new();
        for (line, step) in &case.steps {
            let place = format!("{}:{line}: case {}: {step}", transcript.name, case.title);
            run_step(&server, &mut peers, step, &place);
        }
    }
}

fn run_step(server: &Server, peers: &mut BTreeMap<String, Peer>, step: &str, place: &str) {
    let (name, rest) = step.split_once(' ').unwrap_or_else(|| panic!("{place}: expected a client and a step"));
    let (verb, rest) = rest.split_once(' ').unwrap_or((rest, ""));
    if verb == "connect" {
        let mut peer = match rest {
            "truth" => server.beside(server.truth),
            "positions" => server.beside(server.positions),
            "wireless" => server.beside(server.wireless),
            _ => server.client(),
        };
        peer.dialect = if rest == "ut2004" { Dialect::Ut2004 } else { Dialect::Udk };
        peers.insert(name.to_owned(), peer);
        return;
    }
    if verb == "close" {
        peers.remove(name);
        return;
    }
    let peer = peers.get_mut(name).unwrap_or_else(|| panic!("{place}: not connected"));
    let check = |line: &str, text: &str| assert!(pattern(text).is_match(line), "{place}\n   got: {line}");
    match verb {
        "send" => peer.send(rest),
        "raw" => peer.send_bytes(rest.replace("\\r", "\r").replace("\\n", "\n").replace("\\t", "\t").as_bytes()),
        "reply" => check(&peer.reply(), rest),
        "nothing" => peer.nothing(),
        "sees" => {
            let pattern = pattern(rest);
            peer.wait_for(place, |line| pattern.is_match(line));
        }
        "next" => {
            let (kind, text) = rest.split_once(' ').unwrap_or_else(|| panic!("{place}: expected a type and a pattern"));
            check(&peer.next_of(kind), text);
        }
        "after" => {
            let seconds = rest.parse().unwrap_or_else(|_| panic!("{place}: expected seconds"));
            peer.lines_for(seconds);
        }
        "count" => count(peer, rest, place),
        _ => panic!("{place}: unknown step `{verb}`"),
    }
}

fn count(peer: &mut Peer, arguments: &str, place: &str) {
    let words: Vec<&str> = arguments.split_whitespace().collect();
    let [kind, seconds, least, most] = words[..] else { panic!("{place}: expected TYPE SECONDS LEAST MOST") };
    let number = |text: &str| text.parse::<f64>().unwrap_or_else(|_| panic!("{place}: {text} is not a number"));
    let head = format!("{{Type {kind}}}");
    let fits = |line: &&String| line.starts_with(kind) || (line.starts_with("SEN ") && line.contains(&head));
    // The window starts at a status, a line with a known time.
    let start = time_of(&peer.next_of("STA"));
    assert!(start.is_some(), "{place}: a status without a time");
    let count = peer.lines_for(number(seconds)).iter().filter(fits).count() as f64;
    assert!((number(least)..=number(most)).contains(&count), "{place}\n   got: {count}");
}

/// Compiles a pattern for a whole line: literal with placeholders, or a regular expression between slashes.
fn pattern(text: &str) -> Regex {
    let expression = match text.strip_prefix('/').and_then(|text| text.strip_suffix('/')) {
        // Braces are literal, apart from counts such as {180}.
        Some(expression) => {
            let braces = Regex::new(r"\\.|\{\d+\}|[{}]").unwrap_or_else(|error| panic!("{error}"));
            let literal = |found: &regex::Captures| match &found[0] {
                brace @ ("{" | "}") => format!(r"\{brace}"),
                other => other.to_owned(),
            };
            braces.replace_all(expression, literal).into_owned()
        }
        None => {
            let mut expression = regex::escape(text);
            for (placeholder, meaning) in [
                ("<f4>", r"-?\d+\.\d{4}"),
                ("<f3>", r"-?\d+\.\d{3}"),
                ("<f2>", r"-?\d+\.\d{2}"),
                ("<int>", r"-?\d+"),
                ("<any>", ".*"),
            ] {
                expression = expression.replace(&regex::escape(placeholder), meaning);
            }
            format!("^{expression}$")
        }
    };
    Regex::new(&expression).unwrap_or_else(|error| panic!("{text}: {error}"))
}
