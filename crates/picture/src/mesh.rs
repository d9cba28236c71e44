//! Conversion of shapes to triangles, and of infinite floors to planes.

use std::f64::consts::TAU;

use nalgebra::{Point3, Vector3};
use scene::{Material, Pose, Shape};

use crate::pattern::Pattern;

/// A triangle of a surface.
#[derive(Clone)]
pub(crate) struct Triangle {
    pub(crate) corners: [Point3<f64>; 3],
    pub(crate) colour: [f64; 3],
    pub(crate) laid: Option<Laid>,
}

/// A pattern as it lies on a triangle: places on it of the corners, along the grain and across, m.
#[derive(Clone, Copy)]
pub(crate) struct Laid {
    pattern: &'static Pattern,
    places: [[f64; 2]; 3],
}

/// Colour of a surface, and the pattern of its material.
#[derive(Clone, Copy)]
pub(crate) struct Paint {
    pub(crate) colour: [f64; 3],
    pub(crate) pattern: Option<&'static Pattern>,
}

impl From<&Material> for Paint {
    fn from(material: &Material) -> Self {
        Self { colour: material.colour, pattern: Pattern::of(&material.name) }
    }
}

impl From<[f64; 3]> for Paint {
    fn from(colour: [f64; 3]) -> Self {
        Self { colour, pattern: None }
    }
}

/// An infinite plane.
pub(crate) struct Floor {
    place: Point3<f64>,
    /// Normal, out of the ground.
    pub(crate) normal: Vector3<f64>,
    paint: Paint,
}

/// Number of corners around a cylinder, a ball or a roller.
const SEGMENTS: u32 = 24;

impl Triangle {
    /// Creates a triangle of a piece whose box has edges of these lengths, m, in the piece's own frame; a pose brings it into the world. The
    /// pattern lies along the two axes that it faces least, with the grain along the longer one.
    fn new(corners: [Point3<f64>; 3], size: &Vector3<f64>, pose: &Pose, paint: Paint) -> Self {
        let laid = paint.pattern.map(|pattern| {
            let [a, b, c] = corners;
            let facing = (b - a).cross(&(c - a)).abs().imax();
            let [one, other] = [(facing + 1) % 3, (facing + 2) % 3];
            let [along, across] = if size[one] >= size[other] { [one, other] } else { [other, one] };
            Laid { pattern, places: corners.map(|corner| [corner[along], corner[across]]) }
        });
        Self { corners: corners.map(|corner| pose * corner), colour: paint.colour, laid }
    }

    /// Returns the colour at a place of the triangle. A sample covers `breadth`, m; without an end there is no pattern.
    pub(crate) fn colour_at(&self, place: &Point3<f64>, breadth: f64) -> Vector3<f64> {
        let laid = self.laid.filter(|_| breadth.is_finite());
        let Some(Laid { pattern, places: [first, second, third] }) = laid else { return self.colour.into() };
        let [a, b, c] = self.corners;
        let (ab, ac, at) = (b - a, c - a, place - a);
        // Parts of both edges that lead there, by least squares.
        let (bb, bc, cc) = (ab.dot(&ab), ab.dot(&ac), ac.dot(&ac));
        let determinant = bb * cc - bc * bc;
        let (to_b, to_c) = (at.dot(&ab), at.dot(&ac));
        let (part_b, part_c) = ((cc * to_b - bc * to_c) / determinant, (bb * to_c - bc * to_b) / determinant);
        let on = [0, 1]
            .map(|axis| first[axis] + part_b * (second[axis] - first[axis]) + part_c * (third[axis] - first[axis]));
        // A triangle without an area has no place.
        let factor = if on[0].is_finite() && on[1].is_finite() { pattern.factor(on, breadth) } else { 1.0 };
        Vector3::from(self.colour) * factor
    }

    pub(crate) fn normal(&self) -> Vector3<f64> {
        let [a, b, c] = self.corners;
        (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_else(|| -Vector3::z())
    }
}

impl Floor {
    /// Returns the colour at a place of the floor. A sample covers `breadth`, m; without an end there is no pattern.
    pub(crate) fn colour_at(&self, place: &Point3<f64>, breadth: f64) -> Vector3<f64> {
        let Paint { colour, pattern } = self.paint;
        let pattern = pattern.filter(|_| breadth.is_finite());
        Vector3::from(colour) * pattern.map_or(1.0, |pattern| pattern.factor([place.x, place.y], breadth))
    }

    /// Returns the distance along a ray to the floor.
    pub(crate) fn distance(&self, from: &Point3<f64>, ray: &Vector3<f64>) -> Option<f64> {
        let distance = (self.place - from).dot(&self.normal) / ray.dot(&self.normal);
        (distance > 0.0 && distance.is_finite()).then_some(distance)
    }
}

/// Triangles and infinite floors.
#[derive(Default)]
pub(crate) struct Mesh {
    pub(crate) triangles: Vec<Triangle>,
    pub(crate) floors: Vec<Floor>,
}

impl Mesh {
    /// Adds a shape at a pose.
    pub(crate) fn add(&mut self, shape: &Shape, pose: &Pose, paint: Paint) {
        match shape {
            Shape::HalfSpace => {
                let normal = pose.rotation * -Vector3::z();
                self.floors.push(Floor { place: pose.translation.vector.into(), normal, paint });
            }
            Shape::Box { size } => {
                let corner = |signs: u32| {
                    Point3::from(Vector3::from_fn(|axis, _| {
                        if signs >> axis & 1 == 1 { size[axis] / 2.0 } else { -size[axis] / 2.0 }
                    }))
                };
                for face in [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]] {
                    let corners = face.map(corner);
                    self.add_quad(corners, &Vector3::from(*size), pose, paint);
                }
            }
            Shape::Ball { radius } => {
                let point = |part: u32| {
                    let angle = TAU / 2.0 * f64::from(part) / f64::from(SEGMENTS / 2);
                    [-radius * libm::cos(angle), radius * libm::sin(angle)]
                };
                let outline: Vec<[f64; 2]> = (0..=SEGMENTS / 2).map(point).collect();
                self.add_lathe(&outline, pose, paint);
            }
            Shape::Cylinder { radius, length } => {
                let upright = pose * scene::pose([0.0; 3], [0.0, -TAU / 4.0, 0.0]);
                self.add_lathe(&[[-length / 2.0, *radius], [length / 2.0, *radius]], &upright, paint);
            }
            Shape::Hull { points } => {
                if let Some(surface) = scene::hull_surface(points) {
                    self.add(&surface, pose, paint);
                }
            }
            Shape::HeightField(field) => self.add(&field.surface(), pose, paint),
            Shape::Mesh { vertices, triangles } => {
                let size = size(vertices);
                for triangle in triangles {
                    let corners = triangle.map(|corner| Point3::from(vertices[corner as usize]));
                    self.triangles.push(Triangle::new(corners, &size, pose, paint));
                }
            }
        }
    }

    /// Adds an outline revolved about the x axis: positions along it and radii, closed at both ends.
    pub(crate) fn add_lathe(&mut self, outline: &[[f64; 2]], pose: &Pose, paint: Paint) {
        let ends = [outline.first(), outline.last()].map(|end| end.map_or([0.0; 2], |&[along, _]| [along, 0.0]));
        let closed: Vec<[f64; 2]> =
            std::iter::once(ends[0]).chain(outline.iter().copied()).chain(std::iter::once(ends[1])).collect();
        let point = |[along, radius]: [f64; 2], part: u32| {
            let (sin, cos) = libm::sincos(TAU * f64::from(part) / f64::from(SEGMENTS));
            Point3::new(along, radius * cos, radius * sin)
        };
        let lengths = outline.iter().map(|[along, _]| *along);
        let (least, most) = lengths.fold((0.0, 0.0), |(least, most): (f64, f64), at| (least.min(at), most.max(at)));
        let breadth = 2.0 * outline.iter().map(|[_, radius]| *radius).fold(0.0, f64::max);
        let size = Vector3::new(most - least, breadth, breadth);
        for ring in closed.windows(2) {
            for part in 0..SEGMENTS {
                let corners =
                    [point(ring[0], part), point(ring[0], part + 1), point(ring[1], part + 1), point(ring[1], part)];
                self.add_quad(corners, &size, pose, paint);
            }
        }
    }

    fn add_quad(&mut self, [a, b, c, d]: [Point3<f64>; 4], size: &Vector3<f64>, pose: &Pose, paint: Paint) {
        self.triangles.extend([[a, b, c], [a, c, d]].map(|corners| Triangle::new(corners, size, pose, paint)));
    }
}

/// Returns the lengths of the edges of the box around points, m.
fn size(points: &[[f64; 3]]) -> Vector3<f64> {
    let points = || points.iter().copied().map(Vector3::from);
    let least = points().fold(Vector3::repeat(f64::INFINITY), |least, point| least.inf(&point));
    points().fold(Vector3::repeat(f64::NEG_INFINITY), |most, point| most.sup(&point)) - least
}
