//! The kinematics of a robot on plain wheels that slide when it turns.

use kinematics::Twist;
use kinematics::coulomb::{Contact, quasi_static};
use nalgebra::{Matrix3, Vector3};
use scene::RobotDef;

/// A wheel's contact with the ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Place {
    /// Forward and to the right in the robot frame, m.
    position: [f64; 2],
    radius: f64,
    /// The wheel's share of the weight.
    share: f64,
}

/// Height above the lowest wheel from which a wheel does not touch a level floor, m.
const OFF_GROUND: f64 = 0.002;

/// Returns the contacts of the driven wheels, all of one material, on a level floor.
///
/// The robot is rigid and its wheels are equally compliant, so the load is a linear function of a wheel's position. The centroid of the
/// loads is the centre of mass. Casters carry their share of the weight but cause no friction.
pub(crate) fn places(robot: &RobotDef) -> Vec<Place> {
    let row = |position: [f64; 3]| Vector3::new(1.0, position[0], position[1]);
    let bottom = |wheel: &scene::MountedWheel| wheel.position[2] + wheel.wheel.radius;
    let lowest = robot.wheels().map(|wheel| bottom(&wheel)).fold(f64::NEG_INFINITY, f64::max);
    let stands = |wheel: &scene::MountedWheel| bottom(wheel) > lowest - OFF_GROUND;
    let squares: Matrix3<f64> =
        robot.wheels().filter(stands).map(|wheel| row(wheel.position) * row(wheel.position).transpose()).sum();
    let middle = robot.total_mass().centre;
    let least_squares = squares.svd(true, true).solve(&Vector3::new(1.0, middle.x, middle.y), 1e-12);
    let factors = least_squares.unwrap_or_else(|_| Vector3::zeros());
    let place = |wheel: scene::MountedWheel| Place {
        position: [wheel.position[0], wheel.position[1]],
        radius: wheel.wheel.radius,
        share: if stands(&wheel) { row(wheel.position).dot(&factors).max(0.0) } else { 0.0 },
    };
    robot.driven().map(place).collect()
}

/// Returns the robot's displacement, in m and rad clockwise, while its driven wheels turn by the angles `turned`, rad. Coulomb friction
/// does not depend on the magnitude of the speed, so angles can replace speeds.
pub(crate) fn twist(places: &[Place], turned: &[f64]) -> Twist {
    let contact = |(place, turned): (&Place, &f64)| Contact {
        position: place.position,
        rolling: [place.radius * turned, 0.0],
        friction: place.share,
        along: None,
    };
    let contacts: Vec<Contact> = places.iter().zip(turned).map(contact).collect();
    quasi_static(&contacts)
}
