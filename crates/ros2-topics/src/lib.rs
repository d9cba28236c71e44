//! The world as topics of ROS 2: messages, names and frames. Logs write them to a file, and the crate `ros2` publishes them live.
//!
//! Frames are those of REP 103 and 105: x forward, y left, z up; `odom` is where a robot came into the world, and `base_link` is the robot
//! frame. A robot's topics and frames are in its namespace. This crate has no sockets and no clock.

pub mod cdr;
mod controller;
mod convert;
mod description;
pub mod interfaces;
pub mod json;
mod names;
mod odometer;

use std::collections::BTreeMap;

use nalgebra::Vector3;
use scene::sensor::{Config, kinect_depth};
use scene::{JointKind, JointState, MapDef, Pose, Reading, RobotDef, Sensed};

pub use controller::{Controller, Limit, Wheels};
pub use convert::{camera_info, from_pose, header, name, pose, stamp, vector};
use interfaces as ros;
pub use interfaces::Message;
pub use names::{Namespaces, Space};
use names::{SensorNames, Spaces};
use odometer::{Moved, Odometer};

/// Frame of the world.
pub const MAP: &str = "map";
/// Variances of odometry (nav_msgs/msg/Odometry): those along x and y and about z as small as wheels give them, m² and rad²; the others so
/// large that filters leave them out, as drivers of real robots set them.
pub const VARIANCES: [f64; 6] = [1e-3, 1e-3, 1e6, 1e6, 1e6, 1e-2];
/// `status` of a fix without correction, and of none (sensor_msgs/msg/NavSatStatus).
const FIX: [i8; 2] = [-1, 0];
/// `service` of GPS there.
const GPS: u16 = 1;
/// Least satellites of a fix.
const SATELLITES: f64 = 4.0;
/// `position_covariance_type` of variances that are known (sensor_msgs/msg/NavSatFix).
const DIAGONAL_KNOWN: u8 = 2;
/// `power_supply_status` of a battery in use (sensor_msgs/msg/BatteryState).
const DISCHARGING: u8 = 2;

/// A destination of messages.
pub trait Sink {
    /// Failure of a message.
    type Error;

    /// Takes a message about a simulated time, s.
    ///
    /// # Errors
    /// When it cannot be written.
    fn publish<T: Message>(&mut self, time: f64, topic: &str, message: &T) -> Result<(), Self::Error>;
}

/// True for a topic whose last message late subscribers get (transient local).
pub fn is_latched(topic: &str) -> bool {
    topic == "/tf_static" || topic.ends_with("/robot_description")
}

/// State of a robot.
#[derive(Debug, Clone, Copy)]
pub struct State<'a> {
    /// Pose in the world.
    pub pose: Pose,
    /// Velocity in world axes, m/s.
    pub linear: Vector3<f64>,
    /// Angular velocity in world axes, rad/s.
    pub angular: Vector3<f64>,
    /// Joints that have a value.
    pub joints: &'a [JointState],
}

/// The robots of a world and their names in ROS.
#[derive(Debug)]
pub struct Topics {
    spaces: Spaces,
    /// True to publish where a robot's odometry begins in the map, as a perfect localisation would.
    is_localised: bool,
    /// Gravity, m/s².
    gravity: f64,
    robots: BTreeMap<u64, Robot>,
    /// Last time on `/clock`.
    clock: Option<f64>,
    /// Transforms that wait for [`Topics::publish_transforms`].
    transforms: Vec<ros::TransformStamped>,
}

/// A robot in the world.
#[derive(Debug)]
struct Robot {
    space: Space,
    def: RobotDef,
    /// The controller whose numbers count; without one those of the simulator.
    controller: Option<Controller>,
    sensors: Vec<SensorNames>,
    odometer: Option<Odometer>,
    /// Transforms that do not change.
    fixed: Vec<ros::TransformStamped>,
    /// The picture of a depth camera that is being taken, by the sensor's number: rows so far, m.
    depths: BTreeMap<usize, Vec<f32>>,
}

impl Topics {
    /// Creates the topics of a world without robots on a map.
    pub fn new(namespaces: Namespaces, is_localised: bool, map: &MapDef) -> Self {
        Self {
            spaces: Spaces::new(namespaces),
            is_localised,
            gravity: map.gravity,
            robots: BTreeMap::new(),
            clock: None,
            transforms: Vec::new(),
        }
    }

    /// True if a robot is known.
    pub fn has(&self, robot: u64) -> bool {
        self.robots.contains_key(&robot)
    }

    /// Returns the names of a robot.
    pub fn space(&self, robot: u64) -> Option<&Space> {
        self.robots.get(&robot).map(|robot| &robot.space)
    }

    /// Publishes the time.
    ///
    /// # Errors
    /// When the sink fails.
    pub fn publish_clock<S: Sink>(&mut self, time: f64, sink: &mut S) -> Result<(), S::Error> {
        if self.clock.replace(time) == Some(time) {
            return Ok(());
        }
        sink.publish(time, "/clock", &ros::Clock { clock: stamp(time) })
    }

    /// Takes a robot that has come, with its number, name and class, and publishes what does not change about it. `controller` has the
    /// numbers of its odometry, if they are not the simulator's.
    ///
    /// # Errors
    /// When the sink fails.
    pub fn come<S: Sink>(
        &mut self,
        time: f64,
        robot: u64,
        called: &str,
        def: &RobotDef,
        controller: Option<Controller>,
        sink: &mut S,
    ) -> Result<(), S::Error> {
        let space = self.spaces.come(robot, called);
        let space = controller.iter().fold(space, Space::with);
        let sensors = names::of_sensors(def, &space);
        let frame = |link: usize| description::frame(def, link, &space);
        let links = def.links.iter().enumerate().filter_map(|(number, link)| {
            let joint = link.joint.as_ref().filter(|joint| !moves(joint.kind))?;
            let parent = def.links.get(joint.parent)?;
            let offset = Vector3::from(link.origin()) - Vector3::from(parent.origin());
            let offset = Pose::from_parts(offset.into(), nalgebra::UnitQuaternion::identity());
            Some(convert::transform(time, &frame(joint.parent), &frame(number), &offset))
        });
        let mounts = def.sensors.iter().zip(&sensors).filter_map(|(sensor, names)| {
            let (number, _, pose) = def.mount_of(sensor)?;
            let mount = convert::transform(time, &frame(number), &names.frame, &pose);
            let optical = names.optical.as_ref().map(|optical| convert::optical(time, &names.frame, optical));
            Some(std::iter::once(mount).chain(optical))
        });
        let fixed = links.chain(mounts.flatten()).collect();
        let description = ros::Text { data: description::urdf(def, &space) };
        let topic = space.topic("robot_description");
        let def = def.clone();
        self.robots
            .insert(robot, Robot { space, def, controller, sensors, odometer: None, fixed, depths: BTreeMap::new() });
        // Whoever comes late gets the last message alone, so it has the transforms of all robots.
        let transforms = self.robots.values().flat_map(|robot| robot.fixed.iter().cloned()).collect();
        sink.publish(time, "/tf_static", &ros::TFMessage { transforms })?;
        sink.publish(time, &topic, &description)
    }

    /// Forgets a robot that has left.
    pub fn leave(&mut self, robot: u64) {
        self.spaces.leave(robot);
        self.robots.remove(&robot);
    }

    /// Publishes the state of a robot, but for its transforms, which wait. Nothing happens for a robot that has not come.
    ///
    /// # Errors
    /// When the sink fails.
    pub fn publish_state<S: Sink>(
        &mut self,
        time: f64,
        robot: u64,
        state: &State,
        sink: &mut S,
    ) -> Result<(), S::Error> {
        let Some(Robot { space, def, controller, odometer, .. }) = self.robots.get_mut(&robot) else { return Ok(()) };
        let controller = controller.as_ref();
        let odometer = odometer.get_or_insert_with(|| Odometer::new(def, controller, state.pose));
        let moved = odometer.moved(time, state);
        let (odom, base) = (&space.odom, &space.base);
        if self.is_localised {
            let beginning = state.pose * moved.pose.inverse();
            self.transforms.push(convert::transform(time, MAP, odom, &beginning));
        }
        if controller.is_none_or(|controller| controller.publishes_transform) {
            self.transforms.push(convert::transform(time, odom, base, &moved.pose));
        }
        let placed = def.placed_links(state.joints);
        for (number, (link, pose)) in placed.iter().enumerate() {
            let Some(joint) = link.joint.as_ref().filter(|joint| moves(joint.kind)) else { continue };
            let Some((_, parent)) = placed.get(joint.parent) else { continue };
            let frame = |link| description::frame(def, link, space);
            let transform = convert::transform(time, &frame(joint.parent), &frame(number), &(parent.inverse() * pose));
            self.transforms.push(transform);
        }
        let own = state.pose.rotation.inverse();
        let truth = Moved { pose: state.pose, linear: own * state.linear, angular: own * state.angular };
        let variances = controller.map_or([VARIANCES; 2], |controller| controller.variances);
        let message = odometry(header(time, odom), base, &moved, variances);
        sink.publish(time, &space.topic("odom"), &message)?;
        if let Some(controller) = controller {
            let [_, topic] = controller.topics();
            sink.publish(time, &space.topic(&topic), &message)?;
        }
        sink.publish(time, &space.topic("ground_truth"), &odometry(header(time, MAP), base, &truth, [[0.0; 6]; 2]))?;
        let joints = ros::JointState {
            header: header(time, base),
            name: def.with_values().map(|link| name(&link.name)).collect(),
            position: state.joints.iter().map(|joint| joint.position).collect(),
            velocity: state.joints.iter().map(|joint| joint.speed).collect(),
            effort: Vec::new(),
        };
        sink.publish(time, &space.topic("joint_states"), &joints)
    }

    /// Adds the transform of a movable object by its number.
    pub fn place_object(&mut self, time: f64, object: u64, pose: &Pose) {
        self.transforms.push(convert::transform(time, MAP, &format!("object_{object}"), pose));
    }

    /// Publishes the transforms that wait, as one message.
    ///
    /// # Errors
    /// When the sink fails.
    pub fn publish_transforms<S: Sink>(&mut self, time: f64, sink: &mut S) -> Result<(), S::Error> {
        let transforms = std::mem::take(&mut self.transforms);
        if transforms.is_empty() { Ok(()) } else { sink.publish(time, "/tf", &ros::TFMessage { transforms }) }
    }

    /// Publishes how much a robot's battery has left, s.
    ///
    /// # Errors
    /// When the sink fails.
    pub fn publish_battery<S: Sink>(&mut self, time: f64, robot: u64, left: f64, sink: &mut S) -> Result<(), S::Error> {
        let Some(Robot { space, def, .. }) = self.robots.get(&robot) else { return Ok(()) };
        let Some(battery) = def.battery else { return Ok(()) };
        // NaN is a number that is not measured.
        let unmeasured = f32::NAN;
        let state = ros::BatteryState {
            header: header(time, &space.base),
            voltage: unmeasured,
            temperature: unmeasured,
            current: unmeasured,
            charge: unmeasured,
            capacity: unmeasured,
            design_capacity: unmeasured,
            percentage: (left / battery.life).clamp(0.0, 1.0) as f32,
            power_supply_status: DISCHARGING,
            present: true,
            ..ros::BatteryState::default()
        };
        sink.publish(time, &space.topic("battery_state"), &state)
    }

    /// Returns the topics of a camera's pictures and of its numbers, and its optical frame.
    pub fn camera(&self, robot: u64, sensor: usize) -> Option<[String; 3]> {
        let robot = self.robots.get(&robot)?;
        let names = robot.sensors.get(sensor)?;
        let Some((Config::Camera(_), optical)) =
            robot.def.sensors.get(sensor).map(|sensor| &sensor.config).zip(names.optical.as_ref())
        else {
            return None;
        };
        Some([format!("{}/compressed", names.topic), names.beside("camera_info"), optical.clone()])
    }

    /// Publishes a reading of a sensor, if ROS has a message for it. Pictures of cameras are drawn elsewhere.
    ///
    /// # Errors
    /// When the sink fails.
    pub fn publish_reading<S: Sink>(&mut self, time: f64, sensed: &Sensed, sink: &mut S) -> Result<(), S::Error> {
        let Some(Robot { space, def, sensors, depths, .. }) = self.robots.get_mut(&sensed.robot.0) else {
            return Ok(());
        };
        let Some((sensor, names)) = def.sensors.get(sensed.sensor).zip(sensors.get(sensed.sensor)) else {
            return Ok(());
        };
        let topic = names.topic.as_str();
        let header = header(time, &names.frame);
        match (&sensed.reading, &sensor.config) {
            (Reading::RangeScanner(scan), config) => match config.fan().filter(|fan| fan.level) {
                Some(fan) => {
                    sink.publish(time, topic, &convert::laser(header, &scan.ranges, sensor.scan_interval, fan))
                }
                None => Ok(()),
            },
            (Reading::Sonar(sonar), Config::Sonar(config)) => {
                let limits = [config.min_range, config.max_range];
                let message = convert::range(header, ros::ULTRASOUND, config.beam_angle, limits, sonar.range);
                sink.publish(time, topic, &message)
            }
            (Reading::Infrared(beam), Config::Infrared(config)) => {
                let limits = [config.min_range, config.max_range];
                sink.publish(time, topic, &convert::range(header, ros::INFRARED, 0.0, limits, beam.range))
            }
            (Reading::Ins(ins), _) => sink.publish(time, topic, &convert::orientation(header, ins.angles)),
            (Reading::Imu(reading), _) => {
                sink.publish(time, topic, &convert::imu(header, sensor, reading, self.gravity))
            }
            (Reading::Gps(gps), Config::Gps(config)) => {
                let is_fix = gps.satellites >= SATELLITES;
                // The settings are three times the standard deviation.
                let variance = (config.max_noise / 3.0).powi(2);
                let mut message = ros::NavSatFix {
                    header,
                    status: ros::NavSatStatus { status: FIX[usize::from(is_fix)], service: GPS },
                    latitude: gps.latitude,
                    longitude: gps.longitude,
                    altitude: f64::NAN,
                    position_covariance_type: DIAGONAL_KNOWN,
                    ..ros::NavSatFix::default()
                };
                (0..3).for_each(|axis| message.position_covariance[axis][axis] = variance);
                sink.publish(time, topic, &message)
            }
            (Reading::Odometry(reading), _) => {
                let moved = Moved {
                    pose: scene::pose([reading.x, reading.y, 0.0], [0.0, 0.0, reading.theta]),
                    linear: Vector3::zeros(),
                    angular: Vector3::zeros(),
                };
                let frame = convert::header(time, &format!("{}_start", names.frame));
                let mut message = odometry(frame, &space.base, &moved, [VARIANCES; 2]);
                message.twist.covariance[0][0] = convert::NOT_MEASURED;
                sink.publish(time, topic, &message)
            }
            (Reading::PointCloud(reading), _) => {
                let points = reading.points.chunks_exact(3).filter_map(|point| point.try_into().ok());
                sink.publish(time, topic, &convert::cloud(header, points))
            }
            (Reading::RangeScanner3D(rows), Config::RangeScanner3D(config)) => {
                let points = convert::hits(config, &rows.ranges);
                sink.publish(time, topic, &convert::cloud(header, points.into_iter()))
            }
            (Reading::LineLaser(line), _) => {
                sink.publish(time, topic, &convert::cloud(header, convert::line(line).into_iter()))
            }
            (Reading::KinectDepth(part), Config::KinectDepth(config)) => {
                let Some(optical) = names.optical.as_ref().filter(|_| part.frames > 0.0) else { return Ok(()) };
                let rows = depths.entry(sensed.sensor).or_default();
                if part.frame == 0.0 {
                    rows.clear();
                }
                let whole = (kinect_depth::COLUMNS * kinect_depth::ROWS) as usize;
                rows.extend(part.depths.iter().map(|depth| *depth as f32).take(whole.saturating_sub(rows.len())));
                if rows.len() < whole || part.frame + 1.0 < part.frames {
                    return Ok(());
                }
                let header = convert::header(time, optical);
                let size = [kinect_depth::COLUMNS, kinect_depth::ROWS];
                let [angle, _] = kinect_depth::FIELD_OF_VIEW;
                let info = camera_info(header.clone(), size, angle);
                sink.publish(time, &names.beside("camera_info"), &info)?;
                sink.publish(time, topic, &convert::depth(header, rows, config.max_range))
            }
            // The rest of the state has their content.
            (Reading::GroundTruth(_) | Reading::Encoder(_) | Reading::Tachometer(_), _) => Ok(()),
            // Readings of a sonar and the like are of such sensors. ROS 2 has no message for the others.
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

/// True if one number places a link of such a joint, and it changes.
fn moves(kind: JointKind) -> bool {
    matches!(kind, JointKind::Revolute | JointKind::Continuous | JointKind::Prismatic)
}

/// Makes a message about a robot's frame in another one, with these variances of pose and twist.
fn odometry(header: ros::Header, base: &str, moved: &Moved, variances: [[f64; 6]; 2]) -> ros::Odometry {
    let [of_pose, of_twist] = variances.map(|variances| {
        let mut covariance = [[0.0; 6]; 6];
        for (axis, variance) in variances.into_iter().enumerate() {
            covariance[axis][axis] = variance;
        }
        covariance
    });
    let (linear, angular) = (convert::vector(moved.linear), convert::vector(moved.angular));
    ros::Odometry {
        header,
        child_frame_id: base.to_owned(),
        pose: ros::PoseWithCovariance { pose: pose(&moved.pose), covariance: of_pose },
        twist: ros::TwistWithCovariance { twist: ros::Twist { linear, angular }, covariance: of_twist },
    }
}
