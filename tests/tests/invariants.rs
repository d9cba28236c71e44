//! Invariants of ARCHITECTURE.md: the things that must be absent are absent.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

pub(crate) fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Returns every file in a folder, recursively, with one of the extensions.
pub(crate) fn files(folder: &Path, extensions: &[&str]) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display())) {
        let path = entry.expect("an entry").path();
        if path.is_dir() {
            found.extend(files(&path, extensions));
        } else if path.extension().is_some_and(|extension| extensions.iter().any(|known| extension == *known)) {
            found.push(path);
        }
    }
    found
}

pub(crate) fn text(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

const PURE: [&str; 8] =
    ["articulated", "base-motion", "friction", "gamebots-proto", "goals", "kinematics", "scene", "sim-core"];

/// Runs `cargo tree` with these arguments and prints it as a list.
fn cargo_tree(arguments: &[&str]) -> String {
    let output = Command::new(std::env::var("CARGO").unwrap_or_else(|_| "cargo".to_owned()))
        .args(["tree", "--offline", "--prefix", "none"])
        .args(arguments)
        .current_dir(repository())
        .output()
        .expect("cargo tree runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Returns the dependencies as a list. Negating an inverted tree would count a dev-dependency as a dependency.
fn dependencies(package: &str) -> String {
    let tree = cargo_tree(&["--package", package, "--edges", "normal"]);
    assert!(tree.starts_with(package), "{tree}");
    tree
}

/// Otherwise the program or the Python package would be compiled a second time after the tests, with all that knows the crate.
#[test]
fn tests_turn_on_no_features_of_what_the_program_and_the_python_package_need() {
    let features = |arguments: &[&str]| {
        let tree = cargo_tree(&[arguments, &["--format", "{p} [{f}]"]].concat());
        tree.lines().map(|line| line.trim_end_matches(" (*)").to_owned()).collect::<BTreeSet<_>>()
    };
    let tested = features(&["--workspace"]);
    for arguments in
        [["--workspace", "--edges", "normal,build"].as_slice(), &["-p", "usarsim-python", "-e", "normal,build"]]
    {
        let otherwise: Vec<_> = features(arguments).difference(&tested).cloned().collect();
        assert!(otherwise.is_empty(), "{arguments:?} has other features than the tests: {otherwise:#?}");
    }
}

#[test]
fn the_core_depends_on_no_runtime_and_no_file_format() {
    for package in PURE {
        let tree = dependencies(package);
        for absent in
            ["tokio", "mio", "tracing-subscriber", "toml", "mcap", "scene-loader", "recorder", "thread-pool", "rayon"]
        {
            assert!(!tree.lines().any(|line| line.starts_with(&format!("{absent} "))), "{package} depends on {absent}");
        }
    }
}

#[test]
fn who_reads_definitions_does_not_link_the_engine() {
    for package in ["scene", "scene-loader", "recorder", "picture"] {
        let tree = dependencies(package);
        for absent in ["rapier3d-f64", "sim-core"] {
            assert!(!tree.lines().any(|line| line.starts_with(&format!("{absent} "))), "{package} depends on {absent}");
        }
    }
}

#[test]
fn the_core_names_no_clock_file_socket_environment_or_thread() {
    let absent = ["std::time", "std::fs", "std::net", "std::env", "std::thread", "std::process", "HashMap", "HashSet"];
    for package in PURE {
        for path in files(&repository().join("crates").join(package).join("src"), &["rs"]) {
            let source = text(&path);
            for word in absent {
                assert!(!source.contains(word), "{} names {word}", path.display());
            }
        }
    }
}

/// The loop of a served world gets its clock, and hands long work to its caller. So it runs in a test, and in a browser.
#[test]
fn the_loop_of_a_served_world_names_no_clock_file_socket_environment_or_thread() {
    let absent =
        ["std::time", "std::fs", "std::env", "std::thread", "std::process", "Instant::now", "TcpStream", "HashMap"];
    for package in ["outbox", "page-protocol", "served-world", "sessions"] {
        for path in files(&repository().join("crates").join(package).join("src"), &["rs"]) {
            let source = text(&path);
            let code = source.split("#[cfg(test)]").next().unwrap_or_default();
            for word in absent {
                assert!(!code.contains(word), "{} names {word}", path.display());
            }
        }
    }
}

/// The standard library's sine has other last bits with glibc, musl and in WebAssembly. Square roots have the same everywhere.
#[test]
fn the_core_computes_elementary_functions_by_libm_alone() {
    let functions = [
        "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sin_cos", "sinh", "cosh", "tanh", "exp", "exp2",
        "exp_m1", "ln", "ln_1p", "log", "log2", "log10", "powf", "cbrt", "hypot",
    ];
    for package in PURE {
        for file in files(&repository().join("crates").join(package).join("src"), &["rs"]) {
            let text = text(&file);
            let code = text.split("#[cfg(test)]").next().unwrap_or_default();
            for (number, line) in code.lines().enumerate().filter(|(_, line)| !line.trim_start().starts_with("//")) {
                let calls = |name: &&&str| line.contains(&format!(".{name}(")) || names_path(line, name);
                let called = functions.iter().find(calls);
                assert!(called.is_none(), "{}:{}: {line}: call libm's", file.display(), number + 1);
            }
        }
    }
}

/// True if a line names a function by its path, as in `map(f64::tan)`.
fn names_path(line: &str, name: &str) -> bool {
    let path = format!("f64::{name}");
    line.split(&path).skip(1).any(|rest| !rest.starts_with(|next: char| next.is_alphanumeric() || next == '_'))
}

/// Links and footing decide what moves a robot.
#[test]
fn steering_decides_nothing_but_commands_and_their_answers() {
    for path in files(&repository().join("crates/sim-core/src"), &["rs"]) {
        let is_drive = path.ends_with("sim-core/src/drive.rs");
        assert!(is_drive || !text(&path).contains("Steering::"), "{} names a steering", path.display());
    }
}

#[test]
fn the_physics_engine_is_named_in_the_physics_module_alone() {
    for path in files(&repository().join("crates"), &["rs"]) {
        let shown = path.display().to_string();
        if shown.contains("sim-core/src/physics") {
            continue;
        }
        let code =
            text(&path).lines().filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join("\n");
        let is_hull = shown.ends_with("crates/scene/src/hull.rs");
        assert!(!code.contains("rapier"), "{shown} names the physics engine");
        assert!(is_hull || !code.contains("parry"), "{shown} names the engine's geometry");
    }
}

#[test]
fn the_two_mechanics_do_not_name_each_other() {
    let physics = repository().join("crates/sim-core/src/physics");
    for (own, other) in [("articulated", "bodies::"), ("bodies", "articulated::")] {
        let folder = physics.join(own);
        for path in files(&folder, &["rs"]).into_iter().chain([folder.with_extension("rs")]) {
            assert!(!text(&path).contains(other), "{} names {other}", path.display());
        }
    }
}

#[test]
fn paths_in_the_documents_exist() {
    let root = repository();
    for document in ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md"] {
        let content = text(&root.join(document));
        for word in content.split('`').skip(1).step_by(2) {
            let is_path =
                ["crates/", "assets/", "maps/", "tests/", "docs/", ".ci/"].iter().any(|top| word.starts_with(top));
            if is_path && !word.contains(['<', '*', ' ']) {
                assert!(root.join(word).exists(), "{document} names {word}, which does not exist");
            }
        }
    }
}

#[test]
fn nothing_is_left_undone_in_the_code() {
    for path in files(&repository().join("crates"), &["rs"]) {
        // A test that needs what is not part of this repository is run where it is: `.ci/run`.
        let source = text(&path).replace("#[ignore = \"needs ", "");
        for word in ["todo!(", "unimplemented!(", "#[ignore", "dbg!("] {
            assert!(!source.contains(word), "{} has {word}", path.display());
        }
    }
}

/// True if a line begins a doc comment with a word that leaves its noun or its verb for later.
fn begins_obliquely(before: &str, line: &str) -> bool {
    let doc = |line: &str| line.starts_with("///") || line.starts_with("//!");
    let (before, line) = (before.trim(), line.trim_start());
    let words = match line.strip_prefix("/**") {
        Some(words) => words,
        // The first line of several, in TypeScript.
        None if before == "/**" => line.trim_start_matches('*'),
        None if doc(line) && !doc(before) => &line[3..],
        None => return false,
    };
    let words = words.trim_start();
    ["Of ", "What ", "Who ", "Whose ", "Where ", "Whether ", "The same ", "By ", "Has ", "How ", "Which ", "Those "]
        .iter()
        .any(|word| words.starts_with(word))
}

#[test]
fn doc_comments_begin_with_a_noun_or_a_verb() {
    let mut oblique = Vec::new();
    for folder in ["crates", "tests", "fuzz", "viewer/src"] {
        for path in files(&repository().join(folder), &["rs", "ts"]) {
            let text = text(&path);
            let lines: Vec<&str> = text.lines().collect();
            let numbered = lines.iter().enumerate();
            oblique.extend(
                numbered
                    .filter(|&(number, line)| begins_obliquely(number.checked_sub(1).map_or("", |it| lines[it]), line))
                    .map(|(number, line)| format!("{}:{}: {}", path.display(), number + 1, line.trim())),
            );
        }
    }
    assert!(oblique.is_empty(), "{}", oblique.join("\n"));
}

#[test]
fn a_doc_comment_is_judged_by_its_first_line() {
    for (before, line, is_oblique) in [
        ("", "/// Of a wheel, rad/s.", true),
        ("fn it() {}", "    /// The same of the rear.", true),
        ("", "//! What the page shows.", true),
        ("", "    /// Has a fixed root.", true),
        ("/// The speed", "/// of a wheel. Of a caster, none.", false),
        ("/// The speed", "/// Of a wheel.", false),
        ("", "/// Offers a service.", false),
        ("", "// Of a wheel.", false),
        ("", "/// The samples.", false),
        ("", "  /** Whether it moves. */", true),
        ("  /**", "   * Which moment is shown:", true),
        ("   * A moment:", "   * Which is shown.", false),
        ("", "/** True if it moves. */", false),
    ] {
        assert_eq!(begins_obliquely(before, line), is_oblique, "{before} / {line}");
    }
}

/// Fields of a world, and the files below `world/` that use them, beside `saved.rs`, which saves them.
const FIELDS_OF_WORLD: [(&str, &[&str]); 19] = [
    ("scene", &["avatar.rs", "controller.rs"]),
    ("options", &["avatar.rs", "controller.rs", "report.rs"]),
    (
        "physics",
        &["actors.rs", "avatar.rs", "controller.rs", "held.rs", "pull.rs", "tools.rs", "vacuum.rs", "victims.rs"],
    ),
    ("is_engine_running", &[]),
    ("steps", &[]),
    ("robots", &["actors.rs", "controller.rs", "held.rs", "pull.rs", "tiles.rs", "victims.rs"]),
    ("next_id", &["tools.rs"]),
    ("controllers", &["actors.rs", "controller.rs"]),
    ("avatars", &["actors.rs", "avatar.rs"]),
    ("created", &["controller.rs"]),
    ("next_object", &["avatar.rs", "controller.rs", "tools.rs"]),
    ("pulls", &["pull.rs"]),
    ("attached", &["held.rs", "tools.rs", "vacuum.rs"]),
    ("engine_names", &["actors.rs", "avatar.rs"]),
    ("tiles", &["tiles.rs"]),
    ("single_view", &["tiles.rs"]),
    ("lost", &[]),
    ("restored", &[]),
    ("threads", &[]),
];

/// Every file below `world/` could reach every field: Rust keeps nothing from a module's children.
#[test]
fn a_field_of_the_world_is_used_by_the_few_files_that_need_it() {
    let source = repository().join("crates/sim-core/src");
    let world = text(&source.join("world.rs"));
    let (_, rest) = world.split_once("pub struct World {").expect("the struct");
    let (own, _) = rest.split_once("\n}").expect("its end");
    let field = |line: &str| line.strip_prefix("    ")?.split_once(": ").map(|(name, _)| name.to_owned());
    let fields: Vec<String> = own.lines().filter(|line| !line.contains("///")).filter_map(field).collect();
    assert_eq!(fields, FIELDS_OF_WORLD.map(|(name, _)| name));
    for (field, expected) in FIELDS_OF_WORLD {
        let mut found = Vec::new();
        for path in files(&source.join("world"), &["rs"]) {
            let code = text(&path);
            let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
            let uses = ["self.", "world."].iter().any(|owner| {
                code.match_indices(&format!("{owner}{field}")).any(|(start, it)| {
                    let before = code[..start].chars().next_back().is_none_or(|c| !c.is_alphanumeric() && c != '_');
                    let after = code[start + it.len()..].chars().next();
                    before && after.is_none_or(|c| !c.is_alphanumeric() && c != '_' && c != '(')
                })
            });
            if uses && name != "saved.rs" && code.contains("impl World") {
                found.push(name);
            }
        }
        found.sort();
        assert_eq!(found, expected, "`{field}`: another file uses it, or one no longer does");
    }
}
