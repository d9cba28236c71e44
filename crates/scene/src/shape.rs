//! Geometry of solids.

use serde::{Deserialize, Serialize};

use crate::{HeightField, Material, Pose, pose};

/// Geometry of a solid, in its own frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(ts_rs::TS))]
pub enum Shape {
    /// Everything below the plane z = 0 (positive z); the space above it (negative z) is free.
    HalfSpace,
    /// A box around the origin, by its edge lengths, m.
    Box {
        /// Edge lengths along x, y, z.
        size: [f64; 3],
    },
    /// A cylinder around the z axis, centred on the origin, m.
    Cylinder {
        /// Radius.
        radius: f64,
        /// Length along z.
        length: f64,
    },
    /// A ball around the origin, m.
    Ball {
        /// Radius.
        radius: f64,
    },
    /// The convex hull of points, m.
    Hull {
        /// At least four points that are not in one plane.
        points: Vec<[f64; 3]>,
    },
    /// A surface of triangles, m.
    Mesh {
        /// Corners.
        vertices: Vec<[f64; 3]>,
        /// Indices of three corners each.
        triangles: Vec<[u32; 3]>,
    },
    /// A surface of heights over a grid.
    HeightField(HeightField),
}

impl Shape {
    /// Returns the distance of the farthest point from the origin, m.
    pub fn reach(&self) -> f64 {
        let farthest = |points: &[[f64; 3]]| points.iter().map(|&point| norm(point)).fold(0.0, f64::max);
        match self {
            Self::HalfSpace => f64::INFINITY,
            Self::Box { size } => norm(*size) / 2.0,
            Self::Cylinder { radius, length } => norm([*radius, length / 2.0, 0.0]),
            Self::Ball { radius } => *radius,
            Self::Hull { points } => farthest(points),
            Self::Mesh { vertices, .. } => farthest(vertices),
            Self::HeightField(HeightField { size: [x, y], heights, .. }) => {
                norm([x / 2.0, y / 2.0, heights.iter().copied().map(f64::abs).fold(0.0, f64::max)])
            }
        }
    }

    /// Scales the shape along its own axes. A cylinder stays round, with the mean of both factors across, and a ball with that of all.
    #[must_use]
    pub fn scaled(&self, [x, y, z]: [f64; 3]) -> Self {
        let scaled = |points: &[[f64; 3]]| points.iter().map(|[a, b, c]| [a * x, b * y, c * z]).collect();
        match self {
            Self::HalfSpace => Self::HalfSpace,
            Self::Box { size: [a, b, c] } => Self::Box { size: [a * x, b * y, c * z] },
            Self::Cylinder { radius, length } => Self::Cylinder { radius: radius * (x + y) / 2.0, length: length * z },
            Self::Ball { radius } => Self::Ball { radius: radius * (x + y + z) / 3.0 },
            Self::Hull { points } => Self::Hull { points: scaled(points) },
            Self::Mesh { vertices, triangles } => {
                Self::Mesh { vertices: scaled(vertices), triangles: triangles.clone() }
            }
            Self::HeightField(field) => Self::HeightField(field.scaled([x, y, z])),
        }
    }
}

fn norm(vector: [f64; 3]) -> f64 {
    nalgebra::Vector3::from(vector).norm()
}

/// A shape with a pose and a material.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Solid {
    /// Name for messages and viewers.
    pub name: String,
    /// Geometry.
    pub shape: Shape,
    /// Position in the frame of the map or of the robot, m.
    pub position: [f64; 3],
    /// Roll, pitch, yaw, rad.
    pub rotation: [f64; 3],
    /// Surface material.
    pub material: Material,
}

impl Solid {
    /// Returns the pose.
    pub fn pose(&self) -> Pose {
        pose(self.position, self.rotation)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_reach_is_the_distance_of_the_farthest_point() {
        let points = vec![[1.0, 0.0, 0.0], [0.0, -3.0, 4.0], [0.0, 0.0, 0.0], [1.0, 1.0, 1.0]];
        for (shape, reach) in [
            (Shape::Box { size: [2.0, 4.0, 4.0] }, 3.0),
            (Shape::Cylinder { radius: 3.0, length: 8.0 }, 5.0),
            (Shape::Ball { radius: 2.0 }, 2.0),
            (Shape::Hull { points: points.clone() }, 5.0),
            (Shape::Mesh { vertices: points, triangles: Vec::new() }, 5.0),
            (Shape::HeightField(HeightField { size: [6.0, 8.0], columns: 2, heights: vec![0.0; 4] }), 5.0),
            (Shape::HalfSpace, f64::INFINITY),
        ] {
            assert_eq!(shape.reach(), reach, "{shape:?}");
        }
    }
}
