//! Points that a camera has to show.

use nalgebra::{Point3, Vector3};
use scene::{MapDef, ObjectSnapshot, Pose, Shape};

/// Size of the view of an empty map, m.
const BARE_MAP: [f64; 3] = [4.0, 4.0, 0.1];

/// Returns the corners of all solids and objects of a map, or those of a patch of floor if it has none.
pub fn corners_of_map(map: &MapDef) -> Vec<Point3<f64>> {
    let solids = map.solids.iter().chain(map.objects.iter().map(|object| &object.solid));
    let mut places: Vec<Point3<f64>> = solids.flat_map(|solid| corners(&solid.shape, &solid.pose())).collect();
    if places.is_empty() {
        places.extend(corners(&Shape::Box { size: BARE_MAP }, &Pose::identity()));
    }
    places
}

/// Returns points that span an object.
pub fn corners_of_object(object: &ObjectSnapshot) -> Vec<Point3<f64>> {
    corners(&object.def.solid.shape, &object.pose)
}

/// Returns points that span a shape.
fn corners(shape: &Shape, pose: &Pose) -> Vec<Point3<f64>> {
    let reach = match shape {
        Shape::HalfSpace => return Vec::new(),
        Shape::Hull { points } | Shape::Mesh { vertices: points, .. } => {
            return points.iter().map(|&point| pose * Point3::from(point)).collect();
        }
        Shape::HeightField(field) => return field.corners().map(|point| pose * Point3::from(point)).collect(),
        Shape::Box { size } => Vector3::from(*size) / 2.0,
        Shape::Ball { radius } => Vector3::repeat(*radius),
        Shape::Cylinder { radius, length } => Vector3::new(*radius, *radius, length / 2.0),
    };
    let sign = |bit: usize, axis: usize| if bit >> axis & 1 == 0 { 1.0 } else { -1.0 };
    (0..8)
        .map(|bit| pose * Point3::new(sign(bit, 0) * reach.x, sign(bit, 1) * reach.y, sign(bit, 2) * reach.z))
        .collect()
}
