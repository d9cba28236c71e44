//! Messages of ROS 2. Names, types and order of fields follow the interfaces of Jazzy and later, and each is written once. Their meaning is
//! documented there.

#![expect(missing_docs, reason = "the interfaces of ROS document their fields")]

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use foxglove::{Encode, Schema};
use prost::bytes::BufMut;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize, Serializer};

use crate::cdr;

/// `radiation_type` of a sonar (sensor_msgs/msg/Range).
pub(crate) const ULTRASOUND: u8 = 0;
/// `radiation_type` of a beam of light.
pub(crate) const INFRARED: u8 = 1;
/// Bytes before each message: plain CDR, little endian.
const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];

/// A message of ROS 2.
pub trait Message: Encode + Serialize + DeserializeOwned {
    /// Its name, as in `geometry_msgs/Point`.
    const NAME: &'static str;

    /// Returns its name in DDS, as in `geometry_msgs::msg::dds_::Point_`.
    fn dds_name() -> String {
        let (package, name) = Self::NAME.split_once('/').unwrap_or_default();
        format!("{package}::msg::dds_::{name}_")
    }
}

/// A message with its definition and those of its nested types.
trait Interface: Message {
    /// Returns its fields, one per line.
    fn fields() -> String;
    /// Adds its definition and those of its nested types to a list, each once.
    fn collect(list: &mut Vec<(&'static str, String)>);
}

/// The spelling of a Rust type in a definition.
trait Spelled {
    fn spelled() -> String;
    fn collect(_list: &mut Vec<(&'static str, String)>) {}
}

macro_rules! spelled {
    ($($rust:ty = $ros:literal,)*) => {$(
        impl Spelled for $rust {
            fn spelled() -> String { $ros.to_owned() }
        }
    )*};
}

spelled! {
    bool = "bool", i8 = "int8", u8 = "uint8", u16 = "uint16", i32 = "int32", u32 = "uint32", u64 = "uint64", f32 = "float32", f64 = "float64",
    String = "string", [[f64; 3]; 3] = "float64[9]", [[f64; 4]; 3] = "float64[12]", [[f64; 6]; 6] = "float64[36]",
}

impl<T: Spelled> Spelled for Vec<T> {
    fn spelled() -> String {
        format!("{}[]", T::spelled())
    }

    fn collect(list: &mut Vec<(&'static str, String)>) {
        T::collect(list);
    }
}

impl<T: Interface> Spelled for T {
    fn spelled() -> String {
        T::NAME.to_owned()
    }

    fn collect(list: &mut Vec<(&'static str, String)>) {
        <T as Interface>::collect(list);
    }
}

/// Bytes of a picture or a cloud: `uint8[]`. In JSON they are base64, as rosbridge has them.
#[derive(Debug, Clone, PartialEq, Eq, Default, Deserialize)]
#[serde(transparent)]
pub struct Bytes(pub Vec<u8>);

impl Serialize for Bytes {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match serializer.is_human_readable() {
            true => serializer.serialize_str(&BASE64_STANDARD.encode(&self.0)),
            false => self.0.serialize(serializer),
        }
    }
}

impl Spelled for Bytes {
    fn spelled() -> String {
        Vec::<u8>::spelled()
    }
}

macro_rules! interfaces {
    ($($ros:literal $name:ident { $($field:ident: $type:ty,)* })*) => {$(
        #[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct $name { $(pub $field: $type,)* }

        impl Interface for $name {
            fn fields() -> String {
                [$(format!("{} {}\n", <$type as Spelled>::spelled(), stringify!($field))),*].concat()
            }

            fn collect(list: &mut Vec<(&'static str, String)>) {
                if list.iter().all(|(name, _)| *name != Self::NAME) {
                    list.push((Self::NAME, Self::fields()));
                    $(<$type as Spelled>::collect(list);)*
                }
            }
        }

        impl Message for $name {
            const NAME: &'static str = $ros;
        }

        impl Encode for $name {
            type Error = cdr::Error;

            fn get_schema() -> Option<Schema> {
                let name = Self::NAME.replace('/', "/msg/");
                Some(Schema::new(name, "ros2msg", definition::<Self>().into_bytes()))
            }

            fn get_message_encoding() -> String {
                "cdr".to_owned()
            }

            fn encode(&self, buffer: &mut impl BufMut) -> Result<(), Self::Error> {
                buffer.put_slice(&ENCAPSULATION);
                buffer.put_slice(&cdr::write(self)?);
                Ok(())
            }
        }
    )*};
}

/// Returns the fields of a message, then those of every nested type, as MCAP's `ros2msg` requires.
fn definition<T: Interface>() -> String {
    let mut types = Vec::new();
    <T as Interface>::collect(&mut types);
    let separator = "=".repeat(80);
    let within = types.iter().skip(1).map(|(name, fields)| format!("{separator}\nMSG: {name}\n{fields}"));
    std::iter::once(T::fields()).chain(within).collect()
}

interfaces! {
    "builtin_interfaces/Time" Time { sec: i32, nanosec: u32, }
    "std_msgs/Header" Header { stamp: Time, frame_id: String, }
    "rosgraph_msgs/Clock" Clock { clock: Time, }
    "geometry_msgs/Vector3" Vector3 { x: f64, y: f64, z: f64, }
    "geometry_msgs/Point" Point { x: f64, y: f64, z: f64, }
    "geometry_msgs/Quaternion" Quaternion { x: f64, y: f64, z: f64, w: f64, }
    "geometry_msgs/Transform" Transform { translation: Vector3, rotation: Quaternion, }
    "geometry_msgs/TransformStamped" TransformStamped { header: Header, child_frame_id: String, transform: Transform, }
    "tf2_msgs/TFMessage" TFMessage { transforms: Vec<TransformStamped>, }
    "geometry_msgs/Pose" Pose { position: Point, orientation: Quaternion, }
    "geometry_msgs/PoseWithCovariance" PoseWithCovariance { pose: Pose, covariance: [[f64; 6]; 6], }
    "geometry_msgs/Twist" Twist { linear: Vector3, angular: Vector3, }
    "geometry_msgs/TwistWithCovariance" TwistWithCovariance { twist: Twist, covariance: [[f64; 6]; 6], }
    "nav_msgs/Odometry" Odometry { header: Header, child_frame_id: String, pose: PoseWithCovariance, twist: TwistWithCovariance, }
    "sensor_msgs/JointState" JointState {
        header: Header, name: Vec<String>, position: Vec<f64>, velocity: Vec<f64>, effort: Vec<f64>,
    }
    "sensor_msgs/LaserScan" LaserScan {
        header: Header, angle_min: f32, angle_max: f32, angle_increment: f32, time_increment: f32, scan_time: f32,
        range_min: f32, range_max: f32, ranges: Vec<f32>, intensities: Vec<f32>,
    }
    "sensor_msgs/Range" Range {
        header: Header, radiation_type: u8, field_of_view: f32, min_range: f32, max_range: f32, range: f32,
        variance: f32,
    }
    "sensor_msgs/Imu" Imu {
        header: Header, orientation: Quaternion, orientation_covariance: [[f64; 3]; 3], angular_velocity: Vector3,
        angular_velocity_covariance: [[f64; 3]; 3], linear_acceleration: Vector3,
        linear_acceleration_covariance: [[f64; 3]; 3],
    }
    "sensor_msgs/CompressedImage" CompressedImage { header: Header, format: String, data: Bytes, }
    "sensor_msgs/Image" Image {
        header: Header, height: u32, width: u32, encoding: String, is_bigendian: u8, step: u32, data: Bytes,
    }
    "sensor_msgs/RegionOfInterest" RegionOfInterest { x_offset: u32, y_offset: u32, height: u32, width: u32, do_rectify: bool, }
    "sensor_msgs/CameraInfo" CameraInfo {
        header: Header, height: u32, width: u32, distortion_model: String, d: Vec<f64>, k: [[f64; 3]; 3],
        r: [[f64; 3]; 3], p: [[f64; 4]; 3], binning_x: u32, binning_y: u32, roi: RegionOfInterest,
    }
    "sensor_msgs/PointField" PointField { name: String, offset: u32, datatype: u8, count: u32, }
    "sensor_msgs/PointCloud2" PointCloud2 {
        header: Header, height: u32, width: u32, fields: Vec<PointField>, is_bigendian: bool, point_step: u32,
        row_step: u32, data: Bytes, is_dense: bool,
    }
    "sensor_msgs/NavSatStatus" NavSatStatus { status: i8, service: u16, }
    "sensor_msgs/NavSatFix" NavSatFix {
        header: Header, status: NavSatStatus, latitude: f64, longitude: f64, altitude: f64,
        position_covariance: [[f64; 3]; 3], position_covariance_type: u8,
    }
    "sensor_msgs/BatteryState" BatteryState {
        header: Header, voltage: f32, temperature: f32, current: f32, charge: f32, capacity: f32, design_capacity: f32,
        percentage: f32, power_supply_status: u8, power_supply_health: u8, power_supply_technology: u8, present: bool,
        cell_voltage: Vec<f32>, cell_temperature: Vec<f32>, location: String, serial_number: String,
    }
    "diagnostic_msgs/KeyValue" KeyValue { key: String, value: String, }
    "diagnostic_msgs/DiagnosticStatus" DiagnosticStatus {
        level: u8, name: String, message: String, hardware_id: String, values: Vec<KeyValue>,
    }
    "diagnostic_msgs/DiagnosticArray" DiagnosticArray { header: Header, status: Vec<DiagnosticStatus>, }
    "std_msgs/String" Text { data: String, }
    "std_msgs/Bool" Bool { data: bool, }
    "std_msgs/MultiArrayDimension" MultiArrayDimension { label: String, size: u32, stride: u32, }
    "std_msgs/MultiArrayLayout" MultiArrayLayout { dim: Vec<MultiArrayDimension>, data_offset: u32, }
    "std_msgs/Float64MultiArray" Float64MultiArray { layout: MultiArrayLayout, data: Vec<f64>, }
    "geometry_msgs/PoseStamped" PoseStamped { header: Header, pose: Pose, }
    "geometry_msgs/TwistStamped" TwistStamped { header: Header, twist: Twist, }
    "builtin_interfaces/Duration" Duration { sec: i32, nanosec: u32, }
    "trajectory_msgs/JointTrajectoryPoint" JointTrajectoryPoint {
        positions: Vec<f64>, velocities: Vec<f64>, accelerations: Vec<f64>, effort: Vec<f64>, time_from_start: Duration,
    }
    "trajectory_msgs/JointTrajectory" JointTrajectory { header: Header, joint_names: Vec<String>, points: Vec<JointTrajectoryPoint>, }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_definition_names_each_type_within_once() {
        let rule = "=".repeat(80);
        let expected = format!(
            "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform\n{rule}\n\
             MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n{rule}\n\
             MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n{rule}\n\
             MSG: geometry_msgs/Transform\ngeometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation\n{rule}\n\
             MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z\n{rule}\n\
             MSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w\n"
        );
        assert_eq!(definition::<TransformStamped>(), expected);
    }

    #[test]
    fn a_message_is_plain_little_endian_cdr() {
        let mut bytes = Vec::new();
        let header = Header { stamp: Time { sec: 1, nanosec: 2 }, frame_id: "map".to_owned() };
        header.encode(&mut bytes).unwrap();
        assert_eq!(bytes, [0, 1, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 4, 0, 0, 0, b'm', b'a', b'p', 0]);
    }
}
