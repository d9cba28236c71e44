//! Conversions between nalgebra's types, which the world uses, and the engine's.

use nalgebra::{Quaternion, Translation3, UnitQuaternion, Vector3};
use rapier3d::dynamics::MassProperties;
use rapier3d::math::{Matrix, Pose as EnginePose, Rotation, Vector};
use scene::{Mass, Pose};

pub(super) fn vector(value: impl Into<[f64; 3]>) -> Vector {
    Vector::from_array(value.into())
}

pub(super) fn from_vector(value: Vector) -> Vector3<f64> {
    Vector3::from(value.to_array())
}

pub(super) fn pose(value: &Pose) -> EnginePose {
    let [x, y, z, w] = value.rotation.coords.into();
    EnginePose::from_parts(vector(value.translation.vector), Rotation::from_xyzw(x, y, z, w))
}

pub(super) fn from_pose(value: &EnginePose) -> Pose {
    let [x, y, z, w] = value.rotation.to_array();
    let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    Pose::from_parts(Translation3::from(from_vector(value.translation)), rotation)
}

/// Converts the mass of a body whose frame is along its principal axes.
pub(super) fn principal_mass(value: &Mass) -> MassProperties {
    MassProperties::new(vector(value.centre), value.mass, vector(value.inertia.diagonal()))
}

pub(super) fn mass(value: &Mass) -> MassProperties {
    let inertia = Matrix::from_cols_array_2d(&value.inertia.into());
    MassProperties::with_inertia_matrix(vector(value.centre), value.mass, inertia)
}
