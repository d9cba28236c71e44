//! SDF of Gazebo (sdformat.org): its elements, frames and models. Maps are made of it.

pub(crate) mod frames;
pub(crate) mod models;

use roxmltree::Node;

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
