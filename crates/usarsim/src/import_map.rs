//! `usarsim import-map`: makes the folder of a map from a file of another program.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use names::count;
use scene::{MapDef, Shape};
use scene_loader::{ImportedMap, ImportedSolid, LoadError, MapImport};
use serde_json::json;
use sim_core::{Options, World};

use crate::output::{fill_new_folder, write};
use crate::values::within;
use crate::{Failure, exit, print};

/// Options of `import-map`.
#[derive(clap::Args)]
#[command(
    after_help = "Examples:\n  usarsim import-map building.glb --name building --material 'wall*=plywood' --material 'floor*=carpet'\n  \
    usarsim import-map scan.stl --name scan --scale 0.001 --floor\n  \
    usarsim import-map gazebo.world --name office && usarsim serve --map office\n\n\
    Objects of a mesh become [[mesh]] tables, or [[box]] if they are boxes. Of SDF it takes the colliding shapes with their \
    friction; lights, plugins and models that are not found are left out and listed. Files are z up; glTF is y up."
)]
pub(crate) struct Arguments {
    /// A .sdf, .world, .glb, .gltf, .obj, .stl or .dae file.
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Name of the map, and of its new folder here.
    #[arg(long, value_parser = name)]
    name: String,
    /// Material of the objects whose names fit a pattern, in which * is any text; the first that fits counts, and without one it is
    /// concrete.
    #[arg(long, value_name = "PATTERN=MATERIAL", value_parser = pair)]
    material: Vec<(String, String)>,
    /// Factor from the unit of a mesh to metres.
    #[arg(long, default_value = "1", value_parser = scale)]
    scale: f64,
    /// Add a plane below everything.
    #[arg(long)]
    floor: bool,
    /// Folder with models of Gazebo. May be given several times. Models are also looked for beside FILE, in the folders above, in
    /// GZ_SIM_RESOURCE_PATH, GAZEBO_MODEL_PATH and the like, and in Gazebo's own folders in the home folder.
    #[arg(long, value_name = "DIR")]
    models: Vec<PathBuf>,
    /// Model of SDF to leave out, as a robot that `import` makes. May be given several times.
    #[arg(long, value_name = "NAME")]
    without: Vec<String>,
    /// Refuse the file if a model or mesh is not there. By default it is left out, and listed.
    #[arg(long)]
    strict: bool,
    /// Print what was made as JSON.
    #[arg(long)]
    json: bool,
}

/// Variables with folders of models: those of gz-sim, of its predecessor, of Gazebo Classic and of SDF's library.
const VARIABLES: [&str; 6] = [
    "GZ_SIM_RESOURCE_PATH",
    "IGN_GAZEBO_RESOURCE_PATH",
    "GAZEBO_MODEL_PATH",
    "GAZEBO_RESOURCE_PATH",
    "SDF_PATH",
    "GZ_FILE_PATH",
];
/// Folders of models in the home folder: Gazebo Classic's, and the caches of Fuel by owner.
const OF_CLASSIC: &str = ".gazebo/models";
const OF_FUEL: [&str; 2] = [".gz/fuel/fuel.gazebosim.org", ".ignition/fuel/fuel.ignitionrobotics.org"];

/// Lists the folders in which models are looked for: the named ones, those of variables, and Gazebo's own.
pub(crate) fn folders_of_models(named: &[PathBuf]) -> Vec<PathBuf> {
    let of_variable =
        |name: &&str| std::env::var_os(name).map(|paths| std::env::split_paths(&paths).collect::<Vec<_>>());
    let of_variables =
        VARIABLES.iter().filter_map(of_variable).flatten().filter(|folder| !folder.as_os_str().is_empty());
    let mut folders: Vec<PathBuf> = named.iter().cloned().chain(of_variables).collect();
    if let Some(home) = std::env::var_os("HOME").map(PathBuf::from) {
        folders.push(home.join(OF_CLASSIC));
        let owners =
            OF_FUEL.iter().flat_map(|cache| std::fs::read_dir(home.join(cache)).into_iter().flatten().flatten());
        let mut owners: Vec<PathBuf> = owners.map(|owner| owner.path()).take(100).collect();
        owners.sort();
        folders.extend(owners);
    }
    folders
}

/// Start poses that are looked for; clients ask for them by name.
const STARTS: [&str; 3] = ["PlayerStart_0", "RobotStart1", "RobotStart2"];
/// Robot that has to find room at a start pose.
const CLASS: &str = "P3AT";
/// Distance between places that are tried, m.
const STEP: f64 = 1.5;
/// Rings of places that are tried around the middle.
const RINGS: i32 = 12;
/// Most triangles near the places that are tried, each counted at every place: the search among them takes most of the time. The first
/// place is tried whatever is near.
const MAX_NEAR: usize = 200_000;

fn name(text: &str) -> Result<String, String> {
    let is_good = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    let good = (1..=60).contains(&text.len()) && text.chars().all(is_good) && !text.starts_with(['.', '-']);
    good.then(|| text.to_owned()).ok_or_else(|| "expected up to 60 letters, digits, -, _ or points".to_owned())
}

fn pair(text: &str) -> Result<(String, String), String> {
    let (pattern, material) = text.rsplit_once('=').ok_or("expected PATTERN=MATERIAL, as in wall*=plywood")?;
    Ok((pattern.to_owned(), material.to_owned()))
}

fn scale(text: &str) -> Result<f64, String> {
    within(text, 1e-6, 1e6)
}

pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { file, name, material, scale, floor, models, without, strict, json } = arguments;
    let models = folders_of_models(models);
    let import = MapImport {
        file,
        scale: *scale,
        materials: material,
        floor: *floor,
        models: &models,
        without,
        within: None,
        is_strict: *strict,
    };
    let bad = |error: LoadError| Failure::new(exit::BAD_DATA, error);
    let (folder, map) = (Path::new(name), scene_loader::import_map(&import).map_err(bad)?);
    let Made { map: made, starts, size } = fill_new_folder(folder, || make(folder, &import, map, is_world(file)))?;
    if *json {
        let solid = |it: &ImportedSolid| {
            let ImportedSolid { name, kind, material, triangles, is_movable } = it;
            json!({"name": name, "kind": kind, "material": material, "triangles": triangles, "movable": is_movable})
        };
        let starts = starts.iter().map(|(name, place)| json!({"name": name, "position": place}));
        print(json!({
            "map": folder.join("map.toml"),
            "size": size,
            "solids": made.solids.iter().map(solid).collect::<Vec<_>>(),
            "starts": starts.collect::<Vec<_>>(),
            "notes": made.notes,
        }));
        return Ok(());
    }
    for ImportedSolid { name, kind, material, triangles, is_movable } in &made.solids {
        let size = if *triangles > 0 { format!(" of {}", count(*triangles, "triangle")) } else { String::new() };
        let moves = if *is_movable { ", can be pushed" } else { "" };
        print(format_args!("{name}: {kind}{size}, {material}{moves}"));
    }
    made.notes.iter().for_each(|note| print(format_args!("note: {note}")));
    for (name, [x, y, z]) in &starts {
        print(format_args!("{name}: at {x}, {y}, {z}"));
    }
    let [map, materials] = verdict(name, &made, size);
    print(map);
    print(format_args!("{materials}; --material 'PATTERN=MATERIAL' changes them"));
    match made.notes.len() {
        0 => print("nothing is left out"),
        notes => print(format_args!("left out or changed: {}, above", count(notes, "note"))),
    }
    Ok(())
}

/// A map in its folder.
pub(crate) struct Made {
    pub(crate) map: ImportedMap,
    /// Start poses.
    pub(crate) starts: Starts,
    /// Extent along the axes, m.
    pub(crate) size: [f64; 3],
}

/// Writes an imported map into a new folder. If no robot could stand on it and it `may_get_floor`, it is imported again with a floor.
pub(crate) fn make(
    folder: &Path,
    import: &MapImport,
    mut map: ImportedMap,
    may_get_floor: bool,
) -> Result<Made, Failure> {
    let bad = |error: LoadError| Failure::new(exit::BAD_DATA, error);
    let (mut starts, mut size) = fill(folder, &map)?;
    if starts.is_empty() && !import.floor && may_get_floor {
        map = scene_loader::import_map(&MapImport { floor: true, ..*import }).map_err(bad)?;
        let why = "a floor is added below everything, as there is no place on which a robot could stand";
        map.notes.push(why.to_owned());
        (starts, size) = fill(folder, &map)?;
    }
    if starts.is_empty() {
        let hint = "no place on which a robot could stand: expected a floor. --floor adds one, --scale turns other units into metres";
        return Err(Failure::new(exit::BAD_DATA, hint));
    }
    Ok(Made { map, starts, size })
}

/// Says what a map is, and how it touches.
pub(crate) fn verdict(name: &str, made: &ImportedMap, [x, y, z]: [f64; 3]) -> [String; 2] {
    let pushed = made.solids.iter().filter(|solid| solid.is_movable).count();
    let pushed = if pushed == 0 { "none can be pushed".to_owned() } else { format!("{pushed} can be pushed") };
    let map = format!("{name}: {} over {x:.1} x {y:.1} x {z:.1} m, {pushed}", count(made.solids.len(), "solid"));
    let mut materials = BTreeMap::<&str, usize>::new();
    made.solids.iter().for_each(|solid| *materials.entry(&solid.material).or_default() += 1);
    let materials: Vec<String> = materials.iter().map(|(name, count)| format!("{count} of {name}")).collect();
    [map, format!("materials: {}", names::listed(materials.iter().map(String::as_str)))]
}

/// True for a world or model of Gazebo, which may have no floor.
fn is_world(file: &Path) -> bool {
    file.extension().is_some_and(|ending| ["sdf", "world"].iter().any(|known| ending.eq_ignore_ascii_case(known)))
}

/// Start poses by name.
pub(crate) type Starts = Vec<(&'static str, [f64; 3])>;

/// Writes the files of a map into its new folder, with the start poses that are free. Returns these, and the map's extent along its axes, m.
fn fill(folder: &Path, made: &ImportedMap) -> Result<(Starts, [f64; 3]), Failure> {
    for (file, content) in &made.meshes {
        write(&folder.join(file), content)?;
    }
    let text = |starts: &[(&str, [f64; 3])]| {
        let mut text = made.text.clone();
        for (name, [x, y, z]) in starts {
            let _ = write!(text, "\n[[start]]\nname = \"{name}\"\nposition = [{x:?}, {y:?}, {z:?}]\n");
        }
        text
    };
    let map = &folder.join("map.toml");
    write(map, text(&[(STARTS[0], [0.0; 3])]).as_bytes())?;
    let def = scene_loader::load(&folder.display().to_string(), &[]);
    let mut world = World::new(def.map_err(|error| Failure::new(exit::BAD_DATA, error))?, Options::default());
    let points = picture::corners_of_map(&world.def().map);
    let ends = [0, 1, 2].map(|axis| {
        let places = points.iter().map(|point| point[axis]);
        places.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], at| [least.min(at), most.max(at)])
    });
    let starts = free_places(&mut world, ends);
    if !starts.is_empty() {
        write(map, text(&starts).as_bytes())?;
    }
    Ok((starts, ends.map(|[least, most]| (most - least).max(0.0))))
}

/// Returns free places, the nearest to the middle first, each with the name of a start pose.
fn free_places(world: &mut World, ends: [[f64; 2]; 3]) -> Starts {
    let [x, y, [_, lowest]] = ends;
    let middle = [x, y].map(|[least, most]| (least + most) / 2.0);
    let near = triangles_near(&world.def().map, middle);
    let all = (-RINGS..=RINGS).flat_map(|row| (-RINGS..=RINGS).map(move |column| [row, column]));
    let mut places: Vec<[i32; 2]> = all.collect();
    places.sort_by_key(|[row, column]| row * row + column * column);
    // Start poses lie on the floor, on which robots of any class are put.
    let wheels = world.def().robots[CLASS].wheels().map(|wheel| wheel.position[2] + wheel.radius);
    let under = wheels.fold(0.0, f64::max);
    let mut free: Vec<[f64; 3]> = Vec::new();
    let mut work = 0;
    for (tried, place) in places.into_iter().enumerate() {
        // A place below or above too much is left out; one without anything near costs nothing.
        if tried > 0 && work + near[cell(place)] > MAX_NEAR {
            continue;
        }
        work += near[cell(place)];
        let [x, y] = [0, 1].map(|axis| middle[axis] + STEP * f64::from(place[axis]));
        // A robot below everything is lifted onto the lowest floor.
        let Some(pose) = world.free_pose(CLASS, [x, y, lowest], [0.0; 3]) else { continue };
        if stands(world, [x, y, pose.translation.z]) {
            free.push([x, y, pose.translation.z + under].map(|part| (part * 1e3).round() / 1e3));
        }
        if free.len() == STARTS.len() {
            break;
        }
    }
    STARTS.into_iter().zip(free).collect()
}

/// Number of cells along an edge of the square of places.
const EDGE: usize = 2 * RINGS as usize + 1;

/// Returns the number of the cell of a place.
fn cell([row, column]: [i32; 2]) -> usize {
    (row + RINGS) as usize * EDGE + (column + RINGS) as usize
}

/// Counts the triangles of meshes above and below each place, by their boxes.
fn triangles_near(map: &MapDef, middle: [f64; 2]) -> Vec<usize> {
    // Differences along rows and columns: their sums are the counts, so that a triangle over many places costs no more than another.
    let mut counts = vec![0_i64; (EDGE + 1) * (EDGE + 1)];
    for solid in map.solids.iter().chain(map.objects.iter().map(|object| &object.solid)) {
        let Shape::Mesh { vertices, triangles } = &solid.shape else { continue };
        let pose = solid.pose();
        let place = |vertex: &[f64; 3]| pose * nalgebra::Point3::from(*vertex);
        let places: Vec<_> = vertices.iter().map(place).collect();
        for triangle in triangles {
            let range = |axis: usize| {
                let cells = triangle.iter().filter_map(|&index| {
                    let offset = (places.get(index as usize)?[axis] - middle[axis]) / STEP + f64::from(RINGS);
                    Some((offset + 0.5).floor())
                });
                cells.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| [low.min(at), high.max(at)])
            };
            let [rows, columns] = [range(0), range(1)];
            let is_outside = |[low, high]: [f64; 2]| high < 0.0 || low >= EDGE as f64;
            if is_outside(rows) || is_outside(columns) {
                continue;
            }
            let clamped = |[low, high]: [f64; 2]| [low.max(0.0) as usize, (high as usize).min(EDGE - 1) + 1];
            let ([top, bottom], [left, right]) = (clamped(rows), clamped(columns));
            for (row, column, sign) in [(top, left, 1), (top, right, -1), (bottom, left, -1), (bottom, right, 1)] {
                counts[row * (EDGE + 1) + column] += sign;
            }
        }
    }
    for row in 0..EDGE {
        for column in 0..EDGE {
            let at = |row: usize, column: usize| row * (EDGE + 1) + column;
            let above = if row > 0 { counts[at(row - 1, column)] } else { 0 };
            let left = if column > 0 { counts[at(row, column - 1)] } else { 0 };
            let both = if row > 0 && column > 0 { counts[at(row - 1, column - 1)] } else { 0 };
            counts[at(row, column)] += above + left - both;
        }
    }
    let of_row = |row: usize| counts[row * (EDGE + 1)..][..EDGE].iter().map(|&count| count.max(0) as usize);
    (0..EDGE).flat_map(of_row).collect()
}

/// True if a robot stays where it is put: it has a floor.
fn stands(world: &World, [x, y, z]: [f64; 3]) -> bool {
    /// Time after which it has come to rest, s, and the way that it may fall until then, m.
    const SETTLED: (f64, f64) = (0.3, 0.1);
    let mut copy = world.clone();
    let init =
        gamebots_proto::command::Init { class_name: CLASS.to_owned(), location: [x, y, z], ..Default::default() };
    let Some(robot) = copy.init(&init, &mut Vec::new()) else { return false };
    let steps = (SETTLED.0 / copy.time_step()) as usize;
    (0..steps).for_each(|_| drop(copy.step()));
    copy.state(robot).is_some_and(|(body, _)| (body.pose.translation.z - z).abs() < SETTLED.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compares the counts of a map of one mesh with those of every triangle at every place.
    #[test]
    fn triangles_are_counted_at_every_place_that_their_boxes_reach() {
        let mut state = 7_u64;
        let mut next = |size: f64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            ((state >> 33) as f64 / (1_u64 << 31) as f64 - 0.5) * size
        };
        for (triangles, size, spread) in [(1, 0.1, 0.0), (50, 3.0, 60.0), (20, 200.0, 20.0), (0, 1.0, 1.0)] {
            let mut vertices = Vec::new();
            for _ in 0..triangles {
                let middle = [next(spread), next(spread), 0.0];
                vertices.extend((0..3).map(|_| middle.map(|part| part + next(size))));
            }
            let corners = |triangle: u32| [0, 1, 2].map(|corner| 3 * triangle + corner);
            let shape = Shape::Mesh { vertices: vertices.clone(), triangles: (0..triangles).map(corners).collect() };
            let (name, position, rotation, material) = (String::new(), [0.0; 3], [0.0; 3], scene::Material::default());
            let solid = scene::Solid { name, shape, position, rotation, material };
            let map = MapDef { solids: vec![solid], ..MapDef::default() };
            let middle = [1.0, -2.0];
            let near = triangles_near(&map, middle);
            for row in -RINGS..=RINGS {
                for column in -RINGS..=RINGS {
                    let reaches = |triangle: &[[f64; 3]]| {
                        [row, column].iter().enumerate().all(|(axis, place)| {
                            let at = middle[axis] + STEP * f64::from(*place);
                            let parts = || triangle.iter().map(|vertex| vertex[axis]);
                            let (low, high) = (parts().fold(f64::MAX, f64::min), parts().fold(f64::MIN, f64::max));
                            low < at + STEP / 2.0 && high >= at - STEP / 2.0
                        })
                    };
                    let expected = vertices.chunks(3).filter(|triangle| reaches(triangle)).count();
                    assert_eq!(near[cell([row, column])], expected, "{triangles} of {size} m at {row}, {column}");
                }
            }
        }
    }
}
