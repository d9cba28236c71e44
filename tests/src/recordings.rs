//! Recorded streams of real controllers. They are not part of this repository: `USARSIM_CAPTURES` names their folder.

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde_json::Value;

/// Reads every recording by name: the events of its clients in order.
///
/// # Panics
/// If there are none, or they cannot be read.
pub fn recordings() -> BTreeMap<String, Vec<Value>> {
    let folder = folder().join("clients");
    let files = std::fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut recordings = BTreeMap::new();
    for path in files.filter_map(|file| file.ok()).map(|file| file.path()) {
        let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let event = |line| serde_json::from_str(line).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        recordings.insert(name, text.lines().map(event).collect());
    }
    assert!(!recordings.is_empty(), "{} has no recordings", folder.display());
    recordings
}

/// Reads the lines that a genuine server of 2011 sent. Its client cut off the end of every scan, so a scan ends here with its last whole
/// range.
///
/// # Panics
/// If they cannot be read.
pub fn server_lines() -> Vec<String> {
    let path = folder().join("usarsim-2011-server.txt");
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let mended = |line: &str| match line.rsplit_once(',') {
        Some((whole, _)) if !line.ends_with('}') => format!("{whole}}}"),
        _ => line.to_owned(),
    };
    text.lines().map(|line| mended(line.trim_end())).filter(|line| line.ends_with('}')).collect()
}

fn folder() -> PathBuf {
    let folder = std::env::var_os("USARSIM_CAPTURES");
    PathBuf::from(folder.expect("USARSIM_CAPTURES names no folder: expected that of the recordings"))
}
