//! Scenes: a map and classes of robots, loaded from names and files.

use std::path::PathBuf;

use ::scene::{DriveModel, WorldDef};
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use scene_loader::{Changes, Equipment, Override};
use sim_core::CompiledScene;

use crate::error;

/// Map of a scene that is told none.
const DEFAULT_MAP: &str = "hall";

/// Returns the names of the shipped maps.
#[pyfunction]
pub(crate) fn maps() -> Vec<String> {
    scene_loader::map_names()
}

/// Returns the names of the shipped robot classes.
#[pyfunction]
pub(crate) fn robots() -> Vec<String> {
    scene_loader::robot_names()
}

/// Returns the names of the shipped scenarios.
#[pyfunction]
pub(crate) fn scenarios() -> Vec<String> {
    scene_loader::scenario_names()
}

/// A map with classes of robots. Worlds share it.
#[pyclass(frozen, module = "usarsim")]
pub(crate) struct Scene {
    pub(crate) compiled: CompiledScene,
}

impl Scene {
    pub(crate) fn def(&self) -> &WorldDef {
        self.compiled.def()
    }
}

#[pymethods]
impl Scene {
    #[new]
    #[pyo3(signature = (map = None, *, scenario = None, robots = Vec::new(), set = Vec::new(), equipment = None, drive_model = None))]
    fn new(
        py: Python,
        map: Option<&str>,
        scenario: Option<&str>,
        robots: Vec<PathBuf>,
        set: Vec<String>,
        equipment: Option<&str>,
        drive_model: Option<&str>,
    ) -> PyResult<Self> {
        py.detach(|| {
            let overrides = set.iter().map(|text| text.parse()).collect::<Result<Vec<Override>, _>>();
            let overrides = overrides.map_err(error::scene)?;
            let model = drive_model.map(str::parse::<DriveModel>).transpose().map_err(error::scene)?;
            let equipment = equipment.map_or_else(|| Ok(Equipment::default()), Equipment::load);
            let equipment = equipment.map_err(error::scene)?;
            let files: Vec<_> = robots.iter().map(PathBuf::as_path).collect();
            let changes = Changes { overrides: &overrides, equipment: &equipment };
            let loaded = match (map, scenario) {
                (Some(_), Some(_)) => {
                    return Err(error::scene("got both map and scenario: a scenario has its own map"));
                }
                (map, None) => scene_loader::load_equipped(map.unwrap_or(DEFAULT_MAP), &files, changes),
                (None, Some(name)) => {
                    scene_loader::scenario(name).and_then(|setting| scene_loader::load_around(setting, &files, changes))
                }
            };
            let mut def = loaded.map_err(error::scene)?;
            def.robots.change(move |robot| robot.set_drive_model(model));
            Ok(Self { compiled: def.into() })
        })
    }

    /// Name of the map.
    #[getter]
    fn map(&self) -> &str {
        &self.def().map.name
    }

    /// Names of the robot classes.
    #[getter]
    fn classes(&self) -> Vec<&str> {
        self.def().robots.keys().map(String::as_str).collect()
    }

    /// Names of the start poses of the map.
    #[getter]
    fn starts(&self) -> Vec<&str> {
        self.def().map.starts.iter().map(|start| start.name.as_str()).collect()
    }

    /// Returns every number of a robot class as JSON.
    fn _robot_json(&self, class_name: &str) -> PyResult<String> {
        let robots = &self.def().robots;
        let Some(robot) = robots.find(class_name).and_then(|class| robots.get(class)) else {
            let meant = names::did_you_mean(class_name, robots.keys().map(String::as_str));
            return Err(error::scene(format_args!("unknown robot class `{class_name}`{meant}")));
        };
        serde_json::to_string(robot).map_err(error::scene)
    }

    /// Returns every number of the map as JSON.
    fn _map_json(&self) -> PyResult<String> {
        serde_json::to_string(&self.def().map).map_err(error::scene)
    }

    /// Creates a scene from the bytes of `__reduce__`.
    #[staticmethod]
    fn _from_bytes(py: Python, bytes: &[u8]) -> PyResult<Self> {
        py.detach(|| {
            let unreadable = |reason| error::scene(format_args!("not a pickled scene: {reason}"));
            let def: WorldDef = serde_json::from_slice(bytes).map_err(unreadable)?;
            def.check().map_err(|problem| error::scene(format_args!("not a pickled scene: {problem}")))?;
            Ok(Self { compiled: def.into() })
        })
    }

    /// Returns what pickle makes the scene of: its definition.
    fn __reduce__<'py>(slf: Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let (py, scene) = (slf.py(), slf.get());
        let bytes = py.detach(|| serde_json::to_vec(scene.def())).map_err(error::scene)?;
        (slf.get_type().getattr("_from_bytes")?, (PyBytes::new(py, &bytes),)).into_bound_py_any(py)
    }

    fn __repr__(&self) -> String {
        format!("Scene({:?}, {} robot classes)", self.def().map.name, self.def().robots.len())
    }
}
