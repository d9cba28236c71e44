//! SDF of Gazebo: the colliding shapes of a world's models. It is z up, as URDF, and turned at the end of [`Reader::collision`].

use std::collections::BTreeMap;

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use roxmltree::{Document, Node, ParsingOptions};
use scene::check::MAX_SOLIDS;
use scene::{Pose, Shape};

use super::{Budget, FoundObject, Geometry};
use crate::LoadError;
use crate::mesh;
use crate::problem::Problems;
use crate::source::Source;
use crate::urdf::{mesh_file, z_down};

/// Maximum number of elements, attributes and texts of a file.
const MAX_NODES: u32 = 500_000;
/// Maximum number of namespace declarations: the XML library copies them to every element that declares one more.
const MAX_NAMESPACES: usize = 100;
/// Maximum nesting of models, and of files that include each other.
const MAX_DEPTH: usize = 16;
/// Maximum number of included files: files that include each other twice would be read without end.
const MAX_INCLUDED: usize = 1000;
/// Elements that say nothing about shapes.
const SILENT: [&str; 24] = [
    "physics",
    "scene",
    "gui",
    "plugin",
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
];

/// Reads the objects of a file. Returns them, and notes on what is left out.
pub(super) fn read(
    source: &Source,
    file: &str,
    problems: &mut Problems,
) -> Result<(Vec<FoundObject>, Vec<String>), LoadError> {
    let (found, left_out, triangles) = (Vec::new(), BTreeMap::new(), Budget::default());
    let mut reader = Reader { problems, found, left_out, triangles, included: 0 };
    reader.file(source, file, &Isometry3::identity(), None, 0)?;
    let Reader { found, left_out, .. } = reader;
    Ok((found, left_out.into_iter().map(|(what, count)| format!("{count} of {what} left out")).collect()))
}

struct Reader<'p> {
    problems: &'p mut Problems,
    found: Vec<FoundObject>,
    /// Counts of what is left out.
    left_out: BTreeMap<String, usize>,
    triangles: Budget,
    /// Number of included files.
    included: usize,
}

/// A file that is being read.
#[derive(Clone, Copy)]
struct Place<'a> {
    source: &'a Source,
    shown: &'a str,
    text: &'a str,
    /// Number of files and models around.
    depth: usize,
}

impl Reader<'_> {
    /// Reads the worlds and models of a file at a pose. `name` replaces that of its model.
    fn file(
        &mut self,
        source: &Source,
        file: &str,
        pose: &Isometry3<f64>,
        name: Option<&str>,
        depth: usize,
    ) -> Result<(), LoadError> {
        let (text, shown) = (source.text(file)?, source.display(file));
        let unreadable = |reason: String| LoadError::Unreadable { file: shown.clone(), reason };
        let namespaces = text.matches("xmlns").count();
        if namespaces > MAX_NAMESPACES {
            return Err(unreadable(format!("{namespaces} namespaces: expected at most {MAX_NAMESPACES}")));
        }
        let options = ParsingOptions { nodes_limit: MAX_NODES, ..ParsingOptions::default() };
        let document = Document::parse_with_options(&text, options);
        let document = document.map_err(|error| unreadable(format!("not XML: {error}")))?;
        let root = document.root_element();
        if root.tag_name().name() != "sdf" {
            return Err(unreadable(format!("<{}>: expected <sdf>", root.tag_name().name())));
        }
        let place = Place { source, shown: &shown, text: &text, depth };
        for world in children(root, "world") {
            self.models(place, world, pose, "")?;
        }
        for model in children(root, "model") {
            self.model(place, model, pose, name, "")?;
        }
        Ok(())
    }

    fn problem(&mut self, place: Place, node: Node, message: impl std::fmt::Display) {
        self.problems.at(place.shown, place.text, node.range().start, message);
    }

    fn leave_out(&mut self, what: impl Into<String>) {
        *self.left_out.entry(what.into()).or_default() += 1;
    }

    /// Reads the models inside a world or a model. `prefix` begins their names.
    fn models(&mut self, place: Place, node: Node, pose: &Isometry3<f64>, prefix: &str) -> Result<(), LoadError> {
        if place.depth > MAX_DEPTH {
            self.problem(place, node, format_args!("expected at most {MAX_DEPTH} models inside each other"));
            return Ok(());
        }
        let inner = Place { depth: place.depth + 1, ..place };
        for child in node.children().filter(Node::is_element) {
            match child.tag_name().name() {
                "model" => self.model(inner, child, pose, None, prefix)?,
                "include" => self.include(inner, child, pose)?,
                tag if !SILENT.contains(&tag) => self.leave_out(format!("<{tag}>")),
                _ => {}
            }
        }
        Ok(())
    }

    fn include(&mut self, place: Place, node: Node, pose: &Isometry3<f64>) -> Result<(), LoadError> {
        let uri = text_of(node, "uri");
        let own = self.pose(place, node);
        let name = uri.rsplit("://").next().unwrap_or(uri).trim_matches('/');
        let folder = [name.to_owned(), format!("models/{name}"), format!("../{name}")].into_iter().find_map(|folder| {
            let folder = place.source.folder(&folder)?;
            folder.has("model.sdf").then_some(folder)
        });
        match folder {
            Some(_) if self.included >= MAX_INCLUDED => {
                self.problem(place, node, format_args!("more than {MAX_INCLUDED} included models"));
                Ok(())
            }
            Some(folder) if !name.is_empty() => {
                self.included += 1;
                let called = Some(text_of(node, "name")).filter(|name| !name.is_empty());
                self.file(&folder, "model.sdf", &(pose * own), called, place.depth + 1)
            }
            _ => {
                let expected = format!("expected {name}/model.sdf beside this file, or in a folder `models` there");
                self.problem(place, node, format_args!("the included model `{uri}` is not there: {expected}"));
                Ok(())
            }
        }
    }

    fn model(
        &mut self,
        place: Place,
        node: Node,
        parent: &Isometry3<f64>,
        name: Option<&str>,
        prefix: &str,
    ) -> Result<(), LoadError> {
        let pose = parent * self.pose(place, node);
        let name = format!("{prefix}{}", name.or(node.attribute("name")).unwrap_or("model"));
        let links: Vec<Node> = children(node, "link").collect();
        let collisions = links.iter().flat_map(|link| children(*link, "collision")).count();
        let is_static = ["true", "1"].contains(&text_of(node, "static"));
        let is_alone = collisions == 1 && links.len() == 1;
        let moves = !is_static && is_alone;
        if !is_static && !is_alone && collisions > 0 {
            self.leave_out("mobility of models of several shapes, which stand fast,");
        }
        for link in links {
            let at = pose * self.pose(place, link);
            let colour = link.descendants().find(|it| it.has_tag_name("diffuse") || it.has_tag_name("ambient"));
            let colour = colour
                .and_then(|it| numbers::<4>(it.text()?).or(numbers::<3>(it.text()?).map(|[r, g, b]| [r, g, b, 1.0])));
            let colour = colour.map(|[r, g, b, _]| [r, g, b]);
            let inertial = child(link, "inertial").map(|it| text_of(it, "mass"));
            let mass = inertial.and_then(|mass| mass.parse().ok()).unwrap_or(1.0);
            let own: Vec<Node> = children(link, "collision").collect();
            if own.is_empty() && children(link, "visual").next().is_some() {
                self.leave_out("links that are only seen");
            }
            for collision in own {
                let several = collisions > 1;
                let own_name = collision.attribute("name").filter(|_| several);
                let name = own_name.map_or_else(|| name.clone(), |own| format!("{name}-{own}"));
                self.collision(place, collision, &at, name, colour, moves.then_some(mass));
            }
        }
        self.models(place, node, &pose, &format!("{name}-"))
    }

    /// Adds the shape of a collision. `pose` is that of its link, z up.
    fn collision(
        &mut self,
        place: Place,
        node: Node,
        pose: &Isometry3<f64>,
        name: String,
        colour: Option<[f64; 3]>,
        mass: Option<f64>,
    ) {
        let at = pose * self.pose(place, node);
        let geometry = child(node, "geometry").and_then(|it| it.children().find(Node::is_element));
        let Some(geometry) = geometry else {
            return self.problem(place, node, "a collision without <geometry>");
        };
        if self.found.len() >= MAX_SOLIDS {
            return self.problem(place, geometry, format_args!("more than {MAX_SOLIDS} shapes"));
        }
        // Half a turn on both sides: shapes are alike after it, and meshes are turned by their reader.
        let placed =
            |at: Isometry3<f64>| -> Pose { Isometry3::from_parts(Default::default(), z_down()) * at * z_down() };
        let add = |reader: &mut Self, pose: Pose, geometry: Geometry, mass: Option<f64>| {
            reader.found.push(FoundObject { name: name.clone(), pose, geometry, colour, mass });
        };
        let length = |reader: &mut Self, key: &str| {
            let value = number_of(geometry, key);
            if value.is_none() {
                reader.problem(place, geometry, format_args!("missing <{key}>: expected a length in metres"));
            }
            value
        };
        match geometry.tag_name().name() {
            "box" => match numbers(text_of(geometry, "size")) {
                Some(size) => add(self, placed(at), Geometry::Plain(Shape::Box { size }), mass),
                None => self.problem(place, geometry, "missing <size>: expected three lengths in metres"),
            },
            "cylinder" => {
                if let (Some(radius), Some(length)) = (length(self, "radius"), length(self, "length")) {
                    add(self, placed(at), Geometry::Plain(Shape::Cylinder { radius, length }), mass);
                }
            }
            "sphere" => {
                if let Some(radius) = length(self, "radius") {
                    add(self, placed(at), Geometry::Plain(Shape::Ball { radius }), mass);
                }
            }
            "plane" => {
                let normal = Vector3::from(numbers(text_of(geometry, "normal")).unwrap_or([0.0, 0.0, 1.0]));
                let turn = UnitQuaternion::rotation_between(&Vector3::z(), &normal);
                let pose = placed(at * turn.unwrap_or_else(UnitQuaternion::identity));
                add(self, pose, Geometry::Plain(Shape::HalfSpace), None);
            }
            "mesh" => {
                let uri = text_of(geometry, "uri");
                let scale = numbers(text_of(geometry, "scale")).unwrap_or([1.0; 3]);
                let file = mesh_file(place.source, uri);
                let pieces = mesh::SCALE.problem_in("scale", &scale).map_or_else(
                    || {
                        mesh::pieces(place.source, &file)
                            .and_then(|pieces| self.triangles.add(&pieces).map(|()| pieces))
                    },
                    Err,
                );
                match pieces {
                    Ok(pieces) => {
                        let mut piece = mesh::joined(pieces);
                        let scaled = |[x, y, z]: [f32; 3]| {
                            let [x, y, z] = [x, y, z].map(f64::from);
                            [x * scale[0], y * scale[1], z * scale[2]].map(|part| part as f32)
                        };
                        piece.vertices.iter_mut().for_each(|vertex| *vertex = scaled(*vertex));
                        add(self, placed(at), Geometry::Mesh(piece), None);
                    }
                    Err(reason) => self.problem(place, geometry, reason),
                }
            }
            other => self.leave_out(format!("<geometry> <{other}>")),
        }
    }

    /// Reads the pose of an element in its parent, z up.
    fn pose(&mut self, place: Place, node: Node) -> Isometry3<f64> {
        let Some(pose) = child(node, "pose") else { return Isometry3::identity() };
        let relative = pose.attribute("relative_to").or(pose.attribute("frame")).filter(|frame| !frame.is_empty());
        if let Some(frame) = relative.filter(|frame| !["world", "__model__"].contains(frame)) {
            self.problem(
                place,
                pose,
                format_args!("a pose in the frame `{frame}`: expected one in that of its parent"),
            );
        }
        let text = pose.text().unwrap_or_default().trim();
        if text.is_empty() {
            return Isometry3::identity();
        }
        let turned = pose.attribute("rotation_format").is_some_and(|format| format != "euler_rpy");
        let Some([x, y, z, roll, pitch, yaw]) = numbers(text).filter(|_| !turned) else {
            self.problem(place, pose, "a pose that is not `x y z roll pitch yaw`");
            return Isometry3::identity();
        };
        let unit = if pose.attribute("degrees") == Some("true") { std::f64::consts::PI / 180.0 } else { 1.0 };
        let turn = UnitQuaternion::from_euler_angles(roll * unit, pitch * unit, yaw * unit);
        Isometry3::from_parts(Vector3::new(x, y, z).into(), turn)
    }
}

fn children<'a, 'i>(node: Node<'a, 'i>, tag: &'static str) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children().filter(move |it| it.has_tag_name(tag))
}

fn child<'a, 'i>(node: Node<'a, 'i>, tag: &'static str) -> Option<Node<'a, 'i>> {
    children(node, tag).next()
}

/// Returns the text of a child; empty without one.
fn text_of<'a>(node: Node<'a, '_>, tag: &str) -> &'a str {
    node.children().find(|it| it.has_tag_name(tag)).and_then(|it| it.text()).unwrap_or_default().trim()
}

fn number_of(node: Node, tag: &str) -> Option<f64> {
    numbers::<1>(text_of(node, tag)).map(|[number]| number)
}

/// Reads exactly as many finite numbers as are wanted.
fn numbers<const COUNT: usize>(text: &str) -> Option<[f64; COUNT]> {
    let numbers: Option<Vec<f64>> =
        text.split_whitespace().map(|word| word.parse().ok().filter(|it: &f64| it.is_finite())).collect();
    numbers?.try_into().ok()
}
