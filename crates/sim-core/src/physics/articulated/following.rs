//! Mecanum bases that follow the twist of their wheels' commands, with no more force than they weigh times their grip.

use articulated::{Body, JointRow};
use friction::Constraint;
use kinematics::{FiniteRollers, Mecanum, Twist};
use nalgebra::Vector3;
use scene::{DriveModel, RobotDef};

use crate::mecanum;

/// How a base counts its twist from its wheels' speeds.
pub(super) enum Counting {
    Textbook(Mecanum),
    FiniteRollers(FiniteRollers),
}

/// What makes a base follow.
pub(super) struct Following {
    counting: Counting,
    /// Friction of its wheels.
    grip: f64,
    /// How far its wheels are from its origin, m.
    lever: f64,
}

impl Following {
    /// That of a robot, if its drive model is one.
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

    /// The twist for wheels at angles, rad, that are asked for speeds, rad/s.
    fn twist(&self, speeds: [f64; 4], angles: [f64; 4]) -> Twist {
        match &self.counting {
            Counting::Textbook(mecanum) => mecanum.forward(speeds),
            Counting::FiniteRollers(rollers) => {
                rollers.forward(speeds, std::array::from_fn(|wheel| rollers.phase(wheel, angles[wheel])))
            }
        }
    }

    /// Rows that make the robot frame of a body, which has a number, move so. They push no harder than real wheels could, so walls hold.
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
        // The velocity of the frame's origin along an axis.
        let along = |direction: Vector3<f64>, target| row(frame.origin.cross(&direction), direction, target, most);
        [
            along(axis(Vector3::x()), forward),
            along(axis(Vector3::y()), right),
            row(axis(Vector3::z()), Vector3::zeros(), clockwise, most * self.lever),
        ]
    }
}
