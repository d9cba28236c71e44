//! What a robot and its parts weigh, and how it is spread.

use nalgebra::{Matrix3, Vector3};
use rapier3d::math::Matrix;
use rapier3d::prelude::*;

use super::{convert, shape};
use crate::scene::{RobotDef, Wheel};

/// Mass of a body, robot frame.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Mass {
    /// kg.
    pub(crate) mass: f64,
    /// Centre of mass, m.
    pub(crate) centre: Vector3<f64>,
    /// About the centre, kg m².
    pub(crate) inertia: Matrix3<f64>,
}

impl Mass {
    /// The same for the engine.
    pub(super) fn to_engine(self) -> MassProperties {
        let inertia = Matrix::from_cols_array_2d(&self.inertia.into());
        MassProperties::with_inertia_matrix(convert::vector(self.centre), self.mass, inertia)
    }
}

/// A wheel without its rollers, about its centre.
pub(super) fn wheel_mass(wheel: &Wheel) -> MassProperties {
    MassProperties::new(Vector::ZERO, wheel.mass, convert::vector(wheel_inertia(wheel)))
}

/// Moments of inertia, kg m²: a plain wheel as a solid disc, the hub of a Mecanum wheel as a disc out to the roller axes,
/// a caster as a ball.
fn wheel_inertia(wheel: &Wheel) -> [f64; 3] {
    let radius = wheel.rollers.as_ref().map_or(wheel.radius, |rollers| rollers.axis_circle);
    let spin = wheel.mass * radius * radius / 2.0;
    let tilt = wheel.mass * (3.0 * radius * radius + wheel.width * wheel.width) / 12.0;
    if wheel.drive.is_some() { [tilt, spin, tilt] } else { [0.4 * wheel.mass * radius * radius; 3] }
}

/// Inertia of a wheel with its rollers about its axle, kg m²; that of the motor's rotor is not in it.
pub fn wheel_spin_inertia(wheel: &Wheel) -> f64 {
    mass_with_rollers(wheel).1[(1, 1)]
}

/// Mass and inertia about the centre of a wheel with its rollers.
fn mass_with_rollers(wheel: &Wheel) -> (f64, Matrix3<f64>) {
    let mut inertia = Matrix3::from_diagonal(&wheel_inertia(wheel).into());
    let Some(rollers) = &wheel.rollers else { return (wheel.mass, inertia) };
    let own = Matrix3::from_diagonal(&shape::roller_inertia(rollers, wheel.radius).into());
    for index in 0..rollers.count {
        let pose = rollers.pose(index);
        let turn = pose.rotation.to_rotation_matrix();
        inertia += turn * own * turn.inverse() + point_inertia(rollers.mass, pose.translation.vector);
    }
    (wheel.mass + f64::from(rollers.count) * rollers.mass, inertia)
}

/// Inertia of a point about the origin.
fn point_inertia(mass: f64, place: Vector3<f64>) -> Matrix3<f64> {
    (Matrix3::identity() * place.norm_squared() - place * place.transpose()) * mass
}

/// Mass of the robot with its wheels held.
pub(crate) fn total_mass(robot: &RobotDef) -> Mass {
    let wheels = robot.wheels.iter().map(|wheel| {
        let (mass, inertia) = mass_with_rollers(wheel);
        Mass { mass, centre: wheel.position.into(), inertia }
    });
    combined(part_masses(robot).chain(wheels))
}

/// Mass of the robot's body without wheels.
pub(crate) fn body_mass(robot: &RobotDef) -> Mass {
    combined(part_masses(robot))
}

fn part_masses(robot: &RobotDef) -> impl Iterator<Item = Mass> {
    robot.parts.iter().map(|part| Mass { mass: part.mass, centre: part.centre, inertia: part.inertia })
}

fn combined(parts: impl Iterator<Item = Mass>) -> Mass {
    let parts: Vec<Mass> = parts.collect();
    let mass: f64 = parts.iter().map(|part| part.mass).sum();
    let centre = parts.iter().map(|part| part.centre * part.mass).sum::<Vector3<f64>>() / mass;
    let inertia = parts.iter().map(|part| part.inertia + point_inertia(part.mass, part.centre - centre)).sum();
    Mass { mass, centre, inertia }
}
