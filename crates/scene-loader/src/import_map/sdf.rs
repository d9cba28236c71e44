//! SDF of Gazebo: the colliding shapes of a world's models. It is z up, as URDF, and turned at the end of [`Reader::collision`].
//!
//! Shapes, poses, frames and surfaces are those of the file. Each kind of thing that is not followed is one note with a count.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use roxmltree::Node;
use scene::check::MAX_SOLIDS;
use scene::{Geographic, Pose, Shape};

use super::{Budget, FoundObject, Geometry, MapImport, Touch};
use crate::LoadError;
use crate::map::height_field;
use crate::mesh::{self, Piece};
use crate::problem::Problems;
use crate::sdf::frames::{self, FrameError, Frames};
use crate::sdf::models::{Models, WellKnown, well_known};
use crate::sdf::reading::{self, Included, MAX_DEPTH, MAX_INCLUDED, Place};
use crate::sdf::{child, children, is_true, number_of, numbers, solids, submesh, text_of};
use crate::source::{MAX_MESH, Source};
use crate::urdf::z_down;

/// Maximum size of all meshes that are read, bytes; one that is named again counts again.
const MAX_BYTES: u64 = 1 << 30;
/// Elements that say nothing about shapes, or are read elsewhere.
const SILENT: [&str; 24] = [
    "physics",
    "scene",
    "gui",
    "gravity",
    "magnetic_field",
    "atmosphere",
    "spherical_coordinates",
    "static",
    "self_collide",
    "pose",
    "link",
    "joint",
    "model",
    "include",
    "inertial",
    "collision",
    "visual",
    "name",
    "uri",
    "frame",
    "enable_wind",
    "allow_auto_disable",
    "wind",
    "state",
];

/// Distance of a centre of mass from the middle of its shape that is worth a note, m.
const ASIDE: f64 = 1e-3;
/// Elements of a surface that have no part here, and that are 0 by default.
const UNFOLLOWED: [&str; 4] = ["slip", "slip1", "slip2", "soft_cfm"];

/// Contents of a file.
#[derive(Default)]
pub(super) struct Found {
    pub(super) objects: Vec<FoundObject>,
    /// Parts that are left out or changed, in words.
    pub(super) notes: Vec<String>,
    /// Gravity, m/s², if the file says it.
    pub(super) gravity: Option<f64>,
    /// Place on earth, if the file says it.
    pub(super) origin: Option<Geographic>,
}

/// Reads the objects of a file. A strict import has a problem where a model or mesh is not there; otherwise it is left out.
pub(super) fn read(
    source: &Source,
    file: &str,
    models: Models,
    import: &MapImport,
    problems: &mut Problems,
) -> Result<Found, LoadError> {
    let mut reader = Reader {
        problems,
        models,
        is_strict: import.is_strict,
        without: import.without,
        met: BTreeSet::new(),
        found: Found::default(),
        notes: BTreeMap::new(),
        missing: BTreeMap::new(),
        robots: Vec::new(),
        triangles: Budget::default(),
        bytes: 0,
        included: 0,
    };
    reader.file(source, file, &Included::default(), 0)?;
    let Reader { mut found, notes, missing, robots, met, .. } = reader;
    if let Some(name) = import.without.iter().find(|name| !met.contains(*name)) {
        return Err(LoadError::Import(format!("{}: no model `{name}` to leave out", source.display(file))));
    }
    if !missing.is_empty() {
        let listed: Vec<String> = missing.iter().map(|(uri, count)| counted(&format!("`{uri}`"), *count)).collect();
        let hint = "name their folders by --models, GZ_SIM_RESOURCE_PATH or GAZEBO_MODEL_PATH";
        found.notes.push(format!("left out, as they are not there: {}: {hint}", shortened(&listed)));
    }
    if !robots.is_empty() {
        let names = shortened(&robots);
        let one = &robots[0];
        found.notes.push(format!(
            "models with joints stand fast: {names}: `usarsim import {file} --model {one} --class ..` makes a robot of one, and --without {one} leaves it out here"
        ));
    }
    found.notes.extend(notes.into_iter().map(|(what, count)| counted(&what, count)));
    Ok(found)
}

fn counted(what: &str, count: usize) -> String {
    if count == 1 { what.to_owned() } else { format!("{what} ({count} times)") }
}

/// Joins a list, of which the first twenty are shown.
fn shortened(list: &[String]) -> String {
    const SHOWN: usize = 20;
    let more = list.len().saturating_sub(SHOWN);
    let more = if more == 0 { String::new() } else { format!(" and {more} more") };
    format!("{}{more}", list[..list.len().min(SHOWN)].join(", "))
}

struct Reader<'p> {
    problems: &'p mut Problems,
    models: Models<'p>,
    is_strict: bool,
    /// Names of models to leave out, and those that were met.
    without: &'p [String],
    met: BTreeSet<String>,
    found: Found,
    /// Counts of what is left out or changed.
    notes: BTreeMap<String, usize>,
    /// Addresses of models and meshes that are not there, with their counts.
    missing: BTreeMap<String, usize>,
    /// Models with joints that move.
    robots: Vec<String>,
    triangles: Budget,
    /// Bytes of meshes so far.
    bytes: u64,
    /// Number of included files.
    included: usize,
}

impl Reader<'_> {
    /// Reads the worlds and models of a file.
    fn file(&mut self, source: &Source, file: &str, included: &Included, depth: usize) -> Result<(), LoadError> {
        reading::file(source, file, depth, |place, root| {
            for world in children(root, "world") {
                self.world(place, world)?;
            }
            for model in children(root, "model") {
                self.model(place, model, &Frames::of(root), included, "", &BTreeMap::new())?;
            }
            Ok(())
        })
    }

    fn world(&mut self, place: Place, world: Node) -> Result<(), LoadError> {
        if let Some([x, y, z]) = child(world, "gravity").and_then(|it| numbers(it.text()?)) {
            let is_down = x == 0.0 && y == 0.0 && z <= 0.0;
            if is_down {
                self.found.gravity = Some(-z);
            } else {
                self.note(format!("gravity of {x} {y} {z}: it points down here"));
            }
        }
        if let Some(place) = child(world, "spherical_coordinates") {
            let [latitude, longitude] = ["latitude_deg", "longitude_deg"].map(|key| number_of(place, key));
            self.found.origin = latitude.zip(longitude).map(|(latitude, longitude)| Geographic { latitude, longitude });
        }
        // A world that was saved has the poses of its models at that time beside those at the start.
        let state = children(world, "state").flat_map(|state| children(state, "model"));
        let poses = state.filter_map(|model| Some((model.attribute("name")?.to_owned(), frames::pose(model).ok()?)));
        let poses: BTreeMap<String, Isometry3<f64>> = poses.collect();
        self.models(place, world, &Frames::of(world), &Isometry3::identity(), "", &poses)
    }

    fn problem(&mut self, place: Place, node: Node, message: impl std::fmt::Display) {
        place.problem(self.problems, node, message);
    }

    fn note(&mut self, what: impl Into<String>) {
        *self.notes.entry(what.into()).or_default() += 1;
    }

    /// Notes a model or mesh that is not there.
    fn missing(&mut self, place: Place, node: Node, uri: &str) {
        if self.is_strict {
            let expected =
                "expected it beside this file, in a folder above, in one of --models or GZ_SIM_RESOURCE_PATH";
            self.problem(place, node, format_args!("`{uri}` is not there: {expected}"));
        }
        *self.missing.entry(uri.to_owned()).or_default() += 1;
    }

    /// Returns a pose, or reports why there is none.
    fn posed(&mut self, place: Place, node: Node, pose: Result<Isometry3<f64>, FrameError>) -> Isometry3<f64> {
        place.posed(self.problems, node, pose)
    }

    /// Reads the models inside a world or a model. `prefix` begins their names, and `poses` are those of a saved world.
    fn models(
        &mut self,
        place: Place,
        node: Node,
        frames: &Frames,
        parent: &Isometry3<f64>,
        prefix: &str,
        poses: &BTreeMap<String, Isometry3<f64>>,
    ) -> Result<(), LoadError> {
        if place.depth > MAX_DEPTH {
            self.problem(place, node, format_args!("expected at most {MAX_DEPTH} models inside each other"));
            return Ok(());
        }
        let inner = Place { depth: place.depth + 1, ..place };
        for child in node.children().filter(Node::is_element) {
            match child.tag_name().name() {
                "model" => {
                    let included = Included { parent: *parent, ..Included::default() };
                    self.model(inner, child, frames, &included, prefix, poses)?;
                }
                "include" => self.include(inner, child, frames, parent, prefix)?,
                tag if !SILENT.contains(&tag) => self.note(format!("<{tag}> is left out")),
                _ => {}
            }
        }
        Ok(())
    }

    fn include(
        &mut self,
        place: Place,
        node: Node,
        frames: &Frames,
        parent: &Isometry3<f64>,
        prefix: &str,
    ) -> Result<(), LoadError> {
        let uri = text_of(node, "uri");
        let mut included = Included::of(place, node, frames, *parent, self.problems);
        included.name = included.name.map(|name| format!("{prefix}{name}"));
        if let Some((folder, file)) = self.models.find(place.source, uri) {
            if self.included >= MAX_INCLUDED {
                self.problem(place, node, format_args!("more than {MAX_INCLUDED} included models"));
                return Ok(());
            }
            self.included += 1;
            return match self.file(&folder, &file, &included, place.depth + 1) {
                // What somebody else's model has wrong costs that model alone.
                Err(error) if !self.is_strict => {
                    self.note(format!("model `{uri}` is left out: {error}"));
                    Ok(())
                }
                other => other,
            };
        }
        match well_known(uri) {
            Some(WellKnown::Light) => {}
            Some(WellKnown::Ground) => {
                let pose = included.parent * included.pose.unwrap_or_default();
                let name = included.name.unwrap_or_else(|| "ground_plane".to_owned());
                let touch = Touch { friction: Some(1.0), restitution: None };
                let ground = FoundObject::fixed(name, on_map(pose), Geometry::Plain(Shape::HalfSpace), None);
                self.found.objects.push(FoundObject { touch, ..ground });
            }
            None => self.missing(place, node, uri),
        }
        Ok(())
    }

    fn model(
        &mut self,
        place: Place,
        node: Node,
        around: &Frames,
        included: &Included,
        prefix: &str,
        poses: &BTreeMap<String, Isometry3<f64>>,
    ) -> Result<(), LoadError> {
        let own_name = node.attribute("name").unwrap_or("model");
        let name = included.name.clone().unwrap_or_else(|| format!("{prefix}{own_name}"));
        if self.without.contains(&name) {
            self.met.insert(name);
            return Ok(());
        }
        let frames = Frames::of(node);
        let own = || poses.get(own_name).map_or_else(|| around.pose(node), |saved| Ok(*saved));
        let pose = included.placed(place, node, &frames, own, self.problems);
        let links: Vec<Node> = children(node, "link").collect();
        let collisions = links.iter().flat_map(|link| children(*link, "collision")).count();
        let is_static = included.is_static.unwrap_or_else(|| is_true(text_of(node, "static")));
        let moves = |joint: &Node| joint.attribute("type").is_some_and(|kind| kind != "fixed");
        let says =
            |link: &Node, key: &'static str| child(*link, key).map(|it| is_true(it.text().unwrap_or_default().trim()));
        let floats = |link: &Node| says(link, "gravity") == Some(false) || says(link, "kinematic") == Some(true);
        let is_alone = collisions == 1 && links.len() == 1 && !links.iter().any(floats);
        if !is_static && links.iter().any(floats) {
            self.note("a body that does not fall stands fast, although it could be pushed");
        } else if !is_static && children(node, "joint").any(|joint| moves(&joint)) {
            self.robots.push(name.clone());
        } else if !is_static && !is_alone && collisions > 0 {
            self.note("a model of several shapes stands fast, although it could move");
        }
        for link in links {
            let at = pose * self.posed(place, link, frames.pose(link));
            let colour = colour_of(link);
            let inertial = child(link, "inertial").map(|it| text_of(it, "mass"));
            let mass = inertial.and_then(|mass| mass.parse().ok()).unwrap_or(1.0);
            let middle = child(link, "inertial").and_then(|it| numbers::<6>(text_of(it, "pose")));
            if !is_static && is_alone && middle.is_some_and(|[x, y, z, ..]| x.hypot(y).hypot(z) > ASIDE) {
                self.note("a centre of mass aside: that of the shape counts");
            }
            let own: Vec<Node> = children(link, "collision").collect();
            if own.is_empty() && children(link, "visual").next().is_some() {
                self.note("a link that is only seen is left out");
            }
            for collision in own {
                let own_name = collision.attribute("name").filter(|_| collisions > 1);
                let name = own_name.map_or_else(|| name.clone(), |own| format!("{name}-{own}"));
                let in_link = frames.pose_on(collision, &(pose.inverse() * at));
                let at = pose * self.posed(place, collision, in_link);
                self.collision(place, collision, at, name, colour, (!is_static && is_alone).then_some(mass));
            }
        }
        self.models(place, node, &frames, &pose, &format!("{name}-"), &BTreeMap::new())
    }

    /// Adds the shape of a collision at a pose, z up.
    fn collision(
        &mut self,
        place: Place,
        node: Node,
        at: Isometry3<f64>,
        name: String,
        colour: Option<[f64; 3]>,
        mass: Option<f64>,
    ) {
        let geometry = child(node, "geometry").and_then(|it| it.children().find(Node::is_element));
        let Some(geometry) = geometry else { return self.note("a collision without a shape is left out") };
        if self.found.objects.len() >= MAX_SOLIDS {
            return self.problem(place, geometry, format_args!("more than {MAX_SOLIDS} shapes"));
        }
        let mask = node.descendants().find(|it| it.has_tag_name("collide_bitmask"));
        if mask.is_some_and(|mask| bits(mask.text().unwrap_or_default()) == Some(0)) {
            return self.note("a shape that touches nothing, by its <collide_bitmask>, is left out");
        }
        let touch = self.touch(node);
        let mut length = |key: &str| match number_of(geometry, key) {
            Some(length) => length,
            None => {
                self.note(format!("a <{}> without <{key}>: 1 m, as Gazebo takes it", geometry.tag_name().name()));
                1.0
            }
        };
        let found = match geometry.tag_name().name() {
            "box" => {
                let size = numbers(text_of(geometry, "size"));
                if size.is_none() {
                    self.note("a <box> without <size>: 1 m, as Gazebo takes it");
                }
                Some((at, Geometry::Plain(Shape::Box { size: size.unwrap_or([1.0; 3]) })))
            }
            "cylinder" => {
                let (radius, length) = (length("radius"), length("length"));
                Some((at, Geometry::Plain(Shape::Cylinder { radius, length })))
            }
            "sphere" => Some((at, Geometry::Plain(Shape::Ball { radius: length("radius") }))),
            "capsule" => {
                let (radius, length) = (length("radius"), length("length"));
                Some((at, Geometry::Mesh(solids::capsule(radius, length))))
            }
            "cone" => {
                let (radius, length) = (length("radius"), length("length"));
                Some((at, Geometry::Mesh(solids::cone(radius, length))))
            }
            "ellipsoid" => {
                let radii = numbers(text_of(geometry, "radii")).unwrap_or([1.0; 3]);
                Some((at, Geometry::Mesh(solids::ellipsoid(radii))))
            }
            "polyline" => {
                let points = children(geometry, "point").map(|point| numbers(point.text().unwrap_or_default()));
                let height = number_of(geometry, "height").unwrap_or(1.0);
                let points = points.collect::<Option<Vec<[f64; 2]>>>();
                let piece = points.and_then(|points| solids::prism(&points, height));
                if piece.is_none() {
                    self.note("a <polyline> that is no simple polygon is left out");
                }
                piece.map(|piece| (at, Geometry::Mesh(piece)))
            }
            "plane" => {
                let normal = Vector3::from(numbers(text_of(geometry, "normal")).unwrap_or([0.0, 0.0, 1.0]));
                let turn = UnitQuaternion::rotation_between(&Vector3::z(), &normal);
                // Against z any half turn will do.
                let turn = turn.unwrap_or_else(|| UnitQuaternion::from_euler_angles(std::f64::consts::PI, 0.0, 0.0));
                Some((at * turn, Geometry::Plain(Shape::HalfSpace)))
            }
            "heightmap" => {
                let [x, y, z] = numbers(text_of(geometry, "pos")).unwrap_or_default();
                let middle = Isometry3::translation(x, y, z);
                self.height_map(place, geometry).map(|piece| (at * middle, Geometry::Mesh(piece)))
            }
            "mesh" => self.mesh(place, geometry).map(|piece| (at, Geometry::Mesh(piece))),
            "empty" => None,
            other => {
                self.note(format!("a shape <{other}> is left out"));
                None
            }
        };
        if let Some((at, geometry)) = found {
            let can_move = !matches!(geometry, Geometry::Plain(Shape::HalfSpace) | Geometry::Mesh(_));
            let mass = mass.filter(|_| can_move);
            let colour = colour.or(if let Geometry::Mesh(piece) = &geometry { piece.colour } else { None });
            let object = FoundObject::fixed(name, on_map(at), geometry, colour);
            self.found.objects.push(FoundObject { mass, touch, ..object });
        }
    }

    /// Reads how a collision's surface touches others.
    fn touch(&mut self, collision: Node) -> Touch {
        let Some(surface) = child(collision, "surface") else { return Touch::default() };
        let is_there = |node: &Node| {
            let numbers = node.text().unwrap_or_default().split_whitespace();
            UNFOLLOWED.contains(&node.tag_name().name())
                && numbers.filter_map(|it| it.parse().ok()).any(|it: f64| it != 0.0)
        };
        if surface.descendants().any(|node| is_there(&node)) {
            self.note("slip and softness of a surface are not followed");
        }
        let friction = child(surface, "friction");
        let ode = friction.and_then(|it| child(it, "ode"));
        let [mu, mu2] = ["mu", "mu2"].map(|key| ode.and_then(|ode| number_of(ode, key)));
        let bullet = friction.and_then(|it| child(it, "bullet")).and_then(|it| number_of(it, "friction"));
        if mu.zip(mu2).is_some_and(|(mu, mu2)| mu != mu2) {
            self.note("friction that differs by direction: the first counts");
        }
        if surface
            .descendants()
            .any(|node| node.has_tag_name("collide_without_contact") && is_true(node.text().unwrap_or_default().trim()))
        {
            self.note("a collision without contact stops bodies here");
        }
        let restitution = child(surface, "bounce").and_then(|it| number_of(it, "restitution_coefficient"));
        Touch { friction: mu.or(bullet), restitution: restitution.filter(|it| *it > 0.0) }
    }

    /// Reads ground from a picture of its heights.
    fn height_map(&mut self, place: Place, geometry: Node) -> Option<Piece> {
        let (uri, size) = (text_of(geometry, "uri"), numbers(text_of(geometry, "size")).unwrap_or([1.0; 3]));
        if uri.is_empty() {
            self.note("a shape <heightmap> without a picture is left out");
            return None;
        }
        let Some((source, file)) = self.models.mesh(place.source, uri) else {
            self.missing(place, geometry, uri);
            return None;
        };
        let bytes = source.bytes(&file, MAX_MESH).map_err(|error| error.to_string());
        let rows = bytes.and_then(|bytes| height_field::of_picture(&bytes, size[2]));
        let piece = rows.map(|rows| solids::ground(&rows, [size[0], size[1]]));
        let read = piece.and_then(|piece| self.triangles.add(std::slice::from_ref(&piece)).map(|()| piece));
        read.map_err(|reason| self.note(format!("height map `{file}` is left out: {reason}"))).ok()
    }

    /// Reads a mesh, or a part of one, in the axes of its file.
    fn mesh(&mut self, place: Place, geometry: Node) -> Option<Piece> {
        let uri = text_of(geometry, "uri");
        let scale = numbers(text_of(geometry, "scale")).unwrap_or([1.0; 3]);
        if let Some(problem) = mesh::SCALE.problem_in("scale", &scale.map(f64::abs)) {
            self.problem(place, geometry, problem);
            return None;
        }
        let Some((source, file)) = self.models.mesh(place.source, uri) else {
            self.missing(place, geometry, uri);
            return None;
        };
        self.bytes = self.bytes.saturating_add(source.size(&file));
        if self.bytes > MAX_BYTES {
            self.note(format!("a mesh beyond the {} MB of all meshes is left out", MAX_BYTES >> 20));
            return None;
        }
        let pieces = mesh::named_pieces(&source, &file).and_then(|pieces| self.triangles.add(&pieces).map(|()| pieces));
        let mut piece = match pieces.and_then(|pieces| submesh(pieces, geometry)) {
            Ok(piece) => piece,
            Err(reason) if self.is_strict => {
                self.problem(place, geometry, reason);
                return None;
            }
            Err(reason) => {
                self.note(format!("{reason}: left out"));
                return None;
            }
        };
        let scaled = |vertex: [f32; 3]| std::array::from_fn(|axis| (f64::from(vertex[axis]) * scale[axis]) as f32);
        piece.vertices.iter_mut().for_each(|vertex| *vertex = scaled(*vertex));
        Some(piece)
    }
}

/// Turns a pose to z down. Half a turn on both sides: shapes are alike after it, and meshes are turned by their reader.
fn on_map(at: Isometry3<f64>) -> Pose {
    Isometry3::from_parts(Translation3::identity(), z_down()) * at * z_down()
}

/// Returns the colour of a link's first visual that has one.
fn colour_of(link: Node) -> Option<[f64; 3]> {
    let visuals = children(link, "visual").flat_map(|visual| visual.descendants());
    let texts =
        visuals.filter(|it| it.has_tag_name("diffuse") || it.has_tag_name("ambient")).filter_map(|it| it.text());
    let mut colours = texts.filter_map(|text| numbers::<4>(text).map(|[r, g, b, _]| [r, g, b]).or(numbers::<3>(text)));
    colours.next()
}

/// Reads a mask of bits, as `0x01` or `1`.
fn bits(text: &str) -> Option<u32> {
    let text = text.trim();
    match text.strip_prefix("0x") {
        Some(digits) => u32::from_str_radix(digits, 16).ok(),
        None => text.parse().ok(),
    }
}
