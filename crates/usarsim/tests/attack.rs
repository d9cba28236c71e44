//! Dozens of hostile clients against the program, beside an honest one that they must not disturb. `make attack` runs it at length.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use system_tests::sessions::{Tally, hostile, play_until, rude, streams};
use system_tests::{Honest, Program, Watch, recordings};

/// Hostile clients at once.
const HOSTILE: u64 = 64;
/// Seconds of the attack, unless `USARSIM_ATTACK_SECONDS` is set.
const SECONDS: u64 = 10;
/// Largest memory of the server, bytes.
const MAX_MEMORY: u64 = 300_000_000;
/// Largest latency of 99 in 100 answers in a long attack.
const MAX_LATENCY: Duration = Duration::from_millis(50);
/// Pause between an answer and the next question.
const PAUSE: Duration = Duration::from_millis(5);

#[test]
#[ignore = "needs USARSIM_CAPTURES"]
fn captured_clients_that_are_damaged_do_not_disturb_an_honest_one() {
    let streams = streams(&recordings());
    let seconds = std::env::var("USARSIM_ATTACK_SECONDS").ok().map(|text| text.parse::<u64>().expect("seconds"));
    // There are more connections than clients, as a client that left is counted until the server notices.
    // A battery would be empty after 20 minutes.
    let arguments = ["--max-connections", "80", "--set", "P3AT.battery.life=1e6"];
    let mut server = Program::serve(env!("CARGO_BIN_EXE_usarsim"), &arguments);
    let watch = Watch::start(server.page);
    let mut honest = Honest::join(server.address);
    let answers = honest.answers();
    honest.ask_until(Instant::now() + Duration::from_secs(1), PAUSE, &answers);
    let alone = honest.latency();
    honest.latencies.clear();

    let end = Instant::now() + Duration::from_secs(seconds.unwrap_or(SECONDS));
    let tally = Arc::new(Tally::default());
    let attack = {
        let (address, tally) = (server.address, tally.clone());
        let make = move |random: &mut _, number: u64| hostile(random, &streams[number as usize % streams.len()]);
        std::thread::spawn(move || play_until(|| Instant::now() >= end, address, HOSTILE, 1, &tally, make))
    };
    honest.ask_until(end, PAUSE, &answers);
    attack.join().expect("the attack");
    let (memory, beside) = (server.usage().peak, honest.latency());
    let robots = watch.seen().most_robots;
    // All robots and clients of the attack are gone, and the world goes on.
    watch.wait_for("one robot and one client", |seen| seen.robots() == 1 && seen.clients() == 1);
    honest.ask_until(Instant::now() + Duration::from_secs(1), PAUSE, &answers);
    assert_eq!(server.stop().code(), Some(0));

    let [sessions, refused, bytes] =
        [&tally.sessions, &tally.refused, &tally.bytes].map(|count| count.load(Ordering::Relaxed));
    let milliseconds = |times: [Duration; 3]| times.map(|time| format!("{:.1}", 1e3 * time.as_secs_f64())).join(", ");
    println!("{sessions} hostile sessions, {refused} refused, {:.1} MB sent by them", bytes as f64 / 1e6);
    println!(
        "honest client: {} answers, {} readings, {} gaps",
        honest.latencies.len(),
        honest.readings,
        honest.gaps.len()
    );
    println!(
        "an answer takes (p50, p99, max) {} ms alone, {} ms beside them",
        milliseconds(alone),
        milliseconds(beside)
    );
    println!("peak memory of the server {:.1} MB, at most {robots} robots", memory as f64 / 1e6);
    assert_eq!(honest.gaps, Vec::<String>::new());
    assert!(sessions > 10 * HOSTILE, "{sessions} sessions only");
    assert!(memory < MAX_MEMORY, "{memory} bytes");
    assert!(seconds.is_none() || beside[1] < MAX_LATENCY, "{beside:?}");
}

/// Rude clients at once.
const RUDE: u64 = 6;

/// Rude clients drive through a map with objects, and through one with walls, ramps and rough ground.
#[test]
fn clients_that_mean_ill_to_robots_and_objects_do_not_end_the_server_or_make_absurd_numbers() {
    let seconds = std::env::var("USARSIM_ATTACK_SECONDS").ok().map(|text| text.parse::<u64>().expect("seconds"));
    for map in ["hall", "arena"] {
        let mut server = Program::serve(env!("CARGO_BIN_EXE_usarsim"), &["--map", map]);
        let watch = Watch::start_with_lines(server.page);
        let end = Instant::now() + Duration::from_secs(seconds.unwrap_or(SECONDS));
        let tally = Arc::new(Tally::default());
        play_until(|| Instant::now() >= end, server.address, RUDE, 2, &tally, |random, _| rude(random));
        // All clients are gone, and the world goes on.
        watch.wait_for("nobody", |seen| seen.robots() == 0 && seen.clients() == 0);
        let mut honest = Honest::join(server.address);
        let answers = honest.answers();
        honest.ask_until(Instant::now() + Duration::from_secs(1), PAUSE, &answers);
        let (seen, memory) = (watch.seen(), server.usage().peak);
        let sessions = tally.sessions.load(Ordering::Relaxed);
        println!(
            "{map}: {sessions} rude sessions, {} lines looked at, at most {} robots, peak memory {:.1} MB",
            seen.lines,
            seen.most_robots,
            memory as f64 / 1e6
        );
        assert_eq!(seen.absurd, [""; 0], "{map}");
        assert!(sessions > RUDE && seen.lines > 100, "{map}: {sessions} sessions, {} lines", seen.lines);
        assert!(memory < MAX_MEMORY, "{map}: {memory} bytes");
        drop((honest, watch));
        assert_eq!(server.stop().code(), Some(0), "{map}");
    }
}
