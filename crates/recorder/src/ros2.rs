//! The log as messages of ROS 2, in a separate file: the profile is `ros2`, and messages are CDR. `docs/logs.md` lists the
//! topics. Frames are those of REP 103: x forward, y left, z up.

mod messages;

use std::path::Path;

use mcap::McapResult;
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use scene::sensor::{Config, Fan, imu};
use scene::{Pose, Reading, RobotDef, Sensed, SensorDef, WorldDef};

use self::messages as ros;
use crate::file::{LogFile, Storage, nanoseconds};
use crate::slots::{Slots, Slotted};
use crate::{ObjectState, Publish, Record, RecordError, RobotState};

/// Value in a covariance whose quantity is not measured (sensor_msgs/msg/Imu).
const NOT_MEASURED: f64 = -1.0;

/// Begins a file for the messages.
pub(crate) fn begin(storage: Box<dyn Storage>, path: &Path) -> Result<LogFile, RecordError> {
    LogFile::begin(storage, path, "ros2")
}

/// Converts records to messages.
pub(crate) struct Ros2 {
    world: WorldDef,
    /// Robots that have been seen.
    slots: Slots,
    /// Last time on `/clock`, ns.
    clock: Option<u64>,
}

impl Ros2 {
    pub(crate) fn new(world: &WorldDef) -> Self {
        Self { world: world.clone(), slots: Slots::default(), clock: None }
    }

    pub(crate) fn write(&mut self, time: f64, record: &Record, file: &mut LogFile) -> McapResult<()> {
        match record {
            Record::State(state) => self.write_state(time, state, file),
            Record::Object(object) => self.write_object(time, object, file),
            Record::Sensed(sensed) => self.write_reading(time, sensed, file),
            Record::Left(robot) => {
                self.slots.leave(*robot);
                Ok(())
            }
            Record::In(_)
            | Record::Out(_)
            | Record::Closed(_)
            | Record::ObjectSpawned(_)
            | Record::ObjectRemoved(_)
            | Record::Picture(..)
            | Record::Scored(_)
            | Record::Standings(_)
            | Record::Warning(_)
            | Record::Map(_) => Ok(()),
        }
    }

    fn write_clock(&mut self, time: f64, file: &mut LogFile) -> McapResult<()> {
        let now = nanoseconds(time);
        if self.clock.replace(now) == Some(now) {
            return Ok(());
        }
        file.publish(time, "/clock", &ros::Clock { clock: stamp(time) })
    }

    fn write_state(&mut self, time: f64, state: &RobotState, file: &mut LogFile) -> McapResult<()> {
        self.write_clock(time, file)?;
        let RobotState { robot, class, .. } = state;
        let slot = self.slots.get(*robot).map(|slotted| slotted.slot);
        let (came, slot) = (slot.is_none(), slot.unwrap_or_else(|| self.slots.come(*robot, class)));
        let frame = robot_frame(slot);
        let def = self.world.robots.get(class);
        if let (true, Some(def)) = (came, def) {
            let mount = |sensor: &SensorDef| {
                let (number, link, pose) = def.mount_of(sensor)?;
                let parent = if number == 0 { frame.clone() } else { format!("{frame}/{}", name(&link.name)) };
                Some(transform(time, &parent, &sensor_frame(slot, &sensor.name), &pose))
            };
            let mounts = def.sensors.iter().filter_map(mount).collect();
            file.publish(time, "/tf_static", &ros::TFMessage { transforms: mounts })?;
        }
        let pose = state.pose();
        let links = def.into_iter().flat_map(|def| def.placed_links(&state.joints())).skip(1);
        let links = links.map(|(link, pose)| transform(time, &frame, &format!("{frame}/{}", name(&link.name)), &pose));
        let transforms = std::iter::once(transform(time, "map", &frame, &pose)).chain(links).collect();
        file.publish(time, "/tf", &ros::TFMessage { transforms })?;

        let (linear, angular) = state.velocity();
        let in_robot = |axes: Vector3<f64>| vector(pose.rotation.inverse() * axes);
        let odometry = ros::Odometry {
            header: header(time, "map"),
            child_frame_id: frame.clone(),
            pose: ros::PoseWithCovariance { pose: ros_pose(&pose), covariance: [[0.0; 6]; 6] },
            twist: ros::TwistWithCovariance {
                twist: ros::Twist { linear: in_robot(linear), angular: in_robot(angular) },
                covariance: [[0.0; 6]; 6],
            },
        };
        file.publish(time, &format!("/{frame}/ground_truth"), &odometry)?;
        let joints = ros::JointState {
            header: header(time, &frame),
            name: def.into_iter().flat_map(RobotDef::with_values).map(|link| name(&link.name)).collect(),
            position: state.joint_positions.clone(),
            velocity: state.joint_speeds.clone(),
            effort: Vec::new(),
        };
        file.publish(time, &format!("/{frame}/joint_states"), &joints)
    }

    fn write_object(&mut self, time: f64, object: &ObjectState, file: &mut LogFile) -> McapResult<()> {
        self.write_clock(time, file)?;
        let placed = transform(time, "map", &format!("object_{}", object.object), &object.pose());
        file.publish(time, "/tf", &ros::TFMessage { transforms: vec![placed] })
    }

    fn write_reading(&self, time: f64, sensed: &Sensed, file: &mut LogFile) -> McapResult<()> {
        let Some(Slotted { slot, class }) = self.slots.get(sensed.robot.0) else { return Ok(()) };
        let sensor = self.world.robots.get(class).and_then(|def| def.sensors.get(sensed.sensor));
        let Some(sensor) = sensor else { return Ok(()) };
        let topic = format!("/{}/sensor/{}", robot_frame(*slot), name(&sensor.name));
        let header = header(time, &sensor_frame(*slot, &sensor.name));
        match (&sensed.reading, &sensor.config) {
            (Reading::RangeScanner(scan), config) => match config.fan().filter(|fan| fan.level) {
                Some(fan) => file.publish(time, &topic, &laser(header, &scan.ranges, sensor.scan_interval, fan)),
                None => Ok(()),
            },
            (Reading::Sonar(sonar), Config::Sonar(config)) => {
                let message = ros::Range {
                    header,
                    radiation_type: ros::ULTRASOUND,
                    field_of_view: config.beam_angle as f32,
                    min_range: config.min_range as f32,
                    max_range: config.max_range as f32,
                    range: sonar.range as f32,
                };
                file.publish(time, &topic, &message)
            }
            (Reading::Ins(ins), _) => file.publish(time, &topic, &orientation(header, ins.angles)),
            (Reading::Imu(reading), _) => {
                file.publish(time, &topic, &imu(header, sensor, reading, self.world.map.gravity))
            }
            (Reading::Odometry(odometry), _) => {
                let pose = scene::pose([odometry.x, odometry.y, 0.0], [0.0, 0.0, odometry.theta]);
                let mut message = ros::Odometry {
                    header,
                    child_frame_id: robot_frame(*slot),
                    pose: ros::PoseWithCovariance { pose: ros_pose(&pose), covariance: [[0.0; 6]; 6] },
                    twist: ros::TwistWithCovariance::default(),
                };
                message.header.frame_id.push_str("_start");
                message.twist.covariance[0][0] = NOT_MEASURED;
                file.publish(time, &topic, &message)
            }
            // The rest of the state has their content.
            (Reading::GroundTruth(_) | Reading::Encoder(_) | Reading::Tachometer(_), _) => Ok(()),
            // A sonar's reading is of a sonar. ROS 2 has no message for the others.
            (
                Reading::Sonar(_)
                | Reading::Touch(_)
                | Reading::Camera(_)
                | Reading::Acceleration(_)
                | Reading::Accelerometer(_)
                | Reading::Altitude(_)
                | Reading::Compass(_)
                | Reading::MissionTime(_)
                | Reading::Infrared(_)
                | Reading::RangeScanner3D(_)
                | Reading::KinectDepth(_)
                | Reading::LineLaser(_)
                | Reading::PointCloud(_)
                | Reading::BumperArray(_)
                | Reading::Gps(_)
                | Reading::Acoustic(_)
                | Reading::ObjectSensor(_)
                | Reading::Rfid(_)
                | Reading::Victim(_)
                | Reading::HumanMotion(_)
                | Reading::Sound(_)
                | Reading::Co2(_)
                | Reading::Inu(_),
                _,
            ) => Ok(()),
        }
    }
}

/// Converts a scan. The wire's beams go from the right to the left, as ROS's do.
fn laser(header: ros::Header, ranges: &[f64], scan_interval: f64, fan: Fan) -> ros::LaserScan {
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
        ranges: ranges.iter().map(|range| *range as f32).collect(),
        intensities: Vec::new(),
    }
}

/// Converts the orientation of inertial navigation. Rates and acceleration are not measured.
fn orientation(header: ros::Header, angles: [f64; 3]) -> ros::Imu {
    let unmeasured = [[NOT_MEASURED, 0.0, 0.0], [0.0; 3], [0.0; 3]];
    ros::Imu {
        header,
        orientation: ros_pose(&scene::pose([0.0; 3], angles)).orientation,
        orientation_covariance: [[0.0; 3]; 3],
        angular_velocity: ros::Vector3::default(),
        angular_velocity_covariance: unmeasured,
        linear_acceleration: ros::Vector3::default(),
        linear_acceleration_covariance: unmeasured,
    }
}

/// Converts a reading of an IMU to its own frame. A real accelerometer feels what holds it up (REP 145), so gravity, m/s², is added.
fn imu(header: ros::Header, sensor: &SensorDef, reading: &imu::Reading, gravity: f64) -> ros::Imu {
    let imu::Reading { acceleration: [ahead, right, up], angular_velocity, angles, .. } = *reading;
    let mount = scene::pose(sensor.position, sensor.direction).rotation;
    let attitude = scene::pose([0.0; 3], angles).rotation * mount;
    let held_up = attitude.inverse() * Vector3::new(0.0, 0.0, -gravity);
    let pose = Pose::from_parts(Translation3::identity(), attitude);
    ros::Imu {
        header,
        orientation: ros_pose(&pose).orientation,
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

fn robot_frame(slot: u64) -> String {
    format!("robot_{slot}")
}

fn sensor_frame(slot: u64, sensor: &str) -> String {
    format!("robot_{slot}/{}", name(sensor))
}

/// Converts a name to one that ROS allows: letters, digits and `_`, no digit first.
fn name(text: &str) -> String {
    let mut name: String = text.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    if name.starts_with(|c: char| c.is_ascii_digit()) || name.is_empty() {
        name.insert(0, '_');
    }
    name
}

fn stamp(time: f64) -> ros::Time {
    let nanoseconds = nanoseconds(time);
    ros::Time { sec: (nanoseconds / 1_000_000_000) as i32, nanosec: (nanoseconds % 1_000_000_000) as u32 }
}

fn header(time: f64, frame: &str) -> ros::Header {
    ros::Header { stamp: stamp(time), frame_id: frame.to_owned() }
}

/// Converts a vector to z up.
fn vector(vector: Vector3<f64>) -> ros::Vector3 {
    ros::Vector3 { x: vector.x, y: -vector.y, z: -vector.z }
}

/// Converts a pose between two frames that are both turned z up: half a turn about x before and after.
fn upright(pose: &Pose) -> Pose {
    let ([x, y, z], turn) = (pose.translation.vector.into(), pose.rotation.coords);
    let turn = UnitQuaternion::new_unchecked(Quaternion::new(turn.w, turn.x, -turn.y, -turn.z));
    Isometry3::from_parts(Translation3::<f64>::new(x, -y, -z), turn)
}

fn ros_pose(pose: &Pose) -> ros::Pose {
    let pose = upright(pose);
    let ([x, y, z], [i, j, k, w]): ([f64; 3], [f64; 4]) = (pose.translation.vector.into(), pose.rotation.coords.into());
    ros::Pose { position: ros::Point { x, y, z }, orientation: ros::Quaternion { x: i, y: j, z: k, w } }
}

fn transform(time: f64, parent: &str, child: &str, pose: &Pose) -> ros::TransformStamped {
    let ros::Pose { position: ros::Point { x, y, z }, orientation } = ros_pose(pose);
    ros::TransformStamped {
        header: header(time, parent),
        child_frame_id: child.to_owned(),
        transform: ros::Transform { translation: ros::Vector3 { x, y, z }, rotation: orientation },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_robot_turned_right_on_the_wire_is_turned_clockwise_seen_from_above() {
        let pose = ros_pose(&scene::pose([1.0, 2.0, -3.0], [0.0, 0.0, std::f64::consts::FRAC_PI_2]));
        assert_eq!((pose.position.x, pose.position.y, pose.position.z), (1.0, -2.0, 3.0));
        let ros::Quaternion { z, w, .. } = pose.orientation;
        assert!(
            (z + std::f64::consts::FRAC_1_SQRT_2).abs() < 1e-12 && (w - std::f64::consts::FRAC_1_SQRT_2).abs() < 1e-12
        );
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
}
