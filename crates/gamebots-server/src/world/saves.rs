//! Files of saved worlds: the scene and the state of a world at the end of a step, as JSON.

use std::fs::File;
use std::io::{BufReader, BufWriter, Read, Write};
use std::path::Path;

use scene::WorldDef;
use serde::{Deserialize, Serialize};
use sim_core::{CompiledScene, SavedWorld};

/// The newest format, which is written.
const FORMAT: u32 = 1;
/// Largest file that is read, bytes: a map of 500 000 triangles and 256 robots.
const MAX_BYTES: u64 = 256 * 1024 * 1024;

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

/// Writes a file whole or not at all.
pub(crate) fn write(path: &Path, scene: &CompiledScene, state: &SavedWorld) -> std::io::Result<()> {
    let part = path.with_extension("json.part");
    let mut file = BufWriter::new(File::create(&part)?);
    serde_json::to_writer(&mut file, &Written { format: FORMAT, scene: scene.def(), state })?;
    file.flush()?;
    std::fs::rename(part, path)
}
