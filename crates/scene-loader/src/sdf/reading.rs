//! Reading of files of SDF that include each other, for maps and for robots.

use nalgebra::Isometry3;
use roxmltree::Node;

use super::frames::{FrameError, Frames};
use super::{ROOTS, child, is_true, text_of};
use crate::LoadError;
use crate::problem::Problems;
use crate::source::{MAX_TEXT, Source};
use crate::xml;

/// Maximum number of elements, attributes and texts of a file.
pub(super) const MAX_NODES: u32 = 500_000;
/// Maximum nesting of models, and of files that include each other.
pub(crate) const MAX_DEPTH: usize = 16;
/// Maximum number of included files: files that include each other twice would be read without end.
pub(crate) const MAX_INCLUDED: usize = 1000;

/// A file that is being read.
#[derive(Clone, Copy)]
pub(crate) struct Place<'a> {
    pub(crate) source: &'a Source,
    pub(crate) shown: &'a str,
    pub(crate) text: &'a str,
    /// Number of files and models around.
    pub(crate) depth: usize,
}

/// Opens a file, and lets a function read its root.
pub(crate) fn file(
    source: &Source,
    file: &str,
    depth: usize,
    read: impl FnOnce(Place, Node) -> Result<(), LoadError>,
) -> Result<(), LoadError> {
    let (text, shown) = (source.xml(file, MAX_TEXT)?, source.display(file));
    let unreadable = |reason: String| LoadError::Unreadable { file: shown.clone(), reason };
    let document = xml::parse(&text, MAX_NODES).map_err(|error| unreadable(error.to_string()))?;
    let root = document.root_element();
    if !ROOTS.contains(&root.tag_name().name()) {
        return Err(unreadable(format!("<{}>: expected <sdf>", root.tag_name().name())));
    }
    read(Place { source, shown: &shown, text: &text, depth }, root)
}

impl Place<'_> {
    /// Reports a problem of an element.
    pub(crate) fn problem(self, problems: &mut Problems, node: Node, message: impl std::fmt::Display) {
        problems.at(self.shown, self.text, node.range().start, message);
    }

    /// Returns a pose, or reports why there is none.
    pub(crate) fn posed(
        self,
        problems: &mut Problems,
        node: Node,
        pose: Result<Isometry3<f64>, FrameError>,
    ) -> Isometry3<f64> {
        pose.unwrap_or_else(|error| {
            self.problem(problems, child(node, "pose").unwrap_or(node), error);
            Isometry3::identity()
        })
    }
}

/// Settings of a model by whoever includes it; what is `None` is the model's own.
#[derive(Default)]
pub(crate) struct Included {
    /// Pose of what is around it.
    pub(crate) parent: Isometry3<f64>,
    pub(crate) pose: Option<Isometry3<f64>>,
    pub(crate) name: Option<String>,
    pub(crate) is_static: Option<bool>,
    /// True if its links become those of the model around it.
    pub(crate) is_merged: bool,
    /// Frame of the model that the pose places.
    pub(crate) placed: Option<String>,
}

impl Included {
    /// Reads what an include says of its model. `frames` are those around it, and `parent` is their pose.
    pub(crate) fn of<'a, 'i>(
        place: Place,
        node: Node<'a, 'i>,
        frames: &Frames<'a, 'i>,
        parent: Isometry3<f64>,
        problems: &mut Problems,
    ) -> Self {
        let has_pose = child(node, "pose").is_some_and(|pose| pose.text().is_some_and(|text| !text.trim().is_empty()));
        let text = |tag: &str| Some(text_of(node, tag)).filter(|text| !text.is_empty()).map(str::to_owned);
        Self {
            parent,
            pose: has_pose.then(|| place.posed(problems, node, frames.pose(node))),
            name: text("name"),
            is_static: child(node, "static").map(|node| is_true(node.text().unwrap_or_default().trim())),
            is_merged: node.attribute("merge").is_some_and(is_true),
            placed: text("placement_frame"),
        }
    }

    /// Returns the pose of the included model. `frames` are those inside of it; without a word of the include its pose is `own`.
    pub(crate) fn placed<'a, 'i>(
        &self,
        place: Place,
        node: Node<'a, 'i>,
        frames: &Frames<'a, 'i>,
        own: impl FnOnce() -> Result<Isometry3<f64>, FrameError>,
        problems: &mut Problems,
    ) -> Isometry3<f64> {
        let pose = self.pose.unwrap_or_else(|| place.posed(problems, node, own()));
        let placed = self.placed.as_deref().or(node.attribute("placement_frame")).filter(|frame| !frame.is_empty());
        let offset = match placed {
            Some(frame) => place.posed(problems, node, frames.named(frame)).inverse(),
            None => Isometry3::identity(),
        };
        self.parent * pose * offset
    }
}
