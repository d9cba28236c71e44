//! Robots in a world.

use std::collections::BTreeMap;

use ::picture::SENSOR_SIZE;
use ::scene::{BodyState, JointState, PawnId, RobotDef, Sensed, Steering};
use gamebots_proto::Command;
use gamebots_proto::command::{Drive, MultiDrive};
use numpy::{IntoPyArray, PyArray1, PyArray2, PyArrayMethods};
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use sessions::{Request, SessionId};

use crate::arguments::{busy, check_key, check_line, check_numbers, check_size};
use crate::error;
use crate::picture::array;
use crate::reading::{Reading, vector};
use crate::world::World;

/// A robot in a world.
#[pyclass(frozen, module = "usarsim")]
pub(crate) struct Robot {
    pub(crate) world: Py<World>,
    pub(crate) id: PawnId,
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

    fn order(&self, py: Python, command: Command) -> PyResult<()> {
        let mut world = self.world_mut(py)?;
        let session = self.session(&world)?;
        let problems = world.take(session, &Request::order(command)).map_err(error::log)?;
        if problems.is_empty() { Ok(()) } else { Err(error::command(problems.join("; "))) }
    }

    /// Returns the session of the robot, while it is in the world.
    fn session(&self, world: &World) -> PyResult<SessionId> {
        let is_here = world.world().robot(self.id).is_some();
        world.sessions.owner(self.id).filter(|_| is_here).ok_or_else(|| self.gone())
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

    /// Finds a sensor by its label.
    fn sensor(&self, py: Python, name: &str) -> PyResult<usize> {
        let labels = self.with_def(py, RobotDef::sensor_labels)?;
        labels.iter().position(|label| label.eq_ignore_ascii_case(name)).ok_or_else(|| {
            let known = || labels.iter().map(String::as_str);
            let (meant, known) = (names::did_you_mean(name, known()), names::listed(known()));
            error::command(format_args!("unknown sensor `{name}`{meant}: expected one of {known}"))
        })
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

    /// Slip, use of friction, wheel and patch of each contact, in the order of `contacts`.
    #[getter]
    fn grip<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let seen = self.world(py)?.world().observe(self.id).ok_or_else(|| self.gone())?;
        let count = seen.contacts.len();
        let contacts = || seen.contacts.iter();
        let slips: Vec<f64> = contacts().flat_map(|contact| <[f64; 3]>::from(contact.slip)).collect();
        let shares: Vec<f64> = contacts().map(|contact| contact.friction_share).collect();
        let (wheels, patches) = self.with_def(py, |def| {
            let number = |wheel: usize| def.driven_number(wheel).map(|number| number as i64);
            let wheels: Vec<i64> = contacts().map(|contact| contact.wheel.and_then(number).unwrap_or(-1)).collect();
            let patches: Vec<_> = def.wheels().map(|wheel| wheel.tyre.map_or([0.0; 2], |tyre| tyre.patch)).collect();
            let patch = |wheel: Option<usize>| wheel.and_then(|wheel| patches.get(wheel)).copied().unwrap_or_default();
            (wheels, contacts().flat_map(|contact| patch(contact.wheel)).collect::<Vec<f64>>())
        })?;
        let grip = PyDict::new(py);
        grip.set_item("wheels", wheels.into_pyarray(py))?;
        grip.set_item("slips", slips.into_pyarray(py).reshape([count, 3])?)?;
        grip.set_item("friction_used", shares.into_pyarray(py))?;
        grip.set_item("patches", patches.into_pyarray(py).reshape([count, 2])?)?;
        Ok(grip)
    }

    /// Effective track while it turns: the difference of its sides' speeds over its yaw rate, m.
    #[getter]
    fn effective_track(&self, py: Python) -> PyResult<Option<f64>> {
        let world = self.world(py)?;
        let (body, wheels) = world.world().state(self.id).ok_or_else(|| self.gone())?;
        let yaw_rate = (body.pose.rotation.inverse() * body.angular).z;
        let speeds: Vec<f64> = wheels.iter().map(|wheel| wheel.speed).collect();
        self.with_def(py, |def| effective_track(def, &speeds, yaw_rate))
    }

    /// Names of its sensors, with a number behind a name that comes again.
    #[getter]
    fn sensor_names(&self, py: Python) -> PyResult<Vec<String>> {
        self.with_def(py, RobotDef::sensor_labels)
    }

    /// Last readings of all sensors that have measured, by name.
    #[getter]
    fn readings<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let names = self.sensor_names(py)?;
        let readings = PyDict::new(py);
        for (number, name) in names.iter().enumerate() {
            if let Some((time, sensed)) = self.world(py)?.readings.get(&(self.id, number)) {
                readings.set_item(name, Reading::new(name, *time, sensed))?;
            }
        }
        py.import("usarsim._readings")?.getattr("Readings")?.call1((readings, names))
    }

    /// Last reading of a sensor; None before the first.
    fn reading(&self, py: Python, name: &str) -> PyResult<Option<Reading>> {
        let number = self.sensor(py, name)?;
        let world = self.world(py)?;
        Ok(world.readings.get(&(self.id, number)).map(|(time, sensed)| Reading::new(name, *time, sensed)))
    }

    /// Draws what a camera sees now: an array of rows, columns and colours.
    #[pyo3(signature = (name = "Camera", size = SENSOR_SIZE))]
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
        let image = py.detach(|| ::picture::of_sensor(&stage, world.def(), &world.snapshot(), &sensed, size));
        array(py, image.ok_or_else(|| self.gone())?)
    }

    /// Sets the speeds of the driven wheels, rad/s.
    fn drive_wheels(&self, py: Python, speeds: Vec<f64>) -> PyResult<()> {
        check_numbers("speeds", &speeds)?;
        self.check_steering(py, "speeds of single wheels", &[Steering::Omni])?;
        let names = self.with_def(py, |def| def.driven().count())?;
        if speeds.len() != names {
            return Err(error::command(format_args!("speeds: got {}, expected {names}, one a wheel", speeds.len())));
        }
        let drive = speeds.iter().enumerate().fold(Drive::default(), |drive, (number, speed)| {
            drive.with("WheelNumber", number as f64).with("WheelSpeed", *speed)
        });
        self.order(py, Command::Drive(drive))
    }

    /// Sets the speeds of the wheels on the left and on the right, rad/s.
    fn drive_sides(&self, py: Python, left: f64, right: f64) -> PyResult<()> {
        check_numbers("left and right", &[left, right])?;
        self.check_steering(py, "speeds of sides", &[Steering::Omni, Steering::Skid])?;
        self.order(py, Command::Drive(Drive::default().with("Left", left).with("Right", right)))
    }

    /// Sets the velocities of a Mecanum base: forward and right, m/s, and clockwise, rad/s.
    #[pyo3(signature = (forward = 0.0, right = 0.0, clockwise = 0.0))]
    fn drive_twist(&self, py: Python, forward: f64, right: f64, clockwise: f64) -> PyResult<()> {
        check_numbers("the twist", &[forward, right, clockwise])?;
        self.check_steering(py, "a twist", &[Steering::Omni, Steering::Aerial])?;
        let drive = Drive::default().with("LinearVelocity", forward).with("LateralVelocity", right);
        self.order(py, Command::Drive(drive.with("RotationalVelocity", clockwise)))
    }

    /// Sends a DRIVE with these keys and numbers, as its class takes them.
    fn drive(&self, py: Python, keys: BTreeMap<String, f64>) -> PyResult<()> {
        let mut drive = Drive::default();
        for (key, number) in &keys {
            check_key("key", key)?;
            check_numbers(key, &[*number])?;
            match key.to_ascii_lowercase().as_str() {
                "normalized" => drive.normalized = Some(*number != 0.0),
                "light" => drive.light = Some(*number != 0.0),
                _ => drive = drive.with(key, *number),
            }
        }
        self.order(py, Command::Drive(drive))
    }

    /// Sets the targets of joints that are no wheels, rad or m, by name.
    fn move_joints(&self, py: Python, targets: BTreeMap<String, f64>) -> PyResult<()> {
        for (joint, target) in &targets {
            check_key("joint", joint)?;
            check_numbers(joint, &[*target])?;
        }
        self.order(py, Command::MultiDrive(MultiDrive { targets: targets.into_iter().collect() }))
    }

    /// Sends a line of the Gamebots protocol as the robot's controller. Returns the lines that answer it.
    fn send(&self, py: Python, line: &str) -> PyResult<Vec<String>> {
        check_line(line)?;
        let mut world = self.world_mut(py)?;
        let session = self.session(&world)?;
        world.ask(session, &Request::read(Ok(line.to_owned())))
    }

    /// Removes the robot from the world.
    fn remove(&self, py: Python) -> PyResult<()> {
        let mut world = self.world_mut(py)?;
        let session = world.sessions.owner(self.id).ok_or_else(|| self.gone())?;
        world.readings.retain(|(robot, _), _| *robot != self.id);
        world.sessions.close(session).map_err(error::log)
    }

    /// Returns what pickle makes the robot of: its world and its number.
    fn __reduce__<'py>(slf: Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        let (py, Self { world, id }) = (slf.py(), slf.get());
        let find = py.get_type::<World>().getattr("_robot")?;
        (find, (world, id.0)).into_bound_py_any(py)
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

/// Least yaw rate at which a robot turns, rad/s.
const LEAST_TURN: f64 = 0.02;

/// Computes the effective track of a robot, m, from the speeds of its driven wheels, rad/s, and its yaw rate, clockwise, rad/s.
fn effective_track(def: &RobotDef, speeds: &[f64], yaw_rate: f64) -> Option<f64> {
    let side = |sign: f64| {
        let of_body = def.driven().zip(speeds).filter(|(wheel, _)| wheel.parent == 0 && wheel.position[1] * sign > 0.0);
        let speeds: Vec<f64> = of_body.map(|(wheel, speed)| wheel.radius * speed).collect();
        (!speeds.is_empty()).then(|| speeds.iter().sum::<f64>() / speeds.len() as f64)
    };
    let (left, right) = side(-1.0).zip(side(1.0))?;
    (yaw_rate.abs() > LEAST_TURN).then(|| (left - right) / yaw_rate)
}
