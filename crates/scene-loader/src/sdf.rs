//! SDF of Gazebo (sdformat.org): its elements, frames and models. Maps and robots are made of it.

pub(crate) mod frames;
pub(crate) mod models;
pub(crate) mod reading;
pub(crate) mod robot;
pub(crate) mod solids;

use roxmltree::Node;

use crate::mesh::{self, Piece};

/// Roots of a file: the second in Gazebo's first years.
pub(crate) const ROOTS: [&str; 2] = ["sdf", "gazebo"];

/// True for the text of a true boolean.
pub(crate) fn is_true(text: &str) -> bool {
    ["true", "1"].contains(&text)
}

/// Returns the children with a tag.
pub(crate) fn children<'a, 'i>(node: Node<'a, 'i>, tag: &'static str) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children().filter(move |it| it.has_tag_name(tag))
}

/// Returns the first child with a tag.
pub(crate) fn child<'a, 'i>(node: Node<'a, 'i>, tag: &'static str) -> Option<Node<'a, 'i>> {
    children(node, tag).next()
}

/// Returns the text of a child; empty without one.
pub(crate) fn text_of<'a>(node: Node<'a, '_>, tag: &str) -> &'a str {
    node.children().find(|it| it.has_tag_name(tag)).and_then(|it| it.text()).unwrap_or_default().trim()
}

/// Returns the number in a child; `None` without one.
pub(crate) fn number_of(node: Node, tag: &str) -> Option<f64> {
    numbers::<1>(text_of(node, tag)).map(|[number]| number)
}

/// Reads exactly as many finite numbers as are wanted.
pub(crate) fn numbers<const COUNT: usize>(text: &str) -> Option<[f64; COUNT]> {
    let numbers: Option<Vec<f64>> =
        text.split_whitespace().map(|word| word.parse().ok().filter(|it: &f64| it.is_finite())).collect();
    numbers?.try_into().ok()
}

/// Joins the pieces of a mesh, or those of the part that its `<submesh>` names.
pub(crate) fn submesh(mut pieces: Vec<Piece>, mesh: Node) -> Result<Piece, String> {
    let submesh = child(mesh, "submesh");
    if let Some(name) = submesh.map(|node| text_of(node, "name")).filter(|name| !name.is_empty()) {
        pieces.retain(|piece| piece.name.as_deref() == Some(name));
        if pieces.is_empty() {
            return Err(format!("mesh `{}` has no part `{name}`", text_of(mesh, "uri")));
        }
    }
    let mut piece = mesh::joined(pieces);
    if submesh.is_some_and(|node| is_true(text_of(node, "center"))) {
        let ends = |axis: usize| {
            let all = piece.vertices.iter().map(|vertex| vertex[axis]);
            all.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], at| [low.min(at), high.max(at)])
        };
        let middle = [0, 1, 2].map(ends).map(|[low, high]| (low + high) / 2.0);
        let centred = |vertex: &[f32; 3]| std::array::from_fn(|axis| vertex[axis] - middle[axis]);
        piece.vertices.iter_mut().for_each(|vertex| *vertex = centred(vertex));
    }
    Ok(piece)
}
