//! Movable objects of a world.

use ::scene::{ObjectSnapshot, Pose};
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;

use crate::reading::vector;

/// A movable object at one moment.
#[pyclass(frozen, name = "Object", module = "usarsim")]
pub(crate) struct MovableObject {
    #[pyo3(get)]
    id: u64,
    #[pyo3(get)]
    name: String,
    #[pyo3(get)]
    mass: f64,
    pose: Pose,
}

impl From<ObjectSnapshot> for MovableObject {
    fn from(object: ObjectSnapshot) -> Self {
        Self { id: object.id.0, name: object.def.solid.name.clone(), mass: object.def.mass, pose: object.pose }
    }
}

#[pymethods]
impl MovableObject {
    /// Position, m.
    #[getter]
    fn position<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        vector(py, self.pose.translation.vector)
    }

    /// Orientation as a quaternion x, y, z, w.
    #[getter]
    fn orientation<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        self.pose.rotation.coords.as_slice().to_vec().into_pyarray(py)
    }

    fn __repr__(&self) -> String {
        let [x, y, z] = self.pose.translation.vector.into();
        format!("Object({:?}, position=[{x:.3}, {y:.3}, {z:.3}])", self.name)
    }
}
