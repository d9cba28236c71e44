//! Checks of robots on four Mecanum wheels.

use base_motion::mecanum;
use nalgebra::UnitQuaternion;
use scene::{Material, Shape, Solid, WheelGeometry, wrapped};
use sim_core::WheelState;

use super::{Finding, Scene, Subject, about, below, energy, halved, same_bits, slides, tolerance};
use crate::course::{MotionError, angles, drive_command, exact_step};
use crate::inertia::rolling_mass;

/// Names of the checks.
pub(super) const CHECKS: [&str; 12] = [
    "forward and backward",
    "left and right",
    "rotate in place",
    "diagonal",
    "signs of the wheels",
    "ride height",
    "hold on a slope, wheels locked",
    "roll down a slope, wheels free",
    "traction limit",
    "climb at constant speed",
    "stall and energy",
    "determinism and convergence",
];

/// Runs the check with this number.
pub(super) fn check(subject: &Subject, number: u32) -> Result<Vec<Finding>, MotionError> {
    let run = match number {
        1 => forward,
        2 => sideways,
        3 => rotation,
        4 => diagonal,
        5 => signs,
        6 => ride_height,
        7 => slope_hold,
        8 => free_rolling,
        9 => traction,
        10 => climb,
        11 => stall_and_energy,
        _ => convergence,
    };
    run(subject)
}

/// A drive at constant speeds: the measured motion, and the exact one for the angles of the wheels.
struct Travel {
    /// Measured motion: forward, right (m) and clockwise (rad, not wrapped) in the start frame.
    moved: [f64; 3],
    /// Exact motion by the kinematics, summed in the robot frame.
    exact: [f64; 3],
    /// Angle turned by each wheel.
    turned: [f64; 4],
    /// Difference between the highest and lowest position of the body above the floor.
    ripple: f64,
}

fn travel(subject: &Subject, rise: [f64; 2], speeds: [f64; 4]) -> Result<Travel, MotionError> {
    let mut scene = Scene::new(subject, rise, Vec::new())?;
    let kinematics =
        mecanum::finite_rollers(&subject.robot).ok_or_else(|| MotionError::NotOmni(subject.robot.class.clone()))?;
    scene.drive(&drive_command(speeds));
    scene.run(1.0);
    let (from, wheels) = scene.state();
    let start = angles(&wheels);
    let (mut before, mut yaw_before, mut yaw) = (start, 0.0, 0.0);
    let (mut exact, mut lowest, mut highest) = ([0.0; 3], f64::INFINITY, f64::NEG_INFINITY);
    let up: UnitQuaternion<f64> = from.pose.rotation;
    for _ in 0..(subject.seconds / scene.world.time_step()).round() as u64 {
        scene.world.step();
        let (body, wheels) = scene.state();
        let now = angles(&wheels);
        let twist = exact_step(&kinematics, before, now);
        exact = [exact[0] + twist.forward, exact[1] + twist.right, exact[2] + twist.clockwise];
        let (_, _, heading) = (up.inverse() * body.pose.rotation).euler_angles();
        yaw += wrapped(heading - yaw_before);
        (before, yaw_before) = (now, heading);
        let height = (up.inverse() * (body.pose.translation.vector - from.pose.translation.vector)).z;
        (lowest, highest) = (lowest.min(height), highest.max(height));
    }
    let displacement = up.inverse() * (scene.body().pose.translation.vector - from.pose.translation.vector);
    let turned = std::array::from_fn(|wheel| before[wheel] - start[wheel]);
    Ok(Travel { moved: [displacement.x, displacement.y, yaw], exact, turned, ripple: highest - lowest })
}

fn forward(subject: &Subject) -> Result<Vec<Finding>, MotionError> {
    let mut findings = Vec::new();
    for (name, sign) in [("forward", 1.0), ("backward", -1.0)] {
        let Travel { moved, exact, .. } = travel(subject, [0.0; 2], [sign; 4])?;
        let length = moved[0].abs();
        findings.push(about(format!("{name}, of R theta"), moved[0] / exact[0], 1.0, tolerance(subject, 0.005)));
        findings.push(below(format!("{name}, sideways, % of the travel"), 100.0 * moved[1].abs() / length, 0.3));
        findings.push(below(format!("{name}, yaw, degrees a metre"), moved[2].to_degrees().abs() / length, 0.1));
    }
    Ok(findings)
}

fn sideways(subject: &Subject) -> Result<Vec<Finding>, MotionError> {
    let mut findings = Vec::new();
    let mut travels = Vec::new();
    for (name, sign) in [("right", 1.0), ("left", -1.0)] {
        let Travel { moved, exact, turned, .. } = travel(subject, [0.0; 2], [sign, -sign, -sign, sign])?;
        let length = moved[1].abs();
        findings.push(about(
            format!("{name}, of the exact travel"),
            moved[1] / exact[1],
            1.0,
            tolerance(subject, 0.007),
        ));
        findings.push(below(format!("{name}, ahead or back, % of the travel"), 100.0 * moved[0].abs() / length, 0.5));
        findings.push(below(format!("{name}, yaw, degrees a metre"), moved[2].to_degrees().abs() / length, 0.5));
        travels.push(length / turned.iter().map(|angle| angle.abs()).sum::<f64>());
    }
    findings.push(about("left over right", travels[1] / travels[0], 1.0, 0.001));
    Ok(findings)
}

fn rotation(subject: &Subject) -> Result<Vec<Finding>, MotionError> {
    let Travel { moved, exact, .. } = travel(subject, [0.0; 2], [2.0, -2.0, 2.0, -2.0])?;
    let turns = moved[2].abs() / std::f64::consts::TAU;
    Ok(vec![
        about("of the exact angle", moved[2] / exact[2], 1.0, tolerance(subject, 0.01)),
        below("centre drifts, mm a turn", 1e3 * moved[0].hypot(moved[1]) / turns, 5.0),
    ])
}

/// Drives only the front right and back left wheels: forward left.
fn diagonal(subject: &Subject) -> Result<Vec<Finding>, MotionError> {
    let Travel { moved, exact, .. } = travel(subject, [0.0; 2], [0.0, 1.0, 1.0, 0.0])?;
    let heading = (-moved[1]).atan2(moved[0]).to_degrees();
    let exact_heading = (-exact[1]).atan2(exact[0]).to_degrees();
    Ok(vec![
        about("forward, of the exact travel", moved[0] / exact[0], 1.0, 0.01),
        about("left, of the exact travel", moved[1] / exact[1], 1.0, 0.01),
        about("direction, degrees", heading, exact_heading, 1.0),
    ])
}

fn signs(subject: &Subject) -> Result<Vec<Finding>, MotionError> {
    // Signs of the wheels, then of forward, right, clockwise.
    const TABLE: [([f64; 4], [f64; 3]); 8] = [
        ([1.0, 1.0, 1.0, 1.0], [1.0, 0.0, 0.0]),
        ([-1.0, -1.0, -1.0, -1.0], [-1.0, 0.0, 0.0]),
        ([1.0, -1.0, -1.0, 1.0], [0.0, 1.0, 0.0]),
        ([-1.0, 1.0, 1.0, -1.0], [0.0, -1.0, 0.0]),
        ([1.0, -1.0, 1.0, -1.0], [0.0, 0.0, 1.0]),
        ([-1.0, 1.0, -1.0, 1.0], [0.0, 0.0, -1.0]),
        ([1.0, 0.0, 0.0, 1.0], [1.0, 1.0, 0.0]),
        ([0.0, 1.0, 1.0, 0.0], [1.0, -1.0, 0.0]),
    ];
    let short = Subject { seconds: 2.0, ..subject.clone() };
    let mut right = 0.0;
    for (speeds, expected) in TABLE {
        let Travel { moved, .. } = travel(&short, [0.0; 2], speeds)?;
        let largest = moved[0].abs().max(moved[1].abs()).max(0.3 * moved[2].abs());
        let sign = |value: f64| if value.abs() < 0.1 * largest { 0.0 } else { value.signum() };
        right += f64::from([sign(moved[0]), sign(moved[1]), sign(0.3 * moved[2])] == expected);
    }
    Ok(vec![about("right directions of 8", right, 8.0, 0.0)])
}

fn ride_height(subject: &Subject) -> Result<Vec<Finding>, MotionError> {
    let mut findings = Vec::new();
    for (name, speeds) in
        [("forward", [1.0; 4]), ("right", [1.0, -1.0, -1.0, 1.0]), ("turning", [1.0, -1.0, 1.0, -1.0])]
    {
        findings.push(below(format!("ripple {name}, mm"), 1e3 * travel(subject, [0.0; 2], speeds)?.ripple, 0.15));
    }
    Ok(findings)
}

/// Returns the friction of a roller on the floor.
fn friction(subject: &Subject) -> f64 {
    let roller = subject.robot.wheels().next().and_then(|wheel| wheel.wheel.rollers.as_ref());
    roller.map_or(0.0, |roller| roller.material.pair(&subject.floor).0)
}

/// Returns the friction that acts ahead and aside, as a mean of the wheels. A roller at the phase phi carries force along its axis,
/// which the ground sees at the angle `atan(tan g cos phi)` to the axle. With 45 degree rollers at phase 0 both parts are 1 / sqrt
/// 2.
fn grip(subject: &Subject, wheels: &[WheelState]) -> [f64; 2] {
    let Some(kinematics) = mecanum::finite_rollers(&subject.robot) else { return [0.0; 2] };
    let angles = (0..)
        .zip(wheels)
        .map(|(index, wheel)| (kinematics.angle.tan() * kinematics.phase(index, wheel.angle).cos()).atan());
    let parts = angles.map(|angle| [angle.sin(), angle.cos()]);
    let sum = parts.fold([0.0; 2], |sum, part| [sum[0] + part[0], sum[1] + part[1]]);
    sum.map(|sum| sum * friction(subject) / wheels.len() as f64)
}

/// Locks the wheels by more torque than the floor can turn them with.
fn slope_hold(subject: &Subject) -> Result<Vec<Finding>, MotionError> {
    let mut locked = subject.clone();
    locked.floor.rolling_resistance = 0.0;
    motors(&mut locked, |motor| {
        motor.gain = motor.gain.max(20.0);
        motor.max_torque = motor.max_torque.max(20.0);
    });
    let grip = grip(subject, &Scene::new(subject, [0.0; 2], Vec::new())?.state().1);
    let mut findings = Vec::new();
    for (name, axis) in [("ahead", 0), ("aside", 1)] {
        findings.extend(slides(&locked, name, axis, grip[axis].atan())?);
    }
    Ok(findings)
}

fn free_rolling(subject: &Subject) -> Result<Vec<Finding>, MotionError> {
    let free = coasting(subject);
    let slope = 4.5f64.to_radians();
    let bound = 9.81 * slope.sin() * f64::from(subject.robot.mass()) / rolling_mass(&subject.robot);
    let mut findings = Vec::new();
    for (name, rise, axis, least) in [("ahead", [slope, 0.0], 0, 0.7), ("aside", [0.0, slope], 1, 0.55)] {
        let mut scene = Scene::new(&free, rise, Vec::new())?;
        let before = scene.velocity()[axis];
        scene.run(1.0);
        let acceleration = (scene.velocity()[axis] - before).abs();
        findings.push(between(format!("rolls {name} at 4.5 degrees, of the bound"), acceleration / bound, least, 1.0));
    }
    Ok(findings)
}

fn traction(subject: &Subject) -> Result<Vec<Finding>, MotionError> {
    let mut findings = Vec::new();
    let mut strong = subject.clone();
    strong.floor.rolling_resistance = 0.0;
    motors(&mut strong, |motor| {
        (motor.gain, motor.max_torque, motor.max_speed, motor.integral_time) = (10.0, 20.0, 1000.0, None);
    });
    // Wheels at 20 rad/s slide until the robot is at 1 m/s, after some 0.17 s.
    for (name, signs, axis) in [("ahead", [1.0; 4], 0), ("aside", [1.0, -1.0, -1.0, 1.0], 1)] {
        let mut scene = Scene::new(&strong, [0.0; 2], Vec::new())?;
        scene.drive(&drive_command(signs.map(|sign| sign * 20.0)));
        scene.run(0.02);
        let (before, mut expected) = (scene.velocity()[axis], 0.0);
        for _ in 0..(0.1 / scene.world.time_step()).round() as u64 {
            expected += 9.81 * grip(subject, &scene.state().1)[axis] * scene.world.time_step();
            scene.world.step();
        }
        let ratio = (scene.velocity()[axis] - before) / expected;
        findings.push(about(format!("most acceleration {name}, of mu g and the rollers' angle"), ratio, 1.0, 0.05));
    }
    let limit = friction(subject) * 9.81 / std::f64::consts::SQRT_2;
    for part in [0.25, 0.5] {
        let force = part * limit * f64::from(subject.robot.mass());
        let mut weak = strong.clone();
        motors(&mut weak, |motor| motor.max_torque = force * subject.robot.wheel_geometry().radius / 4.0);
        let mut scene = Scene::new(&weak, [0.0; 2], Vec::new())?;
        scene.drive(&drive_command([100.0; 4]));
        scene.run(0.02);
        let before = scene.velocity()[0];
        scene.run(0.2);
        let acceleration = (scene.velocity()[0] - before) / 0.2;
        let expected = force / rolling_mass(&subject.robot);
        findings.push(about(
            format!("acceleration at {part} of it, of force over mass"),
            acceleration / expected,
            1.0,
            0.05,
        ));
    }
    Ok(findings)
}

fn climb(subject: &Subject) -> Result<Vec<Finding>, MotionError> {
    let mut smooth = subject.clone();
    smooth.floor.rolling_resistance = 0.0;
    let mut findings = Vec::new();
    for degrees in [1.5f64, 4.5] {
        let slope = degrees.to_radians();
        for (name, speeds, rise, axis) in
            [("ahead", [1.0; 4], [slope, 0.0], 0), ("aside", [1.0, -1.0, -1.0, 1.0], [0.0, slope], 1)]
        {
            let flat = travel(&smooth, [0.0; 2], speeds)?;
            let up = travel(&smooth, rise, speeds)?;
            let ratio = (up.moved[axis] / up.exact[axis]) / (flat.moved[axis] / flat.exact[axis]);
            findings.push(about(format!("{degrees} degrees {name}, travel a wheel angle, of flat"), ratio, 1.0, 0.005));
            let motor = subject.robot.driven().next().and_then(|wheel| wheel.drive);
            if axis == 0
                && let Some(motor) = motor.filter(|motor| motor.integral_time.is_none())
            {
                let radius = subject.robot.wheel_geometry().radius;
                let torque = f64::from(subject.robot.mass()) * 9.81 * slope.sin() * radius / 4.0;
                let droop = (flat.turned[0] - up.turned[0]) / subject.seconds;
                let what = format!("{degrees} degrees, droop of the wheels, of torque over gain");
                findings.push(about(what, droop / (torque / motor.gain), 1.0, 0.1));
            }
        }
    }
    Ok(findings)
}

fn stall_and_energy(subject: &Subject) -> Result<Vec<Finding>, MotionError> {
    let mut findings = Vec::new();
    // A smooth bar at the height of the hubs carries no weight. It meets the chassis between the front wheels, which protrude in
    // front and would be held by the friction of a wall. It pushes back above the ground, which unloads the front wheels. They
    // slide first, at F / 4 = grip (m g / 4 - F R / (2 wheel base)).
    let WheelGeometry { radius, wheel_base, .. } = subject.robot.wheel_geometry();
    let ice = Material { name: "ice".to_owned(), ..Material::default() };
    let wall = Solid {
        name: "wall".to_owned(),
        shape: Shape::Box { size: [0.2, 0.2, 0.004] },
        position: [0.6, 0.0, -radius],
        rotation: [0.0; 3],
        material: ice,
    };
    let load = f64::from(subject.robot.mass()) * 9.81 * radius / 4.0;
    // Returns the torque over the grip of the rollers at the ground, and true if the wheels stall. A base held by torque alone may
    // wander sideways along the wall; two wheels then turn on and two back.
    let stalls = |torque: f64| -> Result<(f64, bool), MotionError> {
        let mut limited = subject.clone();
        limited.floor.rolling_resistance = 0.0;
        limited.robot.links[0].solids.iter_mut().for_each(|solid| solid.material.friction = 0.0);
        motors(&mut limited, |motor| (motor.gain, motor.max_torque, motor.integral_time) = (20.0, torque, None));
        let mut scene = Scene::new(&limited, [0.0; 2], vec![wall.clone()])?;
        scene.drive(&drive_command([2.0; 4]));
        scene.run(4.0);
        let turned = |scene: &Scene| scene.state().1.iter().map(|wheel| wheel.angle).sum::<f64>() / 4.0;
        let (before, wheels) = (turned(&scene), scene.state().1);
        scene.run(2.0);
        let speed = (turned(&scene) - before) / 2.0;
        let grip = grip(subject, &wheels)[0];
        let limit = load * grip / (1.0 + 2.0 * grip * radius / wheel_base);
        Ok((torque / limit, speed < 0.2))
    };
    let (mut low, mut high, mut ratio) = (0.5 * load * friction(subject), load * friction(subject), 0.0);
    while high - low > 0.005 * load {
        let middle = (low + high) / 2.0;
        match stalls(middle)? {
            (part, true) => (low, ratio) = (middle, part),
            (_, false) => high = middle,
        }
    }
    findings.push(about(
        "most torque that stalls at a bar, of mu m g R / 4, the rollers' angle and the load on the front wheels",
        ratio,
        1.0,
        0.03,
    ));
    findings.push(energy(&coasting(subject))?);
    Ok(findings)
}

fn convergence(subject: &Subject) -> Result<Vec<Finding>, MotionError> {
    let mut findings = vec![same_bits(subject, &drive_command([1.0, 0.5, -0.5, 1.0]))?];
    let halved = halved(subject);
    for (name, speeds, axis) in [
        ("forward", [1.0; 4], 0),
        ("right", [1.0, -1.0, -1.0, 1.0], 1),
        ("turning", [1.0, -1.0, 1.0, -1.0], 2),
        ("diagonal", [0.0, 1.0, 1.0, 0.0], 0),
    ] {
        let ratio = |subject: &Subject| travel(subject, [0.0; 2], speeds).map(|it| it.moved[axis] / it.exact[axis]);
        let (coarse, fine) = (ratio(subject)?, ratio(&halved)?);
        findings.push(below(format!("half the time step, {name}, %"), 100.0 * (coarse / fine - 1.0).abs(), 0.3));
        if axis < 2 && name != "diagonal" {
            let mut ratios = Vec::new();
            for share in [0.6, 0.8] {
                let mut light = subject.clone();
                if let Some(part) = light.robot.parts_mut().next() {
                    let less = f64::from(subject.robot.mass()) * (1.0 - share);
                    part.inertia *= (part.mass - less) / part.mass;
                    part.mass -= less;
                }
                ratios.push(ratio(&light)? / coarse);
            }
            let worst = ratios.iter().map(|ratio| (ratio - 1.0).abs()).fold(0.0, f64::max);
            findings.push(below(format!("0.6 and 0.8 of its mass, {name}, %"), 100.0 * worst, 0.5));
        }
    }
    Ok(findings)
}

fn between(what: impl Into<String>, measured: f64, least: f64, most: f64) -> Finding {
    Finding { check: 0, what: what.into(), measured, least, most }
}

fn motors(subject: &mut Subject, change: impl FnMut(&mut scene::Motor)) {
    subject.robot.motors_mut().for_each(change);
}

/// Returns the subject with motors that exert no torque, on a floor without rolling resistance.
fn coasting(subject: &Subject) -> Subject {
    let mut free = subject.clone();
    motors(&mut free, |motor| (motor.gain, motor.integral_time) = (1e-9, None));
    free.floor.rolling_resistance = 0.0;
    free
}
