//! Published measurements of real robots, each beside its simulation.
//!
//! A file has one robot: its dimensions, its floor, what was measured, and the source of each number. Nothing in it is fitted to what the
//! simulation gives, but for tyres, which say so.

mod robot;

use gamebots_proto::command::Init;
use nalgebra::Vector3;
use scene::wrapped;
use serde::{Deserialize, Serialize};
use sim_core::{Options, World};

use crate::course::MotionError;
pub use robot::{Dimensions, Floor};

/// Speed of the faster side's wheels, m/s.
const SPEED: f64 = 0.4;
/// Time in which a robot settles and comes to its speed, and time of a measurement, s.
const TIMES: [f64; 2] = [3.0, 6.0];

/// A robot and what was measured with it.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measured {
    /// Name of the robot.
    pub name: String,
    /// Publication or file that the numbers are from.
    pub source: String,
    /// What a reader has to know.
    pub note: Option<String>,
    /// Dimensions.
    pub robot: Dimensions,
    /// Floor.
    pub floor: Floor,
    /// Turns on the spot and curves.
    #[serde(default)]
    pub turn: Vec<Turn>,
}

/// The turn of a robot with wheels that slide.
#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Turn {
    /// Sum of the sides' wheel speeds over their difference: 0 is a turn on the spot.
    pub curvature: f64,
    /// Effective over geometric track: difference of the wheel speeds over track and yaw rate.
    pub chi: f64,
    /// Standard deviation.
    pub spread: Option<f64>,
}

/// One number beside its simulation.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// Quantity.
    pub what: String,
    /// Of the real robot.
    pub real: f64,
    /// Its standard deviation.
    pub spread: Option<f64>,
    /// In the simulation.
    pub ours: f64,
}

/// Runs every measurement of a file.
///
/// # Errors
/// When the world refuses the robot.
pub fn run(measured: &Measured) -> Result<Vec<Row>, MotionError> {
    let row = |turn: &Turn| {
        Ok(Row {
            what: format!("chi at curvature {}", turn.curvature),
            real: turn.chi,
            spread: turn.spread,
            ours: chi(measured, turn.curvature)?,
        })
    };
    measured.turn.iter().map(row).collect()
}

/// Measures the effective over the geometric track at a curvature.
fn chi(measured: &Measured, curvature: f64) -> Result<f64, MotionError> {
    let Dimensions { track, radius, .. } = measured.robot;
    let mut world = World::new(measured.robot.world(measured.floor), Options::default());
    let location = Vector3::zeros().into();
    let mut problems = Vec::new();
    let init = Init { class_name: robot::CLASS.to_owned(), location, ..Init::default() };
    let id = world.init(&init, &mut problems).ok_or(MotionError::Refused(problems))?;
    let fast = SPEED / radius;
    let slow = fast * (curvature - 1.0) / (curvature + 1.0);
    world.execute(Some(id), &robot::turn([fast, slow]), &mut Vec::new());
    let steps = |seconds: f64| (seconds / world.time_step()).round() as u64;
    let [before, during] = TIMES.map(steps);
    (0..before).for_each(|_| drop(world.step()));
    let difference = |world: &World| {
        let wheels = world.state(id).map(|(_, wheels)| wheels).unwrap_or_default();
        wheels.first().zip(wheels.get(1)).map_or(0.0, |(left, right)| left.angle - right.angle)
    };
    let heading = |world: &World| world.state(id).map_or(0.0, |(body, _)| body.pose.rotation.euler_angles().2);
    let start = difference(&world);
    let (mut turned, mut last) = (0.0, heading(&world));
    for _ in 0..during {
        world.step();
        let now = heading(&world);
        turned += wrapped(now - last);
        last = now;
    }
    Ok((difference(&world) - start) * radius / (track * turned))
}
