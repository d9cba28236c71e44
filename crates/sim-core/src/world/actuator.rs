//! Commands of actuators and grippers, and their states (robots.md 5).

use gamebots_proto::Problem;
use gamebots_proto::command::Set;
use gamebots_proto::message::{
    ActuatorConf, ActuatorGeo, Asta, Eff, GripperConf, ItemConf, ItemGeo, JointConf, JointGeo, JointSta, Message,
    MisPkgConf, MisPkgJoint,
};
use nalgebra::Vector3;
use scene::{Actuator, Gripper, Joint, JointKind, RobotDef};

use super::answer::item_geo;
use super::robot::{Robot, unknown};
use crate::drive::Order;
use crate::physics::Physics;
use crate::sensor::floats;

/// USARSim's torque units in 1 N m.
const TORQUE_UNIT: f64 = 5.0;

impl Robot {
    /// Sets joint targets of the actuator called `name`, in any case. Joint numbers start at `first`. Opens or closes the gripper of that name
    /// and those that the actuator carries.
    pub(super) fn act(
        &mut self,
        name: &str,
        first: usize,
        targets: &[(usize, f64)],
        gripper: Option<f64>,
        problems: &mut Vec<Problem>,
    ) {
        let def = &self.bodies().robot().def;
        let actuator = def.actuators.iter().find(|it| it.name.eq_ignore_ascii_case(name));
        if targets.is_empty() && gripper.is_none() {
            let (verb, key) = if first == 0 {
                ("ACT", "Link and Value, or Gripper")
            } else {
                ("MISPKG", "Link, Value and Order 0 in this order, or Gripper")
            };
            problems.push(Problem::MissingKey { verb, key });
        }
        let mut joints = Vec::new();
        for (actuator, &(got, target)) in actuator.iter().flat_map(|it| targets.iter().map(move |target| (it, target)))
        {
            let link = got.checked_sub(first).and_then(|number| actuator.links.get(number));
            match link.and_then(|&link| def.value_of(link)) {
                Some(joint) => joints.push((joint, target)),
                None => {
                    let (name, last) = (actuator.name.clone(), (actuator.links.len() + first).saturating_sub(1));
                    problems.push(Problem::NoLink { got, name, first, last });
                }
            }
        }
        let carries = |link: usize| actuator.is_some_and(|it| it.links.iter().any(|&own| hangs_on(def, link, own)));
        let grippers = def.grippers.iter().enumerate().filter(|(_, it)| {
            it.name.eq_ignore_ascii_case(name) || it.links.first().is_some_and(|&link| carries(link))
        });
        let grippers: Vec<usize> = grippers.map(|(number, _)| number).collect();
        if actuator.is_none() && grippers.is_empty() {
            let known = def.actuators.iter().map(|it| it.name.as_str());
            problems.push(unknown("Name", name, known.chain(def.grippers.iter().map(|it| it.name.as_str()))));
        }
        self.follow(&Order::Joints(joints));
        for number in grippers {
            if let Some(gripper) = gripper {
                self.grip(number, gripper != 0.0);
            }
        }
    }

    /// Opens and closes grippers: `Open`, `Close`, or `Grip` with 0 or 1, in any case. An empty name means all (Gripper.uc:34-45). Returns
    /// true if the opcode is known and a gripper matches.
    pub(super) fn set_grippers(&mut self, set: &Set) -> bool {
        let Some(closed) = set.closes() else { return false };
        let named = self.def().grippers.iter().enumerate();
        let named = named.filter(|(_, it)| is_asked(&it.name, &set.name));
        let numbers: Vec<usize> = named.map(|(number, _)| number).collect();
        numbers.iter().for_each(|&number| self.grip(number, closed));
        !numbers.is_empty()
    }

    fn grip(&mut self, number: usize, closed: bool) {
        let def = &self.bodies().robot().def;
        let Some(gripper) = def.grippers.get(number) else { return };
        let targets = if closed { &gripper.closed } else { &gripper.open };
        let joints = gripper.links.iter().zip(targets);
        let joints: Vec<_> = joints.filter_map(|(&link, &target)| Some((def.value_of(link)?, target))).collect();
        self.follow(&Order::Joints(joints));
        self.note_gripper(number, closed);
    }

    /// Sends the state of every actuator, then of every gripper.
    pub(super) fn report_actuators(&self, physics: &Physics, time: f64, mut send: impl FnMut(Message)) {
        let def = self.def();
        if def.actuators.is_empty() && def.grippers.is_empty() {
            return;
        }
        let joints = physics.joints(self.bodies());
        for actuator in &def.actuators {
            let joint = |(link, &number): (usize, &usize)| {
                let state = joints.get(def.value_of(number)?)?;
                let torque = -max_torque(def.links.get(number)?.joint.as_ref()?);
                // The wire has four decimals. Without this, a joint at rest at 0 would show the sign of a rounding error.
                let value = if state.position.abs() < 5e-5 { 0.0 } else { state.position as f32 };
                Some(JointSta { link, value, torque })
            };
            let joints = (1..).zip(&actuator.links).filter_map(joint).collect();
            send(Message::Asta(Asta { time: time as f32, name: actuator.name.clone(), joints }));
        }
        for (gripper, &closed) in def.grippers.iter().zip(self.closed_grippers()) {
            let (time, name) = (time as f32, gripper.name.clone());
            send(Message::Eff(Eff { time, is_tool_changer: false, name, closed, tool_type: None, tool: None }));
        }
    }
}

/// Returns CONF of the actuators or grippers that a type asks for. A name, in any case, selects one; an empty one selects all.
pub(super) fn confs(def: &RobotDef, type_name: &str, name: &str) -> Vec<ItemConf> {
    let actuators = def.actuators.iter().filter(|it| is_asked(&it.name, name));
    let (own, joints) = (|it: &Actuator| it.name.clone(), |it: &Actuator| joint_confs(def, it));
    if type_name == "MisPkg" {
        let joint = |JointConf { link, kind, max_torque, min, max }| MisPkgJoint { link, kind, max_torque, min, max };
        let joints = |it| joints(it).into_iter().map(joint).collect();
        return actuators.map(|it| MisPkgConf { name: own(it), joints: joints(it) }.into()).collect();
    }
    match type_name.to_ascii_lowercase().as_str() {
        "actuator" => actuators.map(|it| ActuatorConf { name: own(it), joints: joints(it) }.into()).collect(),
        "gripper" => {
            let grippers = def.grippers.iter().filter(|it| is_asked(&it.name, name));
            grippers.map(|it| GripperConf { name: it.name.clone() }.into()).collect()
        }
        _ => Vec::new(),
    }
}

/// Returns the limit of a joint's motor, in USARSim's torque units, or in N for a prismatic joint.
fn max_torque(joint: &Joint) -> f32 {
    let unit = if joint.kind == JointKind::Prismatic { 1.0 } else { TORQUE_UNIT };
    joint.drive.as_ref().map_or(0.0, |motor| motor.max_torque * unit) as f32
}

fn joint_confs(def: &RobotDef, actuator: &Actuator) -> Vec<JointConf> {
    let joint = |(link, &number): (usize, &usize)| {
        let joint = def.links.get(number)?.joint.as_ref()?;
        let kind = match joint.kind {
            JointKind::Revolute | JointKind::Continuous => "Revolute",
            JointKind::Prismatic => "Prismatic",
            JointKind::Fixed | JointKind::Ball => "Unknown",
        };
        let [min, max] = joint.limits.unwrap_or_default().map(|limit| limit as f32);
        let max_torque = max_torque(joint);
        Some(JointConf { link, kind: kind.to_owned(), max_torque, min, max })
    };
    (1..).zip(&actuator.links).filter_map(joint).collect()
}

/// Returns GEO of the actuators. A name, in any case, selects one; an empty one selects all. All frames are parallel to the robot frame
/// when every joint is at 0.
pub(super) fn geos(def: &RobotDef, name: &str) -> Vec<ActuatorGeo> {
    let actuators = def.actuators.iter().filter(|it| is_asked(&it.name, name));
    let origin = |link: usize| def.links.get(link).map_or_else(Vector3::zeros, |link| link.origin().into());
    let geo = |actuator: &Actuator| {
        let parent_of = |link: usize| def.links.get(link)?.joint.as_ref().map(|joint| joint.parent);
        let base = actuator.links.first().and_then(|&link| parent_of(link)).map_or_else(Vector3::zeros, origin);
        let joint = |(number, &link): (usize, &usize)| {
            let parent = parent_of(link).and_then(|it| actuator.links.iter().position(|&own| own == it));
            let from = parent.map_or(base, |parent| origin(actuator.links[parent]));
            let location = floats((origin(link) - from).into());
            JointGeo {
                link: number,
                parent: parent.map_or(0, |parent| parent as i32 + 1),
                location,
                orientation: [0.0; 3],
            }
        };
        let last = actuator.links.last().map_or(base, |&link| origin(link));
        ActuatorGeo {
            name: actuator.name.clone(),
            location: floats(base.into()),
            orientation: [0.0; 3],
            mount: def.class.clone(),
            joints: (1..).zip(&actuator.links).map(joint).collect(),
            tip: floats((Vector3::from(actuator.tip) - last).into()),
        }
    };
    actuators.map(geo).collect()
}

/// Returns GEO of the grippers if the type asks for them. A gripper's place, and its tool point, is the midpoint of its finger joints.
pub(super) fn gripper_geos(def: &RobotDef, type_name: &str, name: &str) -> Vec<ItemGeo> {
    let asked = type_name.eq_ignore_ascii_case("Gripper");
    let grippers = def.grippers.iter().filter(|it| asked && is_asked(&it.name, name));
    let geo = |gripper: &Gripper| {
        let fingers = gripper.links.iter().filter_map(|&link| def.links.get(link));
        let middle = fingers.map(|it| Vector3::from(it.origin())).sum::<Vector3<f64>>() / gripper.links.len() as f64;
        let carrier = def.links.get(*gripper.links.first()?)?.joint.as_ref()?.parent;
        Some(ItemGeo { tip: Some([0.0; 3]), ..item_geo(def, &gripper.name, carrier, middle, [0.0; 3]) })
    };
    grippers.filter_map(geo).collect()
}

/// True if the requested `name`, in any case, is the item's `own` name or is empty, which asks for all items.
pub(super) fn is_asked(own: &str, name: &str) -> bool {
    name.is_empty() || own.eq_ignore_ascii_case(name)
}

/// True if `link` is the link `on` or one of its descendants.
fn hangs_on(def: &RobotDef, link: usize, on: usize) -> bool {
    let parent = |&link: &usize| def.links.get(link)?.joint.as_ref().map(|joint| joint.parent);
    std::iter::successors(Some(link), parent).any(|link| link == on)
}
