//! Wheels, their motors and their rollers.

use std::f64::consts::TAU;
use std::ops::Deref;

use nalgebra::{UnitQuaternion, Vector3};
use serde::{Deserialize, Serialize};

use crate::{Belt, JointKind, Link, Material, Pose, Side, Tyre, pose};

/// A wheel on a joint: it rolls about the robot's y axis, or, as a caster, is a ball.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Wheel {
    /// Side of the robot.
    pub side: Side,
    /// Outer radius, m.
    pub radius: f64,
    /// Width along its axle, m.
    pub width: f64,
    /// Mass without rollers, kg.
    pub mass: f64,
    /// Material of the tread.
    pub material: Material,
    /// Rollers of a Mecanum wheel.
    pub rollers: Option<Rollers>,
    /// Belt around the wheel, which then is the sprocket of a track: its radius is that of the belt around it, and its mass that of the
    /// whole track.
    #[serde(default)]
    pub belt: Option<Belt>,
    /// Elastic tread of a driven wheel without rollers or belt; without one it is a rigid disc. The drive model `articulated` alone has it.
    #[serde(default)]
    pub tyre: Option<Tyre>,
}

/// A wheel and the joint that carries it.
#[derive(Debug, Clone, Copy)]
pub struct MountedWheel<'a> {
    /// Name of its link.
    pub name: &'a str,
    /// Centre in the robot frame, m.
    pub position: [f64; 3],
    /// Motor of its joint; `None` makes it a caster, a ball free to turn about every axis.
    pub drive: Option<&'a Motor>,
    /// Number of its link.
    pub link: usize,
    /// Number of the link that carries it.
    pub parent: usize,
    /// The wheel.
    pub wheel: &'a Wheel,
}

impl<'a> MountedWheel<'a> {
    /// Returns the wheel on the link with this number, if it has one.
    pub fn of((number, link): (usize, &'a Link)) -> Option<Self> {
        let (joint, wheel) = (link.joint.as_ref()?, link.wheel.as_ref()?);
        Some(Self {
            name: &link.name,
            position: joint.anchor,
            drive: joint.drive.as_ref(),
            link: number,
            parent: joint.parent,
            wheel,
        })
    }

    /// Returns the discs that touch the ground: middle in the robot frame and radius, m. A wheel is one, a track has one around each of
    /// its rollers.
    pub fn discs(&self) -> Vec<([f64; 3], f64)> {
        let [_, y, _] = self.position;
        let of_belt = |belt: &Belt| belt.rollers.iter().map(|&[x, z, radius]| ([x, y, z], radius)).collect();
        self.belt.as_ref().map_or_else(|| vec![(self.position, self.radius)], of_belt)
    }

    /// Returns the pose of the wheel in the robot frame after it turned forward by an angle in radians.
    pub fn pose(&self, angle: f64) -> Pose {
        pose(self.position, [0.0, -angle, 0.0])
    }
}

impl Deref for MountedWheel<'_> {
    type Target = Wheel;

    fn deref(&self) -> &Wheel {
        self.wheel
    }
}

impl Wheel {
    /// Returns the kind of a wheel's joint, driven or not.
    pub fn joint_kind(&self, is_driven: bool) -> JointKind {
        match &self.belt {
            Some(_) => JointKind::Belt,
            None if is_driven => JointKind::Continuous,
            None => JointKind::Ball,
        }
    }

    /// Returns the number of rollers.
    pub fn roller_count(&self) -> usize {
        self.rollers.as_ref().map_or(0, |rollers| rollers.count as usize)
    }
}

/// A servo with a torque limit. With a stiffness, torque = stiffness x (target - position) - gain x speed; otherwise torque = gain
/// x (target - speed). For a prismatic joint read N and m instead of N m and rad.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Motor {
    /// Speed limit, rad/s. The target of a position servo moves no faster.
    pub max_speed: f64,
    /// Servo gain, N m s/rad.
    pub gain: f64,
    /// Torque limit, N m.
    pub max_torque: f64,
    /// Stiffness of a position servo, N m/rad. Without it the servo controls speed.
    #[serde(default)]
    pub stiffness: Option<f64>,
    /// Time constant of integral action, s. Without it the speed droops under a load by torque over gain.
    pub integral_time: Option<f64>,
    /// Inertia of the rotor as felt at the wheel, kg m². The engine's sliding friction leans toward the direction in which a
    /// contact is heavier. On a skid robot, whose wheels slide sideways in every turn, this has to be of the order of (mass / 4)
    /// radius². Otherwise the robot hardly turns.
    pub armature: f64,
}

impl Motor {
    /// Returns the torque of a blocked speed servo at the target of its speed limit, N m.
    pub fn stall_torque(&self) -> f64 {
        match self.integral_time {
            // Integral action rises until it meets the limit.
            Some(_) => self.max_torque,
            None => self.max_torque.min(self.gain * self.max_speed),
        }
    }
}

/// Free rollers of a Mecanum wheel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Rollers {
    /// Number of rollers.
    pub count: u32,
    /// Distance of a roller's axis from the wheel's axis, m.
    pub axis_circle: f64,
    /// Angle between the roller axis and the wheel axis, rad; positive if the roller at the ground points forward-right.
    pub angle: f64,
    /// Angle from the front of the wheel, downward, to the first roller at a wheel angle of 0, rad.
    pub first_roller: f64,
    /// Phase of the contact at the end of a roller, rad. At pi / count the contact passes to the next roller without a gap or an
    /// overlap. A larger phase makes longer rollers.
    pub last_phase: f64,
    /// Mass of one roller, kg.
    pub mass: f64,
    /// Viscous friction of the bearing, N m s/rad.
    pub damping: f64,
    /// Dry friction of the bearing: force at the rim of a roller that turns over its load.
    #[serde(default)]
    pub bearing_friction: f64,
    /// Material of a roller.
    pub material: Material,
}

impl Rollers {
    /// Returns the pose of a roller in the frame of its wheel, with its axis along x. Roller k sits at the angle
    /// `first + k 2 pi / count` from the front downward. Its axis leans by the roller angle from the wheel's axis toward the
    /// direction of turning (thesis Appendix A, lines 741 to 762).
    pub fn pose(&self, index: u32) -> Pose {
        let (sin_angle, cos_angle) = libm::sincos(self.angle.abs());
        let (sin, cos) = libm::sincos(self.first_roller + TAU * f64::from(index) / f64::from(self.count));
        let centre = Vector3::new(cos, 0.0, sin) * self.axis_circle;
        let tangent = Vector3::new(-sin, 0.0, cos);
        let axis = tangent * sin_angle - Vector3::y() * cos_angle * self.angle.signum();
        let turn = UnitQuaternion::rotation_between(&Vector3::x(), &axis);
        Pose::from_parts(centre.into(), turn.unwrap_or_default())
    }

    /// Returns the outline of a roller from end to end: positions along its axis from its middle, m, and the radius there, m.
    pub fn outline(&self, wheel_radius: f64, pieces: u32) -> Vec<[f64; 2]> {
        let edge = |piece: u32| {
            let phase = self.last_phase * (2.0 * f64::from(piece) / f64::from(pieces) - 1.0);
            [self.half_length_at(phase, wheel_radius), self.radius_at(phase, wheel_radius)]
        };
        (0..=pieces).map(edge).collect()
    }

    /// Returns the radius of the hub that fits between the rollers, m.
    pub fn hub_radius(&self, wheel_radius: f64) -> f64 {
        self.axis_circle - self.radius_at(0.0, wheel_radius)
    }

    /// Returns the radius of a roller at a phase of the contact, m, at the axial position [`half_length_at`] that phase.
    ///
    /// [`half_length_at`]: Self::half_length_at
    pub fn radius_at(&self, phase: f64, wheel_radius: f64) -> f64 {
        let cos_angle = libm::cos(self.angle.abs());
        (wheel_radius * libm::cos(phase) - self.axis_circle) * (1.0 + (cos_angle * libm::tan(phase)).powi(2)).sqrt()
    }

    /// Returns half the length along its axis of a roller that ends at a phase, m (Gfrerrer, "Geometry and kinematics of the
    /// Mecanum wheel").
    pub fn half_length_at(&self, phase: f64, wheel_radius: f64) -> f64 {
        let (sin, cos) = libm::sincos(self.angle.abs());
        wheel_radius * libm::sin(phase) * sin + self.axis_circle * libm::tan(phase) * cos.powi(2) / sin
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_4, PI};

    /// Positions and axes of the six rollers of either handedness, worked out from the thesis's Appendix A by the rules of Unreal's
    /// rotators. Its ring has a radius of 0.0475 m.
    #[test]
    fn rollers_sit_and_point_as_in_the_thesis() {
        let material = Material::default();
        let half = FRAC_1_SQRT_2;
        let table = [
            ([0.0475, 0.0], [0.0, -half, half]),
            ([0.02375, 0.04114], [-0.6124, -half, 0.3536]),
            ([-0.02375, 0.04114], [-0.6124, -half, -0.3536]),
            ([-0.0475, 0.0], [0.0, -half, -half]),
            ([-0.02375, -0.04114], [0.6124, -half, -0.3536]),
            ([0.02375, -0.04114], [0.6124, -half, 0.3536]),
        ];
        for sign in [1.0, -1.0] {
            let angle = sign * FRAC_PI_4;
            let material = material.clone();
            let rollers = Rollers {
                count: 6,
                axis_circle: 0.0475,
                angle,
                first_roller: 0.0,
                last_phase: PI / 6.0,
                mass: 0.1,
                damping: 0.0,
                bearing_friction: 0.0,
                material,
            };
            for (index, ([x, z], axis)) in (0..).zip(table) {
                let pose = rollers.pose(index);
                let place = pose.translation.vector - Vector3::new(x, 0.0, z);
                let direction = pose.rotation * Vector3::x() - Vector3::new(axis[0], sign * axis[1], axis[2]);
                assert!(place.norm() < 1e-4 && direction.norm() < 1e-3, "roller {index}, {sign}: {pose}");
            }
        }
    }
}
