//! Extents of links, from their shapes.

use nalgebra::{Point3, Translation3, Vector3};
use scene::{Link, Pose, Shape};

/// Directions in which the roundness of a wheel is measured.
const DIRECTIONS: u32 = 16;

/// A link's shapes about the sideways axis through its joint.
pub(super) struct Extent {
    /// Radius about the axis, m.
    pub(super) radius: f64,
    /// Reach to the left of the joint, negative, m.
    pub(super) left: f64,
    /// Reach to the right of the joint, m.
    pub(super) right: f64,
    /// Least reach across the axis over the greatest one, of all directions: 1 for a wheel.
    pub(super) roundness: f64,
}

impl Extent {
    /// Measures a link's solids, or its visuals if it has none. Returns `None` if they have no extent.
    pub(super) fn of(link: &Link) -> Option<Self> {
        let to_joint = Translation3::from(-Vector3::from(link.origin()));
        let points: Vec<Point3<f64>> = points(link).iter().map(|point| to_joint * point).collect();
        let reach = |(sin, cos): (f64, f64)| points.iter().map(|it| it.x * cos + it.z * sin).fold(f64::MIN, f64::max);
        let reaches = || directions(DIRECTIONS).map(reach);
        let (least, most) = (reaches().fold(f64::MAX, f64::min), reaches().fold(f64::MIN, f64::max));
        let radius = points.iter().map(|it| it.x.hypot(it.z)).fold(0.0, f64::max);
        let (left, right) = ends(points.iter().map(|it| it.y));
        (radius > 0.0 && right > left).then_some(Self { radius, left, right, roundness: least / most })
    }
}

/// Returns the lowest point of a link's solids, or of its visuals if it has none; `None` without either.
pub(super) fn lowest(link: &Link) -> Option<Point3<f64>> {
    points(link).into_iter().max_by(|a, b| a.z.total_cmp(&b.z))
}

/// Returns the bounds of a shape, its corner of least and that of greatest coordinates.
pub(crate) fn bounds(shape: &Shape, pose: &Pose) -> [Point3<f64>; 2] {
    let points: Vec<Point3<f64>> = outline(shape).into_iter().map(|point| pose * point).collect();
    let ends = [0, 1, 2].map(|axis| ends(points.iter().map(|point| point[axis])));
    [ends.map(|(least, _)| least).into(), ends.map(|(_, most)| most).into()]
}

fn ends(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::MAX, f64::MIN), |(least, most), value| (least.min(value), most.max(value)))
}

/// Returns points on the outline of a link's solids, or of its visuals if it has none, in the robot frame.
fn points(link: &Link) -> Vec<Point3<f64>> {
    let solids: Vec<(Pose, &Shape)> = link.solids.iter().map(|it| (it.pose(), &it.shape)).collect();
    let visuals = || link.visuals.iter().map(|it| (scene::pose(it.position, it.rotation), &it.shape)).collect();
    let shapes = if solids.is_empty() { visuals() } else { solids };
    shapes.iter().flat_map(|(pose, shape)| outline(shape).into_iter().map(move |point| pose * point)).collect()
}

fn directions(count: u32) -> impl Iterator<Item = (f64, f64)> {
    (0..count).map(move |part| (std::f64::consts::TAU * f64::from(part) / f64::from(count)).sin_cos())
}

/// Returns points of a shape's outline.
fn outline(shape: &Shape) -> Vec<Point3<f64>> {
    const AROUND: u32 = 64;
    let around =
        |radius: f64, z: f64| directions(AROUND).map(move |(sin, cos)| Point3::new(radius * cos, radius * sin, z));
    match shape {
        Shape::HalfSpace => Vec::new(),
        Shape::Box { size: [x, y, z] } => {
            let signs = [-0.5, 0.5];
            let corner = |sx: f64| signs.map(|sy| signs.map(|sz| Point3::new(sx * x, sy * y, sz * z)));
            signs.map(corner).into_iter().flatten().flatten().collect()
        }
        Shape::Cylinder { radius, length } => {
            around(*radius, -length / 2.0).chain(around(*radius, length / 2.0)).collect()
        }
        Shape::Ball { radius } => {
            let rings = directions(AROUND).flat_map(|(sin, cos)| around(radius * cos, radius * sin));
            rings.collect()
        }
        Shape::HeightField(field) => field.corners().map(Point3::from).collect(),
        Shape::Hull { points: vertices } | Shape::Mesh { vertices, .. } => {
            vertices.iter().map(|&vertex| Point3::from(vertex)).collect()
        }
    }
}
