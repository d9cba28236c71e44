//! The program under clients that come, drive, collide and leave for a long time: its resources stay constant. `make soak` runs these tests
//! at full length.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use gamebots_client::Client;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use system_tests::sessions::{End, Piece, Session, Tally, place, play_until};
use system_tests::{Honest, PATIENCE, Program, Usage, Watch, alone, setting};

/// Simulated hours of the soak, unless `USARSIM_SOAK_HOURS` is set.
const HOURS: f64 = 0.1;
/// Span that is compared at the beginning and at the end of a long soak: simulated time, s.
const FIRST_WINDOW: f64 = 600.0;
/// Interval at which the server's resources are sampled.
const SAMPLE_INTERVAL: Duration = Duration::from_millis(50);
/// Pause between an answer and the next question.
const PAUSE: Duration = Duration::from_millis(5);
/// Connections that come and leave, unless `USARSIM_SOAK_LEAVINGS` is set.
const CONNECTIONS: u64 = 300;
/// Number of visitors at a time.
const VISITORS: u64 = 3;
/// A number of lines above those that the server keeps for the report of a panic: 16 MiB.
const MAX_JOURNAL_LINES: usize = 140_000;
/// A line as long as controllers' lines, without effect.
const IDLE_LINE: &str = "IDLE {Left 12.34} {Right 12.34}\r\n";

fn megabytes(bytes: u64) -> f64 {
    bytes as f64 / 1e6
}

#[track_caller]
fn check_same(what: &str, first: u64, last: u64, allowed: f64) {
    assert!(last as f64 <= 1.05 * first as f64 + allowed, "{what}: {first} at first, {last} at the end");
}

/// Fills the server's journal for the report of a panic, so that it does not count as growth.
fn fill_journal(server: &Program) {
    let mut client = Client::connect(server.address).expect("a connection");
    client.send_bytes(IDLE_LINE.repeat(MAX_JOURNAL_LINES).as_bytes()).expect("all is taken");
    client.send("GETSTARTPOSES").expect("a question");
    while !client.next_line(PATIENCE).expect("lines").expect("a line").starts_with("NFO {StartPoses") {}
}

/// Two robots at one place, the second on the first, leave one after the other.
#[test]
fn connections_that_leave_leave_nothing_behind() {
    let _alone = alone();
    let connections = setting("USARSIM_SOAK_LEAVINGS", CONNECTIONS);
    let mut server = Program::serve(env!("CARGO_BIN_EXE_usarsim"), &["--rtf", "50"]);
    fill_journal(&server);
    let watch = Watch::start(server.page);
    let (start, mut first) = (Instant::now(), 0);
    for pair in 0..connections / 2 {
        let class = ["P3AT", "P2DX", "KUKA_YouBot", "P3AT"][pair as usize % 4];
        let mut clients: Vec<Client> = (0..2)
            .map(|_| {
                let mut client = Client::connect(server.address).expect("a connection");
                client.send(&format!("INIT {{ClassName USARBot.{class}}} {{Start PlayerStart_0}}")).expect("INIT");
                client
            })
            .collect();
        for client in &mut clients {
            while !client.next_line(PATIENCE).expect("lines").expect("a line").contains("{Type GroundTruth}") {}
        }
        if pair % 2 == 1 {
            clients.reverse();
        }
        drop(clients);
        if pair == (connections / 6).min(500) {
            first = server.usage().resident;
        }
    }
    watch.wait_for("an empty world", |seen| seen.robots() == 0 && seen.clients() == 0);
    let last = server.usage().resident;
    println!(
        "{connections} connections in {:.1} s: {:.1} MB resident at first, {:.1} MB at the end",
        start.elapsed().as_secs_f64(),
        megabytes(first),
        megabytes(last)
    );
    assert_eq!(server.stop().code(), Some(0));
    check_same("resident memory", first, last, 2e6);
}

/// Makes a session that comes, drives for some seconds, asks questions, and leaves in one of the four ways.
fn visitor(random: &mut ChaCha8Rng, _number: u64) -> Session {
    let class = ["P3AT", "KUKA_YouBot", "KUKA_YouBot"][random.random_range(0..3)];
    let mut pieces = vec![Piece::now(format!("INIT {{ClassName USARBot.{class}}} {}\r\n", place(random)))];
    for _ in 0..random.random_range(1..10) {
        let (left, right) = (random.random_range(-8.0..8.0), random.random_range(-8.0..8.0));
        let question =
            ["GETCONF {Type Robot}", "GETGEO {Type GroundTruth}", "GETSTARTPOSES"][random.random_range(0..3)];
        let text = format!("DRIVE {{Left {left:.2}}} {{Right {right:.2}}}\r\n{question}\r\n");
        pieces.push(Piece::after(random.random_range(5..100), text));
    }
    let end = match random.random_range(0..4) {
        0 => End::Close,
        1 => End::HalfClose,
        2 => End::Reset,
        _ => End::Stall(Duration::from_millis(random.random_range(50..300))),
    };
    Session { pieces, reads: true, end }
}

/// Resources in a window of time: medians, so that a moment in which many clients leave does not count.
#[derive(Debug)]
struct Window {
    /// Resident memory, bytes.
    resident: u64,
    descriptors: u64,
    threads: u64,
    /// Bytes that wait to be sent to clients.
    waiting: u64,
}

impl Window {
    fn of(samples: &[(Usage, u64)]) -> Self {
        let median = |value: fn(&(Usage, u64)) -> u64| {
            let mut values: Vec<u64> = samples.iter().map(value).collect();
            values.sort_unstable();
            values[values.len() / 2]
        };
        Self {
            resident: median(|(usage, _)| usage.resident),
            descriptors: median(|(usage, _)| usage.descriptors),
            threads: median(|(usage, _)| usage.threads),
            waiting: median(|(_, waiting)| *waiting),
        }
    }
}

#[test]
fn a_server_that_is_visited_for_long_takes_no_more_of_the_machine() {
    let _alone = alone();
    let time = 3600.0 * setting("USARSIM_SOAK_HOURS", HOURS);
    let arguments = ["--map", "arena", "--rtf", "0", "--drive-model", "analytic", "--set", "P3AT.battery.life=1e9"];
    let mut server = Program::serve(env!("CARGO_BIN_EXE_usarsim"), &arguments);
    fill_journal(&server);
    let watch = Watch::start(server.page);
    let mut honest = Honest::join(server.address);
    let answers = honest.answers();
    let (start, tally, over) = (Instant::now(), Arc::new(Tally::default()), Arc::new(AtomicBool::new(false)));
    let visits = {
        let (address, tally, over) = (server.address, tally.clone(), over.clone());
        std::thread::spawn(move || play_until(|| over.load(Ordering::Relaxed), address, VISITORS, 1, &tally, visitor))
    };
    // The first window is for warming up. The next one is compared with the last.
    let mut windows = Vec::new();
    let (begin, window) = (honest.time(), FIRST_WINDOW.min(time / 10.0));
    for end in (1..).map(|number| f64::from(number) * window).take_while(|&end| end < time + window / 2.0) {
        let mut samples = Vec::new();
        while samples.is_empty() || honest.time() < begin + end {
            honest.ask_until(Instant::now() + SAMPLE_INTERVAL, PAUSE, &answers);
            samples.push((server.usage(), watch.seen().waiting_bytes));
        }
        windows.push(Window::of(&samples));
        if windows.len() % (time / window / 10.0).round() as usize == 0 {
            println!("{:.2} h, {:.0} s: {:?}", end / 3600.0, start.elapsed().as_secs_f64(), windows.last());
        }
    }
    over.store(true, Ordering::Relaxed);
    visits.join().expect("the visitors");
    let seen = watch.seen();
    println!(
        "{} visits, {} frames seen, {:.1} s simulated, {} readings, {} gaps, at most {} lines dropped",
        tally.sessions.load(Ordering::Relaxed),
        seen.frames,
        honest.time() - begin,
        honest.readings,
        honest.gaps.len(),
        seen.most_dropped,
    );
    watch.wait_for("one robot and one client", |seen| seen.robots() == 1 && seen.clients() == 1);
    drop(honest);
    watch.wait_for("an empty world", |seen| seen.robots() == 0 && seen.clients() == 0);
    assert_eq!(server.stop().code(), Some(0));
    let (first, last) = (&windows[1], &windows[windows.len() - 1]);
    check_same("resident memory", first.resident, last.resident, 2e6);
    check_same("file descriptors", first.descriptors, last.descriptors, 1.0);
    check_same("threads", first.threads, last.threads, 0.0);
    check_same("bytes on their way", first.waiting, last.waiting, 65536.0);
}
