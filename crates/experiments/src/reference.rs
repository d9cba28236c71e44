//! Exact motion of a robot for given wheel angles, as a reference for measured motions.

use kinematics::coulomb::{self, Contact};
use kinematics::{FiniteRollers, Twist};
use nalgebra::Vector3;
use scene::{Material, RobotDef, RobotSnapshot, WHEEL_AXIS};
use sim_core::mecanum;

/// Kinematics of a robot.
pub(crate) enum Reference {
    /// Mecanum wheels: exact, roller by roller.
    Rollers(FiniteRollers),
    /// Plain wheels: the twist at which Coulomb friction balances.
    Sliding(Sliding),
}

/// A robot on plain wheels, with the loads on its wheels.
#[derive(Default)]
pub(crate) struct Sliding {
    wheels: Vec<Wheel>,
    /// Number of snapshots that the loads were summed over.
    noted: f64,
}

/// A wheel and its contact with the ground.
struct Wheel {
    /// Forward and to the right in the robot frame, m.
    position: [f64; 2],
    /// Rolling direction.
    rolling: [f64; 2],
    radius: f64,
    /// Friction of the wheel on the floor; 0 for a caster, which turns about every axis.
    friction: f64,
    /// Rolling resistance of the wheel on the floor.
    resistance: f64,
    is_driven: bool,
    /// Sum of the loads over all snapshots, N.
    load: f64,
}

impl Reference {
    /// Creates the reference for a class of robots, or `None` for one without driven wheels.
    pub(crate) fn of(robot: &RobotDef) -> Option<Self> {
        let sliding = || robot.driven().next().map(|_| Self::Sliding(Sliding::default()));
        mecanum::finite_rollers(robot).map(Self::Rollers).or_else(sliding)
    }
}

impl Sliding {
    /// Adds a snapshot: updates the pose of each wheel and adds its load. Call it in every step of the averaging interval.
    pub(crate) fn note(&mut self, floor: &Material, def: &RobotDef, robot: &RobotSnapshot) {
        let placed = def.placed_links(&robot.joints);
        let wheels = placed.iter().filter_map(|(link, pose)| Some((link, link.wheel.as_ref()?, pose)));
        let loads: Vec<f64> = self.wheels.iter().map(|wheel| wheel.load).collect();
        self.wheels = wheels
            .enumerate()
            .map(|(number, (link, wheel, pose))| {
                let axis = pose.rotation * Vector3::from(WHEEL_AXIS);
                // The wheel rolls across its axis, with z down.
                let rolling = Vector3::z().cross(&axis);
                Wheel {
                    position: [pose.translation.x, pose.translation.y],
                    rolling: [rolling.x, rolling.y],
                    radius: wheel.radius,
                    friction: if link.is_driven_wheel() { wheel.material.pair(floor).0 } else { 0.0 },
                    resistance: wheel.material.rolling_resistance + floor.rolling_resistance,
                    is_driven: link.is_driven_wheel(),
                    load: loads.get(number).copied().unwrap_or_default(),
                }
            })
            .collect();
        self.noted += 1.0;
        let own = robot.body.pose.inverse();
        for contact in &robot.contacts {
            let at = own * nalgebra::Point3::from(contact.point);
            let distance = |wheel: &Wheel| (wheel.position[0] - at.x).hypot(wheel.position[1] - at.y);
            if let Some(wheel) = self.wheels.iter_mut().min_by(|a, b| distance(a).total_cmp(&distance(b))) {
                // Up is negative.
                wheel.load -= contact.force.z;
            }
        }
    }

    /// Returns the mean load on each driven wheel, N.
    pub(crate) fn driven_loads(&self) -> impl Iterator<Item = f64> {
        self.wheels.iter().filter(|wheel| wheel.is_driven).map(|wheel| wheel.load / self.noted)
    }

    /// Returns the twist while the driven wheels turn at the given speeds, rad/s.
    pub(crate) fn twist(&self, speeds: &[f64]) -> Twist {
        let mut speeds = speeds.iter();
        let mut contacts = Vec::new();
        for wheel in &self.wheels {
            let Wheel { position, rolling, radius, friction, resistance, .. } = *wheel;
            let speed = if wheel.is_driven { speeds.next().copied().unwrap_or_default() } else { 0.0 };
            let load = wheel.load / self.noted;
            let passing = rolling.map(|part| part * radius * speed);
            contacts.push(Contact { position, rolling: passing, friction: friction * load, along: None });
            // Rolling resistance is a force against the motion of the hub. A driven wheel rolls only ahead.
            let along = wheel.is_driven.then_some(rolling);
            contacts.push(Contact { position, rolling: [0.0; 2], friction: resistance * load, along });
        }
        coulomb::quasi_static(&contacts)
    }
}
