//! The judge of goals: tasks of learning and leagues share it. [`scene::goal::Goal`] is the list of goals.
//!
//! A [`Judge`] plays one goal for some robots of a world: it begins with the robots where they are, and judges each interval by a [`Sight`]
//! of them. For learning, it also says what a robot observes. Each goal has one file.

mod explore;
mod fetch;
mod find;
mod follow;
mod push;
mod reach;
mod rules;
mod sight;
mod zone;

use std::sync::Arc;

use rand_chacha::ChaCha8Rng;
use scene::goal::Goal;
use scene::{MapDef, RobotDef};
use sim_core::World;

use rules::Rules;
pub use rules::Verdict;
pub use sight::{Place, RobotSight, Sight, distance, draw};

/// A goal as it is played by some robots.
#[derive(Clone)]
pub struct Judge(Played);

#[derive(Clone)]
enum Played {
    Reach(reach::Reach),
    Follow(follow::Follow),
    Push(push::Push),
    Fetch(Box<fetch::Fetch>),
    Explore(explore::Explore),
    Find(find::Find),
    Zone(zone::Zone),
}

impl Judge {
    /// Creates a goal that has not begun, for so many robots of a class. It is judged at this interval, s.
    ///
    /// # Errors
    /// When the class has no such laser or gripper, or the map no such victim.
    pub fn new(goal: &Goal, robots: usize, interval: f64, class: &Arc<RobotDef>, map: &MapDef) -> Result<Self, String> {
        Ok(Self(match goal.clone() {
            Goal::Reach(goal) => Played::Reach(reach::Reach::new(goal, robots, interval)),
            Goal::Follow(goal) => Played::Follow(follow::Follow::new(goal, robots, interval)),
            Goal::Push(goal) => Played::Push(push::Push::new(goal)),
            Goal::Fetch(goal) => Played::Fetch(Box::new(fetch::Fetch::new(goal, class)?)),
            Goal::Explore(goal) => Played::Explore(explore::Explore::new(goal, class)?),
            Goal::Find(goal) => {
                let victim = find::Find::victim(&goal, map)?;
                Played::Find(find::Find::new(victim, goal.radius, robots, map))
            }
            Goal::Zone(goal) => Played::Zone(zone::Zone::new(goal, robots)),
        }))
    }

    /// Creates the goal to find the victim with a number on the map, from nearer than a radius, m. Names need not differ.
    pub fn of_victim(victim: usize, radius: f64, robots: usize, map: &MapDef) -> Self {
        Self(Played::Find(find::Find::new(victim, radius, robots, map)))
    }

    fn rules(&self) -> &dyn Rules {
        match &self.0 {
            Played::Reach(goal) => goal,
            Played::Follow(goal) => goal,
            Played::Push(goal) => goal,
            Played::Fetch(goal) => &**goal,
            Played::Explore(goal) => goal,
            Played::Find(goal) => goal,
            Played::Zone(goal) => goal,
        }
    }

    fn rules_mut(&mut self) -> &mut dyn Rules {
        match &mut self.0 {
            Played::Reach(goal) => goal,
            Played::Follow(goal) => goal,
            Played::Push(goal) => goal,
            Played::Fetch(goal) => &mut **goal,
            Played::Explore(goal) => goal,
            Played::Find(goal) => goal,
            Played::Zone(goal) => goal,
        }
    }

    /// Returns the number of observations of a robot.
    pub fn width(&self) -> usize {
        self.rules().width()
    }

    /// Begins, with the robots where they are.
    pub fn begin(&mut self, sight: &Sight, rng: &mut ChaCha8Rng) {
        self.rules_mut().begin(sight, rng);
    }

    /// Pushes the observations of a robot.
    pub fn observe(&self, sight: &Sight, robot: usize, push: &mut dyn FnMut(f64)) {
        self.rules().observe(sight, robot, push);
    }

    /// Judges an interval.
    pub fn judge(&mut self, world: &mut World, sight: &Sight) -> Verdict {
        self.rules_mut().judge(world, sight)
    }
}
