//! Circles of files: no file uses another that uses it in turn, through others or not. Rust and TypeScript.
//!
//! A file may name what the modules around it define, and a crate's root: it is a part of them. Tests inside a file do not count.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use regex::Regex;

use crate::invariants::{files, repository, text};

/// Comments, texts and letters of Rust.
static NO_CODE: LazyLock<Regex> =
    LazyLock::new(|| pattern(r##"(?s)//[^\n]*|r#".*?"#|r"[^"]*"|"(?:\\.|[^"\\])*"|'(?:\\[^']+|[^'\\])'"##));
static TESTS: LazyLock<Regex> = LazyLock::new(|| pattern(r"#\[cfg\(test\)\]\s*mod \w+ *\{"));
static IMPORT: LazyLock<Regex> = LazyLock::new(|| pattern(r"(pub(?:\([^)]*\))?\s+)?\buse\s+([^;]+);"));

fn pattern(text: &str) -> Regex {
    Regex::new(text).unwrap_or_else(|error| panic!("{error}"))
}

/// Files, each with those that it uses.
type Uses = BTreeMap<PathBuf, BTreeSet<PathBuf>>;
/// A module by its path from the root of its crate.
type Module = Vec<String>;

/// A file of a crate, without comments, texts and tests.
struct Source {
    file: PathBuf,
    /// Paths that it imports, each with the name that it gives it, and true if it hands that on.
    imports: Vec<(Module, String, bool)>,
    code: String,
}

#[test]
fn no_files_use_each_other_in_a_circle() {
    let root = repository();
    let mut uses = typescript(&root.join("viewer/src"));
    let crates = std::fs::read_dir(root.join("crates")).expect("crates");
    for folder in crates.map(|entry| entry.expect("a crate").path().join("src")) {
        uses.extend(rust(&folder));
    }
    assert!(uses.len() > 500, "{} files", uses.len());
    let shown = |path: &&PathBuf| path.strip_prefix(&root).unwrap_or(path).display().to_string();
    let circles = circles(&uses);
    let circles: Vec<String> =
        circles.iter().map(|files| files.iter().map(shown).collect::<Vec<_>>().join("\n  ")).collect();
    assert!(circles.is_empty(), "{} circles:\n  {}", circles.len(), circles.join("\n\n  "));
}

#[test]
fn a_circle_of_files_is_found() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        std::fs::write(path, text).expect("a file");
    };
    write("lib.rs", "mod a;\nmod b;\nmod c;\npub use a::A;\n");
    write("a.rs", "use crate::{b::{self, B}, Root};\npub struct A(B);\n");
    write("b.rs", "// use crate::a::A;\npub struct B;\n#[cfg(test)]\nmod tests { use crate::a::A; }\n");
    write("c.rs", "mod inner;\npub fn make() -> crate::b::B { inner::make() }\n");
    write("c/inner.rs", "use super::make as outer;\nuse crate::a::A;\n");
    let names = || {
        let uses = rust(folder.path());
        let circles = circles(&uses);
        let name = |path: &&PathBuf| path.file_name().expect("a name").to_string_lossy().into_owned();
        circles.iter().map(|circle| circle.iter().map(name).collect::<Vec<_>>()).collect::<Vec<_>>()
    };
    assert_eq!(names(), Vec::<Vec<String>>::new());
    // Through a path in the code, and through what a module hands on.
    write("c.rs", "mod inner;\npub use inner::Handed;\npub fn make() -> crate::b::B { inner::make() }\n");
    write("b.rs", "pub struct B;\nfn f() { let _ = \"\\\"\"; crate::c::Handed::new() }\n");
    assert_eq!(names(), [["a.rs", "b.rs", "inner.rs"]]);
}

/// Returns the groups of files that use each other, those of one file left out.
fn circles(uses: &Uses) -> Vec<BTreeSet<&PathBuf>> {
    let reachable = |from: &PathBuf| {
        let (mut found, mut open) = (BTreeSet::new(), vec![from.clone()]);
        while let Some(file) = open.pop() {
            for next in uses.get(&file).into_iter().flatten() {
                if found.insert(next.clone()) {
                    open.push(next.clone());
                }
            }
        }
        found
    };
    let reached: BTreeMap<&PathBuf, BTreeSet<PathBuf>> = uses.keys().map(|file| (file, reachable(file))).collect();
    let both = |one: &PathBuf, other: &PathBuf| reached[one].contains(other) && reached[other].contains(one);
    let mut circles: BTreeSet<BTreeSet<&PathBuf>> = BTreeSet::new();
    for one in uses.keys().filter(|file| reached[file].contains(*file)) {
        circles.insert(uses.keys().filter(|other| both(one, other)).collect());
    }
    circles.into_iter().collect()
}

fn typescript(folder: &Path) -> Uses {
    let import = pattern(r"from '(\.[^']*)'");
    let mut uses = Uses::new();
    for file in files(folder, &["ts"]) {
        let text = text(&file);
        let found = import.captures_iter(&text).filter_map(|found| {
            let path = file.parent()?.join(&found[1]);
            let candidates = [format!("{}.ts", path.display()), format!("{}/index.ts", path.display())];
            candidates.iter().find_map(|path| std::fs::canonicalize(path).ok())
        });
        let found = found.collect();
        uses.insert(std::fs::canonicalize(&file).expect("a file"), found);
    }
    uses
}

fn rust(folder: &Path) -> Uses {
    let sources: BTreeMap<Module, Source> =
        files(folder, &["rs"]).into_iter().map(|file| (module_of(folder, &file), Source::read(file))).collect();
    let path = pattern(r"\b([a-z_]\w*)((?:::\w+)+)");
    let mut uses = Uses::new();
    for (module, source) in &sources {
        let mut used: Vec<Module> = Vec::new();
        let mut names: BTreeMap<&str, Module> = BTreeMap::new();
        for (path, name, is_handed_on) in &source.imports {
            let Some(path) = from_root(&sources, module, path, &BTreeMap::new()) else { continue };
            names.insert(name, path.clone());
            if !is_handed_on {
                used.push(path);
            }
        }
        for found in path.captures_iter(&source.code) {
            let parts: Module = found[0].split("::").map(str::to_owned).collect();
            used.extend(from_root(&sources, module, &parts, &names));
        }
        let defining = used.iter().map(|path| defining(&sources, path, 0));
        let others = defining.filter(|it| it != module && !module.starts_with(it));
        let files = others.filter_map(|it| Some(sources.get(&it)?.file.clone())).collect();
        uses.insert(source.file.clone(), files);
    }
    uses
}

/// Returns the path of a module from the root of its crate.
fn module_of(folder: &Path, file: &Path) -> Module {
    let path = file.strip_prefix(folder).expect("a file in the folder").with_extension("");
    let mut parts: Module = path.iter().map(|part| part.to_string_lossy().into_owned()).collect();
    parts.pop_if(|last| ["lib", "main", "mod"].contains(&last.as_str()));
    parts
}

/// Returns a path of a file from the root of its crate; `None` if it leads to another crate. `names` are those that the file imports.
fn from_root(
    sources: &BTreeMap<Module, Source>,
    module: &[String],
    path: &[String],
    names: &BTreeMap<&str, Module>,
) -> Option<Module> {
    let (first, rest) = path.split_first()?;
    let child = [module, std::slice::from_ref(first)].concat();
    match first.as_str() {
        "crate" => Some(rest.to_vec()),
        "self" => Some([module, rest].concat()),
        "super" => {
            let ups = path.iter().take_while(|part| *part == "super").count();
            Some([&module[..module.len().saturating_sub(ups)], &path[ups..]].concat())
        }
        _ if sources.contains_key(&child) => Some([module, path].concat()),
        name => names.get(name).map(|named| [named, rest].concat()),
    }
}

/// Returns the module that defines what a path names. What a module hands on is defined elsewhere; a crate's root is taken for all that it
/// hands on.
fn defining(sources: &BTreeMap<Module, Source>, path: &[String], depth: usize) -> Module {
    let mut module = Module::new();
    for (place, part) in path.iter().enumerate() {
        let next = [&module[..], std::slice::from_ref(part)].concat();
        if sources.contains_key(&next) {
            module = next;
            continue;
        }
        let handed = sources.get(&module).into_iter().flat_map(|source| &source.imports);
        let handed =
            handed.filter(|(_, name, is_handed_on)| *is_handed_on && name == part).map(|(path, ..)| path).next();
        let handed = handed.and_then(|path| from_root(sources, &module, path, &BTreeMap::new()));
        return match handed {
            Some(to) if !module.is_empty() && depth < 8 => {
                defining(sources, &[&to[..], &path[place + 1..]].concat(), depth + 1)
            }
            _ => module,
        };
    }
    module
}

impl Source {
    fn read(file: PathBuf) -> Self {
        let code = NO_CODE.replace_all(&text(&file), " ").into_owned();
        let code = TESTS.split(&code).next().unwrap_or_default().to_owned();
        let mut imports = Vec::new();
        for found in IMPORT.captures_iter(&code) {
            imported(&found[2], &[], found.get(1).is_some(), &mut imports);
        }
        let code = IMPORT.replace_all(&code, " ").into_owned();
        Self { file, imports, code }
    }
}

/// Collects the paths of an import: `a::{b, c::d as e}`.
fn imported(tree: &str, before: &[String], is_handed_on: bool, found: &mut Vec<(Module, String, bool)>) {
    let parts = |path: &str| {
        let parts =
            path.split("::").map(str::trim).filter(|part| !part.is_empty() && *part != "self" || path == "self");
        [before, &parts.map(str::to_owned).collect::<Vec<_>>()].concat()
    };
    let tree = tree.trim();
    if let Some((path, list)) = tree.split_once('{') {
        let (before, mut depth) = (parts(path), 0);
        let list = list.trim_end().strip_suffix('}').unwrap_or(list);
        let items = list.split(|letter: char| {
            depth += i32::from(letter == '{') - i32::from(letter == '}');
            letter == ',' && depth == 0
        });
        for item in items.filter(|item| !item.trim().is_empty()) {
            imported(item, &before, is_handed_on, found);
        }
        return;
    }
    let (path, alias) = tree.split_once(" as ").unwrap_or((tree, ""));
    let path = if path == "self" { before.to_vec() } else { parts(path) };
    let name = if alias.is_empty() { path.last().cloned().unwrap_or_default() } else { alias.trim().to_owned() };
    found.push((path, name, is_handed_on));
}
