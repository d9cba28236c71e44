//! Logs, whole and damaged.

use std::path::Path;

use recorder::{Log, Table, export};

/// Longest run that is replayed, simulated seconds.
const MAX_SECONDS: f64 = 0.3;

/// An MCAP file: read, replayed, exported, and recovered. What was recovered has at least what was read.
pub fn log(bytes: &[u8]) {
    let folder = tempfile::tempdir().expect("a folder for files");
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("run.mcap"), bytes).expect("a file is written");
    let log = recorder::read(&path("run.mcap"));
    if let Ok(log) = &log {
        use_log(log, folder.path());
    }
    let recovered = recorder::recover(&path("run.mcap"), &path("recovered.mcap"));
    if let (Ok(log), Ok(_)) = (&log, &recovered)
        && !log.entries.is_empty()
    {
        let again = recorder::read(&path("recovered.mcap")).expect("a recovered log can be read");
        assert!(again.entries.len() >= log.entries.len(), "recovering lost records");
    }
}

fn use_log(log: &Log, folder: &Path) {
    let table = Table::of(log, None);
    assert_eq!((table.to_csv().count(), table.to_tum().count()), (table.rows() + 1, table.rows()));
    // Whether a disk takes it is not the question.
    let _ = export::parquet(&table, &folder.join("states.parquet"));
    let _ = export::ros2(log, &folder.join("run.ros2.mcap"));
    let end = log.end.get("seconds").and_then(|seconds| seconds.parse().ok());
    let last = log.entries.iter().map(|entry| entry.time).chain(end).fold(0.0, f64::max);
    if last <= MAX_SECONDS {
        let _ = logbook::replay(log);
    }
}
