//! Checks of robots on plain wheels.

use gamebots_proto::command::Command;
use scene::{Motor, RobotDef, Steering};

use super::{Finding, Scene, Subject, about, below, energy, halved, same_bits, slides, tolerance, world};
use crate::course::{Course, Motion, MotionError, Travel, angles_of};
use crate::inertia::turning_inertia;
use crate::reference::Sliding;

/// Names of the checks.
pub(super) const CHECKS: [&str; 9] = [
    "straight on and back",
    "on the spot",
    "on a curve",
    "hold on a slope, wheels locked",
    "roll down a slope, wheels free",
    "traction limit",
    "climb at constant speed",
    "energy",
    "determinism and convergence",
];

/// Runs the check with this number.
pub(super) fn check(subject: &Subject, number: u32) -> Result<Vec<Finding>, MotionError> {
    match number {
        1 => straight(subject),
        2 => beside_friction(subject, Motion::Clockwise),
        3 => beside_friction(subject, Motion::Curve),
        4 => slope_hold(subject),
        5 => free_rolling(subject),
        6 => traction(subject),
        7 => climb(subject),
        8 => Ok(vec![energy(&coasting(subject))?]),
        _ => convergence(subject),
    }
}

/// Returns the subject with changed wheel motors and no other brakes. Motors of other joints keep an arm or a flipper in position.
fn with_wheels(subject: &Subject, change: impl FnMut(&mut Motor)) -> Subject {
    let mut changed = subject.clone();
    changed.floor.rolling_resistance = 0.0;
    let solids = changed.robot.links.iter_mut().flat_map(|link| &mut link.solids);
    solids.for_each(|solid| (solid.material.linear_damping, solid.material.angular_damping) = (0.0, 0.0));
    let wheels = changed.robot.links.iter_mut().filter(|link| link.wheel.is_some());
    let motors = wheels.filter_map(|link| {
        link.wheel.as_mut()?.material.rolling_resistance = 0.0;
        link.joint.as_mut()?.drive.as_mut()
    });
    motors.for_each(change);
    changed
}

fn coasting(subject: &Subject) -> Subject {
    with_wheels(subject, |motor| (motor.gain, motor.integral_time) = (1e-9, None))
}

fn ahead(robot: &RobotDef, speed: f64) -> Command {
    Motion::Forward.command(robot, speed)
}

/// Drives on a level floor and compares the travel with the wheels' angles and friction.
fn travel(subject: &Subject, motion: Motion, speed: f64) -> Result<Option<Travel>, MotionError> {
    let class = &subject.robot.class;
    let mut course = Course::start(world(subject, [0.0; 2], Vec::new()), class, 1, motion, speed)?;
    course.run(subject.seconds);
    Ok(course.travel())
}

fn ratio(subject: &Subject, motion: Motion, speed: f64) -> Result<f64, MotionError> {
    Ok(travel(subject, motion, speed)?.map_or(f64::NAN, |travel| travel.ratio))
}

fn straight(subject: &Subject) -> Result<Vec<Finding>, MotionError> {
    let mut findings = Vec::new();
    for (name, speed) in [("ahead", 1.0), ("back", -1.0)] {
        let Some(travel) = travel(subject, Motion::Forward, speed)? else { continue };
        let [forward, right, clockwise] = travel.moved;
        findings.push(about(format!("{name}, of R theta"), travel.ratio, 1.0, tolerance(subject, 0.005)));
        findings.push(below(format!("{name}, sideways, % of the travel"), 100.0 * (right / forward).abs(), 0.3));
        findings.push(below(format!("{name}, yaw, degrees a metre"), (clockwise.to_degrees() / forward).abs(), 0.1));
    }
    Ok(findings)
}

/// Compares the motion with the twist at which the friction of the wheels balances. A car cannot turn on the spot.
fn beside_friction(subject: &Subject, motion: Motion) -> Result<Vec<Finding>, MotionError> {
    if motion == Motion::Clockwise && subject.robot.steering == Steering::Ackermann {
        return Ok(Vec::new());
    }
    let mut findings = Vec::new();
    for speed in [0.2, 1.0, 3.0] {
        let ratio = ratio(subject, motion, speed)?;
        let what = format!("at {speed} rad/s, of the balance of friction");
        findings.push(about(what, ratio, 1.0, tolerance(subject, 0.02)));
    }
    Ok(findings)
}

/// Returns the friction of the driven wheels on the floor.
fn friction(subject: &Subject) -> f64 {
    let first = subject.robot.driven().next();
    first.map_or(0.0, |wheel| wheel.wheel.material.pair(&subject.floor).0)
}

/// Distribution of a robot's weight.
struct Stand {
    /// Fraction of the weight on each driven wheel; casters carry the rest and do not hold the robot.
    shares: Vec<f64>,
}

impl Stand {
    fn of(subject: &Subject) -> Result<Self, MotionError> {
        let scene = Scene::new(subject, [0.0; 2], Vec::new())?;
        let mut sliding = Sliding::default();
        if let Some(snapshot) = scene.world.observe(scene.robot) {
            sliding.note(&subject.floor, &subject.robot, &snapshot);
        }
        let weight = f64::from(subject.robot.mass()) * 9.81;
        Ok(Self { shares: sliding.driven_loads().map(|load| load / weight).collect() })
    }

    /// True if casters carry nothing.
    fn is_on_driven_wheels(&self) -> bool {
        self.shares.iter().sum::<f64>() > 0.99
    }

    /// True if every driven wheel carries enough weight to exert its share of a push, which is this fraction of the whole grip.
    fn can_push(&self, part: f64) -> bool {
        self.shares.iter().all(|share| share * self.shares.len() as f64 > 1.5 * part)
    }

    /// Returns the effective mass of a forward push: the robot's mass plus the share of the inertia of the wheels that roll.
    fn rolling_mass(&self, robot: &RobotDef) -> f64 {
        let driven = robot.driven().zip(&self.shares).filter(|(_, share)| **share > 0.0);
        let driven = driven.map(|(wheel, _)| turning_inertia(&wheel) / wheel.radius.powi(2));
        let casters = robot.wheels().filter(|wheel| wheel.drive.is_none());
        let casters = casters.map(|wheel| wheel.mass_with_rollers(false).inertia.trace() / 3.0 / wheel.radius.powi(2));
        f64::from(robot.mass()) + driven.chain(casters).sum::<f64>()
    }
}

/// True if the robot would tip over, ahead (0) or aside (1), before its wheels slide, or nearly so.
fn tips(subject: &Subject, axis: usize) -> bool {
    let robot = &subject.robot;
    let centre = robot.total_mass().centre;
    // z is down.
    let discs = || robot.wheels().flat_map(|wheel| wheel.discs());
    let height = discs().map(|(middle, radius)| middle[2] + radius - centre.z).fold(0.0, f64::max);
    let [least, most] = [f64::min, f64::max].map(|pick| {
        let places = discs().map(|(middle, _)| middle[axis]);
        places.reduce(pick).unwrap_or(0.0)
    });
    friction(subject) * height > 0.95 * (most - centre[axis]).min(centre[axis] - least)
}

/// Locks the wheels by more torque than the floor can turn them with.
fn slope_hold(subject: &Subject) -> Result<Vec<Finding>, MotionError> {
    let locked = with_wheels(subject, |motor| {
        (motor.gain, motor.max_torque) = (motor.gain.max(50.0), motor.max_torque.max(200.0));
    });
    if !Stand::of(subject)?.is_on_driven_wheels() {
        // The load on its casters changes with the slope.
        return Ok(Vec::new());
    }
    let limit = friction(subject).atan();
    let mut findings = Vec::new();
    for (name, axis) in [("ahead", 0), ("aside", 1)].into_iter().filter(|(_, axis)| !tips(subject, *axis)) {
        findings.extend(slides(&locked, name, axis, limit)?);
    }
    Ok(findings)
}

fn free_rolling(subject: &Subject) -> Result<Vec<Finding>, MotionError> {
    let slope = 4.5f64.to_radians();
    let rolling_mass = Stand::of(subject)?.rolling_mass(&subject.robot);
    let bound = 9.81 * slope.sin() * f64::from(subject.robot.mass()) / rolling_mass;
    let mut scene = Scene::new(&coasting(subject), [slope, 0.0], Vec::new())?;
    let before = scene.velocity()[0];
    scene.run(1.0);
    let acceleration = (scene.velocity()[0] - before).abs();
    Ok(vec![about("rolls at 4.5 degrees, of what gravity gives", acceleration / bound, 1.0, 0.005)])
}

fn traction(subject: &Subject) -> Result<Vec<Finding>, MotionError> {
    let mut findings = Vec::new();
    let strong = |torque: f64| {
        with_wheels(subject, |motor| {
            (motor.gain, motor.max_torque, motor.max_speed, motor.integral_time) = (50.0, torque, 1000.0, None);
        })
    };
    let accelerates = |subject: &Subject, speed: f64, seconds: f64| -> Result<f64, MotionError> {
        let mut scene = Scene::new(subject, [0.0; 2], Vec::new())?;
        scene.drive(&ahead(&subject.robot, speed));
        scene.run(0.08);
        let before = scene.velocity()[0];
        scene.run(seconds);
        Ok((scene.velocity()[0] - before) / seconds)
    };
    let limit = friction(subject) * 9.81;
    let stand = Stand::of(subject)?;
    let radius = subject.robot.wheel_geometry().radius;
    let grip = limit * f64::from(subject.robot.mass()) * radius;
    if stand.is_on_driven_wheels() && !tips(subject, 0) {
        // The torque of each wheel suffices even under the whole weight, which shifts to the rear wheels. Spinning the wheels up
        // turns the body back and unloads the front ones. So the wheels slide no faster than needed.
        let smallest = subject.robot.driven().map(|wheel| wheel.radius).fold(radius, f64::min);
        let most = accelerates(&strong(grip), 1.5 / smallest, 0.08)?;
        findings.push(about("most acceleration, of mu g", most / limit, 1.0, 0.05));
    }
    for part in [0.1, 0.2] {
        if !stand.can_push(part) {
            continue;
        }
        let acceleration = accelerates(&strong(part * grip / stand.shares.len() as f64), 100.0, 0.3)?;
        let what = format!("acceleration at {part} of it, of force over mass");
        let pushes = subject.robot.driven().map(|wheel| radius / wheel.radius).sum::<f64>() / stand.shares.len() as f64;
        let force = part * limit * f64::from(subject.robot.mass()) * pushes;
        let expected = force / stand.rolling_mass(&subject.robot);
        findings.push(about(what, acceleration / expected, 1.0, 0.02));
    }
    Ok(findings)
}

/// Compares the travel per wheel angle on slopes with the travel on the flat.
fn climb(subject: &Subject) -> Result<Vec<Finding>, MotionError> {
    let smooth = with_wheels(subject, |_| {});
    let travel = |degrees: f64| -> Result<f64, MotionError> {
        let mut scene = Scene::new(&smooth, [degrees.to_radians(), 0.0], Vec::new())?;
        scene.drive(&ahead(&subject.robot, 1.0));
        scene.run(1.0);
        let (from, before) = scene.state();
        scene.run(subject.seconds);
        let (to, after) = scene.state();
        let angles = [before, after].map(|wheels| angles_of(&wheels));
        let turned = angles[1].iter().zip(&angles[0]).map(|(after, before)| after - before).sum::<f64>();
        Ok((to.pose.translation.vector - from.pose.translation.vector).norm() * angles[0].len() as f64 / turned)
    };
    let flat = travel(0.0)?;
    let of_slope = |degrees: f64| -> Result<Finding, MotionError> {
        Ok(about(format!("{degrees} degrees, travel a wheel angle, of flat"), travel(degrees)? / flat, 1.0, 0.005))
    };
    [1.5, 4.5].into_iter().map(of_slope).collect()
}

fn convergence(subject: &Subject) -> Result<Vec<Finding>, MotionError> {
    let mut findings = vec![same_bits(subject, &Motion::Curve.command(&subject.robot, 2.0))?];
    let halved = halved(subject);
    for motion in [Motion::Forward, Motion::Curve] {
        let (coarse, fine) = (ratio(subject, motion, 1.0)?, ratio(&halved, motion, 1.0)?);
        let what = format!("half the time step, {}, %", motion.name());
        findings.push(below(what, 100.0 * (coarse / fine - 1.0).abs(), 0.3));
    }
    Ok(findings)
}
