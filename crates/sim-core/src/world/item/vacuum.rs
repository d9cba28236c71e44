//! Vacuums as items: grippers on the wire (Vacuum.uc). How objects stick to them is in [`super::super::vacuum`].

use gamebots_proto::Problem;
use gamebots_proto::command::Set;
use gamebots_proto::message::{Eff, GripperConf, ItemConf, ItemGeo, Message, MountedGeo};
use nalgebra::Vector3;
use scene::{RobotDef, Vacuum};

use super::{Effect, Motion, Report, Verbs, View, mounted};
use crate::world::held::{Attachments, Hand};

#[derive(Clone)]
pub(crate) struct Item {
    /// Number in the robot's class.
    pub(super) number: usize,
    pub(super) def: Vacuum,
}

impl Item {
    fn suck(&self, closed: bool) -> Effect {
        Effect::Hand { hand: Hand::Vacuum(self.number), closed }
    }
}

impl Verbs for Item {
    fn identity(&self) -> (&'static str, &str) {
        ("Gripper", &self.def.name)
    }

    /// Sucks or lets go: `Close`, `Open`, or `Grip` with 1 or 0, in any case (Gripper.uc:34-45).
    fn set(&mut self, set: &Set, _view: &View) -> Option<Effect> {
        set.closes().map(|closed| self.suck(closed))
    }

    /// Sucks or lets go by its own name or that of an actuator that carries it.
    fn act(&mut self, motion: &Motion, robot: &RobotDef, _problems: &mut Vec<Problem>) -> Option<Effect> {
        let carrier = robot.actuator_of(self.def.link).map(|(actuator, _)| actuator.name.as_str());
        let is_meant = [Some(self.def.name.as_str()), carrier]
            .into_iter()
            .flatten()
            .any(|it| it.eq_ignore_ascii_case(motion.name));
        is_meant.then(|| motion.closed.map_or(Effect::None, |closed| self.suck(closed)))
    }

    fn conf(&self, _robot: &RobotDef) -> ItemConf {
        GripperConf { name: self.def.name.clone() }.into()
    }

    /// Returns the pose of its mouth, which is the tool point, too.
    fn geo(&self, robot: &RobotDef) -> Option<ItemGeo> {
        let Vacuum { name, link, position, direction, .. } = &self.def;
        let place = mounted(robot, name, *link, Vector3::from(*position), *direction);
        Some(ItemGeo::Mounted(MountedGeo { tip: Some([0.0; 3]), ..place }))
    }

    /// Reports `CLOSED` while an object sticks to it. As in the original it is open again when it loses that (Vacuum.uc:110-127).
    fn report(&mut self, view: &View, held: &Attachments) -> Option<Report> {
        let closed = held.of(view.id, Hand::Vacuum(self.number)).is_some();
        let (time, name) = (view.time as f32, self.def.name.clone());
        Some(Message::Eff(Eff { time, is_tool_changer: false, name, closed, tool_type: None, tool: None }).into())
    }
}
