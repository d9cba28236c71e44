//! Experiments and claims of the thesis: the files under `experiments/thesis`, embedded in the program.

use include_dir::{Dir, include_dir};

static FILES: Dir = include_dir!("$CARGO_MANIFEST_DIR/../../experiments/thesis");

/// File with the claims of the thesis.
const CLAIMS: &str = "claims.toml";

/// Returns name and text of every experiment file, sorted by name.
pub fn files() -> Vec<(String, &'static str)> {
    let name = |file: &'static include_dir::File| {
        file.path().to_str().filter(|name| name.ends_with(".toml") && *name != CLAIMS)
    };
    let mut files: Vec<_> =
        FILES.files().filter_map(|file| Some((name(file)?.to_owned(), file.contents_utf8()?))).collect();
    files.sort();
    files
}

/// Returns the text of the file with the claims of the thesis.
pub fn claims() -> &'static str {
    FILES.get_file(CLAIMS).and_then(|file| file.contents_utf8()).unwrap_or_default()
}
