//! The measured numbers in README.md and docs/*.md are those that the program gives, with robots and maps as shipped.
//!
//! They stand between `<!-- figures: NAME -->` and `<!-- end -->`. `cargo test` recomputes and compares them, apart from values that differ
//! between machines: times, sizes of logs, memory. With `UPDATE_FIGURES=1` it writes the results. In a release build, as in `make figures`,
//! it also measures those values. A debug build leaves out figures that take minutes; `make release` compares them.

#![expect(clippy::unwrap_used, reason = "helpers of tests")]

#[path = "../../benches/budget.rs"]
#[expect(dead_code, reason = "its main is that of `cargo bench`")]
mod budget;
mod gallery;
mod makers;
mod reference;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::thread;

use regex::{Captures, Regex};

/// Placeholder of a number that was not measured.
const UNTIMED: &str = "~";

/// Makes the text of a figure. With `true` it also measures times.
type Maker = fn(bool) -> String;

const FIGURES: [(&str, Maker); 25] = [
    ("gallery", |_| gallery::chapters()),
    ("reference-robots", |_| reference::robots()),
    ("reference-actuators", |_| reference::actuators()),
    ("reference-sensors", |_| reference::sensors()),
    ("reference-commands", |_| reference::commands()),
    ("reference-maps", |_| reference::maps()),
    ("reference-materials", |_| reference::materials()),
    ("reference-objects", |_| reference::objects()),
    ("messages", |_| makers::messages()),
    ("session", |_| makers::session()),
    ("motion", |_| makers::motion()),
    ("drive-models", makers::drive_models),
    ("robots", makers::robots),
    ("threads", makers::threads),
    ("far", |_| makers::far()),
    ("cost", |timed| makers::cost(timed, &["start", "drive", "listen"])),
    ("cost-of-logs", |timed| makers::cost(timed, &["log"])),
    ("cost-of-viewers", |timed| makers::cost(timed, &["watch"])),
    ("heaps", |timed| makers::cost(timed, &["heap"])),
    ("kinematics", |_| makers::kinematics()),
    ("sliding", |_| makers::sliding()),
    ("real-robots", |_| makers::real_robots()),
    ("thesis", |_| makers::thesis()),
    ("thesis-runs", |_| makers::thesis_runs()),
    ("thesis-needed", |_| makers::thesis_needed()),
];

/// Figures of the engine's bodies, which take minutes. `cargo test` compares the same models elsewhere: `rollers`, `validation`, `golden`.
const LONG: [&str; 3] = ["drive-models", "far", "thesis"];

#[test]
fn figures_in_the_documents_are_those_that_the_program_gives() {
    let update = std::env::var_os("UPDATE_FIGURES").is_some();
    let is_release = !cfg!(debug_assertions);
    let is_made = |name: &str| update || is_release || !LONG.contains(&name);
    let mut made = make(is_made, update && is_release);
    let block = Regex::new("(?s)(<!-- figures: ([a-z-]+) -->)(.*?)(<!-- end -->)").unwrap();
    let mut wrong = String::new();
    for path in documents() {
        let shown = path.file_name().unwrap().display();
        let old = fs::read_to_string(&path).unwrap();
        let new = block.replace_all(&old, |found: &Captures| {
            let [start, name, old, end] = [1, 2, 3, 4].map(|group| &found[group]);
            if !is_made(name) {
                return found[0].to_owned();
            }
            let made =
                made.remove(name).unwrap_or_else(|| panic!("{shown}: nobody makes `{name}`, or it stands twice"));
            let new: Vec<String> = made.split('\n').map(|line| with_old_times(line, old)).collect();
            let new = new.join("\n");
            if new != old || new.contains(UNTIMED) {
                wrong += &format!("{shown}, {name}:\n{}", difference(old, &new));
            }
            format!("{start}{new}{end}")
        });
        if update && new != old {
            fs::write(&path, new.as_ref()).unwrap();
        }
    }
    assert!(made.is_empty(), "in no document: {:?}", made.keys());
    assert!(update || wrong.is_empty(), "not what the program gives (`make figures` renews them):\n{wrong}");
}

/// Makes the wanted figures, in parallel unless times are measured.
fn make(is_wanted: impl Fn(&str) -> bool, timed: bool) -> BTreeMap<&'static str, String> {
    let wanted = FIGURES.into_iter().filter(|(name, _)| is_wanted(name));
    if timed {
        return wanted.map(|(name, make)| (name, make(true))).collect();
    }
    thread::scope(|scope| {
        let makers: Vec<_> = wanted.map(|(name, make)| (name, scope.spawn(move || make(false)))).collect();
        makers.into_iter().map(|(name, maker)| (name, maker.join().unwrap())).collect()
    })
}

/// Returns a row whose unmeasured values are taken from the old row with the same start.
fn with_old_times(new: &str, old: &str) -> String {
    let old = new.split_once(UNTIMED).and_then(|(label, _)| old.lines().find(|line| line.starts_with(label)));
    let Some(old) = old else { return new.to_owned() };
    let cells = new.split('|').zip(old.split('|'));
    cells.map(|(new, old)| if new.trim() == UNTIMED { old } else { new }).collect::<Vec<_>>().join("|")
}

fn difference(old: &str, new: &str) -> String {
    let only = |sign: char, these: &str, those: &str| -> String {
        these
            .lines()
            .filter(|line| !those.lines().any(|other| other == *line))
            .map(|line| format!("{sign} {line}\n"))
            .collect()
    };
    only('-', old, new) + &only('+', new, old)
}

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn documents() -> Vec<PathBuf> {
    let pages = fs::read_dir(repository().join("docs")).unwrap().map(|entry| entry.unwrap().path());
    let pages = pages.filter(|path| path.extension().is_some_and(|end| end == "md"));
    pages.chain([repository().join("README.md")]).collect()
}
