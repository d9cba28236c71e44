//! Worlds with their robots.
//!
//! Every robot has a session of its own, and orders are lines of the wire. So a log of a world in Python is like a log of a server, and
//! `usarsim log replay` repeats it.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use ::scene::check::TIME_STEP;
use ::scene::{BodyState, JointState, ObjectId, Options, PawnId, Pose, RobotDef, Sensed, Steering};
use experiments::LoggedSessions;
use gamebots_server::View;
use nalgebra::{Point3, Vector3};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray3, PyUntypedArrayMethods};
use picture::{Camera, Image, Stage};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyIterator, PyList};
use recorder::{LogWriter, RecordError};
use sessions::SessionId;
use sim_core::{CompiledScene, SavedWorld};
use thread_pool::ThreadPool;

use crate::batch::contiguous;
use crate::error;
use crate::scene::Scene;

/// Time between two looks at the signals of the process, for Ctrl-C.
const SIGNAL_INTERVAL: Duration = Duration::from_millis(100);
/// Time between two looks of a world that is shown, or that keeps to a pace.
const SHOWN_INTERVAL: Duration = Duration::from_millis(15);
/// Longest time that one call may step, simulated s.
const MAX_SECONDS: f64 = 31.0 * 24.0 * 3600.0;
/// Vertical field of view of a picture, rad.
const FIELD_OF_VIEW: f64 = 0.6;

/// A reading with its time, s.
type Read = (f64, Sensed);

/// A simulated world.
#[pyclass(module = "usarsim")]
pub(crate) struct World {
    sessions: LoggedSessions,
    readings: BTreeMap<(PawnId, usize), Read>,
    next_session: SessionId,
    threads: ThreadPool,
    stage: Option<Arc<Stage>>,
    view: Option<View>,
}

impl World {
    pub(crate) fn world(&self) -> &sim_core::World {
        self.sessions.world()
    }

    fn with(world: sim_core::World, threads: ThreadPool, log: Option<LogWriter>) -> Self {
        let sessions = LoggedSessions::new(world.on_threads(Arc::new(threads.clone())), log);
        Self { sessions, readings: BTreeMap::new(), next_session: 1, threads, stage: None, view: None }
    }

    /// Creates sessions for a world that has robots: each takes one over.
    pub(crate) fn of(world: sim_core::World, threads: ThreadPool) -> Result<Self, RecordError> {
        let mut loaded = Self::with(world, threads, None);
        let robots = loaded.world().robots().map(|(_, class, name)| (class.to_owned(), name.to_owned()));
        for (class, name) in robots.collect::<Vec<_>>() {
            loaded.enter(&format!("INIT {{ClassName USARBot.{class}}} {{Name {name}}}"))?;
        }
        Ok(loaded)
    }

    /// Executes a line of a new session. Returns its pawn and problems.
    fn enter(&mut self, line: &str) -> Result<(Option<PawnId>, Vec<String>), RecordError> {
        let session = self.next_session;
        self.next_session += 1;
        self.sessions.open(session)?;
        let problems = self.take(session, line)?;
        let pawn = self.sessions.newest(session);
        if pawn.is_none() {
            self.sessions.close(session)?;
        }
        Ok((pawn, problems))
    }

    /// Executes a line of a session. Returns its problems.
    fn take(&mut self, session: SessionId, line: &str) -> Result<Vec<String>, RecordError> {
        let Self { sessions, readings, .. } = self;
        let time = sessions.world().time();
        let mut keep = |sensed: &Sensed| _ = readings.insert((sensed.robot, sensed.sensor), (time, sensed.clone()));
        let problems = sessions.take(session, line, &mut keep)?;
        Ok(problems.iter().map(ToString::to_string).collect())
    }

    /// Advances by at most this many steps, until the signals are due. Returns the number of steps taken.
    fn advance(&mut self, steps: u64) -> Result<u64, RecordError> {
        let Self { sessions, readings, threads, view, .. } = self;
        let start = Instant::now();
        let interval = if view.is_some() { SHOWN_INTERVAL } else { SIGNAL_INTERVAL };
        threads.run(|| {
            for step in 0..steps {
                // The step's readings are of its end.
                let time = sessions.world().time() + sessions.world().time_step();
                sessions.step(&mut |sensed| {
                    readings.insert((sensed.robot, sensed.sensor), (time, sensed.clone()));
                })?;
                if start.elapsed() >= interval {
                    return Ok(step + 1);
                }
            }
            Ok(steps)
        })
    }

    /// Shows the present on the page of the world, if it has one and a frame is due or `must` be shown.
    fn show_now(&mut self, must: bool) {
        if let Some(view) = self.view.as_mut().filter(|view| must || view.is_due()) {
            view.show(self.sessions.world().snapshot());
        }
    }

    fn stage(&mut self) -> Arc<Stage> {
        let def = self.sessions.world().def();
        self.stage.get_or_insert_with(|| Arc::new(Stage::new(def))).clone()
    }

    /// Returns the object with a name.
    fn object(&self, name: &str) -> PyResult<ObjectId> {
        let known = self.world().objects().find(|object| object.def.solid.name.eq_ignore_ascii_case(name));
        known.map(|object| object.id).ok_or_else(|| {
            let names: Vec<String> = self.world().objects().map(|object| object.def.solid.name.clone()).collect();
            if names.is_empty() {
                return error::command(format_args!("unknown object `{name}`: the world has no movable objects"));
            }
            let known = names::listed(names.iter().map(String::as_str));
            error::command(format_args!("unknown object `{name}`: expected one of {known}"))
        })
    }
}

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
        let mut line = format!("INIT {{ClassName {package}{class_name}}}");
        if !name.is_empty() {
            write!(line, " {{Name {name}}}").map_err(error::command)?;
        }
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
                write!(line, " {{Start {start}}}")
            }
            (None, position) => {
                let (position, rotation) = match (position, map.starts.first()) {
                    (Some(position), _) => (position, rotation.unwrap_or_default()),
                    (None, Some(first)) => (first.position, rotation.unwrap_or(first.rotation)),
                    (None, None) => ([0.0; 3], rotation.unwrap_or_default()),
                };
                check_finite("position", &position)?;
                check_finite("rotation", &rotation)?;
                let text = |vector: [f64; 3]| vector.map(|number| number.to_string()).join(",");
                write!(line, " {{Location {}}} {{Rotation {}}}", text(position), text(rotation))
            }
        }
        .map_err(error::command)?;
        let (pawn, problems) = world.enter(&line).map_err(error::log)?;
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
        let object = |object: ::scene::ObjectSnapshot| {
            let name = object.def.solid.name.clone();
            Py::new(py, MovableObject { id: object.id.0, name, mass: object.def.mass, pose: object.pose })
        };
        self.world().objects().map(object).collect()
    }

    /// Puts a movable object at a pose, at rest.
    #[pyo3(signature = (name, position, rotation = [0.0; 3]))]
    fn put_object(&mut self, name: &str, position: [f64; 3], rotation: [f64; 3]) -> PyResult<()> {
        check_finite("position", &position)?;
        check_finite("rotation", &rotation)?;
        if self.sessions.is_logged() {
            return Err(error::command("an object cannot be put in a world with a log: the log would not replay"));
        }
        let id = self.object(name)?;
        let is_put = self.sessions.world_mut().put_object(id, &::scene::pose(position, rotation));
        is_put
            .then_some(())
            .ok_or_else(|| error::command(format_args!("position: got {position:?}, expected a place on the map")))
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
            threads: self.threads.clone(),
            stage: self.stage.clone(),
            view: None,
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
    let robots = def.robots.iter().filter(|(class, _)| classes.contains(*class));
    robots.for_each(|(_, robot)| hash.mix(&serde_json::to_vec(robot).unwrap_or_default()));
    format!("{:016x}", hash.value())
}

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
        places = picture::corners_of_map(&def.map);
    }
    let ahead = Vector3::new(0.75, 0.6, 0.65);
    let fitted = Camera::fitting(&places, ahead, FIELD_OF_VIEW, size);
    let target = target.map_or(fitted.target, Point3::from);
    // Some floor around the robots.
    let eye = eye.map_or(target + (fitted.eye - fitted.target) * 1.6, Point3::from);
    let camera = Camera { eye, target, ..fitted };
    picture::picture(stage, def, &snapshot, &camera, size)
}

/// A robot in a world.
#[pyclass(frozen, module = "usarsim")]
pub(crate) struct Robot {
    world: Py<World>,
    id: PawnId,
}

impl Robot {
    fn world<'py>(&self, py: Python<'py>) -> PyResult<PyRef<'py, World>> {
        self.world.bind(py).try_borrow().map_err(|_| busy())
    }

    fn world_mut<'py>(&self, py: Python<'py>) -> PyResult<PyRefMut<'py, World>> {
        self.world.bind(py).try_borrow_mut().map_err(|_| busy())
    }

    fn gone(&self) -> PyErr {
        error::command(format_args!("robot {} is gone", self.id.0))
    }

    fn body(&self, py: Python) -> PyResult<BodyState> {
        self.world(py)?.world().state(self.id).map(|(body, _)| body).ok_or_else(|| self.gone())
    }

    fn joints(&self, py: Python) -> PyResult<Vec<JointState>> {
        self.world(py)?.world().joints(self.id).ok_or_else(|| self.gone())
    }

    fn with_def<T>(&self, py: Python, read: impl FnOnce(&RobotDef) -> T) -> PyResult<T> {
        self.world(py)?.world().robot(self.id).map(read).ok_or_else(|| self.gone())
    }

    fn take(&self, py: Python, line: &str) -> PyResult<()> {
        let mut world = self.world_mut(py)?;
        let session = world.sessions.owner(self.id).ok_or_else(|| self.gone())?;
        if world.world().robot(self.id).is_none() {
            return Err(self.gone());
        }
        let problems = world.take(session, line).map_err(error::log)?;
        if problems.is_empty() { Ok(()) } else { Err(error::command(problems.join("; "))) }
    }

    /// Checks that the robot's class takes an order.
    fn check_steering(&self, py: Python, order: &str, takes: &[Steering]) -> PyResult<()> {
        let (class, steering) = self.with_def(py, |def| (def.class.clone(), def.steering))?;
        let expected = match steering {
            Steering::Skid => "drive_sides",
            Steering::Omni => "drive_wheels, drive_sides or drive_twist",
            Steering::Ackermann => "drive, with Speed, FrontSteer and RearSteer",
            Steering::Aerial => "drive_twist, or drive with the keys of its class",
            Steering::Legged => "move_joints",
            Steering::None => "no order, as it cannot drive",
        };
        if takes.contains(&steering) {
            return Ok(());
        }
        Err(error::command(format_args!("{class} does not take {order}: expected {expected}")))
    }

    /// Finds a sensor by its name; of several with one name, the first.
    fn sensor(&self, py: Python, name: &str) -> PyResult<usize> {
        self.with_def(py, |def| {
            let known = def.sensors.iter().position(|sensor| sensor.name.eq_ignore_ascii_case(name));
            known.ok_or_else(|| {
                let meant = names::did_you_mean(name, def.sensors.iter().map(|sensor| sensor.name.as_str()));
                let known = names::listed(def.sensors.iter().map(|sensor| sensor.name.as_str()));
                error::command(format_args!("unknown sensor `{name}`{meant}: expected one of {known}"))
            })
        })?
    }
}

#[pymethods]
impl Robot {
    /// Number of the robot.
    #[getter]
    fn id(&self) -> u64 {
        self.id.0
    }

    /// Name from its spawn.
    #[getter]
    fn name(&self, py: Python) -> PyResult<String> {
        let world = self.world(py)?;
        let named = world.world().robots().find(|(id, ..)| *id == self.id).map(|(.., name)| name.to_owned());
        named.ok_or_else(|| self.gone())
    }

    /// Name of its class.
    #[getter]
    fn class_name(&self, py: Python) -> PyResult<String> {
        self.with_def(py, |def| def.class.clone())
    }

    /// True while it is in the world.
    #[getter]
    fn is_alive(&self, py: Python) -> PyResult<bool> {
        Ok(self.world(py)?.world().robot(self.id).is_some())
    }

    /// Position of its frame, m.
    #[getter]
    fn position<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(vector(py, self.body(py)?.pose.translation.vector))
    }

    /// Orientation of its frame as a quaternion x, y, z, w.
    #[getter]
    fn orientation<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(self.body(py)?.pose.rotation.coords.as_slice().to_vec().into_pyarray(py))
    }

    /// Roll, pitch and yaw, rad.
    #[getter]
    fn rotation<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(::scene::position_and_rotation(&self.body(py)?.pose).1.to_vec().into_pyarray(py))
    }

    /// Velocity of its frame in world axes, m/s.
    #[getter]
    fn velocity<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(vector(py, self.body(py)?.linear))
    }

    /// Angular velocity in world axes, rad/s.
    #[getter]
    fn angular_velocity<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(vector(py, self.body(py)?.angular))
    }

    /// Names of the joints that have a value, wheels included.
    #[getter]
    fn joint_names(&self, py: Python) -> PyResult<Vec<String>> {
        self.with_def(py, |def| def.with_values().map(|link| link.name.clone()).collect())
    }

    /// Positions of these joints, rad or m.
    #[getter]
    fn joint_positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(self.joints(py)?.iter().map(|joint| joint.position).collect::<Vec<_>>().into_pyarray(py))
    }

    /// Speeds of these joints, rad/s or m/s.
    #[getter]
    fn joint_speeds<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        Ok(self.joints(py)?.iter().map(|joint| joint.speed).collect::<Vec<_>>().into_pyarray(py))
    }

    /// Names of the driven wheels.
    #[getter]
    fn wheel_names(&self, py: Python) -> PyResult<Vec<String>> {
        self.with_def(py, |def| def.driven().map(|wheel| wheel.name.to_owned()).collect())
    }

    /// Angles of the driven wheels, rad.
    #[getter]
    fn wheel_angles<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let world = self.world(py)?;
        let (_, wheels) = world.world().state(self.id).ok_or_else(|| self.gone())?;
        Ok(wheels.iter().map(|wheel| wheel.angle).collect::<Vec<_>>().into_pyarray(py))
    }

    /// Speeds of the driven wheels, rad/s.
    #[getter]
    fn wheel_speeds<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let world = self.world(py)?;
        let (_, wheels) = world.world().state(self.id).ok_or_else(|| self.gone())?;
        Ok(wheels.iter().map(|wheel| wheel.speed).collect::<Vec<_>>().into_pyarray(py))
    }

    /// Contacts of the last step: points, m, and forces on the robot, N, in world axes.
    #[getter]
    #[expect(clippy::type_complexity, reason = "two arrays")]
    fn contacts<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>)> {
        let seen = self.world(py)?.world().observe(self.id).ok_or_else(|| self.gone())?;
        let rows = |rows: Vec<f64>| rows.into_pyarray(py).reshape([seen.contacts.len(), 3]);
        let points = seen.contacts.iter().flat_map(|contact| <[f64; 3]>::from(contact.point)).collect();
        let forces = seen.contacts.iter().flat_map(|contact| <[f64; 3]>::from(contact.force)).collect();
        Ok((rows(points)?, rows(forces)?))
    }

    /// Names of its sensors.
    #[getter]
    fn sensor_names(&self, py: Python) -> PyResult<Vec<String>> {
        self.with_def(py, |def| def.sensors.iter().map(|sensor| sensor.name.clone()).collect())
    }

    /// Last readings of all sensors that have measured, by name.
    #[getter]
    fn readings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let names = self.sensor_names(py)?;
        let readings = PyDict::new(py);
        for (number, name) in names.into_iter().enumerate() {
            if let Some((time, sensed)) = self.world(py)?.readings.get(&(self.id, number)) {
                readings.set_item(&name, Reading::new(&name, *time, sensed))?;
            }
        }
        Ok(readings)
    }

    /// Last reading of a sensor; None before the first.
    fn reading(&self, py: Python, name: &str) -> PyResult<Option<Reading>> {
        let number = self.sensor(py, name)?;
        let world = self.world(py)?;
        Ok(world.readings.get(&(self.id, number)).map(|(time, sensed)| Reading::new(name, *time, sensed)))
    }

    /// Draws what a camera sees now: an array of rows, columns and colours.
    #[pyo3(signature = (name = "Camera", size = picture::SENSOR_SIZE))]
    fn camera<'py>(&self, py: Python<'py>, name: &str, size: [usize; 2]) -> PyResult<Bound<'py, PyAny>> {
        check_size(size)?;
        let number = self.sensor(py, name)?;
        let view = self.with_def(py, |def| match def.sensors.get(number).map(|sensor| &sensor.config) {
            Some(::scene::sensor::Config::Camera(camera)) => Some(camera.field_of_view),
            _ => None,
        })?;
        let Some(field_of_view) = view else {
            return Err(error::command(format_args!("sensor `{name}` is no camera")));
        };
        let mut borrowed = self.world_mut(py)?;
        let (id, stage) = (self.id, borrowed.stage());
        let last = borrowed.readings.get(&(id, number)).map(|(_, sensed)| sensed.clone());
        let fresh = ::scene::Reading::from(::scene::sensor::camera::Reading { field_of_view });
        let sensed = last.unwrap_or(Sensed { robot: id, sensor: number, reading: fresh });
        let world = borrowed.world();
        let image = py.detach(|| picture::of_sensor(&stage, world.def(), &world.snapshot(), &sensed, size));
        array(py, image.ok_or_else(|| self.gone())?)
    }

    /// Sets the speeds of the driven wheels, rad/s.
    fn drive_wheels(&self, py: Python, speeds: Vec<f64>) -> PyResult<()> {
        check_finite("speeds", &speeds)?;
        self.check_steering(py, "speeds of single wheels", &[Steering::Omni])?;
        let names = self.with_def(py, |def| def.driven().count())?;
        if speeds.len() != names {
            return Err(error::command(format_args!("speeds: got {}, expected {names}, one a wheel", speeds.len())));
        }
        let blocks =
            speeds.iter().enumerate().map(|(number, speed)| format!("{{WheelNumber {number}}} {{WheelSpeed {speed}}}"));
        self.take(py, &format!("DRIVE {}", blocks.collect::<Vec<_>>().join(" ")))
    }

    /// Sets the speeds of the wheels on the left and on the right, rad/s.
    fn drive_sides(&self, py: Python, left: f64, right: f64) -> PyResult<()> {
        check_finite("left and right", &[left, right])?;
        self.check_steering(py, "speeds of sides", &[Steering::Omni, Steering::Skid])?;
        self.take(py, &format!("DRIVE {{Left {left}}} {{Right {right}}}"))
    }

    /// Sets the velocities of a Mecanum base: forward and right, m/s, and clockwise, rad/s.
    #[pyo3(signature = (forward = 0.0, right = 0.0, clockwise = 0.0))]
    fn drive_twist(&self, py: Python, forward: f64, right: f64, clockwise: f64) -> PyResult<()> {
        check_finite("the twist", &[forward, right, clockwise])?;
        self.check_steering(py, "a twist", &[Steering::Omni, Steering::Aerial])?;
        let line = format!(
            "DRIVE {{LinearVelocity {forward}}} {{LateralVelocity {right}}} {{RotationalVelocity {clockwise}}}"
        );
        self.take(py, &line)
    }

    /// Sends a DRIVE line with these keys and numbers, as its class takes them.
    fn drive(&self, py: Python, keys: BTreeMap<String, f64>) -> PyResult<()> {
        let mut line = "DRIVE".to_owned();
        for (key, number) in &keys {
            check_text("key", key)?;
            check_finite(key, &[*number])?;
            write!(line, " {{{key} {number}}}").map_err(error::command)?;
        }
        self.take(py, &line)
    }

    /// Sets the targets of joints that are no wheels, rad or m, by name.
    fn move_joints(&self, py: Python, targets: BTreeMap<String, f64>) -> PyResult<()> {
        let mut line = "MULTIDRIVE".to_owned();
        for (joint, target) in &targets {
            check_text("joint", joint)?;
            check_finite(joint, &[*target])?;
            write!(line, " {{{joint} {target}}}").map_err(error::command)?;
        }
        self.take(py, &line)
    }

    /// Sends a line of the Gamebots protocol as the robot's controller.
    fn send(&self, py: Python, line: &str) -> PyResult<()> {
        if line.contains(['\n', '\r']) || line.len() > 65536 {
            return Err(error::command("line: expected one line of at most 65536 bytes"));
        }
        self.take(py, line)
    }

    /// Removes the robot from the world.
    fn remove(&self, py: Python) -> PyResult<()> {
        let mut world = self.world_mut(py)?;
        let session = world.sessions.owner(self.id).ok_or_else(|| self.gone())?;
        world.readings.retain(|(robot, _), _| *robot != self.id);
        world.sessions.close(session).map_err(error::log)
    }

    fn __eq__(&self, other: &Bound<PyAny>) -> bool {
        other.cast::<Self>().is_ok_and(|other| other.get().id == self.id && other.get().world.is(&self.world))
    }

    fn __hash__(&self) -> u64 {
        self.id.0 ^ (self.world.as_ptr() as u64)
    }

    fn __repr__(&self, py: Python) -> String {
        match (self.class_name(py), self.body(py)) {
            (Ok(class), Ok(body)) => {
                let [x, y, z] = body.pose.translation.vector.into();
                format!("Robot({}, {class}, position=[{x:.3}, {y:.3}, {z:.3}])", self.id.0)
            }
            _ => format!("Robot({}, gone)", self.id.0),
        }
    }
}

/// A reading of a sensor: its quantities by name, as arrays.
#[pyclass(frozen, module = "usarsim")]
pub(crate) struct Reading {
    name: String,
    time: f64,
    sensed: Sensed,
}

impl Reading {
    fn new(name: &str, time: f64, sensed: &Sensed) -> Self {
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

/// Returns a pool of threads; 0 are as many as the machine runs at a time.
pub(crate) fn pool(threads: usize) -> PyResult<ThreadPool> {
    if threads > 256 {
        return Err(error::command(format_args!("threads: got {threads}, expected 0 to 256")));
    }
    Ok(if threads == 0 { ThreadPool::of_machine()? } else { ThreadPool::new(threads)? })
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

pub(crate) fn check_size(size: [usize; 2]) -> PyResult<()> {
    let is_good = size.iter().all(|edge| (16..=8192).contains(edge));
    is_good
        .then_some(())
        .ok_or_else(|| error::command(format_args!("size: got {size:?}, expected 16 to 8192 pixels each")))
}

fn vector(py: Python, vector: Vector3<f64>) -> Bound<PyArray1<f64>> {
    vector.as_slice().to_vec().into_pyarray(py)
}

fn check_finite(name: &str, numbers: &[f64]) -> PyResult<()> {
    match numbers.iter().find(|number| !number.is_finite()) {
        Some(number) => Err(error::command(format_args!("{name}: got {number}, expected finite numbers"))),
        None => Ok(()),
    }
}

/// Returns the error of a world that another thread steps.
fn busy() -> PyErr {
    pyo3::exceptions::PyRuntimeError::new_err(
        "the world is being stepped in another thread: a world belongs to one thread at a time",
    )
}

/// Checks that a text fits into a block of a line.
fn check_text(name: &str, text: &str) -> PyResult<()> {
    if text.contains(|c: char| c == '{' || c == '}' || c.is_control()) {
        return Err(error::command(format_args!("{name}: got {text:?}, expected a text without braces and line ends")));
    }
    Ok(())
}

/// Warns of problems that did not keep a command from being done.
fn warn(py: Python, problems: &[String]) -> PyResult<()> {
    let category = py.get_type::<error::UsarsimWarning>();
    for problem in problems {
        let text = std::ffi::CString::new(problem.replace('\0', " ")).map_err(error::command)?;
        PyErr::warn(py, &category, &text, 2)?;
    }
    Ok(())
}
