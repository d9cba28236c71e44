//! Mecanum bases that follow the twist of their wheels' commands, with no more force than their weight times their grip.

use articulated::{Body, JointRow};
use friction::Constraint;
use kinematics::{FiniteRollers, Mecanum, Twist};
use nalgebra::Vector3;
use scene::{DriveModel, RobotDef};

use base_motion::mecanum;

/// The map from wheel speeds to a base's twist.
pub(super) enum Counting {
    Textbook(Mecanum),
    FiniteRollers(FiniteRollers),
}

/// Data to make a base follow its commands.
pub(super) struct Following {
    counting: Counting,
    /// Friction coefficient of the wheels.
    grip: f64,
    /// Largest distance of a wheel from the origin, m.
    lever: f64,
}

impl Following {
    /// Builds the data for a robot, if its drive model follows commands.
    pub(super) fn of(def: &RobotDef) -> Option<Self> {
        let counting = match def.drive_model {
            DriveModel::Kinematic => Counting::FiniteRollers(mecanum::finite_rollers(def)?),
            DriveModel::KinematicTextbook => Counting::Textbook(mecanum::textbook(def)?),
            DriveModel::Bodies | DriveModel::Articulated | DriveModel::Analytic => return None,
        };
        let material = |wheel: scene::MountedWheel| wheel.rollers.as_ref().map(|rollers| rollers.material.friction);
        let grip = def.driven().find_map(material)?;
        let lever = def.driven().map(|wheel| Vector3::from(wheel.position).norm()).fold(0.0, f64::max);
        Some(Self { counting, grip, lever })
    }

    /// Returns the twist for wheel speeds, rad/s, at wheel angles, rad.
    fn twist(&self, speeds: [f64; 4], angles: [f64; 4]) -> Twist {
        match &self.counting {
            Counting::Textbook(mecanum) => mecanum.forward(speeds),
            Counting::FiniteRollers(rollers) => {
                rollers.forward(speeds, std::array::from_fn(|wheel| rollers.phase(wheel, angles[wheel])))
            }
        }
    }

    /// Returns the rows that move the robot frame with the commanded twist. They push no harder than real wheels could, so walls hold.
    /// `number` is the body's number in the system.
    pub(super) fn rows(
        &self,
        number: usize,
        body: &Body,
        [speeds, angles]: [[f64; 4]; 2],
        weight: f64,
        time_step: f64,
    ) -> [JointRow; 3] {
        let Twist { forward, right, clockwise } = self.twist(speeds, angles);
        let frame = &body.frames()[0];
        let axis = |axis: Vector3<f64>| frame.rotation * axis;
        let most = self.grip * weight * time_step;
        let row = |angular: Vector3<f64>, linear: Vector3<f64>, target, most| JointRow {
            body: number,
            terms: [None; 2],
            root: [angular.x, angular.y, angular.z, linear.x, linear.y, linear.z],
            constraint: Constraint::Within(most),
            target,
            compliance: 0.0,
            impulse: 0.0,
        };
        // Row of the velocity of the frame's origin along a direction.
        let along = |direction: Vector3<f64>, target| row(frame.origin.cross(&direction), direction, target, most);
        [
            along(axis(Vector3::x()), forward),
            along(axis(Vector3::y()), right),
            row(axis(Vector3::z()), Vector3::zeros(), clockwise, most * self.lever),
        ]
    }
}
