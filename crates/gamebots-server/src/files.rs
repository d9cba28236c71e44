//! Names of files that replace none.

use std::path::{Path, PathBuf};

/// Returns the path itself as the first, then `run-2.mcap`, `run-3.mcap` .. for `run.mcap`.
pub(crate) fn numbered(name: &Path, number: u32) -> PathBuf {
    let part = |part: Option<&std::ffi::OsStr>| part.unwrap_or_default().to_string_lossy().into_owned();
    let (stem, extension) = (part(name.file_stem()), part(name.extension()));
    if number == 1 { name.to_owned() } else { name.with_file_name(format!("{stem}-{number}.{extension}")) }
}

/// True if a file of this name would replace something. Devices and pipes keep nothing; a dangling link belongs to somebody.
pub(crate) fn is_kept(path: &Path) -> bool {
    match std::fs::metadata(path) {
        Ok(found) => found.is_file(),
        Err(_) => path.is_symlink(),
    }
}
