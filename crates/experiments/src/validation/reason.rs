//! Reasons for failed checks: the usual cause of a failure, and anything unusual in the robot's stance.

use std::collections::BTreeMap;

use nalgebra::{Point3, Vector3};
use scene::{Link, Material, RobotDef, RobotSnapshot, Shape};

use super::{Finding, Scene, Subject};
use crate::course::MotionError;

/// Time over which loads are averaged, s.
const WATCHED: f64 = 0.5;
/// Fraction of the weight above which a load is worth mentioning.
const NOTABLE: f64 = 0.01;
/// Relative difference between the loads of the sides above which it is mentioned.
const UNEVEN: f64 = 0.2;
/// Largest distance of a contact from the outline of its wheel, m.
const NEAR: f64 = 0.005;

/// Usual causes of a failed check, for a value too low and too high.
struct Meaning {
    check: &'static str,
    /// Beginning of the finding's description; empty for all other findings of the check.
    what: &'static str,
    low: &'static str,
    high: &'static str,
}

const fn meaning(check: &'static str, what: &'static str, low: &'static str, high: &'static str) -> Meaning {
    Meaning { check, what, low, high }
}

const DRAG: &str = "the wheels slip, as something brakes the robot: look for shapes that touch the floor, and for `friction` and \
                    `damping` of joints";
const LONG: &str =
    "the robot moves farther than its wheels turn: `radius` is larger than what is measured, or wheels leave the floor";
const PULLS: &str = "the robot pulls to a side: compare radius, mass, motor and position of its left and right wheels, and the `centre` \
                     of its mass";
const TURNS_LESS: &str = "it turns less than friction alone lets it: something besides its wheels holds the floor, or its motors are \
                          too weak (`gain`, `max_torque`)";
const TURNS_MORE: &str = "it turns more than friction lets it: a wheel carries little load at times, so look at `centre`, and at \
                          wheels that do not reach the floor";
const HOLD_LOW: &str =
    "it slides before its wheels' friction is used up: part of its weight stands on something smoother, or it tips";
const HOLD_HIGH: &str = "something with more friction than the wheels holds it: look for shapes that touch the floor";
const CREEP: &str = "it creeps though friction would hold it: with `bodies` a shorter step (--dt) helps, otherwise it stands on \
                     something without friction";
const ROLL_LOW: &str = "something brakes wheels without a motor: `damping` or `friction` of their joints, rolling resistance of a \
                        material, or a shape that touches the floor";
const ROLL_HIGH: &str = "it is faster than gravity makes it: the inertia of its wheels or rotors (`armature`) is less than the file says, \
                         or wheels leave the floor";
const PUSH_LOW: &str = "its wheels do not bring their friction to the floor: they carry too little of its weight, or spin up something \
                        heavy (`armature`, rollers)";
const PUSH_HIGH: &str = "it is pushed by more than friction and torque allow: its inertia is less than its mass says, or a wheel \
                         carries more than its part";
const CLIMB: &str = "a slope changes the travel for the same angle of its wheels: they slip; look at the load on each, and at shapes \
                     that touch the floor";
const ENERGY: &str =
    "energy comes from nowhere: try a shorter step (--dt); very light parts beside heavy ones cause it, too";
const STEP: &str = "the result depends on the time step: try a shorter one (--dt), or heavier wheels and rollers";
const BITS: &str = "two runs differ: this is a defect of the program; please report it with the robot's file";
const SIGNS: &str =
    "some wheel turns or pushes the other way: check `side`, the order of the wheels and the sign of `roller_angle`";
const HEIGHT: &str =
    "the body moves up and down as the rollers pass: `axis_circle`, `half_length` or `radius` leave a gap";

const GONE: &str = "the robot did not move, or fell: drive it with `usarsim serve` and look";

const MEANINGS: &[Meaning] = &[
    meaning("straight on and back", "ahead, of", DRAG, LONG),
    meaning("straight on and back", "back, of", DRAG, LONG),
    meaning("straight on and back", "", PULLS, PULLS),
    meaning("on the spot", "", TURNS_LESS, TURNS_MORE),
    meaning("on a curve", "", TURNS_LESS, TURNS_MORE),
    meaning("hold on a slope, wheels locked", "creep", CREEP, CREEP),
    meaning("hold on a slope, wheels locked", "", HOLD_LOW, HOLD_HIGH),
    meaning("roll down a slope, wheels free", "", ROLL_LOW, ROLL_HIGH),
    meaning("traction limit", "", PUSH_LOW, PUSH_HIGH),
    meaning("climb at constant speed", "", CLIMB, CLIMB),
    meaning("energy", "", ENERGY, ENERGY),
    meaning("determinism and convergence", "the same bits", BITS, BITS),
    meaning("determinism and convergence", "", STEP, STEP),
    meaning("forward and backward", "forward, of", DRAG, LONG),
    meaning("forward and backward", "backward, of", DRAG, LONG),
    meaning("forward and backward", "", PULLS, PULLS),
    meaning("left and right", "right, of", DRAG, LONG),
    meaning("left and right", "left, of", DRAG, LONG),
    meaning("left and right", "", PULLS, PULLS),
    meaning("rotate in place", "centre", PULLS, PULLS),
    meaning("rotate in place", "", DRAG, LONG),
    meaning("diagonal", "", DRAG, LONG),
    meaning("signs of the wheels", "", SIGNS, SIGNS),
    meaning("ride height", "", HEIGHT, HEIGHT),
    meaning("stall and energy", "energy", ENERGY, ENERGY),
    meaning("stall and energy", "", PUSH_LOW, PUSH_HIGH),
];

/// A robot's stance on a level floor, in fractions of its weight.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Stance {
    /// Load on each driven wheel.
    driven: Vec<f64>,
    /// Load on casters.
    casters: f64,
    /// Load on shapes of its links by name, and three frictions: the shape's, the floor's and that of the pair.
    shapes: BTreeMap<String, (f64, [f64; 3])>,
}

impl Stance {
    /// Spawns a robot on a level floor and measures the loads on its wheels and shapes.
    ///
    /// # Errors
    /// When the robot cannot be spawned.
    pub fn of(subject: &Subject) -> Result<Self, MotionError> {
        let mut scene = Scene::new(subject, [0.0; 2], Vec::new())?;
        let weight = f64::from(subject.robot.mass()) * 9.81;
        let steps = (WATCHED / scene.world.time_step()).round().max(1.0);
        let mut stance = Self { driven: vec![0.0; subject.robot.driven().count()], ..Self::default() };
        for _ in 0..steps as u64 {
            scene.world.step();
            if let Some(snapshot) = scene.world.observe(scene.robot) {
                stance.note(&subject.robot, &subject.floor, &snapshot, 1.0 / (steps * weight));
            }
        }
        Ok(stance)
    }

    fn note(&mut self, def: &RobotDef, floor: &Material, robot: &RobotSnapshot, part: f64) {
        let placed = def.placed_links(&robot.joints);
        let own = robot.body.pose.inverse();
        for contact in &robot.contacts {
            let at = own * Point3::from(contact.point);
            // Up is negative.
            let load = -contact.force.z * part;
            let mut driven = 0;
            let mut nearest: Option<(f64, Touching)> = None;
            let mut offer = |distance: f64, touching: Touching| {
                if nearest.as_ref().is_none_or(|(least, _)| distance < *least) {
                    nearest = Some((distance, touching));
                }
            };
            for (link, pose) in &placed {
                if let Some(wheel) = &link.wheel {
                    let touching = if link.is_driven_wheel() { Touching::Driven(driven) } else { Touching::Caster };
                    driven += usize::from(link.is_driven_wheel());
                    // A wheel wins over a shape at the same distance.
                    offer(outside_wheel(pose.inverse() * at, wheel) - NEAR, touching);
                }
                for solid in &link.solids {
                    let local = (pose * link.pose_of(solid)).inverse() * at;
                    let friction = [solid.material.friction, floor.friction, solid.material.pair(floor).0];
                    offer(outside(&solid.shape, local), Touching::Shape(solid.name.clone(), friction));
                }
            }
            match nearest {
                Some((_, Touching::Driven(number))) => {
                    self.driven.get_mut(number).into_iter().for_each(|sum| *sum += load);
                }
                Some((_, Touching::Caster)) => self.casters += load,
                Some((_, Touching::Shape(name, friction))) => {
                    let entry = self.shapes.entry(name).or_default();
                    *entry = (entry.0 + load, friction);
                }
                None => {}
            }
        }
    }

    /// Describes what is unusual about the stance; `None` if nothing is.
    pub fn remark(&self, robot: &RobotDef) -> Option<String> {
        let percent = |part: f64| format!("{:.0} %", 100.0 * part);
        let rubbing = self.shapes.iter().filter(|(_, (part, _))| *part > NOTABLE);
        if let Some((name, (part, [own, floor, both]))) = rubbing.max_by(|a, b| a.1.0.total_cmp(&b.1.0)) {
            let part = percent(*part);
            return Some(format!(
                "`{name}` rubs on the floor with {part} of the weight and friction {both:.2}, the mean of its {own:.2} and the floor's \
                 {floor:.2}: lift it, move the mass (`centre`) onto the wheels, or make it a [[caster]] in a robot.toml, which rolls"
            ));
        }
        // A wheel on a flipper or another moving link need not touch the floor.
        let on_body = |link: &Link| link.joint.as_ref().is_some_and(|joint| joint.parent == 0);
        let mut wheels = robot.links.iter().filter(|link| link.is_driven_wheel()).zip(&self.driven);
        if let Some((Link { name, .. }, _)) = wheels.find(|(link, part)| **part < NOTABLE && on_body(link)) {
            return Some(format!(
                "the wheel `{name}` carries nothing: it does not reach the floor, or `centre` is beyond it"
            ));
        }
        let sides = [scene::Side::Left, scene::Side::Right].map(|side| {
            let loads = robot.driven().zip(&self.driven).filter(|(wheel, _)| wheel.side == side);
            loads.map(|(_, part)| part).sum::<f64>()
        });
        if (sides[0] - sides[1]).abs() > UNEVEN * (sides[0] + sides[1]) {
            let [left, right] = sides.map(percent);
            return Some(format!(
                "the left wheels carry {left} of the weight and the right ones {right}: look at `centre`"
            ));
        }
        let driven: f64 = self.driven.iter().sum();
        (driven < 0.5).then(|| format!("driven wheels carry {} of the weight, casters the rest", percent(driven)))
    }
}

/// Part of the robot at a contact.
enum Touching {
    Driven(usize),
    Caster,
    Shape(String, [f64; 3]),
}

/// Returns the distance of a point in a wheel's frame from the wheel, m; negative inside. The axle is y.
fn outside_wheel(at: Point3<f64>, wheel: &scene::Wheel) -> f64 {
    let outside = |middle: [f64; 2], radius: f64| (at.x - middle[0]).hypot(at.z - middle[1]) - radius;
    let across = match &wheel.belt {
        None => outside([0.0; 2], wheel.radius),
        Some(belt) => {
            let (around, [x, z]) = (belt.around(), belt.rollers.first().map_or([0.0; 2], |&[x, z, _]| [x, z]));
            let next = around.iter().cycle().skip(1);
            let discs = around.iter().zip(next).flat_map(|(&one, &other)| belt.run(one, other));
            discs
                .map(|disc| outside([disc.middle[0] - x, disc.middle[1] - z], disc.radius))
                .fold(f64::INFINITY, f64::min)
        }
    };
    across.max(at.y.abs() - wheel.width / 2.0)
}

/// Returns the approximate distance of a point in a shape's frame outside the shape, m.
fn outside(shape: &Shape, at: Point3<f64>) -> f64 {
    match shape {
        Shape::HalfSpace => f64::INFINITY,
        Shape::Box { size } => (0..3).map(|axis| at[axis].abs() - size[axis] / 2.0).fold(f64::MIN, f64::max),
        Shape::Cylinder { radius, length } => (at.x.hypot(at.y) - radius).max(at.z.abs() - length / 2.0),
        Shape::Ball { radius } => at.coords.norm() - radius,
        Shape::HeightField(field) => {
            let distances = field.corners().map(|corner| (Vector3::from(corner) - at.coords).norm());
            distances.fold(f64::INFINITY, f64::min)
        }
        Shape::Hull { points: corners } | Shape::Mesh { vertices: corners, .. } => {
            let distances = corners.iter().map(|corner| (Vector3::from(*corner) - at.coords).norm());
            distances.fold(f64::INFINITY, f64::min)
        }
    }
}

/// Returns the usual cause of a failed finding, and what to change; `None` for one that passes.
pub fn reason(robot: &RobotDef, finding: &Finding) -> Option<&'static str> {
    if finding.passes() {
        return None;
    }
    if finding.measured.is_nan() {
        return Some(GONE);
    }
    let name = super::checks(robot).get((finding.check as usize).checked_sub(1)?)?;
    let meaning = MEANINGS.iter().find(|it| it.check == *name && finding.what.starts_with(it.what))?;
    Some(if finding.measured < finding.least { meaning.low } else { meaning.high })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::validation::{mecanum_wheels, plain_wheels};

    #[test]
    fn every_check_has_a_meaning_for_whatever_it_measures() {
        for name in mecanum_wheels::CHECKS.iter().chain(&plain_wheels::CHECKS) {
            assert!(MEANINGS.iter().any(|it| it.check == *name && it.what.is_empty()), "{name}");
        }
        for Meaning { check, .. } in MEANINGS {
            assert!(mecanum_wheels::CHECKS.iter().chain(&plain_wheels::CHECKS).any(|name| name == check), "{check}");
        }
    }
}
