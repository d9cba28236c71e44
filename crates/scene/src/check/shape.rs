//! Checks of shapes.

use nalgebra::Vector3;

use super::limits::*;
use super::{Number, Range};
use crate::{HeightField, Shape, Solid, hull_surface};

pub(super) fn solid(def: &Solid, reach: Range, size: Range) -> Vec<String> {
    let mut wrong: Vec<String> = reach.problem_in("position", &def.position).into_iter().collect();
    wrong.extend(ANGLE.problem_in("rotation", &def.rotation));
    wrong.extend(shape(&def.shape, reach, size));
    wrong
}

pub(super) fn shape(shape: &Shape, reach: Range, size: Range) -> Vec<String> {
    match shape {
        Shape::HalfSpace => Vec::new(),
        Shape::Box { size: edges } => size.problem_in("size", edges).into_iter().collect(),
        Shape::Cylinder { radius, length } => {
            size.problem("radius", *radius).into_iter().chain(size.problem("length", *length)).collect()
        }
        Shape::Ball { radius } => size.problem("radius", *radius).into_iter().collect(),
        Shape::Hull { points } => {
            let far = corners(points, reach);
            let flat = far.is_none() && volume(points) < LEAST_VOLUME;
            let flat = flat.then(|| format!("a hull of {} points in one plane: expected a volume", points.len()));
            far.into_iter().chain(flat).collect()
        }
        Shape::Mesh { vertices, triangles } => mesh(vertices, triangles, reach),
        Shape::HeightField(field) => height_field(field, size),
    }
}

/// Describes the first corner out of reach.
fn corners(points: &[[f64; 3]], reach: Range) -> Option<String> {
    points.iter().find_map(|point| reach.problem_in("corner", point))
}

/// Returns the volume of the convex hull of points, m³.
fn volume(points: &[[f64; 3]]) -> f64 {
    let Some(Shape::Mesh { vertices, triangles }) = hull_surface(points) else { return 0.0 };
    let corner = |index: u32| Vector3::from(vertices[index as usize]) - Vector3::from(vertices[0]);
    let sixfold = |&[a, b, c]: &[u32; 3]| corner(a).cross(&corner(b)).dot(&corner(c));
    triangles.iter().map(sixfold).sum::<f64>().abs() / 6.0
}

fn mesh(vertices: &[[f64; 3]], triangles: &[[u32; 3]], reach: Range) -> Vec<String> {
    if let Some(far) = corners(vertices, reach) {
        return vec![far];
    }
    if let Some(index) = triangles.iter().flatten().find(|&&index| index as usize >= vertices.len()) {
        return vec![format!("a triangle has the corner {index}: expected less than {}", vertices.len())];
    }
    let corner = |index: u32| Vector3::from(vertices[index as usize]);
    let surface = |&[a, b, c]: &[u32; 3]| (corner(b) - corner(a)).cross(&(corner(c) - corner(a))).norm() / 2.0;
    let surface: f64 = triangles.iter().map(surface).sum();
    if surface < LEAST_SURFACE {
        let count = triangles.len();
        return vec![format!("a mesh of {count} triangles and {} m²: expected a surface", Number(surface))];
    }
    Vec::new()
}

fn height_field(field: &HeightField, size: Range) -> Vec<String> {
    let HeightField { size: lengths, columns, heights } = field;
    let mut wrong: Vec<String> = size.problem_in("size", lengths).into_iter().collect();
    let (rows, points) = (field.rows(), heights.len());
    if *columns < 2 || rows < 2 || rows.checked_mul(*columns) != Some(points) {
        wrong.push(format!("{points} heights in rows of {columns}: expected at least two full rows of at least two"));
    }
    wrong.extend(heights.iter().find_map(|&height| FIELD_HEIGHT.problem("height", height)));
    wrong
}

pub(super) fn triangles(shape: &Shape) -> usize {
    match shape {
        Shape::Mesh { vertices, triangles } => triangles.len().max(vertices.len()),
        Shape::HeightField(field) => field.triangle_count().max(field.heights.len()),
        _ => 0,
    }
}

pub(super) fn hull_points(shape: &Shape) -> usize {
    if let Shape::Hull { points } = shape { points.len() } else { 0 }
}
