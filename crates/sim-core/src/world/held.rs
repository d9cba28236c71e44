//! Objects that are part of a robot's link: the tools that its tool changers hold, and what sticks to its vacuums.
//!
//! An object keeps its id meanwhile. The robot's class is compiled again with it.

use std::sync::Arc;

use scene::{BodyState, Object, ObjectId, PawnId, Pose, RobotDef, check};
use serde::{Deserialize, Serialize};

use super::World;
use crate::physics::{CompiledRobot, Held, Lifted, Physics};

/// A tool in the world.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Tool {
    pub(super) id: ObjectId,
    /// Robot that holds it, or held it last.
    pub(super) robot: PawnId,
    /// Number of the tool changer that holds it; `None` if it lies about.
    pub(super) changer: Option<usize>,
    /// Type on the wire.
    pub(super) kind: String,
    /// Name, shape and mass. The pose of the shape is in the frame of the changer.
    pub(super) object: Arc<Object>,
}

impl Tool {
    /// Returns the type on the wire.
    pub(super) fn kind(&self) -> &str {
        &self.kind
    }

    /// Returns the name.
    pub(super) fn name(&self) -> &str {
        &self.object.solid.name
    }

    /// True if it is a tool that a robot can hold.
    pub(super) fn is_sound(&self) -> bool {
        check::spawned_object(&self.object).is_empty()
    }
}

/// An object that sticks to a vacuum.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Stuck {
    pub(super) id: ObjectId,
    pub(super) robot: PawnId,
    /// Number of the vacuum in the robot's class.
    pub(super) vacuum: usize,
    /// The object as it was in the world.
    pub(super) lifted: Lifted,
    /// The object with the pose of its shape in the robot frame when every joint is at 0.
    pub(super) fixed: Arc<Object>,
}

impl Stuck {
    /// Returns the object as part of its link.
    pub(super) fn held<'a>(&'a self, robot: &RobotDef) -> Option<Held<'a>> {
        let vacuum = robot.vacuums.get(self.vacuum)?;
        Some(Held { link: vacuum.link, at: self.fixed.solid.pose(), object: &self.fixed })
    }

    /// True if it is an object that a world can have.
    pub(super) fn is_sound(&self) -> bool {
        [&self.lifted.def, &self.fixed].into_iter().all(|object| check::spawned_object(object).is_empty())
    }

    /// True if the map has the object.
    pub(super) fn is_of_map(&self) -> bool {
        self.lifted.is_of_map
    }
}

impl World {
    /// Gives a robot the class with the tools that it holds now, and what sticks to it.
    pub(super) fn refit(&mut self, id: PawnId) -> Result<(), String> {
        let name = self.robots.get(&id).map(|robot| robot.def().class.clone()).ok_or("the robot is gone")?;
        let class = self.compiled(&name).ok_or("its class is gone")?;
        let fitted = fitted(&mut self.physics, &class, id, &self.tools, &self.stuck)?;
        let robot = self.robots.get_mut(&id).ok_or("the robot is gone")?;
        let is_refitted = self.physics.refit(robot.bodies_mut(), id, fitted);
        is_refitted.then_some(()).ok_or("the drive model `bodies` cannot change tools".to_owned())
    }

    /// Returns the robot frame as it moves with a link.
    pub(super) fn carrier(&self, robot: PawnId, link: usize) -> Option<BodyState> {
        let bodies = self.robots.get(&robot)?.bodies();
        Some(self.physics.carrier(bodies, link).unwrap_or_else(|| self.physics.body(bodies)))
    }

    /// Gives an object that comes off a link at a pose the velocity of the link.
    pub(super) fn leave_link(&mut self, id: ObjectId, carrier: &BodyState, pose: &Pose) {
        let lever = pose.translation.vector - carrier.pose.translation.vector;
        self.physics.push_off(id, &(carrier.linear + carrier.angular.cross(&lever)), &carrier.angular);
    }
}

/// Returns a class with the tools that a robot holds, and what sticks to it. Fails with the reason in words.
pub(super) fn fitted(
    physics: &mut Physics,
    class: &Arc<CompiledRobot>,
    robot: PawnId,
    tools: &[Tool],
    stuck: &[Stuck],
) -> Result<Arc<CompiledRobot>, String> {
    let of_tool = |tool: &'_ Tool| {
        let changer = class.def.tool_changers.get(tool.changer?)?;
        Some((changer.link, changer.pose() * tool.object.solid.pose()))
    };
    let own = tools.iter().filter(|tool| tool.robot == robot);
    let tools = own.filter_map(|tool| of_tool(tool).map(|(link, at)| Held { link, at, object: &tool.object }));
    let stuck = stuck.iter().filter(|stuck| stuck.robot == robot).filter_map(|stuck| stuck.held(&class.def));
    physics.fitted(class, tools.chain(stuck))
}
