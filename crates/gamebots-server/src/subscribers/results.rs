//! Results of a league as JSON files. Threads write them, so that the world does not wait for the disk.

use std::path::PathBuf;
use std::thread::JoinHandle;

use scene::Standings;
use tracing::{info, warn};

use crate::files::{is_kept, numbered};

/// Writer of results.
#[derive(Default)]
pub(crate) struct Results {
    /// File of the first result; the next ones get numbers. None to write nothing.
    name: Option<PathBuf>,
    writing: Vec<JoinHandle<()>>,
}

impl Results {
    pub(crate) fn new(name: Option<PathBuf>) -> Self {
        Self { name, writing: Vec::new() }
    }

    /// Begins to write the result of a round that has begun. No file is replaced.
    pub(crate) fn write(&mut self, standings: &Standings) {
        self.writing.retain(|thread| !thread.is_finished());
        let Some(name) = self.name.clone().filter(|_| standings.began.is_some()) else { return };
        // Results have only text and numbers, so serialization cannot fail.
        let text = serde_json::to_string_pretty(standings).unwrap_or_default();
        let write = move || {
            let path = (1..).map(|number| numbered(&name, number)).find(|path| !is_kept(path)).unwrap_or_default();
            match std::fs::write(&path, text) {
                Ok(()) => info!("the result is in {}", path.display()),
                Err(error) => warn!("no result: {}: {error}", path.display()),
            }
        };
        match std::thread::Builder::new().name("result".to_owned()).spawn(write) {
            Ok(thread) => self.writing.push(thread),
            Err(error) => warn!("no result: {error}"),
        }
    }

    /// Waits until everything is written.
    pub(crate) fn finish(self) {
        // A thread that panicked has said so.
        self.writing.into_iter().for_each(|thread| _ = thread.join());
    }
}
