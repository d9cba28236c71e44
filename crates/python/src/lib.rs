//! The module `usarsim._native` of the Python package `usarsim`.
//!
//! Python's part of the package is in `python/usarsim`: it adds the environments of Gymnasium and PettingZoo, notebooks and Dask. Types
//! and docs for Python are in `_native.pyi` there.

mod arguments;
mod batch;
mod environments;
mod error;
mod object;
mod picture;
mod reading;
mod robot;
mod runs;
mod scene;
mod world;

use std::ffi::OsString;

use pyo3::prelude::*;

/// Runs the program `usarsim` and returns its exit code. Help and wrong arguments end the process.
#[pyfunction]
fn main(py: Python, arguments: Vec<OsString>) -> u8 {
    py.detach(|| usarsim::main(arguments))
}

#[pymodule]
fn _native(module: &Bound<PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<scene::Scene>()?;
    module.add_class::<world::World>()?;
    module.add_class::<robot::Robot>()?;
    module.add_class::<reading::Reading>()?;
    module.add_class::<object::MovableObject>()?;
    module.add_class::<batch::Batch>()?;
    module.add_class::<environments::Environments>()?;
    module.add_function(wrap_pyfunction!(main, module)?)?;
    module.add_function(wrap_pyfunction!(picture::_png, module)?)?;
    module.add_function(wrap_pyfunction!(scene::maps, module)?)?;
    module.add_function(wrap_pyfunction!(scene::scenarios, module)?)?;
    module.add_function(wrap_pyfunction!(scene::robots, module)?)?;
    module.add_function(wrap_pyfunction!(environments::tasks, module)?)?;
    module.add_function(wrap_pyfunction!(runs::replay, module)?)?;
    module.add_function(wrap_pyfunction!(runs::validate, module)?)?;
    module.add_function(wrap_pyfunction!(runs::run_experiment, module)?)?;
    module.add_function(wrap_pyfunction!(runs::fit, module)?)?;
    module.add_function(wrap_pyfunction!(runs::sweep_batches, module)?)?;
    module.add_function(wrap_pyfunction!(runs::sweep_batch, module)?)?;
    module.add_function(wrap_pyfunction!(runs::finish_sweep, module)?)?;
    error::add_to(module)
}
