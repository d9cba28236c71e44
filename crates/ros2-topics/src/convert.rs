//! Conversions to ROS: poses with z up, times, names, and readings of sensors (REP 103, 117, 145).

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use scene::sensor::{Fan, imu, kinect_depth, line_laser, range_scanner_3d};
use scene::{Pose, SensorDef};

use crate::interfaces as ros;

/// Value in a covariance whose quantity is not measured (sensor_msgs/msg/Imu).
pub(crate) const NOT_MEASURED: f64 = -1.0;
/// `datatype` of a point's number of 32 bits (sensor_msgs/msg/PointField).
const FLOAT32: u8 = 7;
/// Bytes of a point: x, y, z.
const POINT_BYTES: u32 = 12;

/// Converts a name to one that ROS allows: letters, digits and `_`, no digit first.
pub fn name(text: &str) -> String {
    let mut name: String = text.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if name.starts_with(|c: char| c.is_ascii_digit()) || name.is_empty() {
        name.insert(0, '_');
    }
    name
}

/// Converts a simulated time, s.
pub fn stamp(time: f64) -> ros::Time {
    let nanoseconds = (time * 1e9).round() as u64;
    ros::Time { sec: (nanoseconds / 1_000_000_000) as i32, nanosec: (nanoseconds % 1_000_000_000) as u32 }
}

/// Makes the header of a message about a time, s, in a frame.
pub fn header(time: f64, frame: &str) -> ros::Header {
    ros::Header { stamp: stamp(time), frame_id: frame.to_owned() }
}

/// Converts a vector to z up.
pub fn vector(vector: Vector3<f64>) -> ros::Vector3 {
    ros::Vector3 { x: vector.x, y: -vector.y, z: -vector.z }
}

/// Converts a pose between two frames that are both turned z up: half a turn about x before and after.
fn upright(pose: &Pose) -> Pose {
    let ([x, y, z], turn) = (pose.translation.vector.into(), pose.rotation.coords);
    let turn = UnitQuaternion::new_unchecked(Quaternion::new(turn.w, turn.x, -turn.y, -turn.z));
    Isometry3::from_parts(Translation3::<f64>::new(x, -y, -z), turn)
}

/// Converts a pose to z up.
pub fn pose(pose: &Pose) -> ros::Pose {
    let pose = upright(pose);
    let ([x, y, z], [i, j, k, w]): ([f64; 3], [f64; 4]) = (pose.translation.vector.into(), pose.rotation.coords.into());
    ros::Pose { position: ros::Point { x, y, z }, orientation: ros::Quaternion { x: i, y: j, z: k, w } }
}

/// Converts a pose of ROS. A quaternion of length 0, as in a message that leaves it out, means no rotation.
pub fn from_pose(pose: &ros::Pose) -> Pose {
    let ros::Pose { position: ros::Point { x, y, z }, orientation: ros::Quaternion { x: i, y: j, z: k, w } } = *pose;
    let turn = UnitQuaternion::try_new(Quaternion::new(w, i, j, k), 1e-9).unwrap_or_else(UnitQuaternion::identity);
    upright(&Isometry3::from_parts(Translation3::new(x, y, z), turn))
}

/// Makes the transform of a frame in its parent.
pub(crate) fn transform(time: f64, parent: &str, child: &str, placed: &Pose) -> ros::TransformStamped {
    let ros::Pose { position: ros::Point { x, y, z }, orientation } = pose(placed);
    ros::TransformStamped {
        header: header(time, parent),
        child_frame_id: child.to_owned(),
        transform: ros::Transform { translation: ros::Vector3 { x, y, z }, rotation: orientation },
    }
}

/// Converts a distance. One that reaches as far as the sensor means that nothing was hit (REP 117).
fn distance(range: f64, max_range: f64) -> f32 {
    if range < max_range - 1e-6 { range as f32 } else { f32::INFINITY }
}

/// Converts a scan. The wire's beams go from the right to the left, as ROS's do.
pub(crate) fn laser(header: ros::Header, ranges: &[f64], scan_interval: f64, fan: Fan) -> ros::LaserScan {
    let steps = ranges.len().saturating_sub(1) as f64;
    ros::LaserScan {
        header,
        angle_min: -fan.first as f32,
        angle_max: (steps * fan.resolution - fan.first) as f32,
        angle_increment: fan.resolution as f32,
        time_increment: 0.0,
        scan_time: scan_interval as f32,
        range_min: fan.min_range as f32,
        range_max: fan.max_range as f32,
        ranges: ranges.iter().map(|range| distance(*range, fan.max_range)).collect(),
        intensities: Vec::new(),
    }
}

/// Converts one distance of a beam or a cone. `radiation_type` and its opening angle, rad, are the message's.
pub(crate) fn range(
    header: ros::Header,
    radiation_type: u8,
    angle: f64,
    [min_range, max_range]: [f64; 2],
    range: f64,
) -> ros::Range {
    ros::Range {
        header,
        radiation_type,
        field_of_view: angle as f32,
        min_range: min_range as f32,
        max_range: max_range as f32,
        range: distance(range, max_range),
        variance: 0.0,
    }
}

/// Converts the orientation of inertial navigation. Rates and acceleration are not measured.
pub(crate) fn orientation(header: ros::Header, angles: [f64; 3]) -> ros::Imu {
    let unmeasured = [[NOT_MEASURED, 0.0, 0.0], [0.0; 3], [0.0; 3]];
    ros::Imu {
        header,
        orientation: pose(&scene::pose([0.0; 3], angles)).orientation,
        orientation_covariance: [[0.0; 3]; 3],
        angular_velocity: ros::Vector3::default(),
        angular_velocity_covariance: unmeasured,
        linear_acceleration: ros::Vector3::default(),
        linear_acceleration_covariance: unmeasured,
    }
}

/// Converts a reading of an IMU to its own frame. A real accelerometer feels what holds it up (REP 145), so gravity, m/s², is added.
pub(crate) fn imu(header: ros::Header, sensor: &SensorDef, reading: &imu::Reading, gravity: f64) -> ros::Imu {
    let imu::Reading { acceleration: [ahead, right, up], angular_velocity, angles, .. } = *reading;
    let mount = scene::pose(sensor.position, sensor.direction).rotation;
    let attitude = scene::pose([0.0; 3], angles).rotation * mount;
    let held_up = attitude.inverse() * Vector3::new(0.0, 0.0, -gravity);
    ros::Imu {
        header,
        orientation: pose(&Pose::from_parts(Translation3::identity(), attitude)).orientation,
        orientation_covariance: [[0.0; 3]; 3],
        angular_velocity: vector(mount.inverse() * about_axes(angles, angular_velocity)),
        angular_velocity_covariance: [[0.0; 3]; 3],
        linear_acceleration: vector(Vector3::new(ahead, right, -up) + held_up),
        linear_acceleration_covariance: [[0.0; 3]; 3],
    }
}

/// Returns the turn rates about a body's own axes from its roll, pitch and yaw and their rates.
fn about_axes([roll, pitch, _]: [f64; 3], [of_roll, of_pitch, of_yaw]: [f64; 3]) -> Vector3<f64> {
    let (sin, cos) = roll.sin_cos();
    Vector3::new(
        of_roll - of_yaw * pitch.sin(),
        of_pitch * cos + of_yaw * sin * pitch.cos(),
        of_yaw * cos * pitch.cos() - of_pitch * sin,
    )
}

/// Makes a cloud of points in a frame that is turned z up.
pub(crate) fn cloud(header: ros::Header, points: impl Iterator<Item = [f64; 3]>) -> ros::PointCloud2 {
    let mut data = Vec::new();
    points.for_each(|[x, y, z]| [x, -y, -z].iter().for_each(|it| data.extend((*it as f32).to_le_bytes())));
    let field = |(name, number): (&str, u32)| ros::PointField {
        name: name.to_owned(),
        offset: 4 * number,
        datatype: FLOAT32,
        count: 1,
    };
    let width = data.len() as u32 / POINT_BYTES;
    ros::PointCloud2 {
        header,
        height: 1,
        width,
        fields: ["x", "y", "z"].into_iter().zip(0..).map(field).collect(),
        is_bigendian: false,
        point_step: POINT_BYTES,
        row_step: width * POINT_BYTES,
        data: ros::Bytes(data),
        is_dense: true,
    }
}

/// Returns the points that a scanner of rows hit, in its frame.
pub(crate) fn hits(config: &range_scanner_3d::Config, ranges: &[f64]) -> Vec<[f64; 3]> {
    let [_, columns] = config.counts();
    let row_of = |(row, ranges): (usize, &[f64])| -> Vec<[f64; 3]> {
        // Up is a negative pitch in these frames, so rows from the top to the bottom count down from half the field.
        let up = config.vertical_field_of_view / 2.0 - row as f64 * config.vertical_resolution;
        let hit = ranges.iter().enumerate().filter(|(_, range)| **range < config.max_range - 1e-6);
        let point = |(column, range): (usize, &f64)| {
            let right = config.horizontal_field_of_view / 2.0 - column as f64 * config.horizontal_resolution;
            [range * up.cos() * right.cos(), range * up.cos() * right.sin(), -range * up.sin()]
        };
        hit.map(point).collect()
    };
    ranges.chunks(columns.max(1)).enumerate().flat_map(row_of).collect()
}

/// Returns the points of a line of light in the frame of the sensor.
pub(crate) fn line(reading: &line_laser::Reading) -> Vec<[f64; 3]> {
    let to_sensor = scene::pose(reading.position, reading.angles).inverse();
    let point = |point: &[f64]| {
        let at = nalgebra::Point3::new(point.first()?.to_owned(), point.get(1)?.to_owned(), point.get(2)?.to_owned());
        Some((to_sensor * at).coords.into())
    };
    reading.points.chunks_exact(3).filter_map(point).collect()
}

/// Makes a picture of depths, m, rows from the top to the bottom. Where nothing was hit there is none (REP 118).
pub(crate) fn depth(header: ros::Header, depths: &[f32], max_range: f64) -> ros::Image {
    let number = |depth: &f32| if f64::from(*depth) < max_range - 1e-6 { *depth } else { f32::INFINITY };
    ros::Image {
        header,
        height: kinect_depth::ROWS,
        width: kinect_depth::COLUMNS,
        encoding: "32FC1".to_owned(),
        is_bigendian: 0,
        step: 4 * kinect_depth::COLUMNS,
        data: ros::Bytes(depths.iter().flat_map(|depth| number(depth).to_le_bytes()).collect()),
    }
}

/// Makes the numbers of a camera without distortion: `[width, height]` pixels and the angle from the left to the right edge, rad.
pub fn camera_info(header: ros::Header, [width, height]: [u32; 2], angle: f64) -> ros::CameraInfo {
    let focal = f64::from(width) / 2.0 / (angle / 2.0).tan();
    let [x, y] = [f64::from(width) / 2.0, f64::from(height) / 2.0];
    ros::CameraInfo {
        header,
        height,
        width,
        distortion_model: "plumb_bob".to_owned(),
        d: vec![0.0; 5],
        k: [[focal, 0.0, x], [0.0, focal, y], [0.0, 0.0, 1.0]],
        r: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        p: [[focal, 0.0, x, 0.0], [0.0, focal, y, 0.0], [0.0, 0.0, 1.0, 0.0]],
        ..ros::CameraInfo::default()
    }
}

/// Makes the transform of a camera's optical frame in the frame of the camera: z ahead, x to the right, y down (REP 103).
pub(crate) fn optical(time: f64, camera: &str, child: &str) -> ros::TransformStamped {
    ros::TransformStamped {
        header: header(time, camera),
        child_frame_id: child.to_owned(),
        transform: ros::Transform {
            translation: ros::Vector3::default(),
            rotation: ros::Quaternion { x: -0.5, y: 0.5, z: -0.5, w: 0.5 },
        },
    }
}

#[cfg(test)]
mod tests {
    use scene::sensor::Config;

    use super::*;

    #[test]
    fn a_robot_turned_right_on_the_wire_is_turned_clockwise_seen_from_above() {
        let placed = scene::pose([1.0, 2.0, -3.0], [0.0, 0.0, std::f64::consts::FRAC_PI_2]);
        let ros::Pose { position, orientation: ros::Quaternion { z, w, .. } } = pose(&placed);
        assert_eq!((position.x, position.y, position.z), (1.0, -2.0, 3.0));
        let half = std::f64::consts::FRAC_1_SQRT_2;
        assert!((z + half).abs() < 1e-12 && (w - half).abs() < 1e-12);
        let back = from_pose(&pose(&placed));
        assert!((back.inverse() * placed).translation.vector.norm() < 1e-12, "{back}");
    }

    /// Checks the rates against the change of the rotation itself.
    #[test]
    fn turn_rates_are_those_about_the_axes_of_the_body() {
        let (angles, rates, time) = ([0.3, -0.5, 1.2], [0.2, 0.7, -0.4], 1e-6);
        let rotation = |angles| scene::pose([0.0; 3], angles).rotation;
        let later: [f64; 3] = std::array::from_fn(|axis| angles[axis] + rates[axis] * time);
        let turned = (rotation(angles).inverse() * rotation(later)).scaled_axis() / time;
        assert!((turned - about_axes(angles, rates)).norm() < 1e-5);
    }

    /// Checks the acceleration of a resting IMU on the Moon, mounted with its x axis down.
    #[test]
    fn a_resting_imu_feels_the_gravity_of_its_map() {
        let config = Config::Imu(imu::Config {});
        let direction = [0.0, -std::f64::consts::FRAC_PI_2, 0.0];
        let sensor =
            SensorDef { name: "IMU".to_owned(), link: 0, position: [0.0; 3], direction, scan_interval: 0.1, config };
        let [acceleration, angular_velocity, angular_acceleration, angles] = [[0.0; 3]; 4];
        let reading = imu::Reading { acceleration, angular_velocity, angular_acceleration, angles };
        let ros::Vector3 { x, y, z } = imu(header(0.0, "it"), &sensor, &reading, 1.62).linear_acceleration;
        assert!((x + 1.62).abs() < 1e-12 && y.abs() < 1e-12 && z.abs() < 1e-12, "{x} {y} {z}");
    }

    #[test]
    fn names_become_names_of_ros() {
        let check = |text: &str, expected: &str| assert_eq!(name(text), expected);
        check("Scanner1", "Scanner1");
        check("1st laser", "_1st_laser");
        check("", "_");
    }

    #[test]
    fn a_beam_that_hits_nothing_is_infinite() {
        let fan = Fan { first: 1.0, resolution: 1.0, min_range: 0.1, max_range: 20.0, level: true };
        let scan = laser(header(0.0, "it"), &[1.5, 20.0, 0.0], 0.1, fan);
        assert_eq!(scan.ranges, [1.5, f32::INFINITY, 0.0]);
        assert_eq!((scan.angle_min, scan.angle_max), (-1.0, 1.0));
    }

    #[test]
    fn the_upper_row_of_a_scanner_hits_higher() {
        let config =
            range_scanner_3d::Config { vertical_field_of_view: 0.2, vertical_resolution: 0.2, ..Default::default() };
        let [rows, columns] = config.counts();
        let ranges = vec![2.0; rows * columns];
        let cloud = cloud(header(0.0, "it"), hits(&config, &ranges).into_iter());
        let number = |byte: usize| f32::from_le_bytes(cloud.data.0[byte..byte + 4].try_into().expect("four bytes"));
        // The first beam of the upper row is up and to the right.
        assert_eq!((cloud.width as usize, cloud.data.0.len()), (rows * columns, 12 * rows * columns));
        assert!(number(4) < 0.0 && number(8) > 0.0, "{} {}", number(4), number(8));
    }
}
