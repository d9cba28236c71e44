//! Output files and folders, kept apart from the input files of the same command.

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

/// Makes a folder, which must be new: another program may use an empty one.
pub(crate) fn new_folder(folder: &Path) -> Result<(), Failure> {
    std::fs::create_dir(folder).map_err(|error| failed(folder, error))
}

/// Makes a folder and fills it. Leaves nothing if that fails.
pub(crate) fn fill_new_folder<T>(folder: &Path, fill: impl FnOnce() -> Result<T, Failure>) -> Result<T, Failure> {
    new_folder(folder)?;
    let filled = fill();
    if filled.is_err() {
        let _ = std::fs::remove_dir_all(folder);
    }
    filled
}

/// Writes a file.
pub(crate) fn write(path: &Path, content: &[u8]) -> Result<(), Failure> {
    std::fs::write(path, content).map_err(|error| failed(path, error))
}

/// Returns the failure of a file or folder that cannot be written.
pub(crate) fn failed(path: &Path, error: std::io::Error) -> Failure {
    Failure::new(exit::FAILURE, format_args!("{}: {error}", path.display()))
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
