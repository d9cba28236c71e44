//! Goals of tasks and leagues, as plain data. The crate `goals` judges them.

use serde::{Deserialize, Serialize};

/// A goal. A task has one as a table, `[reach]`; a league has any number, each in a `[[goal]]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Goal {
    /// A robot is at a point.
    Reach(Reach),
    /// A robot has followed a path.
    Follow(Follow),
    /// The object is at a point.
    Push(Push),
    /// The object is at a point, by a gripper.
    Fetch(Fetch),
    /// A laser has seen an area.
    Explore(Explore),
    /// A robot sees a victim from nearby.
    Find(Find),
    /// A robot is in a box.
    Zone(Zone),
}

/// A point for robots to reach.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reach {
    /// The point, x and y, m.
    #[serde(default)]
    pub point: Option<[f64; 2]>,
    /// Least and most distance of a random point from the robot at its start, m, where no point is given.
    #[serde(default)]
    pub distance: Option<[f64; 2]>,
    /// Distance at which a robot has arrived, m.
    pub tolerance: f64,
}

/// A path to follow.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Follow {
    /// Points of the path in the frame of the robot at its start: forward and right, m. It begins at the robot.
    pub points: Vec<[f64; 2]>,
    /// Distance between the points ahead that a robot observes, m.
    #[serde(default = "half_a_metre")]
    pub spacing: f64,
    /// Distance beside the path at which the robot has lost it, m.
    pub most_beside: f64,
    /// True to mirror half of the paths.
    #[serde(default)]
    pub mirror: bool,
}

/// A point for an object.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Push {
    /// Name of an object of the map; a task has an object of its own.
    #[serde(default)]
    pub object: Option<String>,
    /// Least and most of x and y of the point, m.
    pub target: [[f64; 2]; 2],
    /// Distance at which the object is there, m, in the plane.
    pub tolerance: f64,
}

/// A point for an object that a gripper brings.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Fetch {
    /// Name of an object of the map; a task has an object of its own.
    #[serde(default)]
    pub object: Option<String>,
    /// Least and most of x and y of the point, m.
    pub target: [[f64; 2]; 2],
    /// Distance at which the object is there, m, in the plane.
    pub tolerance: f64,
    /// Name of the gripper.
    pub gripper: String,
}

/// An area to see with a laser.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Explore {
    /// Least and most of x and y of the area, m.
    pub area: [[f64; 2]; 2],
    /// Edge of a cell of the area, m.
    pub cell: f64,
    /// Name of the laser.
    pub scanner: String,
    /// Distance up to which a beam sees the floor, m.
    pub sight: f64,
    /// Part of the cells that is enough.
    #[serde(default = "all")]
    pub part: f64,
}

/// A victim to find.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Find {
    /// Name of the victim.
    pub victim: String,
    /// Greatest distance between robot frame and pelvis, m.
    pub radius: f64,
}

/// An upright box for robots to be in.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Zone {
    /// Middle, m.
    pub position: [f64; 3],
    /// Edge lengths along the axes of the world, m.
    pub size: [f64; 3],
}

fn half_a_metre() -> f64 {
    0.5
}

fn all() -> f64 {
    1.0
}

impl Goal {
    /// Returns the name of the object that it is about, if it is about one of the map.
    pub fn object(&self) -> Option<&str> {
        match self {
            Self::Push(Push { object, .. }) | Self::Fetch(Fetch { object, .. }) => object.as_deref(),
            Self::Reach(_) | Self::Follow(_) | Self::Explore(_) | Self::Find(_) | Self::Zone(_) => None,
        }
    }

    /// Returns the name of the laser that it needs, if any.
    pub fn scanner(&self) -> Option<&str> {
        match self {
            Self::Explore(explore) => Some(&explore.scanner),
            Self::Reach(_) | Self::Follow(_) | Self::Push(_) | Self::Fetch(_) | Self::Find(_) | Self::Zone(_) => None,
        }
    }
}

impl Explore {
    /// Returns the number of all cells. It may be too large for an integer.
    pub fn cell_count(&self) -> f64 {
        self.cells().iter().map(|&count| count as f64).product()
    }

    /// Returns the number of cells along x and y.
    pub fn cells(&self) -> [usize; 2] {
        self.area.map(|[low, high]| ((high - low) / self.cell).ceil().max(1.0) as usize)
    }
}

impl Zone {
    /// True if a point of the world, m, is inside.
    pub fn contains(&self, point: [f64; 3]) -> bool {
        (0..3).all(|axis| (point[axis] - self.position[axis]).abs() <= self.size[axis] / 2.0)
    }
}
