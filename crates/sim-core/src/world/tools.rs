//! Tools that robots hold, drop and take (ToolChanger.uc:18-148).
//!
//! A tool is an object with an id for as long as it is in the world. While a tool changer holds it, it is part of the changer's link: it
//! loads the arm, and what it touches pushes the arm. Once dropped, it is an object like any other. It leaves with the robot that held it
//! last.

use std::sync::Arc;

use gamebots_proto::Problem;
use nalgebra::Vector3;
use scene::{ObjectId, ObjectSnapshot, PawnId, ToolChanger};

use super::World;
use super::held::{Tool, fitted};
use crate::physics::{CompiledRobot, Identity, Light};

/// Tolerance of comparisons with the limits of a tool changer, m or rad.
const ROUNDING: f64 = 1e-9;

impl World {
    /// Returns the tools with which the next robot of a class is spawned, and the class with them. Fails with the reason in words.
    pub(super) fn outfit(&mut self, class: &Arc<CompiledRobot>) -> Result<(Vec<Tool>, Arc<CompiledRobot>), String> {
        let robot = PawnId(self.next_id);
        let held =
            class.def.tool_changers.iter().enumerate().filter_map(|(number, it)| Some((number, it.tool.as_ref()?)));
        let ids = (self.next_object..).map(ObjectId);
        let tool = |((changer, tool), id): ((usize, &scene::Tool), ObjectId)| Tool {
            id,
            robot,
            changer: Some(changer),
            kind: tool.kind.clone(),
            object: Arc::new(tool.object.clone()),
        };
        let tools: Vec<Tool> = held.zip(ids).map(tool).collect();
        let fitted = fitted(&mut self.physics, class, robot, &tools, &[])?;
        Ok((tools, fitted))
    }

    /// Closes a tool changer, so that it takes a tool, or opens it, so that it drops its own.
    pub(super) fn change_tool(&mut self, robot: PawnId, number: usize, closed: bool, problems: &mut Vec<Problem>) {
        let changer = self.robot(robot).and_then(|def| def.tool_changers.get(number)).cloned();
        let Some(changer) = changer else { return };
        let done = match (closed, held_by(&self.tools, robot, number)) {
            (true, None) => self.take_tool(robot, number, &changer),
            (false, Some(tool)) => self.drop_tool(tool, &changer),
            _ => Ok(()),
        };
        if let Err(why) = done {
            problems.push(Problem::ToolRefused { name: changer.name, why });
        }
    }

    fn drop_tool(&mut self, place: usize, changer: &ToolChanger) -> Result<(), String> {
        let tool = self.tools[place].clone();
        self.empty_tool(tool.robot, &tool);
        let carrier = self.carrier(tool.robot, changer.link).ok_or("the robot is gone")?;
        let pose = carrier.pose * changer.pose() * tool.object.solid.pose();
        self.tools[place].changer = None;
        if let Err(why) = self.refit(tool.robot) {
            self.tools[place].changer = tool.changer;
            return Err(why);
        }
        self.physics.spawn_object(tool.id, tool.object, &pose, false);
        self.leave_link(tool.id, &carrier, &pose);
        Ok(())
    }

    /// Takes the first tool that a ray along the changer's z axis meets, if it is near enough and turned like the changer.
    fn take_tool(&mut self, robot: PawnId, number: usize, changer: &ToolChanger) -> Result<(), String> {
        self.enter_shapes();
        let own = self.carrier(robot, changer.link).ok_or("the robot is gone")?.pose * changer.pose();
        let (origin, reach) = (own.translation.vector.into(), 2.0 * changer.position_tolerance);
        let sight = self.physics.sight(Light::Visible, &origin, reach, robot);
        let hit = sight.cast_ray(&(own.rotation * Vector3::z())).ok_or("nothing is ahead of it")?;
        let Identity::Object(id) = hit.identity else { return Err("what is ahead of it is no tool".to_owned()) };
        let is_it = |tool: &Tool| tool.id == id && tool.changer.is_none();
        let place = self.tools.iter().position(is_it).ok_or("what is ahead of it is no tool")?;
        let shape = self.physics.object(id).ok_or("the tool is gone")?;
        let tool = shape * self.tools[place].object.solid.pose().inverse();
        let distance = (tool.translation.vector - own.translation.vector).norm();
        let between = |axis: Vector3<f64>| (tool.rotation * axis).angle(&(own.rotation * axis));
        let angle = between(Vector3::x()).max(between(Vector3::y()));
        if distance > changer.position_tolerance + ROUNDING || angle > changer.angle_tolerance + ROUNDING {
            let ToolChanger { position_tolerance, angle_tolerance, .. } = changer;
            return Err(format!(
                "the tool is {distance:.3} m and {angle:.3} rad away: expected at most {position_tolerance} m and {angle_tolerance} rad"
            ));
        }
        let before = self.tools[place].robot;
        (self.tools[place].robot, self.tools[place].changer) = (robot, Some(number));
        if let Err(why) = self.refit(robot) {
            (self.tools[place].robot, self.tools[place].changer) = (before, None);
            return Err(why);
        }
        self.physics.remove_object(id);
        Ok(())
    }

    /// Returns snapshots of the tools that robots hold.
    pub(super) fn held_tools(&self) -> impl Iterator<Item = ObjectSnapshot> {
        self.tools.iter().filter_map(|tool| {
            let changer = self.robot(tool.robot)?.tool_changers.get(tool.changer?)?;
            let pose = self.carrier(tool.robot, changer.link)?.pose * changer.pose() * tool.object.solid.pose();
            Some(ObjectSnapshot { id: tool.id, def: tool.object.clone(), pose })
        })
    }

    /// Removes the tools of a robot that leaves.
    pub(super) fn remove_tools(&mut self, robot: PawnId) {
        for tool in self.tools.extract_if(.., |tool| tool.robot == robot) {
            self.physics.remove_object(tool.id);
        }
    }
}

/// Returns the place in a list of the tool that a tool changer holds.
fn held_by(tools: &[Tool], robot: PawnId, changer: usize) -> Option<usize> {
    tools.iter().position(|tool| tool.robot == robot && tool.changer == Some(changer))
}

/// Returns the tool that a tool changer holds.
pub(super) fn held(tools: &[Tool], robot: PawnId, changer: usize) -> Option<&Tool> {
    held_by(tools, robot, changer).and_then(|place| tools.get(place))
}
