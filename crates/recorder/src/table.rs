//! Recorded states as a table of numbers.

use scene::JointState;

use crate::{Log, Record, RobotState};

/// States of robots as columns. SI units, world frame (x forward, y right, z down).
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    /// The columns, of equal length. First `time` (s) and `robot` (number), then `x`, `y`, `z` (m), `qx`, `qy`, `qz`, `qw`,
    /// `roll`, `pitch`, `yaw` (rad), `vx`, `vy`, `vz` (m/s), `wx`, `wy`, `wz` (rad/s). Each wheel with a joint value adds
    /// `wheel_angle_1` (rad) and `wheel_speed_1` (rad/s). Each other joint adds `joint_position_1` (rad or m) and
    /// `joint_speed_1` (rad/s or m/s).
    pub columns: Vec<Column>,
}

/// One quantity.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Its name.
    pub name: String,
    /// Its values; NaN if a robot has fewer wheels or joints than another.
    pub values: Vec<f64>,
}

const FIXED: [&str; 18] = [
    "time", "robot", "x", "y", "z", "qx", "qy", "qz", "qw", "roll", "pitch", "yaw", "vx", "vy", "vz", "wx", "wy", "wz",
];

impl Table {
    /// Builds the table of a log's states, of one robot or of all.
    pub fn of(log: &Log, robot: Option<u64>) -> Self {
        let states: Vec<(f64, &RobotState)> = log
            .entries
            .iter()
            .filter_map(|entry| match &entry.record {
                Record::State(state) if robot.is_none_or(|robot| robot == state.robot) => Some((entry.time, state)),
                _ => None,
            })
            .collect();
        let robots = log.scene().map(|scene| scene.robots).unwrap_or_default();
        let joints = |state: &RobotState| state.wheels_and_others(robots.get(&state.class));
        let most = states.iter().fold([0; 2], |most, (_, state)| {
            let counts = joints(state).map(|joints| joints.len());
            [most[0].max(counts[0]), most[1].max(counts[1])]
        });
        let names = FIXED.map(str::to_owned).into_iter();
        let wheels = (1..=most[0]).flat_map(|wheel| ["angle", "speed"].map(|what| format!("wheel_{what}_{wheel}")));
        let others = (1..=most[1]).flat_map(|joint| ["position", "speed"].map(|what| format!("joint_{what}_{joint}")));
        let names = names.chain(wheels).chain(others);
        let mut columns: Vec<Column> =
            names.map(|name| Column { name, values: Vec::with_capacity(states.len()) }).collect();
        for (time, state) in states {
            for (column, value) in columns.iter_mut().zip(row(time, state, &joints(state), most)) {
                column.values.push(value);
            }
        }
        Self { columns }
    }

    /// Returns the values of a column.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        self.columns.iter().find(|column| column.name == name).map(|column| column.values.as_slice())
    }

    /// Returns the number of states.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |column| column.values.len())
    }

    /// Formats the table as lines of CSV, the names first. Numbers read back with the same bits.
    pub fn to_csv(&self) -> impl Iterator<Item = String> {
        let names: Vec<&str> = self.columns.iter().map(|column| column.name.as_str()).collect();
        let line = |row: usize| {
            let numbers: Vec<String> = self.columns.iter().map(|column| column.values[row].to_string()).collect();
            numbers.join(",")
        };
        std::iter::once(names.join(",")).chain((0..self.rows()).map(line))
    }

    /// Formats the poses as lines for evo and the TUM tools: `time x y z qx qy qz qw`, in the world frame.
    pub fn to_tum(&self) -> impl Iterator<Item = String> {
        let columns = ["time", "x", "y", "z", "qx", "qy", "qz", "qw"].map(|name| self.column(name).unwrap_or_default());
        (0..self.rows()).map(move |row| columns.map(|values| values[row].to_string()).join(" "))
    }
}

fn row(time: f64, state: &RobotState, joints: &[Vec<JointState>; 2], most: [usize; 2]) -> impl Iterator<Item = f64> {
    let pose = state.pose();
    let (roll, pitch, yaw) = pose.rotation.euler_angles();
    let (linear, angular) = state.velocity();
    let missing = JointState { position: f64::NAN, speed: f64::NAN };
    let filled = |kind: usize| {
        let joints = joints[kind].iter().copied().chain(std::iter::repeat(missing)).take(most[kind]);
        joints.flat_map(|joint| [joint.position, joint.speed]).collect::<Vec<f64>>()
    };
    [time, state.robot as f64]
        .into_iter()
        .chain(<[f64; 3]>::from(pose.translation.vector))
        .chain(<[f64; 4]>::from(pose.rotation.coords))
        .chain([roll, pitch, yaw])
        .chain(<[f64; 3]>::from(linear))
        .chain(<[f64; 3]>::from(angular))
        .chain(filled(0))
        .chain(filled(1))
}
