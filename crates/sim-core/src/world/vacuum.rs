//! Vacuums: objects stick to robots and come off (Vacuum.uc).
//!
//! An object that sticks to a vacuum keeps its id and is part of the vacuum's link, where it stuck: it loads the arm, and what it touches
//! pushes the arm. It comes off where it is when the vacuum opens, its tool is dropped or its robot leaves. In the original a spring holds
//! it, whose force is in the engine's units; here a vacuum carries objects up to a weight.

use std::sync::Arc;

use gamebots_proto::Problem;
use nalgebra::Vector3;
use scene::{Object, ObjectId, ObjectSnapshot, PawnId, Pose, Solid, Vacuum, position_and_rotation};

use super::World;
use super::held::{Stuck, Tool};
use crate::physics::{Identity, Light};

impl World {
    /// Closes a vacuum, so that the object ahead of it sticks, or opens it, so that its own comes off.
    pub(super) fn suck(&mut self, robot: PawnId, number: usize, closed: bool, problems: &mut Vec<Problem>) {
        let vacuum = self.robot(robot).and_then(|def| def.vacuums.get(number)).cloned();
        let Some(vacuum) = vacuum else { return };
        let held = self.stuck.iter().position(|it| it.robot == robot && it.vacuum == number);
        let done = match (closed, held) {
            (true, None) => self.stick(robot, number, &vacuum),
            (false, Some(place)) => self.let_go(place),
            _ => Ok(()),
        };
        if let Err(why) = done {
            problems.push(Problem::ToolRefused { name: vacuum.name, why });
        }
    }

    /// Fixes the first object that a ray along the vacuum's z axis meets to its link.
    fn stick(&mut self, robot: PawnId, number: usize, vacuum: &Vacuum) -> Result<(), String> {
        if let Some(tool) = &vacuum.tool
            && !holds(&self.tools, robot, tool)
        {
            return Err(format!("the robot does not hold the tool {tool}"));
        }
        self.enter_shapes();
        let carrier = self.carrier(robot, vacuum.link).ok_or("the robot is gone")?.pose;
        let mouth = carrier * vacuum.pose();
        let sight = self.physics.sight(Light::Visible, &mouth.translation.vector.into(), vacuum.reach, robot);
        let hit = sight.cast_ray(&(mouth.rotation * Vector3::z()));
        let hit = hit.ok_or_else(|| format!("nothing is within {} m ahead of it", vacuum.reach))?;
        let Identity::Object(id) = hit.identity else { return Err("what is ahead of it cannot be lifted".to_owned()) };
        if self.tools.iter().any(|tool| tool.id == id) {
            return Err("what is ahead of it is a tool: expected an object".to_owned());
        }
        let now = self.physics.object(id).ok_or("the object is gone")?;
        let lifted = self.physics.lift_object(id).ok_or("an order of a world controller holds the object")?;
        let weight = lifted.def.mass * self.def().map.gravity;
        if weight > vacuum.force {
            self.physics.put_down(id, lifted, &now);
            return Err(format!("the object weighs {weight:.1} N: expected at most {} N", vacuum.force));
        }
        let (position, rotation) = position_and_rotation(&(carrier.inverse() * now));
        let Object { solid, mass } = &*lifted.def;
        let fixed = Arc::new(Object { solid: Solid { position, rotation, ..solid.clone() }, mass: *mass });
        self.stuck.push(Stuck { id, robot, vacuum: number, lifted, fixed });
        if let Err(why) = self.refit(robot) {
            if let Some(stuck) = self.stuck.pop() {
                self.physics.put_down(id, stuck.lifted, &now);
            }
            return Err(why);
        }
        Ok(())
    }

    /// Lets an object come off, by its place in the list. It goes on with the velocity of the link.
    fn let_go(&mut self, place: usize) -> Result<(), String> {
        let stuck = self.stuck.remove(place);
        let robot = stuck.robot;
        self.put_down(stuck);
        self.refit(robot)
    }

    /// Puts an object that has come off a robot back into the world.
    fn put_down(&mut self, stuck: Stuck) {
        let Stuck { id, robot, vacuum, lifted, fixed } = stuck;
        let link = self.robot(robot).and_then(|def| def.vacuums.get(vacuum)).map(|vacuum| vacuum.link);
        let Some(carrier) = link.and_then(|link| self.carrier(robot, link)) else { return };
        let pose = carrier.pose * fixed.solid.pose();
        self.physics.put_down(id, lifted, &pose);
        self.leave_link(id, &carrier, &pose);
    }

    /// Puts down the objects of a robot that is about to leave.
    pub(super) fn put_all_down(&mut self, robot: PawnId) {
        self.put_down_where(robot, |_| true);
    }

    /// Puts down the objects of a tool that its robot is about to drop. That refits the robot.
    pub(super) fn empty_tool(&mut self, robot: PawnId, tool: &Tool) {
        let is_of_tool = |vacuum: &Vacuum| vacuum.tool.as_ref().is_some_and(|name| is_named(tool, name));
        let vacuums = self.robot(robot).map_or(&[][..], |def| &def.vacuums);
        let own: Vec<bool> = vacuums.iter().map(is_of_tool).collect();
        self.put_down_where(robot, |stuck| own.get(stuck.vacuum) == Some(&true));
    }

    fn put_down_where(&mut self, robot: PawnId, is_meant: impl Fn(&Stuck) -> bool) {
        let own: Vec<Stuck> = self.stuck.extract_if(.., |stuck| stuck.robot == robot && is_meant(stuck)).collect();
        own.into_iter().for_each(|stuck| self.put_down(stuck));
    }

    /// Removes an object from the world, be it stuck to a robot.
    pub(super) fn remove_object(&mut self, id: ObjectId) {
        self.physics.remove_object(id);
        if let Some(place) = self.stuck.iter().position(|stuck| stuck.id == id) {
            let robot = self.stuck.remove(place).robot;
            _ = self.refit(robot);
        }
    }

    /// Returns snapshots of the objects that stick to robots.
    pub(super) fn stuck_objects(&self) -> impl Iterator<Item = ObjectSnapshot> {
        self.stuck.iter().filter_map(|it| {
            Some(ObjectSnapshot { id: it.id, def: it.lifted.def.clone(), pose: self.place_of_stuck(it)? })
        })
    }

    /// Returns the pose of an object, be it stuck to a robot.
    pub(super) fn place_of(&self, id: ObjectId) -> Option<Pose> {
        let stuck = || self.place_of_stuck(self.stuck.iter().find(|stuck| stuck.id == id)?);
        self.physics.object(id).or_else(stuck)
    }

    fn place_of_stuck(&self, stuck: &Stuck) -> Option<Pose> {
        let vacuum = self.robot(stuck.robot)?.vacuums.get(stuck.vacuum)?;
        Some(self.carrier(stuck.robot, vacuum.link)?.pose * stuck.fixed.solid.pose())
    }
}

/// True if one of a robot's tool changers holds a tool.
fn holds(tools: &[Tool], robot: PawnId, name: &str) -> bool {
    tools.iter().any(|tool| tool.robot == robot && tool.changer.is_some() && is_named(tool, name))
}

/// True if a tool has a name, in any case.
fn is_named(tool: &Tool, name: &str) -> bool {
    tool.name().eq_ignore_ascii_case(name)
}
