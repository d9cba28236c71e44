//! Conversion of shapes to triangles, and of infinite floors to planes.

use std::f64::consts::TAU;

use nalgebra::{Point3, Vector3};
use scene::{Pose, Shape};

/// A triangle of a surface.
#[derive(Clone)]
pub(crate) struct Triangle {
    pub(crate) corners: [Point3<f64>; 3],
    pub(crate) colour: [f64; 3],
}

/// An infinite plane.
pub(crate) struct Floor {
    place: Point3<f64>,
    /// Normal, out of the ground.
    pub(crate) normal: Vector3<f64>,
    pub(crate) colour: [f64; 3],
}

/// Number of corners around a cylinder, a ball or a roller.
const SEGMENTS: u32 = 24;

impl Triangle {
    pub(crate) fn normal(&self) -> Vector3<f64> {
        let [a, b, c] = self.corners;
        (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_else(|| -Vector3::z())
    }
}

impl Floor {
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
    pub(crate) fn add(&mut self, shape: &Shape, pose: &Pose, colour: [f64; 3]) {
        match shape {
            Shape::HalfSpace => {
                let normal = pose.rotation * -Vector3::z();
                self.floors.push(Floor { place: pose.translation.vector.into(), normal, colour });
            }
            Shape::Box { size } => {
                let corner = |signs: u32| {
                    Point3::from(Vector3::from_fn(|axis, _| {
                        if signs >> axis & 1 == 1 { size[axis] / 2.0 } else { -size[axis] / 2.0 }
                    }))
                };
                for face in [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]] {
                    let corners = face.map(corner);
                    self.add_quad(corners, pose, colour);
                }
            }
            Shape::Ball { radius } => {
                let point = |part: u32| {
                    let angle = TAU / 2.0 * f64::from(part) / f64::from(SEGMENTS / 2);
                    [-radius * libm::cos(angle), radius * libm::sin(angle)]
                };
                let outline: Vec<[f64; 2]> = (0..=SEGMENTS / 2).map(point).collect();
                self.add_lathe(&outline, pose, colour);
            }
            Shape::Cylinder { radius, length } => {
                let upright = pose * scene::pose([0.0; 3], [0.0, -TAU / 4.0, 0.0]);
                self.add_lathe(&[[-length / 2.0, *radius], [length / 2.0, *radius]], &upright, colour);
            }
            Shape::Hull { points } => {
                if let Some(surface) = scene::hull_surface(points) {
                    self.add(&surface, pose, colour);
                }
            }
            Shape::HeightField(field) => self.add(&field.surface(), pose, colour),
            Shape::Mesh { vertices, triangles } => {
                for triangle in triangles {
                    let corners = triangle.map(|corner| pose * Point3::from(vertices[corner as usize]));
                    self.triangles.push(Triangle { corners, colour });
                }
            }
        }
    }

    /// Adds an outline revolved about the x axis: positions along it and radii, closed at both ends.
    pub(crate) fn add_lathe(&mut self, outline: &[[f64; 2]], pose: &Pose, colour: [f64; 3]) {
        let ends = [outline.first(), outline.last()].map(|end| end.map_or([0.0; 2], |&[along, _]| [along, 0.0]));
        let closed: Vec<[f64; 2]> =
            std::iter::once(ends[0]).chain(outline.iter().copied()).chain(std::iter::once(ends[1])).collect();
        let point = |[along, radius]: [f64; 2], part: u32| {
            let (sin, cos) = libm::sincos(TAU * f64::from(part) / f64::from(SEGMENTS));
            Point3::new(along, radius * cos, radius * sin)
        };
        for ring in closed.windows(2) {
            for part in 0..SEGMENTS {
                let corners =
                    [point(ring[0], part), point(ring[0], part + 1), point(ring[1], part + 1), point(ring[1], part)];
                self.add_quad(corners, pose, colour);
            }
        }
    }

    fn add_quad(&mut self, corners: [Point3<f64>; 4], pose: &Pose, colour: [f64; 3]) {
        let [a, b, c, d] = corners.map(|corner| pose * corner);
        self.triangles.extend([[a, b, c], [a, c, d]].map(|corners| Triangle { corners, colour }));
    }
}
