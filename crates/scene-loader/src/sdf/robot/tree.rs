//! The tree of a robot's links, as a URDF.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use nalgebra::Isometry3;
use scene::check;
use urdf_rs::{Axis, Joint, JointLimit, JointType, LinkName, Vec3};

use super::link::{Placed, moved};
use super::{Hinge, Model, NO_LIMIT, SdfRobot, WORLD};
use crate::urdf::{JOINT_SPEED, escaped, origin};

/// Part of the greatest effort that a joint without a limit gets: rounding keeps it within.
const ROUNDING: f64 = 0.999;

/// Makes the URDF of a model. The robot's frame is that of the model.
pub(super) fn urdf(mut model: Model) -> SdfRobot {
    if model.joints.iter().any(|joint| joint.parent == WORLD) && model.link(WORLD).is_none() {
        model.links.push(Placed::empty(WORLD, Isometry3::identity()));
    }
    let mut tree = Tree::of(&mut model);
    tree.grow();
    let Tree { order, joints, .. } = tree;
    let frames: BTreeMap<String, Isometry3<f64>> =
        joints.iter().map(|joint| (joint.child.clone(), joint.pose)).collect();
    let frame = |name: &str| frames.get(name).copied().unwrap_or_default();
    let driven = driven(&model, &joints);
    let mass: f64 = model.links.iter().map(|placed| placed.link.inertial.mass.value).sum();
    let effort = (ROUNDING * check::MAX_PUSH * check::EARTH_GRAVITY * mass.max(1.0)).min(check::MAX_TORQUE.most);
    let usual = Usual { effort: effort.floor(), speed: JOINT_SPEED };
    say_of_usual(&mut model, &joints, &driven, &usual);
    let mut links: Vec<Placed> = Vec::new();
    for number in order {
        let mut placed = std::mem::replace(&mut model.links[number], Placed::empty("", Isometry3::identity()));
        let by = frame(&placed.link.name).inverse() * placed.pose;
        moved(&mut placed, &by);
        links.push(placed);
    }
    let names = Names::of(&links, &joints);
    let mut robot = urdf_rs::Robot {
        name: model.name.clone(),
        version: None,
        links: Vec::new(),
        joints: joints
            .iter()
            .map(|joint| written(joint, &frame(&joint.parent), &names, driven.contains(&joint.name).then_some(&usual)))
            .collect(),
        materials: Vec::new(),
    };
    let mut gazebo = String::new();
    for mut placed in links {
        placed.link.name = names.link(&placed.link.name);
        add_gazebo(&placed, &mut gazebo);
        robot.links.push(placed.link);
    }
    if !model.plugins.is_empty() {
        let _ = write!(gazebo, "<gazebo>{}</gazebo>", model.plugins.concat());
    }
    // The URDF library writes no elements of Gazebo.
    let text = urdf_rs::write_to_string(&robot).unwrap_or_default();
    let body = text.trim_end().strip_suffix("</robot>").unwrap_or(&text);
    let said = |(what, (count, about)): (String, (usize, Vec<String>))| match (count, about.as_slice()) {
        (0 | 1, []) => what,
        (_, []) => format!("{what} ({count} times)"),
        (_, about) => format!("{what}: {}", names::listed(about.iter().map(String::as_str))),
    };
    SdfRobot {
        text: format!("{body}{gazebo}</robot>\n"),
        wheels: model
            .sides
            .iter()
            .filter(|name| joints.iter().any(|it| it.name == **name))
            .map(|it| names.joint(it))
            .collect(),
        name: model.name,
        folders: model.folders.into_iter().collect(),
        left_out: model.notes.into_iter().map(said).collect(),
    }
}

/// Lists the driven joints: those that a plugin names, or all if none names any.
fn driven(model: &Model, joints: &[Hinge]) -> BTreeSet<String> {
    let names = || joints.iter().map(|joint| joint.name.clone());
    let said: BTreeSet<String> = names().filter(|name| model.said.contains(name)).collect();
    if said.is_empty() { names().collect() } else { said }
}

/// Limits of a driven joint with ends that has none in its file.
struct Usual {
    /// N m or N: as much as lifts the robot many times.
    effort: f64,
    /// rad/s or m/s.
    speed: f64,
}

/// Notes the driven joints that have no limit of effort, and those that nothing drives.
fn say_of_usual(model: &mut Model, joints: &[Hinge], driven: &BTreeSet<String>, usual: &Usual) {
    let Usual { effort, speed } = usual;
    for joint in joints.iter().filter(|joint| matches!(joint.kind, JointType::Revolute | JointType::Prismatic)) {
        match driven.contains(&joint.name) {
            true if !joint.limit.effort.is_finite() => {
                let what = format!("no limit of effort: up to {effort} N m, and {speed} rad/s without a velocity");
                model.note_of(what, &joint.name);
            }
            false if joint.limit.effort != 0.0 => {
                model.note_of("no plugin drives these joints, so they swing freely", &joint.name);
            }
            _ => {}
        }
    }
}

/// A tree that grows from its root.
struct Tree<'m> {
    model: &'m mut Model,
    /// Numbers of links in the tree, parents first.
    order: Vec<usize>,
    /// Joints of the tree.
    joints: Vec<Hinge>,
    is_in: Vec<bool>,
}

impl<'m> Tree<'m> {
    fn of(model: &'m mut Model) -> Self {
        let is_in = vec![false; model.links.len()];
        Self { model, order: Vec::new(), joints: Vec::new(), is_in }
    }

    fn grow(&mut self) {
        let mut left: Vec<Option<Hinge>> = std::mem::take(&mut self.model.joints).into_iter().map(Some).collect();
        while let Some(root) = self.next_root(&left) {
            if let Some(&first) = self.order.first() {
                let [parent, child] = [first, root].map(|number| self.model.links[number].link.name.clone());
                self.model.note_of(format!("links that hang on nothing are held on {parent}"), &child);
                let pose = self.model.links[root].pose;
                self.joints.push(Hinge::held(&format!("{child}_held"), parent, child, pose));
            }
            self.add(root);
            let mut open = self.order.len() - 1;
            while open < self.order.len() {
                let at = self.model.links[self.order[open]].link.name.clone();
                for slot in &mut left {
                    let Some(mut joint) = slot.take_if(|joint| joint.parent == at || joint.child == at) else {
                        continue;
                    };
                    let other = if joint.parent == at { &joint.child } else { &joint.parent };
                    let Some(number) = self.model.links.iter().position(|it| it.link.name == *other) else { continue };
                    if self.is_in[number] {
                        self.model.note_of("joints that close a loop are left out", &joint.name);
                        continue;
                    }
                    if joint.child == at {
                        (joint.parent, joint.child) = (joint.child, joint.parent);
                        joint.axis = -joint.axis;
                    }
                    self.joints.push(joint);
                    self.add(number);
                }
                open += 1;
            }
        }
    }

    fn add(&mut self, number: usize) {
        self.is_in[number] = true;
        self.order.push(number);
    }

    /// Returns the root of the next tree: the world, the only link that no joint carries, or the heaviest one.
    fn next_root(&self, left: &[Option<Hinge>]) -> Option<usize> {
        let open = || (0..self.is_in.len()).filter(|number| !self.is_in[*number]);
        let link = |number: &usize| &self.model.links[*number].link;
        let is_carried = |number: &usize| left.iter().flatten().any(|joint| joint.child == link(number).name);
        let world = open().find(|number| link(number).name == WORLD);
        // Only the first tree may have such a root: looking for it costs links times joints.
        let mut free = open().filter(|number| self.order.is_empty() && !is_carried(number));
        let only = free.next().filter(|_| free.next().is_none());
        let mass = |number: &usize| link(number).inertial.mass.value;
        // Of equal masses the first.
        let heaviest = || open().reduce(|best, next| if mass(&next) > mass(&best) { next } else { best });
        world.or(only).or_else(heaviest)
    }
}

impl Hinge {
    fn held(name: &str, parent: String, child: String, pose: Isometry3<f64>) -> Self {
        Self {
            name: name.to_owned(),
            kind: JointType::Fixed,
            pose,
            parent,
            child,
            axis: nalgebra::Vector3::x(),
            limit: JointLimit::default(),
            dynamics: None,
            mimic: None,
        }
    }
}

/// Returns a joint as a URDF has it; `usual` are the limits that it has without a word if it is driven.
fn written(joint: &Hinge, around: &Isometry3<f64>, names: &Names, usual: Option<&Usual>) -> Joint {
    let has_ends = matches!(joint.kind, JointType::Revolute | JointType::Prismatic);
    let mut limit = JointLimit { velocity: joint.limit.velocity, ..JointLimit::default() };
    if has_ends {
        (limit.lower, limit.upper) = (joint.limit.lower.max(-NO_LIMIT), joint.limit.upper.min(NO_LIMIT));
    }
    if let Some(usual) = usual {
        // Without a limit a wheel has that of its robot.
        if joint.limit.effort.is_finite() {
            limit.effort = joint.limit.effort;
        } else if has_ends {
            limit.effort = usual.effort;
        }
        if has_ends && limit.velocity == 0.0 {
            limit.velocity = usual.speed;
        }
    }
    let mimic = joint.mimic.clone().map(|mimic| urdf_rs::Mimic { joint: names.joint(&mimic.joint), ..mimic });
    let direction = (joint.pose.rotation.inverse() * joint.axis).try_normalize(0.0).unwrap_or(nalgebra::Vector3::z());
    Joint {
        name: names.joint(&joint.name),
        joint_type: joint.kind.clone(),
        origin: origin(&(around.inverse() * joint.pose)),
        parent: LinkName { link: names.link(&joint.parent) },
        child: LinkName { link: names.link(&joint.child) },
        axis: Axis { xyz: Vec3(direction.into()) },
        limit,
        calibration: None,
        dynamics: joint.dynamics.clone(),
        mimic,
        safety_controller: None,
    }
}

/// Adds what a link has for Gazebo: sensors, and directions of friction.
fn add_gazebo(placed: &Placed, text: &mut String) {
    let name = escaped(&placed.link.name);
    for sensor in &placed.sensors {
        let urdf_rs::Pose { xyz, rpy } = origin(&sensor.pose);
        let pose: Vec<String> = xyz.iter().chain(rpy.iter()).map(ToString::to_string).collect();
        let (head, pose, inside) = (&sensor.head, pose.join(" "), &sensor.inside);
        let _ =
            write!(text, "<gazebo reference=\"{name}\"><sensor{head}><pose>{pose}</pose>{inside}</sensor></gazebo>");
    }
    if !placed.directions.is_empty() {
        let _ = write!(text, "<gazebo reference=\"{name}\">{}</gazebo>", placed.directions);
    }
}

/// Names without the colons of models inside of each other, each of its own.
struct Names {
    links: BTreeMap<String, String>,
    joints: BTreeMap<String, String>,
}

impl Names {
    fn of(links: &[Placed], joints: &[Hinge]) -> Self {
        let plain = |names: &mut dyn Iterator<Item = &String>| {
            let (mut made, mut taken) = (BTreeMap::new(), BTreeSet::new());
            for name in names {
                let mut plain = name.replace("::", "_");
                while !taken.insert(plain.clone()) {
                    plain.push('_');
                }
                made.insert(name.clone(), plain);
            }
            made
        };
        Self {
            links: plain(&mut links.iter().map(|placed| &placed.link.name)),
            joints: plain(&mut joints.iter().map(|joint| &joint.name)),
        }
    }

    fn link(&self, name: &str) -> String {
        self.links.get(name).cloned().unwrap_or_else(|| name.to_owned())
    }

    fn joint(&self, name: &str) -> String {
        self.joints.get(name).cloned().unwrap_or_else(|| name.to_owned())
    }
}
