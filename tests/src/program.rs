//! The program as a process, and the resources of a process (Linux).

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::net::{Ipv4Addr, SocketAddr};
use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus, Stdio};

use serde_json::Value;
use tempfile::TempDir;

/// Lines of the program's stderr that are printed when a test fails.
const SHOWN_LINES: usize = 20;

/// A serving program. It is killed on drop.
pub struct Program {
    /// Address of the controllers' port.
    pub address: SocketAddr,
    /// Address of the page.
    pub page: SocketAddr,
    /// Its ready line.
    ready: Value,
    child: Child,
    folder: TempDir,
}

impl Program {
    /// Starts the executable `usarsim` as a server on free ports.
    ///
    /// # Panics
    /// If it does not start.
    pub fn serve(executable: &str, arguments: &[&str]) -> Self {
        let folder = tempfile::tempdir().unwrap_or_else(|error| panic!("no folder: {error}"));
        let said = File::create(folder.path().join("stderr")).unwrap_or_else(|error| panic!("no file: {error}"));
        let child = Command::new(executable)
            .args(["serve", "--port", "0", "--http", "0", "--json"])
            .args(arguments)
            .current_dir(folder.path())
            .stdout(Stdio::piped())
            .stderr(said)
            .spawn();
        let mut child = child.unwrap_or_else(|error| panic!("{executable} does not start: {error}"));
        let mut line = String::new();
        let stdout = child.stdout.take().unwrap_or_else(|| panic!("no stdout"));
        let read = BufReader::new(stdout).read_line(&mut line);
        let ready: Value = read.ok().and_then(|_| serde_json::from_str(&line).ok()).unwrap_or_default();
        let port = |key: &str| ready[key].as_u64().and_then(|port| u16::try_from(port).ok());
        let (Some(address), Some(page)) = (port("port"), port("http")) else { panic!("not ready: {line}") };
        let local = |port| SocketAddr::from((Ipv4Addr::LOCALHOST, port));
        Self { address: local(address), page: local(page), ready, child, folder }
    }

    /// Returns the port of a service that its ready line names.
    ///
    /// # Panics
    /// If it names none.
    pub fn port(&self, service: &str) -> u16 {
        let port = self.ready[service].as_u64().and_then(|port| u16::try_from(port).ok());
        port.unwrap_or_else(|| panic!("no port of {service}"))
    }

    /// Returns the path of a file in the program's working folder.
    pub fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Returns its present resources.
    pub fn usage(&self) -> Usage {
        Usage::of(&self.child.id().to_string())
    }

    /// Stops it by SIGTERM and returns its exit status.
    ///
    /// # Panics
    /// If there is no shell.
    pub fn stop(&mut self) -> ExitStatus {
        // The shell's own kill: not every machine has a program of that name.
        let signal = Command::new("sh").args(["-c", &format!("kill -TERM {}", self.child.id())]).status();
        assert!(signal.is_ok_and(|status| status.success()), "the program is gone");
        self.child.wait().unwrap_or_else(|error| panic!("it does not end: {error}"))
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
        if std::thread::panicking() {
            let said = std::fs::read(self.folder.path().join("stderr")).unwrap_or_default();
            let said = String::from_utf8_lossy(&said);
            let lines: Vec<&str> = said.lines().collect();
            println!("last of its stderr:\n{}", lines[lines.len().saturating_sub(SHOWN_LINES)..].join("\n"));
        }
    }
}

/// Resources of a process.
#[derive(Debug, Clone, Copy)]
pub struct Usage {
    /// Resident memory, bytes.
    pub resident: u64,
    /// Peak of the resident memory, bytes.
    pub peak: u64,
    /// Number of open file descriptors.
    pub descriptors: u64,
    /// Number of threads.
    pub threads: u64,
}

impl Usage {
    /// Returns the resources of a process by its id, or of this one by `self`.
    ///
    /// # Panics
    /// If the process is gone.
    pub fn of(process: &str) -> Self {
        let folder = PathBuf::from("/proc").join(process);
        let status = std::fs::read_to_string(folder.join("status")).unwrap_or_else(|error| panic!("{error}"));
        let number = |key: &str| {
            let line = status.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix(':'));
            line.and_then(|line| line.split_whitespace().next()?.parse::<u64>().ok())
                .unwrap_or_else(|| panic!("the process is gone: no {key} in {status}"))
        };
        let descriptors = std::fs::read_dir(folder.join("fd")).unwrap_or_else(|error| panic!("{error}"));
        Self {
            resident: 1024 * number("VmRSS"),
            peak: 1024 * number("VmHWM"),
            descriptors: descriptors.count() as u64,
            threads: number("Threads"),
        }
    }
}
