//! Motions of wheeled robots, measured in the world and compared with the exact travel for the angles that the wheels turned.

use gamebots_proto::command::{Drive, Init};
use gamebots_proto::{Command, Problem};
use kinematics::{FiniteRollers, Twist};
use nalgebra::{UnitQuaternion, Vector3};
use scene::{RobotDef, Steering, wrapped};
use sim_core::{BodyState, PawnId, SolverEffort, WheelState, World};

use crate::reference::Reference;

/// Time that a robot stands before it drives, to settle on its floor, s.
pub(crate) const SETTLING: f64 = 0.5;
/// Time from the command to the start of the measurement, s.
const SPIN_UP: f64 = 2.0;
/// Last part of the spin-up, in which the loads of the wheels are averaged, s.
const WEIGHING: f64 = 0.5;
/// Distance between robots that drive side by side, m.
const SPACING: f64 = 2.0;

/// A steady motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Motion {
    /// Straight ahead.
    Forward,
    /// To the right.
    Right,
    /// Clockwise on the spot.
    Clockwise,
    /// Ahead and to the right: the right side at half the speed of the left, or steered by half the greatest angle.
    Curve,
}

impl Motion {
    /// Motions of Mecanum bases, with all wheels at one speed.
    pub const ALL: [Self; 3] = [Self::Forward, Self::Right, Self::Clockwise];

    /// Returns the motions that a robot can make.
    pub fn of_robot(robot: &RobotDef) -> &'static [Self] {
        match robot.steering {
            Steering::Omni => &Self::ALL,
            Steering::Ackermann => &[Self::Forward, Self::Curve],
            _ => &[Self::Forward, Self::Clockwise, Self::Curve],
        }
    }

    /// Returns its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Forward => "forward",
            Self::Right => "right",
            Self::Clockwise => "clockwise",
            Self::Curve => "curve",
        }
    }

    /// Returns the command that brings the wheels to a speed, rad/s.
    pub(crate) fn command(self, robot: &RobotDef, speed: f64) -> Command {
        match (robot.steering, self) {
            (Steering::Omni, Self::Right) => drive_command([speed, -speed, -speed, speed]),
            (Steering::Omni, Self::Clockwise) => drive_command([speed, -speed, speed, -speed]),
            (Steering::Omni, _) => drive_command([speed; 4]),
            (Steering::Ackermann, _) => {
                let half =
                    |axle| robot.steering_limits(axle).map(|[_, most]| most / 2.0).reduce(f64::min).unwrap_or(0.0);
                // A car that steers only its rear wheels has to turn those.
                let [front, rear] = if half(0) > 0.0 { [half(0), 0.0] } else { [0.0, half(1)] };
                let share = if self == Self::Curve { 1.0 } else { 0.0 };
                drive(&[("Speed", speed), ("FrontSteer", share * front), ("RearSteer", share * rear)])
            }
            (_, Self::Clockwise) => drive(&[("Left", speed), ("Right", -speed)]),
            (_, Self::Curve) => drive(&[("Left", speed), ("Right", speed / 2.0)]),
            (_, _) => drive(&[("Left", speed), ("Right", speed)]),
        }
    }

    /// Returns the component of a twist along this motion: m/s, or rad/s for turning.
    fn of(self, twist: Twist) -> f64 {
        match self {
            Self::Forward => twist.forward,
            Self::Right => twist.right,
            Self::Clockwise | Self::Curve => twist.clockwise,
        }
    }
}

/// Errors of a measured motion.
#[derive(Debug, thiserror::Error)]
pub enum MotionError {
    /// The robot is not in the world's list.
    #[error("unknown robot `{0}`")]
    UnknownRobot(String),
    /// The exact kinematics of its motion are not known.
    #[error("robot `{0}`: expected one with four Mecanum wheels with rollers")]
    NotOmni(String),
    /// The robot has no driven wheels.
    #[error("robot `{0}`: expected one with driven wheels")]
    NotWheeled(String),
    /// The robot has fewer checks.
    #[error("robot `{class}` has no check {number}: expected 1 to {most}")]
    NoCheck {
        /// Class of the robot.
        class: String,
        /// Requested number.
        number: u32,
        /// Number of checks it has.
        most: usize,
    },
    /// The world refuses the robot.
    #[error("{}", in_words(.0))]
    Refused(Vec<Problem>),
}

/// Joins problems into one line.
pub(crate) fn in_words(problems: &[Problem]) -> String {
    problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
}

/// Interval between samples of all robots, s. Wheels turn by a twentieth of a roller's spacing meanwhile.
const LOOKING_INTERVAL: f64 = 0.05;

/// Robots that drive side by side, ready for measurement.
pub struct Course {
    world: World,
    robots: Vec<PawnId>,
    /// Exact kinematics for each robot.
    references: Vec<Reference>,
    from: Vec<BodyState>,
    /// Angles of the driven wheels of each robot, at the start and at every sample.
    wheels: Vec<Track>,
    /// Current heading of each robot, and its turn since the start, rad.
    headings: Vec<[f64; 2]>,
    motion: Motion,
    /// Height of the first robot's body after every step, m.
    heights: Vec<f64>,
}

/// Angles of the wheels of one robot, sample by sample, rad.
#[derive(Default)]
struct Track {
    wheels: usize,
    angles: Vec<f64>,
}

impl Track {
    fn push(&mut self, wheels: &[WheelState]) {
        self.wheels = wheels.len();
        self.angles.extend(wheels.iter().map(|wheel| wheel.angle));
    }

    fn moments(&self) -> std::slice::ChunksExact<'_, f64> {
        self.angles.chunks_exact(self.wheels.max(1))
    }

    /// Returns the angle that each wheel turned, rad.
    fn turned(&self) -> Option<Vec<f64>> {
        let (first, last) = (self.moments().next()?, self.moments().next_back()?);
        Some(first.iter().zip(last).map(|(first, last)| last - first).collect())
    }
}

/// One sample of a motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// Time since the start of the measurement, s.
    pub time: f64,
    /// Angle of the front left wheel within its spacing of rollers, rad: 0 if a roller touches at its middle, and without rollers.
    pub phase: f64,
    /// Height of the body above its lowest position, m.
    pub height: f64,
}

/// Result of a measured motion, for the robot with the largest deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Travel {
    /// Displacement forward and to the right in the start frame, m, and clockwise, rad.
    pub moved: [f64; 3],
    /// Mean angle that the wheels turned, rad.
    pub turned: f64,
    /// Measured travel over the exact one for the angles that the wheels turned.
    pub ratio: f64,
    /// Difference between the highest and lowest position of the first robot's body, m.
    pub ripple: f64,
}

impl Course {
    /// Spawns robots of a class side by side from the first start of a new world. Lets them settle and brings their wheels to
    /// `speed`, rad/s.
    ///
    /// # Errors
    /// When the class is unknown or has no driven wheels, or the world refuses a robot.
    pub fn start(mut world: World, class: &str, count: u32, motion: Motion, speed: f64) -> Result<Self, MotionError> {
        let robot = world.def().robots.get(class).ok_or_else(|| MotionError::UnknownRobot(class.to_owned()))?;
        let reference = || Reference::of(robot).ok_or_else(|| MotionError::NotWheeled(class.to_owned()));
        let references = (0..count).map(|_| reference()).collect::<Result<_, _>>()?;
        let drive = motion.command(robot, speed);
        let [x, y, z] = world.def().map.starts.first().map_or([0.0; 3], |start| start.position);
        let mut robots = Vec::new();
        for index in 0..count {
            let location = [x, y + f64::from(index) * SPACING, z];
            let init = Init { class_name: class.to_owned(), location, ..Init::default() };
            let mut problems = Vec::new();
            robots.push(world.init(&init, &mut problems).ok_or(MotionError::Refused(problems))?);
        }
        let mut course = Self {
            world,
            robots,
            references,
            from: Vec::new(),
            wheels: Vec::new(),
            headings: Vec::new(),
            motion,
            heights: Vec::new(),
        };
        course.run(SETTLING);
        for &robot in &course.robots {
            course.world.execute(Some(robot), &drive, &mut Vec::new());
        }
        course.run(SPIN_UP - WEIGHING);
        course.weigh(WEIGHING);
        let states: Vec<_> = course.robots.iter().filter_map(|&robot| course.world.state(robot)).collect();
        course.from = states.iter().map(|(body, _)| *body).collect();
        course.wheels = states.iter().map(|_| Track::default()).collect();
        course.wheels.iter_mut().zip(&states).for_each(|(track, (_, wheels))| track.push(wheels));
        course.headings = states.iter().map(|(body, _)| [heading(body), 0.0]).collect();
        course.heights.clear();
        Ok(course)
    }

    /// Drives on for some simulated seconds.
    pub fn run(&mut self, seconds: f64) {
        let steps = (seconds / self.world.time_step()).round() as u64;
        let every = (LOOKING_INTERVAL / self.world.time_step()).ceil() as u64;
        for step in 1..=steps {
            self.world.step();
            // The first robot is sampled in every step.
            let count = if step % every == 0 || step == steps { self.robots.len() } else { 1 };
            for (index, &robot) in self.robots.iter().take(count).enumerate() {
                let Some((body, wheels)) = self.world.state(robot) else { continue };
                if index == 0 {
                    self.heights.push(-body.pose.translation.z);
                }
                if let Some(track) = self.wheels.get_mut(index) {
                    track.push(&wheels);
                }
                if let Some([before, turned]) = self.headings.get_mut(index) {
                    let now = heading(&body);
                    *turned += wrapped(now - *before);
                    *before = now;
                }
            }
        }
    }

    /// Drives on and averages the loads of the wheels.
    fn weigh(&mut self, seconds: f64) {
        for _ in 0..(seconds / self.world.time_step()).round() as u64 {
            self.world.step();
            for (reference, &robot) in self.references.iter_mut().zip(&self.robots) {
                if let Reference::Sliding(sliding) = reference
                    && let Some(floor) = self.world.def().map.solids.first()
                    && let (Some(def), Some(snapshot)) = (self.world.robot(robot), self.world.observe(robot))
                {
                    sliding.note(&floor.material, def, &snapshot);
                }
            }
        }
    }

    /// Returns the samples of the first robot, one for every step since the start.
    pub fn moments(&self) -> Vec<Moment> {
        let lowest = self.lowest();
        let wheels = self.wheels.first().into_iter().flat_map(Track::moments).skip(1);
        let phase = |angles: &[f64]| match self.references.first() {
            Some(Reference::Rollers(rollers)) => rollers.phase(0, angles[0]),
            _ => 0.0,
        };
        let moment = |(step, (wheels, height)): (usize, (&[f64], &f64))| Moment {
            time: (step + 1) as f64 * self.world.time_step(),
            phase: phase(wheels),
            height: height - lowest,
        };
        wheels.zip(&self.heights).enumerate().map(moment).collect()
    }

    fn lowest(&self) -> f64 {
        self.heights.iter().copied().fold(f64::INFINITY, f64::min)
    }

    /// See [`World::digest`].
    pub fn digest(&self) -> u64 {
        self.world.digest()
    }

    /// See [`World::solver_effort`].
    pub fn solver_effort(&self) -> SolverEffort {
        self.world.solver_effort()
    }

    /// Returns the travel since the start of the robot with the largest deviation.
    pub fn travel(&self) -> Option<Travel> {
        let ripple = self.heights.iter().copied().fold(f64::NEG_INFINITY, f64::max) - self.lowest();
        let travels = self.robots.iter().zip(&self.from).enumerate().filter_map(|(index, (&robot, from))| {
            let (to, _) = self.world.state(robot)?;
            let start: UnitQuaternion<f64> = from.pose.rotation;
            let displacement = start.inverse() * (to.pose.translation.vector - from.pose.translation.vector);
            let [_, yaw] = *self.headings.get(index)?;
            let turned = self.wheels[index].turned()?;
            let turned = turned.iter().map(|angle| angle.abs()).sum::<f64>() / turned.len() as f64;
            let moved = Twist { forward: displacement.x, right: displacement.y, clockwise: yaw };
            let ratio = self.motion.of(moved) / self.exact(index);
            Some(Travel { moved: [displacement.x, displacement.y, yaw], turned, ratio, ripple })
        });
        travels.max_by(|a, b| (a.ratio - 1.0).abs().total_cmp(&(b.ratio - 1.0).abs()))
    }

    /// Returns the travel that follows from a robot's wheel angles on the way. With rollers it is summed, as the touching rollers
    /// change. Plain wheels turn steadily, so their mean speeds suffice.
    fn exact(&self, robot: usize) -> f64 {
        let (reference, track) = (&self.references[robot], &self.wheels[robot]);
        match reference {
            Reference::Rollers(rollers) => {
                let four = |angles: &[f64]| std::array::from_fn(|wheel| angles[wheel]);
                let steps = track.moments().zip(track.moments().skip(1));
                steps.map(|(before, after)| self.motion.of(exact_step(rollers, four(before), four(after)))).sum()
            }
            Reference::Sliding(sliding) => {
                // Friction does not depend on speed, so the angles serve as speeds over one unit of time.
                track.turned().map_or(0.0, |turned| self.motion.of(sliding.twist(&turned)))
            }
        }
    }
}

/// Returns the travel of the base in a step in which its wheels turned from one set of angles to another.
pub(crate) fn exact_step(kinematics: &FiniteRollers, before: [f64; 4], after: [f64; 4]) -> Twist {
    let turned = std::array::from_fn(|wheel| after[wheel] - before[wheel]);
    let phases = std::array::from_fn(|wheel| kinematics.phase(wheel, (before[wheel] + after[wheel]) / 2.0));
    kinematics.forward(turned, phases)
}

/// Returns the heading clockwise from the world's x axis, rad.
pub(crate) fn heading(body: &BodyState) -> f64 {
    let ahead = body.pose.rotation * Vector3::x();
    ahead.y.atan2(ahead.x)
}

/// Returns a command for the four wheels, rad/s.
pub(crate) fn drive_command(speeds: [f64; 4]) -> Command {
    let keys = ["Front-Left", "Front-Right", "Back-Left", "Back-Right"];
    drive(&std::array::from_fn::<_, 4, _>(|wheel| (keys[wheel], speeds[wheel])))
}

pub(crate) fn drive(values: &[(&str, f64)]) -> Command {
    Command::Drive(values.iter().fold(Drive::default(), |drive, (key, value)| drive.with(key, *value)))
}

/// Returns the angles of all driven wheels, rad.
pub(crate) fn angles_of(wheels: &[WheelState]) -> Vec<f64> {
    wheels.iter().map(|wheel| wheel.angle).collect()
}

pub(crate) fn angles(wheels: &[WheelState]) -> [f64; 4] {
    std::array::from_fn(|wheel| wheels.get(wheel).map_or(0.0, |wheel| wheel.angle))
}
