//! Actuators: named groups of joints (robots.md 5).

use gamebots_proto::Problem;
use gamebots_proto::message::{
    ActuatorConf, ActuatorGeo, Asta, ItemConf, ItemGeo, JointConf, JointGeo, JointSta, Message, MisPkgConf, MisPkgJoint,
};
use nalgebra::Vector3;
use scene::{Actuator, Joint, JointKind, RobotDef};

use super::{Effect, Motion, Order, Report, Verbs, View};
use crate::sensor::floats;
use crate::world::held::Attachments;

/// USARSim's torque units in 1 N m.
const TORQUE_UNIT: f64 = 5.0;

#[derive(Clone)]
pub(crate) struct Item {
    pub(super) def: Actuator,
}

impl Item {
    /// Returns the configuration in the form before ACT.
    pub(super) fn mission_package(&self, robot: &RobotDef) -> ItemConf {
        let joint = |JointConf { link, kind, max_torque, min, max }| MisPkgJoint { link, kind, max_torque, min, max };
        MisPkgConf { name: self.def.name.clone(), joints: self.joints(robot).map(joint).collect() }.into()
    }

    fn joints(&self, robot: &RobotDef) -> impl Iterator<Item = JointConf> {
        (1..).zip(&self.def.links).filter_map(|(link, &number)| {
            let joint = robot.links.get(number)?.joint.as_ref()?;
            let kind = match joint.kind {
                JointKind::Revolute | JointKind::Continuous => "Revolute",
                JointKind::Prismatic => "Prismatic",
                JointKind::Fixed | JointKind::Ball | JointKind::Belt => "Unknown",
            };
            let [min, max] = joint.limits.unwrap_or_default().map(|limit| limit as f32);
            Some(JointConf { link, kind: kind.to_owned(), max_torque: max_torque(joint), min, max })
        })
    }
}

impl Verbs for Item {
    fn identity(&self) -> (&'static str, &str) {
        ("Actuator", &self.def.name)
    }

    fn act(&mut self, motion: &Motion, robot: &RobotDef, problems: &mut Vec<Problem>) -> Option<Effect> {
        let (Actuator { name, links, .. }, first) = (&self.def, motion.first);
        if !name.eq_ignore_ascii_case(motion.name) {
            return None;
        }
        let mut joints = Vec::new();
        for &(got, target) in motion.targets {
            let link = got.checked_sub(first).and_then(|number| links.get(number));
            match link.and_then(|&link| robot.value_of(link)) {
                Some(joint) => joints.push((joint, target)),
                None => {
                    let (name, last) = (name.clone(), (links.len() + first).saturating_sub(1));
                    problems.push(Problem::NoLink { got, name, first, last });
                }
            }
        }
        Some(Effect::Order(Order::Joints(joints)))
    }

    fn conf(&self, robot: &RobotDef) -> ItemConf {
        ActuatorConf { name: self.def.name.clone(), joints: self.joints(robot).collect() }.into()
    }

    /// Returns the geometry. All frames are parallel to the robot frame when every joint is at 0.
    fn geo(&self, robot: &RobotDef) -> Option<ItemGeo> {
        let Actuator { name, links, tip } = &self.def;
        let origin = |link: usize| robot.links.get(link).map_or_else(Vector3::zeros, |link| link.origin().into());
        let base = links.first().and_then(|&link| robot.parent_of(link)).map_or_else(Vector3::zeros, origin);
        let joint = |(number, &link): (usize, &usize)| {
            let parent = robot.parent_of(link).and_then(|it| links.iter().position(|&own| own == it));
            let from = parent.and_then(|parent| links.get(parent)).map_or(base, |&parent| origin(parent));
            JointGeo {
                link: number,
                parent: parent.map_or(0, |parent| parent as i32 + 1),
                location: floats((origin(link) - from).into()),
                orientation: [0.0; 3],
            }
        };
        let last = links.last().map_or(base, |&link| origin(link));
        Some(ItemGeo::Actuator(ActuatorGeo {
            name: name.clone(),
            location: floats(base.into()),
            orientation: [0.0; 3],
            mount: robot.class.clone(),
            joints: (1..).zip(links).map(joint).collect(),
            tip: floats((Vector3::from(*tip) - last).into()),
        }))
    }

    fn report(&mut self, view: &View, _: &Attachments) -> Option<Report> {
        let states = view.joints();
        let joint = |(link, &number): (usize, &usize)| {
            let state = states.get(view.robot.value_of(number)?)?;
            let torque = -max_torque(view.robot.links.get(number)?.joint.as_ref()?);
            // The wire has four decimals. Without this, a joint at rest at 0 would show the sign of a rounding error.
            let value = if state.position.abs() < 5e-5 { 0.0 } else { state.position as f32 };
            Some(JointSta { link, value, torque })
        };
        let joints = (1..).zip(&self.def.links).filter_map(joint).collect();
        Some(Message::Asta(Asta { time: view.time as f32, name: self.def.name.clone(), joints }).into())
    }
}

/// Returns the limit of a joint's motor, in USARSim's torque units, or in N for a prismatic joint.
fn max_torque(joint: &Joint) -> f32 {
    let unit = if joint.kind == JointKind::Prismatic { 1.0 } else { TORQUE_UNIT };
    joint.drive.as_ref().map_or(0.0, |motor| motor.max_torque * unit) as f32
}
