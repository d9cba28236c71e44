//! Goals of tasks, one file each: what a robot observes, and what it is rewarded for.

pub(crate) mod explore;
pub(crate) mod fetch;
pub(crate) mod follow;
pub(crate) mod push;
pub(crate) mod reach;

use nalgebra::Vector3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use scene::{JointState, Pose};

/// The result of one control interval for the robots of a world.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Verdict {
    /// Reward of each robot.
    pub(crate) rewards: Vec<f64>,
    /// True if the goal is reached, or cannot be reached any longer.
    pub(crate) is_over: bool,
    /// True if the goal is reached.
    pub(crate) is_success: bool,
}

/// A goal, as it is played in one world.
pub(crate) trait Goal: Send + Sync {
    /// Returns the number of observations of a robot.
    fn width(&self) -> usize;

    /// Begins an episode.
    fn reset(&mut self, sight: &Sight, rng: &mut ChaCha8Rng);

    /// Pushes the observations of a robot.
    fn observe(&self, sight: &Sight, robot: usize, push: &mut dyn FnMut(f64));

    /// Judges a control interval.
    fn judge(&mut self, sight: &Sight) -> Verdict;
}

/// State of a world, as goals need it.
#[derive(Debug, Clone, Default)]
pub(crate) struct Sight {
    pub(crate) robots: Vec<RobotSight>,
    /// Pose of the task's object.
    pub(crate) object: Option<Pose>,
}

/// State of a robot, as goals need it.
#[derive(Debug, Clone)]
pub(crate) struct RobotSight {
    pub(crate) pose: Pose,
    pub(crate) place: Place,
    /// Velocities in the robot's own frame: forward, right, m/s, clockwise, rad/s.
    pub(crate) velocity: [f64; 3],
    /// Every joint with a value, if the goal looks at joints.
    pub(crate) joints: Vec<JointState>,
    /// The last scan of the task's laser, m.
    pub(crate) scan: Vec<f64>,
}

/// A place on the floor.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Place {
    pub(crate) x: f64,
    pub(crate) y: f64,
    /// Clockwise seen from above, rad.
    pub(crate) yaw: f64,
}

impl Place {
    pub(crate) fn of(pose: &Pose) -> Self {
        let ahead = pose.rotation * Vector3::x();
        let [x, y, _] = pose.translation.vector.into();
        Self { x, y, yaw: libm::atan2(ahead.y, ahead.x) }
    }

    /// Returns a point in this place's frame: forward and right, m.
    pub(crate) fn to_own(self, [x, y]: [f64; 2]) -> [f64; 2] {
        self.turned([x - self.x, y - self.y])
    }

    /// Returns a direction in this place's frame.
    pub(crate) fn turned(self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = libm::sincos(self.yaw);
        [cos * x + sin * y, cos * y - sin * x]
    }

    /// Returns the direction that another place faces, in this place's frame.
    pub(crate) fn heading_of(self, other: Self) -> [f64; 2] {
        let (sin, cos) = libm::sincos(other.yaw - self.yaw);
        [cos, sin]
    }

    pub(crate) fn point(self) -> [f64; 2] {
        [self.x, self.y]
    }
}

/// Returns the distance between two points, m.
pub(crate) fn distance([a, b]: [f64; 2], [c, d]: [f64; 2]) -> f64 {
    let (x, y) = (c - a, d - b);
    (x * x + y * y).sqrt()
}

/// Draws uniformly from a range.
pub(crate) fn draw(rng: &mut ChaCha8Rng, [low, high]: [f64; 2]) -> f64 {
    low + (high - low) * rng.random::<f64>()
}

/// Checks that a range is ordered and within bounds.
pub(crate) fn check_range(name: &str, [low, high]: [f64; 2], least: f64, most: f64) -> Result<(), String> {
    if low >= least && high <= most && low <= high {
        return Ok(());
    }
    Err(format!("{name}: got {low} to {high}, expected a range within {least} to {most}"))
}
