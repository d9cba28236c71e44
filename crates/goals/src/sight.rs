//! The state of a world and of its robots, as goals need it.

use nalgebra::Vector3;
use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use scene::{JointState, PawnId, Pose};
use sim_core::World;

/// State of a world, as goals need it.
#[derive(Debug, Clone, Default)]
pub struct Sight {
    /// The robots that play.
    pub robots: Vec<RobotSight>,
    /// Pose of the goal's object.
    pub object: Option<Pose>,
}

/// State of a robot, as goals need it.
#[derive(Debug, Clone)]
pub struct RobotSight {
    /// Its number.
    pub id: PawnId,
    /// Pose of its frame.
    pub pose: Pose,
    /// Its place on the floor.
    pub place: Place,
    /// Velocities in the robot's own frame: forward, right, m/s, clockwise, rad/s.
    pub velocity: [f64; 3],
    /// Every joint with a value, if the goal looks at joints.
    pub joints: Vec<JointState>,
    /// The last scan of the goal's laser, m.
    pub scan: Vec<f64>,
}

impl RobotSight {
    /// Looks at a robot, without its scan; `None` if it is gone. Joints are read if the goal looks at them.
    pub fn of(world: &World, id: PawnId, has_joints: bool) -> Option<Self> {
        let (body, _) = world.state(id)?;
        let place = Place::of(&body.pose);
        let [forward, right] = place.turned([body.linear.x, body.linear.y]);
        let joints = if has_joints { world.joints(id).unwrap_or_default() } else { Vec::new() };
        let velocity = [forward, right, body.angular.z];
        Some(Self { id, pose: body.pose, place, velocity, joints, scan: Vec::new() })
    }

    /// Returns its distance from a point of the world, m.
    pub(crate) fn distance_from(&self, point: [f64; 3]) -> f64 {
        let position: [f64; 3] = self.pose.translation.vector.into();
        let way = [0, 1, 2].map(|axis| position[axis] - point[axis]);
        way.iter().map(|it| it * it).sum::<f64>().sqrt()
    }
}

/// A place on the floor.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Place {
    /// Position, m.
    pub x: f64,
    /// Position, m.
    pub y: f64,
    /// Clockwise seen from above, rad.
    pub yaw: f64,
}

impl Place {
    /// Returns the place of a pose.
    pub fn of(pose: &Pose) -> Self {
        let ahead = pose.rotation * Vector3::x();
        let [x, y, _] = pose.translation.vector.into();
        Self { x, y, yaw: libm::atan2(ahead.y, ahead.x) }
    }

    /// Returns a point in this place's frame: forward and right, m.
    pub fn to_own(self, [x, y]: [f64; 2]) -> [f64; 2] {
        self.turned([x - self.x, y - self.y])
    }

    /// Returns a direction in this place's frame.
    pub fn turned(self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = libm::sincos(self.yaw);
        [cos * x + sin * y, cos * y - sin * x]
    }

    /// Returns the direction that another place faces, in this place's frame.
    pub fn heading_of(self, other: Self) -> [f64; 2] {
        let (sin, cos) = libm::sincos(other.yaw - self.yaw);
        [cos, sin]
    }

    /// Returns the position, m.
    pub fn point(self) -> [f64; 2] {
        [self.x, self.y]
    }
}

/// Returns the distance between two points, m.
pub fn distance([a, b]: [f64; 2], [c, d]: [f64; 2]) -> f64 {
    let (x, y) = (c - a, d - b);
    (x * x + y * y).sqrt()
}

/// Draws uniformly from a range.
pub fn draw(rng: &mut ChaCha8Rng, [low, high]: [f64; 2]) -> f64 {
    low + (high - low) * rng.random::<f64>()
}
