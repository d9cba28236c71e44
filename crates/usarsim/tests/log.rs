//! `usarsim log` as a process, on the log of a run.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use experiments::plan::Plan;
use rand::{RngExt, SeedableRng};
use recorder::{Log, Record};

/// Twelve seconds of a youBot, half ahead and half to the left.
const FILE: &str = r#"
description = "ahead and to the left"
drive_models = ["analytic"]
[setup]
steps = 6
script = [{ at = 0, velocity = [0.1, 0.0, 0.0] }, { at = 6, velocity = [0.0, 0.1, 0.0] }]
"#;

struct Folder {
    folder: tempfile::TempDir,
    log: Log,
}

impl Folder {
    /// Creates a folder with `run.mcap`.
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let plan = Plan::read(Path::new("turn.toml"), FILE).unwrap_or_else(|error| panic!("{error}"));
        let file = folder.path().join("run.mcap");
        experiments::run::run(&plan, &plan.runs()[0], Some(&file)).unwrap_or_else(|error| panic!("{error}"));
        let log = recorder::read(&file).unwrap_or_else(|error| panic!("{error}"));
        Self { folder, log }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn run(&self, arguments: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_usarsim"));
        command.arg("log").args(arguments).current_dir(&self.folder).output().expect("usarsim runs")
    }

    /// Returns the output of a command that must succeed.
    fn text(&self, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).expect("text")
    }

    /// Returns the error text of a command that must fail with an exit code.
    fn refused(&self, code: i32, arguments: &[&str]) -> String {
        let output = self.run(arguments);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stderr).expect("text")
    }
}

#[test]
fn a_log_cut_at_any_byte_is_recovered_up_to_its_last_complete_second() {
    let folder = Folder::new();
    let bytes = std::fs::read(folder.path("run.mcap")).expect("the log");
    let summary = mcap::Summary::read(&bytes).expect("an index").expect("an index");
    let chunks = &summary.chunk_indexes;
    let seconds = |nanoseconds: u64| nanoseconds as f64 / 1e9;
    for chunk in chunks {
        let [first, last] = [chunk.message_start_time, chunk.message_end_time].map(|time| time / 1_000_000_000);
        assert_eq!(first, last, "each second ends a chunk");
    }
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(4);
    let start = chunks[0].chunk_start_offset as usize;
    for number in 0..10 {
        let cut = random.random_range(start..bytes.len());
        let (file, out) = (format!("cut{number}.mcap"), format!("cut{number}.recovered.mcap"));
        std::fs::write(folder.path(&file), &bytes[..cut]).expect("a file");
        let said = folder.text(&["recover", &file]);
        assert!(said.starts_with(&out), "{said}");
        let recovered = recorder::read(&folder.path(&out)).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(recovered.run, folder.log.run);
        assert_eq!(recovered.entries, folder.log.entries[..recovered.entries.len()], "cut at {cut}");
        // Chunks that end before the cut are recovered in full. Of the chunk with the cut, the readable part is.
        let whole = chunks.iter().filter(|chunk| chunk.chunk_start_offset + chunk.chunk_length <= cut as u64);
        let expected = whole.map(|chunk| seconds(chunk.message_end_time)).fold(0.0, f64::max);
        let last = recovered.entries.last().map_or(0.0, |entry| entry.time);
        assert!(last >= expected, "cut at {cut}: {last} of {expected}");
        // The copy is a complete file, and its states replay.
        let copy = std::fs::read(folder.path(&out)).expect("the copy");
        assert!(mcap::Summary::read(&copy).expect("an index").is_some());
        folder.text(&["replay", &out]);
        folder.refused(2, &["recover", &file]);
    }
    folder.refused(65, &["recover", "none.mcap"]);
    folder.refused(1, &["recover", "cut0.mcap", "--out", "/dev/null/x.mcap"]);
}

#[test]
fn a_table_has_every_state_with_its_bits() {
    let folder = Folder::new();
    let csv = folder.text(&["export", "run.mcap", "--csv"]);
    let mut lines = csv.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let names = lines.next().expect("names");
    let rows: Vec<BTreeMap<&str, f64>> = lines
        .map(|line| names.iter().copied().zip(line.iter().map(|number| number.parse().expect("a number"))).collect())
        .collect();
    let states: Vec<_> = folder
        .log
        .entries
        .iter()
        .filter_map(|entry| match &entry.record {
            Record::State(state) => Some((entry.time, state)),
            _ => None,
        })
        .collect();
    assert!(states.len() > 600 && rows.len() == states.len());
    for (row, (time, state)) in rows.iter().zip(&states) {
        let position = state.pose().translation;
        assert_eq!([row["time"], row["x"], row["y"]], [*time, position.x, position.y]);
        assert_eq!(row["wheel_speed_4"], state.joint_speeds[3]);
    }
    let last = &rows[rows.len() - 1];
    assert!(last["x"] - rows[0]["x"] > 0.55 && last["y"] - rows[0]["y"] < -0.5, "{last:?}");

    let tum = folder.text(&["export", "run.mcap", "--tum", "--robot", "0"]);
    let first: Vec<f64> =
        tum.lines().next().expect("a line").split(' ').map(|number| number.parse().unwrap()).collect();
    assert_eq!((first.len(), first[0], first[1]), (8, states[0].0, rows[0]["x"]));

    folder.text(&["export", "run.mcap", "--parquet", "--out", "states.parquet"]);
    assert!(std::fs::read(folder.path("states.parquet")).expect("a table").starts_with(b"PAR1"));
    folder.text(&["export", "run.mcap", "--ros2", "--out", "run.ros2.mcap"]);
    assert!(folder.refused(65, &["info", "run.ros2.mcap"]).contains("not a log of usarsim"));
    folder.refused(2, &["export", "run.mcap"]);
    folder.refused(2, &["export", "run.mcap", "--parquet"]);
    folder.refused(1, &["export", "run.mcap", "--csv", "--out", "/dev/null/x.csv"]);
    let said = folder.refused(2, &["export", "run.mcap", "--csv", "--robot", "Bob"]);
    assert!(said.contains("no robot `Bob`: it has 0 (KUKA_YouBot)"), "{said}");
}

#[test]
fn no_command_writes_over_the_log_that_it_reads() {
    let folder = Folder::new();
    std::fs::hard_link(folder.path("run.mcap"), folder.path("hard.png")).expect("a link");
    std::fs::copy(folder.path("run.mcap"), folder.path("run.svg")).expect("a copy");
    #[cfg(unix)]
    std::os::unix::fs::symlink("run.mcap", folder.path("soft.svg")).expect("a link");
    let bytes = |name: &str| std::fs::read(folder.path(name)).expect("a log");
    let before = bytes("run.mcap");
    let outs = [
        "run.mcap",
        "./run.mcap",
        "hard.png",
        #[cfg(unix)]
        "soft.svg",
    ];
    for command in
        [&["export", "--csv"][..], &["export", "--parquet"], &["export", "--tum"], &["export", "--ros2"], &["plot"]]
    {
        for out in outs {
            let said = folder.refused(2, &[command, &["run.mcap", "--out", out]].concat());
            let expected = format!("the output {out} is the input file run.mcap, which would be lost: choose another");
            assert!(said.contains(&expected), "{command:?}: {said}");
        }
    }
    folder.refused(2, &["recover", "run.mcap", "--out", "run.mcap"]);
    // By default the picture has the name of the log.
    let said = folder.refused(2, &["plot", "run.svg"]);
    assert!(said.contains("the output run.svg is the input file run.svg"), "{said}");
    for name in ["run.mcap", "hard.png", "run.svg"] {
        assert!(bytes(name) == before, "{name} has changed");
    }
}

#[test]
fn a_plot_is_the_path_or_fields_against_time() {
    let folder = Folder::new();
    assert_eq!(folder.text(&["plot", "run.mcap"]), "run.svg\n");
    let drawn = std::fs::read_to_string(folder.path("run.svg")).expect("a picture");
    assert!(drawn.contains("map rough, seen from above") && drawn.contains("KUKA_YouBot"));
    folder.text(&["plot", "run.mcap", "--field", "x,wheel_speed_1", "--out", "speeds.png"]);
    assert!(std::fs::read(folder.path("speeds.png")).expect("a picture").starts_with(b"\x89PNG"));
    let said = folder.refused(2, &["plot", "run.mcap", "--field", "speed"]);
    assert!(said.contains("no field `speed`: expected one of time, robot, x"), "{said}");
}

#[test]
fn lines_are_found_by_robot_type_and_time() {
    let folder = Folder::new();
    let lines = |arguments: &[&str]| folder.text(&[&["cat", "run.mcap"], arguments].concat()).lines().count();
    let all = lines(&[]);
    assert_eq!(all, lines(&["--robot", "0"]), "the connection's first lines belong to its robot");
    let readings = lines(&["--type", "GroundTruth", "--from", "1.05", "--to", "3.05"]);
    assert_eq!(readings, 20);
    assert_eq!(lines(&["--type", "init"]), 1);
    assert_eq!(lines(&["--connection", "2"]), 0);
}

#[test]
fn every_log_of_a_folder_is_replayed() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("more")).expect("a folder");
    std::fs::copy(folder.path("run.mcap"), folder.path("more/again.mcap")).expect("a copy");
    let said = folder.text(&["replay", "."]);
    assert_eq!(said.lines().filter(|line| line.contains("replayed with the same bits")).count(), 2, "{said}");
    std::fs::write(folder.path("more/bad.mcap"), "hello").expect("a file");
    assert!(folder.refused(65, &["replay", "."]).contains("1 of 3 logs not replayed"));
}

#[test]
fn damaged_logs_are_refused_or_used_up_to_the_damage() {
    let folder = Folder::new();
    let good = std::fs::read(folder.path("run.mcap")).expect("the log");
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(6);
    for number in 0..12 {
        let (mut bytes, at) = (good.clone(), random.random_range(8..good.len()));
        match number % 4 {
            0 => bytes[at] ^= 1 << random.random_range(0..8),
            1 => bytes.splice(at..at, random.random::<[u8; 9]>()).for_each(drop),
            2 => bytes.splice(at..at, good[at / 2..at].to_vec()).for_each(drop),
            // Often the length of a record.
            _ => bytes[at] = 0xff,
        }
        std::fs::write(folder.path("harmed.mcap"), &bytes).expect("a file");
        let _ = std::fs::remove_file(folder.path("saved.mcap"));
        for arguments in [
            &["info"][..],
            &["cat"],
            &["replay"],
            &["plot", "--out", "path.svg"],
            &["export", "--csv"],
            &["export", "--ros2", "--out", "run.ros2.mcap"],
            &["recover", "--out", "saved.mcap"],
        ] {
            let output = folder.run(&[&arguments[..1], &["harmed.mcap"], &arguments[1..]].concat());
            let said = String::from_utf8_lossy(&output.stderr);
            let known = output.status.code().is_some_and(|code| [0, 1, 65].contains(&code));
            assert!(known && !said.contains("panicked"), "{number}, {arguments:?}: {}: {said}", output.status);
            // Every loss is reported.
            assert!(said.contains("harmed.mcap: ") || said.contains("differ"), "{number}, {arguments:?}: {said}");
        }
    }
}

/// Returns the simulated time of a reading.
fn time_of(line: &str) -> Option<f64> {
    line.split_once("{Time ")?.1.split_once('}')?.0.parse().ok()
}

#[test]
fn a_server_killed_at_any_moment_loses_at_most_the_last_second() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut random = rand_chacha::ChaCha8Rng::seed_from_u64(9);
    for number in 0..20 {
        let log = folder.path().join(format!("{number}.mcap"));
        let arguments = ["serve", "--port", "0", "--no-http", "--json", "--rtf", "20", "--log"];
        let mut serving = usarsim(&arguments, &log);
        let port = ready_port(&mut serving.0);
        let client = TcpStream::connect(("127.0.0.1", port)).expect("a connection");
        let init = b"INIT {ClassName USARBot.P3AT} {Location 0,0,0}\r\nDRIVE {Left 2} {Right 1}\r\n";
        (&client).write_all(init).expect("it is taken");
        let lifetime = Duration::from_millis(random.random_range(100..2500));
        // Readings with their times of arrival.
        let mut readings: Vec<(Instant, f64)> = Vec::new();
        let mut killed = None;
        for line in BufReader::new(client).lines().map_while(Result::ok) {
            let now = Instant::now();
            readings.extend(time_of(&line).filter(|_| line.starts_with("SEN")).map(|time| (now, time)));
            if killed.is_none() && readings.first().is_some_and(|(first, _)| now.duration_since(*first) >= lifetime) {
                killed = Some(now);
                serving.0.kill().expect("it is killed");
            }
        }
        let killed = killed.expect("it was killed");
        let log = recorder::read(&log).unwrap_or_else(|error| panic!("{number}: {error}"));
        assert!(log.end.is_empty(), "it was cut off");
        let last =
            log.entries.iter().rfind(|entry| matches!(entry.record, Record::Out(_))).map_or(-1.0, |last| last.time);
        let lost = readings.iter().find(|(_, time)| *time > last + 1e-3);
        let lost = lost.map_or(Duration::ZERO, |(first, _)| killed.saturating_duration_since(*first));
        assert!(lost <= Duration::from_secs(1), "{number}: {lost:?} lost of {lifetime:?}");
        let replay = logbook::replay(&log).unwrap_or_else(|error| panic!("{number}: {error}"));
        assert!(replay.is_same(), "{number}: {replay:?}");
        println!("killed after {lifetime:?}: {lost:?} lost, {:.1} simulated seconds kept", last.max(0.0));
    }
}

/// A process that is killed on drop.
struct Playing(Child);

/// Starts `usarsim` with a file as its last argument.
fn usarsim(arguments: &[&str], file: &Path) -> Playing {
    let mut command = Command::new(env!("CARGO_BIN_EXE_usarsim"));
    command.args(arguments).arg(file).stdout(Stdio::piped()).stderr(Stdio::null());
    command.spawn().map(Playing).expect("usarsim starts")
}

/// Returns the port in the ready line, which is JSON.
fn ready_port(child: &mut Child) -> u16 {
    let mut ready = String::new();
    BufReader::new(child.stdout.take().expect("stdout")).read_line(&mut ready).expect("a ready line");
    let ready: serde_json::Value = serde_json::from_str(&ready).unwrap_or_else(|error| panic!("{ready}: {error}"));
    ready["port"].as_u64().expect("a port") as u16
}

impl Drop for Playing {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn a_log_is_played_to_each_client_line_by_line() {
    let folder = Folder::new();
    let arguments = ["log", "replay", "--serve", "--port", "0", "--rtf", "0", "--json"];
    let mut playing = usarsim(&arguments, &folder.path("run.mcap"));
    let port = ready_port(&mut playing.0);
    let sent = folder.log.entries.iter().filter_map(|entry| match &entry.record {
        Record::Out(line) => Some(format!("{}\r\n", line.line)),
        _ => None,
    });
    let sent: String = sent.collect();
    for _ in 0..2 {
        let mut came = String::new();
        let client = TcpStream::connect(("127.0.0.1", port)).expect("a connection");
        BufReader::new(client).read_to_string(&mut came).expect("lines to the end");
        assert_eq!(came, sent);
    }
    assert!(
        folder.refused(69, &["replay", "run.mcap", "--serve", "--port", &port.to_string()]).contains("another server")
    );
    folder.refused(2, &["replay", "run.mcap", "--serve", "--connection", "7"]);
    folder.refused(2, &["replay", "run.mcap", "--rtf", "2"]);
}
