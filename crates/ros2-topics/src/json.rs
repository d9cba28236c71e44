//! JSON of messages, as rosbridge has them: bytes in base64, matrices as one row after the other, and `null` for what is not finite.

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

pub use serde_json::Error;

/// Writes a message.
///
/// # Errors
/// When a key of a map is no text. Messages have no maps.
pub fn write(message: &impl Serialize) -> Result<Value, Error> {
    serde_json::to_value(message).map(flat)
}

/// Reads a message. Fields that are left out have their defaults, as in ROS.
///
/// # Errors
/// When the text is no such message, or has a field that the message has not.
pub fn read<T: DeserializeOwned>(text: &str) -> Result<T, Error> {
    serde_json::from_str(text)
}

/// Puts the rows of a matrix into one. ROS has no lists of lists, so each is a matrix.
fn flat(value: Value) -> Value {
    match value {
        Value::Array(list) => list
            .into_iter()
            .flat_map(|item| match flat(item) {
                Value::Array(row) => row,
                item => vec![item],
            })
            .collect(),
        Value::Object(fields) => fields.into_iter().map(|(name, field)| (name, flat(field))).collect(),
        value => value,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interfaces::{Bytes, CompressedImage, LaserScan, PoseWithCovariance, Twist, TwistStamped, Vector3};

    #[test]
    fn messages_are_as_rosbridge_has_them() {
        let mut pose = PoseWithCovariance::default();
        pose.covariance[1][0] = 2.0;
        let pose = write(&pose).expect("JSON");
        let covariance = pose["covariance"].as_array().expect("a list");
        assert_eq!((covariance.len(), covariance[6].as_f64()), (36, Some(2.0)));
        let picture = CompressedImage { data: Bytes(vec![1, 2, 255]), ..CompressedImage::default() };
        assert_eq!(write(&picture).expect("JSON")["data"], "AQL/");
        let scan = LaserScan { ranges: vec![1.5, f32::INFINITY], ..LaserScan::default() };
        assert_eq!(write(&scan).expect("JSON")["ranges"].to_string(), "[1.5,null]");
    }

    #[test]
    fn fields_have_defaults_and_strangers_are_refused() {
        let twist = Twist { linear: Vector3 { x: 0.5, ..Vector3::default() }, ..Twist::default() };
        assert_eq!(read::<Twist>(r#"{"linear": {"x": 0.5}}"#).expect("a Twist"), twist);
        assert!(read::<TwistStamped>(r#"{"linear": {"x": 0.5}}"#).is_err());
        assert_eq!(read::<TwistStamped>(r#"{"twist": {"linear": {"x": 0.5}}}"#).expect("stamped").twist, twist);
    }
}
