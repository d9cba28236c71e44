//! Loader of robots, maps and materials: reads files and returns plain definitions of `scene`. All files of scenes are read here.
//!
//! The robots, maps and materials of this repository are embedded in the program; others are named by their path. Files are in SI
//! units and in the world frame (x forward, y right, z down). URDFs and meshes are z up, as usual, and are converted here.

mod catalogue;
mod document;
mod map;
mod materials;
mod mesh;
mod overrides;
mod problem;
mod robot;
mod source;
mod urdf;

pub use catalogue::{File, load, load_with, map, map_files, map_names, robot, robot_files, robot_names};
pub use overrides::{Override, check_used};
pub use problem::{FileProblem, LoadError};

use std::path::Path;

use problem::Problems;
use source::Source;

/// Checks a robot.toml, a map.toml, a materials.toml, an objects.toml or a URDF. Returns the assumptions made where a robot's file gives no value.
///
/// # Errors
/// Lists all problems of the file. Also fails if the file cannot be read or is of an unknown kind.
pub fn check(path: &Path) -> Result<Vec<String>, LoadError> {
    let path = &catalogue::in_folder(&catalogue::in_folder(path, "map.toml"), "robot.toml");
    if catalogue::is_urdf(path) {
        return catalogue::robot_of_urdf(path, "Checked").map(|robot| robot.assumptions);
    }
    if path.extension().is_none_or(|extension| extension != "toml") {
        let expected = "a .toml (robot, map, materials or objects) or a .urdf file";
        return Err(LoadError::UnknownKind { file: path.display().to_string(), expected });
    }
    let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    check_toml(&Source::of_file(path), name)
}

/// Checks a TOML file. Files of materials, objects and actuators are known by their names, a robot by its name or its wheels; any other file is a map.
fn check_toml(source: &Source, name: &str) -> Result<Vec<String>, LoadError> {
    let text = source.text(name)?;
    let materials = catalogue::built_in_materials(&[])?;
    let mut problems = Problems::default();
    let mut assumptions = Vec::new();
    if name.starts_with("materials") {
        materials::read(&source.display(name), &text, &mut problems);
    } else if name.starts_with("objects") {
        map::read_objects(source, name, &text, &materials, &mut problems);
    } else if name.starts_with("actuator") || name.starts_with("robot") || text.contains("[[wheel]]") {
        let depth = name.starts_with("actuator").then_some(0);
        let definition =
            robot::Definition { source, file: name, class: "Checked", materials: &materials, overrides: &[], depth };
        let robot = robot::read(&definition, &text, &mut problems);
        assumptions = robot.map_or(Vec::new(), |robot| robot.assumptions);
    } else {
        map::read(source, name, "checked", &text, &materials, &mut problems);
    }
    problems.into_result(assumptions)
}
