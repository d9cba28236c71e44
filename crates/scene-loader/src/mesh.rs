//! Triangle meshes from files.

mod collada;
mod gltf;
mod simplify;

use std::collections::HashMap;
use std::fmt::Write;
use std::io::Cursor;

use scene::Shape;
use scene::check::{MAX_TRIANGLES, Range};

pub(crate) use simplify::{simplified, size};

use crate::LoadError;
use crate::source::{MAX_MESH, Source};

/// Scale of a mesh: files are in metres, millimetres or inches.
pub(crate) const SCALE: Range = Range { least: 1e-6, most: 1e6, unit: "" };
/// Colour of a mesh without one.
pub(crate) const COLOUR: [f64; 3] = [0.72, 0.72, 0.74];

/// Name that the reader of OBJ gives to triangles before the first object.
const UNNAMED: &str = "unnamed_object";

/// Triangles of one colour, in the axes of their file: z up, or converted to that by its reader.
#[derive(Default)]
pub(crate) struct Piece {
    pub(crate) vertices: Vec<[f32; 3]>,
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Red, green and blue, if the file gives them.
    pub(crate) colour: Option<[f64; 3]>,
    /// Name of its object, if the file gives one.
    pub(crate) name: Option<String>,
}

/// Reads a mesh as one surface and scales it along the axes of its file. Files are z up, as usual; the result is in the frame of
/// the solid, z down.
pub(crate) fn read(source: &Source, name: &str, scale: [f64; 3]) -> Result<Shape, String> {
    Ok(joined(pieces(source, name)?).scaled(scale))
}

/// Joins pieces into one, with the first colour.
pub(crate) fn joined(pieces: Vec<Piece>) -> Piece {
    let mut whole = Piece { colour: pieces.iter().find_map(|piece| piece.colour), ..Piece::default() };
    for piece in pieces {
        let first = whole.vertices.len() as u32;
        whole.vertices.extend(piece.vertices);
        whole.triangles.extend(piece.triangles.iter().map(|corners| corners.map(|corner| corner + first)));
    }
    whole
}

/// Writes a mesh as OBJ.
pub(crate) fn as_obj(piece: &Piece) -> Vec<u8> {
    let mut text = String::new();
    for [x, y, z] in &piece.vertices {
        let _ = writeln!(text, "v {x} {y} {z}");
    }
    for [a, b, c] in piece.triangles.iter().map(|triangle| triangle.map(|index| index + 1)) {
        let _ = writeln!(text, "f {a} {b} {c}");
    }
    text.into_bytes()
}

/// Reads the pieces of a mesh.
pub(crate) fn pieces(source: &Source, name: &str) -> Result<Vec<Piece>, String> {
    read_pieces(source, name, false)
}

/// Reads the pieces of a mesh, at least one for each named object.
pub(crate) fn named_pieces(source: &Source, name: &str) -> Result<Vec<Piece>, String> {
    read_pieces(source, name, true)
}

fn read_pieces(source: &Source, name: &str, by_object: bool) -> Result<Vec<Piece>, String> {
    let bytes = || source.bytes(name, MAX_MESH).map_err(|error: LoadError| error.to_string());
    let ending = name.rsplit('.').next().map(str::to_ascii_lowercase);
    let pieces = match ending.as_deref() {
        Some("stl") => stl(&bytes()?),
        Some("obj") => obj(&bytes()?, by_object),
        Some("dae") => collada::read(&bytes()?),
        Some("glb" | "gltf") => gltf::read(source, &bytes()?),
        _ => return Err(format!("mesh `{name}`: expected a file that ends in .stl, .obj, .dae, .glb or .gltf")),
    };
    let mut pieces = pieces.map_err(|reason| format!("mesh `{name}`: {reason}"))?;
    // Exporters write empty ones for materials without faces.
    pieces.retain(|piece| !piece.triangles.is_empty());
    let count: usize = pieces.iter().map(|piece| piece.triangles.len()).sum();
    if !(1..=MAX_TRIANGLES).contains(&count) {
        return Err(format!("mesh `{name}` has {count} triangles: expected 1 to {MAX_TRIANGLES}"));
    }
    Ok(pieces)
}

impl Piece {
    /// Scales the piece along the axes of its file and converts it to z down.
    pub(crate) fn scaled(self, scale: [f64; 3]) -> Shape {
        let z_down = |[x, y, z]: [f32; 3]| {
            let [x, y, z] = [x, y, z].map(f64::from);
            [x * scale[0], -y * scale[1], -z * scale[2]]
        };
        Shape::Mesh { vertices: self.vertices.into_iter().map(z_down).collect(), triangles: self.triangles }
    }
}

/// Bytes before the triangles of a binary STL, and of each triangle.
const STL_HEAD: usize = 84;
const STL_TRIANGLE: usize = 50;

/// Reads an STL. A file whose length fits its count of triangles is binary, whatever its header says; exporters write `solid` there, too.
fn stl(bytes: &[u8]) -> Result<Vec<Piece>, String> {
    let count = bytes.get(STL_HEAD - 4..STL_HEAD).and_then(|count| count.try_into().ok()).map(u32::from_le_bytes);
    let length = count.and_then(|count| STL_TRIANGLE.checked_mul(count as usize)?.checked_add(STL_HEAD));
    let is_text = bytes.trim_ascii_start().get(..5).is_some_and(|begin| begin.eq_ignore_ascii_case(b"solid"));
    let corners = match length {
        Some(length) if length == bytes.len() || !is_text && length < bytes.len() => {
            bytes[STL_HEAD..length].chunks_exact(STL_TRIANGLE).flat_map(binary_corners).collect()
        }
        _ if is_text => text_corners(&String::from_utf8_lossy(bytes))?,
        Some(length) => {
            return Err(format!("{} bytes: expected {length}, as its count of triangles says", bytes.len()));
        }
        None => return Err(format!("{} bytes: expected an STL", bytes.len())),
    };
    Ok(vec![of_corners(&corners)])
}

/// Returns the corners of a triangle of a binary STL, after its normal.
fn binary_corners(triangle: &[u8]) -> impl Iterator<Item = [f32; 3]> {
    let number = |bytes: &[u8]| f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
    triangle[12..48]
        .chunks_exact(12)
        .map(move |corner| [number(&corner[..4]), number(&corner[4..8]), number(&corner[8..])])
}

/// Returns the corners in an STL of text, three for each triangle.
fn text_corners(text: &str) -> Result<Vec<[f32; 3]>, String> {
    let mut words = text.split_whitespace();
    let mut corners = Vec::new();
    while let Some(word) = words.next() {
        if word.eq_ignore_ascii_case("vertex") {
            let mut number = || words.next().and_then(|word| word.parse().ok());
            let corner = (|| Some([number()?, number()?, number()?]))();
            corners.push(corner.ok_or_else(|| format!("corner {}: expected three numbers", corners.len() + 1))?);
        }
    }
    if corners.len() % 3 == 0 { Ok(corners) } else { Err("a triangle without three corners".to_owned()) }
}

/// Makes a piece of corners, three for each triangle. Equal corners become one.
fn of_corners(corners: &[[f32; 3]]) -> Piece {
    let (mut piece, mut known) = (Piece::default(), HashMap::with_capacity(corners.len() / 4));
    let mut place = |corner: &[f32; 3]| {
        *known.entry(corner.map(|part| (part + 0.0).to_bits())).or_insert_with(|| {
            piece.vertices.push(*corner);
            piece.vertices.len() as u32 - 1
        })
    };
    let triangles = corners.chunks_exact(3).map(|it| [place(&it[0]), place(&it[1]), place(&it[2])]).collect();
    Piece { triangles, ..piece }
}

fn obj(bytes: &[u8], by_object: bool) -> Result<Vec<Piece>, String> {
    let options = tobj::LoadOptions { triangulate: true, ..tobj::LoadOptions::default() };
    // Material libraries only affect looks; the physical material is the map's.
    let no_materials = |_: &std::path::Path| Err(tobj::LoadError::GenericFailure);
    let geometry = geometry(&String::from_utf8_lossy(bytes), by_object);
    let (models, _) =
        tobj::load_obj_buf(&mut Cursor::new(geometry), &options, no_materials).map_err(|error| error.to_string())?;
    let piece = |model: tobj::Model| Piece {
        vertices: model.mesh.positions.chunks_exact(3).map(|point| [point[0], point[1], point[2]]).collect(),
        triangles: model.mesh.indices.chunks_exact(3).map(|face| [face[0], face[1], face[2]]).collect(),
        colour: None,
        name: Some(model.name).filter(|name| by_object && name != UNNAMED),
    };
    Ok(models.into_iter().map(piece).collect())
}

/// Keeps only corners and faces, and the names of objects if they are wanted: tobj trusts the indices of textures and normals, which are
/// not needed. A line that ends in `\` goes on in the next one.
fn geometry(text: &str, by_object: bool) -> String {
    let text = text.replace("\\\r\n", " ").replace("\\\n", " ");
    let mut geometry = String::with_capacity(text.len());
    for line in text.lines() {
        let mut words = line.split_whitespace();
        let (kind, most) = match words.next() {
            // After its place a corner may have a weight or a colour.
            Some("v") => ("v", 3),
            // `fo` is an older word for a face.
            Some("f" | "fo") => ("f", usize::MAX),
            Some("o" | "g") if by_object => {
                geometry.push_str(line.trim());
                geometry.push('\n');
                continue;
            }
            _ => continue,
        };
        if kind == "f" && words.clone().count() < 3 {
            continue;
        }
        geometry.push_str(kind);
        for word in words.take(most) {
            geometry.push(' ');
            geometry.push_str(word.split('/').next().unwrap_or_default());
        }
        geometry.push('\n');
    }
    geometry
}
