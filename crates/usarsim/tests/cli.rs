//! The program as a process: ready line, signals, exit codes, logs.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

use sim_core::{Options, World};
use system_tests::look_until;

pub(super) fn usarsim() -> Command {
    Command::new(env!("CARGO_BIN_EXE_usarsim"))
}

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// A server process. It is killed on drop.
pub(super) struct Serving {
    child: Child,
    pub(super) ready: serde_json::Value,
}

impl Serving {
    pub(super) fn start(arguments: &[&str]) -> Self {
        Self::start_with(arguments, Stdio::null())
    }

    fn start_with(arguments: &[&str], stderr: Stdio) -> Self {
        Self::of(usarsim().arg("serve").args(arguments), stderr)
    }

    /// Starts a command that serves, and waits until it is ready.
    pub(super) fn of(command: &mut Command, stderr: Stdio) -> Self {
        let mut child = command
            .args(["--port", "0", "--json"])
            .stdout(Stdio::piped())
            .stderr(stderr)
            .spawn()
            .expect("usarsim starts");
        let mut line = String::new();
        BufReader::new(child.stdout.take().expect("stdout")).read_line(&mut line).expect("a ready line");
        let ready = serde_json::from_str(&line).unwrap_or_else(|error| panic!("{line}: {error}"));
        Self { child, ready }
    }

    pub(super) fn connect(&self) -> TcpStream {
        let port = self.ready["port"].as_u64().expect("a port") as u16;
        TcpStream::connect(("127.0.0.1", port)).expect("a connection")
    }

    pub(super) fn signal(&self, name: &str) {
        // The shell's own kill: not every machine has a program of that name.
        let status = Command::new("sh").args(["-c", &format!("kill -{name} {}", self.child.id())]).status();
        assert!(status.expect("kill runs").success());
    }

    pub(super) fn wait(&mut self) -> std::process::ExitStatus {
        self.child.wait().expect("it ends")
    }
}

impl Drop for Serving {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn run(arguments: &[&str]) -> Output {
    usarsim().args(arguments).current_dir(repository()).output().expect("usarsim runs")
}

/// Waits until a file has a text.
fn wait_for(file: &Path, expected: &str) {
    look_until(|| text(&std::fs::read(file).expect("a file")), |said| said.contains(expected));
}

/// Starts a server that logs into a file.
fn serve_into(log: &Path) -> Serving {
    Serving::start_with(&["--no-http"], std::fs::File::create(log).expect("a file").into())
}

/// Returns lines with 50 unknown verbs.
fn rubbish() -> String {
    (0..50).map(|number| format!("RUBBISH{number} {{x}}\r\n")).collect()
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn serve_says_in_one_line_of_json_that_it_is_ready() {
    let server = Serving::start(&["--map", "arena"]);
    assert_eq!(server.ready["event"], "ready");
    assert_eq!(server.ready["host"], "127.0.0.1");
    assert_eq!(server.ready["map"], "arena");
    let mut greeting = String::new();
    BufReader::new(server.connect()).read_line(&mut greeting).expect("a greeting");
    assert_eq!(greeting, "NFO {Gametype BotDeathMatch} {Level arena} {TimeLimit 20}\r\n");
}

#[test]
fn both_signals_end_it_within_a_second_with_clients_connected() {
    for signal in ["INT", "TERM"] {
        let mut server = Serving::start(&[]);
        let mut client = server.connect();
        client.write_all(b"INIT {ClassName USARBot.KUKA_YouBot} {Location 0,0,0}\r\n").expect("INIT is taken");
        client.read_exact(&mut [0; 200]).expect("lines come");
        let start = Instant::now();
        server.signal(signal);
        let status = server.wait();
        assert_eq!(status.code(), Some(0), "{signal}");
        assert!(start.elapsed() < Duration::from_secs(1), "{signal}: {:?}", start.elapsed());
    }
}

#[test]
fn a_reader_of_stderr_that_stops_or_leaves_does_not_stop_the_server() {
    for leaves in [false, true] {
        let (reader, writer) = std::io::pipe().expect("a pipe");
        let mut server = Serving::start_with(&[], writer.into());
        let reader = if leaves {
            drop(reader);
            None
        } else {
            Some(reader)
        };
        // Three log lines for each client exceed the capacity of a pipe.
        for _ in 0..500 {
            let mut client = BufReader::new(server.connect());
            client.get_mut().set_read_timeout(Some(Duration::from_secs(30))).expect("a timeout");
            client.get_mut().write_all(b"FOO\r\n").expect("a line is taken");
            assert!(client.read_line(&mut String::new()).is_ok_and(|count| count > 0), "no greeting");
        }
        server.signal("TERM");
        assert_eq!(server.wait().code(), Some(0));
        drop(reader);
    }
}

#[test]
fn a_panic_of_the_world_is_a_report_that_replays_up_to_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let child = usarsim()
        .args(["serve", "--panic-at", "2", "--port", "0", "--no-http", "--json", "--log", "run.mcap"])
        .current_dir(folder.path())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn();
    let mut child = child.expect("usarsim starts");
    let mut line = String::new();
    BufReader::new(child.stdout.take().expect("stdout")).read_line(&mut line).expect("a ready line");
    let ready: serde_json::Value = serde_json::from_str(&line).expect("JSON");
    let mut client =
        TcpStream::connect(("127.0.0.1", ready["port"].as_u64().expect("a port") as u16)).expect("a client");
    client.write_all(b"INIT {ClassName USARBot.P3AT} {Name R1}\r\nDRIVE {Left 1}{Right 1}\r\n").expect("taken");
    let mut lines = String::new();
    // The connection ends cleanly, after all earlier lines.
    client.read_to_string(&mut lines).expect("no reset");
    assert!(lines.contains("{Time 1.9") && lines.ends_with("\r\n"), "{lines}");
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(output.status.code(), Some(70));
    let said = text(&output.stderr);
    for part in [
        "a defect of this program: panicked at crates/gamebots-server/src/subscribers/defect.rs:",
        "the world panicked at 2.000 s: asked to panic; `usarsim log replay usarsim-panic-1.mcap`",
    ] {
        assert!(said.contains(part), "{part} is not in {said}");
    }
    let log =
        |arguments: &[&str]| usarsim().arg("log").args(arguments).current_dir(folder.path()).output().expect("a log");
    for file in ["run.mcap", "usarsim-panic-1.mcap"] {
        assert_eq!(log(&["info", file]).status.code(), Some(0), "{file}");
        let replay = log(&["replay", file]);
        // The replay takes the step that panicked. Here the server panicked, and not the world.
        let said = text(&replay.stdout) + &text(&replay.stderr);
        let expected = "2.002 s replayed with the same bits";
        assert!(replay.status.code() == Some(0) && said.contains(expected), "{file}: {said}");
    }
    assert!(text(&log(&["cat", "usarsim-panic-1.mcap"]).stdout).contains("DRIVE {Left 1}{Right 1}"));
}

#[test]
fn an_output_that_is_closed_changes_no_exit_code() {
    let (reader, writer) = std::io::pipe().expect("a pipe");
    drop(reader);
    let status = usarsim().args(["check", "no-such.toml"]).stdout(Stdio::null()).stderr(writer).status();
    assert_eq!(status.expect("usarsim runs").code(), Some(65));
}

#[test]
fn an_address_in_use_is_exit_code_69() {
    let server = Serving::start(&[]);
    let output = run(&["serve", "--port", &server.ready["port"].to_string()]);
    assert_eq!(output.status.code(), Some(69));
    assert!(text(&output.stderr).contains("is another server running? Port 0 takes a free one"));
}

#[test]
fn an_unknown_map_is_exit_code_78_and_names_those_there_are() {
    let output = run(&["serve", "--map", "mars"]);
    assert_eq!(output.status.code(), Some(78));
    assert!(
        text(&output.stderr)
            .contains("unknown map `mars`: expected a file or one of arena, factory, hall, rescue, rough, slope-1.5,")
    );
}

/// Creates a folder with a map without the usual start, and an experiment.
fn workplace() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::create_dir(folder.path().join("hall")).expect("a folder");
    let map = "description = \"a hall\"\n[[half_space]]\nname = \"floor\"\nmaterial = \"concrete\"\n\
               [[start]]\nname = \"Door\"\nposition = [1, 0, 0]\n";
    std::fs::write(folder.path().join("hall/map.toml"), map).expect("a map");
    folder
}

/// Runs the program with a line of arguments in the workplace. Returns its exit code and its output on stdout and stderr.
fn say(folder: &Path, line: &str) -> (Option<i32>, String) {
    let output = usarsim().args(line.split_whitespace()).current_dir(folder).output().expect("usarsim runs");
    (output.status.code(), text(&output.stdout) + &text(&output.stderr))
}

#[test]
fn what_is_wrong_is_named_with_what_is_right() {
    let folder = workplace();
    for (line, code, expected) in [
        (
            "serve --set robot.wheels.gian=2",
            78,
            "usarsim: --set robot.wheels.gian=2: nothing that is read here has `wheels.gian` (did you mean `robot.wheels.gain`?)",
        ),
        (
            "serve --set P3TA.wheels.gain=2",
            78,
            "no `P3TA` (did you mean `P3AT`?): expected robot, map, material or a class",
        ),
        ("snapshot --map hall --robot P3AT --seconds 0 --size 64x48 --out a.png", 0, "a.png (64 x 48)"),
        (
            "snapshot --robot P3AT --start PlayerStart --out a.png",
            78,
            "(did you mean `PlayerStart_0`?): expected one of",
        ),
        (
            "snapshot --map hall --seconds 0 --size 64x48 --without grid,floor,background --out a.png",
            0,
            "a.png (64 x 48)",
        ),
        ("snapshot --robot P3AT --labels --film 0.2 --seconds 0 --size 64x48 --out a.png", 0, "a.png (64 x 48)"),
        ("snapshot --robot P3AT --film 1 --without background --out a.png", 2, "a film has a background"),
        ("snapshot --without sky --out a.png", 2, "[possible values: floor, grid, background]"),
        ("snapshot --out a.jpg", 2, "expected a name that ends in .png"),
        // A guess stands alone.
        (
            "snapshot --robot P3TA --out a.png",
            78,
            "unknown robot `P3TA` (did you mean `P3AT`?): expected a file or one of those that `usarsim robots` lists\n",
        ),
        (
            "show robot Kenav",
            78,
            "`Kenav` (did you mean `Kenaf`?): expected a file or one of those that `usarsim robots`",
        ),
        (
            "serve --map arean",
            78,
            "`arean` (did you mean `arena`?): expected a file or one of those that `usarsim maps`",
        ),
        ("show robot Zeppelin", 78, "unknown robot `Zeppelin`: expected a file or one of ARDrone, ATRV,"),
        ("copy robot P3AT Mine", 0, "Mine/robot.toml"),
        ("snapshot --robot Mine --seconds 0 --size 64x48 --out a.png", 0, "a.png (64 x 48)"),
        ("bench --robot Mine --seconds 0.1", 0, "of the exact travel"),
        ("import-map hall/map.toml --name Mine", 65, "expected a .sdf, .world"),
        ("check hall", 0, "1 file good\n"),
        ("check hall hall/map.toml", 0, "2 files good\n"),
        ("check nowhere.toml", 65, "1 mistake in 1 file\n"),
        ("log plot nowhere.mcap", 65, "nowhere.mcap"),
        ("teleop 127.0.0.1:1", 69, "is a server running there?"),
    ] {
        let (got, said) = say(folder.path(), line);
        assert_eq!(got, Some(code), "{line}: {said}");
        assert!(said.contains(expected), "{line}: {said}");
    }
}

#[test]
fn an_experiment_that_failed_is_corrected_and_run_in_the_same_folder() {
    let folder = workplace();
    let write = |robot: &str, main: &str| {
        let text = format!(
            "description = \"mine\"\n[setup]\nrobot = \"{robot}\"\ndrive = \"{{Left 1}} {{Right 1}}\"\nsteps = 1\n\
             main = \"{main}\"\n[[plot]]\nname = \"path\"\ntitle = \"Steps forward\"\ny = \"main\"\n"
        );
        std::fs::write(folder.path().join("mine.toml"), text).expect("an experiment");
    };
    for (robot, main, code, expected) in [
        ("P3TA", "forward", 78, "unknown robot `P3TA`"),
        ("P3AT", "foward", 78, "unknown direction `foward` (did you mean `forward`?)"),
        ("P3AT", "forward", 0, "1 run (0 kept from before), 1 plot in "),
        ("P3AT", "left", 78, "it has runs of another version of `mine`"),
    ] {
        write(robot, main);
        let (got, said) = say(folder.path(), "--quiet experiment run mine.toml");
        assert_eq!(got, Some(code), "{said}");
        assert!(said.contains(expected), "{said}");
    }
    let report = std::fs::read_to_string(folder.path().join("mine/report.html")).expect("a report");
    assert!(!report.contains("the thesis") && report.contains("Steps forward") && !report.contains("path  Steps"));
}

#[test]
fn a_wrong_init_is_logged_with_the_right_name_and_repetitions_are_counted() {
    let folder = tempfile::tempdir().expect("a folder");
    let log = folder.path().join("stderr");
    let mut server = serve_into(&log);
    let mut client = BufReader::new(server.connect());
    let lines = "INIT {ClassName USARBot.KUKAYouBot}\r\nINIT {ClassName USARBot.P3AT} {Start PlayerStart}\r\n"
        .to_owned()
        + &"DRIVE {Left fast} {Right 1}\r\n".repeat(13);
    client.get_mut().write_all(lines.as_bytes()).expect("lines are taken");
    let mut line = String::new();
    while !line.starts_with("SEN") {
        line.clear();
        client.read_line(&mut line).expect("a line");
    }
    drop(client);
    wait_for(&log, "times more");
    server.signal("TERM");
    server.wait();
    let said = std::fs::read_to_string(&log).expect("a file");
    for expected in [
        "{ClassName USARBot.KUKAYouBot} is unknown (did you mean `USARBot.KUKA_YouBot`?); `usarsim robots` lists all",
        "{Start PlayerStart} is unknown (did you mean `PlayerStart_0`?); expected one of",
        "{Left fast}: expected a number; read as 0 (12 times more)",
    ] {
        assert!(said.contains(expected), "{expected} is not in {said}");
    }
    assert_eq!(said.matches("{Left fast}: expected").count(), 2, "{said}");
}

#[test]
fn a_client_that_comes_again_and_again_does_not_fill_the_disk() {
    let folder = tempfile::tempdir().expect("a folder");
    let said = folder.path().join("stderr");
    let mut server = serve_into(&said);
    let begin = Instant::now();
    let come_again = || {
        let mut client = server.connect();
        client.write_all(rubbish().as_bytes()).expect("it is taken");
        client.shutdown(std::net::Shutdown::Write).expect("it ends");
        // The server closes when it has read all.
        client.read_to_end(&mut Vec::new()).expect("an end");
        std::fs::read_to_string(&said).expect("a file")
    };
    // The first line of a second says how many were left out of the one before.
    look_until(come_again, |said| said.matches("further lines were not logged").count() >= 3);
    server.signal("TERM");
    server.wait();
    let said = std::fs::read_to_string(&said).expect("a file");
    let most = 22 * (begin.elapsed().as_secs() as usize + 2);
    let count = said.lines().count();
    assert!((20..=most).contains(&count), "{count} lines, expected at most {most}\n{said}");
}

#[test]
fn lines_that_were_not_logged_are_counted_whatever_is_logged_next() {
    let folder = tempfile::tempdir().expect("a folder");
    let said = folder.path().join("stderr");
    let server = serve_into(&said);
    let mut client = server.connect();
    client.write_all(rubbish().as_bytes()).expect("they are taken");
    let come_and_go = || {
        // A client that does nothing wrong.
        drop(server.connect());
        std::fs::read_to_string(&said).expect("a file")
    };
    look_until(come_and_go, |said| said.contains("further lines were not logged about=127.0.0.1 suppressed="));
}

#[test]
fn a_server_for_everyone_names_an_address_that_can_be_opened() {
    let mut child = usarsim();
    child.args(["serve", "--port", "0", "--http", "0", "--host", "0.0.0.0"]);
    let mut child = child.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().expect("usarsim starts");
    let mut lines = BufReader::new(child.stdout.take().expect("stdout")).lines();
    let see = lines.nth(1).expect("two lines").expect("text");
    child.kill().and_then(|()| child.wait()).expect("it ends");
    let address = see.strip_prefix("see it at http://").unwrap_or_else(|| panic!("{see}"));
    assert!(!address.starts_with("0.0.0.0"), "{see}");
}

#[test]
fn a_bad_argument_is_exit_code_2() {
    for arguments in [&["serve", "--rtf", "-1"][..], &["serve", "--port", "99999"], &["fly"], &["check"]] {
        assert_eq!(run(arguments).status.code(), Some(2), "{arguments:?}");
    }
}

/// A map with many mistakes, which are all reported at once with their lines.
const BROKEN_MAP: &str = r#"description = "broken"
gravity = "down"
colour = "red"

[[half_space]]
name = "floor"
material = "velvet"

[[box]]
name = "a box"
material = "carpet"
size = [1.0, 0.0, 1.0]

[[start]]
name = "Here"
"#;

const BROKEN_ROBOT: &str = r#"description = "broken"
steering = "omni"

[[part]]
name = "Body"
mass = -1.0
size = [1, 1, 1]
material = "aluminium"

[wheels]
radius = 0.1
width = 0.05
mass = 0.4
material = "rubber-tyre"
max_speed = 10.0
gain = 10.0
max_torque = 10.0

[[wheel]]
name = "Left"
side = "port"
position = [0.0, -0.2, 0.0]

[[sensor]]
class = "SICK"
name = "laser"
max_rnge = 10.0

[[sensor]]
class = "Radar"
name = "radar"
"#;

const BROKEN_URDF: &str = r#"<robot name="broken">
  <link name="base"/>
  <link>
  </link>
  <joint name="wheel" type="rolling">
    <origin xyz="0 zero 0"/>
    <parent link="base"/><child link="nowhere"/>
  </joint>
</robot>
"#;

#[test]
fn no_command_writes_over_a_file_that_it_reads() {
    let folder = workplace();
    let path = |name: &str| folder.path().join(name);
    let copied = run(&["copy", "map", "smooth", &path("mine").display().to_string()]);
    assert_eq!(copied.status.code(), Some(0));
    std::fs::hard_link(path("mine/map.toml"), path("map.png")).expect("a link");
    let plan = "description = \"ahead\"\ndrive_models = [\"analytic\"]\n[setup]\nsteps = 1\n\
        drive = \"{Front-Left 1}{Front-Right 1}{Back-Left 1}{Back-Right 1}\"\n";
    let fit = "description = \"a fit\"\nexperiment = \"plan.toml\"\nmeasured = \"results/steps.csv\"\n\
        [[parameter]]\nname = \"gain\"\nset = [\"robot.wheels.gain={}\"]\nrange = [2, 3]\n";
    std::fs::write(path("plan.toml"), plan).expect("a file");
    std::fs::write(path("fit.json"), fit).expect("a file");
    let (code, said) = say(folder.path(), "experiment run plan.toml --out results");
    assert_eq!(code, Some(0), "{said}");
    std::fs::write(path("results/report.html"), plan).expect("a file");
    for (line, out, input) in [
        ("snapshot --map mine --out map.png", "map.png", "mine/map.toml"),
        ("snapshot --map mine/map.toml --out map.png", "map.png", "mine/map.toml"),
        ("bench --map mine --trace mine/map.toml", "mine/map.toml", "mine/map.toml"),
        ("experiment run results/report.html --out results", "results/report.html", "results/report.html"),
        ("experiment fit fit.json --out .", "./fit.json", "fit.json"),
    ] {
        let kept = std::fs::read(path(input)).expect("a file");
        let (code, said) = say(folder.path(), line);
        let expected = format!("the output {out} is the input file {input}, which would be lost: choose another");
        assert!(code == Some(2) && said.contains(&expected), "{line}: {said}");
        assert!(std::fs::read(path(input)).expect("a file") == kept, "{line}: {input} has changed");
    }
}

const TOKEN: &str = "driver-0123456789abcdef";

#[test]
fn a_relay_lets_a_controller_in_that_knows_no_token() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("tokens.toml");
    std::fs::write(&file, format!("[[token]]\ntoken = \"{TOKEN}\"\nroles = [\"driver\"]\n")).expect("a file");
    let server = Serving::start(&["--no-http", "--token-file", file.to_str().expect("a path")]);
    let address = format!("127.0.0.1:{}", server.ready["port"]);
    for (token, expected) in
        [(TOKEN, "NFO {Gametype"), ("wrong-0123456789abcdef", "NFO {Error LOGIN refused: the token is unknown")]
    {
        let relay = Serving::of(usarsim().args(["relay", &address]).env("USARSIM_TOKEN", token), Stdio::null());
        let mut line = String::new();
        BufReader::new(relay.connect()).read_line(&mut line).expect("a line");
        assert!(line.starts_with(expected), "{token}: {line}");
    }
    for (token, expected) in [(Some(TOKEN), "NFO {StartPoses"), (None, "NFO {Error LOGIN refused: there is no token")] {
        let mut connect = usarsim();
        connect.args(["connect", &address]).stdin(Stdio::piped()).stdout(Stdio::piped());
        token.map(|token| connect.env("USARSIM_TOKEN", token));
        let mut child = connect.spawn().expect("usarsim starts");
        child.stdin.take().expect("stdin").write_all(b"GETSTARTPOSES\n").expect("it is taken");
        let said = text(&child.wait_with_output().expect("it ends").stdout);
        assert!(said.contains(expected), "{token:?}: {said}");
    }
    let output = run(&["relay", &address]);
    assert_eq!(output.status.code(), Some(2), "{}", text(&output.stderr));
}

#[test]
fn a_bad_file_of_tokens_is_exit_code_78_and_is_not_shown() {
    let folder = tempfile::tempdir().expect("a folder");
    let token = |team: &str| format!("[[token]]\ntoken = \"{TOKEN}\"\nroles = [\"driver\"]\nteam = \"{team}\"\n");
    for (content, expected) in [
        (token("red") + "x", "tokens.toml: line 5: "),
        (token("red").repeat(2), "tokens.toml: token 2 equals token 1"),
        (token("green"), "no team `green` in the league: expected one of red, blue"),
    ] {
        std::fs::write(folder.path().join("tokens.toml"), content).expect("a file");
        let (code, said) = say(folder.path(), "serve --league rescue --token-file tokens.toml");
        assert!(code == Some(78) && said.contains(expected) && !said.contains(TOKEN), "{code:?} {said}");
        let (code, said) = say(folder.path(), "check tokens.toml");
        // Only the server knows the teams.
        let expected = if expected.contains("green") { "1 file good" } else { expected };
        let is_good = expected == "1 file good";
        assert!(said.contains(expected) && !said.contains(TOKEN) && (code == Some(0)) == is_good, "{code:?} {said}");
    }
}

/// Hostile text for a terminal: escape sequences for the clipboard and the screen, and one-byte control characters.
const ESCAPES: &str = "\x1b]52;c;aGk=\x07\x1b[2J\u{9b}2J\u{7f}";
const ESCAPED: &str = "\\x1b]52;c;aGk=\\x07\\x1b[2J\\u009b2J\\u007f";

#[test]
fn what_a_server_says_is_shown_without_control_characters() {
    for (command, line) in [
        ("connect", format!("NFO {{Word {ESCAPES}}}\r\n")),
        ("teleop", format!("NFO {{Error {ESCAPES}}}\r\nNFO {{Error GETCONF ignored}}\r\n")),
        ("teleop", format!("NFO {{Error {ESCAPES}}}\r\nCONF {{Type Robot}} {{SteeringType SkidSteered}}\r\n")),
    ] {
        let listener = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
        let address = listener.local_addr().expect("an address").to_string();
        let output = tempfile::NamedTempFile::new().expect("a file");
        let mut child = usarsim()
            .args([command, &address])
            .args(if command == "teleop" { &["--start", "Door"][..] } else { &[] })
            .stdin(Stdio::piped())
            .stdout(output.as_file().try_clone().expect("a file"))
            .stderr(output.as_file().try_clone().expect("a file"))
            .spawn()
            .expect("usarsim starts");
        let (mut server, _) = listener.accept().expect("a client");
        server.write_all(line.as_bytes()).expect("it is taken");
        // First the end of the input, then of the connection.
        drop(child.stdin.take());
        wait_for(output.path(), ESCAPED);
        drop(server);
        child.wait().expect("it ends");
        let said = std::fs::read_to_string(output.path()).expect("a file");
        assert!(!said.contains("\x1b]") && !said.contains("\u{9b}"), "{command}: {said:?}");
    }
}

#[test]
fn what_a_client_said_is_in_a_log_and_shown_without_control_characters() {
    let folder = tempfile::tempdir().expect("a folder");
    let log = folder.path().join("run.mcap");
    let mut server = Serving::start(&["--rtf", "0", "--log", log.to_str().expect("a path")]);
    let mut client = BufReader::new(server.connect());
    let init =
        format!("INIT {{ClassName USARBot.P3AT}} {{Name {ESCAPES}}} {{Location 0,0,0}}\r\nSAY {{Word {ESCAPES}}}\r\n");
    client.get_mut().write_all(init.as_bytes()).expect("it is taken");
    let mut line = String::new();
    while !line.starts_with("STA") {
        line.clear();
        client.read_line(&mut line).expect("a line");
    }
    server.signal("TERM");
    server.wait();
    let recorded = format!("SAY {{Word {ESCAPES}}}");
    for command in ["log info run.mcap", "log cat run.mcap", "log plot run.mcap --robot X", "log replay run.mcap"] {
        let (_, said) = say(folder.path(), command);
        assert!(!said.contains(|c: char| c.is_control() && c != '\n' && c != '\t'), "{command}: {said:?}");
    }
    let (_, said) = say(folder.path(), "log cat run.mcap --type SAY");
    assert!(said.contains(ESCAPED), "{said:?}");
    let (_, said) = say(folder.path(), "log cat run.mcap --type SAY --json");
    let row: serde_json::Value = serde_json::from_str(&said).unwrap_or_else(|error| panic!("{said}: {error}"));
    assert_eq!((&row["line"], &row["direction"]), (&recorded.into(), &"in".into()));
}

#[test]
fn check_names_every_mistake_with_its_line() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, content, expected) in [
        (
            "map.toml",
            BROKEN_MAP,
            &[
                "map.toml:2:11: invalid type: string \"down\", expected f64",
                "map.toml:3:1: unknown key `colour`: expected one of description, robots, gravity",
                "map.toml:5:1: unknown material `velvet`: expected one of aluminium, carpet",
                "map.toml:9:1: `size` is [1, 0, 1]: expected numbers of 0.0001 to 100000 m",
                "map.toml:9:1: name `a box`: expected a name without spaces and braces",
                "map.toml:14:1: missing `position`: expected [x, y, z] in metres",
            ][..],
        ),
        (
            "robot.toml",
            BROKEN_ROBOT,
            &[
                "robot.toml:4:1: `mass` is -1: expected 1e-9 to 100000 kg",
                "robot.toml:21:8: unknown variant `port`, expected `left` or `right`",
                "robot.toml:27:1: unknown field `max_rnge`, expected one of `max_range`",
                "robot.toml:29:1: unknown sensor class `Radar`: expected one of GroundTruth",
            ],
        ),
        (
            "robot.urdf",
            BROKEN_URDF,
            &[
                "robot.urdf:3:3: <link> without `name`",
                "robot.urdf:5:3: joint type `rolling`: expected one of fixed, continuous",
                "robot.urdf:6:5: xyz=\"0 zero 0\": expected 3 finite numbers",
                "robot.urdf:7:26: unknown link `nowhere`: expected one of base",
            ],
        ),
    ] {
        let path = folder.path().join(name);
        std::fs::write(&path, content).expect("a file");
        let output = run(&["check", path.to_str().expect("a path")]);
        let found = text(&output.stdout);
        assert_eq!(output.status.code(), Some(65), "{found}");
        for line in expected {
            assert!(found.contains(line), "{name}: missing `{line}` in\n{found}");
        }
        assert_eq!(found.lines().count(), expected.len(), "{found}");
    }
}

#[test]
fn a_broken_map_or_robot_is_refused_at_start() {
    let folder = tempfile::tempdir().expect("a folder");
    let (map, robot) = (folder.path().join("map.toml"), folder.path().join("robot.toml"));
    std::fs::write(&map, BROKEN_MAP).expect("a file");
    std::fs::write(&robot, BROKEN_ROBOT).expect("a file");
    for arguments in
        [["serve", "--map", map.to_str().expect("a path")], ["serve", "--robot", robot.to_str().expect("a path")]]
    {
        let output = run(&arguments);
        assert_eq!(output.status.code(), Some(78), "{arguments:?}");
        assert!(text(&output.stderr).contains(".toml:"), "{arguments:?}");
    }
}

#[test]
fn a_picture_is_taken_of_a_robot_whatever_its_file_is_called() {
    let folder = tempfile::tempdir().expect("a folder");
    system_tests::copy_robot("Kenaf", folder.path());
    for name in ["robot.toml", "Tracked.toml"] {
        let (file, out) = (folder.path().join(name), folder.path().join("picture.png"));
        if !file.exists() {
            std::fs::rename(folder.path().join("robot.toml"), &file).expect("another name");
        }
        let [file, out] = [&file, &out].map(|path| path.to_str().expect("a path"));
        let output = run(&["snapshot", "--robot", file, "--size", "64x48", "--seconds", "0.1", "--out", out]);
        assert_eq!(output.status.code(), Some(0), "{name}: {}", text(&output.stderr));
        assert!(std::fs::read(out).is_ok_and(|png| png.starts_with(b"\x89PNG")), "{name}");
        std::fs::remove_file(out).expect("a picture");
    }
}

#[test]
fn what_is_shipped_is_good() {
    let mut files = vec!["assets/materials.toml".to_owned(), "assets/robots/KUKA_YouBot/robot.urdf".to_owned()];
    files.extend(scene_loader::map_names().iter().map(|map| format!("maps/{map}/map.toml")));
    // A class may have several names, but only one folder.
    for (folder, file) in [("robots", "robot.toml"), ("actuators", "actuator.toml")] {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let entries = std::fs::read_dir(root.join("assets").join(folder)).expect("a folder");
        let found = entries.map(|entry| entry.expect("an entry").path().join(file)).filter(|path| path.is_file());
        let before = files.len();
        files.extend(found.map(|path| path.display().to_string()));
        assert!(files.len() > before + 10, "{folder}: {}", files.len() - before);
    }
    let mut arguments = vec!["check"];
    arguments.extend(files.iter().map(String::as_str));
    let output = run(&arguments);
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stdout));
}

/// Changes the state of a saved world. Each file is refused with the reason, and no server starts.
#[test]
fn a_saved_world_with_options_or_numbers_of_no_run_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let world = World::new(scene_loader::load("hall", &[]).expect("a map"), Options::default());
    let state = serde_json::to_value(world.save().expect("a state")).expect("JSON");
    let file = folder.path().join("saved.json");
    for (key, value, expected) in [
        ("/options/time_step", "0", "options: `time_step` is 0: expected 0.0001 to 0.02 s"),
        ("/options/time_step", "1e-300", "`time_step` is 1e-300: expected 0.0001 to 0.02 s"),
        ("/options/time_step", "0.5", "`time_step` is 0.5: expected 0.0001 to 0.02 s"),
        ("/options/speed_unit", "0", "`speed_unit` is 0: expected 0.01 to 100 rad/s"),
        ("/steps", "18446744073709551615", "`steps` is 18446744073709551615: expected at most 281474976710656"),
        ("/next_id", "18446744073709551615", "`next_id` is 18446744073709551615: expected at most"),
    ] {
        let mut state = state.clone();
        *state.pointer_mut(key).expect("a number") = serde_json::from_str(value).expect("a number");
        let saved = serde_json::json!({ "format": 1, "scene": world.def(), "state": state });
        std::fs::write(&file, saved.to_string()).expect("a file");
        let path = file.display().to_string();
        let output = run(&["serve", "--from", &path, "--port", "0", "--no-http"]);
        let said = text(&output.stderr);
        assert!(output.status.code() == Some(78) && said.contains(expected), "{key} {value}: {said}");
    }
}

/// Lines of a list in the order of its families, with the colours of a class in one line.
#[test]
fn the_list_of_robots_is_by_family_and_folds_colours() {
    let list = text(&run(&["robots"]).stdout);
    let places: Vec<_> = [
        "On wheels.",
        "USARBot.P3AT ",
        "On tracks.",
        "USARBot.Kenaf ",
        "Cars.",
        "USARBot.Hummer ",
        "On legs.",
        "USARBot.Nao ",
    ]
    .iter()
    .map(|part| list.find(part).unwrap_or_else(|| panic!("{part}: {list}")))
    .collect();
    assert!(places.is_sorted(), "{list}");
    assert!(list.contains("; also with _b _g _r _y\n") && !list.contains("_sensors_b "), "{list}");
    assert!(list.contains("; also OmniP2AT, P2AT_ATLANTA\n"), "{list}");
}

#[test]
fn serve_has_a_short_help_and_a_long_one_with_headings() {
    let help = |option: &str| text(&run(&["serve", option]).stdout);
    let (short, long) = (help("-h"), help("--help"));
    let options = |help: &str| help.lines().filter(|line| line.trim_start().starts_with("--")).count();
    assert!(options(&short) == 12 && options(&long) > 30, "{short}");
    let headings = ["World:", "Robots:", "Page:", "Ports:", "ROS 2:", "Time:", "Log:", "Access:"];
    let places: Vec<_> = headings.iter().map(|heading| long.find(&format!("\n{heading}\n"))).collect();
    assert!(places.iter().all(Option::is_some) && places.is_sorted(), "{places:?}: {long}");
}

#[test]
fn a_file_of_tokens_is_bounded_and_a_word_is_no_token() {
    let folder = tempfile::tempdir().expect("a folder");
    let endless = |arguments: &[&str], code: i32| {
        let output = run(arguments);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}");
        let said = text(&output.stdout) + &text(&output.stderr);
        assert!(said.contains("not a regular file") || said.contains("/dev/zero: expected"), "{arguments:?}: {said}");
    };
    endless(&["serve", "--port", "0", "--token-file", "/dev/zero"], 78);
    endless(&["check", "/dev/zero"], 65);
    endless(&["experiment", "run", "/dev/zero"], 78);
    endless(&["experiment", "fit", "/dev/zero"], 78);
    let file = folder.path().join("tokens.toml");
    std::fs::write(&file, "[[token]]\ntoken = \"the-projector-in-the-hall\"\nroles = [\"viewer\"]\n").expect("a file");
    let (reader, writer) = std::io::pipe().expect("a pipe");
    let mut server = Serving::start_with(&["--token-file", &file.display().to_string()], writer.into());
    server.signal("TERM");
    assert_eq!(server.wait().code(), Some(0));
    drop(server);
    let said = std::io::read_to_string(reader).expect("text");
    assert!(said.contains("tokens.toml: token 1 could be guessed") && !said.contains("projector"), "{said}");
}

#[test]
fn the_lists_name_maps_and_robots() {
    for (command, names) in [("maps", ["rough", "arena"]), ("robots", ["USARBot.KUKA_YouBot", "USARBot.P3AT"])] {
        let plain = text(&run(&[command]).stdout);
        let json: serde_json::Value = serde_json::from_slice(&run(&[command, "--json"]).stdout).expect("JSON");
        for name in names {
            assert!(plain.contains(name), "{plain}");
            assert!(json.to_string().contains(name), "{json}");
        }
    }
}

#[test]
fn copies_of_all_robots_and_maps_are_good_and_overwrite_nothing() {
    let folder = tempfile::tempdir().expect("a folder");
    let copy = |what: &str, name: &str, to: &str| {
        usarsim().current_dir(&folder).args(["copy", what, name, to]).output().expect("it runs")
    };
    for (what, names) in [("robot", scene_loader::robot_names()), ("map", scene_loader::map_names())] {
        for name in names {
            let to = format!("my-{name}");
            let output = copy(what, &name, &to);
            assert!(output.status.success(), "{name}: {output:?}");
            let check = usarsim().current_dir(&folder).args(["check", &to]).output().expect("it runs");
            assert!(check.status.success(), "{name}: {check:?}");
        }
    }
    for (name, to, code, expected) in [
        ("arena", "my-arena", 1, "my-arena: exists already: choose another name"),
        ("arean", "new", 78, "did you mean `arena`"),
        ("arena", "no/such/place", 1, "no/such/place: No such file or directory"),
    ] {
        let output = copy("map", name, to);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(code) && said.contains(expected), "{name} {to}: {output:?}");
    }
}

#[test]
fn robots_have_the_equipment_of_a_set_or_of_an_ini() {
    let show = |arguments: &[&str]| run(&[&["show", "robot", "P3AT"], arguments].concat());
    let set = show(&["--equipment", "robocup2014"]);
    assert!(set.status.success() && text(&set.stdout).contains("\"Sonar8\""), "{}", text(&set.stderr));
    let folder = tempfile::tempdir().expect("a folder");
    let ini = folder.path().join("team.ini");
    let lines = "[USARBot.P3AT]\nAddParts=(ItemClass=class'USARSensor.IMU',ItemName=\"only\")\nColour=red\n";
    std::fs::write(&ini, lines).expect("a file");
    let path = ini.display().to_string();
    let shown = show(&["--ini", &path]);
    assert!(shown.status.success() && text(&shown.stdout).contains("\"only\""), "{}", text(&shown.stderr));
    let warning = format!("warning: {path}:3:1: `Colour` of P3AT has no effect\n");
    assert_eq!(text(&shown.stderr), warning);
    let checked = run(&["check", &path]);
    assert!(checked.status.success() && text(&checked.stdout).contains("note: 3:1: `Colour`"), "{checked:?}");
    for (arguments, code, message) in [
        (vec!["--equipment", "robocup2015"], 78, "did you mean `robocup2014`?"),
        (vec!["--ini", "none.ini"], 78, "none.ini: cannot be read"),
        (vec!["--equipment", "shipped", "--ini", &path], 2, "cannot be used with"),
    ] {
        let refused = show(&arguments);
        assert_eq!(refused.status.code(), Some(code), "{arguments:?}");
        assert!(text(&refused.stderr).contains(message), "{arguments:?}: {}", text(&refused.stderr));
    }
}

#[test]
fn show_prints_the_numbers_in_effect() {
    let output = run(&["show", "robot", "KUKA_YouBot", "--set", "robot.wheels.gain=2.5", "--drive-model", "analytic"]);
    let shown = text(&output.stdout);
    assert!(output.status.success() && shown.contains("drive_model = \"Analytic\""), "{shown}");
    assert_eq!(shown.matches("gain = 2.5").count(), 4, "{shown}");
    let output = run(&["show", "map", "rough", "--json", "--set", "map.gravity=1.62"]);
    assert!(text(&output.stdout).contains("\"gravity\": 1.62"), "{}", text(&output.stdout));
    let output = run(&["show", "map", "rough", "--set", "map.gravitas=1"]);
    assert_eq!(output.status.code(), Some(78));
    let output = run(&["show", "map", "rough", "--set", "robot.wheels.gain=1"]);
    assert_eq!(output.status.code(), Some(78));
    assert!(text(&output.stderr).contains("nothing that is read here is a `robot`"), "{}", text(&output.stderr));
}

#[test]
fn bench_measures_speed_and_error_in_one_run() {
    let output = run(&["bench", "--seconds", "1", "--dt", "0.004", "--robots", "2", "--json"]);
    let report: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let number = |key: &str| report[key].as_f64().unwrap_or_else(|| panic!("no {key} in {report}"));
    assert!(number("real_time_factor") > 0.0 && number("microseconds_per_step") > 0.0, "{report}");
    assert_eq!((number("dt"), number("robots")), (0.004, 2.0));
    assert!(number("worst_error_percent") < 3.0, "{report}");
    let output = run(&["bench", "--robot", "CasterSkidRobot", "--seconds", "1", "--json"]);
    let result: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    for motion in ["forward", "clockwise", "curve"] {
        let ratio = result["motions"][motion]["ratio"].as_f64().expect("a ratio");
        assert!((ratio - 1.0).abs() < 0.01, "{result}");
    }
    let refused = run(&["bench", "--robot", "AirRobot"]);
    assert_eq!(refused.status.code(), Some(78));
    assert!(text(&refused.stderr).contains("expected one with driven wheels"), "{}", text(&refused.stderr));
}

#[test]
fn a_killed_server_leaves_a_log_that_reads() {
    let folder = tempfile::tempdir().expect("a folder");
    let log = folder.path().join("run.mcap");
    let mut server = Serving::start(&["--log", log.to_str().expect("a path")]);
    let mut client = BufReader::new(server.connect());
    client
        .get_mut()
        .write_all(b"INIT {ClassName USARBot.P3AT} {Name Ann} {Location 0,0,0}\r\n")
        .expect("INIT is taken");
    client.get_mut().write_all(b"DRIVE {Left 1} {Right 1}\r\n").expect("DRIVE is taken");
    // After a status of two seconds later, the log holds everything up to a second before that status.
    let mut line = String::new();
    while !line.contains("{Battery 1197}") {
        line.clear();
        client.read_line(&mut line).expect("a line");
    }
    server.signal("KILL");
    server.wait();
    let recorder::Log { entries, end, .. } = recorder::read(&log).expect("the log reads");
    assert!(end.is_empty(), "it was cut off");
    let drive = recorder::Record::In(recorder::WireLine {
        connection: 1,
        robot: Some(0),
        line: "DRIVE {Left 1} {Right 1}".to_owned(),
    });
    assert!(entries.iter().any(|entry| entry.record == drive));
    let states: Vec<_> = entries
        .iter()
        .filter_map(|entry| match &entry.record {
            recorder::Record::State(state) => Some((entry.time, state)),
            _ => None,
        })
        .collect();
    assert!(states.len() > 50, "{} states", states.len());
    let steps = states.windows(2).map(|pair| pair[1].0 - pair[0].0);
    assert!(steps.into_iter().all(|step| (step - 0.02).abs() < 1e-9), "50 Hz of simulated time");
    assert_eq!((states[0].1.name.as_str(), states[0].1.joint_positions.len()), ("Ann", 4));

    let file = log.to_str().expect("a path");
    let text = |arguments: &[&str]| {
        let output = run(arguments);
        assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stdout).into_owned()
    };
    assert!(
        text(&["log", "info", file])
            .contains("cut off\nmap hall, seed 0, steps of 0.002 s\nrobot 0: P3AT Ann\n2 lines in")
    );
    assert!(text(&["log", "cat", file, "--type", "drive"]).ends_with(" 1 < DRIVE {Left 1} {Right 1}\n"));
    assert!(text(&["log", "replay", file]).contains("replayed with the same bits"));
    assert_eq!(run(&["log", "info", "Cargo.toml"]).status.code(), Some(65));
}
