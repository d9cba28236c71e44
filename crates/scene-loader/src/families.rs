//! Families of robots, by which lists of classes are ordered.

use scene::{RobotDef, Steering};

/// A family of robots.
#[derive(Debug, Clone, Copy)]
pub struct Family {
    /// Title of its chapter.
    pub title: &'static str,
    /// Commands that drive its robots.
    pub driving: &'static str,
    has: fn(&RobotDef) -> bool,
}

impl Family {
    /// True for a robot of the family. Each robot is of one family.
    pub fn has(&self, robot: &RobotDef) -> bool {
        (self.has)(robot)
    }
}

/// All families.
pub const FAMILIES: [Family; 7] = [
    Family {
        title: "On wheels",
        driving: "Skid steering: `DRIVE {Left l} {Right r}`, rad/s.",
        has: |robot| skids(robot) && !has_tracks(robot),
    },
    Family {
        title: "On tracks",
        driving: "Skid steering as on wheels. `MULTIDRIVE {joint angle}` moves flippers.",
        has: |robot| skids(robot) && has_tracks(robot),
    },
    Family {
        title: "On Mecanum wheels",
        driving: "`DRIVE {LinearVelocity x} {LateralVelocity y} {RotationalVelocity r}`, m/s and rad/s, or each wheel.",
        has: |robot| robot.steering == Steering::Omni,
    },
    Family {
        title: "Cars",
        driving: "`DRIVE {Speed s} {FrontSteer f} {RearSteer r}`, rad/s and rad.",
        has: |robot| robot.steering == Steering::Ackermann,
    },
    Family {
        title: "In the air and under water",
        driving: "`DRIVE {LinearVelocity x} {LateralVelocity y} {AltitudeVelocity z} {RotationalVelocity r}`, m/s and degrees/s.",
        has: |robot| robot.steering == Steering::Aerial,
    },
    Family {
        title: "On legs",
        driving: "No DRIVE: `SET {Type Joint}` moves joints.",
        has: |robot| robot.steering == Steering::Legged,
    },
    Family {
        title: "Fixed to the ground",
        driving: "No DRIVE: `ACT` moves arms.",
        has: |robot| robot.steering == Steering::None,
    },
];

fn skids(robot: &RobotDef) -> bool {
    robot.steering == Steering::Skid
}

fn has_tracks(robot: &RobotDef) -> bool {
    robot.driven().any(|wheel| wheel.wheel.belt.is_some())
}
