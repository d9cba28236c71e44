//! Convex hulls, by parry's algorithm: nothing else of it is used here.

use parry3d::math::Vector;

use crate::Shape;

/// The surface of a convex hull as a mesh. `None` for points in one plane.
pub fn hull_surface(corners: &[[f64; 3]]) -> Option<Shape> {
    let points: Vec<Vector> = corners.iter().map(|&point| Vector::from_array(point)).collect();
    let (vertices, triangles) = parry3d::transformation::try_convex_hull(&points).ok()?;
    let vertices = vertices.iter().map(|vertex| vertex.to_array()).collect();
    Some(Shape::Mesh { vertices, triangles })
}
