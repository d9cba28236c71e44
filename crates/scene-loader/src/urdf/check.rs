//! Checks of a URDF that report lines, which the URDF library does not.

use std::collections::BTreeMap;

use names::{did_you_mean, listed};
use roxmltree::{Node, NodeType};
use scene::check::{ANGLE, INERTIA, ROBOT_REACH, Range};

use crate::problem::Problems;

/// Maximum nesting of elements, as the URDF library recurses into them. A URDF has six levels, extensions of simulators twelve.
const MAX_DEPTH: usize = 64;
/// Maximum number of links, and of joints.
const MAX_LINKS: usize = 1000;

/// Least length of an axis. A shorter one is a mistake, and squares of smaller numbers are lost.
const LEAST_AXIS: f64 = 1e-9;

/// Types of joints. `spherical` is none of ROS, but of other readers, as PyBullet's.
const JOINT_TYPES: [&str; 7] = ["fixed", "continuous", "revolute", "prismatic", "floating", "planar", "spherical"];

pub(super) struct Check<'a> {
    pub(super) file: &'a str,
    pub(super) text: &'a str,
    pub(super) problems: &'a mut Problems,
    pub(super) good: bool,
}

impl Check<'_> {
    fn problem(&mut self, node: Node, message: impl std::fmt::Display) {
        self.good = false;
        self.problems.at(self.file, self.text, node.range().start, message);
    }

    pub(super) fn robot(&mut self, robot: Node) {
        if let Some((node, what)) = robot.descendants().find_map(|node| Some((node, of_xacro(robot, node)?))) {
            self.problem(node, unexpanded(&what));
            return;
        }
        let deep = |node: &Node| node.ancestors().nth(MAX_DEPTH).is_some();
        if let Some(node) = robot.descendants().find(deep) {
            self.problem(node, format_args!("<{}> is too deep: expected {MAX_DEPTH} levels", node.tag_name().name()));
            return;
        }
        if robot.tag_name().name() != "robot" {
            self.problem(robot, format_args!("<{}>: expected <robot>", robot.tag_name().name()));
            return;
        }
        let children = |tag: &'static str| robot.children().filter(move |node| node.has_tag_name(tag));
        for tag in ["link", "joint"] {
            let count = children(tag).count();
            if count > MAX_LINKS {
                self.problem(robot, format_args!("{count} <{tag}>: expected at most {MAX_LINKS}"));
                return;
            }
        }
        let links: Vec<&str> = children("link").filter_map(|link| link.attribute("name")).collect();
        if links.is_empty() {
            self.problem(robot, "no <link>: expected at least one");
        }
        for (index, link) in children("link").enumerate() {
            let name = self.attribute(link, "name");
            if name.is_some_and(|name| links[..index.min(links.len())].contains(&name)) {
                self.problem(link, format_args!("second link `{}`: expected unique names", name.unwrap_or_default()));
            }
        }
        for joint in children("joint") {
            self.joint(joint, &links);
        }
        if self.good {
            self.tree(robot, children("joint").collect(), &links);
        }
        for part in robot.children().filter(|part| part.has_tag_name("link") || part.has_tag_name("joint")) {
            // Visuals and parts of other programs refuse no robot.
            let of_part = part.children().filter(|node| !node.has_tag_name("visual"));
            for node in of_part.flat_map(|node| node.descendants()).filter(Node::is_element) {
                self.numbers(node);
            }
            for collision in part.children().filter(|node| node.has_tag_name("collision")) {
                self.shape(collision);
            }
        }
    }

    /// Checks that the links are a tree: one without a parent, and all others with one.
    fn tree(&mut self, robot: Node, joints: Vec<Node>, links: &[&str]) {
        let mut parents = BTreeMap::<&str, Vec<(&str, &str)>>::new();
        for joint in &joints {
            let Some((child, parent)) = end_of(*joint, "child").zip(end_of(*joint, "parent")) else { continue };
            let of_link = parents.entry(child).or_default();
            of_link.push((joint.attribute("name").unwrap_or_default(), parent));
            if let [.., (first, one), (second, other)] = of_link[..] {
                let expected = "expected one; remove one of the joints";
                let which = format!("`{one}` by joint `{first}` and `{other}` by joint `{second}`");
                self.problem(*joint, format_args!("link `{child}` has two parents, {which}: {expected}"));
            }
        }
        let roots: Vec<&str> = links.iter().copied().filter(|link| !parents.contains_key(link)).collect();
        match roots[..] {
            _ if !self.good => {}
            [root] => self.reached(robot, &parents, root, links),
            [] => self.problem(robot, "every link is the child of a joint: expected one link without a parent"),
            _ => {
                let (count, names) = (roots.len(), listed(roots.iter().copied()));
                self.problem(
                    robot,
                    format_args!("{count} links without a parent: {names}: expected one root of a tree"),
                );
            }
        }
    }

    /// Checks that every link reaches the root. Links in a circle of joints have parents, yet no connection to it.
    fn reached(&mut self, robot: Node, parents: &BTreeMap<&str, Vec<(&str, &str)>>, root: &str, links: &[&str]) {
        let parent_of = |link: &str| parents.get(link).and_then(|of_link| of_link.first()).map(|(_, parent)| *parent);
        let reaches = |link: &str| {
            std::iter::successors(Some(link), |link: &&str| parent_of(link)).take(MAX_LINKS + 1).any(|it| it == root)
        };
        if let Some(lost) = links.iter().find(|link| !reaches(link)) {
            let message = "it is carried in a circle of joints: expected a tree with one root";
            self.problem(robot, format_args!("link `{lost}`: {message}"));
        }
    }

    fn joint(&mut self, joint: Node, links: &[&str]) {
        self.attribute(joint, "name");
        if let Some(kind) = self.attribute(joint, "type")
            && !JOINT_TYPES.contains(&kind)
        {
            self.problem(joint, format_args!("joint type `{kind}`: expected one of {}", JOINT_TYPES.join(", ")));
        }
        for end in ["parent", "child"] {
            let Some(node) = joint.children().find(|node| node.has_tag_name(end)) else {
                self.problem(joint, format_args!("joint without <{end} link=..>"));
                continue;
            };
            if let Some(link) = self.attribute(node, "link")
                && !links.contains(&link)
            {
                let (known, meant) = (listed(links.iter().copied()), did_you_mean(link, links.iter().copied()));
                self.problem(node, format_args!("unknown link `{link}`: expected one of {known}{meant}"));
            }
        }
    }

    fn attribute<'n>(&mut self, node: Node<'n, '_>, name: &str) -> Option<&'n str> {
        let value = node.attribute(name);
        if value.is_none() {
            self.problem(node, format_args!("<{}> without `{name}`", node.tag_name().name()));
        }
        value
    }

    /// Checks the shape of a collision: its first one counts.
    fn shape(&mut self, collision: Node) {
        let geometry = collision.children().find(|node| node.has_tag_name("geometry"));
        let Some(shape) = geometry.and_then(|node| node.children().find(Node::is_element)) else { return };
        let needed: &[&str] = match shape.tag_name().name() {
            "box" => &["size"],
            "cylinder" => &["radius", "length"],
            "sphere" => &["radius"],
            "mesh" => &["filename"],
            other => {
                return self.problem(shape, format_args!("shape <{other}>: expected box, cylinder, sphere or mesh"));
            }
        };
        needed.iter().for_each(|key| _ = self.attribute(shape, key));
    }

    /// Checks the attributes that are numbers everywhere in a URDF, and those with a fixed range.
    fn numbers(&mut self, node: Node) {
        for attribute in node.attributes() {
            let (count, range) = match attribute.name() {
                "xyz" => (3, ROBOT_REACH),
                "rpy" => (3, ANGLE),
                "size" | "scale" => (3, FINITE),
                "ixx" | "ixy" | "ixz" | "iyy" | "iyz" | "izz" => (1, INERTIA),
                "radius" | "length" | "velocity" | "effort" | "lower" | "upper" => (1, FINITE),
                "multiplier" | "offset" => (1, FINITE),
                "damping" | "friction" if node.has_tag_name("dynamics") => (1, FINITE),
                "value" if node.has_tag_name("mass") => (1, FINITE),
                _ => continue,
            };
            let (key, value) = (attribute.name(), attribute.value());
            let is_axis = node.has_tag_name("axis") && key == "xyz" && node.parent().is_some_and(moves);
            let numbers: Vec<f64> = value.split_whitespace().filter_map(|word| word.parse().ok()).collect();
            // PyBullet's files have scales of four numbers, of which it takes three.
            let is_longer = key == "scale" && numbers.len() > count;
            let all = value.split_whitespace().count() == numbers.len() && (numbers.len() == count || is_longer);
            if !all || !numbers.iter().all(|number| number.is_finite()) {
                let expected = names::count(count, "finite number");
                self.problem(node, format_args!("{key}=\"{value}\": expected {expected}"));
            } else if !numbers.iter().all(|&number| range.holds(number)) {
                self.problem(node, format_args!("{key}=\"{value}\": expected {range}"));
            } else if is_axis && numbers.iter().all(|&number| number.abs() < LEAST_AXIS) {
                let expected = "expected a direction, as in xyz=\"0 0 1\"";
                self.problem(node, format_args!("<axis {key}=\"{value}\"> is zero: {expected}"));
            }
        }
    }
}

/// Returns the link at an end of a joint, `parent` or `child`.
fn end_of<'n>(joint: Node<'n, '_>, tag: &str) -> Option<&'n str> {
    joint.children().find(|node| node.has_tag_name(tag))?.attribute("link")
}

/// True for a joint that turns or slides about its axis. Exporters write a zero axis for the others.
fn moves(joint: Node) -> bool {
    joint.attribute("type").is_some_and(|kind| ["continuous", "revolute", "prismatic"].contains(&kind))
}

const FINITE: Range = Range { least: f64::MIN, most: f64::MAX, unit: "" };

/// Returns the part of a node that needs xacro. A mere declaration of xacro is harmless: it often remains after expansion. So are texts for
/// other programs.
fn of_xacro(robot: Node, node: Node) -> Option<String> {
    let substitution = |text: &str| text.contains("${") || text.contains("$(");
    if node.node_type() != NodeType::Element {
        return None;
    }
    let tag = node.tag_name();
    if tag.namespace().is_some_and(is_xacro) {
        return Some(format!("<xacro:{}>", tag.name()));
    }
    let is_of_robot = |node: &Node| {
        let is_part = ["link", "joint", "material"].contains(&node.tag_name().name());
        is_part && node.parent() == Some(robot)
    };
    let value = || node.attributes().map(|attribute| attribute.value()).find(|value| substitution(value));
    value().filter(|_| node.ancestors().any(|node| is_of_robot(&node))).map(str::to_owned)
}

/// True for the name space of xacro, of which there are several spellings.
pub(super) fn is_xacro(namespace: &str) -> bool {
    let place = namespace.trim_end_matches("#interface").trim_end_matches('/');
    place.ends_with("/xacro")
}

/// Returns the message for a file that needs xacro.
pub(super) fn unexpanded(what: &str) -> String {
    format!(
        "`{what}` is of xacro: expected a URDF; expand it first by `usarsim import robot.xacro`, or `xacro robot.xacro > robot.urdf`"
    )
}
