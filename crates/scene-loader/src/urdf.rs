//! URDF: a tree of links on joints, with masses, colliding shapes and visuals.
//!
//! Links on fixed joints become parts of their carriers. A continuous joint may carry a wheel; shape, rollers and servo of a wheel
//! come from robot.toml. URDF is x forward, y left, z up. It is converted here, once, to the robot frame, z down.

mod check;
mod looks;

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Matrix3, Quaternion, UnitQuaternion, Vector3};
use roxmltree::{Node, ParsingOptions};
use scene::check::ROBOT_REACH;
use scene::{Coupling, CouplingKind, Joint, JointKind, Link, Material, Motor, Part, Pose, ROOT, Shape, Solid};
use urdf_rs::{Geometry, JointType};

use self::check::{Check, unexpanded};
use self::looks::Looks;
use crate::mesh;
use crate::problem::{Problems, Unread};
use crate::source::Source;

/// Maximum number of elements, attributes and texts of a file.
const MAX_NODES: u32 = 500_000;
/// Maximum number of namespace declarations: the XML library copies them to every element that declares one more.
const MAX_NAMESPACES: usize = 100;
/// Position error at which a servo reaches its torque limit, rad or m. A URDF gives no stiffness.
const FULL_TORQUE_ERROR: f64 = 0.02;
/// Speed error at which a speed servo reaches its torque limit, as a fraction of its greatest speed.
pub(crate) const FULL_TORQUE_LAG: f64 = 0.1;
/// Maximum number of folders above that of the URDF in which a mesh of a package is searched.
const MAX_LEVELS: usize = 4;
/// A URDF in the robot frame.
pub(crate) struct Urdf {
    /// Links, parents before their children. The first is the body; the others have the names of their joints.
    pub(crate) links: Vec<Link>,
    /// Joints that may carry wheels.
    pub(crate) continuous: Vec<Continuous>,
    /// Assumptions where the file gives no value, or asks for a feature that is not supported.
    pub(crate) assumptions: Vec<String>,
}

/// A continuous joint, which may carry a wheel.
pub(crate) struct Continuous {
    pub(crate) joint: String,
    /// Number of its link.
    pub(crate) link: usize,
    /// Mass of its link without the links fixed to it, kg.
    pub(crate) mass: f64,
    pub(crate) max_speed: Option<f64>,
    pub(crate) max_torque: Option<f64>,
}

impl Urdf {
    /// Returns a robot with only a body.
    pub(crate) fn body() -> Self {
        let body = Link { name: ROOT.to_owned(), ..Link::default() };
        Self { links: vec![body], continuous: Vec::new(), assumptions: Vec::new() }
    }
}

/// Parses the XML of a URDF.
pub(crate) fn document(text: &str) -> Result<roxmltree::Document<'_>, roxmltree::Error> {
    if namespaces(text).is_some() {
        return Err(roxmltree::Error::NodesLimitReached);
    }
    let options = ParsingOptions { nodes_limit: MAX_NODES, ..ParsingOptions::default() };
    roxmltree::Document::parse_with_options(text, options)
}

/// True if the root of an XML file declares the name space of xacro.
pub(crate) fn declares_xacro(text: &str) -> bool {
    document(text).is_ok_and(|document| document.root_element().namespaces().any(|it| check::is_xacro(it.uri())))
}

fn namespaces(text: &str) -> Option<String> {
    let namespaces = text.matches("xmlns").count();
    (namespaces > MAX_NAMESPACES).then(|| format!("{namespaces} namespaces: expected at most {MAX_NAMESPACES}"))
}

/// Parses a URDF and checks the tree and the numbers. `shown` names the file in problems.
pub(crate) fn parse<'t>(
    shown: &str,
    text: &'t str,
    problems: &mut Problems,
) -> Result<(roxmltree::Document<'t>, urdf_rs::Robot), Unread> {
    let mut at = |offset: usize, message: String| problems.at(shown, text, offset, message);
    if let Some(problem) = namespaces(text) {
        at(0, problem);
        return Err(Unread);
    }
    let document = self::document(text).map_err(|error| {
        let place = error.pos();
        let line_start: usize = text.split_inclusive('\n').take(place.row as usize - 1).map(str::len).sum();
        let xacro = matches!(&error, roxmltree::Error::UnknownNamespace(prefix, _) if prefix == "xacro");
        let message = if xacro { unexpanded("<xacro:..>") } else { format!("not XML: {error}") };
        at(line_start + place.col as usize - 1, message);
        Unread
    })?;
    let mut check = Check { file: shown, text, problems, good: true };
    check.robot(document.root_element());
    if !check.good {
        return Err(Unread);
    }
    let robot = urdf_rs::read_from_string(text).map_err(|error| {
        problems.at(shown, text, 0, format_args!("not a URDF: {error}"));
        Unread
    })?;
    Ok((document, robot))
}

/// Reads a URDF; its links get the given material.
pub(crate) fn read(
    source: &Source,
    file: &str,
    text: &str,
    material: Material,
    problems: &mut Problems,
) -> Result<Urdf, Unread> {
    let shown = source.display(file);
    let (document, robot) = parse(&shown, text, problems)?;
    let mut tree = Tree {
        source,
        document: &document,
        robot: &robot,
        material: &material,
        wrong: Vec::new(),
        urdf: Urdf { assumptions: ignored(document.root_element()), ..Urdf::body() },
        looks: Looks::default(),
    };
    tree.add_all();
    let Tree { wrong, mut urdf, looks, .. } = tree;
    urdf.assumptions.extend(looks.finish(&mut urdf.links));
    let good = wrong.is_empty();
    wrong.into_iter().for_each(|(offset, message)| problems.at(&shown, text, offset, message));
    if good { Ok(urdf) } else { Err(Unread) }
}

/// True if a URDF hints at Mecanum wheels: by names of links or meshes, or by Gazebo's diagonal directions of friction or its plugin
/// that moves a base to all sides.
pub(crate) fn hints_at_mecanum(text: &str) -> bool {
    let Ok(document) = document(text) else { return false };
    let named = |name: &str| {
        let name = name.to_ascii_lowercase();
        ["mecanum", "omni_wheel", "omniwheel"].iter().any(|word| name.contains(word))
    };
    let is_diagonal = |text: &str| {
        let numbers: Vec<f64> = text.split_whitespace().filter_map(|word| word.parse().ok()).collect();
        matches!(numbers[..], [x, y, _] if x.abs() > 0.5 && (x.abs() - y.abs()).abs() < 0.1)
    };
    document.root_element().descendants().any(|node| match node.tag_name().name() {
        "link" | "joint" => node.attribute("name").is_some_and(named),
        "mesh" => node.attribute("filename").is_some_and(named),
        "fdir1" => node.text().is_some_and(is_diagonal),
        "plugin" => node.attribute("filename").is_some_and(|name| name.contains("planar_move")),
        _ => false,
    })
}

/// Lists the elements of a URDF that are for other programs.
pub(crate) fn ignored(robot: Node) -> Vec<String> {
    let mut counts = BTreeMap::<&str, usize>::new();
    for node in robot.children().filter(Node::is_element) {
        let tag = node.tag_name().name();
        if !["link", "joint", "material"].contains(&tag) {
            *counts.entry(tag).or_default() += 1;
        }
    }
    counts.iter().map(|(tag, count)| format!("{count} <{tag}> not used: usarsim does not read them")).collect()
}

/// A tree under construction.
struct Tree<'a> {
    source: &'a Source,
    document: &'a roxmltree::Document<'a>,
    robot: &'a urdf_rs::Robot,
    material: &'a Material,
    /// Mistakes with their offsets in the text.
    wrong: Vec<(usize, String)>,
    urdf: Urdf,
    looks: Looks,
}

impl<'a> Tree<'a> {
    fn add_all(&mut self) {
        let robot = self.robot;
        let is_child = |name: &str| robot.joints.iter().any(|joint| joint.child.link == name);
        // The URDF library has its own XML reader, which may miss elements that were checked before.
        let Some(root) = robot.links.iter().find(|link| !is_child(&link.name)) else {
            return self.wrong.push((0, "not a URDF: no link is found that is no joint's child".to_owned()));
        };
        // Each entry holds a link, its pose in the URDF's axes, and the number of the link it belongs to. The traversal orders the
        // parts and so the sums over them. Rounding makes that order a property of the robot.
        let mut open = vec![(root, Isometry3::identity(), 0)];
        while let Some((link, pose, number)) = open.pop() {
            self.add_link(link, &pose, number);
            for joint in robot.joints.iter().filter(|joint| joint.parent.link == link.name) {
                let Some(child) = robot.links.iter().find(|link| link.name == joint.child.link) else {
                    let message = format!("joint {}: its child {} is not found", joint.name, joint.child.link);
                    self.wrong.push((self.place("joint", &joint.name), message));
                    continue;
                };
                let place = pose * isometry(&joint.origin);
                let carried = self.add_joint(joint, child, &place, number);
                open.push((child, place, carried));
            }
        }
        // Wheels are numbered in the order of the file.
        let place = |name: &str| robot.joints.iter().position(|joint| joint.name == name);
        self.urdf.continuous.sort_by_key(|it| place(&it.joint));
        self.add_mimics();
        self.add_servos();
    }

    /// Adds the mass, shapes and visuals of a link to the link with this number.
    fn add_link(&mut self, link: &urdf_rs::Link, pose: &Pose, number: usize) {
        let node = self.named("link", &link.name);
        let start = |node: Option<Node>| node.map_or(0, |node| node.range().start);
        let of_link = |message: String| format!("link {}: {message}", link.name);
        if let Some(part) = part(link, pose) {
            self.wrong.extend(scene::check::part(&part).into_iter().map(|message| (start(node), of_link(message))));
            self.urdf.links[number].parts.push(part);
        }
        let mut nodes = node.into_iter().flat_map(|node| node.children()).filter(|node| node.has_tag_name("collision"));
        let before = self.urdf.links[number].solids.len();
        for collision in &link.collision {
            let at = start(nodes.next());
            match solid(self.source, link, collision, pose, self.material) {
                Ok(solid) => {
                    let wrong = scene::check::body_solid(&solid);
                    self.wrong.extend(wrong.into_iter().map(|message| (at, of_link(message))));
                    self.urdf.links[number].solids.push(solid);
                }
                Err(reason) => self.wrong.push((at, of_link(reason))),
            }
        }
        let solids = &self.urdf.links[number].solids;
        let own = &solids[before.min(solids.len())..];
        let (visuals, said) = self.looks.of_link(self.source, link, pose, self.robot, own);
        self.urdf.links[number].visuals.extend(visuals);
        self.urdf.assumptions.extend(said);
        self.looks.bound(&mut self.urdf.links);
    }

    /// Returns the number of the link that a joint carries: a new one, or the parent if the joint is held.
    fn add_joint(&mut self, joint: &urdf_rs::Joint, child: &urdf_rs::Link, place: &Pose, parent: usize) -> usize {
        let limits = [joint.limit.lower, joint.limit.upper];
        let kind = match joint.joint_type {
            JointType::Fixed => return parent,
            JointType::Continuous => JointKind::Continuous,
            JointType::Revolute | JointType::Prismatic if limits[0] == limits[1] => {
                self.urdf.assumptions.push(format!("joint {} has equal limits and is held", joint.name));
                return parent;
            }
            JointType::Revolute => JointKind::Revolute,
            JointType::Prismatic => JointKind::Prismatic,
            JointType::Spherical => JointKind::Ball,
            JointType::Floating | JointType::Planar => {
                self.urdf.assumptions.push(format!("joint {} is {:?}: held", joint.name, joint.joint_type));
                return parent;
            }
        };
        if self.urdf.links.iter().any(|link| link.name == joint.name) {
            let message = format!("second joint `{}`: expected a name of its own", joint.name);
            self.wrong.push((self.place("joint", &joint.name), message));
        }
        let axis = (z_down() * place.rotation * Vector3::from(*joint.axis.xyz)).normalize();
        let anchor = z_down().transform_vector(&place.translation.vector);
        let (damping, friction) = joint.dynamics.as_ref().map_or((0.0, 0.0), |it| (it.damping, it.friction));
        let has_ends = matches!(kind, JointKind::Revolute | JointKind::Prismatic);
        let limits = has_ends.then_some(limits);
        let made = Joint { limits, damping, friction, ..Joint::new(parent, kind, anchor.into(), axis.into()) };
        let number = self.urdf.links.len();
        self.urdf.links.push(Link { name: joint.name.clone(), joint: Some(made), ..Link::default() });
        if kind == JointKind::Continuous {
            let positive = |number: f64| Some(number).filter(|number| *number > 0.0 && number.is_finite());
            self.urdf.continuous.push(Continuous {
                joint: joint.name.clone(),
                link: number,
                mass: child.inertial.mass.value,
                max_speed: positive(joint.limit.velocity),
                max_torque: positive(joint.limit.effort),
            });
        }
        number
    }

    fn add_mimics(&mut self) {
        for joint in &self.robot.joints {
            let Some(mimic) = &joint.mimic else { continue };
            let number = |name: &str| self.urdf.links.iter().position(|link| link.name == name);
            let Some(follower) = number(&joint.name) else { continue };
            let Some(leader) = number(&mimic.joint) else {
                let message = format!("joint {}: it mimics {}: expected a joint that moves", joint.name, mimic.joint);
                self.wrong.push((self.place("joint", &joint.name), message));
                continue;
            };
            let (multiplier, offset) = (mimic.multiplier.unwrap_or(1.0), mimic.offset.unwrap_or(0.0));
            if let Some(joint) = &mut self.urdf.links[follower].joint {
                joint.coupling = Some(Coupling { leader, multiplier, offset, kind: CouplingKind::Mimic });
            }
        }
    }

    /// Adds a servo to every joint with an effort and a speed; joints without them swing freely.
    fn add_servos(&mut self) {
        for number in 1..self.urdf.links.len() {
            let links = &self.urdf.links;
            let Some(joint) = links[number].joint.as_ref().filter(|joint| joint.coupling.is_none()) else { continue };
            let name = &links[number].name;
            let Some(limit) = self.robot.joints.iter().find(|it| &it.name == name).map(|it| &it.limit) else {
                continue;
            };
            if !(limit.effort > 0.0 && limit.velocity > 0.0 && joint.kind.has_value()) {
                continue;
            }
            let (max_speed, max_torque) = (limit.velocity, limit.effort);
            let inertia = inertia_beyond(links, number);
            let motor = if joint.kind == JointKind::Continuous {
                let gain = max_torque / (FULL_TORQUE_LAG * max_speed);
                Motor { max_speed, gain, max_torque, stiffness: None, integral_time: None, armature: 0.0 }
            } else {
                let stiffness = max_torque / FULL_TORQUE_ERROR;
                // Critical damping, without overshoot.
                let gain = 2.0 * (stiffness * inertia).sqrt();
                Motor { max_speed, gain, max_torque, stiffness: Some(stiffness), integral_time: None, armature: 0.0 }
            };
            if let Some(joint) = &mut self.urdf.links[number].joint {
                joint.drive = Some(motor);
            }
        }
    }

    /// Returns the offset of a link or joint in the text.
    fn place(&self, tag: &str, name: &str) -> usize {
        self.named(tag, name).map_or(0, |node| node.range().start)
    }

    fn named(&self, tag: &str, name: &str) -> Option<Node<'a, 'a>> {
        let mut nodes = self.document.root_element().children();
        nodes.find(|node| node.has_tag_name(tag) && node.attribute("name") == Some(name))
    }
}

/// Returns the inertia about a joint's axis of everything it carries, kg m²; for a slide the mass, kg.
fn inertia_beyond(links: &[Link], joint: usize) -> f64 {
    let Some(axis) = &links[joint].joint else { return 0.0 };
    let (direction, anchor) = (Vector3::from(axis.axis), Vector3::from(axis.anchor));
    let mut hangs = vec![false; links.len()];
    let mut sum = 0.0;
    for (number, link) in links.iter().enumerate().skip(joint) {
        hangs[number] = number == joint || link.joint.as_ref().is_some_and(|joint| hangs[joint.parent]);
        for part in link.parts.iter().filter(|_| hangs[number]) {
            sum += match axis.kind {
                JointKind::Prismatic => part.mass,
                _ => {
                    let arm = (part.centre - anchor).cross(&direction).norm_squared();
                    direction.dot(&(part.inertia * direction)) + part.mass * arm
                }
            };
        }
    }
    sum
}

/// Returns the rotation from the URDF's axes to the robot frame: exactly half a turn about x.
pub(crate) fn z_down() -> UnitQuaternion<f64> {
    UnitQuaternion::new_unchecked(Quaternion::new(0.0, 1.0, 0.0, 0.0))
}

pub(crate) fn isometry(origin: &urdf_rs::Pose) -> Isometry3<f64> {
    let [roll, pitch, yaw] = *origin.rpy;
    Isometry3::from_parts(Vector3::from(*origin.xyz).into(), UnitQuaternion::from_euler_angles(roll, pitch, yaw))
}

/// Returns the mass properties of a link, or `None` for a frame without mass.
pub(crate) fn part(link: &urdf_rs::Link, pose: &Pose) -> Option<Part> {
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

/// Returns the shape of a link, in the robot frame.
pub(crate) fn solid(
    source: &Source,
    link: &urdf_rs::Link,
    collision: &urdf_rs::Collision,
    pose: &Pose,
    material: &Material,
) -> Result<Solid, String> {
    let place = Isometry3::from_parts(Default::default(), z_down()) * pose * isometry(&collision.origin);
    // Primitive shapes are symmetric about their z axis. Meshes are not; `mesh` converts them to z down.
    let (shape, turn) = match &collision.geometry {
        Geometry::Mesh { filename, scale } => (hull(source, filename, scale.map(|scale| *scale))?, z_down()),
        geometry => (primitive(geometry)?, UnitQuaternion::identity()),
    };
    let (position, rotation) = scene::position_and_rotation(&(place * turn));
    Ok(Solid { name: link.name.clone(), shape, position, rotation, material: material.clone() })
}

/// Returns a primitive shape. All are symmetric about their z axis, so they need no conversion to z down.
fn primitive(geometry: &Geometry) -> Result<Shape, String> {
    match geometry {
        Geometry::Box { size } => Ok(Shape::Box { size: **size }),
        Geometry::Cylinder { radius, length } => Ok(Shape::Cylinder { radius: *radius, length: *length }),
        Geometry::Sphere { radius } => Ok(Shape::Ball { radius: *radius }),
        other => Err(format!("geometry {other:?}: expected box, cylinder, sphere or mesh")),
    }
}

/// Returns the file of a mesh. `package://` names a folder above that of the URDF, or beside one.
pub(crate) fn mesh_file(source: &Source, filename: &str) -> String {
    let name = filename.rsplit("://").next().unwrap_or(filename);
    let above = |levels: usize| format!("{}{name}", "../".repeat(levels));
    (0..=MAX_LEVELS).map(above).find(|file| source.has(file)).unwrap_or_else(|| name.to_owned())
}

/// Returns the convex hull of a mesh, which needs only few of its corners. A mirrored scale is fine for a hull.
fn hull(source: &Source, filename: &str, scale: Option<[f64; 3]>) -> Result<Shape, String> {
    let scale = scale.unwrap_or([1.0; 3]);
    if let Some(problem) = mesh::SCALE.problem_in("scale", &scale.map(f64::abs)) {
        return Err(format!("{problem}, either sign"));
    }
    let name = mesh_file(source, filename);
    let Shape::Mesh { vertices, .. } = mesh::read(source, &name, scale)? else {
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
