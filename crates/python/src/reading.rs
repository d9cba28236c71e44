//! Readings of sensors.

use ::scene::Sensed;
use nalgebra::Vector3;
use numpy::{IntoPyArray, PyArray1};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyIterator, PyList};

/// A reading of a sensor: its quantities by name, as arrays.
#[pyclass(frozen, module = "usarsim")]
pub(crate) struct Reading {
    name: String,
    time: f64,
    sensed: Sensed,
}

impl Reading {
    pub(crate) fn new(name: &str, time: f64, sensed: &Sensed) -> Self {
        Self { name: name.to_owned(), time, sensed: sensed.clone() }
    }
}

#[pymethods]
impl Reading {
    /// Name of the sensor.
    #[getter]
    fn name(&self) -> &str {
        &self.name
    }

    /// Type of the sensor.
    #[getter]
    fn r#type(&self) -> &'static str {
        self.sensed.reading.type_name()
    }

    /// Simulated time, s.
    #[getter]
    fn time(&self) -> f64 {
        self.time
    }

    /// Units of the quantities by name.
    #[getter]
    fn units<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let units = PyDict::new(py);
        self.sensed.reading.quantities().iter().try_for_each(|it| units.set_item(it.name, it.unit))?;
        Ok(units)
    }

    /// Names of the quantities.
    fn keys(&self) -> Vec<&'static str> {
        self.sensed.reading.quantities().iter().map(|it| it.name).collect()
    }

    fn __len__(&self) -> usize {
        self.sensed.reading.quantities().len()
    }

    fn __contains__(&self, name: &str) -> bool {
        self.keys().contains(&name)
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyIterator>> {
        PyList::new(py, self.keys())?.try_iter()
    }

    fn __getitem__<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let found = self.sensed.reading.quantities().into_iter().find(|it| it.name == name);
        let missing =
            || pyo3::exceptions::PyKeyError::new_err(format!("{name}: expected one of {}", self.keys().join(", ")));
        Ok(found.ok_or_else(missing)?.values.into_pyarray(py))
    }

    fn __repr__(&self) -> String {
        format!("Reading({:?}, {}, time={:.3}, {})", self.name, self.r#type(), self.time, self.keys().join(", "))
    }
}

/// Returns a vector as an array.
pub(crate) fn vector(py: Python, vector: Vector3<f64>) -> Bound<PyArray1<f64>> {
    vector.as_slice().to_vec().into_pyarray(py)
}
