//! `usarsim import`: makes a robot's folder from a ROS description package.

pub(crate) mod xacro;

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use names::count;
use scene::{MountedWheel, RobotDef, Steering};
use scene_loader::{Content, Import, Imported, LoadError, Packages, SdfFile, WheelDrive};
use serde_json::json;

use crate::import_map::folders_of_models;
use crate::output::{failed, fill_new_folder};
use crate::{Failure, exit, print};

/// Options of `import`.
#[derive(clap::Args)]
#[command(after_help = "Examples:\n  usarsim import husky_description/urdf/husky.urdf.xacro --class Husky\n  \
    usarsim import ur_description/urdf/ur.urdf.xacro ur_type:=ur5 name:=ur --class UR5\n  \
    usarsim import diff_drive.sdf --model vehicle_blue --class Blue\n  \
    usarsim check Husky && usarsim serve --robot Husky\n\nMakes the folder NAME here, which must not exist, with robot.toml, \
    robot.urdf and meshes. Says what was guessed, replaced and left out. Packages are searched around FILE, in ROS_PACKAGE_PATH and in \
    AMENT_PREFIX_PATH. A xacro file is a program: expand only those that you trust.")]
pub(crate) struct Arguments {
    /// URDF or xacro file, or a model or world of SDF. Xacro needs Python's `xacro` (`pip install xacro`).
    file: PathBuf,
    /// Arguments of the xacro file.
    #[arg(value_name = "NAME:=VALUE", value_parser = xacro_argument)]
    arguments: Vec<String>,
    /// Name of the robot's class and folder.
    #[arg(long, value_name = "NAME", value_parser = class)]
    class: String,
    /// Folder of a package that is not found. May be given several times.
    #[arg(long = "package", value_name = "NAME=FOLDER", value_parser = package)]
    packages: Vec<(String, PathBuf)>,
    /// Model in a file of SDF, if it has several robots.
    #[arg(long, value_name = "NAME")]
    model: Option<String>,
    /// Folder with models of Gazebo that a file of SDF includes. May be given several times. They are looked for as by `import-map`.
    #[arg(long, value_name = "DIR")]
    models: Vec<PathBuf>,
    /// Joints of the driven wheels, if the guess is wrong: names with commas between them.
    #[arg(long, value_name = "JOINT,..", value_delimiter = ',')]
    wheels: Vec<String>,
    /// Drive of the wheels, if the guess is wrong.
    #[arg(long, value_enum)]
    drive: Option<DriveChoice>,
    /// Print the result as JSON.
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum DriveChoice {
    /// Four Mecanum wheels, which also go sideways.
    Mecanum,
    /// Left and right wheels at speeds of their own.
    Skid,
    /// Two driven wheels and casters.
    Differential,
    /// Steered wheels.
    Car,
}

impl From<DriveChoice> for WheelDrive {
    fn from(choice: DriveChoice) -> Self {
        match choice {
            DriveChoice::Mecanum => Self::Mecanum,
            DriveChoice::Skid | DriveChoice::Differential => Self::Sides,
            DriveChoice::Car => Self::Car,
        }
    }
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { file, class, json, .. } = arguments;
    let folder = Path::new(class);
    if folder.symlink_metadata().is_ok() {
        let message = format_args!("{class}: exists already: choose another --class, or remove it");
        return Err(Failure::new(exit::FAILURE, message));
    }
    let bad = |error: LoadError| Failure::new(exit::BAD_DATA, error);
    let mut text = scene_loader::xml_text(file).map_err(bad)?;
    let mut packages = Packages::around(file, &arguments.packages, &searched_folders()).map_err(bad)?;
    let (mut missing, mut of_sdf) = (Vec::new(), None);
    // Parts of meshes lie in it until they are copied.
    let work = tempfile::tempdir().map_err(|error| failed(Path::new("temporary folder"), error))?;
    if scene_loader::is_sdf(&text) {
        let models = &folders_of_models(&arguments.models);
        let sdf = SdfFile { file, models, within: None, work: work.path() };
        let robot = scene_loader::sdf_robot(&sdf, arguments.model.as_deref()).map_err(bad)?;
        robot.folders.iter().map(PathBuf::as_path).chain([work.path()]).for_each(|folder| packages.allow(folder));
        of_sdf = Some(robot);
    } else if let Some(model) = &arguments.model {
        let message = format_args!("--model {model}: {} is no SDF: expected one with models", file.display());
        return Err(Failure::new(exit::USAGE, message));
    } else if xacro::is_needed(file, &text) {
        let source = text;
        (text, missing) = xacro::expand(file, &arguments.arguments, packages.folders())?;
        if let Some(why) = xacro::only_macros(file, &source, &text) {
            return Err(Failure::new(exit::BAD_DATA, why));
        }
    } else if let Some(argument) = arguments.arguments.first() {
        let message = format_args!("{argument}: {} is a URDF: expected arguments of a xacro file only", file.display());
        return Err(Failure::new(exit::USAGE, message));
    }
    let drive = arguments.drive.map(WheelDrive::from);
    let import = Import { file, text: &text, class, packages: &packages, wheels: &arguments.wheels, drive };
    let imported = of_sdf.map_or_else(|| scene_loader::import(&import), |robot| robot.import(&import));
    let mut imported = imported.map_err(bad)?;
    let unfound = |name: &String| {
        format!(
            "package `{name}` is not found, so its files are not included: name its folder by --package {name}=FOLDER"
        )
    };
    imported.left_out.extend(missing.iter().map(unfound));
    fill_new_folder(folder, || {
        fill(folder, &imported)?;
        // The folder is what counts.
        scene_loader::robot(&folder.join("robot.toml").display().to_string(), &[]).map_err(bad)
    })?;
    if *json {
        print(as_json(class, &imported))
    } else {
        say(folder, &imported)
    }
    Ok(())
}

/// Parses an argument of a xacro file.
fn xacro_argument(text: &str) -> Result<String, String> {
    let name = text.split_once(":=").map(|(name, _)| name);
    let good = name.is_some_and(|name| !name.is_empty() && !name.starts_with('-'));
    if good { Ok(text.to_owned()) } else { Err("expected NAME:=VALUE".to_owned()) }
}

fn package(text: &str) -> Result<(String, PathBuf), String> {
    let (name, folder) = text.split_once('=').ok_or("expected NAME=FOLDER")?;
    Ok((name.to_owned(), folder.into()))
}

/// Parses the name of a class, which is the name of a folder and a word on the wire.
fn class(text: &str) -> Result<String, String> {
    let good = |c: char| c.is_ascii_alphanumeric() || "_-".contains(c);
    if text.is_empty() || text.len() > 64 || !text.chars().all(good) || text.starts_with('-') {
        return Err("expected 1 to 64 letters, digits, `_` or `-`".to_owned());
    }
    if scene_loader::robot_names().iter().any(|known| known.eq_ignore_ascii_case(text)) {
        return Err("a built-in robot has this name: expected another".to_owned());
    }
    Ok(text.to_owned())
}

/// Returns the folders in which ROS has its packages.
pub(crate) fn searched_folders() -> Vec<PathBuf> {
    let paths = |name: &str| std::env::var_os(name).map(|paths| std::env::split_paths(&paths).collect::<Vec<_>>());
    let shares = paths("AMENT_PREFIX_PATH").unwrap_or_default().into_iter().map(|prefix| prefix.join("share"));
    paths("ROS_PACKAGE_PATH").unwrap_or_default().into_iter().chain(shares).filter(|path| path.is_dir()).collect()
}

/// Writes the files of a robot into its new folder.
fn fill(folder: &Path, imported: &Imported) -> Result<(), Failure> {
    for (name, content) in &imported.files {
        let path = folder.join(name);
        let parent = path.parent().map_or(Ok(()), std::fs::create_dir_all);
        let written = parent.and_then(|()| match content {
            Content::Text(text) => std::fs::write(&path, text),
            Content::CopyOf(from) => std::fs::read(from).and_then(|bytes| std::fs::write(&path, bytes)),
        });
        written.map_err(|error| failed(&path, error))?;
    }
    Ok(())
}

fn say(folder: &Path, imported: &Imported) {
    for (name, _) in &imported.files {
        print(folder.join(name).display());
    }
    let Imported { guessed, replaced, left_out, .. } = imported;
    for (what, notes) in [("guessed", guessed), ("replaced", replaced), ("left out", left_out)] {
        notes.iter().for_each(|note| print(format_args!("{what}: {note}")));
    }
    verdict(imported).iter().for_each(print);
    let notes = [(guessed, "guessed"), (replaced, "replaced"), (left_out, "left out")];
    let notes: Vec<String> = notes.iter().map(|(notes, what)| format!("{} {what}", notes.len())).collect();
    print(format_args!("notes: {}, above; --wheels and --drive say what the guess has wrong", notes.join(", ")));
}

/// Says what a robot is, and how it drives.
pub(crate) fn verdict(imported: &Imported) -> [String; 2] {
    let robot = &imported.robot;
    let driven = robot.driven().count();
    let casters = robot.wheels().count() - driven;
    let joints = robot.links.iter().filter(|link| link.wheel.is_none() && link.has_value()).count();
    let (wheels, casters) = (count(driven, "driven wheel"), count(casters, "caster"));
    let (class, mass, joints) = (&robot.class, robot.mass(), count(joints, "joint"));
    [
        format!("{class}: {}, {mass:.1} kg, {wheels}, {casters}, {joints}", steering(imported)),
        format!("drives: {}", drives(robot)),
    ]
}

/// Returns how a robot moves, in words.
fn drives(robot: &RobotDef) -> String {
    let rim = |wheel: MountedWheel| wheel.drive.map_or(0.0, |motor| motor.max_speed * wheel.radius);
    let speed = robot.driven().map(rim).fold(f64::INFINITY, f64::min);
    let wheels = || names::listed(robot.driven().map(|wheel| wheel.name));
    match robot.steering {
        Steering::Skid => format!("left and right, up to {speed:.2} m/s, by {}", wheels()),
        Steering::Omni => format!("to all sides on Mecanum wheels, up to {speed:.2} m/s ahead, by {}", wheels()),
        Steering::Ackermann => format!("as a car, up to {speed:.2} m/s, by {}", wheels()),
        Steering::Aerial => "it flies".to_owned(),
        Steering::Legged => "it stands on legs; its joints move".to_owned(),
        Steering::None => "not at all: it is fixed to the ground".to_owned(),
    }
}

fn steering(Imported { robot, .. }: &Imported) -> &'static str {
    Steering::ALL.iter().find(|(_, it)| *it == robot.steering).map_or("none", |(name, _)| name)
}

fn as_json(class: &str, imported: &Imported) -> serde_json::Value {
    let Imported { robot, files, guessed, replaced, left_out } = imported;
    let wheels = robot.wheels().map(|wheel| {
        json!({"name": wheel.name, "driven": wheel.drive.is_some(), "position": wheel.position, "radius": wheel.radius, "width": wheel.width})
    });
    let joints = robot.links.iter().filter(|link| link.wheel.is_none() && link.has_value()).map(|link| &link.name);
    json!({
        "class": class,
        "steering": steering(imported),
        "mass": robot.mass(),
        "wheels": serde_json::Value::from_iter(wheels),
        "joints": joints.collect::<Vec<_>>(),
        "files": files.iter().map(|(name, _)| format!("{class}/{name}")).collect::<Vec<_>>(),
        "guessed": guessed,
        "replaced": replaced,
        "left_out": left_out,
    })
}
