//! URDF: the body of a robot and the places of its wheels.
//!
//! Links on fixed joints become parts of the body, links on continuous joints become wheels with the place, mass,
//! speed and torque limit that the URDF gives them. Shape, rollers and servo of a wheel stand in robot.toml.
//! URDF is x forward, y left, z up; here it is turned into the robot frame, z down, once.

use nalgebra::{Isometry3, Matrix3, Quaternion, UnitQuaternion, Vector3};
use roxmltree::{Node, NodeType, ParsingOptions};
use scene::check::{ANGLE, INERTIA, ROBOT_REACH, Range};
use scene::{Material, Part, Pose, Shape, Solid, check};
use urdf_rs::{Geometry, JointType};

use crate::mesh;
use crate::problem::{Problems, Unread, listed};
use crate::source::Source;

/// Most elements inside each other: the URDF library recurses into them. A URDF has six, extensions of simulators twelve.
const MAX_DEPTH: usize = 64;
/// Most elements, attributes and texts of a file.
const MAX_NODES: u32 = 500_000;
/// Most declarations of namespaces: the XML library copies them to every element that declares one more.
const MAX_NAMESPACES: usize = 100;
/// Most links and most joints.
const MAX_LINKS: usize = 1000;

/// What a robot takes from its URDF, in the robot frame.
pub(crate) struct Urdf {
    pub(crate) parts: Vec<Part>,
    pub(crate) solids: Vec<Solid>,
    pub(crate) wheels: Vec<UrdfWheel>,
}

/// A continuous joint and its child link.
pub(crate) struct UrdfWheel {
    pub(crate) joint: String,
    pub(crate) position: [f64; 3],
    pub(crate) mass: f64,
    pub(crate) max_speed: Option<f64>,
    pub(crate) max_torque: Option<f64>,
}

const JOINT_TYPES: [&str; 6] = ["fixed", "continuous", "revolute", "prismatic", "floating", "planar"];

/// Reads a URDF; `material` is of what the body is made.
pub(crate) fn read(
    source: &Source,
    file: &str,
    text: &str,
    material: Material,
    problems: &mut Problems,
) -> Result<Urdf, Unread> {
    let shown = source.display(file);
    let mut at = |offset: usize, message: String| problems.at(&shown, text, offset, message);
    let namespaces = text.matches("xmlns").count();
    if namespaces > MAX_NAMESPACES {
        at(0, format!("{namespaces} namespaces: expected at most {MAX_NAMESPACES}"));
        return Err(Unread);
    }
    let options = ParsingOptions { nodes_limit: MAX_NODES, ..ParsingOptions::default() };
    let document = roxmltree::Document::parse_with_options(text, options).map_err(|error| {
        let place = error.pos();
        let line_start: usize = text.split_inclusive('\n').take(place.row as usize - 1).map(str::len).sum();
        let xacro = matches!(&error, roxmltree::Error::UnknownNamespace(prefix, _) if prefix == "xacro");
        let message = if xacro { unexpanded("<xacro:..>") } else { format!("not XML: {error}") };
        at(line_start + place.col as usize - 1, message);
        Unread
    })?;
    let mut check = Check { file: &shown, text, problems, good: true };
    check.robot(document.root_element());
    if !check.good {
        return Err(Unread);
    }
    let robot = urdf_rs::read_from_string(text).map_err(|error| {
        problems.at(&shown, text, 0, format_args!("not a URDF: {error}"));
        Unread
    })?;
    let mut urdf = Urdf { parts: Vec::new(), solids: Vec::new(), wheels: Vec::new() };
    let is_child = |name: &str| robot.joints.iter().any(|joint| joint.child.link == name);
    // The URDF library has an XML reader of its own, which need not find what was checked before.
    let root = robot.links.iter().find(|link| !is_child(&link.name)).ok_or_else(|| {
        problems.at(&shown, text, 0, "not a URDF: no link is found that is no joint's child");
        Unread
    })?;
    let mut open = vec![(root, Isometry3::identity())];
    let noted = problems.count();
    while let Some((link, pose)) = open.pop() {
        let node = named(&document, "link", &link.name);
        let mut wrong = |node: Option<Node>, message: String| {
            let place = node.map_or(0, |node| node.range().start);
            problems.at(&shown, text, place, format_args!("link {}: {message}", link.name));
        };
        if let Some(part) = part(link, &pose) {
            check::part(&part).into_iter().for_each(|message| wrong(node, message));
            urdf.parts.push(part);
        }
        let mut nodes = node.into_iter().flat_map(|node| node.children()).filter(|node| node.has_tag_name("collision"));
        for collision in &link.collision {
            let node = nodes.next();
            match solid(source, link, collision, &pose, &material) {
                Ok(solid) => {
                    check::body_solid(&solid).into_iter().for_each(|message| wrong(node, message));
                    urdf.solids.push(solid);
                }
                Err(reason) => wrong(node, reason),
            }
        }
        for joint in robot.joints.iter().filter(|joint| joint.parent.link == link.name) {
            let Some(child) = robot.links.iter().find(|link| link.name == joint.child.link) else {
                wrong(node, format!("joint {}: its child {} is not found", joint.name, joint.child.link));
                continue;
            };
            let place = pose * isometry(&joint.origin);
            match joint.joint_type {
                JointType::Continuous => urdf.wheels.push(UrdfWheel {
                    joint: joint.name.clone(),
                    position: z_down().transform_vector(&place.translation.vector).into(),
                    mass: child.inertial.mass.value,
                    max_speed: Some(joint.limit.velocity).filter(|&speed| speed > 0.0 && speed.is_finite()),
                    max_torque: Some(joint.limit.effort).filter(|&torque| torque > 0.0 && torque.is_finite()),
                }),
                // Arms are held where they are.
                _ => open.push((child, place)),
            }
        }
    }
    if problems.count() == noted { Ok(urdf) } else { Err(Unread) }
}

/// The element of a link or joint.
fn named<'a>(document: &'a roxmltree::Document, tag: &str, name: &str) -> Option<Node<'a, 'a>> {
    let mut nodes = document.root_element().children();
    nodes.find(|node| node.has_tag_name(tag) && node.attribute("name") == Some(name))
}

/// What is said of a file with something in it that only xacro understands.
fn unexpanded(what: &str) -> String {
    format!("`{what}` is of xacro: expected a URDF; expand it first: `xacro robot.xacro > robot.urdf`")
}

/// From the URDF's axes to the robot frame: half a turn about x, exactly.
fn z_down() -> UnitQuaternion<f64> {
    UnitQuaternion::new_unchecked(Quaternion::new(0.0, 1.0, 0.0, 0.0))
}

fn isometry(origin: &urdf_rs::Pose) -> Isometry3<f64> {
    let [roll, pitch, yaw] = *origin.rpy;
    Isometry3::from_parts(Vector3::from(*origin.xyz).into(), UnitQuaternion::from_euler_angles(roll, pitch, yaw))
}

/// What a link weighs; a frame weighs nothing.
fn part(link: &urdf_rs::Link, pose: &Pose) -> Option<Part> {
    let inertial = &link.inertial;
    let mass = inertial.mass.value;
    if mass == 0.0 {
        return None;
    }
    let centre = pose * isometry(&inertial.origin);
    let urdf_rs::Inertia { ixx, ixy, ixz, iyy, iyz, izz } = inertial.inertia;
    let inertia = Matrix3::new(ixx, ixy, ixz, ixy, iyy, iyz, ixz, iyz, izz);
    let turn = (z_down() * centre.rotation).to_rotation_matrix();
    Some(Part {
        name: link.name.clone(),
        mass,
        centre: z_down() * centre.translation.vector,
        inertia: turn.matrix() * inertia * turn.matrix().transpose(),
    })
}

/// The shape of a link, in the robot frame.
fn solid(
    source: &Source,
    link: &urdf_rs::Link,
    collision: &urdf_rs::Collision,
    pose: &Pose,
    material: &Material,
) -> Result<Solid, String> {
    let place = Isometry3::from_parts(Default::default(), z_down()) * pose * isometry(&collision.origin);
    // Shapes are symmetric about their z axis but for meshes, which `mesh` turns z down by themselves.
    let (shape, turn) = match &collision.geometry {
        Geometry::Box { size } => (Shape::Box { size: **size }, UnitQuaternion::identity()),
        Geometry::Cylinder { radius, length } => {
            (Shape::Cylinder { radius: *radius, length: *length }, UnitQuaternion::identity())
        }
        Geometry::Sphere { radius } => (Shape::Ball { radius: *radius }, UnitQuaternion::identity()),
        Geometry::Mesh { filename, scale } => (hull(source, filename, scale.map(|scale| *scale))?, z_down()),
        other => return Err(format!("geometry {other:?}: expected box, cylinder, sphere or mesh")),
    };
    let (position, rotation) = scene::position_and_rotation(&(place * turn));
    Ok(Solid { name: link.name.clone(), shape, position, rotation, material: material.clone() })
}

/// The convex hull of a mesh: only its corners, of the many that a drawing has. A mirrored scale is fine for a hull.
fn hull(source: &Source, filename: &str, scale: Option<[f64; 3]>) -> Result<Shape, String> {
    let scale = scale.unwrap_or([1.0; 3]);
    if let Some(problem) = mesh::SCALE.problem_in("scale", &scale.map(f64::abs)) {
        return Err(format!("{problem}, either sign"));
    }
    let name = filename.rsplit("://").next().unwrap_or(filename);
    let Shape::Mesh { vertices, .. } = mesh::read(source, name, scale)? else {
        return Err(format!("mesh `{name}`: expected triangles"));
    };
    if let Some(problem) = vertices.iter().find_map(|corner| ROBOT_REACH.problem_in("corner", corner)) {
        return Err(format!("mesh `{name}`: {problem}"));
    }
    match scene::hull_surface(&vertices) {
        Some(Shape::Mesh { vertices, .. }) => Ok(Shape::Hull { points: vertices }),
        _ => Err(format!("mesh `{name}` has its points in one plane: expected a volume")),
    }
}

/// Finds mistakes with their lines, which the URDF library does not tell.
struct Check<'a> {
    file: &'a str,
    text: &'a str,
    problems: &'a mut Problems,
    good: bool,
}

impl Check<'_> {
    fn problem(&mut self, node: Node, message: impl std::fmt::Display) {
        self.good = false;
        self.problems.at(self.file, self.text, node.range().start, message);
    }

    fn robot(&mut self, robot: Node) {
        if let Some((node, what)) = robot.descendants().find_map(|node| Some((node, of_xacro(node)?))) {
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
        let ends = children("joint").filter_map(|joint| joint.children().find(|node| node.has_tag_name("child")));
        let child_links: Vec<&str> = ends.filter_map(|end| end.attribute("link")).collect();
        let is_child = |link: &str| child_links.iter().filter(|child| **child == link).count();
        let roots = links.iter().filter(|link| is_child(link) == 0).count();
        if self.good && (roots != 1 || links.iter().any(|link| is_child(link) > 1)) {
            self.problem(robot, format_args!("{roots} links without a parent: expected a tree with one root"));
        }
        for node in robot.descendants().filter(Node::is_element) {
            self.numbers(node);
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
                self.problem(
                    node,
                    format_args!("unknown link `{link}`: expected one of {}", listed(links.iter().copied())),
                );
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

    /// Attributes that are numbers everywhere in a URDF, with their range where they have one everywhere.
    fn numbers(&mut self, node: Node) {
        for attribute in node.attributes() {
            let (count, range) = match attribute.name() {
                "xyz" => (3, ROBOT_REACH),
                "rpy" => (3, ANGLE),
                "size" | "scale" => (3, FINITE),
                "ixx" | "ixy" | "ixz" | "iyy" | "iyz" | "izz" => (1, INERTIA),
                "radius" | "length" | "velocity" | "effort" => (1, FINITE),
                "value" if node.has_tag_name("mass") => (1, FINITE),
                _ => continue,
            };
            let (key, value) = (attribute.name(), attribute.value());
            let numbers: Vec<f64> = value.split_whitespace().filter_map(|word| word.parse().ok()).collect();
            let all = numbers.len() == count && value.split_whitespace().count() == count;
            if !all || !numbers.iter().all(|number| number.is_finite()) {
                self.problem(node, format_args!("{key}=\"{value}\": expected {count} finite number(s)"));
            } else if !numbers.iter().all(|&number| range.holds(number)) {
                self.problem(node, format_args!("{key}=\"{value}\": expected {range}"));
            }
        }
    }
}

const FINITE: Range = Range { least: f64::MIN, most: f64::MAX, unit: "" };

/// What in a node only xacro understands. That it is declared is no harm: it often stays when it is expanded.
fn of_xacro(node: Node) -> Option<String> {
    let substitution = |text: &str| text.contains("${") || text.contains("$(");
    match node.node_type() {
        NodeType::Element => {
            let tag = node.tag_name();
            let own = tag.namespace().is_some_and(|namespace| namespace.ends_with("/xacro"));
            let value = || node.attributes().map(|attribute| attribute.value()).find(|value| substitution(value));
            if own { Some(format!("<xacro:{}>", tag.name())) } else { value().map(str::to_owned) }
        }
        NodeType::Text => node.text().filter(|text| substitution(text)).map(|text| text.trim().to_owned()),
        _ => None,
    }
}
