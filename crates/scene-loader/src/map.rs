//! `map.toml`: solids, their materials, start poses, and what sensors perceive beside shapes.

pub(crate) mod height_field;
mod perceived;

use std::collections::BTreeMap;

use scene::{Conveyor, Geographic, MapDef, NamedPose, Object, Shape, Solid, check};

use crate::document::{Document, Table, Vector};
use crate::materials::{self, Materials};
use crate::mesh;
use crate::problem::Problems;
use crate::source::Source;

const KEYS: &str = "description, robots, gravity, time_limit, north, latitude, longitude, material, half_space, box, ramp, cylinder, ball, mesh, \
                    height_field, start, path_node, victim, rfid, smoke, sound";

pub(crate) fn read(
    source: &Source,
    file: &str,
    name: &str,
    text: &str,
    materials: &Materials,
    problems: &mut Problems,
) -> Option<MapDef> {
    let shown = source.display(file);
    let (mut document, mut root) = Document::parse(&shown, text, problems)?;
    let description = document.required(&mut root, "description", "one sentence about the map");
    let robots = document.optional(&mut root, "robots").unwrap_or_default();
    let gravity = document.section(&mut root, "gravity").ok().flatten().map_or(9.81, |(span, gravity)| {
        document.within(&span, "gravity", gravity, check::GRAVITY);
        gravity
    });
    let time_limit = document.optional(&mut root, "time_limit").unwrap_or(20);
    let north = document.optional(&mut root, "north").unwrap_or(0.0);
    let origin = match ["latitude", "longitude"].map(|key| document.optional(&mut root, key)) {
        [None, None] => None,
        [latitude, longitude] => {
            if latitude.is_none() || longitude.is_none() {
                document.problem(&(0..0), "`latitude` or `longitude` is missing: expected both, or neither");
            }
            Some(Geographic { latitude: latitude.unwrap_or(0.0), longitude: longitude.unwrap_or(0.0) })
        }
    };
    let materials = materials::read_own(&mut document, &mut root, materials);
    let mut map = MapDef { name: name.to_owned(), robots, gravity, time_limit, north, origin, ..MapDef::default() };
    read_solids(source, &mut document, &mut root, &materials, &mut map);
    if !root.has("start") {
        document.problem(&(0..0), "no [[start]]: expected at least one start pose");
    }
    map.starts = read_poses(&mut document, &mut root, "start");
    map.path_nodes = read_poses(&mut document, &mut root, "path_node");
    let perceived = perceived::read(&mut document, &mut root, &materials);
    map.solids.extend(perceived.solids);
    (map.victims, map.tags) = (perceived.victims, perceived.tags);
    (map.smoke, map.sounds) = (perceived.smoke, perceived.sounds);
    document.finish(root, KEYS);
    map.description = description?;
    document.as_a_whole(|| check::map(&map));
    Some(map)
}

/// Reads solids of all kinds, and adds them to a map.
pub(crate) fn read_solids<'a>(
    source: &Source,
    document: &mut Document<'a>,
    root: &mut Table<'a>,
    materials: &Materials,
    map: &mut MapDef,
) {
    for kind in ["half_space", "box", "ramp", "cylinder", "ball", "mesh", "height_field"] {
        for table in document.tables(root, kind) {
            match read_solid(source, document, kind, table, materials) {
                // A solid with a mass can be pushed.
                Some((solid, Use::Object { mass })) => map.objects.push(Object { solid, mass }),
                Some((solid, Use::Marking)) => map.markings.push(solid),
                Some((solid, Use::Conveyor { velocity })) => {
                    map.conveyors.push(Conveyor { solid: map.solids.len(), velocity });
                    map.solids.push(solid);
                }
                Some((solid, Use::Fixed)) => map.solids.push(solid),
                None => {}
            }
        }
    }
}

/// Reads classes of objects: the tables of a map's boxes, cylinders and balls, each with a mass.
pub(crate) fn read_objects(
    source: &Source,
    file: &str,
    text: &str,
    materials: &Materials,
    problems: &mut Problems,
) -> BTreeMap<String, Object> {
    let shown = source.display(file);
    let Some((mut document, mut root)) = Document::parse(&shown, text, problems) else { return BTreeMap::new() };
    let mut objects = BTreeMap::new();
    for kind in ["box", "cylinder", "ball"] {
        for table in document.tables(&mut root, kind) {
            let span = table.span();
            match read_solid(source, &mut document, kind, table, materials) {
                Some((solid, Use::Object { mass })) => {
                    objects.insert(solid.name.clone(), Object { solid, mass });
                }
                Some((solid, _)) => document.problem(&span, format_args!("{} has no mass", solid.name)),
                None => {}
            }
        }
    }
    document.finish(root, "box, cylinder, ball");
    objects
}

/// Use of a solid of a map.
enum Use {
    Fixed,
    Object { mass: f64 },
    Conveyor { velocity: Vector },
    Marking,
}

fn read_solid<'a>(
    source: &Source,
    document: &mut Document<'a>,
    kind: &str,
    mut table: Table<'a>,
    materials: &Materials,
) -> Option<(Solid, Use)> {
    let span = table.span();
    let name: Option<String> = document.required(&mut table, "name", "a name for the solid");
    let material: Option<String> = document.required(&mut table, "material", "the name of a material");
    let position: Vector = document.optional(&mut table, "position").unwrap_or_default();
    let rotation: Vector = document.optional(&mut table, "rotation").unwrap_or_default();
    let colour: Option<Vector> = document.optional(&mut table, "colour");
    let mut mass: Option<f64> = None;
    if matches!(kind, "box" | "cylinder" | "ball") {
        mass = document.optional(&mut table, "mass");
    }
    let mut velocity: Option<Vector> = None;
    if kind == "box" {
        velocity = document.optional(&mut table, "conveyor");
    }
    let mut collides = true;
    if !matches!(kind, "half_space" | "height_field") {
        collides = document.optional(&mut table, "collides").unwrap_or(true);
    }
    let used_as = match (mass, velocity, collides) {
        (None, None, true) => Use::Fixed,
        (Some(mass), None, true) => Use::Object { mass },
        (None, Some(velocity), true) => Use::Conveyor { velocity },
        (None, None, false) => Use::Marking,
        _ => {
            document.problem(&span, "expected at most one of `mass`, `conveyor` and `collides = false`");
            Use::Fixed
        }
    };
    let mut length = |document: &mut Document<'a>, key: &str| -> Option<f64> {
        document.required(&mut table, key, "a length in metres")
    };
    let (shape, keys) = match kind {
        "half_space" => (Some(Shape::HalfSpace), ""),
        "box" => {
            let size: Option<Vector> = document.required(&mut table, "size", "edge lengths [x, y, z] in metres");
            (size.map(|size| Shape::Box { size }), ", collides, size, mass, conveyor")
        }
        "ramp" => {
            let edges = ["length", "width", "height"]
                .map(|key| length(document, key).filter(|&edge| document.within(&span, key, edge, check::MAP_SIZE)));
            let shape = match edges {
                [Some(length), Some(width), Some(height)] => Some(ramp(length, width, height)),
                _ => None,
            };
            (shape, ", collides, length, width, height")
        }
        "cylinder" => {
            let (radius, length) = (length(document, "radius"), length(document, "length"));
            let shape = radius.zip(length).map(|(radius, length)| Shape::Cylinder { radius, length });
            (shape, ", collides, radius, length, mass")
        }
        "ball" => {
            let radius = length(document, "radius");
            (radius.map(|radius| Shape::Ball { radius }), ", collides, radius, mass")
        }
        "height_field" => (height_field::read(source, document, &mut table), height_field::KEYS),
        _ => {
            let file: Option<String> =
                document.required(&mut table, "file", "an .stl, .obj, .dae, .glb or .gltf file beside the map");
            let scale = document.optional(&mut table, "scale").unwrap_or(1.0);
            let file = file.filter(|_| document.within(&span, "scale", scale, mesh::SCALE));
            let mesh = file.map(|file| mesh::read(source, &file, [scale; 3]));
            let mesh = mesh.and_then(|mesh| mesh.map_err(|reason| document.problem(&span, reason)).ok());
            (mesh, ", collides, file, scale")
        }
    };
    document.finish(table, &format!("name, material, colour, position, rotation{keys}"));
    let (name, mut material) = (name?, document.material(&span, &material?, materials));
    if let Some(colour) = colour {
        material.colour = colour;
        document.wrong(&span, check::material(&material));
    }
    let solid = Solid { name, shape: shape?, position, rotation, material };
    match used_as {
        Use::Object { mass } => document.wrong(&span, check::object(&Object { solid: solid.clone(), mass })),
        _ => document.wrong(&span, check::map_solid(&solid)),
    }
    if let Use::Conveyor { velocity } = used_as {
        document.wrong(&span, check::conveyor(&Conveyor { solid: 0, velocity }, Some(&solid.shape)));
    }
    Some((solid, used_as))
}

/// Returns a wedge. Its low edge lies on the y axis; it rises along x to `height` and ends in a vertical face.
fn ramp(length: f64, width: f64, height: f64) -> Shape {
    let side = |y: f64| [[0.0, y, 0.0], [length, y, 0.0], [length, y, -height]];
    Shape::Hull { points: [side(-width / 2.0), side(width / 2.0)].concat() }
}

/// Reads the tables of named poses of a file.
pub(crate) fn read_poses<'a>(document: &mut Document<'a>, root: &mut Table<'a>, key: &str) -> Vec<NamedPose> {
    let mut poses = Vec::new();
    for mut table in document.tables(root, key) {
        let span = table.span();
        let name: Option<String> = document.required(&mut table, "name", "a name without spaces");
        let position: Option<Vector> = document.required(&mut table, "position", "[x, y, z] in metres");
        let rotation: Vector = document.optional(&mut table, "rotation").unwrap_or_default();
        document.finish(table, "name, position, rotation");
        if let (Some(name), Some(position)) = (name, position) {
            let pose = NamedPose { name, position, rotation };
            document.wrong(&span, check::named_pose(&pose));
            poses.push(pose);
        }
    }
    poses
}
