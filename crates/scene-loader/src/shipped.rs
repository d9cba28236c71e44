//! Robots, maps, equipment and materials embedded in the program, by their names.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use include_dir::{Dir, include_dir};
use names::{did_you_mean, listed};

use crate::LoadError;
use crate::materials::{self, Materials};
use crate::overrides::{self, Override};
use crate::problem::Problems;
use crate::source::Source;

pub(crate) static ASSETS: Dir = include_dir!("$CARGO_MANIFEST_DIR/../../assets");
pub(crate) static SCENARIOS: Dir = include_dir!("$CARGO_MANIFEST_DIR/../../scenarios");
pub(crate) static MAPS: Dir = include_dir!("$CARGO_MANIFEST_DIR/../../maps");

/// Returns the names of the embedded maps.
pub fn map_names() -> Vec<String> {
    folders(&MAPS)
}

/// Returns the description of an embedded map, without reading the rest of it. `None` if there is no map of that name.
pub fn map_description(name: &str) -> Option<String> {
    #[derive(serde::Deserialize)]
    struct Head {
        description: String,
    }
    let text = Source::BuiltIn(MAPS.get_dir(name)?).text("map.toml").ok()?;
    // It stands before the tables.
    let head = text.split("\n[").next()?;
    toml::from_str(head).ok().map(|Head { description }| description)
}

/// Names of the embedded robot classes, each with its folder. A class may have several names.
static ROBOTS: LazyLock<BTreeMap<String, &Dir>> = LazyLock::new(|| {
    let folders = ASSETS.get_dir("robots").into_iter().flat_map(Dir::dirs);
    let of_folder = |dir: &'static Dir| {
        let text = Source::BuiltIn(dir).text("robot.toml").unwrap_or_default();
        folder_name(dir).into_iter().chain(further_names(&text)).map(move |name| (name, dir))
    };
    folders.flat_map(of_folder).collect()
});

/// Returns the names of the embedded robot classes.
pub fn robot_names() -> Vec<String> {
    ROBOTS.keys().cloned().collect()
}

/// Returns the embedded robots by the names of their folders, in any case, each with its further names.
pub fn robot_folders() -> Vec<(String, Vec<String>)> {
    let mut folders: BTreeMap<String, (String, Vec<String>)> = BTreeMap::new();
    for (name, dir) in ROBOTS.iter() {
        let folder = folder_name(dir).unwrap_or_else(|| name.clone());
        let (_, further) = folders.entry(folder.to_ascii_lowercase()).or_insert((folder.clone(), Vec::new()));
        further.extend(Some(name.clone()).filter(|name| *name != folder));
    }
    folders.into_values().collect()
}

/// Returns the names of the embedded actuators.
pub(crate) fn actuator_names() -> Vec<String> {
    ASSETS.get_dir("actuators").map_or_else(Vec::new, folders)
}

/// Returns the names of the embedded sets of equipment.
pub(crate) fn equipment_names() -> Vec<String> {
    let files = ASSETS.get_dir("equipment").into_iter().flat_map(Dir::files);
    files.filter_map(|file| Some(file.path().file_stem()?.to_string_lossy().into_owned())).collect()
}

/// Returns the folder and the file of an embedded set of equipment, by its name in any case.
pub(crate) fn equipment_file(name: &str) -> Option<(Source, String)> {
    let known = equipment_names().into_iter().find(|known| known.eq_ignore_ascii_case(name))?;
    Some((Source::BuiltIn(ASSETS.get_dir("equipment")?), format!("{known}.toml")))
}

/// Returns the names that a robot.toml has besides that of its folder. A text with a mistake has none; its reader reports it.
pub(crate) fn further_names(text: &str) -> Vec<String> {
    #[derive(serde::Deserialize)]
    struct Names {
        #[serde(default)]
        names: Vec<String>,
    }
    if !text.contains("names") {
        return Vec::new();
    }
    toml::from_str::<Names>(text).map_or_else(|_| Vec::new(), |it| it.names)
}

/// True if an embedded class is like another one.
pub(crate) fn is_like_another(name: &str) -> bool {
    let text = ROBOTS.get(name).map(|dir| Source::BuiltIn(dir).text("robot.toml").unwrap_or_default());
    text.is_some_and(|text| text.lines().any(|line| line.starts_with("like = ")))
}

/// Name and contents of an embedded file.
pub type File = (String, &'static [u8]);

/// Returns the files of an embedded map: `map.toml` and its meshes.
///
/// # Errors
/// When the name is unknown.
pub fn map_files(name: &str) -> Result<Vec<File>, LoadError> {
    MAPS.get_dir(name).map(files).ok_or_else(|| unknown("map", name, &map_names()))
}

/// Returns the folder of an embedded map that has a league.
pub(crate) fn league_of_map(name: &str) -> Option<Source> {
    let folder = Source::BuiltIn(MAPS.get_dir(name)?);
    folder.has("league.toml").then_some(folder)
}

/// Returns the files of an embedded robot class, in any case: `robot.toml`, its URDF and meshes.
///
/// # Errors
/// When the name is unknown.
pub fn robot_files(name: &str) -> Result<Vec<File>, LoadError> {
    built_in_robot(name).map(|(_, dir)| files(dir)).ok_or_else(|| unknown("robot", name, &robot_names()))
}

pub(crate) fn built_in_materials(overrides: &[Override]) -> Result<Materials, LoadError> {
    let source = Source::BuiltIn(&ASSETS);
    let mut problems = Problems::default();
    let text = overrides::apply(source.text("materials.toml")?, overrides, &["material"], &[]);
    let materials = materials::read("assets/materials.toml", &text, &mut problems);
    problems.into_result(materials)
}

/// Returns an embedded class, by its name in any case, and its folder.
pub(crate) fn built_in_robot(name: &str) -> Option<(String, &'static Dir<'static>)> {
    let (class, folder) = ROBOTS.iter().find(|(known, _)| known.eq_ignore_ascii_case(name))?;
    Some((class.clone(), folder))
}

fn files(dir: &'static Dir) -> Vec<File> {
    let file = |file: &'static include_dir::File| {
        Some((file.path().file_name()?.to_string_lossy().into_owned(), file.contents()))
    };
    dir.files().filter_map(file).collect()
}

pub(crate) fn folders(dir: &'static Dir) -> Vec<String> {
    let mut names: Vec<String> = dir.dirs().filter_map(folder_name).collect();
    names.sort();
    names
}

pub(crate) fn folder_name(dir: &Dir) -> Option<String> {
    dir.path().file_name().map(|name| name.to_string_lossy().into_owned())
}

/// Returns the error of an unknown name: with the nearest known name alone, if one is near.
pub(crate) fn unknown(kind: &'static str, got: &str, names: &[String]) -> LoadError {
    let known = || names.iter().map(String::as_str);
    let suggestion = did_you_mean(got, known());
    let is_listed = ["robot", "map", "scenario"].contains(&kind);
    let expected = match suggestion.as_str() {
        "" => listed(known()),
        _ if is_listed => format!("those that `usarsim {kind}s` lists"),
        _ => listed(known()),
    };
    LoadError::UnknownName { kind, got: got.to_owned(), suggestion, expected }
}
