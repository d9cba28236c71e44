//! Convex hulls. This is the only use of parry in this crate.

use parry3d::math::Vector;

use crate::Shape;

/// Returns the surface of a convex hull as a mesh, or `None` for points in one plane.
pub fn hull_surface(corners: &[[f64; 3]]) -> Option<Shape> {
    let points: Vec<Vector> = corners.iter().map(|&point| Vector::from_array(point)).collect();
    let (vertices, triangles) = parry3d::transformation::try_convex_hull(&points).ok()?;
    let vertices = vertices.iter().map(|vertex| vertex.to_array()).collect();
    Some(Shape::Mesh { vertices, triangles })
}
