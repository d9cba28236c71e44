//! URDF: the body of a robot and the places of its wheels.
//!
//! Links on fixed joints become parts of the body, links on continuous joints become wheels with the place, mass,
//! speed and torque limit that the URDF gives them. Shape, rollers and servo of a wheel stand in robot.toml.
//! URDF is x forward, y left, z up; here it is turned into the robot frame, z down, once.

use nalgebra::{Isometry3, Matrix3, Quaternion, UnitQuaternion, Vector3};
use roxmltree::Node;
use sim_core::scene::{Material, Part, Pose, Shape, Solid};
use urdf_rs::{Geometry, JointType};

use crate::materials::Materials;
use crate::mesh;
use crate::problem::Problems;
use crate::source::Source;

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

/// Reads a URDF; `material` is of what the body is made, the first known one if it is not given.
pub(crate) fn read(
    source: &Source,
    file: &str,
    text: &str,
    materials: &Materials,
    material: Option<Material>,
    problems: &mut Problems,
) -> Option<Urdf> {
    let shown = source.display(file);
    let document = match roxmltree::Document::parse(text) {
        Ok(document) => document,
        Err(error) => {
            let place = error.pos();
            let line_start: usize = text.split_inclusive('\n').take(place.row as usize - 1).map(str::len).sum();
            problems.at(&shown, text, line_start + place.col as usize - 1, format_args!("not XML: {error}"));
            return None;
        }
    };
    let mut check = Check { file: &shown, text, problems, good: true };
    check.robot(document.root_element());
    if !check.good {
        return None;
    }
    let robot = match urdf_rs::read_from_string(text) {
        Ok(robot) => robot,
        Err(error) => {
            problems.at(&shown, text, 0, format_args!("not a URDF: {error}"));
            return None;
        }
    };
    let material = material.or_else(|| materials.values().next().cloned())?;
    let mut urdf = Urdf { parts: Vec::new(), solids: Vec::new(), wheels: Vec::new() };
    let is_child = |name: &str| robot.joints.iter().any(|joint| joint.child.link == name);
    let root = robot.links.iter().find(|link| !is_child(&link.name))?;
    let mut open = vec![(root, Isometry3::identity())];
    while let Some((link, pose)) = open.pop() {
        if let Err(reason) = add_link(source, link, &pose, &material, &mut urdf) {
            problems.at(&shown, text, 0, format_args!("link {}: {reason}", link.name));
        }
        for joint in robot.joints.iter().filter(|joint| joint.parent.link == link.name) {
            let child = robot.links.iter().find(|link| link.name == joint.child.link)?;
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
    Some(urdf)
}

/// From the URDF's axes to the robot frame: half a turn about x, exactly.
fn z_down() -> UnitQuaternion<f64> {
    UnitQuaternion::new_unchecked(Quaternion::new(0.0, 1.0, 0.0, 0.0))
}

fn isometry(origin: &urdf_rs::Pose) -> Isometry3<f64> {
    let [roll, pitch, yaw] = *origin.rpy;
    Isometry3::from_parts(Vector3::from(*origin.xyz).into(), UnitQuaternion::from_euler_angles(roll, pitch, yaw))
}

fn add_link(
    source: &Source,
    link: &urdf_rs::Link,
    pose: &Pose,
    material: &Material,
    urdf: &mut Urdf,
) -> Result<(), String> {
    let inertial = &link.inertial;
    let mass = inertial.mass.value;
    if mass > 0.0 {
        let centre = pose * isometry(&inertial.origin);
        let urdf_rs::Inertia { ixx, ixy, ixz, iyy, iyz, izz } = inertial.inertia;
        let inertia = Matrix3::new(ixx, ixy, ixz, ixy, iyy, iyz, ixz, iyz, izz);
        let turn = (z_down() * centre.rotation).to_rotation_matrix();
        urdf.parts.push(Part {
            name: link.name.clone(),
            mass,
            centre: z_down() * centre.translation.vector,
            inertia: turn.matrix() * inertia * turn.matrix().transpose(),
        });
    }
    for collision in &link.collision {
        let place = Isometry3::from_parts(Default::default(), z_down()) * pose * isometry(&collision.origin);
        // Shapes are symmetric about their z axis but for meshes, which `mesh` turns z down by themselves.
        let (shape, turn) = match &collision.geometry {
            Geometry::Box { size } => (Shape::Box { size: **size }, UnitQuaternion::identity()),
            Geometry::Cylinder { radius, length } => {
                (Shape::Cylinder { radius: *radius, length: *length }, UnitQuaternion::identity())
            }
            Geometry::Sphere { radius } => (Shape::Ball { radius: *radius }, UnitQuaternion::identity()),
            Geometry::Mesh { filename, scale } => {
                let scale = scale.map_or(1.0, |scale| scale[0]);
                let name = filename.rsplit("://").next().unwrap_or(filename);
                let Shape::Mesh { vertices, .. } = mesh::read(source, name, scale)? else { continue };
                (Shape::Hull { points: vertices }, z_down())
            }
            other => return Err(format!("geometry {other:?}: expected box, cylinder, sphere or mesh")),
        };
        let (position, rotation) = sim_core::scene::position_and_rotation(&(place * turn));
        urdf.solids.push(Solid { name: link.name.clone(), shape, position, rotation, material: material.clone() });
    }
    Ok(())
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
        if robot.tag_name().name() != "robot" {
            self.problem(robot, format_args!("<{}>: expected <robot>", robot.tag_name().name()));
            return;
        }
        let children = |tag: &'static str| robot.children().filter(move |node| node.has_tag_name(tag));
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
                self.problem(node, format_args!("unknown link `{link}`: expected one of {}", links.join(", ")));
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

    /// Attributes that are numbers everywhere in a URDF.
    fn numbers(&mut self, node: Node) {
        for attribute in node.attributes() {
            let count = match attribute.name() {
                "xyz" | "rpy" | "size" => 3,
                "radius" | "length" | "ixx" | "ixy" | "ixz" | "iyy" | "iyz" | "izz" | "velocity" | "effort" => 1,
                "value" if node.has_tag_name("mass") => 1,
                _ => continue,
            };
            let numbers: Vec<Option<f64>> =
                attribute.value().split_whitespace().map(|word| word.parse().ok()).collect();
            if numbers.len() != count || !numbers.iter().all(|number| number.is_some_and(f64::is_finite)) {
                let message =
                    format!("{}=\"{}\": expected {count} finite number(s)", attribute.name(), attribute.value());
                self.problem(node, message);
            }
        }
    }
}
