//! The experiments of the thesis and what it says about them: the files under `experiments/thesis`, built into the program.

use include_dir::{Dir, include_dir};

static FILES: Dir = include_dir!("$CARGO_MANIFEST_DIR/../../experiments/thesis");

/// The file with what the thesis claims.
const CLAIMS: &str = "claims.toml";

/// Name and text of every experiment file, in the order of their names.
pub fn files() -> Vec<(String, &'static str)> {
    let name = |file: &'static include_dir::File| {
        file.path().to_str().filter(|name| name.ends_with(".toml") && *name != CLAIMS)
    };
    let mut files: Vec<_> =
        FILES.files().filter_map(|file| Some((name(file)?.to_owned(), file.contents_utf8()?))).collect();
    files.sort();
    files
}

/// What the thesis claims.
pub fn claims() -> &'static str {
    FILES.get_file(CLAIMS).and_then(|file| file.contents_utf8()).unwrap_or_default()
}
