//! Exact motion of a robot for given wheel angles, as a reference for measured motions.

use base_motion::mecanum;
use kinematics::coulomb::{self, Contact};
use kinematics::{FiniteRollers, Twist};
use nalgebra::Vector3;
use scene::{Belt, Material, Pose, RobotDef, RobotSnapshot, WHEEL_AXIS};

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
    /// Rollers around the belt of every wheel in the order of the links; none for a wheel without one.
    around: Vec<Vec<usize>>,
    /// Number of snapshots that the loads were summed over.
    noted: f64,
}

/// A contact of a wheel with the ground. A track has several along its lowest run.
struct Wheel {
    /// Forward and to the right in the robot frame, m.
    position: [f64; 2],
    /// Rolling direction.
    rolling: [f64; 2],
    radius: f64,
    /// Friction of the wheel on the floor; 0 for a caster, which turns about every axis.
    friction: f64,
    /// Rolling resistance of a caster on the floor; that of a driven wheel is a moment, which its motor gives.
    resistance: f64,
    /// Number of its wheel among the driven ones; `None` for a caster.
    driven: Option<usize>,
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
        if self.around.is_empty() {
            let around = |wheel: &scene::Wheel| wheel.belt.as_ref().map_or_else(Vec::new, Belt::around);
            self.around = def.links.iter().filter_map(|link| link.wheel.as_ref()).map(around).collect();
        }
        let mut count = 0;
        self.wheels.clear();
        for ((link, wheel, pose), around) in wheels.zip(&self.around) {
            let axis = pose.rotation * Vector3::from(WHEEL_AXIS);
            // The wheel rolls across its axis, with z down.
            let rolling = Vector3::z().cross(&axis);
            let is_driven = link.is_driven_wheel();
            for [x, y] in stands(wheel, around, pose) {
                self.wheels.push(Wheel {
                    position: [x, y],
                    rolling: [rolling.x, rolling.y],
                    radius: wheel.radius,
                    friction: if is_driven { wheel.material.pair(floor).0 } else { 0.0 },
                    resistance: if is_driven { 0.0 } else { wheel.material.pair_rolling_resistance(floor) },
                    driven: is_driven.then_some(count),
                    load: loads.get(self.wheels.len()).copied().unwrap_or_default(),
                });
            }
            count += usize::from(is_driven);
        }
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
        let count = self.wheels.iter().filter_map(|wheel| wheel.driven).max().map_or(0, |last| last + 1);
        let load =
            move |number| self.wheels.iter().filter(move |wheel| wheel.driven == Some(number)).map(|wheel| wheel.load);
        (0..count).map(move |number| load(number).sum::<f64>() / self.noted)
    }

    /// Returns the twist while the driven wheels turn at the given speeds, rad/s.
    pub(crate) fn twist(&self, speeds: &[f64]) -> Twist {
        let mut contacts = Vec::new();
        for wheel in &self.wheels {
            let Wheel { position, rolling, radius, friction, resistance, .. } = *wheel;
            let speed = wheel.driven.and_then(|number| speeds.get(number)).copied().unwrap_or_default();
            let load = wheel.load / self.noted;
            let passing = rolling.map(|part| part * radius * speed);
            contacts.push(Contact { position, rolling: passing, friction: friction * load, along: None });
            if resistance > 0.0 {
                contacts.push(Contact { position, rolling: [0.0; 2], friction: resistance * load, along: None });
            }
        }
        coulomb::quasi_static(&contacts)
    }
}

/// Returns where a wheel at a pose in the robot frame can touch the ground, forward and to the right in the robot frame, m.
fn stands(wheel: &scene::Wheel, around: &[usize], pose: &Pose) -> Vec<[f64; 2]> {
    let Some(belt) = &wheel.belt else { return vec![[pose.translation.x, pose.translation.y]] };
    let down = pose.rotation.inverse() * Vector3::z();
    let [x, z] = belt.rollers.first().map_or([0.0; 2], |&[x, z, _]| [x, z]);
    let discs = belt.lowest_run(around, [down.x, down.z]).into_iter();
    let places = discs.map(|disc| pose * nalgebra::Point3::new(disc.middle[0] - x, 0.0, disc.middle[1] - z));
    places.map(|place| [place.x, place.y]).collect()
}
