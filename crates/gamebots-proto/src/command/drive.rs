//! `DRIVE`: the keys of every drive family, each optional; the drive of the robot decides which count.

use super::ReadWrite;
use crate::{Line, Problem, value};

/// Sets speeds that hold until they are replaced. No reply.
///
/// Wheel speeds are rad/s, positive = forward (or percent of the limit while `Normalized` is on).
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Drive {
    /// Sticky: speeds are percent of the limit from now on.
    pub normalized: Option<bool>,
    /// Headlight, shown in STA.
    pub light: Option<bool>,
    /// Speed of the wheels on the left.
    pub left: Option<f64>,
    /// Speed of the wheels on the right.
    pub right: Option<f64>,
    /// Speed of the front left wheel (thesis line 250).
    pub front_left: Option<f64>,
    /// Speed of the front right wheel.
    pub front_right: Option<f64>,
    /// Speed of the back left wheel.
    pub back_left: Option<f64>,
    /// Speed of the back right wheel.
    pub back_right: Option<f64>,
    /// Forward velocity, m/s.
    pub linear_velocity: Option<f64>,
    /// Velocity to the right, m/s.
    pub lateral_velocity: Option<f64>,
    /// Turn rate, rad/s, clockwise seen from above.
    pub rotational_velocity: Option<f64>,
    /// `{WheelNumber n} {WheelSpeed v}` pairs in the order sent.
    pub wheels: Vec<WheelSpeed>,
}

/// One `{WheelNumber n} {WheelSpeed v}` pair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WheelSpeed {
    /// Number of the wheel from 0, in the order of the robot's wheels.
    pub number: u32,
    /// Its speed.
    pub speed: f64,
}

impl ReadWrite for Drive {
    fn read(line: &Line, problems: &mut Vec<Problem>) -> Self {
        let mut scalar = |key| value::scalar(line, key, problems);
        Self {
            left: scalar("Left"),
            right: scalar("Right"),
            front_left: scalar("Front-Left"),
            front_right: scalar("Front-Right"),
            back_left: scalar("Back-Left"),
            back_right: scalar("Back-Right"),
            linear_velocity: scalar("LinearVelocity"),
            lateral_velocity: scalar("LateralVelocity"),
            rotational_velocity: scalar("RotationalVelocity"),
            normalized: value::boolean(line, "Normalized", problems),
            light: value::boolean(line, "Light", problems),
            wheels: read_wheels(line, problems),
        }
    }

    fn write(&self) -> Line {
        let mut line = Line::new("DRIVE");
        for (key, speed) in [
            ("Front-Left", self.front_left),
            ("Front-Right", self.front_right),
            ("Back-Left", self.back_left),
            ("Back-Right", self.back_right),
            ("Left", self.left),
            ("Right", self.right),
            ("LinearVelocity", self.linear_velocity),
            ("LateralVelocity", self.lateral_velocity),
            ("RotationalVelocity", self.rotational_velocity),
        ] {
            line = speed.into_iter().fold(line, |line, speed| line.with(key, speed));
        }
        for WheelSpeed { number, speed } in &self.wheels {
            line = line.with("WheelNumber", number).with("WheelSpeed", speed);
        }
        for (key, flag) in [("Normalized", self.normalized), ("Light", self.light)] {
            line = flag.into_iter().fold(line, |line, flag| line.with(key, flag));
        }
        line
    }
}

/// A `WheelSpeed` belongs to the last `WheelNumber` before it; `WheelSteer` has no meaning for fixed wheels.
fn read_wheels(line: &Line, problems: &mut Vec<Problem>) -> Vec<WheelSpeed> {
    let mut wheels = Vec::new();
    let mut number = None;
    for block in &line.blocks {
        if block.key.eq_ignore_ascii_case("WheelNumber") {
            number = block.value.parse::<u32>().ok();
            if number.is_none() {
                problems.push(Problem::NotANumber {
                    key: block.key.clone(),
                    got: block.value.chars().take(60).collect(),
                    read_as: -1.0,
                });
            }
        } else if block.key.eq_ignore_ascii_case("WheelSpeed") {
            let speed = value::scalar_of(&block.key, &block.value, problems);
            wheels.extend(number.take().map(|number| WheelSpeed { number, speed }));
        }
    }
    wheels
}
