//! Loader of robots, maps and materials: reads files and returns plain definitions of `scene`. All files of scenes are read here.
//!
//! The robots, maps and materials of this repository are embedded in the program; others are named by their path. Files are in SI
//! units and in the world frame (x forward, y right, z down). URDFs and meshes are z up, as usual, and are converted here.

mod catalogue;
mod document;
mod equipment;
mod families;
mod import;
mod import_map;
mod league;
mod map;
mod materials;
mod mesh;
mod overrides;
mod problem;
mod robot;
mod scenario;
mod sdf;
mod shipped;
mod source;
mod urdf;
mod xml;

pub use catalogue::{load, load_around, load_equipped, load_with, map, objects, robot, robot_equipped};
pub use equipment::{Changes, Equipment};
pub use families::{FAMILIES, Family};
pub use import::{Content, Import, Imported, Packages, import};
pub use import_map::{ImportedMap, ImportedSolid, MapImport, import_map};
pub use league::{Communication, Controllers, LeagueFile, league};
pub use overrides::{Override, check_used};
pub use problem::{FileProblem, LoadError};
pub use robot::of_urdf::WheelDrive;
pub use scenario::{ListedScenario, listed_scenarios, scenario, scenario_names, scenarios_in};
pub use sdf::robot::{SdfFile, SdfRobot, is_sdf, is_sdf_model, sdf_robot, sdf_robots};
pub use shipped::{File, map_description, map_files, map_names, robot_files, robot_folders, robot_names};

use std::path::Path;

use problem::Problems;
use source::Source;

/// Checks a robot.toml, a map.toml, a scenario.toml, a league.toml, a materials.toml, an objects.toml, a set of equipment, a URDF or an ini of USARSim. Returns the assumptions
/// made where a robot's file gives no value, and the lines of an ini that have no effect.
///
/// # Errors
/// Lists all problems of the file. Also fails if the file cannot be read or is of an unknown kind.
pub fn check(path: &Path) -> Result<Vec<String>, LoadError> {
    let in_folder = |path, file| catalogue::in_folder(path, file);
    let path = &in_folder(&in_folder(&in_folder(path, "scenario.toml"), "map.toml"), "robot.toml");
    if catalogue::is_urdf(path) {
        return catalogue::robot_of_urdf(path, "Checked").map(|robot| robot.assumptions);
    }
    if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("ini")) {
        return check_ini(path);
    }
    if path.extension().is_none_or(|extension| extension != "toml") {
        let expected =
            "a .toml (robot, map, scenario, league, materials, objects or equipment), a .urdf or an .ini file";
        return Err(LoadError::UnknownKind { file: path.display().to_string(), expected });
    }
    check_toml(path)
}

/// Returns the text of a file of at most 4 MB.
///
/// # Errors
/// When it cannot be read, is larger or is not UTF-8.
pub fn text(path: &Path) -> Result<String, LoadError> {
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    Source::of_file(path).text(&name)
}

/// Returns the text of an XML file, such as a URDF, of at most 4 MB, in the encoding that it says. What XML forbids and the readers of ROS and
/// Gazebo take, such as comments with `--`, is made good; lines stay where they are.
///
/// # Errors
/// When it cannot be read or is larger.
pub fn xml_text(path: &Path) -> Result<String, LoadError> {
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    Source::of_file(path).xml(&name, source::MAX_TEXT)
}

/// True if the root of a URDF declares the name space of xacro.
pub fn declares_xacro(text: &str) -> bool {
    urdf::declares_xacro(text)
}

/// Returns the name of the robot in a URDF, if it has one.
pub fn urdf_name(text: &str) -> Option<String> {
    urdf::robot_name(text)
}

/// True for a set of equipment: its name or its tables say so.
fn is_equipment(name: &str, text: &str) -> bool {
    name.starts_with("equipment") || [".sensor]]", ".mount]]"].iter().any(|table| text.contains(table))
}

/// True for a league: its name or its teams say so.
fn is_league(name: &str, text: &str) -> bool {
    name.starts_with("league") || text.lines().any(|line| line.trim() == "[[team]]")
}

/// True for a scenario: its name or its times say so.
fn is_scenario(name: &str, text: &str) -> bool {
    name.starts_with("scenario") || text.lines().any(|line| line.starts_with("stars ="))
}

/// Checks a set of equipment with the shipped robots and actuators that it names.
fn check_equipment(source: &Source, name: &str) -> Result<Vec<String>, LoadError> {
    let equipment = &Equipment::load(&source.display(name))?;
    let robots = robot_names();
    equipment.check_classes(robots.iter().map(String::as_str))?;
    let changes = Changes { overrides: &[], equipment };
    for class in equipment.set_classes() {
        if robots.iter().any(|robot| robot.eq_ignore_ascii_case(class)) {
            robot_equipped(class, changes)?;
        } else {
            catalogue::actuator(source, class, changes, 0)?;
        }
    }
    Ok(Vec::new())
}

/// Checks an ini of USARSim. Returns the lines without an effect.
fn check_ini(path: &Path) -> Result<Vec<String>, LoadError> {
    let equipment = Equipment::of_inis(&[path.to_owned()])?;
    let robots = robot_names();
    let warnings = equipment.warnings(robots.iter().map(String::as_str));
    Ok(warnings.iter().map(|it| format!("{}:{}: {}", it.line, it.column, it.message)).collect())
}

/// Checks a TOML file. Files of materials, objects and actuators are known by their names, a robot by its name or its wheels, a scenario by its name or its times, a league by its name or its teams, equipment by its tables; any other
/// file is a map.
fn check_toml(path: &Path) -> Result<Vec<String>, LoadError> {
    let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let source = &Source::of_file(path);
    let text = source.text(name)?;
    if is_scenario(name, &text) {
        return scenario(&path.display().to_string()).map(|_| Vec::new());
    }
    if is_league(name, &text) {
        return league(path, None).map(|_| Vec::new());
    }
    if is_equipment(name, &text) {
        return check_equipment(source, name);
    }
    let materials = shipped::built_in_materials(&[])?;
    let mut problems = Problems::default();
    let mut assumptions = Vec::new();
    if name.starts_with("materials") {
        materials::read(&source.display(name), &text, &mut problems);
    } else if name.starts_with("objects") {
        map::read_objects(source, name, &text, &materials, &mut problems);
    } else if name.starts_with("actuator") || name.starts_with("robot") || text.contains("[[wheel]]") {
        let depth = name.starts_with("actuator").then_some(0);
        let definition = robot::Definition {
            source,
            file: name,
            class: "Checked",
            equipped_as: "",
            materials: &materials,
            changes: Changes::of(&[]),
            depth,
            others: catalogue::OTHERS,
        };
        let robot = robot::read(&definition, &text, &mut problems);
        assumptions = robot.map_or(Vec::new(), |robot| robot.assumptions);
    } else {
        map::read(source, name, "checked", &text, &materials, &mut problems);
    }
    problems.into_result(assumptions)
}
