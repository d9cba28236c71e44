//! One world in which a task is played.

use std::sync::Arc;

use gamebots_proto::command::Init;
use goals::{Judge, RobotSight, Sight, Verdict, draw};
use kinematics::Twist;
use nalgebra::Vector3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use scene::{ObjectId, Options, Pose, Reading, Side};
use sim_core::{Order, PawnId, Report, World};

use crate::Task;
use crate::task::{ObjectSpec, height};

/// A world in which a task is played, episode by episode.
pub(crate) struct Environment {
    task: Arc<Task>,
    world: World,
    robots: Vec<PawnId>,
    /// Targets of the joints that actions move, robot by robot.
    targets: Vec<f64>,
    goal: Judge,
    sight: Sight,
    rng: ChaCha8Rng,
    /// Actions since the episode began.
    age: u32,
    /// True if the episode has ended and the next one has not begun.
    pub(crate) is_over: bool,
    /// The reason why the last episode could not begin, if any, in words.
    pub(crate) failure: Option<String>,
}

/// The end of an interval between two actions.
pub(crate) struct Interval {
    /// Rewards of the robots, and the end of the episode by the goal.
    pub(crate) verdict: Verdict,
    /// True if the time of the episode is up.
    pub(crate) is_truncated: bool,
}

impl Environment {
    /// Creates an environment whose first episode has not begun. `goal` is a goal that has not begun.
    pub(crate) fn new(task: Arc<Task>, goal: Judge, seed: u64) -> Self {
        let world = World::new(task.scene.clone(), task.options(0));
        let rng = ChaCha8Rng::seed_from_u64(seed);
        let (robots, targets, sight) = (Vec::new(), Vec::new(), Sight::default());
        Self { task, world, robots, targets, goal, sight, rng, age: 0, is_over: true, failure: None }
    }

    /// True if an episode has begun.
    pub(crate) fn has_begun(&self) -> bool {
        !self.robots.is_empty()
    }

    /// Returns the world.
    pub(crate) fn world(&self) -> &World {
        &self.world
    }

    /// Begins the random numbers anew.
    pub(crate) fn seed(&mut self, seed: u64) {
        self.rng = ChaCha8Rng::seed_from_u64(seed);
    }

    /// Begins an episode and writes the first observations. If there is no room for a robot, none begins, and `failure` says why.
    pub(crate) fn reset(&mut self, observations: &mut [f32]) {
        let (task, rng) = (self.task.clone(), &mut self.rng);
        self.world = World::new(task.scene.clone(), task.options(rng.random()));
        if let Some(object) = &task.file.object {
            put_object(&mut self.world, object, rng);
        }
        self.robots.clear();
        for _ in 0..task.robots() {
            let (init, mut problems) = (start(&task, rng), Vec::new());
            let Some(robot) = self.world.init(&init, &mut problems) else {
                self.robots.clear();
                let reason: Vec<String> = problems.iter().map(ToString::to_string).collect();
                self.failure = Some(reason.join("; "));
                return;
            };
            self.robots.push(robot);
        }
        self.world.set_reporting(task.file.explore.is_some());
        self.targets = vec![0.0; task.joints.len() * task.robots()];
        (self.age, self.is_over) = (0, false);
        self.sight.robots.clear();
        self.look(&[]);
        self.goal.begin(&self.sight, &mut self.rng);
        self.observe(observations);
    }

    /// Plays one interval: gives the actions to the robots, advances the world, and writes the observations.
    pub(crate) fn step(&mut self, actions: &[f32], observations: &mut [f32]) -> Interval {
        let (task, width) = (self.task.clone(), self.task.actions());
        for (number, actions) in actions.chunks_exact(width.max(1)).enumerate() {
            self.act(&task, number, actions);
        }
        let mut reports = Vec::new();
        for _ in 0..task.steps {
            reports.extend(self.world.step());
        }
        self.age += 1;
        let is_lost = self.look(&reports);
        let mut verdict = self.goal.judge(&mut self.world, &self.sight);
        verdict.is_over |= is_lost;
        let is_truncated = !verdict.is_over && self.age >= task.horizon;
        self.is_over = verdict.is_over || is_truncated;
        self.observe(observations);
        Interval { verdict, is_truncated }
    }

    /// Gives a robot its orders.
    fn act(&mut self, task: &Task, number: usize, actions: &[f32]) {
        let Some(&robot) = self.robots.get(number) else { return };
        let mut actions = actions.iter().map(|&action| f64::from(action).clamp(-1.0, 1.0));
        let mut next = || actions.next().unwrap_or_default();
        if let Some(most) = task.file.action.twist {
            let [forward, right, clockwise] = most.map(|most| most * next());
            self.world.order(robot, &Order::Twist(Twist { forward, right, clockwise }));
        }
        if let Some(most) = task.file.action.sides {
            let [left, right] = [next(), next()].map(|action| most * action);
            let speed = |side| Some(if side == Side::Left { left } else { right });
            let speeds = task.robot.driven().map(|wheel| speed(wheel.side)).collect();
            self.world.order(robot, &Order::Wheels(speeds));
        }
        let mut orders = Vec::new();
        let joints = task.joints.len();
        let targets = self.targets.iter_mut().skip(number * joints);
        for (&(joint, speed, [low, high]), target) in task.joints.iter().zip(targets) {
            *target = (*target + speed * next() * task.file.control_interval).clamp(low, high);
            orders.push((joint, *target));
        }
        if !task.fingers.is_empty() {
            let is_open = next() > 0.0;
            orders.extend(task.fingers.iter().map(|&(finger, places)| (finger, places[usize::from(is_open)])));
        }
        if !orders.is_empty() {
            self.world.order(robot, &Order::Joints(orders));
        }
    }

    /// Looks at the world after the last step. Returns true if a robot is gone; its last state stays.
    fn look(&mut self, reports: &[(PawnId, Report)]) -> bool {
        let (mut is_lost, has_joints) = (false, self.task.file.fetch.is_some());
        for (number, &id) in self.robots.iter().enumerate() {
            let Some(seen) = RobotSight::of(&self.world, id, has_joints) else {
                is_lost = true;
                continue;
            };
            let scan = reports.iter().rev().find_map(|(pawn, report)| match report {
                Report::Sensed(sensed) if *pawn == id => match &sensed.reading {
                    Reading::RangeScanner(reading) => Some(reading.ranges.to_vec()),
                    _ => None,
                },
                _ => None,
            });
            match self.sight.robots.get_mut(number) {
                Some(known) => *known = RobotSight { scan: scan.unwrap_or(std::mem::take(&mut known.scan)), ..seen },
                None => self.sight.robots.push(RobotSight { scan: scan.unwrap_or_default(), ..seen }),
            }
        }
        self.sight.object = self.task.object().and_then(|id| self.world.object(id));
        is_lost
    }

    fn observe(&self, observations: &mut [f32]) {
        let mut places = observations.iter_mut();
        for robot in 0..self.sight.robots.len() {
            let push = &mut |number: f64| places.next().into_iter().for_each(|place| *place = number as f32);
            self.goal.observe(&self.sight, robot, push);
        }
        places.for_each(|place| *place = 0.0);
    }
}

impl Task {
    fn options(&self, seed: u64) -> Options {
        Options { seed, time_step: self.file.time_step, ..Options::default() }
    }

    /// Returns the task's object, which is the map's last.
    fn object(&self) -> Option<ObjectId> {
        self.file.object.as_ref()?;
        Some(ObjectId(self.scene.def().map.objects.len() as u64 - 1))
    }
}

/// Draws where a robot starts.
fn start(task: &Task, rng: &mut ChaCha8Rng) -> Init {
    let range = &task.file.start;
    let [x, y] = range.position.map(|range| draw(rng, range));
    let named = range.name.as_ref().and_then(|name| task.scene.def().map.start(name));
    let pose = named.map_or_else(Pose::identity, |named| scene::pose(named.position, named.rotation));
    let pose = pose * scene::pose([x, y, 0.0], [0.0, 0.0, draw(rng, range.yaw)]);
    let (location, rotation) = scene::position_and_rotation(&pose);
    Init { class_name: task.robot.class.clone(), location, rotation, ..Init::default() }
}

/// Puts the task's object on the floor.
fn put_object(world: &mut World, object: &ObjectSpec, rng: &mut ChaCha8Rng) {
    let Some((number, def)) = world.def().map.objects.iter().enumerate().next_back() else { return };
    let up = -height(def) / 2.0;
    let [x, y] = object.position.map(|range| draw(rng, range));
    let yaw = draw(rng, [-std::f64::consts::PI, std::f64::consts::PI]);
    let rotation = nalgebra::UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw);
    world.put_object(ObjectId(number as u64), &Pose::from_parts([x, y, up].into(), rotation));
}
