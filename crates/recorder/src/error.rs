//! The error of a log that cannot be written.

use std::path::Path;

/// A log that cannot be written.
#[derive(Debug, thiserror::Error)]
#[error("log {file}: {reason}")]
pub struct RecordError {
    file: String,
    reason: String,
}

impl RecordError {
    /// Creates the error of a file that the operating system refuses.
    pub fn new(file: &Path, reason: &std::io::Error) -> Self {
        Self { file: file.display().to_string(), reason: reason.to_string() }
    }
}

/// Creates an error, with the operating system's reason if that is the cause.
pub(crate) fn refused(file: impl AsRef<Path>, reason: impl Into<Box<dyn std::error::Error>>) -> RecordError {
    let reason = reason.into();
    let cause = reason.source().map(ToString::to_string);
    RecordError { file: file.as_ref().display().to_string(), reason: cause.unwrap_or_else(|| reason.to_string()) }
}
