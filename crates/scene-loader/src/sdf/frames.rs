//! Frames of SDF: every link, joint, model and `<frame>` is one, and a pose may be relative to any in its world or model
//! (sdformat.org, "Pose frame semantics").

use std::cell::Cell;
use std::collections::BTreeMap;

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use roxmltree::Node;

/// Longest chain of frames.
const MAX_CHAIN: usize = 64;
/// Most times that frames inside of other models are looked up from a world or a model: each takes as long as that model is large.
const MAX_INSIDE: usize = 1000;

/// A pose that cannot be known.
#[derive(Debug, thiserror::Error)]
pub(crate) enum FrameError {
    #[error("a pose that is not `x y z roll pitch yaw`")]
    Numbers,
    #[error("no frame `{0}`")]
    Unknown(String),
    #[error("frames that hang on each other in a circle, at `{0}`")]
    Circle(String),
    #[error("more than {MAX_INSIDE} poses relative to frames inside of other models")]
    TooMany,
}

/// The frames of a world or a model.
pub(crate) struct Frames<'a, 'i> {
    nodes: BTreeMap<String, Node<'a, 'i>>,
    /// Name of the world or model itself.
    own: Option<&'a str>,
    /// Lookups inside of other models so far.
    inside: Cell<usize>,
}

impl<'a, 'i> Frames<'a, 'i> {
    /// Collects the frames in a world or a model.
    pub(crate) fn of(scope: Node<'a, 'i>) -> Self {
        let kinds = ["link", "joint", "model", "frame", "include"];
        let nodes = scope.children().filter(|node| kinds.contains(&node.tag_name().name()));
        let nodes = nodes.filter_map(|node| Some((name_of(node)?, node))).collect();
        Self { nodes, own: scope.attribute("name"), inside: Cell::new(0) }
    }

    /// Returns the pose of an element in its world or model.
    pub(crate) fn pose(&self, node: Node<'a, 'i>) -> Result<Isometry3<f64>, FrameError> {
        self.pose_within(node, 0)
    }

    /// Returns the pose of an element that is usually relative to one of these frames.
    pub(crate) fn pose_on(&self, node: Node<'a, 'i>, usual: &Isometry3<f64>) -> Result<Isometry3<f64>, FrameError> {
        let own = pose(node)?;
        match relative(node) {
            Some(frame) => Ok(self.frame(frame, 0)? * own),
            None => Ok(usual * own),
        }
    }

    /// Returns the pose of a frame by its name.
    pub(crate) fn named(&self, name: &str) -> Result<Isometry3<f64>, FrameError> {
        self.frame(name, 0)
    }

    fn pose_within(&self, node: Node<'a, 'i>, depth: usize) -> Result<Isometry3<f64>, FrameError> {
        let own = pose(node)?;
        let child_of = |tag: &str| node.children().find(|it| it.has_tag_name(tag)).and_then(|it| it.text());
        // Without a word, a joint is at its child, and a frame at what it is attached to.
        let usual = match node.tag_name().name() {
            "joint" => child_of("child").map(str::trim),
            "frame" => node.attribute("attached_to"),
            _ => None,
        };
        let frame = relative(node).or(usual.filter(|frame| !frame.is_empty()));
        frame.map_or(Ok(own), |frame| Ok(self.frame(frame, depth + 1)? * own))
    }

    fn frame(&self, name: &str, depth: usize) -> Result<Isometry3<f64>, FrameError> {
        if depth > MAX_CHAIN {
            return Err(FrameError::Circle(name.to_owned()));
        }
        if ["world", "__model__", "__root__"].contains(&name) {
            return Ok(Isometry3::identity());
        }
        if let Some(node) = self.nodes.get(name) {
            return self.pose_within(*node, depth);
        }
        // Gazebo's own examples name a model from inside.
        if self.own == Some(name) {
            return Ok(Isometry3::identity());
        }
        let unknown = || FrameError::Unknown(name.to_owned());
        let (model, rest) = name.split_once("::").ok_or_else(unknown)?;
        let node = self.nodes.get(model).filter(|node| node.has_tag_name("model")).ok_or_else(unknown)?;
        self.inside.set(self.inside.get() + 1);
        if self.inside.get() > MAX_INSIDE {
            return Err(FrameError::TooMany);
        }
        Ok(self.pose_within(*node, depth)? * Frames::of(*node).frame(rest, depth + 1)?)
    }
}

/// Returns the name of a frame: its own, or the last part of an included model's address.
fn name_of(node: Node) -> Option<String> {
    let text = |tag: &str| node.children().find(|it| it.has_tag_name(tag)).and_then(|it| it.text()).map(str::trim);
    match node.attribute("name").or_else(|| text("name")) {
        Some(name) => Some(name.to_owned()),
        None => text("uri").and_then(|uri| uri.rsplit('/').next()).map(str::to_owned),
    }
}

/// Returns the frame that an element's pose is relative to, if it says one. Before SDF 1.7 the attribute was `frame`.
pub(crate) fn relative<'a>(node: Node<'a, '_>) -> Option<&'a str> {
    let pose = node.children().find(|it| it.has_tag_name("pose"))?;
    pose.attribute("relative_to").or(pose.attribute("frame")).filter(|frame| !frame.is_empty())
}

/// Reads the numbers of an element's pose, z up.
pub(crate) fn pose(node: Node) -> Result<Isometry3<f64>, FrameError> {
    let Some(pose) = node.children().find(|it| it.has_tag_name("pose")) else { return Ok(Isometry3::identity()) };
    let text = pose.text().unwrap_or_default().trim();
    let words: Option<Vec<f64>> = text.split_whitespace().map(|word| word.parse().ok()).collect();
    let numbers = words.filter(|numbers| numbers.iter().all(|it| it.is_finite())).ok_or(FrameError::Numbers)?;
    let unit = if pose.attribute("degrees") == Some("true") { std::f64::consts::PI / 180.0 } else { 1.0 };
    let (place, turn) = match (pose.attribute("rotation_format").unwrap_or("euler_rpy"), numbers.as_slice()) {
        (_, []) => return Ok(Isometry3::identity()),
        ("quat_xyzw", &[x, y, z, i, j, k, w]) => {
            let turn = UnitQuaternion::try_new(nalgebra::Quaternion::new(w, i, j, k), 1e-9);
            (Vector3::new(x, y, z), turn.ok_or(FrameError::Numbers)?)
        }
        ("euler_rpy", &[x, y, z, roll, pitch, yaw]) => {
            (Vector3::new(x, y, z), UnitQuaternion::from_euler_angles(roll * unit, pitch * unit, yaw * unit))
        }
        // Gazebo takes what is missing for zero.
        ("euler_rpy", &[x, y, z]) => (Vector3::new(x, y, z), UnitQuaternion::identity()),
        _ => return Err(FrameError::Numbers),
    };
    Ok(Isometry3::from_parts(place.into(), turn))
}
