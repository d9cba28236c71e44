//! A client that other clients must not disturb: its sensors have no gaps, and its questions always get the same answers.

use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::time::{Duration, Instant};

use gamebots_client::Client;

use crate::server::{PATIENCE, time_of};

/// Messages of a P3AT that come at fixed intervals of simulated time, s.
const INTERVALS: [(&str, f64); 3] = [("STA ", 0.1), ("{Type GroundTruth}", 0.1), ("{Type RangeScanner}", 0.2)];
/// Tolerance of times, s. On the wire they have four decimals, after rounding to 24 bits.
const TIME_TOLERANCE: f64 = 0.00011;
const TIME_ROUNDING: f64 = f32::EPSILON as f64;
/// Most gaps that are kept.
const MAX_GAPS: usize = 20;

/// Questions of all kinds. Each has one answer that never changes.
const QUESTIONS: [&str; 10] = [
    "GETSTARTPOSES",
    "GETPATHNODES",
    "GETCLOSESTPATHNODE {Location 1,1,0}",
    "GETCONF {Type Robot}",
    "GETGEO {Type Robot}",
    "GETCONF {Type RangeScanner}",
    "GETGEO {Type RangeScanner}",
    "GETCONF {Type GroundTruth}",
    "GETGEO {Type GroundTruth}",
    "GETCONF {Type INS}",
];

/// A client with a P3AT that checks the times of its readings.
pub struct Honest {
    client: Client,
    last: BTreeMap<&'static str, f64>,
    /// Readings that came at a wrong time, up to a maximum.
    pub gaps: Vec<String>,
    /// Number of readings that were checked.
    pub readings: u64,
    /// Latency of each answer.
    pub latencies: Vec<Duration>,
}

impl Honest {
    /// Connects, spawns a robot at a place of its own and waits for the first readings.
    ///
    /// # Panics
    /// If the server does not serve it.
    pub fn join(address: SocketAddr) -> Self {
        let client = Client::connect(address).unwrap_or_else(|error| panic!("cannot connect: {error}"));
        let (last, gaps) = (BTreeMap::new(), Vec::new());
        let mut honest = Self { client, last, gaps, readings: 0, latencies: Vec::new() };
        let greeting = honest.reply();
        assert!(greeting.starts_with("NFO {Gametype "), "{greeting}");
        honest.send("INIT {ClassName USARBot.P3AT} {Name Honest} {Location 10,10,0}");
        while honest.last.len() < INTERVALS.len() {
            honest.listen(Duration::from_millis(50));
        }
        honest
    }

    /// Asks a question and returns its answer.
    ///
    /// # Panics
    /// If there is no answer.
    pub fn ask(&mut self, question: &str) -> String {
        let start = Instant::now();
        self.send(question);
        let reply = self.reply();
        self.latencies.push(start.elapsed());
        reply
    }

    /// Asks every question once.
    pub fn answers(&mut self) -> Vec<String> {
        QUESTIONS.iter().map(|question| self.ask(question)).collect()
    }

    /// Asks the questions in turn until a deadline, and listens in pauses between them.
    ///
    /// # Panics
    /// If an answer is not as expected.
    pub fn ask_until(&mut self, end: Instant, pause: Duration, expected: &[String]) {
        for (question, expected) in QUESTIONS.iter().zip(expected).cycle() {
            if Instant::now() >= end {
                break;
            }
            assert_eq!(&self.ask(question), expected, "{question}");
            self.listen(pause);
        }
    }

    /// Receives and checks lines for a time.
    pub fn listen(&mut self, time: Duration) {
        let end = Instant::now() + time;
        while let Some(line) = self.next_line(end.saturating_duration_since(Instant::now())) {
            assert!(self.note(&line), "nothing was asked, and yet: {line}");
        }
    }

    /// Returns the simulated time of the newest reading, s.
    pub fn time(&self) -> f64 {
        self.last.values().copied().fold(0.0, f64::max)
    }

    /// Returns the latencies at the 50th and 99th percentile, and the longest.
    pub fn latency(&self) -> [Duration; 3] {
        let mut sorted = self.latencies.clone();
        sorted.sort();
        [0.5, 0.99, 1.0].map(|part| sorted[((sorted.len() - 1) as f64 * part) as usize])
    }

    fn send(&mut self, line: &str) {
        self.client.send(line).unwrap_or_else(|error| panic!("sending {line}: {error}"));
    }

    fn next_line(&mut self, patience: Duration) -> Option<String> {
        self.client.next_line(patience).unwrap_or_else(|error| panic!("the server is gone: {error}"))
    }

    /// Returns the next line that is not on a timer.
    fn reply(&mut self) -> String {
        let end = Instant::now() + PATIENCE;
        loop {
            let line = self.next_line(end.saturating_duration_since(Instant::now()));
            let line = line.unwrap_or_else(|| panic!("no answer comes"));
            if !self.note(&line) {
                return line;
            }
        }
    }

    /// Checks the time of a line that is on a timer. Returns false for any other line.
    fn note(&mut self, line: &str) -> bool {
        if !["SEN ", "STA ", "ASTA ", "EFF "].iter().any(|kind| line.starts_with(kind)) {
            return false;
        }
        let timed = INTERVALS.into_iter().find(|(kind, _)| line.contains(kind)).zip(time_of(line));
        if let Some(((kind, interval), time)) = timed {
            self.readings += 1;
            if let Some(last) = self.last.insert(kind, time)
                && (time - last - interval).abs() > TIME_TOLERANCE + TIME_ROUNDING * time
                && self.gaps.len() < MAX_GAPS
            {
                self.gaps.push(format!("{kind} at {time} after {last}"));
            }
        }
        true
    }
}
