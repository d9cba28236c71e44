//! Links of SDF: masses, shapes and sensors.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use nalgebra::Isometry3;
use roxmltree::Node;
use urdf_rs::{Geometry, Inertia, Inertial, Mass, Vec3};

use super::{MAX_SHAPES, MODELS_HINT, Model, Place, Reader, Scope};
use crate::mesh::{self, Piece};
use crate::sdf::{child, children, is_true, number_of, numbers, solids, submesh, text_of};
use crate::source::Source;
use crate::urdf::{isometry, origin};

/// Maximum number of meshes that are made of others, and of their triangles together.
const MAX_PARTS: usize = 200;
const MAX_TRIANGLES: usize = 1_000_000;
/// Maximum size of all meshes that parts are taken of, bytes; one that is named again counts again.
const MAX_BYTES: u64 = 1 << 30;

/// A link at its pose in the robot's frame. What is on it is in its own frame.
pub(super) struct Placed {
    pub(super) link: urdf_rs::Link,
    pub(super) pose: Isometry3<f64>,
    pub(super) sensors: Vec<Sensor>,
    /// Directions of friction of its shapes, as they are written.
    pub(super) directions: String,
}

/// A sensor on a link.
pub(super) struct Sensor {
    /// Attributes of its element.
    pub(super) head: String,
    pub(super) pose: Isometry3<f64>,
    /// Its elements without the pose, as they are written.
    pub(super) inside: String,
}

impl Placed {
    /// Returns a link with nothing on it.
    pub(super) fn empty(name: &str, pose: Isometry3<f64>) -> Self {
        let (inertial, visual, collision) = (Inertial::default(), Vec::new(), Vec::new());
        let link = urdf_rs::Link { name: name.to_owned(), inertial, visual, collision };
        Self { link, pose, sensors: Vec::new(), directions: String::new() }
    }

    /// Takes a part of the mass and inertia of a link, about its centre.
    pub(super) fn take_mass(&mut self, from: &mut Self, part: f64) {
        self.link.inertial = from.link.inertial.clone();
        let at = self.pose.inverse() * from.pose * isometry(&self.link.inertial.origin);
        self.link.inertial.origin = origin(&at);
        for (inertial, part) in [(&mut self.link.inertial, part), (&mut from.link.inertial, 1.0 - part)] {
            let Inertia { ixx, ixy, ixz, iyy, iyz, izz } = &mut inertial.inertia;
            [&mut inertial.mass.value, ixx, ixy, ixz, iyy, iyz, izz].into_iter().for_each(|it| *it *= part);
        }
    }
}

/// Meshes that are made of others.
pub(super) struct Parts<'a> {
    /// Folder that they are written to.
    folder: &'a Path,
    /// True while the model is read that is asked for.
    pub(super) is_open: bool,
    count: usize,
    triangles: usize,
    bytes: u64,
}

impl<'a> Parts<'a> {
    pub(super) fn new(folder: &'a Path) -> Self {
        Self { folder, is_open: false, count: 0, triangles: 0, bytes: 0 }
    }

    /// Writes a mesh.
    fn add(&mut self, piece: &Piece) -> Result<PathBuf, String> {
        if !self.is_open {
            return Err("another model is asked for".to_owned());
        }
        (self.count, self.triangles) = (self.count + 1, self.triangles + piece.triangles.len());
        if self.count > MAX_PARTS || self.triangles > MAX_TRIANGLES {
            return Err(format!("expected at most {MAX_PARTS} parts of meshes, and {MAX_TRIANGLES} triangles of them"));
        }
        let file = self.folder.join(format!("part_{}.obj", self.count));
        std::fs::write(&file, mesh::as_obj(piece)).map_err(|error| error.to_string())?;
        Ok(file)
    }
}

/// A shape as a URDF has it, its pose on the shape of SDF, and the colour of its mesh.
struct Made {
    geometry: Geometry,
    pose: Isometry3<f64>,
    colour: Option<[f64; 3]>,
}

impl Made {
    fn plain(geometry: Geometry) -> Vec<Self> {
        vec![Self { geometry, pose: Isometry3::identity(), colour: None }]
    }
}

impl Reader<'_> {
    /// Reads a link at a pose in the robot's frame.
    pub(super) fn link(
        &mut self,
        place: Place,
        node: Node,
        scope: &Scope,
        pose: Isometry3<f64>,
        model: &mut Model,
    ) -> Placed {
        let mut placed = Placed::empty(&format!("{}{}", scope.prefix, node.attribute("name").unwrap_or("link")), pose);
        for key in ["gravity", "kinematic"] {
            if child(node, key)
                .is_some_and(|it| is_true(text_of(node, key)) != (key == "gravity") && it.text().is_some())
            {
                model.note(format!("a <{key}> of a link is left out: it falls and is moved by forces"));
            }
        }
        placed.link.inertial = self.inertial(place, node);
        // A pose may be relative to another frame than its link's.
        let within = pose.inverse() * scope.base;
        let usual = scope.base.inverse() * pose;
        for tag in ["collision", "visual"] {
            for shape in children(node, tag) {
                model.shapes += 1;
                if model.shapes > MAX_SHAPES {
                    self.problem(place, shape, format_args!("expected at most {MAX_SHAPES} shapes of a robot"));
                    return placed;
                }
                let at = within * self.posed(place, shape, scope.frames.pose_on(shape, &usual));
                let made = self.shapes(place, shape, tag, model);
                let colour = colour_of(shape);
                for Made { geometry, pose, colour: own } in made {
                    let origin = origin(&(at * pose));
                    if tag == "collision" {
                        placed.link.collision.push(urdf_rs::Collision { name: None, origin, geometry });
                    } else {
                        let material = colour.or(own).map(material);
                        placed.link.visual.push(urdf_rs::Visual { name: None, origin, geometry, material });
                    }
                }
                for direction in shape.descendants().filter(|it| it.has_tag_name("fdir1")) {
                    placed.directions += model.raw(place.text, direction);
                }
            }
        }
        for sensor in children(node, "sensor") {
            let at = within * self.posed(place, sensor, scope.frames.pose_on(sensor, &usual));
            let mut made = Sensor { head: String::new(), pose: at, inside: String::new() };
            for key in ["name", "type"] {
                let value = crate::urdf::escaped(sensor.attribute(key).unwrap_or_default());
                let _ = write!(made.head, " {key}=\"{value}\"");
            }
            let inside = sensor.children().filter(|it| it.is_element() && !it.has_tag_name("pose"));
            inside.for_each(|it| made.inside += model.raw(place.text, it));
            placed.sensors.push(made);
        }
        placed
    }

    /// Reads the mass of a link: without a word it is 1 kg with 1 kg m², as Gazebo takes it.
    fn inertial(&mut self, place: Place, link: Node) -> Inertial {
        let inertial = child(link, "inertial");
        let pose = inertial.map_or(Ok(Isometry3::identity()), crate::sdf::frames::pose);
        let pose = self.posed(place, inertial.unwrap_or(link), pose);
        let value = inertial.and_then(|it| number_of(it, "mass")).unwrap_or(1.0);
        let inertia = inertial.and_then(|it| child(it, "inertia"));
        let part = |tag: &str, usual: f64| inertia.and_then(|it| number_of(it, tag)).unwrap_or(usual);
        let [ixx, iyy, izz] = ["ixx", "iyy", "izz"].map(|tag| part(tag, 1.0));
        let [ixy, ixz, iyz] = ["ixy", "ixz", "iyz"].map(|tag| part(tag, 0.0));
        Inertial { origin: origin(&pose), mass: Mass { value }, inertia: Inertia { ixx, ixy, ixz, iyy, iyz, izz } }
    }

    /// Returns the shapes of a collision or visual.
    fn shapes(&mut self, place: Place, node: Node, tag: &str, model: &mut Model) -> Vec<Made> {
        let geometry = child(node, "geometry").and_then(|it| it.children().find(Node::is_element));
        let Some(geometry) = geometry else {
            model.note(format!("a {tag} without a shape is left out"));
            return Vec::new();
        };
        let kind = geometry.tag_name().name();
        let length = |key: &str| number_of(geometry, key).unwrap_or(1.0);
        let (radius, long) = (length("radius"), length("length"));
        let made = match kind {
            "box" => {
                let size = Vec3(numbers(text_of(geometry, "size")).unwrap_or([1.0; 3]));
                Ok(Made::plain(Geometry::Box { size }))
            }
            "cylinder" => Ok(Made::plain(Geometry::Cylinder { radius, length: long })),
            "sphere" => Ok(Made::plain(Geometry::Sphere { radius })),
            "capsule" => {
                let end = |side: f64| Made {
                    geometry: Geometry::Sphere { radius },
                    pose: Isometry3::translation(0.0, 0.0, side * long / 2.0),
                    colour: None,
                };
                let mut made = Made::plain(Geometry::Cylinder { radius, length: long });
                made.extend([end(-1.0), end(1.0)]);
                Ok(made)
            }
            "cone" => self.made(&solids::cone(radius, long), None),
            "ellipsoid" => {
                let radii = numbers(text_of(geometry, "radii")).unwrap_or([1.0; 3]);
                self.made(&solids::ellipsoid(radii), None)
            }
            "polyline" => {
                let points = children(geometry, "point").map(|point| numbers(point.text().unwrap_or_default()));
                let points = points.collect::<Option<Vec<[f64; 2]>>>().unwrap_or_default();
                let piece = solids::prism(&points, length("height"));
                piece.map_or_else(|| Err("it is no simple polygon".to_owned()), |piece| self.made(&piece, None))
            }
            "mesh" => self.mesh(place, geometry, model),
            "empty" => Ok(Vec::new()),
            _ => Err("no robot has it".to_owned()),
        };
        made.unwrap_or_else(|reason| {
            model.note(format!("a {tag} of a <{kind}> is left out: {reason}"));
            Vec::new()
        })
    }

    /// Returns a shape that is written as a mesh.
    fn made(&mut self, piece: &Piece, scale: Option<Vec3>) -> Result<Vec<Made>, String> {
        let file = self.parts.add(piece)?;
        let geometry = Geometry::Mesh { filename: format!("file://{}", file.display()), scale };
        Ok(vec![Made { geometry, pose: Isometry3::identity(), colour: piece.colour }])
    }

    fn mesh(&mut self, place: Place, geometry: Node, model: &mut Model) -> Result<Vec<Made>, String> {
        let uri = text_of(geometry, "uri");
        let (source, file) =
            self.models.mesh(place.source, uri).ok_or_else(|| format!("`{uri}` is not there: {MODELS_HINT}"))?;
        let scale = numbers(text_of(geometry, "scale")).map(Vec3);
        if child(geometry, "submesh").is_some_and(|part| !text_of(part, "name").is_empty()) {
            if !self.parts.is_open {
                return Ok(Vec::new());
            }
            self.parts.bytes = self.parts.bytes.saturating_add(source.size(&file));
            if self.parts.bytes > MAX_BYTES {
                return Err(format!("parts of more than {} MB of meshes", MAX_BYTES >> 20));
            }
            let piece = submesh(mesh::named_pieces(&source, &file)?, geometry)?;
            return self.made(&piece, scale);
        }
        let Source::Folder(folder) = source else { return Err("no file".to_owned()) };
        let filename = format!("file://{}", folder.join(&file).display());
        model.folders.insert(folder);
        Ok(Made::plain(Geometry::Mesh { filename, scale }))
    }
}

/// Moves everything on a link by a pose in front of it.
pub(super) fn moved(placed: &mut Placed, by: &Isometry3<f64>) {
    let link = &mut placed.link;
    let poses = [&mut link.inertial.origin].into_iter();
    let poses = poses.chain(link.visual.iter_mut().map(|it| &mut it.origin));
    poses.chain(link.collision.iter_mut().map(|it| &mut it.origin)).for_each(|at| *at = origin(&(by * isometry(at))));
    placed.sensors.iter_mut().for_each(|sensor| sensor.pose = by * sensor.pose);
}

/// Returns the colour of a visual.
fn colour_of(visual: Node) -> Option<[f64; 3]> {
    let material = child(visual, "material")?;
    ["diffuse", "ambient"].iter().find_map(|tag| {
        let text = text_of(material, tag);
        numbers::<4>(text).map(|[r, g, b, _]| [r, g, b]).or_else(|| numbers::<3>(text))
    })
}

fn material([r, g, b]: [f64; 3]) -> urdf_rs::Material {
    let rgba = urdf_rs::Vec4([r, g, b, 1.0]);
    urdf_rs::Material { name: String::new(), color: Some(urdf_rs::Color { rgba }), texture: None }
}
