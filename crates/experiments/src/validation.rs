//! Physical checks of a robot on wheels, on maps made for them: twelve of one on Mecanum wheels, nine of another.
//!
//! Every number is measured in the world through commands and states, and compared with mechanics that the simulator
//! does not use: the exact kinematics of finite rollers, the balance of friction, Coulomb's limit, the dynamics of a rolling
//! body. Units: m, s, rad, kg, N.

mod mecanum_wheels;
mod plain_wheels;

use std::collections::BTreeMap;

use gamebots_proto::command::{Command, Init};
use nalgebra::Vector3;
use scene::{DriveModel, MapDef, Material, RobotDef, Shape, Solid, WorldDef};
use sim_core::{BodyState, Options, RobotId, WheelState, World, mecanum};

use crate::course::{MotionError, SETTLING};

/// One measured number and what it should be.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// Which of the checks, from 1.
    pub check: u32,
    /// What was measured, with its unit.
    pub what: String,
    /// Measured.
    pub measured: f64,
    /// Least that is right.
    pub least: f64,
    /// Most that is right.
    pub most: f64,
}

impl Finding {
    /// Whether it is within its bounds.
    pub fn passes(&self) -> bool {
        (self.least..=self.most).contains(&self.measured)
    }
}

/// What is checked, and how long.
#[derive(Debug, Clone)]
pub struct Subject {
    /// The robot, with its drive model.
    pub robot: RobotDef,
    /// What the floor is made of.
    pub floor: Material,
    /// Seed and time step.
    pub options: Options,
    /// Seconds of a measured drive.
    pub seconds: f64,
}

/// Names of the checks of a robot.
pub fn checks(robot: &RobotDef) -> &'static [&'static str] {
    if mecanum::finite_rollers(robot).is_some() { &mecanum_wheels::CHECKS } else { &plain_wheels::CHECKS }
}

/// Runs one check.
///
/// # Errors
/// When the robot has no driven wheels, or the check is none of its own.
pub fn check(subject: &Subject, number: u32) -> Result<Vec<Finding>, MotionError> {
    let class = || subject.robot.class.clone();
    if subject.robot.driven().next().is_none() {
        return Err(MotionError::NotWheeled(class()));
    }
    let most = checks(&subject.robot).len();
    if !(1..=most as u32).contains(&number) {
        return Err(MotionError::NoCheck { class: class(), number, most });
    }
    let is_omni = mecanum::finite_rollers(&subject.robot).is_some();
    let mut findings =
        if is_omni { mecanum_wheels::check(subject, number) } else { plain_wheels::check(subject, number) }?;
    findings.iter_mut().for_each(|finding| finding.check = number);
    Ok(findings)
}

fn about(what: impl Into<String>, measured: f64, expected: f64, tolerance: f64) -> Finding {
    Finding { check: 0, what: what.into(), measured, least: expected - tolerance, most: expected + tolerance }
}

fn below(what: impl Into<String>, measured: f64, most: f64) -> Finding {
    Finding { check: 0, what: what.into(), measured, least: f64::NEG_INFINITY, most }
}

fn between(what: impl Into<String>, measured: f64, least: f64, most: f64) -> Finding {
    Finding { check: 0, what: what.into(), measured, least, most }
}

/// Orientation of a floor that rises to the front and to the right by an angle: pitched up (z is down) about y, rolled about x.
fn tilt(rise: [f64; 2]) -> [f64; 3] {
    [-rise[1], rise[0], 0.0]
}

/// A floor with solids, and nobody on it yet.
fn world(subject: &Subject, rise: [f64; 2], solids: Vec<Solid>) -> World {
    let floor = Solid {
        name: "floor".to_owned(),
        shape: Shape::HalfSpace,
        position: [0.0; 3],
        rotation: tilt(rise),
        material: subject.floor.clone(),
    };
    let map = MapDef {
        name: "validation".to_owned(),
        description: String::new(),
        gravity: 9.81,
        time_limit: 0,
        solids: std::iter::once(floor).chain(solids).collect(),
        objects: Vec::new(),
        starts: Vec::new(),
        path_nodes: Vec::new(),
    };
    let class = subject.robot.class.clone();
    let def = WorldDef { map, robots: BTreeMap::from([(class, subject.robot.clone())]) };
    World::new(def, subject.options)
}

/// A robot on a floor, settled.
struct Scene {
    world: World,
    robot: RobotId,
}

impl Scene {
    /// On a floor that rises to the front and to the right by an angle, heading level with it, between solids.
    fn new(subject: &Subject, rise: [f64; 2], solids: Vec<Solid>) -> Result<Self, MotionError> {
        let tilt = tilt(rise);
        let class = subject.robot.class.clone();
        let mut world = world(subject, rise, solids);
        let mut problems = Vec::new();
        let init = Init { class_name: class, rotation: tilt, ..Init::default() };
        let robot = world.init(&init, &mut problems).ok_or(MotionError::Refused(problems))?;
        let mut scene = Self { world, robot };
        scene.run(SETTLING);
        Ok(scene)
    }

    fn drive(&mut self, command: &Command) {
        self.world.execute(Some(self.robot), command, &mut Vec::new());
    }

    fn run(&mut self, seconds: f64) {
        (0..(seconds / self.world.time_step()).round() as u64).for_each(|_| drop(self.world.step()));
    }

    fn state(&self) -> (BodyState, Vec<WheelState>) {
        let gone = || {
            let zero = Vector3::zeros();
            (BodyState { pose: scene::Pose::identity(), linear: zero, angular: zero }, Vec::new())
        };
        self.world.state(self.robot).unwrap_or_else(gone)
    }

    fn body(&self) -> BodyState {
        self.state().0
    }

    /// Velocity in the robot's own axes.
    fn velocity(&self) -> Vector3<f64> {
        let body = self.body();
        body.pose.rotation.inverse() * body.linear
    }
}

/// Trees in reduced coordinates are held to 0.3 %, others to what the check allows.
fn tolerance(subject: &Subject, other: f64) -> f64 {
    let is_exact = matches!(subject.robot.drive_model, DriveModel::Analytic | DriveModel::Articulated);
    if is_exact { 0.003 } else { other }
}

fn motors(subject: &mut Subject, change: impl FnMut(&mut scene::Motor)) {
    subject.robot.motors_mut().for_each(change);
}

/// The same robot with motors that do nothing on a floor that takes nothing.
fn coasting(subject: &Subject) -> Subject {
    let mut free = subject.clone();
    motors(&mut free, |motor| (motor.gain, motor.integral_time) = (1e-9, None));
    free.floor.rolling_resistance = 0.0;
    free
}

/// Mass that a push forward has to move: the robot's and what its wheels' inertia adds.
fn rolling_mass(robot: &RobotDef) -> f64 {
    let wheels = robot.driven().map(|wheel| {
        let armature = wheel.drive.map_or(0.0, |motor| motor.armature);
        (wheel.spin_inertia() + armature) / wheel.radius.powi(2)
    });
    f64::from(robot.mass()) + wheels.sum::<f64>()
}
