//! Experiments and claims of the thesis: the files under `experiments/thesis`, embedded in the program.

use include_dir::{Dir, include_dir};

use crate::claim::Claim;
use crate::plan::{Plan, Run};

static FILES: Dir = include_dir!("$CARGO_MANIFEST_DIR/../../experiments/thesis");

/// File with the claims of the thesis.
const CLAIMS: &str = "claims.toml";

/// Returns name and text of every experiment file, sorted by name.
pub fn files() -> Vec<(String, &'static str)> {
    let mut files = toml_files(&FILES);
    files.retain(|(name, _)| name != CLAIMS);
    files
}

/// Returns name and text of every TOML file of a folder, sorted by name.
pub(crate) fn toml_files(folder: &'static Dir) -> Vec<(String, &'static str)> {
    let name = |file: &'static include_dir::File| file.path().to_str().filter(|name| name.ends_with(".toml"));
    let mut files: Vec<_> =
        folder.files().filter_map(|file| Some((name(file)?.to_owned(), file.contents_utf8()?))).collect();
    files.sort();
    files
}

/// Returns the text of the file with the claims of the thesis.
pub fn claims() -> &'static str {
    FILES.get_file(CLAIMS).and_then(|file| file.contents_utf8()).unwrap_or_default()
}

/// Keeps the runs of a plan that its plots and the claims need at least: a sample of each setting that they show, and all samples where a
/// plot or claim tells samples apart.
pub fn keep_needed(plan: &mut Plan, claims: &[Claim]) {
    let plots = std::mem::take(&mut plan.plots);
    let name = plan.name.clone();
    let is_needed = |run: &Run| {
        let of_plots = plots
            .iter()
            .any(|plot| plot.shows(|name| run.label(name)) && (run.sample == 1 || plot.tells_samples_apart()));
        let mut of_claims = claims.iter().filter(|claim| claim.measures(&name, run));
        of_plots || of_claims.any(|claim| run.sample == 1 || claim.tells_samples_apart())
    };
    plan.keep(is_needed);
    plan.plots = plots;
}
