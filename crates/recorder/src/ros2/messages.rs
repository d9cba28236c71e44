//! The messages of ROS 2 that a log needs. Names, types and order of fields follow the interfaces, and each is written once.

use byteorder::LittleEndian;
use foxglove::{Encode, Schema};
use prost::bytes::BufMut;
use serde::Serialize;

/// `radiation_type` of a sonar.
pub(super) const ULTRASOUND: u8 = 0;

/// Bytes before each message: plain CDR, little endian.
const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];

/// A ROS type with its definition and those of its nested types.
trait Interface {
    /// Its name, as in `geometry_msgs/Point`.
    const NAME: &'static str;
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
    u8 = "uint8", i32 = "int32", u32 = "uint32", f32 = "float32", f64 = "float64", String = "string",
    [[f64; 3]; 3] = "float64[9]", [[f64; 6]; 6] = "float64[36]",
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

macro_rules! interfaces {
    ($($package:literal $name:ident { $($field:ident: $type:ty,)* })*) => {$(
        #[derive(Debug, Clone, PartialEq, Default, Serialize)]
        pub(super) struct $name { $(pub(super) $field: $type,)* }

        impl Interface for $name {
            const NAME: &'static str = concat!($package, "/", stringify!($name));

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

        impl Encode for $name {
            type Error = cdr_encoding::Error;

            fn get_schema() -> Option<Schema> {
                let name = concat!($package, "/msg/", stringify!($name));
                Some(Schema::new(name, "ros2msg", definition::<Self>().into_bytes()))
            }

            fn get_message_encoding() -> String {
                "cdr".to_owned()
            }

            fn encode(&self, buffer: &mut impl BufMut) -> Result<(), Self::Error> {
                buffer.put_slice(&ENCAPSULATION);
                buffer.put_slice(&cdr_encoding::to_vec::<_, LittleEndian>(self)?);
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
    "builtin_interfaces" Time { sec: i32, nanosec: u32, }
    "std_msgs" Header { stamp: Time, frame_id: String, }
    "rosgraph_msgs" Clock { clock: Time, }
    "geometry_msgs" Vector3 { x: f64, y: f64, z: f64, }
    "geometry_msgs" Point { x: f64, y: f64, z: f64, }
    "geometry_msgs" Quaternion { x: f64, y: f64, z: f64, w: f64, }
    "geometry_msgs" Transform { translation: Vector3, rotation: Quaternion, }
    "geometry_msgs" TransformStamped { header: Header, child_frame_id: String, transform: Transform, }
    "tf2_msgs" TFMessage { transforms: Vec<TransformStamped>, }
    "geometry_msgs" Pose { position: Point, orientation: Quaternion, }
    "geometry_msgs" PoseWithCovariance { pose: Pose, covariance: [[f64; 6]; 6], }
    "geometry_msgs" Twist { linear: Vector3, angular: Vector3, }
    "geometry_msgs" TwistWithCovariance { twist: Twist, covariance: [[f64; 6]; 6], }
    "nav_msgs" Odometry { header: Header, child_frame_id: String, pose: PoseWithCovariance, twist: TwistWithCovariance, }
    "sensor_msgs" JointState {
        header: Header, name: Vec<String>, position: Vec<f64>, velocity: Vec<f64>, effort: Vec<f64>,
    }
    "sensor_msgs" LaserScan {
        header: Header, angle_min: f32, angle_max: f32, angle_increment: f32, time_increment: f32, scan_time: f32,
        range_min: f32, range_max: f32, ranges: Vec<f32>, intensities: Vec<f32>,
    }
    "sensor_msgs" Range {
        header: Header, radiation_type: u8, field_of_view: f32, min_range: f32, max_range: f32, range: f32,
    }
    "sensor_msgs" Imu {
        header: Header, orientation: Quaternion, orientation_covariance: [[f64; 3]; 3], angular_velocity: Vector3,
        angular_velocity_covariance: [[f64; 3]; 3], linear_acceleration: Vector3,
        linear_acceleration_covariance: [[f64; 3]; 3],
    }
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
