//! Rolling resistance and the friction of rollers' bearings, from runs that end without power.
//!
//! Rolling resistance brakes a robot by c g, and the bearings of its rollers by √2 c g |sin a| where it goes at an angle a to its front:
//! rollers turn at √2 times the speed sideways, and stand still ahead. So each run gives a row that is linear in both.

use nalgebra::{Rotation2, Vector2};
use scene::RobotDef;

use super::fit::Fit;
use super::record::Record;
use crate::inertia::rolling_mass;

/// Gravity, m/s².
const GRAVITY: f64 = 9.81;
/// Time before and after a sample within which its speed is measured, s.
const AROUND: f64 = 0.1;
/// Speed below which a robot stands, and least top speed of a run, m/s.
const REST: f64 = 0.05;
const LEAST_TOP: f64 = 0.2;
/// Shares of a run's top speed between which it counts. Above, the power may still be on; below, noise has its part.
const COUNTS: [f64; 2] = [0.8, 0.2];
/// Sine of the angle to the front up to which a run is one ahead.
const AHEAD: f64 = 0.01;
/// Fewest samples of a run, and fewest runs.
const LEAST_SAMPLES: usize = 8;
pub(super) const LEAST_RUNS: usize = 4;

/// The end of a run.
struct Coasting {
    /// m/s².
    deceleration: f64,
    /// Sine of the angle between its way and the front, without its sign.
    sideways: f64,
    /// Weight of its row: noise of poses counts most in short runs.
    weight: f64,
}

/// Two coefficients with halves of their intervals: rolling resistance, with all that brakes alike in all directions as motors do, and friction
/// of the rollers' bearings. Also the number of runs.
pub(super) fn coasting(record: &Record, robot: &RobotDef) -> ([[f64; 2]; 2], usize) {
    let has_rollers = robot.driven().any(|wheel| wheel.rollers.is_some());
    let runs = runs(record);
    let mut fit = Fit::new();
    for run in &runs {
        let sideways = if has_rollers { run.sideways } else { 0.0 };
        fit.add([run.weight, sideways * run.weight], run.deceleration * run.weight);
    }
    // Wheels that turn have to be stopped, too.
    let over_gravity = rolling_mass(robot) / f64::from(robot.mass()) / GRAVITY;
    let found = fit.solve();
    let coefficient = |number: usize, factor: f64| found.number(number).map(|it| it * factor * over_gravity);
    ([coefficient(0, 1.0), coefficient(1, std::f64::consts::FRAC_1_SQRT_2)], runs.len())
}

/// Finds the ends of all runs: from a share of the top speed to another.
fn runs(record: &Record) -> Vec<Coasting> {
    let speeds = speeds(record);
    let mut runs = Vec::new();
    let mut at = 0;
    while at < speeds.len() {
        if speeds[at] < REST {
            at += 1;
            continue;
        }
        let end = (at..speeds.len()).find(|&it| speeds[it] < REST);
        let last = end.unwrap_or(speeds.len());
        let top = speeds[at..last].iter().copied().fold(0.0, f64::max);
        let from = (at..last).rev().find(|&it| speeds[it] >= COUNTS[0] * top);
        let to = from.and_then(|from| (from..last).find(|&it| speeds[it] < COUNTS[1] * top));
        if let Some((from, to)) = from.zip(to).filter(|(from, to)| top > LEAST_TOP && to - from >= LEAST_SAMPLES) {
            runs.extend(run(record, from, to));
        }
        at = last;
    }
    runs
}

/// Returns the speed at each sample, m/s.
fn speeds(record: &Record) -> Vec<f64> {
    let (mut before, mut after) = (0, 0);
    let speed = |at: usize| {
        let time = record.time(at);
        while before + 1 < at && record.time(before + 1) <= time - AROUND {
            before += 1;
        }
        while after + 1 < record.len() && (after <= at || record.time(after) < time + AROUND) {
            after += 1;
        }
        let [[x, y, _], [to_x, to_y, _]] = [before, after].map(|it| record.pose(it));
        let seconds = record.time(after) - record.time(before);
        if seconds > 0.0 { (to_x - x).hypot(to_y - y) / seconds } else { 0.0 }
    };
    (0..record.len()).map(speed).collect()
}

/// Fits a parabola to the way between two samples.
fn run(record: &Record, from: usize, to: usize) -> Option<Coasting> {
    let samples = || (from..=to).map(|it| (record.time(it) - record.time(from), record.pose(it)));
    let count = (to - from + 1) as f64;
    let middle = samples().map(|(time, _)| time).sum::<f64>() / count;
    // All samples tell the direction, as those at the ends alone are noisy.
    let way = samples().map(|(time, [x, y, _])| Vector2::new(x, y) * (time - middle)).sum::<Vector2<f64>>();
    let way = way.try_normalize(f64::MIN_POSITIVE)?;
    let [.., first] = record.pose(from);
    let yaw = first + samples().map(|(_, [.., yaw])| scene::wrapped(yaw - first)).sum::<f64>() / count;
    let mut parabola = Fit::new();
    let [start_x, start_y, _] = record.pose(from);
    for (time, [x, y, _]) in samples() {
        parabola.add([1.0, time, time * time / 2.0], way.dot(&Vector2::new(x - start_x, y - start_y)));
    }
    let parabola = parabola.solve();
    // Noise adds to a sine without a sign.
    let sideways = Some((Rotation2::new(-yaw) * way).y.abs()).filter(|&it| it > AHEAD).unwrap_or(0.0);
    let weight = 1.0 / parabola.covariance[(2, 2)].sqrt();
    let run = Coasting { deceleration: -parabola.values[2], sideways, weight };
    (run.deceleration * run.weight).is_finite().then_some(run)
}
