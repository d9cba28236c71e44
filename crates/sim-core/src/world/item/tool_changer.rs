//! Tool changers as items (ToolChanger.uc:18-148). How robots hold, drop and take tools is in [`super::super::tools`].

use gamebots_proto::Problem;
use gamebots_proto::command::Set;
use gamebots_proto::message::{Eff, ItemConf, ItemGeo, Message, ToolChangerConf};
use scene::{RobotDef, ToolChanger};

use super::{Effect, Motion, Report, Verbs, View, mounted};
use crate::world::held::{Attachments, Hand};

#[derive(Clone)]
pub(crate) struct Item {
    /// Number in the robot's class.
    pub(super) number: usize,
    pub(super) def: ToolChanger,
}

impl Item {
    fn change(&self, closed: bool) -> Effect {
        Effect::Hand { hand: Hand::Changer(self.number), closed }
    }
}

impl Verbs for Item {
    fn identity(&self) -> (&'static str, &str) {
        ("ToolChanger", &self.def.name)
    }

    fn set(&mut self, set: &Set, _view: &View) -> Option<Effect> {
        set.closes().map(|closed| self.change(closed))
    }

    fn act(&mut self, motion: &Motion, _robot: &RobotDef, _problems: &mut Vec<Problem>) -> Option<Effect> {
        let is_meant = self.def.name.eq_ignore_ascii_case(motion.name);
        is_meant.then(|| motion.closed.map_or(Effect::None, |closed| self.change(closed)))
    }

    fn conf(&self, _robot: &RobotDef) -> ItemConf {
        let ToolChanger { name, position_tolerance, angle_tolerance, .. } = &self.def;
        let [position_tolerance, angle_tolerance] = [position_tolerance, angle_tolerance].map(|it| *it as f32);
        ToolChangerConf { name: name.clone(), position_tolerance, angle_tolerance }.into()
    }

    fn geo(&self, robot: &RobotDef) -> Option<ItemGeo> {
        let ToolChanger { name, link, position, direction, .. } = &self.def;
        Some(ItemGeo::Mounted(mounted(robot, name, *link, (*position).into(), *direction)))
    }

    fn report(&mut self, view: &View, held: &Attachments) -> Option<Report> {
        let tool = held.of(view.id, Hand::Changer(self.number));
        let state = Eff {
            time: view.time as f32,
            is_tool_changer: true,
            name: self.def.name.clone(),
            closed: tool.is_some(),
            tool_type: tool.and_then(|tool| tool.kind()).map(str::to_owned),
            tool: tool.map(|tool| tool.name().to_owned()),
        };
        Some(Message::Eff(state).into())
    }
}
