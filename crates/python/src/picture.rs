//! Pictures as arrays.

use ::picture::{Camera, FIELD_OF_VIEW, Image, Stage};
use nalgebra::{Point3, Vector3};
use numpy::{IntoPyArray, PyArrayMethods, PyReadonlyArray3, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::arguments::contiguous;
use crate::error;

/// Draws a world. Without an eye, the camera looks at the robots, or else at the whole map, from behind and above.
pub(crate) fn draw(
    stage: &Stage,
    world: &sim_core::World,
    size: [usize; 2],
    eye: Option<[f64; 3]>,
    target: Option<[f64; 3]>,
) -> Image {
    let (def, snapshot) = (world.def(), world.snapshot());
    let robots = snapshot.robots.iter().flat_map(|robot| stage.corners_of(def, &snapshot, robot));
    let mut places: Vec<Point3<f64>> = robots.collect();
    if places.is_empty() {
        places = ::picture::corners_of_map(&def.map);
    }
    let ahead = Vector3::new(0.75, 0.6, 0.65);
    let fitted = Camera::fitting(&places, ahead, FIELD_OF_VIEW, size);
    let target = target.map_or(fitted.target, Point3::from);
    // Some floor around the robots.
    let eye = eye.map_or(target + (fitted.eye - fitted.target) * 1.6, Point3::from);
    let camera = Camera { eye, target, ..fitted };
    ::picture::picture(stage, def, &snapshot, &camera, size)
}

/// Returns an image as a `Picture`, an array of rows, columns and colours that a notebook shows.
pub(crate) fn array(py: Python, image: Image) -> PyResult<Bound<PyAny>> {
    let (height, width) = (image.height, image.width);
    let array = image.pixels.into_flattened().into_pyarray(py).reshape([height, width, 3])?;
    array.call_method1("view", (py.import("usarsim._picture")?.getattr("Picture")?,))
}

/// Returns an array of rows, columns and colours as a PNG file.
#[pyfunction]
pub(crate) fn _png<'py>(py: Python<'py>, picture: PyReadonlyArray3<u8>) -> PyResult<Bound<'py, PyBytes>> {
    let &[height, width, 3] = picture.shape() else {
        return Err(error::command(format_args!(
            "picture: got shape {:?}, expected rows, columns, 3",
            picture.shape()
        )));
    };
    let (pixels, _) = picture.as_slice().map_err(|_| contiguous("picture"))?.as_chunks::<3>();
    let image = Image { width, height, pixels: pixels.to_vec() };
    Ok(PyBytes::new(py, &image.to_png().map_err(error::command)?))
}
