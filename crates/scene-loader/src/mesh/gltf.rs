//! glTF 2.0: a `.glb`, or a `.gltf` with its buffers in it or in files beside it. The specification defines y as up.
//!
//! Only what faces are made of is read: positions, indices, poses and colours. What else a file has may be broken or of a later version.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::{Component, Path};

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use gltf::accessor::sparse::IndexType;
use gltf::accessor::{DataType, Dimensions};
use gltf::json::Root;
use gltf::mesh::Mode;
use gltf::{Accessor, Document, Glb, Node, Semantic, buffer, json};
use nalgebra::{Matrix4, Point3};
use percent_encoding::percent_decode_str;
use scene::check::MAX_TRIANGLES;

use super::Piece;
use crate::source::{MAX_MESH, Source};

/// Maximum nesting of nodes.
const MAX_DEPTH: usize = 64;
/// Maximum number of placed nodes; a node counts at every place.
const MAX_NODES: usize = 100_000;
/// Extensions that change where faces are and are not read, each with what to do.
const COMPRESSED: [(&str, &str); 3] = [
    ("KHR_draco_mesh_compression", "its meshes are compressed by Draco"),
    ("EXT_meshopt_compression", "its meshes are compressed by meshopt"),
    ("KHR_meshopt_compression", "its meshes are compressed by meshopt"),
];

pub(super) fn read(source: &Source, bytes: &[u8]) -> Result<Vec<Piece>, String> {
    let (text, blob) = if bytes.starts_with(b"glTF") {
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
    let mut root = Root::from_slice(&text).map_err(|error| error.to_string())?;
    if let Some((name, why)) = COMPRESSED.iter().find(|(name, _)| root.extensions_required.iter().any(|it| it == name))
    {
        return Err(format!("{why} ({name}): expected a file without compression, as `gltf-transform copy` writes it"));
    }
    // The others change looks, or are read here.
    root.extensions_required.clear();
    let mut attributes = root.meshes.iter().flat_map(|mesh| &mesh.primitives).flat_map(|it| it.attributes.values());
    // The library uses these indices before it checks them.
    if attributes.any(|accessor| accessor.value() >= root.accessors.len()) {
        return Err("a mesh of an accessor that is not there".to_owned());
    }
    for accessor in &mut root.accessors {
        // The library wants bounds, which nothing needs.
        let zero = || Some(json::Value::from(vec![0.0; 3]));
        (accessor.min, accessor.max) = (accessor.min.take().or_else(zero), accessor.max.take().or_else(zero));
    }
    let gltf = Document::from_json(root).map_err(|error| error.to_string())?;
    let mut file = File { source, blob, buffers: BTreeMap::new(), left: MAX_MESH, pieces: Vec::new(), triangles: 0 };
    // y up to z up.
    let up = Matrix4::new(1.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0);
    let scene = gltf.default_scene().or_else(|| gltf.scenes().next()).ok_or("no scene")?;
    let mut open: Vec<_> = scene.nodes().map(|node| (node, up, 0)).collect();
    let mut count = 0;
    while let Some((node, parent, depth)) = open.pop() {
        count += 1;
        if depth > MAX_DEPTH || count > MAX_NODES {
            return Err(format!("expected at most {MAX_NODES} nodes, {MAX_DEPTH} inside each other"));
        }
        let pose = parent * Matrix4::from(node.transform().matrix());
        file.add(&node, &pose)?;
        open.extend(node.children().map(|child| (child, pose, depth + 1)));
    }
    Ok(file.pieces)
}

/// A file that is being read.
struct File<'a> {
    source: &'a Source,
    /// The buffer in a .glb.
    blob: Option<Vec<u8>>,
    /// Buffers that were needed, by their numbers.
    buffers: BTreeMap<usize, Vec<u8>>,
    /// Bytes that may still be read.
    left: u64,
    pieces: Vec<Piece>,
    triangles: usize,
}

impl File<'_> {
    fn add(&mut self, node: &Node, pose: &Matrix4<f32>) -> Result<(), String> {
        for primitive in node.mesh().iter().flat_map(gltf::Mesh::primitives) {
            if matches!(primitive.mode(), Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
                continue;
            }
            let positions = primitive.get(&Semantic::Positions).ok_or("a mesh without positions")?;
            if positions.dimensions() != Dimensions::Vec3 {
                return Err("positions that are not three numbers".to_owned());
            }
            let numbers = self.numbers(&positions)?;
            let place =
                |at: &[f64]| pose.transform_point(&Point3::new(at[0] as f32, at[1] as f32, at[2] as f32)).into();
            let vertices: Vec<[f32; 3]> = numbers.chunks_exact(3).map(place).collect();
            let indices: Vec<u32> = match primitive.indices() {
                Some(indices) if indices.dimensions() == Dimensions::Scalar => {
                    self.numbers(&indices)?.into_iter().map(|index| index as u32).collect()
                }
                Some(_) => return Err("indices that are not single numbers".to_owned()),
                None => (0..vertices.len() as u32).collect(),
            };
            if indices.iter().any(|&index| index as usize >= vertices.len()) {
                return Err(format!("an index beyond {} corners", vertices.len()));
            }
            let triangles = faces(primitive.mode(), &indices);
            self.triangles += triangles.len();
            if self.triangles > MAX_TRIANGLES {
                return Err(format!("expected at most {MAX_TRIANGLES} triangles"));
            }
            let [r, g, b, _] = primitive.material().pbr_metallic_roughness().base_color_factor();
            let colour = primitive.material().index().map(|_| [r, g, b].map(srgb));
            let name = node.name().or(node.mesh().and_then(|mesh| mesh.name())).map(str::to_owned);
            self.pieces.push(Piece { vertices, triangles, colour, name });
        }
        Ok(())
    }

    /// Returns the numbers of an accessor: zeros where it has no data, and those of its sparse part over the others.
    fn numbers(&mut self, accessor: &Accessor) -> Result<Vec<f64>, String> {
        let (count, parts) = (accessor.count(), accessor.dimensions().multiplicity());
        let kind = Elements { kind: accessor.data_type(), parts, is_normalized: accessor.normalized() };
        let number = accessor.index();
        let mut numbers = match accessor.view() {
            Some(view) => self.elements(number, &view, accessor.offset(), count, kind)?,
            // Zeros cost memory that the file does not have.
            None if count as u64 * parts as u64 > self.left => return Err(format!("accessor {number} is too long")),
            None => vec![0.0; count * parts],
        };
        if let Some(sparse) = accessor.sparse() {
            let (indices, values) = (sparse.indices(), sparse.values());
            let kind_of_index = match indices.index_type() {
                IndexType::U8 => DataType::U8,
                IndexType::U16 => DataType::U16,
                IndexType::U32 => DataType::U32,
            };
            let index = Elements { kind: kind_of_index, parts: 1, is_normalized: false };
            let places = self.elements(number, &indices.view(), indices.offset(), sparse.count(), index)?;
            let values = self.elements(number, &values.view(), values.offset(), sparse.count(), kind)?;
            for (place, value) in places.into_iter().zip(values.chunks_exact(parts)) {
                let place = numbers.get_mut(place as usize * parts..).and_then(|rest| rest.get_mut(..parts));
                place
                    .ok_or_else(|| format!("accessor {number}: a sparse index beyond {count}"))?
                    .copy_from_slice(value);
            }
        }
        Ok(numbers)
    }

    /// Reads elements of a view from an offset in it.
    fn elements(
        &mut self,
        accessor: usize,
        view: &buffer::View,
        offset: usize,
        count: usize,
        elements: Elements,
    ) -> Result<Vec<f64>, String> {
        let size = elements.kind.size() * elements.parts;
        let (start, length, stride) = (view.offset(), view.length(), view.stride().unwrap_or(size));
        let bytes = self.buffer(&view.buffer())?;
        let end = start.checked_add(length);
        let bytes = end
            .and_then(|end| bytes.get(start..end))
            .ok_or_else(|| format!("view {} of a buffer is longer than that", view.index()))?;
        let last = count.saturating_sub(1).checked_mul(stride);
        let end = last.and_then(|last| last.checked_add(offset)?.checked_add(size));
        if count > 0 && end.is_none_or(|end| end > bytes.len()) {
            return Err(format!("accessor {accessor} is longer than its view"));
        }
        let element = |number: usize| bytes.get(offset + number * stride..).unwrap_or_default();
        let all = (0..count).flat_map(|number| {
            element(number).chunks_exact(elements.kind.size()).take(elements.parts).map(|part| elements.read(part))
        });
        Ok(all.collect())
    }

    /// Returns a buffer, which is read when it is first needed.
    fn buffer(&mut self, buffer: &buffer::Buffer) -> Result<&[u8], String> {
        let number = buffer.index();
        if !self.buffers.contains_key(&number) {
            let bytes = match buffer.source() {
                buffer::Source::Bin => self.blob.take().ok_or("a buffer that is not there")?,
                buffer::Source::Uri(uri) if uri.starts_with("data:") => {
                    let (head, data) = uri.split_once(',').ok_or("a buffer as data without a comma")?;
                    if !head.ends_with(";base64") {
                        return Err("a buffer as data that is not base64".to_owned());
                    }
                    BASE64_STANDARD.decode(data.trim()).map_err(|error| format!("a buffer as data: {error}"))?
                }
                buffer::Source::Uri(file) => {
                    let file = percent_decode_str(file).decode_utf8_lossy();
                    let is_inside = |part: Component| matches!(part, Component::Normal(_) | Component::CurDir);
                    if !Path::new(&*file).components().all(is_inside) {
                        return Err(format!("buffer `{file}`: expected a file in the folder of the mesh"));
                    }
                    let bytes = self.source.bytes(&file, self.left).map_err(|error| error.to_string())?;
                    self.left -= bytes.len() as u64;
                    bytes
                }
            };
            self.buffers.insert(number, bytes);
        }
        Ok(self.buffers.get(&number).map(Vec::as_slice).unwrap_or_default())
    }
}

/// Kind of the elements of an accessor.
#[derive(Clone, Copy)]
struct Elements {
    kind: DataType,
    /// Numbers of an element.
    parts: usize,
    /// True if whole numbers stand for parts of 1 (KHR_mesh_quantization).
    is_normalized: bool,
}

impl Elements {
    /// Reads a number, little endian.
    fn read(self, bytes: &[u8]) -> f64 {
        let (value, most): (f64, f64) = match (self.kind, bytes) {
            (DataType::I8, &[a]) => (i8::from_le_bytes([a]).into(), i8::MAX.into()),
            (DataType::U8, &[a]) => (a.into(), u8::MAX.into()),
            (DataType::I16, &[a, b]) => (i16::from_le_bytes([a, b]).into(), i16::MAX.into()),
            (DataType::U16, &[a, b]) => (u16::from_le_bytes([a, b]).into(), u16::MAX.into()),
            (DataType::U32, &[a, b, c, d]) => (u32::from_le_bytes([a, b, c, d]).into(), u32::MAX.into()),
            (DataType::F32, &[a, b, c, d]) => return f32::from_le_bytes([a, b, c, d]).into(),
            _ => (0.0, 1.0),
        };
        if self.is_normalized { (value / most).max(-1.0) } else { value }
    }
}

/// Returns the triangles of a list, a strip or a fan of corners.
fn faces(mode: Mode, indices: &[u32]) -> Vec<[u32; 3]> {
    let triple = |corners: &[u32]| [corners[0], corners[1], corners[2]];
    match mode {
        Mode::TriangleStrip => {
            let turned = |(number, [a, b, c]): (usize, [u32; 3])| if number % 2 == 0 { [a, b, c] } else { [b, a, c] };
            indices.windows(3).map(triple).enumerate().map(turned).collect()
        }
        Mode::TriangleFan => {
            let (first, rest) = indices.split_first().map_or((0, &[][..]), |(first, rest)| (*first, rest));
            rest.windows(2).map(|pair| [first, pair[0], pair[1]]).collect()
        }
        _ => indices.chunks_exact(3).map(triple).collect(),
    }
}

/// Converts a linear colour component of glTF to sRGB (IEC 61966-2-1).
fn srgb(linear: f32) -> f64 {
    let linear = f64::from(linear).clamp(0.0, 1.0);
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}
