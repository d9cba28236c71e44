//! Maps from files of other programs: meshes with several objects, and Gazebo's SDF.

mod sdf;

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::path::{Path, PathBuf};

use nalgebra::Vector3;
use scene::check::{FRICTION, MAX_NAME, MAX_OBJECTS, MAX_SOLIDS, MAX_TRIANGLES};
use scene::{Material, Pose, Shape};

use crate::mesh::{self, Piece};
use crate::problem::Problems;
use crate::sdf::models::Models;
use crate::source::Source;
use crate::{LoadError, shipped};

/// Size below which two coordinates of a box are one, as a part of its longest edge.
const FLAT: f64 = 1e-5;
/// Thinnest box, m. A thinner one stays a mesh.
const THIN: f64 = 1e-3;
/// Least area of a mesh, m²: a square of a millimetre.
const LEAST_AREA: f64 = 1e-6;
/// Material of what no pattern fits.
const MATERIAL: &str = "concrete";

/// Settings of an import.
#[derive(Debug, Clone, Copy)]
pub struct MapImport<'a> {
    /// A .sdf, .world, .glb, .gltf, .obj, .stl or .dae file.
    pub file: &'a Path,
    /// Factor from the unit of a mesh to metres. SDF is in metres.
    pub scale: f64,
    /// Patterns of names, with `*` for any text, and the material of what they fit. The first that fits counts.
    pub materials: &'a [(String, String)],
    /// True to add a plane below everything.
    pub floor: bool,
    /// Folders in which models of Gazebo are looked for, beside those around the file.
    pub models: &'a [PathBuf],
    /// Names of models of SDF that are left out, as robots that are imported by themselves.
    pub without: &'a [String],
    /// Folder outside of which nothing is read, for files of strangers: a whole path without links. `None` if everything may be.
    pub within: Option<&'a Path>,
    /// True to refuse a file whose models or meshes are not all there.
    pub is_strict: bool,
}

impl<'a> MapImport<'a> {
    /// Returns the usual settings: in metres, without a floor of its own, and what is not there is left out.
    pub fn new(file: &'a Path) -> Self {
        Self {
            file,
            scale: 1.0,
            materials: &[],
            floor: false,
            models: &[],
            without: &[],
            within: None,
            is_strict: false,
        }
    }
}

/// A solid that an import made of an object.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ImportedSolid {
    /// Name on the map.
    pub name: String,
    /// Kind of its table in map.toml.
    pub kind: &'static str,
    /// Name of its material.
    pub material: String,
    /// Number of triangles of a mesh; otherwise 0.
    pub triangles: usize,
    /// True if it can be pushed.
    pub is_movable: bool,
}

/// A map made from a file.
#[derive(Debug, Clone, PartialEq)]
pub struct ImportedMap {
    /// Text of map.toml without start poses.
    pub text: String,
    /// Meshes beside it: names and contents.
    pub meshes: Vec<(String, Vec<u8>)>,
    /// Its solids, in the order of the text.
    pub solids: Vec<ImportedSolid>,
    /// Parts of the file that are left out, in words.
    pub notes: Vec<String>,
}

/// An object of a file, in the world frame, z down.
struct FoundObject {
    name: String,
    pose: Pose,
    geometry: Geometry,
    colour: Option<[f64; 3]>,
    /// Mass, kg, if it can be pushed.
    mass: Option<f64>,
    touch: Touch,
    /// Name of a material of its own.
    material: Option<String>,
}

/// Touch of a surface, as far as the file says it.
#[derive(Clone, Copy, Default)]
struct Touch {
    friction: Option<f64>,
    restitution: Option<f64>,
}

enum Geometry {
    /// A half space, box, cylinder or ball.
    Plain(Shape),
    /// A mesh in the axes of its file, z up, m.
    Mesh(Piece),
}

/// Makes a map from a file.
///
/// # Errors
/// Reports an unreadable file, an unknown material, or all problems of the file.
pub fn import_map(import: &MapImport) -> Result<ImportedMap, LoadError> {
    import.materials.iter().try_for_each(|(_, material)| known_material(material))?;
    let (source, file) = (Source::of_file(import.file), file_name(import.file));
    let ending = import.file.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
    let sdf::Found { objects: mut found, mut notes, gravity, origin } = match ending.as_deref() {
        Some("sdf" | "world") => {
            let mut problems = Problems::default();
            let models = Models { folders: import.models, within: import.within };
            let read = sdf::read(&source, &file, models, import, &mut problems)?;
            problems.into_result(read)?
        }
        Some("glb" | "gltf" | "obj" | "stl" | "dae") => {
            let pieces = mesh::named_pieces(&source, &file).map_err(LoadError::Import)?;
            let stem = import.file.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
            let objects = pieces.into_iter().map(|piece| of_piece(piece, import.scale, &stem)).collect();
            sdf::Found { objects, ..sdf::Found::default() }
        }
        _ => {
            let expected = "a .sdf, .world, .glb, .gltf, .obj, .stl or .dae file";
            return Err(LoadError::UnknownKind { file: import.file.display().to_string(), expected });
        }
    };
    let before = found.len();
    found.retain(FoundObject::has_surface);
    if found.len() < before {
        notes.push(format!("{} meshes without an area are left out", before - found.len()));
    }
    if found.is_empty() || found.len() > MAX_SOLIDS {
        let (file, count) = (import.file.display(), found.len());
        let mut why = format!("{file} has {count} colliding shapes: expected 1 to {MAX_SOLIDS}");
        notes.iter().for_each(|note| why += &format!("\nnote: {note}"));
        return Err(LoadError::Import(why));
    }
    let movable = found.iter_mut().filter(|object| object.mass.is_some());
    let too_many: Vec<&mut FoundObject> = movable.skip(MAX_OBJECTS).collect();
    if !too_many.is_empty() {
        notes.push(format!("{} objects stand fast, as at most {MAX_OBJECTS} can be pushed", too_many.len()));
        too_many.into_iter().for_each(|object| object.mass = None);
    }
    if import.floor {
        let lowest = found.iter().flat_map(FoundObject::depths).fold(f64::NEG_INFINITY, f64::max);
        let pose = Pose::translation(0.0, 0.0, if lowest.is_finite() { lowest } else { 0.0 });
        let geometry = Geometry::Plain(Shape::HalfSpace);
        found.insert(0, FoundObject::fixed("floor".to_owned(), pose, geometry, None));
    }
    let mut made = ImportedMap { text: String::new(), meshes: Vec::new(), solids: Vec::new(), notes };
    let _ = writeln!(made.text, "description = {}", quoted(&format!("From {file}")));
    if let Some(gravity) = gravity {
        let _ = writeln!(made.text, "gravity = {}", number(gravity));
    }
    if let Some(origin) = origin {
        let _ = writeln!(made.text, "latitude = {:?}\nlongitude = {:?}", origin.latitude, origin.longitude);
    }
    made.text += &own_materials(&mut found, import.materials)?;
    let mut names = Names::default();
    for object in found {
        made.add(object, import.materials, &mut names);
    }
    Ok(made)
}

/// Returns the tables of materials for surfaces whose friction or bounce the file says, where no pattern of the user fits. Such a material is
/// the usual one with these numbers.
fn own_materials(found: &mut [FoundObject], patterns: &[(String, String)]) -> Result<String, LoadError> {
    let materials = shipped::built_in_materials(&[])?;
    let usual = materials.get(MATERIAL).cloned().unwrap_or_default();
    let mut own = BTreeMap::<String, Material>::new();
    for object in found.iter_mut().filter(|object| !patterns.iter().any(|(pattern, _)| fits(pattern, &object.name))) {
        let Touch { friction, restitution } = object.touch;
        if friction.or(restitution).is_none() {
            continue;
        }
        let mut material = usual.clone();
        material.friction = friction.unwrap_or(usual.friction).clamp(FRICTION.least, FRICTION.most);
        material.restitution = restitution.unwrap_or(usual.restitution).clamp(0.0, 1.0);
        let bounce =
            if restitution.is_some() { format!("-bounce-{}", number(material.restitution)) } else { String::new() };
        material.name = format!("friction-{}{bounce}", number(material.friction));
        object.material = Some(material.name.clone());
        own.insert(material.name.clone(), material);
    }
    let mut text = String::new();
    for (name, material) in own {
        let Material { friction, restitution, rolling_resistance, .. } = material;
        let _ = write!(
            text,
            "\n[material.{}]\nfriction = {}\nrestitution = {}\nrolling_resistance = {}\nsource = \"The file's surface\"\n",
            quoted(&name),
            number(friction),
            number(restitution),
            number(rolling_resistance)
        );
    }
    Ok(text)
}

fn known_material(name: &str) -> Result<(), LoadError> {
    let materials = shipped::built_in_materials(&[])?;
    let known = || materials.keys().map(String::as_str);
    let unknown = || LoadError::UnknownMaterial {
        got: name.to_owned(),
        suggestion: names::did_you_mean(name, known()),
        expected: names::listed(known()),
    };
    if materials.contains_key(name) { Ok(()) } else { Err(unknown()) }
}

fn file_name(path: &Path) -> String {
    path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}

/// Returns the object of a piece of a mesh. A closed box along the axes is a box, which costs less than its triangles.
fn of_piece(mut piece: Piece, scale: f64, stem: &str) -> FoundObject {
    piece.vertices.iter_mut().flatten().for_each(|part| *part = (f64::from(*part) * scale) as f32);
    let (name, colour) = (piece.name.clone().unwrap_or_else(|| stem.to_owned()), piece.colour);
    match as_box(&piece) {
        Some((centre, size)) => {
            let [x, y, z] = centre;
            // The frame of a map is z down, and a box is alike after half a turn.
            let pose = Pose::translation(x, -y, -z);
            FoundObject::fixed(name, pose, Geometry::Plain(Shape::Box { size }), colour)
        }
        None => FoundObject::fixed(name, Pose::identity(), Geometry::Mesh(piece), colour),
    }
}

/// Returns centre and edges of a piece that is a closed box along the axes, whichever side its triangles show.
fn as_box(piece: &Piece) -> Option<([f64; 3], [f64; 3])> {
    if piece.triangles.len() != 12 {
        return None;
    }
    let corner = |index: u32| piece.vertices[index as usize].map(f64::from);
    let used = || piece.triangles.iter().flatten().map(|&index| corner(index));
    let low: [f64; 3] = std::array::from_fn(|axis| used().map(|it| it[axis]).fold(f64::INFINITY, f64::min));
    let high: [f64; 3] = std::array::from_fn(|axis| used().map(|it| it[axis]).fold(f64::NEG_INFINITY, f64::max));
    let size: [f64; 3] = std::array::from_fn(|axis| high[axis] - low[axis]);
    let near = FLAT * size.into_iter().fold(0.0, f64::max);
    let mut corners = BTreeSet::new();
    for corner in used() {
        let side = |axis: usize| match corner[axis] {
            at if at - low[axis] <= near => Some(false),
            at if high[axis] - at <= near => Some(true),
            _ => None,
        };
        corners.insert([side(0)?, side(1)?, side(2)?]);
    }
    let volume = |&[a, b, c]: &[u32; 3]| {
        let [a, b, c] = [a, b, c].map(|index| Vector3::from(corner(index)));
        a.dot(&b.cross(&c)) / 6.0
    };
    let (volume, whole) = (piece.triangles.iter().map(volume).sum::<f64>(), size.iter().product::<f64>());
    let is_closed = corners.len() == 8 && (volume.abs() - whole).abs() < 1e-3 * whole;
    let centre = std::array::from_fn(|axis| (low[axis] + high[axis]) / 2.0);
    (is_closed && size.iter().all(|&edge| edge >= THIN)).then_some((centre, size))
}

impl FoundObject {
    fn fixed(name: String, pose: Pose, geometry: Geometry, colour: Option<[f64; 3]>) -> Self {
        Self { name, pose, geometry, colour, mass: None, touch: Touch::default(), material: None }
    }

    /// True unless it is a mesh that is a line or a point.
    fn has_surface(&self) -> bool {
        let Geometry::Mesh(piece) = &self.geometry else { return true };
        let corner = |index: u32| Vector3::from(piece.vertices[index as usize].map(f64::from));
        let area = |&[a, b, c]: &[u32; 3]| (corner(b) - corner(a)).cross(&(corner(c) - corner(a))).norm() / 2.0;
        piece.triangles.iter().map(area).sum::<f64>() > LEAST_AREA
    }

    /// Returns the heights (z) of its points, as far as they have an end.
    fn depths(&self) -> Vec<f64> {
        let down = |point: [f64; 3]| (self.pose * nalgebra::Point3::from(point)).z;
        match &self.geometry {
            Geometry::Plain(Shape::Box { size }) => {
                let half = |sign: f64| size.map(|edge| sign * edge / 2.0);
                let [low, high] = [half(-1.0), half(1.0)];
                let corner = |bits: usize| std::array::from_fn(|axis| [low, high][bits >> axis & 1][axis]);
                (0..8).map(|bits| down(corner(bits))).collect()
            }
            Geometry::Plain(Shape::Cylinder { radius, length }) => {
                vec![down([0.0, 0.0, length / 2.0]).max(down([0.0, 0.0, -length / 2.0])) + radius * self.lean()]
            }
            Geometry::Plain(Shape::Ball { radius }) => vec![down([0.0; 3]) + radius],
            Geometry::Plain(_) => Vec::new(),
            Geometry::Mesh(piece) => {
                let place = |[x, y, z]: [f32; 3]| down([x, -y, -z].map(f64::from));
                piece.vertices.iter().map(|&vertex| place(vertex)).collect()
            }
        }
    }

    /// Returns the sine of the angle between its z axis and the vertical.
    fn lean(&self) -> f64 {
        (self.pose.rotation * Vector3::z()).xy().norm()
    }
}

/// Names that are taken, of solids and of files.
#[derive(Default)]
struct Names(BTreeSet<String>);

impl Names {
    /// Returns a name that nothing has: the one that is wanted, or that with a number.
    fn new_one(&mut self, wanted: &str) -> String {
        let mut name = wanted.to_owned();
        let mut number = 1;
        while !self.0.insert(name.to_ascii_lowercase()) {
            number += 1;
            name = format!("{wanted}-{number}");
        }
        name
    }
}

impl ImportedMap {
    fn add(&mut self, found: FoundObject, patterns: &[(String, String)], names: &mut Names) {
        let is_bad = |c: char| c.is_whitespace() || c.is_control() || "{}".contains(c);
        let plain: String = found.name.trim().chars().take(MAX_NAME - 10).collect();
        let plain = plain.replace(is_bad, "_");
        let name = names.new_one(if plain.is_empty() { "solid" } else { &plain });
        let fits = patterns.iter().find(|(pattern, _)| fits(pattern, &found.name));
        let material = fits.map(|(_, material)| material.as_str()).or(found.material.as_deref()).unwrap_or(MATERIAL);
        let (kind, shape) = match &found.geometry {
            Geometry::Plain(Shape::HalfSpace) => ("half_space", String::new()),
            Geometry::Plain(Shape::Box { size }) => ("box", format!("size = {}\n", list(size))),
            Geometry::Plain(Shape::Cylinder { radius, length }) => {
                ("cylinder", format!("radius = {}\nlength = {}\n", number(*radius), number(*length)))
            }
            Geometry::Plain(Shape::Ball { radius }) => ("ball", format!("radius = {}\n", number(*radius))),
            Geometry::Plain(_) => return,
            Geometry::Mesh(piece) => {
                let simple = |c: char| if c.is_ascii_alphanumeric() || "-_".contains(c) { c } else { '_' };
                let file =
                    Names(self.meshes.iter().map(|(file, _)| file.trim_end_matches(".obj").to_owned()).collect())
                        .new_one(&name.chars().map(simple).take(60).collect::<String>());
                let file = format!("{}.obj", file.to_ascii_lowercase());
                self.meshes.push((file.clone(), mesh::as_obj(piece)));
                ("mesh", format!("file = {}\n", quoted(&file)))
            }
        };
        let triangles = if let Geometry::Mesh(piece) = &found.geometry { piece.triangles.len() } else { 0 };
        let (position, rotation) = scene::position_and_rotation(&found.pose);
        let _ = write!(self.text, "\n[[{kind}]]\nname = {}\nmaterial = {}\n", quoted(&name), quoted(material));
        if position != [0.0; 3] {
            let _ = writeln!(self.text, "position = {}", list(&position));
        }
        if rotation.iter().any(|angle| angle.abs() > 1e-9) {
            let _ = writeln!(self.text, "rotation = {}", list(&rotation));
        }
        self.text.push_str(&shape);
        if let Some(colour) = found.colour {
            let _ = writeln!(self.text, "colour = {}", list(&colour.map(|part| part.clamp(0.0, 1.0))));
        }
        if let Some(mass) = found.mass {
            let _ = writeln!(self.text, "mass = {}", number(mass));
        }
        let is_movable = found.mass.is_some();
        self.solids.push(ImportedSolid { name, kind, material: material.to_owned(), triangles, is_movable });
    }
}

/// True if a name fits a pattern, in which `*` is any text, in any case.
fn fits(pattern: &str, name: &str) -> bool {
    let (pattern, name) = (pattern.to_lowercase(), name.to_lowercase());
    let mut parts = pattern.split('*');
    let Some(mut rest) = parts.next().and_then(|first| name.strip_prefix(first)) else { return false };
    let Some(last) = parts.next_back() else { return rest.is_empty() };
    for part in parts {
        let Some(at) = rest.find(part) else { return false };
        rest = &rest[at + part.len()..];
    }
    rest.ends_with(last)
}

/// Returns a string of TOML.
fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

/// Returns a number to a hundredth of a millimetre, with a point.
fn number(value: f64) -> String {
    let rounded = (value * 1e5).round() / 1e5;
    format!("{:?}", if rounded == 0.0 { 0.0 } else { rounded })
}

fn list(values: &[f64]) -> String {
    format!("[{}]", values.iter().map(|&value| number(value)).collect::<Vec<_>>().join(", "))
}

/// Counts triangles, which all meshes of a map share.
#[derive(Default)]
struct Budget(usize);

impl Budget {
    fn add(&mut self, pieces: &[Piece]) -> Result<(), String> {
        self.0 += pieces.iter().map(|piece| piece.triangles.len()).sum::<usize>();
        let problem = || format!("meshes of more than {MAX_TRIANGLES} triangles together");
        if self.0 > MAX_TRIANGLES { Err(problem()) } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_fit_names() {
        for (pattern, name, expected) in [
            ("wall", "wall", true),
            ("wall", "walls", false),
            ("Wall*", "wall_12", true),
            ("*wall", "north-wall", true),
            ("*wall*", "the wall is", true),
            ("a*b*c", "a--b--c", true),
            ("a*b*c", "a--c--b", false),
            ("*", "", true),
            ("a*a", "a", false),
            ("", "x", false),
        ] {
            assert_eq!(fits(pattern, name), expected, "{pattern} {name}");
        }
    }
}
