//! Vacuums: objects stick to robots and come off (Vacuum.uc).
//!
//! An object that sticks to a vacuum keeps its id and is part of the vacuum's link, where it stuck: it loads the arm, and what it touches
//! pushes the arm. It comes off where it is when the vacuum opens, its tool is dropped or its robot leaves. In the original a spring holds
//! it, whose force is in the engine's units; here a vacuum carries objects up to a weight.

use std::sync::Arc;

use gamebots_proto::Problem;
use nalgebra::Vector3;
use scene::{Object, PawnId, Solid, Vacuum, position_and_rotation};

use super::World;
use super::held::{Attachment, Hand, Origin};
use crate::physics::{Identity, Light};

impl World {
    /// Closes a vacuum, so that the object ahead of it sticks, or opens it, so that its own comes off.
    pub(super) fn suck(&mut self, robot: PawnId, number: usize, closed: bool, problems: &mut Vec<Problem>) {
        let vacuum = self.robot(robot).and_then(|def| def.vacuums.get(number)).cloned();
        let Some(vacuum) = vacuum else { return };
        let held = self.attached.of(robot, Hand::Vacuum(number)).map(|it| it.id);
        let done = match (closed, held) {
            (true, None) => self.stick(robot, number, &vacuum),
            (false, Some(id)) => {
                let own = self.attached.take(id);
                own.into_iter().for_each(|it| self.put_down(it));
                self.refit(robot)
            }
            _ => Ok(()),
        };
        if let Err(why) = done {
            problems.push(Problem::ToolRefused { name: vacuum.name, why });
        }
    }

    /// Fixes the first object that a ray along the vacuum's z axis meets to its link.
    fn stick(&mut self, robot: PawnId, number: usize, vacuum: &Vacuum) -> Result<(), String> {
        if let Some(tool) = &vacuum.tool
            && !self.attached.iter().any(|it| it.robot == robot && is_held_as(it, tool))
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
        if self.attached.iter().any(|it| it.id == id) {
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
        let (hand, origin) = (Some(Hand::Vacuum(number)), Origin::World(lifted));
        self.attached.add(Attachment { id, robot, hand, object: fixed, origin });
        if let Err(why) = self.refit(robot) {
            if let Some(Attachment { origin: Origin::World(lifted), .. }) = self.attached.take(id) {
                self.physics.put_down(id, lifted, &now);
            }
            return Err(why);
        }
        Ok(())
    }

    /// Puts an object that has come off a vacuum back into the world. It goes on with the velocity of the link.
    fn put_down(&mut self, attachment: Attachment) {
        let Some((carrier, pose)) = self.carried(&attachment) else { return };
        let Origin::World(lifted) = attachment.origin else { return };
        self.physics.put_down(attachment.id, lifted, &pose);
        self.leave_link(attachment.id, &carrier, &pose);
    }

    /// Puts down the objects of a robot that is about to leave.
    pub(super) fn put_all_down(&mut self, robot: PawnId) {
        self.put_down_where(robot, |_| true);
    }

    /// Puts down the objects of a tool that its robot is about to drop. That refits the robot.
    pub(super) fn empty_tool(&mut self, robot: PawnId, tool: &Attachment) {
        let is_of_tool = |vacuum: &Vacuum| vacuum.tool.as_ref().is_some_and(|name| is_named(tool, name));
        let vacuums = self.robot(robot).map_or(&[][..], |def| &def.vacuums);
        let own: Vec<bool> = vacuums.iter().map(is_of_tool).collect();
        self.put_down_where(robot, |vacuum| own.get(vacuum) == Some(&true));
    }

    /// Puts down the objects that a robot's vacuums hold, by the numbers of the vacuums.
    fn put_down_where(&mut self, robot: PawnId, is_meant: impl Fn(usize) -> bool) {
        let own = self
            .attached
            .take_where(|it| it.robot == robot && matches!(it.hand, Some(Hand::Vacuum(number)) if is_meant(number)));
        own.into_iter().for_each(|it| self.put_down(it));
    }
}

/// True if it is a tool with this name that a tool changer holds.
fn is_held_as(attachment: &Attachment, name: &str) -> bool {
    matches!(attachment.hand, Some(Hand::Changer(_))) && is_named(attachment, name)
}

/// True if a tool has a name, in any case.
fn is_named(tool: &Attachment, name: &str) -> bool {
    tool.name().eq_ignore_ascii_case(name)
}
