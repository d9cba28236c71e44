//! Between the world's f64 and the engine's f32.

use nalgebra::{Quaternion, Translation3, UnitQuaternion, Vector3};
use rapier3d::glamx::{Pose3, Quat, Vec3};

use crate::scene::Pose;

pub(super) fn vector(value: impl Into<[f64; 3]>) -> Vec3 {
    Vec3::from_array(value.into().map(|component| component as f32))
}

pub(super) fn from_vector(value: Vec3) -> Vector3<f64> {
    Vector3::from(value.to_array().map(f64::from))
}

pub(super) fn pose(value: &Pose) -> Pose3 {
    let [x, y, z, w] = value.rotation.coords.map(|component| component as f32).into();
    Pose3::from_parts(vector(value.translation.vector), Quat::from_xyzw(x, y, z, w))
}

pub(super) fn from_pose(value: &Pose3) -> Pose {
    let [x, y, z, w] = value.rotation.to_array().map(f64::from);
    let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    Pose::from_parts(Translation3::from(from_vector(value.translation)), rotation)
}
