//! Batches of worlds with orders and observations in two arrays.

use environments::{BatchError, Column, WorldBatch};
use numpy::{PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PySlice;

use crate::arguments::{contiguous, pool};
use crate::error;
use crate::world::World;

/// Copies of a world that are stepped together.
#[pyclass(module = "usarsim")]
pub(crate) struct Batch {
    batch: WorldBatch,
    observations: Py<PyArray2<f64>>,
}

#[pymethods]
impl Batch {
    #[new]
    #[pyo3(signature = (world, count, *, orders = "wheels", observations = vec!["position".to_owned(), "orientation".to_owned(), "velocity".to_owned(), "angular_velocity".to_owned()], threads = 0))]
    fn new(
        py: Python,
        world: PyRef<World>,
        count: usize,
        orders: &str,
        observations: Vec<String>,
        threads: usize,
    ) -> PyResult<Self> {
        let threads = pool(threads)?;
        let orders = orders.parse().map_err(error::task)?;
        let columns = observations.iter().map(|name| name.parse()).collect::<Result<Vec<Column>, BatchError>>();
        let (columns, world) = (columns.map_err(error::task)?, world.world());
        let batch = py.detach(|| WorldBatch::new(world, count, orders, columns, threads)).map_err(error::task)?;
        let observations = PyArray2::zeros(py, [count, batch.observation_width()], false);
        let mut batch = Self { batch, observations: observations.unbind() };
        batch.reset(py, None)?;
        Ok(batch)
    }

    /// Gives every world its row of orders, advances each by `steps` time steps, and returns the observations: the same array each time.
    #[pyo3(signature = (orders, steps = 1))]
    fn step(&mut self, py: Python, orders: PyReadonlyArray2<f64>, steps: u32) -> PyResult<Py<PyArray2<f64>>> {
        let Self { batch, observations } = self;
        check_rows("orders", &orders, [batch.worlds(), batch.order_width()])?;
        let orders = orders.as_slice().map_err(|_| contiguous("orders"))?;
        let mut written = observations.bind(py).try_readwrite().map_err(error::task)?;
        let rows = written.as_slice_mut().map_err(|_| contiguous("observations"))?;
        py.detach(|| batch.step(orders, steps, rows)).map_err(error::task)?;
        Ok(observations.clone_ref(py))
    }

    /// Puts worlds back to the state that they were copied from: those that `mask` marks, or all. Returns the observations.
    #[pyo3(signature = (mask = None))]
    fn reset(&mut self, py: Python, mask: Option<PyReadonlyArray1<bool>>) -> PyResult<Py<PyArray2<f64>>> {
        let Self { batch, observations } = self;
        let mask = mask.as_ref().map(|mask| mask.as_slice().map_err(|_| contiguous("mask"))).transpose()?;
        let mut written = observations.bind(py).try_readwrite().map_err(error::task)?;
        let rows = written.as_slice_mut().map_err(|_| contiguous("observations"))?;
        py.detach(|| batch.reset(mask, rows)).map_err(error::task)?;
        Ok(observations.clone_ref(py))
    }

    /// Observations after the last step: one array for the whole life of the batch, a row a world.
    #[getter]
    fn observations(&self, py: Python) -> Py<PyArray2<f64>> {
        self.observations.clone_ref(py)
    }

    /// Columns of the observations: number of the robot, name of the group, first column, column after the last.
    #[getter]
    fn columns(&self) -> Vec<(usize, String, usize, usize)> {
        let layout = self.batch.layout().into_iter();
        layout.map(|(robot, column, range)| (robot, column.to_string(), range.start, range.end)).collect()
    }

    /// Number of orders in a row.
    #[getter]
    fn order_width(&self) -> usize {
        self.batch.order_width()
    }

    /// Returns the columns of a group of observations.
    #[pyo3(signature = (name, robot = 0))]
    fn column<'py>(&self, py: Python<'py>, name: &str, robot: usize) -> PyResult<Bound<'py, PySlice>> {
        let group: Column = name.parse().map_err(error::task)?;
        let known = self.batch.layout().into_iter().find(|(number, column, _)| (*number, column) == (robot, &group));
        let Some((_, _, range)) = known else {
            return Err(error::task(format_args!("robot {robot} has no observations `{name}` in this batch")));
        };
        Ok(PySlice::new(py, range.start as isize, range.end as isize, 1))
    }

    /// Returns a copy of a world.
    fn world(&self, number: usize) -> PyResult<World> {
        let Some(world) = self.batch.world(number) else {
            let count = self.batch.worlds();
            return Err(error::task(format_args!("world: got {number}, expected less than {count}")));
        };
        let mut world = world.clone();
        world.set_reporting(true);
        World::of(world, pool(1)?).map_err(error::log)
    }

    /// Hashes of the bits of every body, a world each.
    #[getter]
    fn digests(&self) -> Vec<String> {
        let worlds = (0..self.batch.worlds()).filter_map(|number| self.batch.world(number));
        worlds.map(|world| format!("{:016x}", world.digest())).collect()
    }

    fn __len__(&self) -> usize {
        self.batch.worlds()
    }

    fn __repr__(&self) -> String {
        let [orders, observations] = [self.batch.order_width(), self.batch.observation_width()];
        format!("Batch({} worlds, {orders} orders, {observations} observations each)", self.batch.worlds())
    }
}

/// Checks the shape of an array, and that its rows are one after the other.
pub(crate) fn check_rows<T: numpy::Element>(
    name: &str,
    array: &Bound<PyArray2<T>>,
    expected: [usize; 2],
) -> PyResult<()> {
    let got = array.shape();
    if got != expected {
        return Err(error::task(format_args!("{name}: got an array of shape {got:?}, expected {expected:?}")));
    }
    array.is_c_contiguous().then_some(()).ok_or_else(|| contiguous(name))
}
