//! Triangle meshes from STL and OBJ files.

use std::io::Cursor;

use sim_core::scene::Shape;

use crate::LoadError;
use crate::source::Source;

/// Most triangles of one mesh.
const MAX_TRIANGLES: usize = 2_000_000;

/// Reads a mesh and scales it. Files are z up, as is usual; the result is in the frame of the solid, z down.
pub(crate) fn read(source: &Source, name: &str, scale: f64) -> Result<Shape, String> {
    let parse = match name.rsplit('.').next().map(str::to_ascii_lowercase).as_deref() {
        Some("stl") => stl,
        Some("obj") => obj,
        _ => return Err(format!("mesh `{name}`: expected a file that ends in .stl or .obj")),
    };
    let bytes = source.bytes(name).map_err(|error: LoadError| error.to_string())?;
    let (vertices, triangles) = parse(&bytes).map_err(|reason| format!("mesh `{name}`: {reason}"))?;
    if triangles.is_empty() || triangles.len() > MAX_TRIANGLES {
        return Err(format!("mesh `{name}` has {} triangles: expected 1 to {MAX_TRIANGLES}", triangles.len()));
    }
    let z_down = |[x, y, z]: [f32; 3]| [x, -y, -z].map(|component| f64::from(component) * scale);
    let vertices: Vec<[f64; 3]> = vertices.into_iter().map(z_down).collect();
    if !vertices.iter().flatten().all(|component| component.is_finite()) {
        return Err(format!("mesh `{name}` has a coordinate that is not finite"));
    }
    Ok(Shape::Mesh { vertices, triangles })
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
    let (models, _) =
        tobj::load_obj_buf(&mut Cursor::new(bytes), &options, no_materials).map_err(|error| error.to_string())?;
    let (mut vertices, mut triangles): Mesh = (Vec::new(), Vec::new());
    for model in models {
        let first = vertices.len() as u32;
        vertices.extend(model.mesh.positions.chunks_exact(3).map(|point| [point[0], point[1], point[2]]));
        let faces = model.mesh.indices.chunks_exact(3);
        triangles.extend(faces.map(|face| [face[0] + first, face[1] + first, face[2] + first]));
    }
    Ok((vertices, triangles))
}
