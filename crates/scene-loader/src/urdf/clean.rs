//! A URDF with what has a bearing on physics and looks, and nothing else, for the URDF library.
//!
//! The library refuses what ROS does not mind: elements that are there twice, stray texts, colours of three numbers. ROS takes the first
//! element of a kind. Looks never refuse a robot: a visual that cannot be read is left out.

use std::collections::BTreeMap;
use std::fmt::Write;

use roxmltree::Node;

/// Elements of which the first counts (urdfdom).
const SINGLE: [(&str, &[&str]); 2] = [
    ("joint", &["origin", "parent", "child", "axis", "limit", "dynamics", "mimic", "calibration", "safety_controller"]),
    ("link", &["inertial"]),
];
/// Shapes, each with its attributes of numbers.
const SHAPES: [(&str, &[(&str, usize)]); 5] = [
    ("box", &[("size", 3)]),
    ("cylinder", &[("radius", 1), ("length", 1)]),
    ("sphere", &[("radius", 1)]),
    ("capsule", &[("radius", 1), ("length", 1)]),
    ("mesh", &[("scale", 3)]),
];

/// Returns the text for the library, and what it leaves out, in words.
pub(super) fn clean(robot: Node) -> (String, Vec<String>) {
    let mut made = Clean { text: String::new(), left_out: BTreeMap::new() };
    made.robot(robot);
    let counted = |(what, count): (String, usize)| if count == 1 { what } else { format!("{what} ({count} times)") };
    (made.text, made.left_out.into_iter().map(counted).collect())
}

/// A text under construction. Numbers outside of visuals have been checked.
struct Clean {
    text: String,
    /// Counts of what is left out.
    left_out: BTreeMap<String, usize>,
}

impl Clean {
    fn robot(&mut self, robot: Node) {
        let _ = write!(self.text, "<robot name=\"{}\">", escaped(robot.attribute("name").unwrap_or("robot")));
        for node in robot.children().filter(Node::is_element) {
            if let Some((tag, single)) = SINGLE.iter().find(|(tag, _)| node.has_tag_name(*tag)) {
                for name in *single {
                    if node.children().filter(|child| child.has_tag_name(*name)).nth(1).is_some() {
                        let owner = node.attribute("name").unwrap_or_default();
                        self.leave_out(format!("{tag} {owner}: a second <{name}>, as the first counts"));
                    }
                }
            }
            match node.tag_name().name() {
                "material" => {
                    let material = self.material(node);
                    self.text += &material;
                }
                "link" => self.link(node),
                "joint" => self.joint(node),
                _ => {}
            }
        }
        self.text += "</robot>";
    }

    fn leave_out(&mut self, what: impl Into<String>) {
        *self.left_out.entry(what.into()).or_default() += 1;
    }

    fn link(&mut self, link: Node) {
        let _ = write!(self.text, "<link name=\"{}\">", name(link));
        if let Some(inertial) = child(link, "inertial") {
            self.text += "<inertial>";
            self.text += &origin(inertial).unwrap_or_default();
            let mass = child(inertial, "mass").and_then(|mass| mass.attribute("value")).unwrap_or("0");
            let _ = write!(self.text, "<mass value=\"{}\"/><inertia", numbers(mass, 1).unwrap_or_default());
            for key in ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"] {
                let value = child(inertial, "inertia").and_then(|inertia| inertia.attribute(key)).unwrap_or("0");
                let _ = write!(self.text, " {key}=\"{}\"", numbers(value, 1).unwrap_or_default());
            }
            self.text += "/></inertial>";
        }
        for node in link.children() {
            match node.tag_name().name() {
                "visual" => match self.visual(node) {
                    Some(visual) => self.text += &visual,
                    None => self.leave_out(format!("link {}: a visual that is not read", name(link))),
                },
                "collision" => match self.shape(node) {
                    Some(shape) => {
                        let _ = write!(self.text, "<collision>{}{shape}</collision>", origin(node).unwrap_or_default());
                    }
                    None => self.leave_out(format!("link {}: a <collision> without a shape", name(link))),
                },
                _ => {}
            }
        }
        self.text += "</link>";
    }

    /// Returns a visual; `None` if it cannot be read.
    fn visual(&mut self, node: Node) -> Option<String> {
        let (origin, shape) = (origin(node)?, self.shape(node)?);
        let mut materials = node.children().filter(|child| child.has_tag_name("material"));
        let material = materials.next().map(|material| self.material(material)).unwrap_or_default();
        if materials.next().is_some() {
            self.leave_out("a second <material> of a visual, as the first counts");
        }
        Some(format!("<visual>{origin}{shape}{material}</visual>"))
    }

    /// Returns the geometry of a visual or a collision: its first shape.
    fn shape(&mut self, node: Node) -> Option<String> {
        let mut shapes = child(node, "geometry")?.children().filter(Node::is_element);
        let shape = shapes.next()?;
        if shapes.next().is_some() {
            self.leave_out("a second shape of a <geometry>, as the first counts");
        }
        let tag = shape.tag_name().name();
        let (_, keys) = SHAPES.iter().find(|(known, _)| *known == tag)?;
        let mut text = format!("<geometry><{tag}");
        if tag == "mesh" {
            let _ = write!(text, " filename=\"{}\"", escaped(shape.attribute("filename")?));
        }
        for (key, count) in *keys {
            match shape.attribute(*key) {
                Some(value) => {
                    let _ = write!(text, " {key}=\"{}\"", numbers(value, *count)?);
                }
                None if tag == "mesh" => {}
                None => return None,
            }
        }
        Some(text + "/></geometry>")
    }

    /// Returns a material: its name and colour. Three numbers are a colour that covers.
    fn material(&mut self, node: Node) -> String {
        let rgba = child(node, "color").map(|colour| colour.attribute("rgba").unwrap_or_default());
        let colour = rgba.map(|rgba| numbers(rgba, 4).or_else(|| numbers(rgba, 3).map(|rgb| format!("{rgb} 1"))));
        let colour = match colour {
            Some(Some(rgba)) => format!("<color rgba=\"{rgba}\"/>"),
            Some(None) => {
                self.leave_out("a colour that is not four numbers");
                String::new()
            }
            None => String::new(),
        };
        format!("<material name=\"{}\">{colour}</material>", name(node))
    }

    fn joint(&mut self, joint: Node) {
        let kind = escaped(joint.attribute("type").unwrap_or_default());
        let _ = write!(self.text, "<joint name=\"{}\" type=\"{kind}\">", name(joint));
        self.text += &origin(joint).unwrap_or_default();
        for end in ["parent", "child"] {
            let link = child(joint, end).and_then(|node| node.attribute("link")).unwrap_or_default();
            let _ = write!(self.text, "<{end} link=\"{}\"/>", escaped(link));
        }
        if let Some(axis) = child(joint, "axis").and_then(|node| numbers(node.attribute("xyz")?, 3)) {
            let _ = write!(self.text, "<axis xyz=\"{axis}\"/>");
        }
        let mut element = |tag: &str, keys: &[&str]| {
            let Some(node) = child(joint, tag) else { return };
            let _ = write!(self.text, "<{tag}");
            for key in keys {
                let value = node.attribute(*key).and_then(|value| numbers(value, 1));
                if let Some(value) = value.or_else(|| (tag != "mimic").then(|| "0".to_owned())) {
                    let _ = write!(self.text, " {key}=\"{value}\"");
                }
            }
            if let Some(leader) = node.attribute("joint") {
                let _ = write!(self.text, " joint=\"{}\"", escaped(leader));
            }
            self.text += "/>";
        };
        element("limit", &["lower", "upper", "effort", "velocity"]);
        element("dynamics", &["damping", "friction"]);
        element("mimic", &["multiplier", "offset"]);
        self.text += "</joint>";
    }
}

fn child<'a, 'i>(node: Node<'a, 'i>, tag: &str) -> Option<Node<'a, 'i>> {
    node.children().find(|child| child.has_tag_name(tag))
}

fn name(node: Node) -> String {
    escaped(node.attribute("name").unwrap_or_default())
}

/// Returns the origin of an element, if it has one; `None` if it cannot be read.
fn origin(node: Node) -> Option<String> {
    let Some(origin) = child(node, "origin") else { return Some(String::new()) };
    let part = |key: &str| origin.attribute(key).map_or(Some("0 0 0".to_owned()), |value| numbers(value, 3));
    Some(format!("<origin xyz=\"{}\" rpy=\"{}\"/>", part("xyz")?, part("rpy")?))
}

/// Returns so many finite numbers with single spaces; `None` if the text is anything else.
fn numbers(text: &str, count: usize) -> Option<String> {
    let words: Vec<&str> = text.split_whitespace().collect();
    let is_good = |word: &&str| word.parse::<f64>().is_ok_and(f64::is_finite);
    // A scale may have more numbers than count.
    (words.len() >= count && words.iter().all(is_good)).then(|| words[..count].join(" "))
}

/// Returns a text as the value of an attribute.
pub(crate) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;")
}
