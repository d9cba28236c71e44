//! Physical checks of wheeled robots, on maps made for them: twelve for robots on Mecanum wheels, nine for others.
//!
//! Every number is measured in the world through commands and states. It is compared with mechanics that the simulator does not
//! use: the exact kinematics of finite rollers, the balance of friction, Coulomb's limit, the dynamics of a rolling body. Units: m,
//! s, rad, kg, N.

mod mecanum_wheels;
mod plain_wheels;
mod reason;

use base_motion::mecanum;
use gamebots_proto::command::{Command, Init};
use nalgebra::Vector3;
use scene::{DriveModel, MapDef, Material, RobotDef, Shape, Solid, WorldDef};
use scene_loader::{LoadError, Override};
use sim_core::{BodyState, Options, PawnId, WheelState, World};

pub use reason::{Stance, reason};

use crate::course::{MotionError, SETTLING};
use crate::inertia::turning_inertia;

/// One measured number and its bounds.
#[derive(Debug, Clone, PartialEq)]
pub struct Finding {
    /// Number of the check, from 1.
    pub check: u32,
    /// Description of the quantity, with its unit.
    pub what: String,
    /// Measured value.
    pub measured: f64,
    /// Least valid value.
    pub least: f64,
    /// Greatest valid value.
    pub most: f64,
}

impl Finding {
    /// True if the value is within its bounds.
    pub fn passes(&self) -> bool {
        (self.least..=self.most).contains(&self.measured)
    }
}

/// Robot, floor and settings of the checks.
#[derive(Debug, Clone)]
pub struct Subject {
    /// Robot, with its drive model.
    pub robot: RobotDef,
    /// Material of the floor.
    pub floor: Material,
    /// Seed and time step.
    pub options: Options,
    /// Time of a measured drive, s.
    pub seconds: f64,
}

impl Subject {
    /// Loads a robot, by the name of its class or the path of its robot.toml, and the floor of the map `rough`.
    ///
    /// # Errors
    /// When a file does not load, or an override changes nothing.
    pub fn load(
        robot: &str,
        drive_model: Option<DriveModel>,
        set: &[Override],
        options: Options,
        seconds: f64,
    ) -> Result<Self, LoadError> {
        let mut robot = scene_loader::robot(robot, set)?;
        robot.set_drive_model(drive_model);
        let floor = scene_loader::map("rough", set)?.solids.swap_remove(0).material;
        scene_loader::check_used(set)?;
        Ok(Self { robot, floor, options, seconds })
    }

    /// Returns a finding as JSON, with the name of its check and the reason of a failure.
    pub fn to_json(&self, finding: &Finding) -> serde_json::Value {
        let Finding { check, what, measured, least, most } = finding;
        let bound = |value: &f64| value.is_finite().then_some(*value);
        let name = checks(&self.robot).get(*check as usize - 1);
        serde_json::json!({
            "check": check, "name": name, "what": what, "measured": measured, "least": bound(least),
            "most": bound(most), "passes": finding.passes(), "reason": reason(&self.robot, finding),
        })
    }
}

/// Returns the names of the checks of a robot.
pub fn checks(robot: &RobotDef) -> &'static [&'static str] {
    if is_omni(robot) { &mecanum_wheels::CHECKS } else { &plain_wheels::CHECKS }
}

fn is_omni(robot: &RobotDef) -> bool {
    mecanum::finite_rollers(robot).is_some()
}

/// Runs one check.
///
/// # Errors
/// When the robot has no driven wheels, or has no check with this number.
pub fn check(subject: &Subject, number: u32) -> Result<Vec<Finding>, MotionError> {
    let class = || subject.robot.class.clone();
    if subject.robot.driven().next().is_none() {
        return Err(MotionError::NotWheeled(class()));
    }
    let most = checks(&subject.robot).len();
    if !(1..=most as u32).contains(&number) {
        return Err(MotionError::NoCheck { class: class(), number, most });
    }
    let run = if is_omni(&subject.robot) { mecanum_wheels::check } else { plain_wheels::check };
    let mut findings = run(subject, number)?;
    findings.iter_mut().for_each(|finding| finding.check = number);
    Ok(findings)
}

fn about(what: impl Into<String>, measured: f64, expected: f64, tolerance: f64) -> Finding {
    Finding { check: 0, what: what.into(), measured, least: expected - tolerance, most: expected + tolerance }
}

fn below(what: impl Into<String>, measured: f64, most: f64) -> Finding {
    Finding { check: 0, what: what.into(), measured, least: f64::NEG_INFINITY, most }
}

/// Returns the orientation of a floor that rises to the front and to the right by these angles. It is pitched up (z is down) about
/// y and rolled about x.
fn tilt(rise: [f64; 2]) -> [f64; 3] {
    [-rise[1], rise[0], 0.0]
}

/// Creates a world with a floor and solids, without robots.
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
        ..MapDef::default()
    };
    let class = subject.robot.class.clone();
    let def = WorldDef { map, robots: [(class, subject.robot.clone())].into(), ..WorldDef::default() };
    World::new(def, subject.options)
}

/// A settled robot on a floor.
struct Scene {
    world: World,
    robot: PawnId,
}

impl Scene {
    /// Spawns the robot on a floor that rises to the front and to the right by these angles, parallel to it, and lets it settle.
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

    /// Returns the velocity in the robot's own axes.
    fn velocity(&self) -> Vector3<f64> {
        let body = self.body();
        body.pose.rotation.inverse() * body.linear
    }
}

/// Returns the tolerance of a ratio: 0.3 % for the models `Analytic` and `Articulated`, `other` for the rest.
fn tolerance(subject: &Subject, other: f64) -> f64 {
    let is_exact = matches!(subject.robot.drive_model, DriveModel::Analytic | DriveModel::Articulated);
    if is_exact { 0.003 } else { other }
}

/// Compares the slope at which a robot with locked wheels slides, ahead (0) or aside (1), with a limit, rad. Also measures its
/// creep at 0.9 of the limit.
fn slides(locked: &Subject, name: &str, axis: usize, limit: f64) -> Result<[Finding; 2], MotionError> {
    let on = |angle: f64| {
        let mut rise = [0.0; 2];
        rise[axis] = angle;
        Scene::new(locked, rise, Vec::new())
    };
    // The robot is spawned a millimetre above the floor and may slide a little; beyond the limit it gets faster.
    let slides = |angle: f64| -> Result<bool, MotionError> {
        let mut scene = on(angle)?;
        let before = scene.velocity().norm();
        scene.run(2.0);
        Ok(scene.velocity().norm() > before.max(0.005))
    };
    let (mut low, mut high) = (0.7 * limit, 1.3 * limit);
    while high - low > 0.1f64.to_radians() {
        let middle = (low + high) / 2.0;
        if slides(middle)? { high = middle } else { low = middle }
    }
    let mut scene = on(0.9 * limit)?;
    scene.run(1.0);
    let before = scene.body().pose.translation.vector;
    scene.run(10.0);
    let creep = (scene.body().pose.translation.vector - before).norm();
    Ok([
        about(format!("slides {name} from, degrees"), low.to_degrees(), limit.to_degrees(), 1.0),
        below(format!("creep {name} at 0.9 of it, mm in 10 s"), 1e3 * creep, 1.0),
    ])
}

/// Checks that a robot rolling down a slope without motors gains no energy, height included.
fn energy(coasting: &Subject) -> Result<Finding, MotionError> {
    let mut scene = Scene::new(coasting, [0.05, 0.0], Vec::new())?;
    let mass = f64::from(coasting.robot.mass());
    let energy = |scene: &Scene| {
        let (body, wheels) = scene.state();
        let driven = coasting.robot.driven().zip(&wheels);
        let spin: f64 = driven.map(|(wheel, state)| turning_inertia(&wheel) * state.speed.powi(2) / 2.0).sum();
        // z is down.
        mass * body.linear.norm_squared() / 2.0 + spin - mass * 9.81 * body.pose.translation.z
    };
    scene.run(1.0);
    let (mut before, mut grown) = (energy(&scene), f64::NEG_INFINITY);
    // A robot that is held does not move at all.
    let motion = (mass * scene.body().linear.norm_squared() / 2.0).max(1e-3);
    for _ in 0..20 {
        scene.run(0.1);
        let now = energy(&scene);
        grown = grown.max((now - before) / 0.1);
        before = now;
    }
    Ok(below("energy gained without a drive, of its motion a second", grown / motion, 1e-4))
}

/// Checks that a drive gives the same bits twice.
fn same_bits(subject: &Subject, command: &Command) -> Result<Finding, MotionError> {
    let digest = || -> Result<u64, MotionError> {
        let mut scene = Scene::new(subject, [0.0; 2], Vec::new())?;
        scene.drive(command);
        scene.run(2.0);
        Ok(scene.world.digest())
    };
    Ok(about("the same bits twice", f64::from(digest()? == digest()?), 1.0, 0.0))
}

/// Returns the subject with half the time step.
fn halved(subject: &Subject) -> Subject {
    let mut halved = subject.clone();
    halved.options.time_step /= 2.0;
    halved
}
