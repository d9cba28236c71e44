//! A server with few descriptors. Strangers who hold connections open lock nobody out.

use std::io::Read;
use std::net::{SocketAddr, TcpStream};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use gamebots_client::Client;
use system_tests::{PATIENCE, Program};

/// Descriptors of the server, fewer than the strangers ask for.
const DESCRIPTORS: u64 = 256;
/// Silent connections to each port.
const STRANGERS: usize = 60;
const TOKENS: &str = "[[token]]\ntoken = \"0123456789abcdef\"\nroles = [\"driver\", \"viewer\"]\n";
const SERVICES: [&str; 8] = ["port", "http", "foxglove", "truth", "positions", "images", "wireless", "com_server"];

/// Writes a script that runs the program with few descriptors.
fn limited(folder: &Path) -> PathBuf {
    let script = folder.join("limited");
    let text = format!("#!/bin/sh\nulimit -n {DESCRIPTORS}\nexec \"{}\" \"$@\"\n", env!("CARGO_BIN_EXE_usarsim"));
    std::fs::write(&script, text).expect("a file");
    std::fs::set_permissions(&script, std::fs::Permissions::from_mode(0o755)).expect("a program");
    script
}

/// Holds silent connections to a port, and renews those that the server closes, until `stop`.
fn hold(port: u16, stop: &AtomicBool) {
    let connect = || {
        let stream = TcpStream::connect(("127.0.0.1", port)).ok()?;
        stream.set_nonblocking(true).ok()?;
        Some(stream)
    };
    let mut held: Vec<TcpStream> = Vec::new();
    while !stop.load(Ordering::Relaxed) {
        held.retain_mut(
            |stream| matches!(stream.read(&mut [0; 64]), Err(error) if error.kind() == std::io::ErrorKind::WouldBlock),
        );
        held.extend((held.len()..STRANGERS).map_while(|_| connect()));
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Logs in, and reads the greeting. Fails if the machine pauses this thread so long after connecting that its place goes to a stranger.
fn log_in(server: SocketAddr) -> std::io::Result<()> {
    let mut client = Client::connect(server)?;
    client.send("LOGIN {Token 0123456789abcdef}")?;
    let greeting = client.next_line(PATIENCE)?.ok_or(std::io::ErrorKind::UnexpectedEof)?;
    assert!(greeting.starts_with("NFO {Gametype"), "{greeting}");
    Ok(())
}

#[test]
fn strangers_who_wait_at_all_ports_lock_out_nobody_with_a_token() {
    let folder = tempfile::tempdir().expect("a folder");
    let tokens = folder.path().join("tokens.toml");
    std::fs::write(&tokens, TOKENS).expect("a file");
    let mut arguments = vec!["--token-file", tokens.to_str().expect("a path")];
    for service in ["--foxglove", "--truth", "--positions", "--images", "--wireless", "--com-server"] {
        arguments.extend([service, "0"]);
    }
    let script = limited(folder.path());
    let mut program = Program::serve(script.to_str().expect("a path"), &arguments);
    let stop = Arc::<AtomicBool>::default();
    let strangers: Vec<_> = SERVICES
        .iter()
        .map(|service| (program.port(service), stop.clone()))
        .map(|(port, stop)| std::thread::spawn(move || hold(port, &stop)))
        .collect();
    for number in 0..5 {
        let start = Instant::now();
        while let Err(error) = log_in(program.address) {
            assert!(start.elapsed() < PATIENCE / 2, "{number}: out after {:?}: {error}", start.elapsed());
        }
    }
    assert!(program.usage().descriptors < DESCRIPTORS, "{} descriptors", program.usage().descriptors);
    stop.store(true, Ordering::Relaxed);
    strangers.into_iter().for_each(|stranger| stranger.join().expect("a stranger"));
    assert!(program.stop().success());
}
