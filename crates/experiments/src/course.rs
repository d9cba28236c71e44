//! Motions of an omnidirectional robot, measured in the world and compared with the exact kinematics of its wheels.

use gamebots_proto::command::{Drive, Init};
use gamebots_proto::{Command, Problem};
use kinematics::{FiniteRollers, Twist};
use nalgebra::UnitQuaternion;
use scene::WorldDef;
use sim_core::{BodyState, Options, RobotId, WheelState, World, mecanum};

/// Seconds that a robot stands before it drives, to settle on its floor.
pub(crate) const SETTLING: f64 = 0.5;
/// Seconds from the command to the beginning of what is measured.
const SPIN_UP: f64 = 2.0;
/// Metres between robots that drive side by side.
const SPACING: f64 = 2.0;

/// A motion with all wheels at one speed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Motion {
    /// Straight ahead.
    Forward,
    /// To the right.
    Right,
    /// Clockwise on the spot.
    Clockwise,
}

impl Motion {
    /// The three.
    pub const ALL: [Self; 3] = [Self::Forward, Self::Right, Self::Clockwise];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Forward => "forward",
            Self::Right => "right",
            Self::Clockwise => "clockwise",
        }
    }

    /// Signs of the wheels: front left, front right, back left, back right.
    fn signs(self) -> [f64; 4] {
        match self {
            Self::Forward => [1.0, 1.0, 1.0, 1.0],
            Self::Right => [1.0, -1.0, -1.0, 1.0],
            Self::Clockwise => [1.0, -1.0, 1.0, -1.0],
        }
    }

    /// Its part of a twist: m/s, or rad/s for turning.
    fn of(self, twist: Twist) -> f64 {
        match self {
            Self::Forward => twist.forward,
            Self::Right => twist.right,
            Self::Clockwise => twist.clockwise,
        }
    }
}

/// What cannot be measured.
#[derive(Debug, thiserror::Error)]
pub enum MotionError {
    /// The robot is not in the world's list.
    #[error("unknown robot `{0}`")]
    UnknownRobot(String),
    /// Its motion has no exact kinematics here.
    #[error("robot `{0}`: expected one with four Mecanum wheels with rollers")]
    NotOmni(String),
    /// The world takes no more robots, or not this one.
    #[error("{}", in_words(.0))]
    Refused(Vec<Problem>),
}

/// Problems in one line.
pub(crate) fn in_words(problems: &[Problem]) -> String {
    problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
}

/// Robots that drive side by side, ready to be measured.
pub struct Course {
    world: World,
    robots: Vec<RobotId>,
    kinematics: FiniteRollers,
    from: Vec<BodyState>,
    /// Angles of the four wheels of each robot, at the start and after every step.
    wheels: Vec<Vec<[f64; 4]>>,
    motion: Motion,
    /// Height of the first robot's body after every step, m.
    heights: Vec<f64>,
}

/// A moment of a motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// Seconds since the start of what is measured.
    pub time: f64,
    /// Angle of the front left wheel within its spacing of rollers, rad: 0 where a roller touches at its middle.
    pub phase: f64,
    /// Height of the body over its lowest place, m.
    pub height: f64,
}

/// What a measured motion gave, of the robot that did worst.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Travel {
    /// Displacement forward and to the right in the start frame, m, and clockwise, rad.
    pub moved: [f64; 3],
    /// Mean angle that the wheels turned, rad.
    pub turned: f64,
    /// The travel over the exact one for the angles that the wheels turned.
    pub ratio: f64,
    /// Highest less lowest place of the first robot's body, m.
    pub ripple: f64,
}

impl Course {
    /// Puts robots of a class on the map, side by side from its first start, lets them settle and brings their wheels to
    /// `speed`, rad/s.
    ///
    /// # Errors
    /// When the class is unknown or has no rollers.
    pub fn start(
        def: WorldDef,
        options: Options,
        class: &str,
        count: u32,
        motion: Motion,
        speed: f64,
    ) -> Result<Self, MotionError> {
        let robot = def.robots.get(class).ok_or_else(|| MotionError::UnknownRobot(class.to_owned()))?;
        let kinematics = mecanum::finite_rollers(robot).ok_or_else(|| MotionError::NotOmni(class.to_owned()))?;
        let [x, y, z] = def.map.starts.first().map_or([0.0; 3], |start| start.position);
        let mut world = World::new(def, options);
        let mut robots = Vec::new();
        for index in 0..count {
            let location = [x, y + f64::from(index) * SPACING, z];
            let init = Init { class_name: class.to_owned(), location, ..Init::default() };
            let mut problems = Vec::new();
            robots.push(world.init(&init, &mut problems).ok_or(MotionError::Refused(problems))?);
        }
        let mut course =
            Self { world, robots, kinematics, from: Vec::new(), wheels: Vec::new(), motion, heights: Vec::new() };
        course.run(SETTLING);
        let drive = drive_command(motion.signs().map(|sign| sign * speed));
        for &robot in &course.robots {
            course.world.execute(Some(robot), &drive, &mut Vec::new());
        }
        course.run(SPIN_UP);
        let states: Vec<_> = course.robots.iter().filter_map(|&robot| course.world.state(robot)).collect();
        course.from = states.iter().map(|(body, _)| *body).collect();
        course.wheels = states.iter().map(|(_, wheels)| vec![angles(wheels)]).collect();
        course.heights.clear();
        Ok(course)
    }

    /// Drives on for some simulated seconds.
    pub fn run(&mut self, seconds: f64) {
        for _ in 0..(seconds / self.world.time_step()).round() as u64 {
            self.world.step();
            for (index, &robot) in self.robots.iter().enumerate() {
                let Some((body, wheels)) = self.world.state(robot) else { continue };
                if index == 0 {
                    self.heights.push(-body.pose.translation.z);
                }
                if let Some(track) = self.wheels.get_mut(index) {
                    track.push(angles(&wheels));
                }
            }
        }
    }

    /// The first robot after every step since the start.
    pub fn moments(&self) -> Vec<Moment> {
        let lowest = self.lowest();
        let wheels = self.wheels.first().into_iter().flatten().skip(1);
        let moment = |(step, (wheels, height)): (usize, (&[f64; 4], &f64))| Moment {
            time: (step + 1) as f64 * self.world.time_step(),
            phase: self.kinematics.phase(0, wheels[0]),
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

    /// What the robots did since the start, turning less than half a turn.
    pub fn travel(&self) -> Option<Travel> {
        let ripple = self.heights.iter().copied().fold(f64::NEG_INFINITY, f64::max) - self.lowest();
        let travels = self.robots.iter().zip(&self.from).enumerate().filter_map(|(index, (&robot, from))| {
            let (to, _) = self.world.state(robot)?;
            let start: UnitQuaternion<f64> = from.pose.rotation;
            let displacement = start.inverse() * (to.pose.translation.vector - from.pose.translation.vector);
            let (_, _, yaw) = (start.inverse() * to.pose.rotation).euler_angles();
            let (first, last) = (self.wheels[index].first()?, self.wheels[index].last()?);
            let turned = first.iter().zip(last).map(|(first, last)| (last - first).abs()).sum::<f64>() / 4.0;
            let moved = [displacement.x, displacement.y, yaw];
            let ratio = moved[self.motion as usize] / self.exact(index);
            Some(Travel { moved, turned, ratio, ripple })
        });
        travels.max_by(|a, b| (a.ratio - 1.0).abs().total_cmp(&(b.ratio - 1.0).abs()))
    }

    /// The travel by the exact kinematics for the angles that the wheels of a robot had after every step: the rollers that
    /// touch change on the way.
    fn exact(&self, robot: usize) -> f64 {
        let pairs = self.wheels[robot].windows(2);
        pairs.map(|pair| self.motion.of(exact_step(&self.kinematics, pair[0], pair[1]))).sum()
    }
}

/// The travel of the base in a step in which its wheels turned from one set of angles to another.
pub(crate) fn exact_step(kinematics: &FiniteRollers, before: [f64; 4], after: [f64; 4]) -> Twist {
    let turned = std::array::from_fn(|wheel| after[wheel] - before[wheel]);
    let phases = std::array::from_fn(|wheel| kinematics.phase(wheel, (before[wheel] + after[wheel]) / 2.0));
    kinematics.forward(turned, phases)
}

/// A command for the four wheels, rad/s.
pub(crate) fn drive_command(speeds: [f64; 4]) -> Command {
    let keys = ["Front-Left", "Front-Right", "Back-Left", "Back-Right"];
    Command::Drive(keys.iter().zip(speeds).fold(Drive::default(), |drive, (key, speed)| drive.with(key, speed)))
}

pub(crate) fn angles(wheels: &[WheelState]) -> [f64; 4] {
    std::array::from_fn(|wheel| wheels.get(wheel).map_or(0.0, |wheel| wheel.angle))
}
