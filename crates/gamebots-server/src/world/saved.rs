//! Files of saved worlds: the scene and the state of a world at the end of a step, as JSON.

use std::fs::File;
use std::io::{BufReader, BufWriter, Read, Write};
use std::path::Path;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::{Duration, Instant};

use scene::WorldDef;
use serde::{Deserialize, Serialize};
use sim_core::{CompiledScene, SavedWorld, World};

use crate::files::{is_kept, numbered};

/// The newest format, which is written.
const FORMAT: u32 = 1;
/// Largest file that is read, bytes: a map of 500 000 triangles and 256 robots.
const MAX_BYTES: u64 = 256 * 1024 * 1024;
/// Least time between two saves: each takes time of the world's thread, and room on the disk.
const INTERVAL: Duration = Duration::from_secs(1);

#[derive(Serialize)]
struct Written<'a> {
    format: u32,
    scene: &'a WorldDef,
    state: &'a SavedWorld,
}

#[derive(Deserialize)]
struct SavedFile {
    format: u32,
    scene: WorldDef,
    state: SavedWorld,
}

/// The reason why a file does not give a world.
#[derive(Debug, thiserror::Error)]
pub enum SavedFileError {
    /// The file cannot be read.
    #[error("{file}: {reason}")]
    Unreadable {
        /// Its path.
        file: String,
        /// The operating system's error.
        reason: std::io::Error,
    },
    /// The file is no saved world.
    #[error("{file}: not a saved world: {reason}")]
    Malformed {
        /// Its path.
        file: String,
        /// The problem.
        reason: String,
    },
}

/// Reads the scene and the state of a saved world.
///
/// # Errors
/// When the file cannot be read, or is no saved world.
pub fn read_saved(path: &Path) -> Result<(WorldDef, SavedWorld), SavedFileError> {
    let file = path.display().to_string();
    let malformed = |reason: String| SavedFileError::Malformed { file: file.clone(), reason };
    let opened = File::open(path).map_err(|reason| SavedFileError::Unreadable { file: file.clone(), reason })?;
    let found: SavedFile = serde_json::from_reader(BufReader::new(opened.take(MAX_BYTES)))
        .map_err(|error| malformed(error.to_string()))?;
    if found.format != FORMAT {
        return Err(malformed(format!("its format is {}: expected {FORMAT}", found.format)));
    }
    found.scene.check().map_err(|problem| malformed(problem.to_string()))?;
    Ok((found.scene, found.state))
}

/// Saving of a world while it runs. A thread writes the file, so that the world does not wait for the disk.
#[derive(Default)]
pub(crate) struct Saving {
    /// True if somebody asked for a save that has not begun. Saves that wait become one.
    is_asked: bool,
    /// The outcome of the save that is being written.
    outcome: Option<Receiver<Outcome>>,
    /// Time of the last save's start.
    started: Option<Instant>,
}

/// A sentence about a save that succeeded or failed.
type Outcome = Result<String, String>;

impl Saving {
    /// Requests a save.
    pub(crate) fn ask(&mut self) {
        self.is_asked = true;
    }

    /// True if a save is to begin now.
    pub(crate) fn is_due(&self, now: Instant) -> bool {
        let has_rested = self.started.is_none_or(|started| now.duration_since(started) >= INTERVAL);
        self.is_asked && self.outcome.is_none() && has_rested
    }

    /// Begins to write a world to a file beside this name that does not exist yet. Returns the reason if it cannot.
    pub(crate) fn start(&mut self, now: Instant, name: &Path, world: &World) -> Result<(), String> {
        (self.is_asked, self.started) = (false, Some(now));
        let state = world.save().map_err(|error| format!("not saved: {error}"))?;
        let path = (1..).map(|number| numbered(name, number)).find(|path| !is_kept(path)).unwrap_or_default();
        let (scene, time) = (world.scene().clone(), world.time());
        let (done, news) = channel();
        let write = move || {
            let said = match write(&path, &scene, &state) {
                Ok(()) => Ok(format!("saved the world at {time:.3} s to {}", path.display())),
                Err(error) => Err(format!("not saved: {}: {error}", path.display())),
            };
            // The server may have ended.
            let _ = done.send(said);
        };
        let thread = std::thread::Builder::new().name("save".to_owned()).spawn(write);
        thread.map_err(|error| format!("not saved: {error}"))?;
        self.outcome = Some(news);
        Ok(())
    }

    /// Returns the outcome of a save that has ended since the last call.
    pub(crate) fn news(&mut self) -> Option<Outcome> {
        let news = match self.outcome.as_ref()?.try_recv() {
            Ok(news) => news,
            Err(TryRecvError::Empty) => return None,
            Err(TryRecvError::Disconnected) => Err("not saved: the file was not finished".to_owned()),
        };
        self.outcome = None;
        Some(news)
    }
}

/// Writes a file whole or not at all.
fn write(path: &Path, scene: &CompiledScene, state: &SavedWorld) -> std::io::Result<()> {
    let part = path.with_extension("json.part");
    let mut file = BufWriter::new(File::create(&part)?);
    serde_json::to_writer(&mut file, &Written { format: FORMAT, scene: scene.def(), state })?;
    file.flush()?;
    std::fs::rename(part, path)
}
