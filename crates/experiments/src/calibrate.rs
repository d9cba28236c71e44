//! The numbers of a robot's wheels, from a record of its poses and of how far its wheels turned.
//!
//! ```text
//! table of poses and wheels -> [`Record`] -> windows -> least squares -> [`Calibration`] -> robot.toml
//! ```
//!
//! In each window the way of the robot is a sum of what its wheels turned, step by step, in the direction that it had: linear in the wheel's
//! radius and in what goes sideways. Its turn is linear in the radius over the effective track. So there is nothing to guess and nothing to
//! iterate, and the covariances are those of linear least squares. Only the stiffness of tyres needs a search (`tyres.rs`).

mod coasting;
mod file;
mod fit;
mod record;
mod tyres;

use base_motion::{Base, DiffDrive, Model};
use kinematics::{Mecanum, Twist};
use scene::{Drivetrain, RobotDef, Side};
use serde::Serialize;

pub use file::write_robot;
use fit::Fit;
pub use record::{Record, RecordError};

/// Length of a window, s.
const WINDOW: f64 = 1.0;
/// Least turning of the wheels in a window that counts, rad.
const LEAST_TURNED: f64 = 0.05;
/// Fewest windows that tell anything.
const LEAST_WINDOWS: usize = 8;
/// Greatest half width of an interval over its number, above which the record does not tell the number.
const MOST_UNCERTAIN: f64 = 0.1;
/// Ends of the ranges of curvature in which the effective track is told apart. In wider curves a robot hardly turns.
const CURVATURES: [f64; 8] = [0.0, 0.25, 0.75, 1.5, 3.0, 6.0, 12.0, 30.0];

/// The numbers that a record tells.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Calibration {
    /// Numbers that were found.
    pub numbers: Vec<Number>,
    /// Effective track by the curvature of the way, of robots that turn by a difference of their sides.
    pub curves: Vec<Curve>,
    /// Half length and half width of the patch for which the stiffness of the tyres holds, m.
    pub patch: Option<[f64; 2]>,
    /// Numbers that this record does not tell, and why.
    pub missing: Vec<String>,
    /// Windows that count.
    pub windows: usize,
    /// Standard deviation of what the numbers leave of the way in a window, m, and of its turn, rad.
    pub residuals: [f64; 2],
    /// True if the poses are counted with y to the left and yaw counterclockwise.
    pub is_mirrored: bool,
}

/// A number with its 95 % interval.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Number {
    /// Its name.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Its value.
    pub value: f64,
    /// Interval that holds it in 95 of 100 records.
    pub interval: [f64; 2],
    /// Value in the robot's file, if it has one.
    pub in_file: Option<f64>,
}

/// Effective track in a range of curvatures.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Curve {
    /// Mean curvature: sum over difference of the sides' wheel speeds.
    pub curvature: f64,
    /// Effective track, m.
    pub track: f64,
    /// Its standard error, m.
    pub error: f64,
    /// Windows in the range.
    pub windows: usize,
}

/// Names of the numbers.
const RADIUS: &str = "wheel radius";
const TRACK: &str = "effective track";
const CENTRE: &str = "turning centre ahead of the wheels' middle";
const ASIDE: &str = "way sideways over ahead";
const SUM: &str = "lx + ly";
const STIFFNESS: [&str; 2] = ["tyre stiffness along", "tyre stiffness across"];
const RESISTANCE: &str = "rolling resistance, with what else brakes";
const BEARINGS: &str = "friction of the rollers' bearings";
/// Greatest half width of an interval of a coefficient that brakes over it.
const MOST_UNCERTAIN_BRAKE: f64 = 0.5;

/// A record that cannot be fitted.
#[derive(Debug, thiserror::Error)]
pub enum CalibrationError {
    /// The robot's wheels have no fitting kinematics.
    #[error("robot `{0}`: expected driven wheels on two sides that are not steered, or four Mecanum wheels")]
    Wheels(String),
    /// The record has another number of wheels.
    #[error("the record has {got} wheels: expected {expected}, as the robot has driven ones")]
    Count {
        /// Wheels of the record.
        got: usize,
        /// Driven wheels of the robot.
        expected: usize,
    },
    /// The record is too short, or the robot stands.
    #[error("{0} windows of 1 s in which the wheels turn: expected {LEAST_WINDOWS} at least")]
    Short(usize),
}

/// Returns the kinematics of a robot as if wheel radius, and track or lx + ly, were 1 m. `None` if its wheels do not fit.
fn unit_base(robot: &RobotDef) -> Option<Base> {
    Base::of(robot, Model::Ideal)?;
    let is_plain = || robot.driven().all(|wheel| wheel.rollers.is_none());
    match robot.drivetrain() {
        Drivetrain::Mecanum => Some(Base::Mecanum(Mecanum { half_wheelbase: 0.5, half_track: 0.5, wheel_radius: 1.0 })),
        Drivetrain::Sides if is_plain() => Some(Base::of_driver(robot, DiffDrive { track: 1.0, radii: [1.0; 2] })),
        _ => None,
    }
}

/// A window of the record.
struct Window {
    /// Way in the frame of its start, m, and turn, rad.
    moved: [f64; 2],
    turn: f64,
    /// Way for a wheel radius of 1 m, and what belongs to the second number of the way: sideways for a ratio of 1 and that radius, or the
    /// way of a point 1 m ahead as the robot turns.
    ahead: [f64; 2],
    aside: [f64; 2],
    /// Turning of the wheels about the vertical, rad.
    about: f64,
    /// Sum of the sides' wheels, rad.
    sum: f64,
}

/// Finds the numbers of a robot's wheels from a record, and from one of runs that end without power, if there is one.
/// `friction` is that between tyres and floor, for the stiffness of tyres.
///
/// # Errors
/// When the robot has no fitting wheels, the record has others, or tells nothing.
pub fn calibrate(
    record: &Record,
    robot: &RobotDef,
    coasting: Option<&Record>,
    friction: f64,
) -> Result<Calibration, CalibrationError> {
    let base = unit_base(robot).ok_or_else(|| CalibrationError::Wheels(robot.class.clone()))?;
    let expected = robot.driven().count();
    if record.wheels() != expected {
        return Err(CalibrationError::Count { got: record.wheels(), expected });
    }
    // Poses with y to the left turn the other way for the same wheels.
    let turns = windows(record, &base, 1.0).iter().map(|it| it.about * it.turn).sum::<f64>();
    let is_mirrored = turns < 0.0;
    let windows = windows(record, &base, if is_mirrored { -1.0 } else { 1.0 });
    if windows.len() < LEAST_WINDOWS {
        return Err(CalibrationError::Short(windows.len()));
    }
    let mut way = Fit::new();
    let mut turn = Fit::new();
    for it in &windows {
        (0..2).for_each(|axis| way.add([it.ahead[axis], it.aside[axis]], it.moved[axis]));
        turn.add([it.about, 0.0], it.turn);
    }
    let (way, turn) = (way.solve(), turn.solve());
    let mut found = Found { numbers: Vec::new(), missing: Vec::new() };
    let wheel = robot.driven().next();
    let of_file = wheel.map(|wheel| wheel.radius);
    let mut radius = way.number(0);
    found.add(RADIUS, "m", radius, of_file, "the robot hardly goes ahead, so that of the file counts");
    if found.numbers.is_empty() {
        radius = [of_file.unwrap_or_default(), 0.0];
    }
    let over_turn = quotient(radius, turn.number(0));
    let mut curves = Vec::new();
    match &base {
        Base::Mecanum(_) => {
            found.add(ASIDE, "", quotient(way.number(1), radius), None, "the robot hardly goes sideways");
            let sum = wheel.map(|wheel| wheel.position[0].abs() + wheel.position[1].abs());
            found.add(SUM, "m", over_turn, sum, "the robot hardly turns");
        }
        _ => {
            let on = |side: Side| robot.driven().filter(move |wheel| wheel.side == side);
            let across = |side: Side| on(side).next().map_or(0.0, |wheel| wheel.position[1]);
            let is_sliding = on(Side::Left).count() > 1;
            let in_file = (!is_sliding).then(|| across(Side::Right) - across(Side::Left));
            found.add(TRACK, "m", over_turn, in_file, "the robot hardly turns");
            // It may be 0, so its interval counts by itself.
            found.add_within(MOST_UNCERTAIN, CENTRE, "m", way.number(1), Some(0.0), "the robot hardly turns");
            curves = by_curvature(&windows, radius[0]);
            if is_sliding && robot.driven().all(|wheel| wheel.belt.is_none()) {
                found.add_tyres(robot, friction, &curves);
            }
        }
    }
    found.add_brakes(robot, coasting);
    let Found { numbers, missing } = found;
    let residuals = [way.deviation, turn.deviation];
    let has_tyres = numbers.iter().any(|it| it.name == STIFFNESS[0]);
    let patch = wheel.filter(|_| has_tyres).map(|wheel| tyres::patch(wheel.tyre, wheel.radius, wheel.width));
    Ok(Calibration { numbers, curves, patch, missing, windows: windows.len(), residuals, is_mirrored })
}

/// Numbers that were found, and those that were not.
struct Found {
    numbers: Vec<Number>,
    missing: Vec<String>,
}

impl Found {
    /// Adds a number, given by its value and half of its interval, unless the record does not tell it.
    fn add(&mut self, name: &'static str, unit: &'static str, number: [f64; 2], in_file: Option<f64>, why: &str) {
        self.add_within(MOST_UNCERTAIN * number[0].abs(), name, unit, number, in_file, why);
    }

    /// Adds a number if half of its interval is `most` at most.
    fn add_within(
        &mut self,
        most: f64,
        name: &'static str,
        unit: &'static str,
        [value, half]: [f64; 2],
        in_file: Option<f64>,
        why: &str,
    ) {
        if half.is_finite() && half <= most {
            self.numbers.push(Number { name, unit, value, interval: [value - half, value + half], in_file });
        } else {
            self.missing.push(format!("{name}: {why}"));
        }
    }

    /// Adds the stiffness of the tyres, as it is told by the effective track at several curvatures.
    fn add_tyres(&mut self, robot: &RobotDef, friction: f64, curves: &[Curve]) {
        match tyres::stiffness(robot, friction, curves) {
            Ok(found) => {
                let in_file = robot.driven().find_map(|wheel| wheel.tyre).map(|tyre| tyre.stiffness);
                for (axis, [value, low, high]) in found.into_iter().enumerate() {
                    let in_file = in_file.map(|it| it[axis]);
                    self.numbers.push(Number {
                        name: STIFFNESS[axis],
                        unit: "",
                        value,
                        interval: [low, high],
                        in_file,
                    });
                }
            }
            Err(why) => self.missing.push(format!("stiffness of the tyres: {why}")),
        }
    }

    /// Adds what brakes a robot without power.
    fn add_brakes(&mut self, robot: &RobotDef, record: Option<&Record>) {
        let bearings = robot.driven().find_map(|wheel| Some(wheel.rollers.as_ref()?.bearing_friction));
        let names = [RESISTANCE, BEARINGS].into_iter().take(if bearings.is_some() { 2 } else { 1 });
        let Some(record) = record else {
            let missing = |name| format!("{name}: expected runs that end without power (--coasting)");
            return self.missing.extend(names.map(missing));
        };
        let (found, runs) = coasting::coasting(record, robot);
        for (name, number) in names.zip(found) {
            let in_file = bearings.filter(|_| name == BEARINGS);
            if runs < coasting::LEAST_RUNS {
                let expected = coasting::LEAST_RUNS;
                self.missing.push(format!("{name}: {runs} runs that end without power: expected {expected} at least"));
                continue;
            }
            let why = "these runs do not tell it; a Mecanum robot needs some ahead and some sideways";
            self.add_within(MOST_UNCERTAIN_BRAKE * number[0].abs(), name, "", number, in_file, why);
        }
    }
}

/// Divides two numbers with halves of their intervals, as if their errors did not depend on each other.
fn quotient([one, half_one]: [f64; 2], [other, half_other]: [f64; 2]) -> [f64; 2] {
    let value = one / other;
    [value, value.abs() * ((half_one / one).powi(2) + (half_other / other).powi(2)).sqrt()]
}

/// Divides a record into windows in which the wheels turn. `mirror` is -1 if y is to the left.
fn windows(record: &Record, base: &Base, mirror: f64) -> Vec<Window> {
    let mut windows = Vec::new();
    let mut first = 0;
    while first < record.len() {
        let Some(last) = (first + 1..record.len()).find(|&it| record.time(it) - record.time(first) >= WINDOW) else {
            break;
        };
        let pose = |sample: usize| {
            let [x, y, yaw] = record.pose(sample);
            [x, mirror * y, mirror * yaw]
        };
        let [x, y, yaw] = pose(first);
        let into = |[along, across]: [f64; 2], angle: f64| {
            let (sin, cos) = libm::sincos(angle);
            [along * cos - across * sin, along * sin + across * cos]
        };
        let [end_x, end_y, _] = pose(last);
        let mut window = Window {
            moved: into([end_x - x, end_y - y], -yaw),
            turn: 0.0,
            ahead: [0.0; 2],
            aside: [0.0; 2],
            about: 0.0,
            sum: 0.0,
        };
        let mut turned_most = 0.0_f64;
        for sample in first..last {
            let turned = record.turned(sample);
            let Twist { forward: ahead, right: aside, clockwise: about } = base.displacement(&turned, &[], [0.0; 2]);
            let step = scene::wrapped(pose(sample + 1)[2] - pose(sample)[2]);
            // The direction in the middle of the step.
            let direction = window.turn + step / 2.0;
            let across = if matches!(base, Base::Mecanum(_)) { aside } else { step };
            for (sum, part) in [(&mut window.ahead, [ahead, 0.0]), (&mut window.aside, [0.0, across])] {
                sum.iter_mut().zip(into(part, direction)).for_each(|(sum, part)| *sum += part);
            }
            window.turn += step;
            window.about += about;
            window.sum += 2.0 * ahead;
            turned_most += turned.iter().map(|it| it.abs()).fold(0.0, f64::max);
        }
        if turned_most > LEAST_TURNED {
            windows.push(window);
        }
        first = last;
    }
    windows
}

/// Finds the effective track in each range of curvatures that has enough windows.
fn by_curvature(windows: &[Window], radius: f64) -> Vec<Curve> {
    let ranges = CURVATURES.iter().zip(&CURVATURES[1..]);
    let curve = |(&low, &high): (&f64, &f64)| {
        let curvature = |it: &Window| (it.sum / it.about).abs();
        let own = || windows.iter().filter(|it| (low..high).contains(&curvature(it)));
        let mut turn = Fit::new();
        own().for_each(|it| turn.add([it.about, 0.0], it.turn));
        let count = own().count();
        let [share, half] = turn.solve().number(0);
        let track = radius / share;
        let is_told = count >= LEAST_WINDOWS && half <= MOST_UNCERTAIN * share.abs();
        let mean = own().map(curvature).sum::<f64>() / count as f64;
        is_told.then(|| Curve { curvature: mean, track, error: track * half / share.abs() / 2.0, windows: count })
    };
    ranges.filter_map(curve).collect()
}
