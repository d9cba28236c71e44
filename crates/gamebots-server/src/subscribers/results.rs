//! Results of a league as JSON files. Threads write them, so that the world does not wait for the disk.

use std::path::PathBuf;
use std::thread::JoinHandle;

use recorder::RecordError;
use scene::Standings;
use served_world::Told;
use sessions::News;
use tracing::{info, warn};

use crate::files::{is_kept, numbered};
use crate::subscribers::subscriber::{Moment, Subscriber};

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
    fn write(&mut self, standings: &Standings) {
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
}

impl Subscriber for Results {
    /// Writes the result of a round whose time is up, or that the world's end cuts short.
    fn hear(&mut self, _: &mut Moment, event: &Told) {
        if let Told::News(News::TimeUp(standings)) = event {
            self.write(standings);
        }
        if let Told::Result(standings) = event
            && !standings.is_over
        {
            self.write(standings);
        }
    }

    /// Waits until everything is written.
    fn end(&mut self, _: &mut Moment, _: Option<&str>) -> Option<Result<PathBuf, RecordError>> {
        // A thread that panicked has said so.
        self.writing.drain(..).for_each(|thread| _ = thread.join());
        None
    }
}
