//! Sessions as data: the bytes that a client sends, if it reads, and how it leaves. They are made from a seed, so the same bytes can be
//! sent again.

use std::collections::BTreeMap;
use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::Value;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::net::tcp::{OwnedReadHalf, OwnedWriteHalf};
use tokio::task::JoinSet;
use tokio::time::{sleep, timeout};

/// Longest pause that is kept from a recording.
const MAX_PAUSE: Duration = Duration::from_millis(300);
/// Time after which sending is aborted if the server does not take the bytes. The client then leaves as its end says.
const MAX_SENDING: Duration = Duration::from_secs(4);
/// Time for which a client that closed its sending side still listens.
const HALF_CLOSED: Duration = Duration::from_millis(200);

/// The actions of one client.
#[derive(Debug, Clone)]
pub struct Session {
    /// Segments that it sends.
    pub pieces: Vec<Piece>,
    /// True if it reads what the server sends.
    pub reads: bool,
    /// The way it leaves.
    pub end: End,
}

/// One segment of a session.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Piece {
    /// Pause before it.
    pub pause: Duration,
    /// Bytes that are sent.
    pub bytes: Vec<u8>,
}

/// The way a client leaves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// Closes the connection.
    Close,
    /// Closes the sending side, and the connection later.
    HalfClose,
    /// Resets the connection.
    Reset,
    /// Neither sends nor reads for a time, and then closes.
    Stall(Duration),
}

/// Counters of a crowd of clients.
#[derive(Debug, Default)]
pub struct Tally {
    /// Sessions played.
    pub sessions: AtomicU64,
    /// Connections refused.
    pub refused: AtomicU64,
    /// Bytes taken by the server's machine.
    pub bytes: AtomicU64,
}

impl Piece {
    /// Creates a segment without a pause before it.
    pub fn now(bytes: impl Into<Vec<u8>>) -> Self {
        Self { pause: Duration::ZERO, bytes: bytes.into() }
    }

    /// Creates a segment after a pause.
    pub fn after(milliseconds: u64, bytes: impl Into<Vec<u8>>) -> Self {
        Self { pause: Duration::from_millis(milliseconds), bytes: bytes.into() }
    }
}

/// Returns the segments that each connection of the recordings sent, with their pauses.
pub fn streams(recordings: &BTreeMap<String, Vec<Value>>) -> Vec<Vec<Piece>> {
    let mut streams = Vec::new();
    for events in recordings.values() {
        let mut connections: BTreeMap<u64, (f64, Vec<Piece>)> = BTreeMap::new();
        for event in events {
            let (Some(time), Some(id)) = (event["t"].as_f64(), event["connection"].as_u64()) else { continue };
            let (last, pieces) = connections.entry(id).or_insert((time, Vec::new()));
            if let Some(text) = event["send"].as_str() {
                let pause = Duration::from_secs_f64((time - *last).max(0.0)).min(MAX_PAUSE);
                pieces.push(Piece { pause, bytes: text.as_bytes().to_vec() });
                *last = time;
            }
        }
        streams.extend(connections.into_values().map(|(_, pieces)| pieces));
    }
    streams
}

/// Makes a hostile session: a damaged recorded stream, or one of the kinds of abuse below.
pub fn hostile(random: &mut ChaCha8Rng, stream: &[Piece]) -> Session {
    let end = match random.random_range(0..4) {
        0 => End::Close,
        1 => End::HalfClose,
        2 => End::Reset,
        _ => End::Stall(Duration::from_millis(random.random_range(100..2000))),
    };
    let (pieces, reads) = match random.random_range(0..20) {
        0..13 => (damaged(random, stream), random.random_bool(0.8)),
        13..15 => (flood(random), true),
        15..17 => (flood(random), false),
        17 => (crowd(random), random.random_bool(0.5)),
        // Connects and leaves at once.
        _ => (Vec::new(), false),
    };
    Session { pieces, reads, end }
}

/// Damages a stream: its segments are split, joined, delayed, flipped, cut and repeated.
pub fn damaged(random: &mut ChaCha8Rng, stream: &[Piece]) -> Vec<Piece> {
    let mut pieces = stream.to_vec();
    for _ in 0..random.random_range(1..8) {
        if pieces.is_empty() {
            break;
        }
        let at = random.random_range(0..pieces.len());
        match random.random_range(0..7) {
            // Split.
            0 => {
                let bytes = &mut pieces[at].bytes;
                let tail = bytes.split_off(random.random_range(0..=bytes.len()));
                pieces.insert(at + 1, Piece::after(random.random_range(0..20), tail));
            }
            // Joined with the next.
            1 if at + 1 < pieces.len() => {
                let next = pieces.remove(at + 1);
                pieces[at].bytes.extend(next.bytes);
            }
            // All in one.
            2 => pieces = vec![Piece::now(pieces.iter().flat_map(|piece| piece.bytes.clone()).collect::<Vec<u8>>())],
            // Delayed, beyond the time after which an unfinished line counts as a line.
            3 => pieces[at].pause += Duration::from_millis(random.random_range(0..700)),
            // Bits flipped.
            4 => {
                for _ in 0..random.random_range(1..9) {
                    let bytes = &mut pieces[at].bytes;
                    if !bytes.is_empty() {
                        let byte = random.random_range(0..bytes.len());
                        bytes[byte] ^= 1 << random.random_range(0..8);
                    }
                }
            }
            // Cut, with the rest lost.
            5 => {
                let bytes = &mut pieces[at].bytes;
                bytes.truncate(random.random_range(0..=bytes.len()));
                pieces.truncate(at + 1);
            }
            // Repeated.
            _ => {
                let piece = Piece { pause: Duration::ZERO, ..pieces[at].clone() };
                let times = random.random_range(1..5);
                pieces.splice(at..at, std::iter::repeat_n(piece, times));
            }
        }
    }
    pieces
}

/// Makes a session that spawns a robot and then sends some megabytes of one line as fast as the server takes them.
fn flood(random: &mut ChaCha8Rng) -> Vec<Piece> {
    let unit = match random.random_range(0..6) {
        0 => "SET {Type RangeScanner} {Opcode SCAN}\r\n".repeat(400),
        1 => "A\r\n".repeat(5000),
        2 => "DRIVE {Left 1} {Right -1}\r\n".repeat(600),
        3 => format!("DRIVE {}\r\n", "{Left 1}".repeat(4096)),
        4 => "GETGEO {Type Sonar}\r\n".repeat(700),
        _ => format!("A{{{}{{\r\n", "}".repeat(60_000)),
    };
    let class = ["P3AT", "P2AT"][random.random_range(0..2)];
    let init = format!("INIT {{ClassName USARBot.{class}}} {}\r\n", place(random));
    let mut pieces = vec![Piece::now(init)];
    pieces.extend(vec![Piece::now(unit); 100]);
    pieces
}

/// Makes a session that spawns many robots at one place in one segment.
fn crowd(random: &mut ChaCha8Rng) -> Vec<Piece> {
    let class = ["P3AT", "KUKA_YouBot", "P2DX", "CasterSkidRobot"][random.random_range(0..4)];
    let init = format!("INIT {{ClassName USARBot.{class}}} {}\r\n", place(random));
    let count = random.random_range(2..6);
    vec![Piece::now(init.repeat(count)), Piece::after(random.random_range(0..200), "DRIVE {Left 2} {Right 3}\r\n")]
}

/// Classes that a rude client spawns.
const CLASSES: [&str; 9] =
    ["AirRobot", "P3AT", "Kenaf", "KUKA_YouBot", "YouBotArm", "P2DX", "FrontAckerman", "BasicSkidRobot", "YouBot"];
/// Numbers that no controller would send.
const NUMBERS: [&str; 12] = ["0", "1", "-1", "5", "-20", "100", "1e4", "-1e6", "1e9", "1e308", "NaN", "-inf"];

/// Makes a session of valid commands with bad intent. It spawns robots at one place, in solids and in the sky. It drives them by any
/// number, through crates and each other, and leaves at any moment.
pub fn rude(random: &mut ChaCha8Rng) -> Session {
    let mut pieces = Vec::new();
    for _ in 0..random.random_range(1..4) {
        let class = CLASSES[random.random_range(0..CLASSES.len())];
        let mut within = |most: f64| random.random_range(-most..most);
        let (x, y, turn) = (within(5.5), within(5.5), [within(3.1), within(3.1), within(3.1)]);
        let place = match random.random_range(0..6) {
            0 => "{Start PlayerStart_0}".to_owned(),
            1 => format!(
                "{{Location {x},{y},-{}}} {{Rotation {},{},{}}}",
                random.random_range(0..60),
                turn[0],
                turn[1],
                turn[2]
            ),
            2 => format!("{{Location {x},{y},{}}}", NUMBERS[random.random_range(0..NUMBERS.len())]),
            _ => format!("{{Location {x},{y},0}} {{Rotation 0,0,{}}}", turn[2]),
        };
        let count = if random.random_bool(0.2) { random.random_range(2..8) } else { 1 };
        pieces.push(Piece::now(format!("INIT {{ClassName USARBot.{class}}} {place}\r\n").repeat(count)));
        for _ in 0..random.random_range(1..8) {
            let mut number = || NUMBERS[random.random_range(0..NUMBERS.len())];
            let (one, other) = (number(), number());
            let line = match random.random_range(0..8) {
                0 | 1 => format!("DRIVE {{Left {one}}} {{Right {other}}}"),
                2 => "DRIVE {Left 20} {Right 20}".to_owned(),
                3 => format!("DRIVE {{LinearVelocity {one}}} {{LateralVelocity {other}}} {{AltitudeVelocity {one}}}"),
                4 => format!("DRIVE {{RotationalVelocity {one}}} {{PitchAngle {other}}} {{Normalized true}}"),
                5 => format!("ACT {{Name Arm}} {{Link 1}} {{Value {one}}} {{Link 2}} {{Value {other}}}"),
                6 => format!("MULTIDRIVE {{FLFlipper {one}}} {{FRFlipper {other}}} {{RLFlipper {one}}}"),
                _ => format!("DRIVE {{Speed {one}}} {{FrontSteer {other}}} {{RearSteer 0}}"),
            };
            pieces.push(Piece::after(random.random_range(0..400), format!("{line}\r\n")));
        }
    }
    let end = [End::Close, End::HalfClose, End::Reset][random.random_range(0..3)];
    Session { pieces, reads: random.random_bool(0.9), end }
}

/// Returns a random place within 3 m.
pub fn place(random: &mut ChaCha8Rng) -> String {
    let mut within = |most: f64| random.random_range(-most..most);
    let (x, y, yaw) = (within(3.0), within(3.0), within(3.1));
    format!("{{Location {x:.2},{y:.2},0}} {{Rotation 0,0,{yaw:.2}}}")
}

/// Interval at which players check if the play is over.
const OVER_INTERVAL: Duration = Duration::from_millis(10);

/// Lets clients play one session after the other until `is_over`. The n-th session of client i is made by `make` from that client's random
/// numbers and i + n.
///
/// All clients share one thread, so any number of them leaves the server a processor.
///
/// # Panics
/// If there is no runtime.
pub fn play_until(
    is_over: impl Fn() -> bool,
    address: SocketAddr,
    clients: u64,
    seed: u64,
    tally: &Arc<Tally>,
    make: impl Fn(&mut ChaCha8Rng, u64) -> Session + Send + Sync + 'static,
) {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
    let runtime = runtime.unwrap_or_else(|error| panic!("{error}"));
    let make = Arc::new(make);
    runtime.block_on(async {
        let mut tasks = JoinSet::new();
        for client in 0..clients {
            let (make, tally) = (make.clone(), tally.clone());
            tasks.spawn(async move {
                let mut random = ChaCha8Rng::seed_from_u64(seed);
                random.set_stream(client);
                for number in client.. {
                    play(make(&mut random, number), address, &tally).await;
                }
            });
        }
        while !is_over() {
            sleep(OVER_INTERVAL).await;
        }
    });
}

/// Plays one session to its end.
pub async fn play(session: Session, address: SocketAddr, tally: &Tally) {
    let Ok(stream) = TcpStream::connect(address).await else {
        tally.refused.fetch_add(1, Ordering::Relaxed);
        // Wait before the next connection, to spare the server.
        return sleep(Duration::from_millis(20)).await;
    };
    tally.sessions.fetch_add(1, Ordering::Relaxed);
    let (read, mut write) = stream.into_split();
    let mut reading = std::pin::pin!(take_all(read, session.reads));
    tokio::select! {
        () = &mut reading => return,
        _ = timeout(MAX_SENDING, send(&session.pieces, &mut write, tally)) => {}
    }
    match session.end {
        End::Close => {}
        End::HalfClose => {
            let _ = write.shutdown().await;
            let _ = timeout(HALF_CLOSED, reading).await;
        }
        End::Reset => {
            let _ = write.as_ref().set_zero_linger();
            // Dropping it would first close its side politely.
            write.forget();
        }
        End::Stall(time) => sleep(time).await,
    }
}

async fn send(pieces: &[Piece], write: &mut OwnedWriteHalf, tally: &Tally) {
    for Piece { pause, bytes } in pieces {
        sleep(*pause).await;
        let mut rest = &bytes[..];
        while !rest.is_empty() {
            let Ok(count) = write.write(rest).await else { return };
            tally.bytes.fetch_add(count as u64, Ordering::Relaxed);
            rest = &rest[count..];
        }
    }
}

/// Reads until the server closes the connection. If `reads` is false, reads nothing and never ends.
async fn take_all(mut read: OwnedReadHalf, reads: bool) {
    let mut buffer = vec![0; 16 * 1024];
    while reads && read.read(&mut buffer).await.is_ok_and(|count| count > 0) {}
    if !reads {
        std::future::pending().await
    }
}
