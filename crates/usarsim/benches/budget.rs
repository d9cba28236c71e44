//! Cost of a server, measured on the program itself: `cargo bench -p usarsim --bench budget` (Linux).
//!
//! Each row starts a server of its own on a free port and reads its processor time and memory from /proc.

use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use gamebots_client::Client;
use system_tests::Usage;

/// Seconds of each measurement.
const SECONDS: f64 = 10.0;
/// Clock ticks per second in /proc/PID/stat; fixed on Linux.
const TICKS: f64 = 100.0;

/// A row: its group, its label, its measurement, and the target.
pub(crate) type Row = (&'static str, &'static str, fn() -> String, &'static str);

/// All rows, in the order of their tables.
pub(crate) const ROWS: [Row; 15] = [
    ("start", "start to ready, median of 5", start, "under 1000 ms"),
    (
        "drive",
        "one youBot driving on `rough`",
        || drive("rough", "KUKA_YouBot", 1),
        "at most 80 % of a core, under 300 MB",
    ),
    ("drive", "10 P3ATs with laser driving in `arena`", || drive("arena", "P3AT", 10), "real time, under 300 MB"),
    ("listen", "64 listening clients beside a youBot", || listen(64), "no line lost, under 300 MB"),
    ("log", "ten youBots in `bodies` with a log", || log_ten("bodies"), "less than 5 %"),
    ("log", "ten youBots in `analytic` with a log", || log_ten("analytic"), "less than 5 %"),
    ("log", "log of one youBot in `bodies`", || log_one("bodies"), "under 200 MB"),
    ("log", "log of one youBot in `analytic`", || log_one("analytic"), "under 200 MB"),
    ("watch", "ten youBots in `bodies` seen by one viewer, by ten", || watch_ten("bodies"), "less than 5 % for one"),
    (
        "watch",
        "ten youBots in `analytic` seen by one viewer, by ten",
        || watch_ten("analytic"),
        "less than 5 % for one",
    ),
    ("watch", "state of ten youBots with lasers for one viewer", watch_in_real_time, "under 200 kB/s"),
    ("heap", "ten robots of four classes at one place", || heap(&FOUR, 10, 0.0), "no silence over 100 ms"),
    ("heap", "250 P3ATs at one place", || heap(&["P3AT"], 250, 0.0), "under 200 MB"),
    ("heap", "twenty P3ATs that fall on each other", || heap(&["P3AT"], 20, 0.6), "no silence over 200 ms"),
    ("heap", "ten robots of four classes that fall on each other", || heap(&FOUR, 10, 0.6), "no silence over 200 ms"),
];

/// Classes of a mixed heap; the first is rapier's multibody.
const FOUR: [&str; 4] = ["KUKA_YouBot", "YouBot", "P3AT", "Kenaf"];

fn main() {
    // `cargo test --benches` only checks that it runs.
    if !std::env::args().any(|argument| argument == "--bench") {
        return;
    }
    // `-- watch` measures the rows about viewers alone.
    let wanted: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with('-')).collect();
    println!("| measured | got | wanted |");
    println!("|---|---|---|");
    for (group, what, measure, bar) in ROWS {
        if wanted.is_empty() || wanted.iter().any(|wanted| wanted == group) {
            println!("| {what} | {} | {bar} |", measure());
        }
    }
}

fn start() -> String {
    let mut starts: Vec<f64> = (0..5).map(|_| Server::start("rough").started_in).collect();
    starts.sort_by(f64::total_cmp);
    format!("{:.0} ms", 1e3 * starts[2])
}

/// Measures ten youBots at full speed, with a log and without, in turns.
fn log_ten(model: &str) -> String {
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
    format!("real-time factor {with:.2}, {without:.2} without: {:+.1} %", 100.0 * (with / without - 1.0))
}

/// Measures ten youBots at full speed with no viewer, one and ten, in turns.
fn watch_ten(model: &str) -> String {
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
    format!("real-time factor {none:.2} unseen, {one:.2} ({:+.1} %), {ten:.2} ({:+.1} %)", change(one), change(ten))
}

/// Measures the bytes that one viewer of ten youBots with lasers receives.
fn watch_in_real_time() -> String {
    let server = Server::start_with("rough", &["--drive-model", "analytic"]);
    let viewer = server.watch();
    let factor = fastest(&server, 10);
    drop(server);
    let kilobytes = viewer.join().unwrap_or_default() as f64 / 1000.0 / (SECONDS + 0.5);
    format!("{kilobytes:.0} kB/s at real-time factor {factor:.2}")
}

/// Measures the size of the log of one youBot, and of the one for ROS 2 beside it. The scene at the start of a log does not grow.
fn log_one(model: &str) -> String {
    let folder = tempfile::tempdir().unwrap_or_else(|error| panic!("{error}"));
    let log = folder.path().join("one.mcap").display().to_string();
    let arguments = ["--rtf", "5", "--drive-model", model, "--log", &log, "--log-format", "ros2"];
    let megabytes = || {
        ["one.mcap", "one.ros2.mcap"].map(|file| {
            let bytes = std::fs::metadata(folder.path().join(file)).map_or(0, |data| data.len());
            bytes as f64 / 1e6
        })
    };
    drop(Server::start_with("rough", &arguments));
    let scene = megabytes();
    // A server does not replace an existing log.
    ["one.mcap", "one.ros2.mcap"].iter().for_each(|file| drop(std::fs::remove_file(folder.path().join(file))));
    let seconds = fastest(&Server::start_with("rough", &arguments), 1) * SECONDS;
    let whole = megabytes();
    let [own, ros2] = [0, 1].map(|file| (whole[file] - scene[file]) * 3600.0 / seconds);
    format!("{own:.0} MB an hour beside its scene of {:.1} MB, and {ros2:.0} MB as ROS 2", scene[0])
}

/// Returns simulated seconds per second with a number of driving youBots.
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

/// Returns simulated seconds per second by the times of lines.
fn factor(lines: &[(Instant, String)]) -> f64 {
    let timed: Vec<(Instant, f64)> = lines.iter().filter_map(|(at, line)| Some((*at, time_of(line)?))).collect();
    let ends = timed.last().zip(timed.first());
    ends.map_or(0.0, |(last, first)| (last.1 - first.1) / last.0.duration_since(first.0).as_secs_f64())
}

/// Measures the server's processor share and its pace while robots drive in real time.
fn drive(map: &str, class: &str, count: usize) -> String {
    let server = Server::start(map);
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
    let (percent, megabytes) = (100.0 * share, server.peak_megabytes());
    format!("real-time factor {factor:.3}, {percent:.0} % of a core, {scans} scans, {megabytes:.0} MB")
}

/// Measures the lines that a client with a robot loses while other clients only listen.
fn listen(count: usize) -> String {
    let server = Server::start("rough");
    let _idle: Vec<Client> = (0..count).map(|_| server.connect()).collect();
    let mut client = server.connect();
    send(&mut client, "INIT {ClassName USARBot.KUKA_YouBot} {Location 0,0,0}");
    let lines = read(client, SECONDS);
    let truths: Vec<f64> = lines
        .iter()
        .filter(|(_, line)| line.contains("{Type GroundTruth}"))
        .filter_map(|(_, line)| time_of(line))
        .collect();
    let gaps = truths.windows(2).filter(|pair| (pair[1] - pair[0] - 0.1).abs() > 1e-3).count();
    let (seen, megabytes) = (truths.len(), server.peak_megabytes());
    format!("{seen} ground truths in {SECONDS} s, {gaps} gaps, {megabytes:.0} MB")
}

/// Measures the longest silence for a bystander 30 m away while another client spawns robots at one place or above each other, in one
/// segment. A robot alone is heard every 100 ms or sooner.
fn heap(classes: &[&str], count: usize, spacing: f64) -> String {
    let server = Server::start("rough");
    let mut bystander = server.connect();
    send(&mut bystander, "INIT {ClassName USARBot.P3AT} {Location 30,0,0}");
    let mut other = server.connect();
    let line = |(number, class): (usize, &&str)| {
        let height = 1.0 + spacing * number as f64;
        format!("INIT {{ClassName USARBot.{class}}} {{Location 0,0,-{height}}}")
    };
    let lines: Vec<String> = classes.iter().cycle().take(count).enumerate().map(line).collect();
    send(&mut other, &lines.join("\r\n"));
    let other = std::thread::spawn(move || drop(read(other, SECONDS)));
    let lines = read(bystander, SECONDS);
    let silence = lines.windows(2).map(|pair| pair[1].0.duration_since(pair[0].0).as_secs_f64()).fold(0.0, f64::max);
    let (factor, busy, megabytes) = (factor(&lines), server.processor_seconds(), server.peak_megabytes());
    drop(other.join());
    format!(
        "longest silence {:.0} ms, real-time factor {factor:.2}, {busy:.1} s of processor time, {megabytes:.0} MB",
        1e3 * silence
    )
}

/// Returns every line with its time of arrival.
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

    /// Starts a viewer that reads until the server ends. It returns the number of bytes.
    fn watch(&self) -> JoinHandle<usize> {
        let url = format!("ws://127.0.0.1:{}/live", self.http);
        let (mut socket, _) = tungstenite::connect(url).unwrap_or_else(|error| panic!("cannot watch: {error}"));
        std::thread::spawn(move || std::iter::from_fn(|| socket.read().ok()).map(|message| message.len()).sum())
    }

    /// Returns user and system time of the process, fields 14 and 15 of /proc/PID/stat.
    fn processor_seconds(&self) -> f64 {
        let stat = std::fs::read_to_string(format!("/proc/{}/stat", self.child.id())).unwrap_or_default();
        let after_name = stat.rsplit(')').next().unwrap_or_default();
        let fields = after_name.split_whitespace().skip(11).take(2);
        fields.filter_map(|field| field.parse::<f64>().ok()).sum::<f64>() / TICKS
    }

    /// Returns the largest resident memory so far.
    fn peak_megabytes(&self) -> f64 {
        Usage::of(&self.child.id().to_string()).peak as f64 / f64::from(1 << 20)
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        // SIGTERM lets it complete its logs. The shell's own kill is used, as not every machine has a program of that name.
        let asked = Command::new("sh").args(["-c", &format!("kill -TERM {}", self.child.id())]).status();
        if !asked.is_ok_and(|asked| asked.success()) {
            let _ = self.child.kill();
        }
        let _ = self.child.wait();
    }
}
