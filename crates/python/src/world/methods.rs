//! Methods of a world in Python.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use ::scene::check::TIME_STEP;
use ::scene::{Options, PawnId};
use gamebots_proto::Command;
use gamebots_proto::command::{Control, Create, Init};
use gamebots_server::View;
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use recorder::LogWriter;
use sessions::Request;
use sim_core::{CompiledScene, SavedWorld};

use crate::arguments::{busy, check_finite, check_line, check_numbers, check_size, check_text, pool, warn};
use crate::error;
use crate::object::MovableObject;
use crate::picture::{array, draw};
use crate::robot::Robot;
use crate::scene::Scene;

use super::{SHOWN_INTERVAL, SIGNAL_INTERVAL, World};

/// Longest time that one call may step, simulated s.
const MAX_SECONDS: f64 = 31.0 * 24.0 * 3600.0;

#[pymethods]
impl World {
    #[new]
    #[pyo3(signature = (scene, *, seed = 0, time_step = 0.002, threads = 1, log = None))]
    fn new(
        py: Python,
        scene: &Scene,
        seed: u64,
        time_step: f64,
        threads: usize,
        log: Option<PathBuf>,
    ) -> PyResult<Self> {
        let threads = pool(threads)?;
        if !TIME_STEP.holds(time_step) {
            return Err(error::scene(format_args!("time_step: got {time_step}, expected {TIME_STEP}")));
        }
        let options = Options { seed, time_step, ..Options::default() };
        py.detach(|| {
            if let Some(path) = log.as_ref().filter(|path| path.exists()) {
                return Err(error::log(format_args!("{}: it exists, expected the name of a new file", path.display())));
            }
            let log = log.map(|path| LogWriter::create(&path, scene.def(), options, &[])).transpose();
            let log = log.map_err(error::log)?;
            Ok(Self::with(sim_core::World::new(scene.compiled.clone(), options), threads, log))
        })
    }

    /// Spawns a robot.
    #[pyo3(signature = (class_name, *, start = None, position = None, rotation = None, name = ""))]
    fn spawn(
        slf: Bound<Self>,
        class_name: &str,
        start: Option<&str>,
        position: Option<[f64; 3]>,
        rotation: Option<[f64; 3]>,
        name: &str,
    ) -> PyResult<Robot> {
        let py = slf.py();
        check_text("class_name", class_name)?;
        check_text("name", name)?;
        let package = if class_name.contains('.') { "" } else { "USARBot." };
        let mut init =
            Init { class_name: format!("{package}{class_name}"), name: name.trim().to_owned(), ..Init::default() };
        let mut world = slf.try_borrow_mut().map_err(|_| busy())?;
        let map = &world.world().def().map;
        match (start, position) {
            (Some(_), Some(_)) => return Err(error::command("got both start and position: expected one of them")),
            (Some(_), None) if rotation.is_some() => {
                return Err(error::command("got both start and rotation: a start has its own rotation"));
            }
            (Some(start), None) => {
                check_text("start", start)?;
                if map.start(start).is_none() {
                    let known = names::listed(map.starts.iter().map(|start| start.name.as_str()));
                    return Err(error::command(format_args!("unknown start `{start}`: expected one of {known}")));
                }
                start.trim().clone_into(&mut init.start);
            }
            (None, position) => {
                let (position, rotation) = match (position, map.starts.first()) {
                    (Some(position), _) => (position, rotation.unwrap_or_default()),
                    (None, Some(first)) => (first.position, rotation.unwrap_or(first.rotation)),
                    (None, None) => ([0.0; 3], rotation.unwrap_or_default()),
                };
                check_finite("position", &position)?;
                check_numbers("rotation", &rotation)?;
                (init.location, init.rotation) = (position, rotation);
            }
        }
        let (pawn, problems) = world.enter(init).map_err(error::log)?;
        let Some(id) = pawn else { return Err(error::command(problems.join("; "))) };
        if world.world().robot(id).is_none() {
            let session = world.sessions.owner(id);
            session.map_or(Ok(()), |session| world.sessions.close(session)).map_err(error::log)?;
            return Err(error::command(format_args!("class_name: got {class_name}, expected a robot class")));
        }
        world.show_now(true);
        drop(world);
        warn(py, &problems)?;
        Ok(Robot { world: slf.unbind(), id })
    }

    /// Advances the world.
    #[pyo3(signature = (steps = 1, *, real_time_factor = None))]
    fn step(&mut self, py: Python, steps: u64, real_time_factor: Option<f64>) -> PyResult<()> {
        if steps as f64 * self.world().time_step() > MAX_SECONDS {
            return Err(error::command(format_args!("steps: got {steps}, expected at most a simulated month")));
        }
        if let Some(factor) = real_time_factor.filter(|factor| !(0.001..=1000.0).contains(factor)) {
            return Err(error::command(format_args!("real_time_factor: got {factor}, expected 0.001 to 1000")));
        }
        let (start, begin, time_step) = (Instant::now(), self.world().time(), self.world().time_step());
        let mut left = steps;
        while left > 0 {
            // As many steps as have become due until the next look.
            let due = real_time_factor.map_or(left, |factor| {
                let end = (start.elapsed() + SHOWN_INTERVAL).as_secs_f64() * factor;
                ((end - (self.world().time() - begin)) / time_step).max(0.0) as u64
            });
            left -= py.detach(|| self.advance(due.min(left))).map_err(error::log)?;
            self.show_now(left == 0);
            py.check_signals()?;
            if let Some(factor) = real_time_factor {
                let ahead =
                    Duration::from_secs_f64((self.world().time() - begin) / factor).saturating_sub(start.elapsed());
                py.detach(|| std::thread::sleep(ahead.min(SIGNAL_INTERVAL)));
            }
        }
        Ok(())
    }

    /// Advances the world by a time, s.
    #[pyo3(signature = (seconds, *, real_time_factor = None))]
    fn run(&mut self, py: Python, seconds: f64, real_time_factor: Option<f64>) -> PyResult<()> {
        if !(0.0..=MAX_SECONDS).contains(&seconds) {
            return Err(error::command(format_args!("seconds: got {seconds}, expected 0 to {MAX_SECONDS}")));
        }
        self.step(py, (seconds / self.world().time_step()).round() as u64, real_time_factor)
    }

    /// Serves a page that shows the world live.
    #[pyo3(signature = (port = 0, height = 480))]
    fn show(slf: Bound<Self>, port: u16, height: u32) -> PyResult<Bound<PyAny>> {
        let url = {
            let mut world = slf.try_borrow_mut().map_err(|_| busy())?;
            if world.view.is_none() {
                let view = View::start(world.world().def(), world.world().options(), port).map_err(error::command)?;
                world.view = Some(view);
            }
            world.show_now(true);
            world.view.as_ref().map_or_else(String::new, |view| format!("http://{}/", view.address()))
        };
        slf.py().import("usarsim._view")?.getattr("View")?.call1((&slf, url, height))
    }

    /// Ends the page.
    fn _hide(&mut self, py: Python) {
        let view = self.view.take();
        py.detach(|| drop(view));
    }

    /// Simulated time, s.
    #[getter]
    fn time(&self) -> f64 {
        self.world().time()
    }

    /// Length of a step, s.
    #[getter]
    fn time_step(&self) -> f64 {
        self.world().time_step()
    }

    /// The scene.
    #[getter]
    fn scene(&self) -> Scene {
        Scene { compiled: self.world().scene().clone() }
    }

    /// Robots, in the order of their spawns.
    #[getter]
    fn robots(slf: Bound<Self>) -> PyResult<Vec<Robot>> {
        let ids: Vec<PawnId> = slf.try_borrow().map_err(|_| busy())?.world().robots().map(|(id, ..)| id).collect();
        Ok(ids.into_iter().map(|id| Robot { world: slf.clone().unbind(), id }).collect())
    }

    /// Movable objects, by their ids.
    #[getter]
    fn objects(&self, py: Python) -> PyResult<Vec<Py<MovableObject>>> {
        self.world().objects().map(|object| Py::new(py, MovableObject::from(object))).collect()
    }

    /// Puts a movable object at a pose, at rest.
    #[pyo3(signature = (name, position, rotation = [0.0; 3]))]
    fn put_object(&mut self, name: &str, position: [f64; 3], rotation: [f64; 3]) -> PyResult<()> {
        check_finite("position", &position)?;
        check_numbers("rotation", &rotation)?;
        if self.sessions.is_logged() {
            return Err(error::command(
                "an object cannot be put in a world with a log, which would not replay: expected \
                 control(\"CONTROL {Type AbsMove} {Name ..} {Location ..}\")",
            ));
        }
        let id = self.object(name)?;
        let is_put = self.sessions.world_mut().put_object(id, &::scene::pose(position, rotation));
        is_put
            .then_some(())
            .ok_or_else(|| error::command(format_args!("position: got {position:?}, expected a place on the map")))
    }

    /// Creates a movable object.
    #[pyo3(signature = (class_name, name, position, rotation = [0.0; 3], *, scale = [1.0; 3], material = "", rigid = true))]
    #[expect(clippy::too_many_arguments, reason = "keywords of Python")]
    fn create_object(
        &mut self,
        py: Python,
        class_name: &str,
        name: &str,
        position: [f64; 3],
        rotation: [f64; 3],
        scale: [f64; 3],
        material: &str,
        rigid: bool,
    ) -> PyResult<MovableObject> {
        for (key, text) in [("class_name", class_name), ("name", name), ("material", material)] {
            check_text(key, text)?;
        }
        for (key, vector) in [("position", position), ("rotation", rotation), ("scale", scale)] {
            check_numbers(key, &vector)?;
        }
        if name.trim() != name || name.is_empty() {
            return Err(error::command(format_args!("name: got {name:?}, expected a name without space around it")));
        }
        if self.world().objects().any(|object| object.def.solid.name.eq_ignore_ascii_case(name)) {
            return Err(error::command(format_args!("name: the world has an object `{name}` already")));
        }
        let create = Create {
            class_name: class_name.to_owned(),
            name: name.to_owned(),
            location: position,
            rotation,
            scale,
            is_rigid: rigid,
            material: material.to_owned(),
            ..Create::default()
        };
        let session = self.controller()?;
        let problems =
            self.take(session, &Request::order(Command::Control(Control::Create(create)))).map_err(error::log)?;
        let created = self.world().objects().find(|object| object.def.solid.name == name);
        let created = created.ok_or_else(|| error::command(problems.join("; ")))?;
        warn(py, &problems)?;
        Ok(created.into())
    }

    /// Removes a movable object.
    fn remove_object(&mut self, name: &str) -> PyResult<()> {
        check_text("name", name)?;
        self.object(name)?;
        let session = self.controller()?;
        let kill = Control::Kill { name: name.to_owned() };
        self.ask(session, &Request::order(Command::Control(kill))).map(drop)
    }

    /// Sends a line of the Gamebots protocol as a world controller. Returns the lines that answer it.
    fn control(&mut self, line: &str) -> PyResult<Vec<String>> {
        check_line(line)?;
        let session = self.controller()?;
        self.ask(session, &Request::read(Ok(line.to_owned())))
    }

    /// Names of the goals that have been reached, in that order. Without a league or a scenario there are none.
    #[getter]
    fn reached(&self) -> Vec<String> {
        let teams = self.sessions.standings().unwrap_or_default().teams;
        let scores = teams.iter().flat_map(|team| &team.scores);
        scores.filter_map(|score| score.goal().map(str::to_owned)).collect()
    }

    /// Simulated time from the first robot's arrival in which a team has reached all goals, s.
    #[getter]
    fn finished(&self) -> Option<f64> {
        self.sessions.standings()?.teams.iter().find_map(|team| team.finished)
    }

    /// Hash of the bits of every body.
    #[getter]
    fn digest(&self) -> String {
        format!("{:016x}", self.world().digest())
    }

    /// Number of steps of robots whose contacts did not converge.
    #[getter]
    fn unsettled_steps(&self) -> u64 {
        self.world().unsettled_steps()
    }

    /// Returns an independent copy that continues with the same bits, without a log.
    fn copy(&self) -> Self {
        Self {
            sessions: self.sessions.copy(),
            readings: self.readings.clone(),
            next_session: self.next_session,
            controller: self.controller,
            threads: self.threads.clone(),
            stage: self.stage.clone(),
            view: None,
            shown: f64::NEG_INFINITY,
        }
    }

    fn __copy__(&self) -> Self {
        self.copy()
    }

    #[pyo3(signature = (_memo))]
    fn __deepcopy__(&self, _memo: Py<PyAny>) -> Self {
        self.copy()
    }

    /// Returns the state as bytes, without the scene.
    fn save<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let saved = self.world().save().map_err(error::save)?;
        let compiled = self.world().scene();
        let write = || {
            let world = serde_json::to_value(&saved)?;
            let scene = scene_hash(compiled, &world_classes(&world));
            serde_json::to_vec(&Saved { scene, world })
        };
        Ok(PyBytes::new(py, &py.detach(write).map_err(error::save)?))
    }

    /// Creates a world that goes on from a saved state of the same scene.
    #[staticmethod]
    #[pyo3(signature = (scene, state, *, threads = 1))]
    fn load(py: Python, scene: &Scene, state: &[u8], threads: usize) -> PyResult<Self> {
        let threads = pool(threads)?;
        py.detach(|| {
            let unreadable = |reason| error::save(format_args!("state: not a saved world: {reason}"));
            let Saved { scene: of, world } = serde_json::from_slice(state).map_err(unreadable)?;
            if of != scene_hash(&scene.compiled, &world_classes(&world)) {
                return Err(error::save(
                    "state: it was saved in another scene: expected the same map and robot classes",
                ));
            }
            let world: SavedWorld = serde_json::from_value(world).map_err(unreadable)?;
            let world = sim_core::World::load(scene.compiled.clone(), &world).map_err(error::save)?;
            Self::of(world, threads).map_err(error::save)
        })
    }

    /// Creates a world from what `__reduce__` returns.
    #[staticmethod]
    fn _restore(py: Python, scene: &Scene, state: &[u8], threads: usize) -> PyResult<Self> {
        Self::load(py, scene, state, threads)
    }

    /// Returns what pickle makes the world of: its scene, its state and the number of its threads.
    fn __reduce__<'py>(slf: Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let py = slf.py();
        let restore = slf.get_type().getattr("_restore")?;
        let world = slf.try_borrow().map_err(|_| busy())?;
        (restore, (world.scene(), world.save(py)?, world.threads.threads())).into_bound_py_any(py)
    }

    /// Returns the robot with a number, for pickle.
    fn _robot(slf: Bound<Self>, id: u64) -> Robot {
        Robot { world: slf.unbind(), id: PawnId(id) }
    }

    /// Ends the log.
    fn close(&mut self) -> PyResult<()> {
        self.sessions.finish().map_err(error::log)
    }

    fn __enter__(slf: Bound<Self>) -> Bound<Self> {
        slf
    }

    #[pyo3(signature = (*_error))]
    fn __exit__(&mut self, _error: &Bound<PyAny>) -> PyResult<()> {
        self.close()
    }

    /// Draws the world: the picture as an array of rows, columns and colours.
    #[pyo3(signature = (size = [640, 360], *, eye = None, target = None))]
    fn picture<'py>(
        &mut self,
        py: Python<'py>,
        size: [usize; 2],
        eye: Option<[f64; 3]>,
        target: Option<[f64; 3]>,
    ) -> PyResult<Bound<'py, PyAny>> {
        check_size(size)?;
        eye.iter().chain(&target).try_for_each(|place| check_finite("eye and target", place))?;
        let (stage, world) = (self.stage(), self.world());
        let image = py.detach(|| draw(&stage, world, size, eye, target));
        array(py, image)
    }

    fn __repr__(&self) -> String {
        let (world, robots) = (self.world(), self.world().robots().count());
        format!("World({:?}, time={:.3}, {robots} robots)", world.def().map.name, world.time())
    }
}

/// A saved world with the hash of its scene.
#[derive(serde::Serialize, serde::Deserialize)]
struct Saved {
    scene: String,
    world: serde_json::Value,
}

/// Returns the classes of the robots of a saved world.
fn world_classes(saved: &serde_json::Value) -> BTreeSet<String> {
    let robots = saved.get("robots").and_then(|robots| robots.as_array());
    let class = |robot: &serde_json::Value| Some(robot.get("class")?.as_str()?.to_owned());
    robots.into_iter().flatten().filter_map(class).collect()
}

/// Returns a hash of the map and of these classes.
fn scene_hash(scene: &CompiledScene, classes: &BTreeSet<String>) -> String {
    let (def, mut hash) = (scene.def(), ::scene::Fnv::default());
    hash.mix(&serde_json::to_vec(&def.map).unwrap_or_default());
    let robots = classes.iter().filter_map(|class| def.robots.get(class));
    robots.for_each(|robot| hash.mix(&serde_json::to_vec(robot).unwrap_or_default()));
    format!("{:016x}", hash.value())
}
