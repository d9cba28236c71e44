//! Tasks for learning: which robot, on which map, with which goal. Files are `assets/tasks/<name>.toml`, or one's own.

use std::path::Path;
use std::sync::Arc;

use goals::Judge;
use include_dir::{Dir, include_dir};
use scene::check::{self, TIME_STEP};
use scene::goal::{self, Goal};
use scene::{MapDef, Object, RobotDef, Shape, WorldDef};
use scene_loader::Override;
use serde::Deserialize;
use sim_core::CompiledScene;

static SHIPPED: Dir = include_dir!("$CARGO_MANIFEST_DIR/../../assets/tasks");

/// Maximum number of robots in a world of a task.
const MAX_ROBOTS: usize = 16;
/// Longest interval between two actions, s.
const MAX_INTERVAL: f64 = 1.0;
/// Longest episode, s.
const MAX_SECONDS: f64 = 3600.0;

/// A task file that cannot be played.
#[derive(Debug, thiserror::Error)]
#[error("{file}: {reason}")]
pub struct TaskError {
    file: String,
    reason: String,
}

/// A task, ready to be played.
pub struct Task {
    /// Name of its file without the ending.
    pub name: String,
    pub(crate) file: TaskFile,
    pub(crate) scene: CompiledScene,
    /// The robot's class on the map, with the sensors that the goal uses.
    pub(crate) robot: Arc<RobotDef>,
    /// Joints that actions move, by their numbers among those with a value, each with the speed at 1 and its limits.
    pub(crate) joints: Vec<(usize, f64, [f64; 2])>,
    /// Fingers of the gripper by the same numbers, each with its closed and its open position.
    pub(crate) fingers: Vec<(usize, [f64; 2])>,
    /// Time steps between two actions.
    pub(crate) steps: u32,
    /// Actions until an episode is cut off.
    pub(crate) horizon: u32,
}

/// A task file.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct TaskFile {
    /// Description in one sentence.
    pub(crate) description: String,
    /// Map by name or file.
    map: String,
    /// Robot by class or file.
    robot: String,
    /// Drive model; the robot's own if there is none.
    #[serde(default)]
    drive_model: Option<String>,
    /// Overrides `PATH=VALUE`, as for `--set`.
    #[serde(default)]
    set: Vec<String>,
    /// Number of robots in a world.
    #[serde(default = "one")]
    pub(crate) robots: usize,
    /// Length of a time step, s.
    pub(crate) time_step: f64,
    /// Time between two actions, s.
    pub(crate) control_interval: f64,
    /// Length of an episode, s.
    seconds: f64,
    pub(crate) action: Action,
    pub(crate) start: Start,
    #[serde(default)]
    pub(crate) object: Option<ObjectSpec>,
    #[serde(default)]
    reach: Option<goal::Reach>,
    #[serde(default)]
    follow: Option<goal::Follow>,
    #[serde(default)]
    push: Option<goal::Push>,
    #[serde(default)]
    pub(crate) fetch: Option<goal::Fetch>,
    #[serde(default)]
    pub(crate) explore: Option<goal::Explore>,
    #[serde(default)]
    find: Option<goal::Find>,
    #[serde(default)]
    zone: Option<goal::Zone>,
}

fn one() -> usize {
    1
}

/// Meaning of a robot's actions. Each is between -1 and 1, in the order of these fields.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct Action {
    /// Velocities of a Mecanum base at 1: forward, right, m/s, clockwise, rad/s.
    pub(crate) twist: Option<[f64; 3]>,
    /// Speed of the wheels at 1, rad/s: one action for the left side and one for the right.
    pub(crate) sides: Option<f64>,
    /// Speeds of joints at 1, rad/s or m/s, by name. The joint's target moves at this speed.
    joints: toml::Table,
    /// Name of a gripper that one action opens, above 0, or closes.
    gripper: Option<String>,
}

/// The start of the robots.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub(crate) struct Start {
    /// Least and most of x and y, m; beside the named start if there is one.
    pub(crate) position: [[f64; 2]; 2],
    /// Least and most yaw, rad, clockwise; added to that of the named start.
    pub(crate) yaw: [f64; 2],
    /// Name of a start pose of the map.
    pub(crate) name: Option<String>,
}

/// An object that lies on the floor.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct ObjectSpec {
    /// Class of assets/objects.toml.
    class: String,
    /// Edges of a box, m, instead of those of the class.
    #[serde(default)]
    size: Option<[f64; 3]>,
    /// Mass, kg, instead of that of the class.
    #[serde(default)]
    mass: Option<f64>,
    /// Least and most of x and y at the start, m.
    pub(crate) position: [[f64; 2]; 2],
}

impl Task {
    /// Returns the names of the shipped tasks.
    pub fn shipped() -> Vec<String> {
        let name = |file: &'static include_dir::File| Some(file.path().file_stem()?.to_str()?.to_owned());
        let mut names: Vec<String> = SHIPPED.files().filter_map(name).collect();
        names.sort();
        names
    }

    /// Loads a shipped task by its name, or a file by its path.
    ///
    /// # Errors
    /// When the name is unknown, the file cannot be read, or something in it is wrong.
    pub fn load(name: &str) -> Result<Self, TaskError> {
        let error = |reason: String| TaskError { file: name.to_owned(), reason };
        if let Some(file) = SHIPPED.get_file(format!("{name}.toml")) {
            return Self::read(Path::new(name), file.contents_utf8().unwrap_or_default());
        }
        let path = Path::new(name);
        if path.extension().is_none_or(|ending| ending != "toml") {
            let names = Self::shipped();
            let meant = names::did_you_mean(name, names.iter().map(String::as_str));
            return Err(error(format!("unknown task{meant}: expected a task.toml, or one of {}", names.join(", "))));
        }
        Self::read(path, &scene_loader::text(path).map_err(|reason| error(reason.to_string()))?)
    }

    /// Reads a task from its text.
    ///
    /// # Errors
    /// Gives the line of a mistake, or the number that is out of bounds.
    pub fn read(path: &Path, text: &str) -> Result<Self, TaskError> {
        let error = |reason: String| TaskError { file: path.display().to_string(), reason };
        let file: TaskFile = toml::from_str(text).map_err(|reason| error(reason.to_string().trim_end().to_owned()))?;
        file.check().map_err(error)?;
        let (def, class) = file.def(path).map_err(|reason| error(reason.to_string()))?;
        let robot = def.robots.get(&class).cloned().map(Arc::new);
        let robot = robot.ok_or_else(|| error(format!("no class {class}")))?;
        let joints = file.action.joints(&robot).map_err(error)?;
        let fingers = file.action.fingers(&robot).map_err(error)?;
        if file.action.twist.is_some() && base_motion::mecanum::textbook(&robot).is_none() {
            return Err(error(format!("action.twist: {class} has no Mecanum base")));
        }
        if file.action.sides.is_some() && robot.driven().next().is_none() {
            return Err(error(format!("action.sides: {class} has no driven wheels")));
        }
        if let Some(name) = &file.start.name
            && def.map.start(name).is_none()
        {
            let known = names::listed(def.map.starts.iter().map(|start| start.name.as_str()));
            return Err(error(format!("start.name: unknown start `{name}`: expected one of {known}")));
        }
        file.goal(&robot, &def.map).map_err(error)?;
        let steps = (file.control_interval / file.time_step).round() as u32;
        let horizon = (file.seconds / file.control_interval).round() as u32;
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Ok(Self { name, scene: def.into(), robot, joints, fingers, steps, horizon, file })
    }

    /// Returns the number of robots in a world.
    pub fn robots(&self) -> usize {
        self.file.robots
    }

    /// Returns the description in one sentence.
    pub fn description(&self) -> &str {
        &self.file.description
    }

    /// Returns the time between two actions, s.
    pub fn control_interval(&self) -> f64 {
        self.file.control_interval
    }

    /// Returns the actions until an episode is cut off.
    pub fn horizon(&self) -> u32 {
        self.horizon
    }

    /// Returns the number of actions of a robot.
    pub fn actions(&self) -> usize {
        let base = self.file.action.twist.map_or(0, |_| 3) + self.file.action.sides.map_or(0, |_| 2);
        base + self.joints.len() + usize::from(!self.fingers.is_empty())
    }

    /// Returns its goal, which has not begun.
    pub(crate) fn goal(&self) -> Result<Judge, String> {
        self.file.goal(&self.robot, &self.scene.def().map)
    }

    /// Returns the number of observations of a robot.
    pub fn observations(&self) -> usize {
        self.goal().map_or(0, |goal| goal.width())
    }
}

impl TaskFile {
    fn check(&self) -> Result<(), String> {
        let within = |name: &str, got: f64, least: f64, most: f64| {
            let is_good = (least..=most).contains(&got);
            is_good.then_some(()).ok_or_else(|| format!("{name}: got {got}, expected {least} to {most}"))
        };
        within("robots", self.robots as f64, 1.0, MAX_ROBOTS as f64)?;
        within("time_step", self.time_step, TIME_STEP.least, TIME_STEP.most)?;
        within("control_interval", self.control_interval, self.time_step, MAX_INTERVAL)?;
        within("seconds", self.seconds, self.control_interval, MAX_SECONDS)?;
        let steps = self.control_interval / self.time_step;
        if (steps - steps.round()).abs() > 1e-6 {
            return Err(format!("control_interval: got {} time steps, expected a whole number", steps));
        }
        let ranges = [("start.position", self.start.position)].into_iter();
        let ranges = ranges.chain(self.object.iter().map(|object| ("object.position", object.position)));
        for (name, range) in
            ranges.flat_map(|(name, range)| range.map(|range| (name, range))).chain([("start.yaw", self.start.yaw)])
        {
            check::within(name, range, check::GOAL_REACH).map_or(Ok(()), Err)?;
        }
        if let Some(ObjectSpec { size, mass, .. }) = &self.object {
            size.iter().flatten().try_for_each(|&edge| within("object.size", edge, 0.001, 10.0))?;
            mass.iter().try_for_each(|&mass| within("object.mass", mass, 0.001, 1e4))?;
        }
        let speeds = self.action.twist.into_iter().flatten().chain(self.action.sides);
        speeds.into_iter().try_for_each(|speed| within("action", speed, 0.0, 1000.0))
    }

    /// Loads the map with the object, and the robot's class.
    fn def(&self, path: &Path) -> Result<(WorldDef, String), String> {
        let overrides = self.set.iter().map(|text| text.parse()).collect::<Result<Vec<Override>, _>>();
        let overrides = overrides.map_err(|error| format!("set: {error}"))?;
        let beside = |name: &str| {
            let file = path.parent().unwrap_or(Path::new("")).join(name);
            if file.exists() { file.display().to_string() } else { name.to_owned() }
        };
        let robot = scene_loader::robot(&beside(&self.robot), &overrides).map_err(|error| error.to_string())?;
        let mut map = scene_loader::map(&beside(&self.map), &overrides).map_err(|error| error.to_string())?;
        scene_loader::check_used(&overrides).map_err(|error| error.to_string())?;
        if let Some(object) = &self.object {
            let classes = scene_loader::objects().map_err(|error| error.to_string())?;
            map.objects.push(object.made(&classes)?);
        }
        let mut robot = robot;
        if let Some(model) = &self.drive_model {
            let model = model.parse().map_err(|error| format!("drive_model: {error}"))?;
            if !robot.can_have(model) {
                return Err(format!("drive_model: {} cannot have it", robot.class));
            }
            robot.drive_model = model;
        }
        let scanner = self.explore.as_ref().map(|explore| explore.scanner.as_str());
        robot.sensors.retain(|sensor| scanner.is_some_and(|name| sensor.name.eq_ignore_ascii_case(name)));
        let class = robot.class.clone();
        let def = WorldDef { map, robots: [(class.clone(), robot)].into(), ..WorldDef::default() };
        def.check().map_err(|error| error.to_string())?;
        Ok((def, class))
    }

    /// Returns the goal, which has not begun.
    fn goal(&self, robot: &Arc<RobotDef>, map: &MapDef) -> Result<Judge, String> {
        let Self { reach, follow, push, fetch, explore, find, zone, robots, control_interval: interval, .. } = self;
        let tables = [
            reach.clone().map(Goal::Reach),
            follow.clone().map(Goal::Follow),
            push.clone().map(Goal::Push),
            fetch.clone().map(Goal::Fetch),
            explore.clone().map(Goal::Explore),
            find.clone().map(Goal::Find),
            zone.clone().map(Goal::Zone),
        ];
        let tables: Vec<Goal> = tables.into_iter().flatten().collect();
        let [goal] = &tables[..] else {
            let known = "[reach], [follow], [push], [fetch], [explore], [find] and [zone]";
            return Err(format!("expected one table of {known}"));
        };
        if let Some(problem) = check::goal(goal).into_iter().next() {
            return Err(problem);
        }
        if matches!(goal, Goal::Push(_) | Goal::Fetch(_)) && self.object.is_none() {
            return Err("expected an [object]".to_owned());
        }
        if goal.object().is_some() {
            return Err("the goal names an `object`: expected none, as it is about the task's own [object]".to_owned());
        }
        Judge::new(goal, *robots, *interval, robot, map)
    }
}

impl Action {
    /// Finds the joints by their names.
    fn joints(&self, robot: &RobotDef) -> Result<Vec<(usize, f64, [f64; 2])>, String> {
        let mut joints = Vec::new();
        for (name, speed) in &self.joints {
            let links = robot.with_values().enumerate().filter(|(_, link)| link.wheel.is_none());
            let Some((number, link)) = links.clone().find(|(_, link)| link.name.eq_ignore_ascii_case(name)) else {
                let known = names::listed(links.map(|(_, link)| link.name.as_str()));
                return Err(format!("action.joints: unknown joint `{name}`: expected some of {known}"));
            };
            let speed = speed.as_float().or(speed.as_integer().map(|whole| whole as f64));
            let Some(speed) = speed.filter(|speed| (0.0..=100.0).contains(speed)) else {
                return Err(format!("action.joints.{name}: expected a speed of 0 to 100"));
            };
            let endless = [f64::NEG_INFINITY, f64::INFINITY];
            joints.push((number, speed, link.joint.as_ref().and_then(|joint| joint.limits).unwrap_or(endless)));
        }
        Ok(joints)
    }

    /// Finds the joints of the gripper.
    fn fingers(&self, robot: &RobotDef) -> Result<Vec<(usize, [f64; 2])>, String> {
        let Some(name) = &self.gripper else { return Ok(Vec::new()) };
        let Some(gripper) = robot.grippers.iter().find(|gripper| gripper.name.eq_ignore_ascii_case(name)) else {
            return Err(format!("action.gripper: {} has no gripper `{name}`", robot.class));
        };
        let places = gripper.closed.iter().zip(&gripper.open);
        let finger = |(&link, (&closed, &open))| Some((robot.value_of(link)?, [closed, open]));
        Ok(gripper.links.iter().zip(places).filter_map(finger).collect())
    }
}

impl ObjectSpec {
    fn made(&self, classes: &std::collections::BTreeMap<String, Object>) -> Result<Object, String> {
        let Some(class) = classes.get(&self.class) else {
            let meant = names::did_you_mean(&self.class, classes.keys().map(String::as_str));
            let known = names::listed(classes.keys().map(String::as_str));
            return Err(format!("object.class: unknown class `{}`{meant}: expected one of {known}", self.class));
        };
        let mut object = class.clone();
        if let Some(size) = self.size {
            object.solid.shape = Shape::Box { size };
        }
        object.mass = self.mass.unwrap_or(object.mass);
        object.solid.name = "object".to_owned();
        object.solid.position = [self.position[0][0], self.position[1][0], -height(&object) / 2.0];
        Ok(object)
    }
}

/// Returns the height of an object that stands upright, m.
pub(crate) fn height(object: &Object) -> f64 {
    match &object.solid.shape {
        Shape::Box { size } => size[2],
        Shape::Cylinder { length, .. } => *length,
        Shape::Ball { radius } => 2.0 * radius,
        _ => 0.0,
    }
}
