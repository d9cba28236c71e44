//! What a server costs, measured on the program itself: `cargo bench -p usarsim --bench budget` (Linux).
//!
//! Each row starts a server of its own on a free port and reads its processor time and memory from /proc.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use gamebots_client::Client;

/// Seconds of each measurement.
const SECONDS: f64 = 10.0;
/// Clock ticks a second in /proc/PID/stat; fixed on Linux.
const TICKS: f64 = 100.0;

fn main() {
    // `cargo test --benches` and the like only want to know that it runs.
    if !std::env::args().any(|argument| argument == "--bench") {
        return;
    }
    // `-- watch` measures the rows about viewers alone.
    let rows: &[(&str, fn())] = &[
        ("start", start),
        ("drive", || drive("one youBot driving", "KUKA_YouBot", 1, "at most 80 % of a core")),
        ("drive", || drive("10 P3ATs with laser driving", "P3AT", 10, "real time")),
        ("listen", || listen(64)),
        ("log", || log_ten("bodies")),
        ("log", || log_ten("analytic")),
        ("log", log_one),
        ("watch", || watch_ten("bodies")),
        ("watch", || watch_ten("analytic")),
        ("watch", watch_in_real_time),
    ];
    let wanted: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with('-')).collect();
    println!("| measured | got | wanted |");
    println!("|---|---|---|");
    for (_, measure) in rows.iter().filter(|(name, _)| wanted.is_empty() || wanted.iter().any(|wanted| wanted == name))
    {
        measure();
    }
}

fn start() {
    let mut starts: Vec<f64> = (0..5).map(|_| Server::start("rough").started_in).collect();
    starts.sort_by(f64::total_cmp);
    println!("| start to ready, median of 5 | {:.0} ms | under 1000 ms |", 1e3 * starts[2]);
}

/// Ten youBots as fast as possible, with a log and without, in turns.
fn log_ten(model: &str) {
    let folder = tempfile::tempdir().unwrap_or_else(|error| panic!("{error}"));
    let log = folder.path().join("ten.mcap").display().to_string();
    let arguments = ["--rtf", "0", "--drive-model", model];
    let [mut without, mut with] = [Vec::new(), Vec::new()];
    for _ in 0..3 {
        without.push(fastest(&Server::start_with("rough", &arguments), 10));
        with.push(fastest(&Server::start_with("rough", &[&arguments[..], &["--log", &log]].concat()), 10));
    }
    let [without, with] = [without, with].map(|mut factors: Vec<f64>| {
        factors.sort_by(f64::total_cmp);
        factors[1]
    });
    println!(
        "| ten youBots in {model} with a log | real-time factor {with:.2}, {without:.2} without: {:+.1} % | less than 5 % |",
        100.0 * (with / without - 1.0)
    );
}

/// Ten youBots as fast as possible with no viewer, one and ten, in turns.
fn watch_ten(model: &str) {
    let arguments = ["--rtf", "0", "--drive-model", model];
    let mut factors = [0, 1, 10].map(|viewers| (viewers, Vec::new()));
    for _ in 0..3 {
        for (viewers, factors) in &mut factors {
            let server = Server::start_with("rough", &arguments);
            let _watching: Vec<_> = (0..*viewers).map(|_| server.watch()).collect();
            factors.push(fastest(&server, 10));
        }
    }
    let [none, one, ten] = factors.map(|(_, mut factors)| {
        factors.sort_by(f64::total_cmp);
        factors[1]
    });
    let change = |factor: f64| 100.0 * (factor / none - 1.0);
    println!(
        "| ten youBots in {model} seen by one viewer, by ten | real-time factor {none:.2} unseen, {one:.2} ({:+.1} %), {ten:.2} ({:+.1} %) | less than 5 % for one |",
        change(one),
        change(ten),
    );
}

/// What one viewer of ten youBots with lasers is sent.
fn watch_in_real_time() {
    let server = Server::start_with("rough", &["--drive-model", "analytic"]);
    let viewer = server.watch();
    let factor = fastest(&server, 10);
    drop(server);
    let kilobytes = viewer.join().unwrap_or_default() as f64 / 1000.0 / (SECONDS + 0.5);
    println!(
        "| state of ten youBots with lasers for one viewer | {kilobytes:.0} kB/s at real-time factor {factor:.2} | under 200 kB/s |"
    );
}

/// How large the log of one youBot gets.
fn log_one() {
    let folder = tempfile::tempdir().unwrap_or_else(|error| panic!("{error}"));
    let log = folder.path().join("one.mcap");
    let factor = fastest(&Server::start_with("rough", &["--rtf", "20", "--log", &log.display().to_string()]), 1);
    let bytes = std::fs::metadata(&log).map_or(0, |data| data.len());
    let megabytes = bytes as f64 / (factor * SECONDS) * 3600.0 / 1e6;
    println!("| log of one youBot | {megabytes:.0} MB an hour | under 200 MB |");
}

/// Simulated seconds a second with so many youBots that drive.
fn fastest(server: &Server, count: usize) -> f64 {
    let readers: Vec<_> = (0..count)
        .map(|index| {
            let mut client = server.connect();
            send(&mut client, &format!("INIT {{ClassName USARBot.KUKA_YouBot}} {{Location 0,{},0}}", 2 * index));
            send(&mut client, "DRIVE {Front-Left 1} {Front-Right 1} {Back-Left 1} {Back-Right 1}");
            std::thread::spawn(move || read(client, SECONDS))
        })
        .collect();
    let lines: Vec<Vec<(Instant, String)>> = readers.into_iter().filter_map(|reader| reader.join().ok()).collect();
    factor(&lines[0])
}

/// Simulated seconds a second by the times of lines.
fn factor(lines: &[(Instant, String)]) -> f64 {
    let timed: Vec<(Instant, f64)> = lines.iter().filter_map(|(at, line)| Some((*at, time_of(line)?))).collect();
    let ends = timed.last().zip(timed.first());
    ends.map_or(0.0, |(last, first)| (last.1 - first.1) / last.0.duration_since(first.0).as_secs_f64())
}

/// Robots drive in real time in the arena; how busy is the server, and does it keep its pace?
fn drive(what: &str, class: &str, count: usize, wanted: &str) {
    let server = Server::start(if count == 1 { "rough" } else { "arena" });
    let mut clients: Vec<Client> = (0..count)
        .map(|index| {
            let mut client = server.connect();
            let (x, y) = (index as f64 % 5.0 - 2.0, (index / 5) as f64 - 1.0);
            send(&mut client, &format!("INIT {{ClassName USARBot.{class}}} {{Location {x},{y},0}}"));
            send(&mut client, "DRIVE {Left 1} {Right 0.8}");
            client
        })
        .collect();
    let (start, busy) = (Instant::now(), server.processor_seconds());
    let readers: Vec<_> = clients.drain(..).map(|client| std::thread::spawn(move || read(client, SECONDS))).collect();
    let lines: Vec<Vec<(Instant, String)>> = readers.into_iter().filter_map(|reader| reader.join().ok()).collect();
    let wall = start.elapsed().as_secs_f64();
    let share = (server.processor_seconds() - busy) / wall;
    let factor = factor(&lines[0]);
    let scans: usize = lines.iter().flatten().filter(|(_, line)| line.contains("{Type RangeScanner}")).count();
    println!(
        "| {what} | real-time factor {:.3}, {:.0} % of a core, {scans} scans, {:.0} MB | {wanted}, under 300 MB |",
        factor,
        100.0 * share,
        server.peak_megabytes(),
    );
}

/// Clients that only listen beside one that has a robot: does that one lose a line?
fn listen(count: usize) {
    let server = Server::start("rough");
    let idle: Vec<Client> = (0..count).map(|_| server.connect()).collect();
    let mut client = server.connect();
    send(&mut client, "INIT {ClassName USARBot.KUKA_YouBot} {Location 0,0,0}");
    let lines = read(client, SECONDS);
    let truths: Vec<f64> = lines
        .iter()
        .filter(|(_, line)| line.contains("{Type GroundTruth}"))
        .filter_map(|(_, line)| time_of(line))
        .collect();
    let gaps = truths.windows(2).filter(|pair| (pair[1] - pair[0] - 0.1).abs() > 1e-3).count();
    println!(
        "| {} listening clients beside a youBot | {} ground truths in {SECONDS} s, {gaps} gaps, {:.0} MB | no line lost, under 300 MB |",
        idle.len(),
        truths.len(),
        server.peak_megabytes(),
    );
}

/// Every line that comes, with the moment it came.
fn read(mut client: Client, seconds: f64) -> Vec<(Instant, String)> {
    let end = Instant::now() + Duration::from_secs_f64(seconds);
    let next = || client.next_line(end.saturating_duration_since(Instant::now())).ok().flatten();
    std::iter::from_fn(next).map(|line| (Instant::now(), line)).collect()
}

fn send(client: &mut Client, line: &str) {
    client.send(line).unwrap_or_else(|error| panic!("{line}: {error}"));
}

fn time_of(line: &str) -> Option<f64> {
    line.split_once("{Time ")?.1.split('}').next()?.parse().ok()
}

struct Server {
    child: Child,
    port: u16,
    http: u16,
    started_in: f64,
}

impl Server {
    fn start(map: &str) -> Self {
        Self::start_with(map, &[])
    }

    fn start_with(map: &str, arguments: &[&str]) -> Self {
        let start = Instant::now();
        let mut child = Command::new(env!("CARGO_BIN_EXE_usarsim"))
            .args(["--quiet", "serve", "--port", "0", "--http", "0", "--json", "--map", map])
            .args(arguments)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap_or_else(|error| panic!("usarsim does not start: {error}"));
        let mut line = String::new();
        let stdout = child.stdout.take().map(BufReader::new);
        stdout.map(|mut stdout| stdout.read_line(&mut line));
        let started_in = start.elapsed().as_secs_f64();
        let ready: serde_json::Value = serde_json::from_str(&line).unwrap_or_else(|error| panic!("{line}: {error}"));
        let port = ready["port"].as_u64().unwrap_or_default() as u16;
        let http = ready["http"].as_u64().unwrap_or_default() as u16;
        Self { child, port, http, started_in }
    }

    fn connect(&self) -> Client {
        Client::connect(("127.0.0.1", self.port)).unwrap_or_else(|error| panic!("cannot connect: {error}"))
    }

    /// A viewer that takes everything until the server ends; gives back how many bytes that was.
    fn watch(&self) -> JoinHandle<usize> {
        let url = format!("ws://127.0.0.1:{}/live", self.http);
        let (mut socket, _) = tungstenite::connect(url).unwrap_or_else(|error| panic!("cannot watch: {error}"));
        std::thread::spawn(move || std::iter::from_fn(|| socket.read().ok()).map(|message| message.len()).sum())
    }

    /// User and system time of the process, fields 14 and 15 of /proc/PID/stat.
    fn processor_seconds(&self) -> f64 {
        let stat = self.proc("stat");
        let after_name = stat.rsplit(')').next().unwrap_or_default();
        let fields = after_name.split_whitespace().skip(11).take(2);
        fields.filter_map(|field| field.parse::<f64>().ok()).sum::<f64>() / TICKS
    }

    /// Largest resident memory so far.
    fn peak_megabytes(&self) -> f64 {
        let status = self.proc("status");
        let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        line.and_then(|line| line.trim().split(' ').next()?.parse::<f64>().ok()).unwrap_or(f64::NAN) / 1024.0
    }

    fn proc(&self, file: &str) -> String {
        std::fs::read_to_string(format!("/proc/{}/{file}", self.child.id())).unwrap_or_default()
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
