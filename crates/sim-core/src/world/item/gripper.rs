//! Grippers: joints that open and close together (Gripper.uc).

use gamebots_proto::Problem;
use gamebots_proto::command::Set;
use gamebots_proto::message::{Eff, GripperConf, ItemConf, ItemGeo, Message, MountedGeo};
use nalgebra::Vector3;
use scene::{Gripper, RobotDef};

use super::{Effect, Motion, Order, Report, State, Verbs, View, mounted};
use crate::world::held::Attachments;

#[derive(Clone)]
pub(crate) struct Item {
    pub(super) def: Gripper,
    pub(super) closed: bool,
}

impl Item {
    fn grip(&mut self, closed: bool, robot: &RobotDef) -> Effect {
        self.closed = closed;
        let targets = if closed { &self.def.closed } else { &self.def.open };
        let joints = self.def.links.iter().zip(targets);
        Effect::Order(Order::Joints(
            joints.filter_map(|(&link, &target)| Some((robot.value_of(link)?, target))).collect(),
        ))
    }

    /// True if the robot's actuator of a name carries it.
    fn is_carried_by(&self, actuator: &str, robot: &RobotDef) -> bool {
        let named = robot.actuators.iter().find(|it| it.name.eq_ignore_ascii_case(actuator));
        let links = named.zip(self.def.links.first());
        links.is_some_and(|(actuator, &finger)| actuator.links.iter().any(|&link| hangs_on(robot, finger, link)))
    }
}

impl Verbs for Item {
    fn identity(&self) -> (&'static str, &str) {
        ("Gripper", &self.def.name)
    }

    /// Opens or closes it: `Open`, `Close`, or `Grip` with 0 or 1, in any case (Gripper.uc:34-45).
    fn set(&mut self, set: &Set, view: &View) -> Option<Effect> {
        set.closes().map(|closed| self.grip(closed, view.robot))
    }

    fn act(&mut self, motion: &Motion, robot: &RobotDef, _problems: &mut Vec<Problem>) -> Option<Effect> {
        let is_meant = self.def.name.eq_ignore_ascii_case(motion.name) || self.is_carried_by(motion.name, robot);
        is_meant.then(|| motion.closed.map_or(Effect::None, |closed| self.grip(closed, robot)))
    }

    fn conf(&self, _robot: &RobotDef) -> ItemConf {
        GripperConf { name: self.def.name.clone() }.into()
    }

    /// Returns the midpoint of the finger joints, which is the tool point, too.
    fn geo(&self, robot: &RobotDef) -> Option<ItemGeo> {
        let Gripper { name, links, .. } = &self.def;
        let fingers = links.iter().filter_map(|&link| robot.links.get(link));
        let middle = fingers.map(|it| Vector3::from(it.origin())).sum::<Vector3<f64>>() / links.len() as f64;
        let carrier = robot.parent_of(*links.first()?)?;
        Some(ItemGeo::Mounted(MountedGeo { tip: Some([0.0; 3]), ..mounted(robot, name, carrier, middle, [0.0; 3]) }))
    }

    fn report(&mut self, view: &View, _: &Attachments) -> Option<Report> {
        let (time, name, closed) = (view.time as f32, self.def.name.clone(), self.closed);
        Some(Message::Eff(Eff { time, is_tool_changer: false, name, closed, tool_type: None, tool: None }).into())
    }

    fn state(&mut self) -> State<'_> {
        State { flags: vec![&mut self.closed], ..State::default() }
    }
}

/// True if `link` is the link `on` or one of its descendants.
fn hangs_on(robot: &RobotDef, link: usize, on: usize) -> bool {
    std::iter::successors(Some(link), |&link| robot.parent_of(link)).any(|link| link == on)
}
