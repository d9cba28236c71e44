//! Loading of worlds, maps and robots by their names or files.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use scene::{Classes, MapDef, Object, RobotDef, Setting, WorldDef};

use crate::equipment::Changes;
use crate::overrides::{self, Override};
use crate::problem::Problems;
use crate::robot::Others;
use crate::robot::of_urdf::{Known, OfUrdf};
use crate::shipped::{
    ASSETS, MAPS, actuator_names, built_in_materials, built_in_robot, folder_name, further_names, is_like_another,
    map_names, robot_names, unknown,
};
use crate::source::{MAX_TEXT, Source};
use crate::urdf::hints_at_mecanum;
use crate::{LoadError, map as map_file, robot as robot_file};

/// Loaders of the classes and actuators that a definition names.
pub(crate) const OTHERS: Others = Others { class: built_in_as, actuator };

/// Loads a world: a map, embedded or a file, all embedded robots, and those of further robot.toml files.
///
/// # Errors
/// Reports an unknown name, an unreadable file, or all problems of the files.
pub fn load(map_name: &str, robot_files: &[&Path]) -> Result<WorldDef, LoadError> {
    load_with(map_name, robot_files, &[])
}

/// Loads a world with overrides.
///
/// # Errors
/// As [`load`], and an override that is not used.
pub fn load_with(map_name: &str, robot_files: &[&Path], overrides: &[Override]) -> Result<WorldDef, LoadError> {
    load_equipped(map_name, robot_files, Changes::of(overrides))
}

/// Loads a world with overrides, and with equipment for its robots.
///
/// # Errors
/// As [`load_with`], and a class of the equipment that does not exist.
pub fn load_equipped(map_name: &str, robot_files: &[&Path], changes: Changes) -> Result<WorldDef, LoadError> {
    load_on(|| Ok(map(map_name, changes.overrides)?.into()), robot_files, changes)
}

/// Loads a world around a setting, as [`load_equipped`] does around a map. Overrides change its robots alone.
///
/// # Errors
/// As [`load_equipped`].
pub fn load_around(setting: Setting, robot_files: &[&Path], changes: Changes) -> Result<WorldDef, LoadError> {
    load_on(|| Ok(setting), robot_files, changes)
}

fn load_on(
    setting: impl FnOnce() -> Result<Setting, LoadError>,
    robot_files: &[&Path],
    changes: Changes,
) -> Result<WorldDef, LoadError> {
    let overrides = changes.overrides;
    let mut robots = shipped(changes)?;
    for file in robot_files {
        let definition = robot_equipped(&file.display().to_string(), changes)?;
        let text = crate::text(&in_folder(file, "robot.toml")).unwrap_or_default();
        for class in further_names(&text) {
            robots.insert(class.clone(), RobotDef { class, ..definition.clone() });
        }
        robots.insert(definition.class.clone(), definition);
    }
    let Setting { map, league, scenario } = setting()?;
    overrides::check_used(overrides)?;
    changes.equipment.check_classes(robots.keys().map(String::as_str))?;
    let world = WorldDef { map, robots, objects: objects()?, league, scenario };
    world.check()?;
    Ok(world)
}

/// Returns the embedded robots. They are read when somebody first asks for them, unless they are changed: then mistakes of the changes are
/// reported at once.
fn shipped(changes: Changes) -> Result<Classes, LoadError> {
    let mut robots = Classes::default();
    if changes.is_none() {
        for name in robot_names() {
            let class = name.clone();
            robots.insert_unread(name, move || checked(&class).map_err(|error| error.to_string()));
        }
        return Ok(robots);
    }
    // Classes that are like another one come last, so a mistake is reported of the class that has it.
    let (like, own): (Vec<String>, Vec<String>) = robot_names().into_iter().partition(|name| is_like_another(name));
    for name in own.into_iter().chain(like) {
        robots.insert(name.clone(), robot_equipped(&name, changes)?);
    }
    Ok(robots)
}

/// Loads an embedded robot and checks its numbers.
fn checked(class: &str) -> Result<RobotDef, LoadError> {
    let robot = robot_equipped(class, Changes::of(&[]))?;
    scene::check::check_robot(&robot)?;
    Ok(robot)
}

/// Loads a map by its name, or by the path of its file.
///
/// # Errors
/// As [`load`].
pub fn map(name: &str, overrides: &[Override]) -> Result<MapDef, LoadError> {
    let path = &in_folder(Path::new(name), "map.toml");
    let (source, file, name) = match MAPS.get_dir(name) {
        Some(dir) => (Source::BuiltIn(dir), "map.toml".to_owned(), name.to_owned()),
        None if path.is_file() => (Source::of_file(path), file_name(path, "a map.toml")?, name_of(path, "map")),
        None => return Err(unknown("map", name, &map_names())),
    };
    overrides::blame(overrides, |overrides| {
        let mut problems = Problems::default();
        let text = overrides::apply(source.text(&file)?, overrides, &["map"], &[]);
        let map = map_file::read(&source, &file, &name, &text, &built_in_materials(overrides)?, &mut problems);
        problems.into_result(map)?.ok_or_else(|| unknown("map", &name, &map_names()))
    })
}

/// Loads a robot class by its name, in any case, or by the path of its robot.toml or of a URDF.
///
/// # Errors
/// As [`load`].
pub fn robot(name: &str, overrides: &[Override]) -> Result<RobotDef, LoadError> {
    robot_equipped(name, Changes::of(overrides))
}

/// Loads a robot class with overrides and equipment.
///
/// # Errors
/// As [`robot`].
pub fn robot_equipped(name: &str, changes: Changes) -> Result<RobotDef, LoadError> {
    let path = &in_folder(Path::new(name), "robot.toml");
    match built_in_robot(name) {
        Some(_) => built_in_as(name, changes, None),
        None if path.is_file() => {
            let class = name_of(path, "robot");
            if is_urdf(path) {
                return robot_of_urdf(path, &class);
            }
            let file = file_name(path, "a robot.toml or a URDF")?;
            read_definition(&Source::of_file(path), &file, [&class; 2], changes, None)
        }
        None => Err(unknown("robot", name, &robot_names())),
    }
}

/// Loads an embedded robot class by its name, in any case, with the equipment of that class or another. A further name of a class has the
/// class's equipment if it has none of its own.
pub(crate) fn built_in_as(name: &str, changes: Changes, equipped_as: Option<&str>) -> Result<RobotDef, LoadError> {
    let (class, dir) = built_in_robot(name).ok_or_else(|| unknown("robot", name, &robot_names()))?;
    let own = if changes.equipment.has(&class) { None } else { folder_name(dir) };
    let equipped_as = equipped_as.unwrap_or_else(|| own.as_deref().unwrap_or(&class));
    read_definition(&Source::BuiltIn(dir), "robot.toml", [&class, equipped_as], changes, None)
}

/// Loads an actuator: one in a folder beside the file that names it, or an embedded one. `depth` is the number of actuators that it is
/// mounted on.
pub(crate) fn actuator(beside: &Source, class: &str, changes: Changes, depth: usize) -> Result<RobotDef, LoadError> {
    let own = beside.folder(class).filter(|source| source.has("actuator.toml"));
    let embedded = || {
        let name = actuator_names().into_iter().find(|known| known.eq_ignore_ascii_case(class));
        let dir = ASSETS.get_dir(format!("actuators/{}", name?))?;
        Some(Source::BuiltIn(dir))
    };
    let source = own.or_else(embedded).ok_or_else(|| unknown("actuator", class, &actuator_names()))?;
    read_definition(&source, "actuator.toml", [class; 2], changes, Some(depth))
}

/// Loads a robot from only a URDF. Its assumptions list the values that a URDF does not give.
pub(crate) fn robot_of_urdf(path: &Path, class: &str) -> Result<RobotDef, LoadError> {
    let (source, mut problems) = (Source::of_file(path), Problems::default());
    let file = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let (text, materials) = (source.xml(&file, MAX_TEXT)?, built_in_materials(&[])?);
    let known = Known { mecanum: hints_at_mecanum(&text), ..Known::default() };
    let of = OfUrdf { source: &source, file: &file, text: &text, class, materials: &materials, known };
    let guessed = robot_file::of_urdf::read(&of, &mut problems);
    let robot = guessed.map(|guessed| guessed.robot);
    problems.into_result(robot)?.ok_or_else(|| unknown("robot", class, &robot_names()))
}

/// Returns the file with this name in a folder; any other path stays unchanged.
pub(crate) fn in_folder(path: &Path, file: &str) -> PathBuf {
    let inside = path.join(file);
    if path.is_dir() && inside.is_file() { inside } else { path.to_owned() }
}

pub(crate) fn is_urdf(path: &Path) -> bool {
    path.extension().is_some_and(|extension| ["urdf", "xacro"].iter().any(|known| extension == *known))
}

fn read_definition(
    source: &Source,
    file: &str,
    [class, equipped_as]: [&str; 2],
    changes: Changes,
    depth: Option<usize>,
) -> Result<RobotDef, LoadError> {
    let without: &[&str] = if changes.equipment.replaces(equipped_as) { &["sensor", "mount"] } else { &[] };
    overrides::blame(changes.overrides, |overrides| {
        let mut problems = Problems::default();
        let text = overrides::apply(source.text(file)?, overrides, &["robot", class], without);
        let (materials, changes) = (&built_in_materials(overrides)?, Changes { overrides, ..changes });
        let definition =
            robot_file::Definition { source, file, class, equipped_as, materials, changes, depth, others: OTHERS };
        let robot = robot_file::read(&definition, &text, &mut problems);
        problems.into_result(robot)?.ok_or_else(|| unknown("robot", class, &robot_names()))
    })
}

/// Returns the embedded classes of objects, by name.
///
/// # Errors
/// When their file has a mistake.
pub fn objects() -> Result<BTreeMap<String, Object>, LoadError> {
    let (source, mut problems) = (Source::BuiltIn(&ASSETS), Problems::default());
    let (text, materials) = (source.text("objects.toml")?, built_in_materials(&[])?);
    let objects = map_file::read_objects(&source, "objects.toml", &text, &materials, &mut problems);
    problems.into_result(objects)
}

/// Returns `foo` for `foo/map.toml` and `foo.toml`, with `_` for characters that a name on the wire cannot have. In the name of a
/// class, a point would end a package.
pub(crate) fn name_of(path: &Path, kind: &str) -> String {
    let stem = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or(kind);
    let folder = path.parent().and_then(Path::file_name).and_then(|name| name.to_str());
    let name = if stem == kind { folder.unwrap_or(stem) } else { stem };
    name.replace(|c: char| c.is_whitespace() || "{}".contains(c) || (kind == "robot" && c == '.'), "_")
}

/// Returns the name of a TOML file; `expected` lists the accepted files in the error.
pub(crate) fn file_name(path: &Path, expected: &'static str) -> Result<String, LoadError> {
    if path.extension().is_none_or(|extension| extension != "toml") {
        return Err(LoadError::UnknownKind { file: path.display().to_string(), expected });
    }
    Ok(path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default())
}
