//! Tools that robots hold, drop and take (ToolChanger.uc:18-148).
//!
//! A tool is an object with an id for as long as it is in the world. While a tool changer holds it, it is part of the changer's link: it
//! loads the arm, and what it touches pushes the arm. Once dropped, it is an object like any other. It leaves with the robot that held it
//! last.

use std::sync::Arc;

use gamebots_proto::Problem;
use nalgebra::Vector3;
use scene::{ObjectId, PawnId, ToolChanger};

use super::World;
use super::held::{Attachment, Attachments, Hand, Origin};
use crate::physics::{CompiledRobot, Identity, Light};

/// Tolerance of comparisons with the limits of a tool changer, m or rad.
const ROUNDING: f64 = 1e-9;

impl World {
    /// Returns the tools with which the next robot of a class is spawned, and the class with them. Fails with the reason in words.
    pub(super) fn outfit(&mut self, class: &Arc<CompiledRobot>) -> Result<(Attachments, Arc<CompiledRobot>), String> {
        let robot = PawnId(self.next_id);
        let held =
            class.def.tool_changers.iter().enumerate().filter_map(|(number, it)| Some((number, it.tool.as_ref()?)));
        let ids = (self.next_object..).map(ObjectId);
        let mut tools = Attachments::default();
        for ((changer, tool), id) in held.zip(ids) {
            let (hand, object) = (Some(Hand::Changer(changer)), Arc::new(tool.object.clone()));
            tools.add(Attachment { id, robot, hand, object, origin: Origin::Tool(tool.kind.clone()) });
        }
        let fitted = tools.fitted(&mut self.physics, class, robot)?;
        Ok((tools, fitted))
    }

    /// Closes a tool changer, so that it takes a tool, or opens it, so that it drops its own.
    pub(super) fn change_tool(&mut self, robot: PawnId, number: usize, closed: bool, problems: &mut Vec<Problem>) {
        let changer = self.robot(robot).and_then(|def| def.tool_changers.get(number)).cloned();
        let Some(changer) = changer else { return };
        let held = self.attached.of(robot, Hand::Changer(number)).cloned();
        let done = match (closed, held) {
            (true, None) => self.take_tool(robot, number, &changer),
            (false, Some(tool)) => self.drop_tool(tool),
            _ => Ok(()),
        };
        if let Err(why) = done {
            problems.push(Problem::ToolRefused { name: changer.name, why });
        }
    }

    fn drop_tool(&mut self, tool: Attachment) -> Result<(), String> {
        self.empty_tool(tool.robot, &tool);
        let (carrier, pose) = self.carried(&tool).ok_or("the robot is gone")?;
        self.hand_over(tool.id, tool.robot, None);
        if let Err(why) = self.refit(tool.robot) {
            self.hand_over(tool.id, tool.robot, tool.hand);
            return Err(why);
        }
        self.physics.spawn_object(tool.id, tool.object, &pose, false);
        self.leave_link(tool.id, &carrier, &pose);
        Ok(())
    }

    /// Gives a tool to an item of a robot, or to none.
    fn hand_over(&mut self, tool: ObjectId, robot: PawnId, hand: Option<Hand>) {
        if let Some(tool) = self.attached.get_mut(tool) {
            (tool.robot, tool.hand) = (robot, hand);
        }
    }

    /// Takes the first tool that a ray along the changer's z axis meets, if it is near enough and turned like the changer.
    fn take_tool(&mut self, robot: PawnId, number: usize, changer: &ToolChanger) -> Result<(), String> {
        self.enter_shapes();
        let own = self.carrier(robot, changer.link).ok_or("the robot is gone")?.pose * changer.pose();
        let (origin, reach) = (own.translation.vector.into(), 2.0 * changer.position_tolerance);
        let sight = self.physics.sight(Light::Visible, &origin, reach, robot);
        let hit = sight.cast_ray(&(own.rotation * Vector3::z())).ok_or("nothing is ahead of it")?;
        let Identity::Object(id) = hit.identity else { return Err("what is ahead of it is no tool".to_owned()) };
        let is_it = |it: &&Attachment| it.id == id && it.hand.is_none();
        let (before, shape) = self
            .attached
            .iter()
            .find(is_it)
            .map(|tool| (tool.robot, tool.object.solid.pose()))
            .ok_or("what is ahead of it is no tool")?;
        let tool = self.physics.object(id).ok_or("the tool is gone")? * shape.inverse();
        let distance = (tool.translation.vector - own.translation.vector).norm();
        let between = |axis: Vector3<f64>| (tool.rotation * axis).angle(&(own.rotation * axis));
        let angle = between(Vector3::x()).max(between(Vector3::y()));
        if distance > changer.position_tolerance + ROUNDING || angle > changer.angle_tolerance + ROUNDING {
            let ToolChanger { position_tolerance, angle_tolerance, .. } = changer;
            return Err(format!(
                "the tool is {distance:.3} m and {angle:.3} rad away: expected at most {position_tolerance} m and {angle_tolerance} rad"
            ));
        }
        self.hand_over(id, robot, Some(Hand::Changer(number)));
        if let Err(why) = self.refit(robot) {
            self.hand_over(id, before, None);
            return Err(why);
        }
        self.physics.remove_object(id);
        Ok(())
    }

    /// Removes the tools of a robot that leaves.
    pub(super) fn remove_tools(&mut self, robot: PawnId) {
        for tool in self.attached.take_where(|it| it.robot == robot && it.kind().is_some()) {
            self.physics.remove_object(tool.id);
        }
    }
}
