//! The camera of a picture.

use nalgebra::{Point3, Vector3};

use scene::{MapDef, Pose, RobotDef, RobotSnapshot, SensorDef};

use crate::corners::corners_of_map;
use crate::raster::axes;

/// A camera in the world frame, m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Position of the eye.
    pub eye: Point3<f64>,
    /// Point in the middle of the picture.
    pub target: Point3<f64>,
    /// Direction that is down in the picture, as far as it lies across the view; z for an upright one.
    pub down: Vector3<f64>,
    /// Angle from the lower to the upper edge, rad.
    pub field_of_view: f64,
}

/// Direction from behind, from the left and from above toward what a picture shows.
pub const FROM_CORNER: Vector3<f64> = Vector3::new(0.75, 0.75, 0.65);
/// Angle from the lower to the upper edge of a picture that nobody chose another one for, rad.
pub const FIELD_OF_VIEW: f64 = 0.6;
/// Fraction of the picture's width and height that is used.
const FILLING: f64 = 0.94;
/// Least distance from the eye to the nearest point, m.
const LEAST_DISTANCE: f64 = 0.05;

impl Camera {
    /// Creates a camera that looks in a direction, as near as possible with all points in a picture of this width and height.
    pub fn fitting(places: &[Point3<f64>], ahead: Vector3<f64>, field_of_view: f64, size: [usize; 2]) -> Self {
        let axes = axes(ahead, Vector3::z());
        let tangent = FILLING * libm::tan(field_of_view / 2.0);
        let tangents = [tangent * size[0] as f64 / size[1] as f64, tangent];
        let local: Vec<[f64; 3]> = places.iter().map(|place| axes.map(|axis| place.coords.dot(&axis))).collect();
        let far = local.iter().map(|place| place[2]).fold(f64::MIN, f64::max);
        let near = local.iter().map(|place| place[2]).fold(f64::MAX, f64::min);
        // A point is in the picture while |across - eye| <= tangent (depth - eye's depth), for each of both axes.
        let mut eye = [0.0, 0.0, near - LEAST_DISTANCE];
        for (axis, tangent) in tangents.into_iter().enumerate() {
            let low = local.iter().map(|place| place[axis] - tangent * place[2]).fold(f64::MIN, f64::max);
            let high = local.iter().map(|place| place[axis] + tangent * place[2]).fold(f64::MAX, f64::min);
            eye[axis] = (low + high) / 2.0;
            eye[2] = eye[2].min((high - low) / (2.0 * tangent));
        }
        let middle = (far + near) / 2.0 - eye[2];
        let eye = Point3::from(axes[0] * eye[0] + axes[1] * eye[1] + axes[2] * eye[2]);
        Self { eye, target: eye + axes[2] * middle, down: Vector3::z(), field_of_view }
    }

    /// Creates a camera that shows a whole map from a corner in a picture of this width and height.
    pub fn of_map(map: &MapDef, size: [usize; 2]) -> Self {
        Self::fitting(&corners_of_map(map), FROM_CORNER, FIELD_OF_VIEW, size)
    }

    /// Creates the camera of a robot: it looks along the x axis of a pose in the world, with z down. `across` is the angle from the left
    /// to the right edge of a picture of this width and height, rad.
    fn mounted(pose: &Pose, across: f64, size: [usize; 2]) -> Self {
        let eye = Point3::from(pose.translation.vector);
        let tangent = libm::tan(across / 2.0) * size[1] as f64 / size[0] as f64;
        let [ahead, down] = [Vector3::x(), Vector3::z()].map(|axis| pose.rotation * axis);
        Self { eye, target: eye + ahead, down, field_of_view: 2.0 * libm::atan(tangent) }
    }

    /// Creates the camera that is a robot's sensor. `None` if the class has no such link.
    pub fn of_robot(
        def: &RobotDef,
        robot: &RobotSnapshot,
        sensor: &SensorDef,
        across: f64,
        size: [usize; 2],
    ) -> Option<Self> {
        let (link, _, mount) = def.mount_of(sensor)?;
        let placed = def.placed_links(&robot.joints);
        let (_, link) = placed.get(link)?;
        Some(Self::mounted(&(robot.body.pose * link * mount), across, size))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::Projection;

    #[test]
    fn a_fitting_camera_has_every_place_in_the_picture_and_no_room_to_spare() {
        let cloud = |sizes: [f64; 3]| -> Vec<Point3<f64>> {
            let half = |bit: usize, axis: usize| if bit >> axis & 1 == 0 { 3.0 } else { 3.0 + sizes[axis] };
            (0..8).map(|bit| Point3::new(half(bit, 0), half(bit, 1), -half(bit, 2))).collect()
        };
        for sizes in [[12.0, 10.0, 0.5], [0.6, 0.4, 0.2], [1.0, 100.0, 1.0], [0.0; 3]] {
            for ahead in [[0.75, 0.75, 0.65], [0.0, 0.0, 1.0], [0.0, -1.0, 0.2], [-1.0, -0.25, 0.3]] {
                for size in [[1280, 720], [720, 1280], [64, 64], [3000, 100]] {
                    let places = cloud(sizes);
                    let camera = Camera::fitting(&places, Vector3::from(ahead), 0.6, size);
                    let view = Projection::perspective(&camera, size[0], size[1]);
                    let mut fullest: f64 = 0.0;
                    for place in &places {
                        let pixel = view.pixel_of(place).unwrap_or_else(|| panic!("{place} is behind {camera:?}"));
                        for axis in 0..2 {
                            let part = (pixel[axis] / size[axis] as f64 - 0.5).abs() * 2.0;
                            assert!(part < 0.95, "{sizes:?} {ahead:?} {size:?}: {part}");
                            fullest = fullest.max(part);
                        }
                    }
                    assert!(fullest > 0.9 || sizes == [0.0; 3], "{sizes:?} {ahead:?} {size:?}: {fullest}");
                }
            }
        }
    }
}
