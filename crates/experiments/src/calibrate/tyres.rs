//! Stiffness of tyres, from the effective track at several curvatures.
//!
//! On the spot a tread slides whole, and the effective track says nothing of it. In wide curves it holds, and the effective track follows from
//! its stiffness. Between, both count, and where that lies depends on stiffness over friction: so the friction has to be known. The robot is simulated with tyres until its effective tracks are those of the record: least squares by
//! Gauss and Newton over the logarithms of the stiffness along and across.

use nalgebra::Vector3;
use scene::{DriveModel, RobotDef, Tyre, WorldDef};

use super::Curve;
use super::fit::Fit;
use crate::real::{Floor, effective_track};

/// Fewest curvatures.
const LEAST_CURVES: usize = 4;
/// Half length of a patch over the radius of its wheel, and half width over the width of its wheel, where the robot has no tyres.
const PATCH: [f64; 2] = [0.27, 0.5];
/// First guess of both stiffnesses, and their range.
const GUESS: f64 = 6.0;
const RANGE: [f64; 2] = [0.5, 100.0];
/// Most iterations, and the step at which they end.
const MOST_STEPS: usize = 8;
const SMALL: f64 = 1e-3;
/// Step of a derivative.
const NUDGE: f64 = 0.05;
/// Greatest half width of an interval of a logarithm: a factor of 2.
const MOST_UNCERTAIN: f64 = 0.7;

/// Finds the stiffness along and across, each with its 95 % interval.
///
/// # Errors
/// When the record does not tell it. The text says why.
pub(super) fn stiffness(robot: &RobotDef, friction: f64, curves: &[Curve]) -> Result<[[f64; 3]; 2], String> {
    let radius = robot.driven().next().map_or(1.0, |wheel| wheel.radius);
    if curves.len() < LEAST_CURVES {
        return Err(format!(
            "the record has {} curvatures: expected {LEAST_CURVES} at least, from turns on the spot to wide curves",
            curves.len()
        ));
    }
    let tracks = |logs: Vector3<f64>| -> Result<Vec<f64>, String> {
        let [low, high] = RANGE;
        let world = world(robot, friction, [logs.x, logs.y].map(|it| libm::exp(it).clamp(low, high)));
        let track = |curve: &Curve| effective_track(world.clone(), &robot.class, radius, curve.curvature);
        let scaled = |curve: &Curve| Ok(track(curve).map_err(|error| error.to_string())? * libm::exp(logs.z));
        curves.iter().map(scaled).collect()
    };
    // Logarithms of the stiffness along and across, and of the record's tracks over those simulated: a wheel's radius is not exact.
    let mut logs = Vector3::new(libm::log(GUESS), libm::log(GUESS), 0.0);
    let (mut found, mut last) = (Fit::<3>::new().solve(), f64::INFINITY);
    for _ in 0..MOST_STEPS {
        let now = tracks(logs)?;
        let [along, across] = [Vector3::x(), Vector3::y()].map(|axis| tracks(logs + axis * NUDGE));
        let (along, across) = (along?, across?);
        let mut fit = Fit::new();
        for (index, curve) in curves.iter().enumerate() {
            let slope = |nudged: &[f64]| (nudged[index] - now[index]) / NUDGE;
            let parts = [slope(&along), slope(&across), now[index]].map(|part| part / curve.error);
            fit.add(parts, (curve.track - now[index]) / curve.error);
        }
        found = fit.solve();
        let step = found.values.map(|it| it.clamp(-1.0, 1.0));
        if !step.iter().all(|it| it.is_finite()) {
            return Err("the effective tracks are those of rigid wheels".to_owned());
        }
        logs += step;
        last = step.amax();
        if last < SMALL {
            break;
        }
    }
    if last > NUDGE {
        return Err("no stiffness gives these effective tracks".to_owned());
    }
    // What the tyre does not explain widens the intervals.
    let variance = found.deviation.powi(2).max(1.0);
    let [along, across] = [0, 1].map(|axis| {
        let half = 1.96 * (found.covariance[(axis, axis)] * variance).sqrt();
        let is_told = half <= MOST_UNCERTAIN && (libm::log(RANGE[0])..libm::log(RANGE[1])).contains(&logs[axis]);
        is_told.then(|| [logs[axis], logs[axis] - half, logs[axis] + half].map(libm::exp))
    });
    along.zip(across).map(|(along, across)| [along, across]).ok_or_else(|| {
        "the effective track hardly depends on it here; wide curves tell it, of a curvature of 4 and more".to_owned()
    })
}

/// Returns half length and half width of the patch of a wheel, m.
pub(super) fn patch(tyre: Option<Tyre>, radius: f64, width: f64) -> [f64; 2] {
    tyre.map_or([PATCH[0] * radius, PATCH[1] * width], |tyre| tyre.patch)
}

/// Returns a level floor and the robot with tyres.
fn world(robot: &RobotDef, friction: f64, stiffness: [f64; 2]) -> WorldDef {
    let map = Floor { friction, rolling_resistance: 0.0 }.map();
    let mut robot = robot.clone();
    robot.set_drive_model(Some(DriveModel::Articulated));
    for link in &mut robot.links {
        let is_driven = link.joint.as_ref().is_some_and(|joint| joint.drive.is_some());
        let Some(wheel) = link.wheel.as_mut().filter(|_| is_driven) else { continue };
        wheel.material.friction = friction;
        let patch = patch(wheel.tyre, wheel.radius, wheel.width);
        wheel.tyre = Some(Tyre { stiffness, patch, relaxation: None, friction: scene::isotropic() });
    }
    WorldDef { map, robots: [(robot.class.clone(), robot)].into(), ..WorldDef::default() }
}
