//! Triangle meshes from STL and OBJ files.

use std::io::Cursor;

use scene::Shape;
use scene::check::{MAX_TRIANGLES, Range};

use crate::LoadError;
use crate::source::{MAX_MESH, Source};

/// By how much a mesh is scaled: files are in metres, millimetres or inches.
pub(crate) const SCALE: Range = Range { least: 1e-6, most: 1e6, unit: "" };

/// Reads a mesh and scales it along the axes of its file. Files are z up, as is usual; the result is in the frame of the
/// solid, z down.
pub(crate) fn read(source: &Source, name: &str, scale: [f64; 3]) -> Result<Shape, String> {
    let parse = match name.rsplit('.').next().map(str::to_ascii_lowercase).as_deref() {
        Some("stl") => stl,
        Some("obj") => obj,
        _ => return Err(format!("mesh `{name}`: expected a file that ends in .stl or .obj")),
    };
    let bytes = source.bytes(name, MAX_MESH).map_err(|error: LoadError| error.to_string())?;
    let (vertices, triangles) = parse(&bytes).map_err(|reason| format!("mesh `{name}`: {reason}"))?;
    if triangles.is_empty() || triangles.len() > MAX_TRIANGLES {
        return Err(format!("mesh `{name}` has {} triangles: expected 1 to {MAX_TRIANGLES}", triangles.len()));
    }
    let z_down = |[x, y, z]: [f32; 3]| {
        let [x, y, z] = [x, y, z].map(f64::from);
        [x * scale[0], -y * scale[1], -z * scale[2]]
    };
    Ok(Shape::Mesh { vertices: vertices.into_iter().map(z_down).collect(), triangles })
}

type Mesh = (Vec<[f32; 3]>, Vec<[u32; 3]>);

fn stl(bytes: &[u8]) -> Result<Mesh, String> {
    let mesh = stl_io::read_stl(&mut Cursor::new(bytes)).map_err(|error| error.to_string())?;
    let vertices = mesh.vertices.iter().map(|vertex| [vertex[0], vertex[1], vertex[2]]).collect();
    let triangles = mesh.faces.iter().map(|face| face.vertices.map(|index| index as u32)).collect();
    Ok((vertices, triangles))
}

fn obj(bytes: &[u8]) -> Result<Mesh, String> {
    let options = tobj::LoadOptions { triangulate: true, ..tobj::LoadOptions::default() };
    // Material libraries are about looks; the physical material is the map's.
    let no_materials = |_: &std::path::Path| Err(tobj::LoadError::GenericFailure);
    let geometry = geometry(&String::from_utf8_lossy(bytes));
    let (models, _) =
        tobj::load_obj_buf(&mut Cursor::new(geometry), &options, no_materials).map_err(|error| error.to_string())?;
    let (mut vertices, mut triangles): Mesh = (Vec::new(), Vec::new());
    for model in models {
        let first = vertices.len() as u32;
        vertices.extend(model.mesh.positions.chunks_exact(3).map(|point| [point[0], point[1], point[2]]));
        let faces = model.mesh.indices.chunks_exact(3);
        triangles.extend(faces.map(|face| [face[0] + first, face[1] + first, face[2] + first]));
    }
    Ok((vertices, triangles))
}

/// Corners and faces alone: tobj trusts the indices of textures and normals, and nobody needs them.
fn geometry(text: &str) -> String {
    let mut geometry = String::with_capacity(text.len());
    for line in text.lines() {
        let mut words = line.split_whitespace();
        let Some(kind @ ("v" | "f")) = words.next() else { continue };
        geometry.push_str(kind);
        for word in words {
            geometry.push(' ');
            geometry.push_str(word.split('/').next().unwrap_or_default());
        }
        geometry.push('\n');
    }
    geometry
}
