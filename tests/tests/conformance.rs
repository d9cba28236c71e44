//! The conformance cases of USARSim's protocol, over a real socket: `tests/conformance/*.txt`.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use system_tests::{Peer, Server, Transcript, run_transcript, wait_until};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).to_owned()
}

fn check(name: &str) {
    let robots = ["ShortLife", "KR60"].map(|class| folder().join("robots").join(class).join("robot.toml"));
    run_transcript(
        &Transcript::read(&folder().join("conformance").join(name)),
        &robots.each_ref().map(PathBuf::as_path),
    );
}

#[test]
fn framing() {
    check("framing.txt");
}

#[test]
fn tokeniser() {
    check("tokeniser.txt");
}

#[test]
fn init() {
    check("init.txt");
}

#[test]
fn p3at() {
    check("p3at.txt");
}

#[test]
fn pioneer2() {
    check("pioneer2.txt");
}

#[test]
fn ut2004() {
    check("ut2004.txt");
}

#[test]
fn ut2004_for_robots_of_udk() {
    check("ut2004-forced.txt");
}

#[test]
fn youbot() {
    check("youbot.txt");
}

#[test]
fn ackermann() {
    check("ackermann.txt");
}

#[test]
fn airrobot() {
    check("airrobot.txt");
}

#[test]
fn arm() {
    check("arm.txt");
}

#[test]
fn static_platform() {
    check("static.txt");
}

#[test]
fn world_controller() {
    check("controller.txt");
}

#[test]
fn ports_beside_the_controllers() {
    check("ports.txt");
}

#[test]
fn report() {
    check("report.txt");
}

#[test]
fn battery() {
    check("battery.txt");
}

/// Case 3: as in USARSim, one client more than the limit of 64 is accepted. The next is refused until one leaves.
#[test]
fn the_66th_connection_is_refused_until_one_leaves() {
    let server = Server::start("rough", &[], |_| {});
    let mut peers: Vec<Peer> = (0..65).map(|_| server.client()).collect();
    wait_until(|| Peer::connect(server.address).is_err());
    peers.pop();
    let greeted = |mut peer: Peer| peer.line_or_end().is_some_and(|line| line.starts_with("NFO {Gametype "));
    wait_until(|| Peer::connect(server.address).is_ok_and(greeted));
}

/// The table in the docs and the transcripts list the same cases.
#[test]
fn the_table_of_cases_agrees_with_the_transcripts() {
    let table = std::fs::read_to_string(folder().join("../docs/conformance.md")).expect("docs/conformance.md");
    let mut written = BTreeSet::new();
    for entry in std::fs::read_dir(folder().join("conformance")).expect("tests/conformance") {
        let path = entry.expect("a file").path();
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        written.extend(Transcript::read(&path).case_numbers().into_iter().map(|case| (case, name.clone())));
    }
    let (mut listed, mut titles) = (BTreeSet::new(), BTreeSet::new());
    for row in table.lines().filter(|row| row.starts_with("| ")) {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        let Ok(case) = cells[1].parse::<u32>() else { continue };
        let title = cells[2];
        assert!(title.len() > 3 && titles.insert(title), "case {case} needs a title of its own: `{title}`");
        if let Some(file) = cells[3].strip_prefix("`tests/conformance/") {
            listed.insert((case, file.trim_end_matches('`').to_owned()));
        }
    }
    assert_eq!(listed, written);
    let rows: BTreeSet<u32> = table.lines().filter_map(|row| row.split('|').nth(1)?.trim().parse().ok()).collect();
    assert_eq!(rows, (1..=120).collect(), "every case of the specification has a row");
}
