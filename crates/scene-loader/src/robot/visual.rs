//! `[[visual]]`: visible shapes of a link instead of its colliding shapes and its wheel.

use std::ops::Range;

use scene::{Link, Shape, Visual, check};
use serde::Deserialize;

use super::joint::find_link;
use crate::document::{Document, Table, Vector};
use crate::mesh;
use crate::source::Source;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct VisualEntry {
    /// Link; without one, the body.
    link: Option<String>,
    size: Option<Vector>,
    radius: Option<f64>,
    length: Option<f64>,
    mesh: Option<String>,
    scale: Option<f64>,
    #[serde(default)]
    position: Vector,
    #[serde(default)]
    rotation: Vector,
    /// Colour instead of those of the mesh.
    colour: Option<[f64; 3]>,
    #[serde(default)]
    spin: f64,
}

/// Adds visuals to links. If not all links could be read, an unknown name is not reported.
pub(super) fn read_visuals<'a>(
    source: &Source,
    document: &mut Document<'a>,
    root: &mut Table<'a>,
    links: &mut [Link],
    complete: bool,
) {
    for (span, entry) in document.list::<VisualEntry>(root, "visual") {
        let link = find_link(document, &span, "link", entry.link.as_deref(), links, complete);
        for (shape, colour) in shapes(source, document, &span, &entry) {
            let VisualEntry { position, rotation, spin, .. } = entry;
            let visual = Visual { shape, position, rotation, colour, spin };
            document.wrong(&span, check::visual(&visual));
            if let Some(link) = link.and_then(|link| links.get_mut(link)) {
                link.visuals.push(visual);
            }
        }
    }
}

/// Rounds corners to a hundredth of a millimetre, finer than anybody sees. The further digits of a file's 32-bit numbers would
/// double the size of every log.
fn rounded(shape: Shape) -> Shape {
    let Shape::Mesh { mut vertices, triangles } = shape else { return shape };
    vertices.iter_mut().flatten().for_each(|part| *part = (*part * 1e5).round() / 1e5);
    Shape::Mesh { vertices, triangles }
}

fn shapes(
    source: &Source,
    document: &mut Document,
    span: &Range<usize>,
    entry: &VisualEntry,
) -> Vec<(Shape, [f64; 3])> {
    let colour = entry.colour.unwrap_or(mesh::COLOUR);
    match (entry.size, entry.radius, entry.length, &entry.mesh, entry.scale) {
        (Some(size), None, None, None, None) => vec![(Shape::Box { size }, colour)],
        (None, Some(radius), None, None, None) => vec![(Shape::Ball { radius }, colour)],
        (None, Some(radius), Some(length), None, None) => vec![(Shape::Cylinder { radius, length }, colour)],
        (None, None, None, Some(file), scale) => {
            let scale = scale.unwrap_or(1.0);
            if !document.within(span, "scale", scale, mesh::SCALE) {
                return Vec::new();
            }
            let pieces = mesh::pieces(source, file).unwrap_or_else(|reason| {
                document.problem(span, reason);
                Vec::new()
            });
            let piece = |it: mesh::Piece| {
                let colour = entry.colour.or(it.colour).unwrap_or(mesh::COLOUR);
                (rounded(it.scaled([scale; 3])), colour)
            };
            pieces.into_iter().map(piece).collect()
        }
        _ => {
            let expected =
                "expected `size` of a box, `radius` of a ball, `radius` and `length` of a cylinder, or `mesh`";
            document.problem(span, format_args!("a visual of no shape or of more than one: {expected}"));
            Vec::new()
        }
    }
}
