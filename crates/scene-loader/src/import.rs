//! Robots from description packages of ROS: makes a robot.toml, a clean URDF and the list of its meshes.
//!
//! The URDF that is written has only what this program reads. Its meshes lie beside it, its inertias are possible, and casters are
//! left to robot.toml. Everything that is guessed, replaced or left out is listed.

mod inertia;
mod meshes;
mod packages;
mod sensors;
mod toml;

use std::path::{Path, PathBuf};

use nalgebra::{Isometry3, Point3};
use scene::{Material, RobotDef};
use urdf_rs::{Geometry, JointType};

pub use self::packages::Packages;

use self::meshes::Meshes;
use crate::problem::Problems;
use crate::robot::of_urdf::extent::bounds;
use crate::robot::of_urdf::{self, Change, Guessed, Known, WheelDrive};
use crate::source::Source;
use crate::urdf::{self, Parsed};
use crate::{LoadError, shipped, xml};

/// Name of the URDF in a robot's folder.
const URDF: &str = "robot.urdf";
/// Folder of the meshes in a robot's folder.
const MESHES: &str = "meshes";

/// A robot to be imported.
pub struct Import<'a> {
    /// The file, for messages.
    pub file: &'a Path,
    /// Its text, a URDF without xacro.
    pub text: &'a str,
    /// Name of the class.
    pub class: &'a str,
    /// Packages that it refers to.
    pub packages: &'a Packages,
    /// Joints of its driven wheels; empty if they shall be found.
    pub wheels: &'a [String],
    /// Drive of its wheels; `None` if it shall be guessed.
    pub drive: Option<WheelDrive>,
}

/// An imported robot.
pub struct Imported {
    /// The robot.
    pub robot: RobotDef,
    /// Names of files in the robot's folder, with their contents.
    pub files: Vec<(String, Content)>,
    /// Guesses where the URDF has no value.
    pub guessed: Vec<String>,
    /// Impossible values that were replaced.
    pub replaced: Vec<String>,
    /// Parts of the URDF that are not used.
    pub left_out: Vec<String>,
}

/// Content of a file.
pub enum Content {
    /// A text.
    Text(String),
    /// A copy of another file.
    CopyOf(PathBuf),
}

/// Imports a robot. Writes nothing.
///
/// # Errors
/// Lists all problems of the URDF. Also fails if it is no robot that can be simulated.
pub fn import(import: &Import) -> Result<Imported, LoadError> {
    let &Import { file, packages, .. } = import;
    let (shown, mut problems) = (file.display().to_string(), Problems::default());
    let text = xml::lenient(import.text);
    let parsed = urdf::parse(&shown, &text, &mut problems);
    let Some(Parsed { document, mut robot, mut left_out }) = problems.into_result(parsed.ok())? else {
        return Err(problem(&shown, "not a URDF"));
    };
    let mut meshes = Meshes::new(packages);
    meshes.place_all(&mut robot, &mut left_out);
    let source = meshes.source();
    let mut replaced = Vec::new();
    remove_hollow(&source, &mut robot, &mut left_out);
    inertia::repair(&source, &mut robot, &mut replaced);
    let mut guessed = guess(import, &source, &robot, urdf::hints_at_mecanum(&text))?;
    if guessed.robot.links.iter().all(|link| link.solids.is_empty() && link.wheel.is_none()) {
        left_out.push("no colliding shape is left, so the robot touches nothing".to_owned());
    }
    guessed.changes.iter().for_each(|change| apply(change, &mut robot));
    let sensors = sensors::find(document.root_element(), &robot, &guessed.robot, &mut left_out);
    for sensor in &sensors {
        let sensors::Sensor { class, def, .. } = sensor;
        let link = &guessed.robot.links[def.link].name;
        guessed.robot.assumptions.push(format!("sensor {} is Gazebo's, a {class} on {link}", def.name));
    }
    guessed.robot.sensors.extend(sensors.iter().map(|sensor| sensor.def.clone()));
    let name = file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let of_robot = toml::of_robot(&guessed.robot, &sensors, &name, [&guessed.robot.assumptions, &replaced, &left_out])
        .map_err(|error| problem(&shown, error))?;
    let mut files = vec![
        ("robot.toml".to_owned(), Content::Text(of_robot)),
        (URDF.to_owned(), Content::Text(written(&shown, &robot)?)),
    ];
    files.extend(meshes.used_by(&robot).into_iter().map(|(name, path)| (name, Content::CopyOf(path))));
    Ok(Imported { guessed: guessed.robot.assumptions.clone(), robot: guessed.robot, files, replaced, left_out })
}

/// Guesses the robot of a URDF in a folder that is not written yet. `mecanum` is true if the file hints at Mecanum wheels.
fn guess(import: &Import, source: &Source, robot: &urdf_rs::Robot, mecanum: bool) -> Result<Guessed, LoadError> {
    let shown = import.file.display().to_string();
    let (text, materials) = (written(&shown, robot)?, shipped::built_in_materials(&[])?);
    let (known, mut problems) = (Known { wheels: import.wheels, drive: import.drive, mecanum }, Problems::default());
    let of = of_urdf::OfUrdf { source, file: URDF, text: &text, class: import.class, materials: &materials, known };
    let guessed = of_urdf::read(&of, &mut problems);
    // The user does not have the file in which these problems have lines.
    let guessed = problems.into_result(guessed).map_err(|error| match error {
        LoadError::Bad(problems) => {
            let messages: Vec<String> = problems.into_iter().map(|problem| problem.message).collect();
            problem(&shown, messages.join("; "))
        }
        other => other,
    })?;
    guessed.ok_or_else(|| problem(&shown, "not a robot"))
}

/// Returns the text of a URDF.
fn written(shown: &str, robot: &urdf_rs::Robot) -> Result<String, LoadError> {
    let text = urdf_rs::write_to_string(robot).map_err(|error| problem(shown, error))?;
    Ok(format!("<?xml version=\"1.0\"?>\n{text}\n"))
}

fn problem(file: &str, message: impl std::fmt::Display) -> LoadError {
    LoadError::Scene(scene::check::SceneProblem { place: file.to_owned(), message: message.to_string() })
}

/// Removes colliding shapes that have no volume, which the loader refuses.
fn remove_hollow(source: &Source, robot: &mut urdf_rs::Robot, left_out: &mut Vec<String>) {
    for link in &mut robot.links {
        let mut kept = Vec::new();
        for collision in std::mem::take(&mut link.collision) {
            let solid = urdf::solid(source, link, &collision, &Isometry3::identity(), &Material::default());
            let wrong = match &solid {
                Ok(solid) => scene::check::body_solid(solid).into_iter().next(),
                Err(reason) => Some(reason.clone()),
            };
            match wrong {
                Some(reason) => left_out.push(format!("link {}: a colliding shape: {reason}", link.name)),
                None => kept.push(collision),
            }
        }
        link.collision = kept;
    }
}

/// Returns the bounds of a link's colliding shapes, or of its visuals if it has none, in its own frame.
fn bounds_of(source: &Source, link: &urdf_rs::Link) -> Option<[Point3<f64>; 2]> {
    let of_visual = |it: &urdf_rs::Visual| (it.origin.clone(), it.geometry.clone());
    let visuals = || link.visual.iter().map(of_visual).collect();
    let shapes: Vec<(urdf_rs::Pose, Geometry)> = match link.collision.len() {
        0 => visuals(),
        _ => link.collision.iter().map(|it| (it.origin.clone(), it.geometry.clone())).collect(),
    };
    let solid = |(origin, geometry): (urdf_rs::Pose, Geometry)| {
        let collision = urdf_rs::Collision { name: None, origin, geometry };
        urdf::solid(source, link, &collision, &Isometry3::identity(), &Material::default()).ok()
    };
    let of_solids = shapes.into_iter().filter_map(solid).map(|solid| bounds(&solid.shape, &solid.pose()));
    let [low, high] = of_solids.reduce(|[low, high], [a, b]| [low.inf(&a), high.sup(&b)])?;
    // Solids are z down.
    Some([Point3::new(low.x, -high.y, -high.z), Point3::new(high.x, -low.y, -low.z)])
}

fn apply(change: &Change, robot: &mut urdf_rs::Robot) {
    match change {
        Change::Hold(name) => {
            for joint in robot.joints.iter_mut().filter(|joint| &joint.name == name) {
                (joint.joint_type, joint.mimic) = (JointType::Fixed, None);
            }
        }
        Change::Rename(from, to) => {
            for joint in &mut robot.joints {
                if &joint.name == from {
                    joint.name.clone_from(to);
                }
                if let Some(mimic) = joint.mimic.as_mut().filter(|mimic| &mimic.joint == from) {
                    mimic.joint.clone_from(to);
                }
            }
        }
        Change::Limit(name, [effort, velocity]) => {
            for joint in robot.joints.iter_mut().filter(|joint| &joint.name == name) {
                (joint.limit.effort, joint.limit.velocity) = (*effort, *velocity);
            }
        }
        Change::Turn(yaw) => urdf::turn(robot, *yaw),
        Change::NoCollision(name) => {
            robot.links.iter_mut().filter(|link| &link.name == name).for_each(|link| link.collision.clear());
        }
    }
}
