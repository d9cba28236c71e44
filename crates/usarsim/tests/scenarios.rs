//! Scenarios of the program: which there are, how one begins, and what the page gets of them.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;

use super::cli::{Serving, usarsim};

/// Asks the page for a path. Returns the status and the body.
fn get(server: &Serving, path: &str) -> (u16, Vec<u8>) {
    let port = server.ready["http"].as_u64().expect("a page") as u16;
    let mut stream = TcpStream::connect(("127.0.0.1", port)).expect("a connection");
    let request = format!("GET {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n");
    stream.write_all(request.as_bytes()).expect("taken");
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).expect("an answer");
    let head = answer.windows(4).position(|four| four == b"\r\n\r\n").expect("a head");
    let status = String::from_utf8_lossy(&answer[..head]).split(' ').nth(1).and_then(|status| status.parse().ok());
    (status.expect("a status"), answer[head + 4..].to_owned())
}

fn json(server: &Serving, path: &str) -> serde_json::Value {
    let (status, body) = get(server, path);
    assert_eq!(status, 200, "{path}");
    serde_json::from_slice(&body).expect("JSON")
}

const OWN: &str = "title = \"Own\"\ntext = \"Go.\"\nkeys = \"W\"\nmap = \"smooth\"\ntime_limit = 20\nstars = [3, 6]\nrank = 0\n\
    [[robot]]\nclass = \"P3AT\"\nposition = [2.0, 1.0, 0.0]\n\
    [[zone]]\nname = \"there\"\nposition = [3.0, 1.0, 0.0]\nsize = [1.0, 1.0, 2.0]\n";

#[test]
fn a_scenario_has_its_robot_at_its_start_and_counts_its_goals() {
    let folder = tempfile::tempdir().expect("a folder");
    let own = folder.path().join("own");
    std::fs::create_dir(&own).expect("a folder");
    std::fs::write(own.join("scenario.toml"), OWN).expect("a file");
    let server = Serving::start(&["--http", "0", "--scenario", &own.display().to_string(), "--rtf", "0"]);
    assert_eq!(server.ready["map"], "smooth");
    let mut client = server.connect();
    client
        .write_all(b"REPORT {Errors true}\r\nINIT {ClassName USARBot.Kenaf}\r\nINIT {ClassName USARBot.P3AT}\r\n")
        .expect("taken");
    let mut lines = BufReader::new(client.try_clone().expect("a copy")).lines().map_while(Result::ok);
    let refused = lines.find(|line| line.starts_with("NFO {Error")).expect("an error");
    assert!(refused.contains("team players has no Kenaf: expected one of P3AT"), "{refused}");
    let truth = lines.find(|line| line.contains("{Type GroundTruth}")).expect("a pose");
    assert!(truth.contains("{Location 2.0") && truth.contains(",1.0"), "{truth}");
    client.write_all(b"DRIVE {Left 3} {Right 3}\r\n").expect("taken");
    loop {
        lines.next().expect("it goes on");
        let league = json(&server, "/league.json");
        let team = &league["teams"][0];
        if let Some(finished) = team["finished"].as_f64() {
            assert!(team["scores"][0]["reason"] == "reached there" && finished > 0.5, "{league}");
            break;
        }
    }
    let scene = json(&server, "/scene.json");
    assert_eq!((&scene["scenario"]["title"], &scene["scenario"]["goals"][0]), (&"Own".into(), &"there".into()));
}

#[test]
fn the_page_offers_scenarios_with_logs_of_their_demos() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, demo) in
        [("own", "0 1 INIT {ClassName USARBot.P3AT}\n0.1 1 DRIVE {Left 3} {Right 3}\n"), ("wrong", "0.1 DRIVE\n")]
    {
        let own = folder.path().join(name);
        std::fs::create_dir(&own).expect("a folder");
        std::fs::write(own.join("scenario.toml"), OWN).expect("a file");
        std::fs::write(own.join("demo.txt"), demo).expect("a file");
    }
    // One with the name of a built-in one replaces it.
    std::fs::create_dir(folder.path().join("crate")).expect("a folder");
    std::fs::write(folder.path().join("crate/scenario.toml"), OWN.replace("rank = 0", "rank = 1")).expect("a file");
    let server = Serving::start(&["--http", "0", "--scenarios", &folder.path().display().to_string()]);
    let list = json(&server, "/scenarios.json");
    let names: Vec<&str> = list.as_array().expect("a list").iter().filter_map(|card| card["name"].as_str()).collect();
    // A rank of 0 comes first, and then the name counts.
    assert!(names.len() == 12 && names[..4] == ["own", "wrong", "crate", "stairs"], "{names:?}");
    assert_eq!(list[2]["title"], "Own");
    let (status, log) = get(&server, "/scenario/own/demo.mcap");
    assert!(status == 200 && log.starts_with(b"\x89MCAP"), "{status}");
    // It is played once: the second answer is the same file.
    assert_eq!(get(&server, "/scenario/own/demo.mcap").1, log);
    let file = folder.path().join("demo.mcap");
    std::fs::write(&file, &log).expect("a file");
    let info = usarsim().args(["log", "info", &file.display().to_string()]).output().expect("usarsim runs");
    assert!(String::from_utf8_lossy(&info.stdout).contains("robot 0: P3AT"), "{info:?}");
    let (status, why) = get(&server, "/scenario/wrong/demo.mcap");
    assert_eq!(
        (status, String::from_utf8_lossy(&why).trim()),
        (422, "line 1 of the demo: expected `TIME CLIENT TEXT`")
    );
    for path in ["/scenario/none/demo.mcap", "/scenario/own/picture.jpg", "/scenario/own/solve.py"] {
        assert_eq!(get(&server, path).0, 404, "{path}");
    }
}

#[test]
fn scenarios_are_listed_and_wrong_ones_are_refused_at_the_start() {
    let list = usarsim().args(["scenarios", "--json"]).output().expect("usarsim runs");
    let list: serde_json::Value = serde_json::from_slice(&list.stdout).expect("JSON");
    assert!(list[0]["name"] == "stairs" && list[0]["robots"][0] == "Kenaf", "{list}");
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().display().to_string();
    let own = folder.path().join("own");
    let refused = |arguments: &[&str]| {
        let output = usarsim().arg("serve").args(arguments).args(["--port", "0", "--no-http"]).output();
        let output = output.expect("usarsim runs");
        assert_eq!(output.status.code(), Some(78), "{arguments:?}");
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    assert!(refused(&["--scenarios", &path]).contains("expected folders with a scenario.toml"));
    std::fs::create_dir(&own).expect("a folder");
    for (from, to, expected) in [
        ("\"P3AT\"", "\"P3ATT\"", "no class `P3ATT`: expected one of `usarsim robots`"),
        ("stars = [3, 6]", "stars = 3", "expected an array of length 2"),
    ] {
        std::fs::write(own.join("scenario.toml"), OWN.replace(from, to)).expect("a file");
        let said = refused(&["--scenario", &own.display().to_string()]);
        assert!(said.contains(expected), "{to}: {said}");
    }
    assert!(refused(&["--scenarios", &path]).contains("own/scenario.toml:6"));
    assert!(refused(&["--scenario", "moon"]).contains("unknown scenario `moon`"));
}
