//! Springs that pull a body at a point, as a hand does.

use nalgebra::{Matrix3, Point3, UnitQuaternion, Vector3};
use scene::BodyState;
use serde::{Deserialize, Serialize};

/// Frequency of the springs with the body's whole mass, rad/s. What is lifted hangs 0.1 m below the hand.
const FREQUENCY: f64 = 10.0;
/// Critical damping with the mass that the spring meets, 1/s.
const DAMPING: f64 = 2.0 * FREQUENCY;
/// Longest way over which the spring grows stronger, m. With its damping the body comes at 5 m/s at most.
const MAX_WAY: f64 = 1.0;
/// Largest acceleration that the spring gives, m/s²: enough to lift, and to throw.
const MAX_ACCELERATION: f64 = 50.0;
/// Largest angular acceleration of the spring that turns the body, rad/s².
const MAX_TURNING: f64 = 100.0;
/// Decrease of the turn of a body that swings below the hand, 1/s, and the most that its lever adds to its inertia then.
const CALMING: f64 = 2.0;
const MOST_INERTIA: f64 = 10.0;
/// Most of a way that a spring at rest takes back in a step. A softer spring takes the place of one that is too stiff for the step.
const MOST_OF_WAY: f64 = 1.0;

/// A spring from a point of a body to a place. Its stiffness goes with the body's mass, and its damping is critical.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub(crate) struct Spring {
    /// Point of the body, in its own frame, m.
    pub(crate) grip: Vector3<f64>,
    /// Place to which the point is pulled, m; `None` to turn the body alone.
    pub(crate) to: Option<Vector3<f64>>,
    /// Orientation to which the body is turned; `None` to let it swing.
    pub(crate) turn: Option<UnitQuaternion<f64>>,
}

/// A body that a spring pulls at its first link. Vectors are in world axes.
pub(super) struct Grasped {
    state: BodyState,
    /// Position of the link's centre of mass, m.
    centre: Vector3<f64>,
    /// Mass with all links, kg.
    mass: f64,
    /// Moments of inertia about the centre, kg m².
    inertia: Matrix3<f64>,
}

impl Grasped {
    /// Describes a body by its first link, with its mass, kg, and its moments of inertia in its own axes, kg m², and by the mass of all links.
    /// Arms and wheels are taken to be spread as the link is.
    pub(super) fn new(state: BodyState, centre: Vector3<f64>, link: (f64, Matrix3<f64>), mass: f64) -> Self {
        let rotation = state.pose.rotation.to_rotation_matrix().into_inner();
        // The engine weighs its bodies in their first step.
        let spread = if link.0 > 0.0 { mass / link.0 } else { 0.0 };
        Self { state, centre, mass, inertia: rotation * link.1 * rotation.transpose() * spread }
    }
}

/// Effect of a spring on a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Tug {
    /// Point at which it pulls, m.
    pub(crate) point: Vector3<f64>,
    /// Its force, N.
    pub(crate) force: Vector3<f64>,
    /// Its torque beside that of the force, N m.
    pub(crate) torque: Vector3<f64>,
}

impl Spring {
    /// Computes the effect on a body in the coming step.
    pub(super) fn tug(&self, body: &Grasped, time_step: f64) -> Tug {
        let Grasped { state: BodyState { pose, linear, angular }, centre, mass, inertia } = body;
        let point = (pose * Point3::from(self.grip)).coords;
        if *mass == 0.0 {
            return Tug { point, force: Vector3::zeros(), torque: Vector3::zeros() };
        }
        let velocity = linear + angular.cross(&(point - pose.translation.vector));
        let lever = (point - centre).cross_matrix();
        let turning = inertia.try_inverse().map_or_else(Matrix3::zeros, |inverse| lever.transpose() * inverse * lever);
        // A push far from the centre meets less than the whole mass, as it turns the body.
        let met = (Matrix3::identity() / *mass + turning).try_inverse().unwrap_or_default();
        let share = 1.0 / (1.0 + mass * turning.norm());
        let force = self.to.map_or_else(Vector3::zeros, |to| {
            let stiffness = (FREQUENCY * FREQUENCY).min(MOST_OF_WAY * share / (time_step * time_step));
            let pull = (to - point).cap_magnitude(MAX_WAY) * stiffness * *mass;
            (pull - met * velocity * DAMPING).cap_magnitude(MAX_ACCELERATION * mass)
        });
        let turning = match self.turn {
            Some(turn) => {
                let way = (turn * pose.rotation.inverse()).scaled_axis();
                (way * FREQUENCY * FREQUENCY - angular * DAMPING).cap_magnitude(MAX_TURNING)
            }
            None => -angular * CALMING * (1.0 / share).min(MOST_INERTIA),
        };
        Tug { point, force, torque: inertia * turning }
    }
}
