//! glTF 2.0: a `.glb`, or a `.gltf` with its buffers in files beside it. The specification defines y as up.

use std::borrow::Cow;

use gltf::accessor::{DataType, Dimensions};
use gltf::json::Root;
use gltf::mesh::Mode;
use gltf::{Accessor, Document, Glb, Node, Semantic, buffer};
use nalgebra::{Matrix4, Point3};
use scene::check::MAX_TRIANGLES;

use super::Piece;
use crate::source::{MAX_MESH, Source};

/// Maximum nesting of nodes.
const MAX_DEPTH: usize = 64;
/// Maximum number of placed nodes; a node counts at every place.
const MAX_NODES: usize = 100_000;

pub(super) fn read(source: &Source, bytes: &[u8]) -> Result<Vec<Piece>, String> {
    let (json, mut blob) = if bytes.starts_with(b"glTF") {
        // The library subtracts the 12 bytes of the header without a check.
        let length = bytes.get(8..12).and_then(|length| length.try_into().ok()).map(u32::from_le_bytes);
        if let Some(length) = length.filter(|&length| length < 12) {
            return Err(format!("the header says {length} bytes: expected at least its own 12"));
        }
        let file = Glb::from_slice(bytes).map_err(|error| error.to_string())?;
        (file.json, file.bin.map(Cow::into_owned))
    } else {
        (Cow::Borrowed(bytes), None)
    };
    let root = Root::from_slice(&json).map_err(|error| error.to_string())?;
    let mut attributes = root.meshes.iter().flat_map(|mesh| &mesh.primitives).flat_map(|it| it.attributes.values());
    // The library uses these indices before it checks them.
    if attributes.any(|accessor| accessor.value() >= root.accessors.len()) {
        return Err("a mesh of an accessor that is not there".to_owned());
    }
    let gltf = Document::from_json(root).map_err(|error| error.to_string())?;
    let mut left = MAX_MESH;
    let mut load = |buffer: buffer::Buffer| match buffer.source() {
        buffer::Source::Bin => blob.take().ok_or_else(|| "a buffer that is not there".to_owned()),
        buffer::Source::Uri(uri) if uri.starts_with("data:") => {
            Err("a buffer as data: expected a .glb, or a buffer in a file of its own".to_owned())
        }
        buffer::Source::Uri(file) => {
            let bytes = source.bytes(file, left).map_err(|error| error.to_string())?;
            left -= bytes.len() as u64;
            Ok(bytes)
        }
    };
    let buffers = gltf.buffers().map(&mut load).collect::<Result<Vec<_>, _>>()?;
    for view in gltf.views() {
        let within = |buffer: &Vec<u8>| view.offset().checked_add(view.length()).is_some_and(|end| end <= buffer.len());
        if !buffers.get(view.buffer().index()).is_some_and(within) {
            return Err(format!("view {} of a buffer is longer than that", view.index()));
        }
    }
    for accessor in gltf.accessors() {
        let Some(view) = accessor.view().filter(|_| accessor.sparse().is_none()) else {
            return Err(format!("accessor {} is sparse: expected numbers", accessor.index()));
        };
        let stride = view.stride().unwrap_or(accessor.size());
        let last = accessor.count().saturating_sub(1).checked_mul(stride);
        let end = last.and_then(|last| last.checked_add(accessor.offset())?.checked_add(accessor.size()));
        if end.is_none_or(|end| end > view.length()) {
            return Err(format!("accessor {} is longer than its view", accessor.index()));
        }
    }
    // y up to z up.
    let up = Matrix4::new(1.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0);
    let scene = gltf.default_scene().or_else(|| gltf.scenes().next()).ok_or("no scene")?;
    let (mut pieces, mut open) = (Vec::new(), Vec::new());
    open.extend(scene.nodes().map(|node| (node, up, 0)));
    let mut count = 0;
    while let Some((node, parent, depth)) = open.pop() {
        count += 1;
        if depth > MAX_DEPTH || count > MAX_NODES {
            return Err(format!("expected at most {MAX_NODES} nodes, {MAX_DEPTH} inside each other"));
        }
        let pose = parent * Matrix4::from(node.transform().matrix());
        add(&node, &pose, &buffers, &mut pieces)?;
        open.extend(node.children().map(|child| (child, pose, depth + 1)));
    }
    Ok(pieces)
}

fn add(node: &Node, pose: &Matrix4<f32>, buffers: &[Vec<u8>], pieces: &mut Vec<Piece>) -> Result<(), String> {
    for primitive in node.mesh().iter().flat_map(gltf::Mesh::primitives) {
        if primitive.mode() != Mode::Triangles {
            return Err(format!("{:?}: expected triangles", primitive.mode()));
        }
        let is_of = |accessor: &Accessor, dimensions, types: &[DataType]| {
            accessor.dimensions() == dimensions && types.contains(&accessor.data_type())
        };
        let positions = primitive.get(&Semantic::Positions);
        let indices = primitive.indices();
        if !positions.is_some_and(|it| is_of(&it, Dimensions::Vec3, &[DataType::F32]))
            || !indices.is_none_or(|it| is_of(&it, Dimensions::Scalar, &[DataType::U8, DataType::U16, DataType::U32]))
        {
            return Err("positions or indices of another type: expected three f32 and u8, u16 or u32".to_owned());
        }
        let reader = primitive.reader(|buffer| buffers.get(buffer.index()).map(Vec::as_slice));
        let corners = reader.read_positions().ok_or("a mesh without positions")?;
        let vertices: Vec<[f32; 3]> = corners.map(|at| pose.transform_point(&Point3::from(at)).into()).collect();
        let indices: Vec<u32> = match reader.read_indices() {
            Some(indices) => indices.into_u32().collect(),
            None => (0..vertices.len() as u32).collect(),
        };
        if indices.iter().any(|&index| index as usize >= vertices.len()) {
            return Err(format!("an index beyond {} corners", vertices.len()));
        }
        let triangles = indices.chunks_exact(3).map(|it| [it[0], it[1], it[2]]).collect();
        let [r, g, b, _] = primitive.material().pbr_metallic_roughness().base_color_factor();
        let colour = primitive.material().index().map(|_| [r, g, b].map(srgb));
        let name = node.name().or(node.mesh().and_then(|mesh| mesh.name())).map(str::to_owned);
        pieces.push(Piece { vertices, triangles, colour, name });
        if pieces.iter().map(|piece| piece.triangles.len()).sum::<usize>() > MAX_TRIANGLES {
            return Err(format!("expected at most {MAX_TRIANGLES} triangles"));
        }
    }
    Ok(())
}

/// Converts a linear colour component of glTF to sRGB (IEC 61966-2-1).
fn srgb(linear: f32) -> f64 {
    let linear = f64::from(linear).clamp(0.0, 1.0);
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}
