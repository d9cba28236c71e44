//! Files of other programs that somebody drops on the page: a robot or a map is made of them, as `usarsim import` and `import-map` do.
//!
//! They are a stranger's, so nothing outside of their folder is read, and no program is run.

use std::path::{Path, PathBuf};

use gamebots_server::{NotOpened, Opened, Thing};
#[cfg(feature = "ros2")]
use scene::RobotDef;
use scene::{DriveModel, MapDef};
use scene_loader::{Import, Imported, MapImport, Packages, SdfFile};

use crate::Failure;
use crate::import::{self, xacro};
use crate::import_map::{self, Made};

/// Files that can be opened, in words.
const EXPECTED: &str = "expected a .urdf, .sdf, .world, .glb, .gltf, .obj, .stl or .dae file";
/// Most files that a question lists.
const MAX_CHOICES: usize = 20;
/// Extents of a mesh, m, beyond which its unit may be another.
const LIKELY: std::ops::RangeInclusive<f64> = 0.05..=500.0;
/// Longest name of a class or a map.
const MAX_NAME: usize = 40;

/// Opens the robot or the map in a folder: the file named `chosen`, or the only one that it could be. Writes into the folder `work`.
///
/// # Errors
/// If there are several, none, or the file is bad.
pub(super) fn open(
    folder: &Path,
    work: &Path,
    chosen: Option<&str>,
    drive_model: Option<DriveModel>,
) -> Result<Opened, NotOpened> {
    let folder = &folder.canonicalize().map_err(|error| NotOpened::Bad(error.to_string()))?;
    let file = match chosen {
        Some(chosen) => folder.join(chosen),
        None => folder.join(only(&candidates(folder))?),
    };
    std::fs::create_dir_all(work).map_err(|error| NotOpened::Bad(error.to_string()))?;
    let opened = match kind(&file) {
        Some(Kind::Robot | Kind::Xacro) => robot(folder, work, &file, drive_model),
        Some(Kind::World) if is_robot(folder, work, &file) => robot(folder, work, &file, drive_model),
        Some(Kind::World | Kind::Mesh) => map(folder, work, &file),
        None => Err(format!("{EXPECTED}, or a folder with one")),
    };
    // Whoever dropped the file knows it by its own name.
    let shown =
        |why: String| why.replace(&format!("{}/", folder.display()), "").replace(&folder.display().to_string(), ".");
    opened
        .map_err(|why| NotOpened::Bad(shown(why)))
        .map(|opened| Opened { notes: opened.notes.into_iter().map(shown).collect(), ..opened })
}

/// Kinds of files that can be opened. The first ones win where there are several.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    Robot,
    World,
    Xacro,
    Mesh,
}

fn kind(file: &Path) -> Option<Kind> {
    match file.extension()?.to_str()?.to_ascii_lowercase().as_str() {
        "urdf" => Some(Kind::Robot),
        "world" | "sdf" => Some(Kind::World),
        "xacro" => Some(Kind::Xacro),
        "glb" | "gltf" | "obj" | "stl" | "dae" => Some(Kind::Mesh),
        _ => None,
    }
}

/// Lists the files of the first kinds that a folder has, by their paths in it: robots and worlds are one kind.
fn candidates(folder: &Path) -> Vec<String> {
    let (mut found, mut open) = (Vec::new(), vec![folder.to_owned()]);
    while let Some(inside) = open.pop() {
        for path in std::fs::read_dir(&inside).into_iter().flatten().flatten().map(|entry| entry.path()) {
            if path.is_dir() {
                open.push(path);
            } else if let Some(kind) = kind(&path) {
                let name = path.strip_prefix(folder).unwrap_or(&path).to_string_lossy().into_owned();
                found.push((kind.max(Kind::World), name));
            }
        }
    }
    let first = found.iter().map(|(kind, _)| *kind).min();
    let mut names: Vec<String> =
        found.into_iter().filter(|(kind, _)| Some(*kind) == first).map(|(_, name)| name).collect();
    names.sort_by_key(|name| (name.matches('/').count(), name.clone()));
    names
}

/// Returns the only candidate.
fn only(names: &[String]) -> Result<&String, NotOpened> {
    match names {
        [] => Err(NotOpened::Bad(format!("nothing here can be opened: {EXPECTED}"))),
        [name] => Ok(name),
        names => Err(NotOpened::Choose(names.iter().take(MAX_CHOICES).cloned().collect())),
    }
}

/// Makes a robot of a URDF or SDF that a node of ROS sends. Meshes of a URDF are those of the packages that this machine has; SDF names
/// files anywhere, of which none is read.
#[cfg(feature = "ros2")]
pub(super) fn robot_of_text(text: &str, drive_model: Option<DriveModel>) -> Result<RobotDef, String> {
    let folder = tempfile::tempdir().map_err(|error| error.to_string())?;
    let within = &folder.path().canonicalize().map_err(|error| error.to_string())?;
    let file = within.join("robot.urdf");
    std::fs::write(&file, text).map_err(|error| error.to_string())?;
    let packages = Packages::around(&file, &[], &import::searched_folders()).map_err(|error| error.to_string())?;
    let shown = |why: String| why.replace(&file.display().to_string(), "robot.urdf");
    let sdf = SdfFile { file: &file, models: &[], within: Some(within), work: within };
    read(&sdf, packages, drive_model).map(|imported| imported.robot).map_err(shown)
}

/// True if a file of SDF is one model with joints that move: a world is a map, whatever is in it.
fn is_robot(root: &Path, work: &Path, file: &Path) -> bool {
    let sdf = SdfFile { file, models: &[], within: Some(root), work };
    let is_model = scene_loader::xml_text(file).is_ok_and(|text| scene_loader::is_sdf_model(&text));
    is_model && scene_loader::sdf_robots(&sdf).is_ok_and(|robots| !robots.is_empty())
}

fn robot(root: &Path, work: &Path, file: &Path, drive_model: Option<DriveModel>) -> Result<Opened, String> {
    let packages = Packages::inside(root, file).map_err(|error| error.to_string())?;
    let sdf = SdfFile { file, models: &[], within: Some(root), work };
    let imported = read(&sdf, packages, drive_model)?;
    let verdict = import::verdict(&imported).to_vec();
    let Imported { robot, guessed, replaced, left_out, .. } = imported;
    let notes = [("guessed", guessed), ("replaced", replaced), ("left out", left_out)];
    let notes =
        notes.into_iter().flat_map(|(what, notes)| notes.into_iter().map(move |note| format!("{what}: {note}")));
    Ok(Opened { thing: Thing::Robot(Box::new(robot)), verdict, notes: notes.collect() })
}

/// Reads a robot from its URDF or SDF.
fn read(sdf: &SdfFile, mut packages: Packages, drive_model: Option<DriveModel>) -> Result<Imported, String> {
    let file = sdf.file;
    let text = scene_loader::xml_text(file).map_err(|error| error.to_string())?;
    let mut of_sdf = None;
    if scene_loader::is_sdf(&text) {
        of_sdf = Some(scene_loader::sdf_robot(sdf, None).map_err(|error| error.to_string())?);
        packages.allow(sdf.work);
    } else if xacro::is_used(&text) {
        let name = file.file_name().unwrap_or_default().display().to_string();
        return Err(format!(
            "{name} is a program of xacro, which no server runs for a page: drop what `xacro {name}` prints"
        ));
    }
    let name = of_sdf.as_ref().map_or_else(|| scene_loader::urdf_name(&text), |robot| Some(robot.name.clone()));
    let class = &name.and_then(|name| plain(&name)).unwrap_or_else(|| name_of(file, "Robot"));
    let import = Import { file, text: &text, class, packages: &packages, wheels: &[], drive: None };
    let imported = of_sdf.map_or_else(|| scene_loader::import(&import), |robot| robot.import(&import));
    let mut imported = imported.map_err(|error| error.to_string())?;
    if drive_model.is_some() {
        imported.robot.set_drive_model(drive_model);
    }
    Ok(imported)
}

fn map(root: &Path, work: &Path, file: &Path) -> Result<Opened, String> {
    let name = &name_of(file, "dropped");
    let import = MapImport { within: Some(root), ..MapImport::new(file) };
    let folder: &PathBuf = &work.join(name);
    std::fs::create_dir_all(folder).map_err(|error| error.to_string())?;
    let map = scene_loader::import_map(&import).map_err(|error| error.to_string())?;
    let made = import_map::make(folder, &import, map, true).map_err(|Failure { message, .. }| message)?;
    let def: MapDef = scene_loader::map(&folder.display().to_string(), &[]).map_err(|error| error.to_string())?;
    let Made { map, size, .. } = made;
    let verdict = import_map::verdict(name, &map, size).to_vec();
    let mut notes = map.notes;
    let extent = size.into_iter().fold(0.0, f64::max);
    if kind(file) == Some(Kind::Mesh) && !LIKELY.contains(&extent) {
        notes.push(format!(
            "it is {extent:.3} m long, as a file without a unit is in metres: `usarsim import-map --scale 0.001` reads millimetres"
        ));
    }
    Ok(Opened { thing: Thing::Map(Box::new(def)), verdict, notes })
}

/// Returns a name for the wire after that of a file.
fn name_of(file: &Path, otherwise: &str) -> String {
    let stem = file.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    plain(&stem).unwrap_or_else(|| otherwise.to_owned())
}

/// Returns a name with only what a name on the wire may have; `None` if nothing is left.
fn plain(name: &str) -> Option<String> {
    let plain = |c: char| if c.is_ascii_alphanumeric() || "_-".contains(c) { c } else { '_' };
    let name: String = name.trim().chars().take(MAX_NAME).map(plain).collect();
    Some(name.trim_matches(['_', '-']).to_owned()).filter(|name| !name.is_empty())
}

#[cfg(all(test, feature = "ros2"))]
mod tests {
    use super::*;

    #[test]
    fn a_text_of_sdf_reads_no_file_of_the_machine() {
        let elsewhere = tempfile::tempdir().expect("a folder");
        let mesh = elsewhere.path().join("secret.obj");
        std::fs::write(&mesh, "o part\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
            .expect("a file");
        let uri = format!("<uri>file://{}</uri>", mesh.display());
        for inside in [uri.clone(), uri + "<submesh><name>part</name></submesh>"] {
            let text = format!(
                "<sdf version='1.9'><model name='m'><link name='l'><collision name='c'><geometry><mesh>{inside}</mesh></geometry>\
                 </collision></link></model></sdf>"
            );
            let robot = robot_of_text(&text, None).expect("a robot");
            assert!(robot.links.iter().all(|link| link.solids.is_empty()), "{inside}");
        }
    }
}
