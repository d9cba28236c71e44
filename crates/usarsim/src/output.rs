//! Output files, kept apart from the input files of the same command.

use std::path::{Path, PathBuf};

use crate::{Failure, exit};

/// Refuses an output file that is one of the input files, by the same path, a symbolic link or a hard link.
///
/// A command opens its output after reading its input, so it would silently replace the input.
pub(crate) fn keep_inputs(out: &Path, inputs: &[impl AsRef<Path>]) -> Result<(), Failure> {
    let mut inputs = inputs.iter().map(AsRef::as_ref);
    let Some(input) = inputs.find(|input| is_same_file(out, input)) else { return Ok(()) };
    let (out, input) = (out.display(), input.display());
    let message =
        format!("the output {out} is the input file {input}, which would be lost: choose another output file");
    Err(Failure::new(exit::USAGE, message))
}

/// Returns the files from which a robot or map given as `NAME|FILE` may be read: the path itself, or a definition in that folder.
pub(crate) fn definition_files(given: &str) -> [PathBuf; 3] {
    let path = Path::new(given);
    [path.to_owned(), path.join("robot.toml"), path.join("map.toml")]
}

/// True if both paths lead to one regular file. Devices store nothing, so one may be both read and written.
#[cfg(unix)]
fn is_same_file(a: &Path, b: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let identity = |path| std::fs::metadata(path).ok().filter(|it| it.is_file()).map(|it| (it.dev(), it.ino()));
    identity(a).is_some_and(|a| identity(b) == Some(a))
}

/// True if both paths lead to one regular file. Hard links are not recognised.
#[cfg(not(unix))]
fn is_same_file(a: &Path, b: &Path) -> bool {
    let place = |path: &Path| path.canonicalize().ok().filter(|path| path.is_file());
    place(a).is_some_and(|a| place(b) == Some(a))
}
