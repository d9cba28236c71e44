//! Exceptions, with the texts of the program's errors.

use std::fmt::Display;

use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyUserWarning};
use pyo3::prelude::*;

create_exception!(
    usarsim,
    Error,
    PyException,
    "An error of usarsim. Its text says what is wrong, where, and what is expected."
);
create_exception!(usarsim, SceneError, Error, "A map, a robot, an override or equipment does not load.");
create_exception!(usarsim, CommandError, Error, "A robot cannot do what it was told.");
create_exception!(usarsim, SaveError, Error, "A world cannot be saved, or go on from a saved state.");
create_exception!(usarsim, LogError, Error, "A log cannot be written, read or replayed.");
create_exception!(usarsim, TaskError, Error, "A task, an experiment or a fit cannot run.");
create_exception!(usarsim, UsarsimWarning, PyUserWarning, "Something was done in another way than asked for.");

pub(crate) fn add_to(module: &Bound<PyModule>) -> PyResult<()> {
    let py = module.py();
    module.add("Error", py.get_type::<Error>())?;
    module.add("SceneError", py.get_type::<SceneError>())?;
    module.add("CommandError", py.get_type::<CommandError>())?;
    module.add("SaveError", py.get_type::<SaveError>())?;
    module.add("LogError", py.get_type::<LogError>())?;
    module.add("TaskError", py.get_type::<TaskError>())?;
    module.add("UsarsimWarning", py.get_type::<UsarsimWarning>())
}

pub(crate) fn scene(error: impl Display) -> PyErr {
    SceneError::new_err(error.to_string())
}

pub(crate) fn command(error: impl Display) -> PyErr {
    CommandError::new_err(error.to_string())
}

pub(crate) fn save(error: impl Display) -> PyErr {
    SaveError::new_err(error.to_string())
}

pub(crate) fn log(error: impl Display) -> PyErr {
    LogError::new_err(error.to_string())
}

pub(crate) fn task(error: impl Display) -> PyErr {
    TaskError::new_err(error.to_string())
}
