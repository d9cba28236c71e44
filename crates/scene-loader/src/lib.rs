//! Robots, maps and materials: files in, plain definitions of `scene` out. Every file is read here.
//!
//! The robots, maps and materials of this repository are built into the program; others are named by their path.
//! Files are in SI units and in the world frame (x forward, y right, z down), but for URDF and meshes, which are
//! z up as everywhere else and are turned here.

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

pub use catalogue::{load, load_with, map, map_names, robot, robot_names};
pub use overrides::{Override, check_used};
pub use problem::{FileProblem, LoadError};

use std::path::Path;

use problem::Problems;
use scene::Material;
use source::Source;

/// Checks a robot.toml, a map.toml, a materials.toml or a URDF and returns everything wrong with it.
///
/// # Errors
/// When the file cannot be read or its kind is not known.
pub fn check(path: &Path) -> Result<(), LoadError> {
    let source = Source::of_file(path);
    let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let problems = match path.extension().and_then(|extension| extension.to_str()) {
        Some("urdf" | "xacro") => {
            let mut problems = Problems::default();
            let text = source.text(name)?;
            // Why it could not be read stands in the problems.
            let _ = urdf::read(&source, name, &text, Material::default(), &mut problems);
            problems
        }
        Some("toml") => check_toml(&source, name)?,
        _ => {
            let expected = "a .toml (robot, map or materials) or a .urdf file";
            return Err(LoadError::UnknownKind { file: path.display().to_string(), expected });
        }
    };
    problems.into_result(()).map(|_| ())
}

/// Materials are told by the name of their file, robots by their wheels; the rest is a map.
fn check_toml(source: &Source, name: &str) -> Result<Problems, LoadError> {
    let text = source.text(name)?;
    let materials = catalogue::built_in_materials(&[])?;
    let mut problems = Problems::default();
    if name.starts_with("materials") {
        materials::read(&source.display(name), &text, &mut problems);
    } else if name.starts_with("robot") || text.contains("[[wheel]]") {
        robot::read(source, name, "Checked", &text, &materials, &mut problems);
    } else {
        map::read(source, name, "checked", &text, &materials, &mut problems);
    }
    Ok(problems)
}
