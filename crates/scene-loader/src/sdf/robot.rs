//! Robots of SDF: a model becomes a URDF, of which the import makes a robot.
//!
//! Nested and included models become one tree. Shapes that a URDF does not have, as parts of meshes, are written as meshes.

mod link;
mod tree;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use nalgebra::{Isometry3, Vector3};
use roxmltree::Node;
use urdf_rs::{JointLimit, JointType};

use self::link::{Parts, Placed};
use super::frames::{self, FrameError, Frames};
use super::models::{Models, well_known};
use super::reading::{self, Included, MAX_DEPTH, MAX_INCLUDED, MAX_NODES, Place};
use super::{ROOTS, child, children, is_true, number_of, numbers, text_of};
use crate::LoadError;
use crate::import::{Import, Imported, import};
use crate::problem::Problems;
use crate::source::Source;
use crate::xml;

/// Maximum number of missing models that an error lists.
const MAX_SAID: usize = 20;
/// Maximum number of links of a robot, of its joints, and of its shapes.
const MAX_LINKS: usize = 1000;
const MAX_JOINTS: usize = 2000;
const MAX_SHAPES: usize = 10_000;
/// Maximum length of the sensors and plugins of a robot, bytes.
const MAX_RAW: usize = 4 << 20;
/// Part of a link's mass that the link between the two axes of its joint has.
const BETWEEN: f64 = 0.01;
/// Limit from which on a joint has none, rad or m. SDF's own is 1e16.
const NO_LIMIT: f64 = 1e9;
/// Version of SDF before which axes are in the frame of the model.
const AXES_OF_JOINTS: [u32; 2] = [1, 5];
/// Advice where a model is missing.
const MODELS_HINT: &str = "name its folder by --models, GZ_SIM_RESOURCE_PATH or GAZEBO_MODEL_PATH";
/// Name of the frame that never moves.
const WORLD: &str = "world";

/// A file of SDF, and where to find the models that it includes.
#[derive(Debug, Clone, Copy)]
pub struct SdfFile<'a> {
    /// The file.
    pub file: &'a Path,
    /// Folders in which models of Gazebo are looked for, beside those around the file.
    pub models: &'a [PathBuf],
    /// Folder outside of which nothing is read, for files of strangers: a whole path without links. `None` if everything may be.
    pub within: Option<&'a Path>,
    /// Folder for meshes that are made of others.
    pub work: &'a Path,
}

/// A model as a URDF.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SdfRobot {
    /// Name of the model.
    pub name: String,
    /// The URDF. Its meshes have absolute paths.
    pub text: String,
    /// Joints of driven wheels that a plugin names; empty if none does.
    pub wheels: Vec<String>,
    /// Folders of its meshes.
    pub folders: Vec<PathBuf>,
    /// Parts that are left out or changed, in words.
    pub left_out: Vec<String>,
}

impl SdfRobot {
    /// Imports the robot with these settings, whose text does not count. Without wheels it has those that a plugin names.
    ///
    /// # Errors
    /// Does as [`import`] does.
    pub fn import(&self, settings: &Import) -> Result<Imported, LoadError> {
        let wheels = if settings.wheels.is_empty() { &self.wheels } else { settings.wheels };
        let mut imported = import(&Import { text: &self.text, wheels, ..*settings })?;
        imported.left_out.extend_from_slice(&self.left_out);
        Ok(imported)
    }
}

/// True if a text is SDF.
pub fn is_sdf(text: &str) -> bool {
    xml::parse(text, MAX_NODES).is_ok_and(|document| ROOTS.contains(&document.root_element().tag_name().name()))
}

/// True if a text is SDF of models and of no world.
pub fn is_sdf_model(text: &str) -> bool {
    xml::parse(text, MAX_NODES).is_ok_and(|document| {
        let root = document.root_element();
        ROOTS.contains(&root.tag_name().name()) && child(root, "world").is_none()
    })
}

/// Lists the models of a file that could be robots: those with joints that move.
///
/// # Errors
/// Reports a file that cannot be read, and all its problems.
pub fn sdf_robots(of: &SdfFile) -> Result<Vec<String>, LoadError> {
    Ok(read(of, None)?.robots)
}

/// Makes a URDF of the model with this name. Without a name it is the only robot of the file, or its only model.
///
/// # Errors
/// Reports a file that cannot be read, all its problems, and a name that is missing or unknown.
pub fn sdf_robot(of: &SdfFile, name: Option<&str>) -> Result<SdfRobot, LoadError> {
    let wrong = |reason: String| Err(LoadError::Import(format!("{}: {reason}", of.file.display())));
    let Found { robots, others, missing, model, .. } = read(of, name)?;
    let all = || names::listed(robots.iter().chain(&others).map(String::as_str));
    match (name, model) {
        (None, Some(_)) if robots.len() > 1 => wrong(format!(
            "{} robots: name one by --model: {}",
            robots.len(),
            names::listed(robots.iter().map(String::as_str))
        )),
        (_, Some(model)) => Ok(tree::urdf(model)),
        (Some(name), None) => {
            let meant = names::did_you_mean(name, robots.iter().chain(&others).map(String::as_str));
            wrong(format!("no model `{name}`{meant}: expected one of {}{}", all(), also(&missing)))
        }
        (None, None) => {
            let others = if others.is_empty() { String::new() } else { format!("; --model names one of {}", all()) };
            wrong(format!("no model with joints that move: expected a robot{others}{}", also(&missing)))
        }
    }
}

/// Returns a line for each model that could not be read.
fn also(missing: &[String]) -> String {
    missing.iter().take(MAX_SAID).map(|why| format!("\nnote: {why}")).collect()
}

/// A model with those inside of it. Poses are in its frame.
#[derive(Default)]
struct Model {
    name: String,
    links: Vec<Placed>,
    joints: Vec<Hinge>,
    /// Poses of the models inside, by their names.
    inside: BTreeMap<String, Isometry3<f64>>,
    /// Plugins, as they are written.
    plugins: Vec<String>,
    /// Names that plugins say anywhere: a joint among them is driven.
    said: BTreeSet<String>,
    /// Joints that plugins drive on the left or the right.
    sides: Vec<String>,
    /// Link that the model's frame is on.
    canonical: Option<String>,
    /// Number of shapes, and length of sensors and plugins.
    shapes: usize,
    raw: usize,
    folders: BTreeSet<PathBuf>,
    /// Parts that are left out or changed: the counts of each kind, and the names that it is about.
    notes: BTreeMap<String, (usize, Vec<String>)>,
}

/// A joint of one axis.
struct Hinge {
    name: String,
    kind: JointType,
    pose: Isometry3<f64>,
    parent: String,
    child: String,
    /// Direction in the frame of the model.
    axis: Vector3<f64>,
    /// Without a limit of effort it is infinite.
    limit: JointLimit,
    dynamics: Option<urdf_rs::Dynamics>,
    mimic: Option<urdf_rs::Mimic>,
}

impl Model {
    fn note(&mut self, what: impl Into<String>) {
        self.notes.entry(what.into()).or_default().0 += 1;
    }

    /// Notes something about a link or a joint.
    fn note_of(&mut self, what: impl Into<String>, name: &str) {
        self.notes.entry(what.into()).or_default().1.push(name.to_owned());
    }

    /// Returns an element as it is written, while there is room.
    fn raw<'t>(&mut self, text: &'t str, node: Node) -> &'t str {
        let piece = &text[node.range()];
        self.raw += piece.len();
        if self.raw <= MAX_RAW {
            return piece;
        }
        self.note(format!("sensors and plugins beyond {} MB are left out", MAX_RAW >> 20));
        ""
    }

    fn moves(&self) -> bool {
        self.joints.iter().any(|joint| joint.kind != JointType::Fixed)
    }

    fn link(&self, name: &str) -> Option<&Placed> {
        self.links.iter().find(|placed| placed.link.name == name)
    }
}

/// Models of a file.
#[derive(Default)]
struct Found {
    /// Names of models with joints that move.
    robots: Vec<String>,
    /// Names of the others.
    others: Vec<String>,
    /// Models that could not be read, in words.
    missing: Vec<String>,
    /// The model that was asked for, or the first robot, or the only model of a file.
    model: Option<Model>,
    is_model: bool,
}

fn read(of: &SdfFile, wanted: Option<&str>) -> Result<Found, LoadError> {
    let file = of.file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let mut reader = Reader {
        problems: Problems::default(),
        models: Models { folders: of.models, within: of.within },
        parts: Parts::new(of.work),
        wanted,
        found: Found::default(),
        included: 0,
    };
    let source = Source::of_file(of.file);
    reading::file(&source, &file, 0, |place, root| reader.all(place, root))?;
    let Reader { problems, found, .. } = reader;
    problems.into_result(found)
}

struct Reader<'a> {
    problems: Problems,
    models: Models<'a>,
    parts: Parts<'a>,
    wanted: Option<&'a str>,
    found: Found,
    /// Number of included files.
    included: usize,
}

/// A model whose elements are being read.
struct Scope<'a, 'i> {
    node: Node<'a, 'i>,
    frames: Frames<'a, 'i>,
    /// Begin of the names inside.
    prefix: &'a str,
    /// Pose in the robot's frame.
    base: Isometry3<f64>,
}

/// A function of a file's root.
type Each<'f> = &'f mut dyn FnMut(&mut Reader, Place, Node) -> Result<(), LoadError>;

impl Reader<'_> {
    fn problem(&mut self, place: Place, node: Node, message: impl std::fmt::Display) {
        place.problem(&mut self.problems, node, message);
    }

    /// Returns a pose, or reports why there is none.
    fn posed(&mut self, place: Place, node: Node, pose: Result<Isometry3<f64>, FrameError>) -> Isometry3<f64> {
        place.posed(&mut self.problems, node, pose)
    }

    /// Reads the models of a file and of its worlds.
    fn all(&mut self, place: Place, root: Node) -> Result<(), LoadError> {
        self.found.is_model = child(root, "world").is_none();
        for around in [root].into_iter().chain(children(root, "world")) {
            let frames = Frames::of(around);
            for node in around.children() {
                match node.tag_name().name() {
                    "model" => self.top(place, node, &Included::default())?,
                    "include" => {
                        let included = Included::of(place, node, &frames, Isometry3::identity(), &mut self.problems);
                        let read =
                            &mut |reader: &mut Reader, place: Place, model: Node| reader.top(place, model, &included);
                        let missing = self.include(place, node, read);
                        self.found.missing.extend(missing);
                    }
                    _ => {}
                }
            }
        }
        Ok(())
    }

    /// Reads a model that is inside of no other.
    fn top(&mut self, place: Place, node: Node, included: &Included) -> Result<(), LoadError> {
        let name = included.name.clone().or(node.attribute("name").map(str::to_owned)).unwrap_or_default();
        let is_static = included.is_static.unwrap_or_else(|| is_true(text_of(node, "static")));
        self.parts.is_open = match self.wanted {
            Some(wanted) => name == wanted,
            None => !is_static && self.found.robots.is_empty(),
        };
        let mut model = Model { name, ..Model::default() };
        self.model(place, node, &mut model, "", Isometry3::identity())?;
        if model.links.is_empty() {
            return Ok(());
        }
        let is_robot = !is_static && model.moves();
        let is_better = match self.wanted {
            Some(wanted) => model.name == wanted && self.found.model.is_none(),
            None if is_robot => self.found.robots.is_empty(),
            None => self.found.model.is_none() && self.found.is_model,
        };
        if is_robot { &mut self.found.robots } else { &mut self.found.others }.push(model.name.clone());
        if is_better {
            self.found.model = Some(model);
        }
        Ok(())
    }

    /// Reads the model of an included file. What somebody else's model has wrong costs that model alone: its note is returned.
    fn include(&mut self, place: Place, node: Node, each: Each) -> Option<String> {
        let uri = text_of(node, "uri");
        let Some((folder, file)) = self.models.find(place.source, uri) else {
            return well_known(uri).is_none().then(|| format!("model `{uri}` is not there: {MODELS_HINT}"));
        };
        if self.included >= MAX_INCLUDED || place.depth >= MAX_DEPTH {
            return Some(format!("more than {MAX_INCLUDED} included models, or {MAX_DEPTH} inside each other"));
        }
        self.included += 1;
        let read = reading::file(&folder, &file, place.depth + 1, |place, root| {
            child(root, "model").map_or(Ok(()), |model| each(self, place, model))
        });
        read.err().map(|error| format!("model `{uri}` is left out: {error}"))
    }

    /// Adds the links and joints of a model at a pose to a robot.
    fn model(
        &mut self,
        place: Place,
        node: Node,
        model: &mut Model,
        prefix: &str,
        base: Isometry3<f64>,
    ) -> Result<(), LoadError> {
        let scope = Scope { node, frames: Frames::of(node), prefix, base };
        if place.depth > MAX_DEPTH {
            self.problem(place, node, format_args!("expected at most {MAX_DEPTH} models inside each other"));
            return Ok(());
        }
        for link in children(node, "link") {
            if model.links.len() >= MAX_LINKS {
                self.problem(place, link, format_args!("expected at most {MAX_LINKS} links of a robot"));
                return Ok(());
            }
            let at = base * self.posed(place, link, scope.frames.pose(link));
            let placed = self.link(place, link, &scope, at, model);
            model.links.push(placed);
        }
        if prefix.is_empty() {
            let named = node.attribute("canonical_link").map(str::to_owned);
            model.canonical = named.or_else(|| model.links.first().map(|placed| placed.link.name.clone()));
        }
        for inner in node.children() {
            let inside = Place { depth: place.depth + 1, ..place };
            match inner.tag_name().name() {
                "model" => {
                    let pose = self.posed(place, inner, scope.frames.pose(inner));
                    self.nested(
                        inside,
                        inner,
                        model,
                        &scope,
                        &Included { parent: base, pose: Some(pose), ..Included::default() },
                    )?;
                }
                "include" => {
                    let included = Included::of(place, inner, &scope.frames, base, &mut self.problems);
                    let note = self.include(inside, inner, &mut |reader, place, found| {
                        reader.nested(place, found, model, &scope, &included)
                    });
                    note.into_iter().for_each(|note| model.note(note));
                }
                _ => {}
            }
        }
        for joint in children(node, "joint") {
            if model.joints.len() >= MAX_JOINTS {
                self.problem(place, joint, format_args!("expected at most {MAX_JOINTS} joints of a robot"));
                return Ok(());
            }
            self.joint(place, joint, &scope, model);
        }
        for plugin in children(node, "plugin") {
            add_plugin(plugin, place.text, prefix, model);
        }
        Ok(())
    }

    /// Adds a model inside of another.
    fn nested(
        &mut self,
        place: Place,
        node: Node,
        model: &mut Model,
        around: &Scope,
        included: &Included,
    ) -> Result<(), LoadError> {
        let own = included.name.as_deref().or(node.attribute("name")).unwrap_or("model");
        let base = included.placed(place, node, &Frames::of(node), || frames::pose(node), &mut self.problems);
        let prefix = if included.is_merged { around.prefix.to_owned() } else { format!("{}{own}::", around.prefix) };
        model.inside.insert(format!("{}{own}", around.prefix), base);
        self.model(place, node, model, &prefix, base)
    }

    fn joint(&mut self, place: Place, node: Node, scope: &Scope, model: &mut Model) {
        let own = node.attribute("name").unwrap_or("joint");
        let name = format!("{}{own}", scope.prefix);
        // Before SDF 1.2 the name was an attribute.
        let named = |end| child(node, end).and_then(|it| it.attribute("link")).unwrap_or_else(|| text_of(node, end));
        let mut ends = Vec::new();
        for end in ["parent", "child"] {
            let text = named(end);
            match link_of(text, scope, model) {
                Some(link) => ends.push(link),
                None => {
                    return model.note_of(format!("joints are left out, as there is no link `{text}`"), &name);
                }
            }
        }
        let [parent, child_link] = [0, 1].map(|end| ends[end].clone());
        if parent == child_link || child_link == WORLD {
            return model.note_of("joints are left out, as they carry nothing", &name);
        }
        let frame = frames::relative(node).unwrap_or(named("child"));
        let own_pose = self.posed(place, node, frames::pose(node));
        let pose = self.posed(place, node, pose_of(frame, scope, model)) * own_pose;
        let first = Axis::of(node, "axis", &pose, scope, model);
        let made = |kind: JointType, axis: Axis| Hinge {
            name: name.clone(),
            kind,
            pose,
            parent: parent.clone(),
            child: child_link.clone(),
            axis: axis.direction,
            limit: axis.limit,
            dynamics: Some(axis.dynamics),
            mimic: axis.mimic,
        };
        match node.attribute("type").unwrap_or("fixed") {
            "fixed" => model.joints.push(made(JointType::Fixed, first)),
            "ball" => model.joints.push(made(JointType::Spherical, first)),
            "prismatic" => model.joints.push(made(JointType::Prismatic, first)),
            "revolute" | "continuous" => {
                let kind = if first.has_ends() { JointType::Revolute } else { JointType::Continuous };
                model.joints.push(made(kind, first));
            }
            "revolute2" | "universal" => {
                // Two joints with a link between them.
                let second = Axis::of(node, "axis2", &pose, scope, model);
                let between = format!("{name}_between");
                let mut link = Placed::empty(&between, pose);
                if let Some(carried) = model.links.iter_mut().find(|placed| placed.link.name == child_link) {
                    link.take_mass(carried, BETWEEN);
                }
                model.links.push(link);
                let kind = |axis: &Axis| if axis.has_ends() { JointType::Revolute } else { JointType::Continuous };
                let (one, other) = (kind(&first), kind(&second));
                let carrier = Hinge { child: between.clone(), ..made(one, first) };
                let carried = Hinge { name: format!("{name}_2"), parent: between, ..made(other, second) };
                model.joints.extend([carrier, carried]);
            }
            "gearbox" => model.note_of("gearboxes of two joints are left out", &name),
            other => {
                model.note_of(format!("joints of type `{other}` are held"), &name);
                model.joints.push(made(JointType::Fixed, first));
            }
        }
    }
}

/// An axis of a joint.
struct Axis {
    /// Direction in the frame of the robot.
    direction: Vector3<f64>,
    limit: JointLimit,
    dynamics: urdf_rs::Dynamics,
    mimic: Option<urdf_rs::Mimic>,
}

impl Axis {
    fn of(joint: Node, tag: &'static str, pose: &Isometry3<f64>, scope: &Scope, model: &mut Model) -> Self {
        let axis = child(joint, tag);
        let xyz = axis.and_then(|axis| child(axis, "xyz"));
        let own = Vector3::from(xyz.and_then(|it| numbers(it.text()?)).unwrap_or([0.0, 0.0, 1.0]));
        let version = joint.document().root_element().attribute("version").and_then(version);
        let is_old = version.is_some_and(|version| version < AXES_OF_JOINTS);
        let of_model = axis.is_some_and(|axis| is_true(text_of(axis, "use_parent_model_frame")));
        let named = xyz.and_then(|it| it.attribute("expressed_in")).filter(|frame| !frame.is_empty());
        let turn = match named {
            Some(frame) => pose_of(frame, scope, model).map_or(pose.rotation, |it| it.rotation),
            None if of_model || is_old => scope.base.rotation,
            None => pose.rotation,
        };
        let part = |of: &'static str, tag: &str| axis.and_then(|axis| number_of(child(axis, of)?, tag));
        let limit = JointLimit {
            lower: part("limit", "lower").unwrap_or(-NO_LIMIT).max(-NO_LIMIT),
            upper: part("limit", "upper").unwrap_or(NO_LIMIT).min(NO_LIMIT),
            effort: part("limit", "effort").filter(|it| *it >= 0.0).unwrap_or(f64::INFINITY),
            velocity: part("limit", "velocity").filter(|it| *it >= 0.0).unwrap_or(0.0),
            ..JointLimit::default()
        };
        let [damping, friction] = ["damping", "friction"].map(|tag| part("dynamics", tag).unwrap_or(0.0).max(0.0));
        if part("dynamics", "spring_stiffness").is_some_and(|it| it != 0.0) {
            model.note("a spring of a joint is left out");
        }
        let mimic = axis.and_then(|axis| child(axis, "mimic")).and_then(|mimic| {
            let number = |tag: &str, usual: f64| number_of(mimic, tag).unwrap_or(usual);
            let multiplier = number("multiplier", 1.0);
            // SDF's follower is at multiplier (leader - reference) + offset.
            let offset = number("offset", 0.0) - multiplier * number("reference", 0.0);
            let joint = format!("{}{}", scope.prefix, mimic.attribute("joint")?);
            Some(urdf_rs::Mimic { joint, multiplier: Some(multiplier), offset: Some(offset) })
        });
        Self { direction: turn * own, limit, dynamics: urdf_rs::Dynamics { damping, friction }, mimic }
    }

    fn has_ends(&self) -> bool {
        self.limit.lower > -NO_LIMIT || self.limit.upper < NO_LIMIT
    }
}

/// Reads a version: 1.10 is later than 1.9.
fn version(text: &str) -> Option<[u32; 2]> {
    let (major, minor) = text.trim().split_once('.')?;
    Some([major.parse().ok()?, minor.split('.').next()?.parse().ok()?])
}

/// Returns the pose of a frame in the robot's frame.
fn pose_of(name: &str, scope: &Scope, model: &Model) -> Result<Isometry3<f64>, FrameError> {
    let whole = format!("{}{name}", scope.prefix);
    match model.link(&whole).map(|placed| placed.pose).or(model.inside.get(&whole).copied()) {
        Some(pose) => Ok(pose),
        None => Ok(scope.base * scope.frames.named(name)?),
    }
}

/// Returns the link that an end of a joint names: itself, the link of a frame, or the first one of a model inside.
fn link_of(name: &str, scope: &Scope, model: &Model) -> Option<String> {
    let mut name = name.strip_suffix("::__model__").unwrap_or(name);
    if name == WORLD {
        return Some(WORLD.to_owned());
    }
    // Frames hang on frames, in no circle: every one of them has a name of its own.
    for _ in 0..MAX_DEPTH {
        let whole = format!("{}{name}", scope.prefix);
        if model.link(&whole).is_some() {
            return Some(whole);
        }
        let inside = format!("{whole}::");
        if let Some(placed) = model.links.iter().find(|placed| placed.link.name.starts_with(&inside)) {
            return Some(placed.link.name.clone());
        }
        let frame = scope.node.children().find(|it| it.attribute("name") == Some(name))?;
        let on = match frame.tag_name().name() {
            "frame" => frame.attribute("attached_to").filter(|on| !on.is_empty()),
            "joint" => Some(text_of(frame, "child")),
            _ => None,
        };
        match on {
            Some(on) if on != "__model__" => name = on,
            _ => return model.canonical.clone(),
        }
    }
    None
}

/// Adds a plugin, and the joints that it drives.
fn add_plugin(plugin: Node, text: &str, prefix: &str, model: &mut Model) {
    let raw = model.raw(text, plugin).to_owned();
    if raw.is_empty() {
        return;
    }
    for node in plugin.descendants().filter(|node| node.is_element()) {
        let Some(said) = node.text().map(str::trim).filter(|said| !said.is_empty() && said.len() < 200) else {
            continue;
        };
        let name = format!("{prefix}{said}");
        let tag = node.tag_name().name().to_ascii_lowercase();
        let is_side = ["left", "right"].iter().any(|side| tag.contains(side)) && !tag.contains("steer");
        let turns = |joint: &Hinge| joint.name == name && joint.kind == JointType::Continuous;
        if is_side && model.joints.iter().any(turns) && !model.sides.contains(&name) {
            model.sides.push(name.clone());
        }
        model.said.insert(name);
    }
    model.plugins.push(raw);
}
