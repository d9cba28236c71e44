//! COLLADA 1.4 and 1.5, as far as a mesh needs it: triangles and polygons in the visual scene, with diffuse colours.
//!
//! The available libraries panic on unexpected files, so this module has its own reader. It ignores the up axis: ROS viewers take
//! coordinates as they are, and URDFs are written for those.

use std::collections::HashMap;

use nalgebra::{Matrix4, Point3, Translation3, Unit, UnitQuaternion, Vector3};
use roxmltree::Node;
use scene::check::MAX_TRIANGLES;

use super::Piece;
use crate::xml;

/// Maximum nesting of nodes, including instances.
const MAX_DEPTH: usize = 64;
/// Maximum number of placed nodes; a node counts at every place.
const MAX_PLACED: usize = 100_000;
/// Maximum number of elements, attributes and texts.
const MAX_NODES: u32 = 2_000_000;

pub(super) fn read(bytes: &[u8]) -> Result<Vec<Piece>, String> {
    let text = xml::decode(bytes);
    let document = xml::parse(&text, MAX_NODES).map_err(|error| error.to_string())?;
    let root = document.root_element();
    if root.tag_name().name() != "COLLADA" {
        return Err(format!("<{}>: expected <COLLADA>", root.tag_name().name()));
    }
    let mut ids = HashMap::new();
    for node in root.descendants() {
        if let Some(id) = node.attribute("id") {
            // An exporter gives a scene and its node one id, so ids are those of their kind.
            ids.entry((node.tag_name().name(), id)).or_insert(node);
        }
    }
    let unit = child(root, "asset").and_then(|asset| child(asset, "unit")?.attribute("meter")?.trim().parse().ok());
    let mut file = File { ids, pieces: Vec::new(), placed: 0, triangles: 0 };
    let unit = Matrix4::new_scaling(unit.filter(|unit: &f64| *unit > 0.0 && unit.is_finite()).unwrap_or(1.0));
    let instance = child(root, "scene").and_then(|scene| child(scene, "instance_visual_scene"));
    let scene = instance.and_then(|instance| file.target(instance, "url", "visual_scene"));
    match scene.or_else(|| root.descendants().find(|node| is(node, "visual_scene"))) {
        Some(scene) => children(scene, "node").try_for_each(|node| file.add_node(node, unit, None, 0))?,
        None => {
            let mut geometries = root.descendants().filter(|node| is(node, "geometry"));
            geometries.try_for_each(|geometry| file.add_geometry(geometry, &unit, None, &HashMap::new()))?;
        }
    }
    Ok(file.pieces)
}

struct File<'a> {
    /// Elements by their kinds and ids.
    ids: HashMap<(&'a str, &'a str), Node<'a, 'a>>,
    pieces: Vec<Piece>,
    placed: usize,
    triangles: usize,
}

impl<'a> File<'a> {
    /// Returns the element of a kind that an attribute refers to, as `#id`.
    fn target(&self, node: Node<'a, '_>, attribute: &str, kind: &'a str) -> Option<Node<'a, 'a>> {
        let id = node.attribute(attribute)?;
        self.ids.get(&(kind, id.strip_prefix('#').unwrap_or(id))).copied()
    }

    fn add_node(
        &mut self,
        node: Node<'a, 'a>,
        parent: Matrix4<f64>,
        carrier: Option<&'a str>,
        depth: usize,
    ) -> Result<(), String> {
        self.placed += 1;
        if depth > MAX_DEPTH || self.placed > MAX_PLACED {
            return Err(format!("expected at most {MAX_PLACED} nodes, {MAX_DEPTH} inside each other"));
        }
        let pose = node.children().filter_map(transform).fold(parent, |pose, own| pose * own);
        let name = node.attribute("name").or(node.attribute("id")).filter(|name| !name.is_empty()).or(carrier);
        for part in node.children() {
            match part.tag_name().name() {
                "node" => self.add_node(part, pose, name, depth + 1)?,
                "instance_node" => {
                    if let Some(target) = self.target(part, "url", "node") {
                        self.add_node(target, pose, name, depth + 1)?;
                    }
                }
                "instance_geometry" | "instance_controller" => {
                    let materials = part.descendants().filter(|node| is(node, "instance_material"));
                    let colour = |it: Node<'a, 'a>| Some((it.attribute("symbol")?, self.colour(it)?));
                    let colours = materials.filter_map(colour).collect();
                    // A controller bends a geometry. At rest it is the geometry.
                    let controller = self.target(part, "url", "controller").and_then(|it| child(it, "skin"));
                    let geometry = match controller {
                        Some(skin) => self.target(skin, "source", "geometry"),
                        None => self.target(part, "url", "geometry"),
                    };
                    if let Some(geometry) = geometry {
                        self.add_geometry(geometry, &pose, name, &colours)?;
                    }
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Returns the diffuse colour of a material.
    fn colour(&self, instance: Node<'a, 'a>) -> Option<[f64; 3]> {
        let material = self.target(instance, "target", "material")?;
        let effect = self.target(child(material, "instance_effect")?, "url", "effect")?;
        let diffuse = effect.descendants().find(|node| is(node, "diffuse"))?;
        let numbers: Vec<f64> = numbers(child(diffuse, "color")?)?;
        numbers.get(..3)?.try_into().ok()
    }

    fn add_geometry(
        &mut self,
        geometry: Node<'a, 'a>,
        pose: &Matrix4<f64>,
        name: Option<&str>,
        colours: &HashMap<&str, [f64; 3]>,
    ) -> Result<(), String> {
        let id = geometry.attribute("id").unwrap_or_default();
        let Some(mesh) = child(geometry, "mesh") else { return Ok(()) };
        for primitive in mesh.children().filter(|it| PRIMITIVES.contains(&it.tag_name().name())) {
            let broken = |what: &str| format!("geometry `{id}`, <{}>: {what}", primitive.tag_name().name());
            let (positions, stride) =
                self.positions(mesh, primitive).ok_or_else(|| broken("expected positions as numbers"))?;
            let (offset, per_corner) =
                inputs(primitive).ok_or_else(|| broken("expected an input VERTEX with its offset"))?;
            let corner = |index: u32| {
                let at = positions.get(index as usize * stride..)?.get(..3)?;
                Some((pose.transform_point(&Point3::new(at[0], at[1], at[2]))).coords.map(|it| it as f32).into())
            };
            let polygons = polygons(primitive, per_corner).ok_or_else(|| broken("expected indices of corners"))?;
            let mut piece = Piece {
                colour: primitive.attribute("material").and_then(|it| colours.get(it)).copied(),
                name: name.map(str::to_owned),
                ..Piece::default()
            };
            let is_strip = is(&primitive, "tristrips");
            for polygon in polygons {
                let indices: Vec<u32> =
                    polygon.chunks_exact(per_corner).filter_map(|it| it.get(offset).copied()).collect();
                for number in 1..indices.len().saturating_sub(1) {
                    let first = piece.vertices.len() as u32;
                    // Every other triangle of a strip is wound the other way.
                    let corners = match is_strip {
                        true if number % 2 == 0 => [number, number - 1, number + 1],
                        true => [number - 1, number, number + 1],
                        false => [0, number, number + 1],
                    };
                    for index in corners.map(|corner| indices[corner]) {
                        piece.vertices.push(corner(index).ok_or_else(|| broken(&format!("no corner {index}")))?);
                    }
                    piece.triangles.push([first, first + 1, first + 2]);
                    self.triangles += 1;
                    if self.triangles > MAX_TRIANGLES {
                        return Err(format!("expected at most {MAX_TRIANGLES} triangles"));
                    }
                }
            }
            self.pieces.push(piece);
        }
        Ok(())
    }

    /// Returns the coordinates of corners, and the number of values per corner. Ids are looked for in the mesh first.
    fn positions(&self, mesh: Node<'a, 'a>, primitive: Node<'a, 'a>) -> Option<(Vec<f64>, usize)> {
        let own = |node: Node<'a, 'a>, kind: &'static str| {
            let id = node.attribute("source")?;
            let id = id.strip_prefix('#').unwrap_or(id);
            children(mesh, kind).find(|it| it.attribute("id") == Some(id)).or_else(|| self.target(node, "source", kind))
        };
        let vertices = own(input(primitive, "VERTEX")?, "vertices")?;
        let source = own(input(vertices, "POSITION")?, "source")?;
        let accessor = source.descendants().find(|node| is(node, "accessor"))?;
        let stride =
            accessor.attribute("stride").map_or(Some(1), |it| it.parse().ok()).filter(|&stride| stride >= 3)?;
        let array = child(source, "float_array").or_else(|| self.target(accessor, "source", "float_array"))?;
        Some((numbers(array)?, stride))
    }
}

/// Elements of a mesh that have faces.
const PRIMITIVES: [&str; 5] = ["triangles", "polylist", "polygons", "tristrips", "trifans"];

/// Returns the index lists of a primitive, one per polygon, strip or fan. Holes are not cut out.
fn polygons(primitive: Node, per_corner: usize) -> Option<Vec<Vec<u32>>> {
    let holed = children(primitive, "ph").filter_map(|it| child(it, "p"));
    let lists = children(primitive, "p").chain(holed).map(numbers::<u32>).collect::<Option<Vec<_>>>()?;
    let cut = |list: &Vec<u32>, counts: &mut dyn Iterator<Item = usize>| {
        let mut rest = list.as_slice();
        let mut polygons = Vec::new();
        for count in counts {
            let (polygon, others) = rest.split_at_checked(count.checked_mul(per_corner)?)?;
            polygons.push(polygon.to_owned());
            rest = others;
        }
        Some(polygons)
    };
    match primitive.tag_name().name() {
        "polygons" | "tristrips" | "trifans" => Some(lists),
        // An exporter writes empty ones for materials that it does not use.
        _ if lists.iter().all(Vec::is_empty) => Some(Vec::new()),
        "polylist" => {
            let counts: Vec<usize> = numbers(child(primitive, "vcount")?)?;
            cut(lists.first()?, &mut counts.into_iter())
        }
        _ => {
            let list = lists.first()?;
            cut(list, &mut std::iter::repeat_n(3, list.len() / (3 * per_corner)))
        }
    }
}

/// Returns the position of the vertex index among a corner's indices, and the number of indices per corner.
fn inputs(primitive: Node) -> Option<(usize, usize)> {
    let offset = |input: Node| input.attribute("offset")?.parse::<usize>().ok();
    let most = children(primitive, "input").filter_map(offset).max()?;
    // A file with more than sixteen kinds of data per corner is not a mesh.
    Some((offset(input(primitive, "VERTEX")?)?, most + 1)).filter(|&(_, count)| count <= 16)
}

fn input<'a>(node: Node<'a, 'a>, semantic: &str) -> Option<Node<'a, 'a>> {
    children(node, "input").find(|it| it.attribute("semantic") == Some(semantic))
}

fn transform(node: Node) -> Option<Matrix4<f64>> {
    let numbers = || numbers::<f64>(node);
    match node.tag_name().name() {
        "matrix" => numbers().filter(|it| it.len() == 16).map(|it| Matrix4::from_row_slice(&it)),
        "translate" => match numbers()?[..] {
            [x, y, z] => Some(Translation3::new(x, y, z).to_homogeneous()),
            _ => None,
        },
        "rotate" => match numbers()?[..] {
            [x, y, z, degrees] => {
                let axis = Unit::try_new(Vector3::new(x, y, z), 1e-9)?;
                Some(UnitQuaternion::from_axis_angle(&axis, degrees.to_radians()).to_homogeneous())
            }
            _ => None,
        },
        "scale" => match numbers()?[..] {
            [x, y, z] => Some(Matrix4::new_nonuniform_scaling(&Vector3::new(x, y, z))),
            _ => None,
        },
        _ => None,
    }
}

fn numbers<T: std::str::FromStr>(node: Node) -> Option<Vec<T>> {
    node.text().unwrap_or_default().split_whitespace().map(|word| word.parse().ok()).collect()
}

fn is(node: &Node, tag: &str) -> bool {
    node.tag_name().name() == tag
}

fn child<'a>(node: Node<'a, 'a>, tag: &'static str) -> Option<Node<'a, 'a>> {
    children(node, tag).next()
}

fn children<'a>(node: Node<'a, 'a>, tag: &'static str) -> impl Iterator<Item = Node<'a, 'a>> {
    node.children().filter(move |node| is(node, tag))
}
