//! The kinematics of a robot on plain wheels that slide when it turns.

use kinematics::Twist;
use kinematics::coulomb::{Contact, quasi_static};
use nalgebra::{Matrix3, Vector3};
use scene::{Belt, Disc, MountedWheel, RobotDef};

/// A contact of a wheel or a track with the ground.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Place {
    /// Forward and to the right in the robot frame, m.
    position: [f64; 2],
    /// Number of its wheel among the driven ones.
    wheel: usize,
    radius: f64,
    /// The contact's share of the weight.
    share: f64,
}

/// Height above the lowest wheel from which a wheel does not touch a level floor, m.
const OFF_GROUND: f64 = 0.002;

/// Returns the contacts of the driven wheels, all of one material, on a level floor.
///
/// The robot is rigid and its wheels are equally compliant, so the load is a linear function of a wheel's position. The centroid of the
/// loads is the centre of mass. Casters carry their share of the weight but cause no friction. A track has several contacts along its
/// lowest run.
pub(crate) fn places(robot: &RobotDef) -> Vec<Place> {
    let row = |[x, y]: [f64; 2]| Vector3::new(1.0, x, y);
    let bottoms = robot.wheels().flat_map(|wheel| supports(&wheel, f64::NEG_INFINITY));
    let lowest = bottoms.map(|contact| contact.bottom).fold(f64::NEG_INFINITY, f64::max);
    let stands = |wheel: &MountedWheel| supports(wheel, lowest - OFF_GROUND);
    let contacts: Vec<Support> = robot.wheels().flat_map(|wheel| stands(&wheel)).collect();
    let square = |it: &Support| row(it.position) * row(it.position).transpose() * it.part;
    let squares: Matrix3<f64> = contacts.iter().map(square).sum();
    let middle = robot.total_mass().centre;
    let least_squares = squares.svd(true, true).solve(&Vector3::new(1.0, middle.x, middle.y), 1e-12);
    let factors = least_squares.unwrap_or_else(|_| Vector3::zeros());
    let place = |(wheel, mounted): (usize, MountedWheel)| {
        let radius = mounted.radius;
        stands(&mounted).into_iter().map(move |contact| Place {
            position: contact.position,
            wheel,
            radius,
            share: contact.part * row(contact.position).dot(&factors).max(0.0),
        })
    };
    robot.driven().enumerate().flat_map(place).collect()
}

/// A possible contact with the ground.
struct Support {
    /// m.
    position: [f64; 2],
    /// Height of the lowest point, downward, m.
    bottom: f64,
    /// Stiffness over that of a wheel.
    part: f64,
}

/// Returns the contacts of a wheel that reach below a height, downward, m.
fn supports(wheel: &MountedWheel, height: f64) -> Vec<Support> {
    let [x, y, z] = wheel.position;
    let mut contacts = match &wheel.belt {
        None => vec![Support { position: [x, y], bottom: z + wheel.radius, part: 1.0 }],
        Some(belt) => {
            let of_disc = |Disc { middle: [x, z], radius, share }: Disc| Support {
                position: [x, y],
                bottom: z + radius,
                part: share,
            };
            belt.lowest_run(&belt.around(), [0.0, 1.0]).into_iter().map(of_disc).collect()
        }
    };
    contacts.retain(|contact| contact.bottom > height);
    if let ([alone], Some(_)) = (&mut contacts[..], &wheel.belt) {
        alone.part = Belt::ALONE;
    }
    contacts
}

/// Returns the robot's displacement, in m and rad clockwise, while its driven wheels turn by the angles `turned`, rad. Coulomb friction
/// does not depend on the magnitude of the speed, so angles can replace speeds. Rolling resistance is a moment on a wheel, which has no part in it.
pub(crate) fn twist(places: &[Place], turned: &[f64]) -> Twist {
    let contacts = places.iter().map(|place| {
        let Place { position, wheel, radius, share } = *place;
        let rolled = radius * turned.get(wheel).copied().unwrap_or(0.0);
        Contact { position, rolling: [rolled, 0.0], friction: share, along: None }
    });
    quasi_static(&contacts.collect::<Vec<_>>())
}
