//! URDF: a tree of links on joints, with masses, colliding shapes and visuals.
//!
//! Links on fixed joints become parts of their carriers. A continuous joint may carry a wheel; shape, rollers and servo of a wheel
//! come from robot.toml. URDF is x forward, y left, z up. It is converted here, once, to the robot frame, z down.

mod check;
mod clean;
mod hulls;
mod looks;
mod turn;

use std::collections::BTreeMap;

use nalgebra::{Isometry3, Matrix3, Quaternion, UnitQuaternion, Vector3};
use roxmltree::Node;
use scene::check::{self as limits, JOINT_LIMIT, ROBOT_REACH};
use scene::{Coupling, CouplingKind, Joint, JointKind, Link, Material, Motor, Part, Pose, ROOT, Shape, Solid};
use urdf_rs::{Geometry, JointType};

use self::check::{Check, unexpanded};
pub(crate) use self::clean::escaped;
use self::looks::Looks;
pub(crate) use self::turn::turn;
use crate::mesh;
use crate::problem::{Problems, Unread};
use crate::source::Source;
use crate::xml::{self, NotXml};

/// Maximum number of elements, attributes and texts of a file.
const MAX_NODES: u32 = 500_000;
/// Position error at which a servo reaches its torque limit, rad or m. A URDF gives no stiffness.
const FULL_TORQUE_ERROR: f64 = 0.02;
/// Error at which the servo of a joint that steers a car reaches its limit, rad. The friction that files give must not widen its circle.
pub(crate) const STEERING_ERROR: f64 = 0.001;
/// Speed error at which a speed servo reaches its torque limit, as a fraction of its greatest speed.
pub(crate) const FULL_TORQUE_LAG: f64 = 0.1;
/// Travel of a revolute joint from which on it turns many times, rad: three turns. Arms have up to two.
const MANY_TURNS: f64 = 3.0 * std::f64::consts::TAU;
/// Speed limit of a joint with an effort and without a speed, rad/s or m/s.
pub(crate) const JOINT_SPEED: f64 = 3.0;
/// Maximum number of folders above that of the URDF in which a mesh of a package is searched.
const MAX_LEVELS: usize = 4;
/// Digits that are kept of a pose that was turned: beyond these is only the rounding of a right angle.
const KEPT: f64 = 1e12;
/// Note about a joint without an effort.
const FREE: &str = "free to swing, as the effort is 0";

/// A URDF in the robot frame.
pub(crate) struct Urdf {
    /// Links, parents before their children. The first is the body; the others have the names of their joints.
    pub(crate) links: Vec<Link>,
    /// Joints that may carry wheels.
    pub(crate) continuous: Vec<Continuous>,
    /// Assumptions where the file gives no value, or asks for a feature that is not supported.
    pub(crate) assumptions: Vec<String>,
    /// Assumptions about joints, each with the joints that it is about.
    of_joints: BTreeMap<String, Vec<String>>,
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
        Self { links: vec![body], continuous: Vec::new(), assumptions: Vec::new(), of_joints: BTreeMap::new() }
    }

    /// Notes an assumption about a joint. Joints of which the same is said share a note.
    pub(crate) fn say_of(&mut self, joint: &str, what: impl Into<String>) {
        self.of_joints.entry(what.into()).or_default().push(joint.to_owned());
    }

    /// Takes back that a joint swings freely.
    pub(crate) fn is_driven(&mut self, joint: &str) {
        if let Some(joints) = self.of_joints.get_mut(FREE) {
            joints.retain(|free| free != joint);
        }
    }

    /// Ends the notes about joints.
    pub(crate) fn finish_notes(&mut self) {
        for (what, joints) in std::mem::take(&mut self.of_joints) {
            if let Some((last, others)) = joints.split_last() {
                let names =
                    if others.is_empty() { format!("joint {last}") } else { format!("joints {}", joints.join(", ")) };
                self.assumptions.push(format!("{names}: {what}"));
            }
        }
    }
}

/// Parses the XML of a URDF.
fn document(text: &str) -> Result<roxmltree::Document<'_>, NotXml> {
    xml::parse(text, MAX_NODES)
}

/// True if the root of an XML file declares the name space of xacro.
pub(crate) fn declares_xacro(text: &str) -> bool {
    document(text).is_ok_and(|document| document.root_element().namespaces().any(|it| check::is_xacro(it.uri())))
}

/// Returns the name of the robot in a URDF.
pub(crate) fn robot_name(text: &str) -> Option<String> {
    document(text).ok()?.root_element().attribute("name").map(str::to_owned)
}

/// A URDF as it is written.
pub(crate) struct Parsed<'t> {
    pub(crate) document: roxmltree::Document<'t>,
    pub(crate) robot: urdf_rs::Robot,
    /// Parts that are left out, in words.
    pub(crate) left_out: Vec<String>,
}

/// Parses a URDF and checks the tree and the numbers. `shown` names the file in problems.
pub(crate) fn parse<'t>(shown: &str, text: &'t str, problems: &mut Problems) -> Result<Parsed<'t>, Unread> {
    let document = self::document(text).map_err(|error| {
        let is_xacro = error.to_string().contains("'xacro'");
        let message = if is_xacro { unexpanded("<xacro:..>") } else { error.to_string() };
        problems.at(shown, text, error.offset, message);
        Unread
    })?;
    let mut check = Check { file: shown, text, problems, good: true };
    check.robot(document.root_element());
    if !check.good {
        return Err(Unread);
    }
    let (clean, mut left_out) = clean::clean(document.root_element());
    let robot = urdf_rs::read_from_string(&clean).map_err(|error| {
        problems.at(shown, text, 0, format_args!("not a URDF: {error}"));
        Unread
    })?;
    left_out.extend(ignored(document.root_element()));
    Ok(Parsed { document, robot, left_out })
}

/// Returns the text of a URDF that is turned about the vertical, rad, counterclockwise from above; `None` if it cannot be read.
pub(crate) fn turned(text: &str, yaw: f64) -> Option<String> {
    let mut robot = parse("", text, &mut Problems::default()).ok()?.robot;
    turn(&mut robot, yaw);
    urdf_rs::write_to_string(&robot).ok()
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
    let Parsed { document, robot, left_out } = parse(&shown, text, problems)?;
    let mut tree = Tree {
        source,
        document: &document,
        robot: &robot,
        material: &material,
        wrong: Vec::new(),
        urdf: Urdf { assumptions: left_out, ..Urdf::body() },
        looks: Looks::default(),
    };
    tree.add_all();
    let Tree { wrong, mut urdf, looks, .. } = tree;
    urdf.assumptions.extend(looks.finish(&mut urdf.links));
    urdf.assumptions.extend(hulls::thin(&mut urdf.links));
    let good = wrong.is_empty();
    wrong.into_iter().for_each(|(offset, message)| problems.at(&shown, text, offset, message));
    if good { Ok(urdf) } else { Err(Unread) }
}

/// Words in the names of links, joints, meshes, plugins and controllers of Mecanum bases. Gazebo moves such a base to all sides by a plugin.
const MECANUM: [&str; 6] = ["mecanum", "omni_wheel", "omniwheel", "planar_move", "planarmove", "force_based_move"];

/// True if a URDF hints at Mecanum wheels: by names of links or meshes, by plugins and controllers of Gazebo and ros2_control, or by
/// Gazebo's diagonal directions of friction.
pub(crate) fn hints_at_mecanum(text: &str) -> bool {
    let Ok(document) = document(text) else { return false };
    let named = |name: &str| {
        let name = name.to_ascii_lowercase();
        MECANUM.iter().any(|word| name.contains(word))
    };
    let is_diagonal = |text: &str| {
        let numbers: Vec<f64> = text.split_whitespace().filter_map(|word| word.parse().ok()).collect();
        matches!(numbers[..], [x, y, _] if x.abs() > 0.5 && (x.abs() - y.abs()).abs() < 0.1)
    };
    let is_of_program = |node: Node| {
        node.attributes().any(|attribute| named(attribute.value()))
            || named(node.tag_name().name())
            || node.text().is_some_and(|text| text.len() < 200 && named(text))
    };
    document.root_element().descendants().any(|node| match node.tag_name().name() {
        "link" | "joint" if node.parent() == Some(document.root_element()) => node.attribute("name").is_some_and(named),
        "mesh" => node.attribute("filename").is_some_and(named),
        "fdir1" => node.text().is_some_and(is_diagonal),
        _ => {
            let mut around = node.ancestors().map(|it| it.tag_name().name());
            node.is_element()
                && around.any(|tag| ["plugin", "ros2_control", "transmission"].contains(&tag))
                && is_of_program(node)
        }
    })
}

/// Lists the elements of a URDF that are for other programs.
fn ignored(robot: Node) -> Vec<String> {
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
        let limits = self.limits(joint);
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
        // A joint that turns many times may be a wheel, too.
        if kind == JointKind::Continuous
            || kind == JointKind::Revolute && joint.limit.upper - joint.limit.lower > MANY_TURNS
        {
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

    /// Returns the limits of a joint as far as they mean something, rad or m.
    fn limits(&mut self, joint: &urdf_rs::Joint) -> [f64; 2] {
        let (lower, upper) = (joint.limit.lower, joint.limit.upper);
        if !matches!(joint.joint_type, JointType::Revolute | JointType::Prismatic) {
            return [lower, upper];
        }
        let (low, high) = (lower.min(upper), lower.max(upper));
        if lower > upper {
            self.urdf.say_of(&joint.name, format!("limits {lower} and {upper} are exchanged"));
        }
        let within = [low, high].map(|limit| limit.clamp(JOINT_LIMIT.least, JOINT_LIMIT.most));
        if within != [low, high] {
            self.urdf.say_of(&joint.name, format!("limits of {low} to {high} mean none"));
        }
        within
    }

    /// Couples joints that mimic others. Who mimics a follower mimics its leader.
    fn add_mimics(&mut self) {
        let robot = self.robot;
        let mimic_of = |name: &str| {
            let joint = robot.joints.iter().find(|joint| joint.name == name)?;
            let mimic = joint.mimic.as_ref()?;
            Some((mimic.joint.as_str(), mimic.multiplier.unwrap_or(1.0), mimic.offset.unwrap_or(0.0)))
        };
        for joint in &robot.joints {
            let Some((mut leader, mut multiplier, mut offset)) = mimic_of(&joint.name) else { continue };
            let number = |name: &str| self.urdf.links.iter().position(|link| link.name == name);
            let Some(follower) = number(&joint.name) else { continue };
            let mut length = 0;
            while let Some((next, own_multiplier, own_offset)) =
                mimic_of(leader).filter(|_| length <= robot.joints.len())
            {
                (offset, multiplier) = (offset + multiplier * own_offset, multiplier * own_multiplier);
                (leader, length) = (next, length + 1);
            }
            let held = match number(leader) {
                _ if length > robot.joints.len() => Some("they mimic each other in a circle"),
                Some(leader) if leader == follower => Some("it mimics itself"),
                Some(leader) => {
                    if let Some(joint) = &mut self.urdf.links[follower].joint {
                        joint.coupling = Some(Coupling { leader, multiplier, offset, kind: CouplingKind::Mimic });
                    }
                    None
                }
                None if robot.joints.iter().any(|joint| joint.name == leader) => Some("its leader does not move"),
                None => Some("its leader is not there"),
            };
            if let Some(why) = held {
                self.urdf.assumptions.push(format!("joint {} mimics {leader}: it is held, as {why}", joint.name));
                if let Some(joint) = &mut self.urdf.links[follower].joint {
                    (joint.kind, joint.limits) = (JointKind::Fixed, None);
                }
            }
        }
    }

    /// Adds a servo to every joint with an effort; joints without one swing freely. Numbers that mean none are lowered.
    fn add_servos(&mut self) {
        let mass: f64 = self.urdf.links.iter().map(|link| link.mass().mass).sum();
        // As much as lifts the robot many times at an arm of a metre.
        let most_torque = (limits::MAX_PUSH * limits::EARTH_GRAVITY * mass.max(1.0)).min(limits::MAX_TORQUE.most);
        for number in 1..self.urdf.links.len() {
            let links = &self.urdf.links;
            let Some(joint) = links[number].joint.as_ref().filter(|joint| joint.coupling.is_none()) else { continue };
            let name = &links[number].name;
            let Some(limit) = self.robot.joints.iter().find(|it| &it.name == name).map(|it| &it.limit) else {
                continue;
            };
            let is_many_turns = self.urdf.continuous.iter().any(|it| it.link == number);
            if !joint.kind.has_value() {
                continue;
            }
            let name = name.clone();
            if limit.effort == 0.0 {
                if !is_many_turns {
                    self.urdf.say_of(&name, FREE);
                }
                continue;
            }
            let mut said = Vec::new();
            // Below zero, too, a number means none.
            let mut lowered = |what: &str, given: f64, usual: Option<f64>, most: f64| match (given, usual) {
                (0.0, Some(usual)) => {
                    said.push(format!("{what} 0 is taken as {usual}"));
                    usual
                }
                _ if (0.0..=most).contains(&given) => given,
                _ => {
                    said.push(format!("{what} {given} is taken as {most:.0}"));
                    most
                }
            };
            let max_speed = lowered("velocity", limit.velocity, Some(JOINT_SPEED), limits::MAX_SPEED.most);
            let max_torque = lowered("effort", limit.effort, None, most_torque);
            // Wheels have numbers of their own.
            let (kind, inertia) = (joint.kind, inertia_beyond(links, number));
            let steers = links[number].steered_axle().is_some();
            let error = if steers { STEERING_ERROR } else { FULL_TORQUE_ERROR };
            if !said.is_empty() && !is_many_turns {
                self.urdf.say_of(&name, format!("{}, as no robot has that", said.join(", ")));
            }
            if let Some(joint) = &mut self.urdf.links[number].joint {
                joint.drive = Some(servo(kind, max_speed, max_torque, inertia, error));
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

/// Returns a servo of speed for a joint without an end, and one of position for any other, which reaches its torque limit at an error, rad or
/// m.
pub(crate) fn servo(kind: JointKind, max_speed: f64, max_torque: f64, inertia: f64, error: f64) -> Motor {
    let motor = Motor { max_speed, gain: 0.0, max_torque, stiffness: None, integral_time: None, armature: 0.0 };
    if kind == JointKind::Continuous {
        return Motor { gain: max_torque / (FULL_TORQUE_LAG * max_speed), ..motor };
    }
    let stiffness = (max_torque / error).min(limits::STIFFNESS.most);
    // Critical damping, without overshoot.
    let gain = (2.0 * (stiffness * inertia).sqrt()).clamp(limits::GAIN.least, limits::GAIN.most);
    Motor { gain, stiffness: Some(stiffness), ..motor }
}

/// Returns the inertia about a joint's axis of everything it carries, kg m²; for a slide the mass, kg.
pub(crate) fn inertia_beyond(links: &[Link], joint: usize) -> f64 {
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

/// Returns a pose as a URDF has it.
pub(crate) fn origin(pose: &Isometry3<f64>) -> urdf_rs::Pose {
    let (roll, pitch, yaw) = pose.rotation.euler_angles();
    let rounded = |number: f64| (number * KEPT).round() / KEPT;
    let xyz = <[f64; 3]>::from(pose.translation.vector).map(rounded);
    urdf_rs::Pose { xyz: urdf_rs::Vec3(xyz), rpy: urdf_rs::Vec3([roll, pitch, yaw].map(rounded)) }
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
