//! Springs by which world controllers pull objects and robots, as hands do. The original has none.

use gamebots_proto::command;
use nalgebra::Vector3;
use scene::{ObjectId, PawnId, PullSnapshot, check};
use serde::{Deserialize, Serialize};

use super::World;
use crate::physics::{Spring, Tug};

/// Most things of a world that are pulled at a time. A controller pulls no more than it leaves for others.
pub(super) const MAX_PULLS: usize = 64;

/// An object or a robot that a world controller pulls.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Pull {
    by: PawnId,
    thing: Thing,
    spring: Spring,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
enum Thing {
    Object(ObjectId),
    Robot(PawnId),
}

impl Pull {
    /// True if its numbers are such as orders give them. Saved ones may come from a stranger.
    pub(super) fn is_sound(&self) -> bool {
        let Spring { grip, to, turn } = &self.spring;
        let is_near = |place: &Vector3<f64>| place.iter().all(|&it| check::MAP_REACH.holds(it));
        is_near(grip)
            && to.as_ref().is_none_or(is_near)
            && turn.is_none_or(|it| it.coords.iter().all(|it| it.is_finite()))
    }
}

impl World {
    /// Pulls an object or a robot, or lets it go. A pull by another controller ends: the last hand holds it.
    pub(super) fn pull(&mut self, by: PawnId, order: &command::Pull) -> Result<(), String> {
        let command::Pull { name, grip, location, rotation } = order;
        let thing = match self.object_of(by, name) {
            Some(id) => Thing::Object(id),
            None => Thing::Robot(self.robot_of(name).ok_or("no object or robot has that name")?),
        };
        for (key, place) in [("Grip", Some(grip)), ("Location", location.as_ref())] {
            if let Some(wrong) = place.and_then(|place| check::MAP_REACH.problem_in(key, place)) {
                return Err(wrong);
            }
        }
        self.pulls.retain(|pull| pull.thing != thing);
        if location.is_none() && rotation.is_none() {
            return Ok(());
        }
        let (all, own) = (self.pulls.len(), self.pulls.iter().filter(|pull| pull.by == by).count());
        if own >= MAX_PULLS - all.min(MAX_PULLS) {
            return Err(format!(
                "{own} things are pulled by it, {all} in all: expected no more of {MAX_PULLS} than are left for others"
            ));
        }
        let turn = rotation.map(|angles| scene::pose([0.0; 3], angles).rotation);
        let spring = Spring { grip: (*grip).into(), to: location.map(Into::into), turn };
        let pull = Pull { by, thing, spring };
        self.tug(&pull).ok_or_else(|| self.why_fixed(thing))?;
        self.pulls.push(pull);
        Ok(())
    }

    /// Ends the pulls of a controller that leaves.
    pub(super) fn let_go(&mut self, by: PawnId) {
        self.pulls.retain(|pull| pull.by != by);
    }

    /// Applies all springs for the coming step, after the motors. A pull ends when its object or robot is gone, or held by something else.
    pub(super) fn apply_pulls(&mut self) {
        for pull in std::mem::take(&mut self.pulls) {
            let Some(tug) = self.tug(&pull) else { continue };
            match pull.thing {
                Thing::Object(id) => self.physics.pull_object(id, &tug),
                Thing::Robot(id) => {
                    if let Some(robot) = self.robots.get_mut(&id) {
                        self.physics.pull_robot(robot.bodies_mut(), &tug);
                    }
                }
            }
            self.pulls.push(pull);
        }
    }

    /// Returns snapshots of all springs.
    pub(super) fn pull_snapshots(&self) -> impl Iterator<Item = PullSnapshot> {
        self.pulls.iter().filter_map(|pull| {
            let Tug { point, force, .. } = self.tug(pull)?;
            Some(PullSnapshot { from: point, to: pull.spring.to.unwrap_or(point), force })
        })
    }

    /// Returns the effect of a spring now; `None` if nothing can pull its thing.
    fn tug(&self, Pull { thing, spring, .. }: &Pull) -> Option<Tug> {
        match thing {
            Thing::Object(id) => self.physics.tug_of_object(*id, spring),
            Thing::Robot(id) => {
                let robot = self.robots.get(id).filter(|robot| robot.def().footing.aerial().is_none())?;
                Some(self.physics.tug_of_robot(robot.bodies(), spring))
            }
        }
    }

    /// Returns the reason why something cannot be pulled, in words.
    fn why_fixed(&self, thing: Thing) -> String {
        let why = match thing {
            Thing::Object(id) if self.physics.object(id).is_none() => "a robot holds it",
            Thing::Object(_) => "nothing pushes it, as it was created without {Physics RigidBody} or orders move it",
            Thing::Robot(_) => "its rotors hold it",
        };
        why.to_owned()
    }
}
