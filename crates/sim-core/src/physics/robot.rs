//! Robots of a world: spawning, removing, moving and reading them.

use std::sync::Arc;

use rapier3d::prelude::*;
use scene::{BodyState, JointState, Pose, WheelState, check};
use serde::{Deserialize, Serialize};

use super::articulated::{self, SavedTree, StepInput};
use super::compile::{CompiledRobot, Held, with_held};
use super::mechanism::Mechanism;
use super::query::set_box;
use super::{Fault, Physics, Spring, Tug};
use crate::PawnId;
use crate::flight::Flight;
use crate::threads::Threads;

/// Position of placeholders, m, out of reach of rays.
const FAR_AWAY: Vector = Vector::new(1e6, 1e6, 1e6);

/// A robot in the physics.
#[derive(Clone)]
pub(crate) struct RobotBodies {
    robot: Arc<CompiledRobot>,
    mechanism: Mechanism,
    /// Flight command of an aerial robot.
    flight: Option<Flight>,
}

/// The state of a robot in the physics as plain data.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct SavedBodies {
    tree: SavedTree,
    flight: Option<Flight>,
}

impl RobotBodies {
    /// Returns the compiled class.
    pub(crate) fn robot(&self) -> &Arc<CompiledRobot> {
        &self.robot
    }

    pub(super) fn mechanism(&self) -> &Mechanism {
        &self.mechanism
    }

    /// Sets the targets of the wheel servos, rad/s.
    pub(crate) fn set_wheel_speeds(&mut self, speeds: &[f64]) {
        self.mechanism.set_wheel_speeds(speeds);
    }

    /// Sets the target of a joint's servo, by the joint's number among those that have a value. It is rad or m within its limits, or rad/s
    /// or m/s for a speed servo.
    pub(crate) fn set_joint_target(&mut self, joint: usize, target: f64) {
        self.mechanism.set_joint_target(joint, target);
    }

    /// Returns the state. `None` for a robot of the engine, which keeps part of its state to itself.
    pub(crate) fn save(&self) -> Option<SavedBodies> {
        Some(SavedBodies { tree: self.mechanism.articulated()?.save(), flight: self.flight })
    }

    /// Takes a saved state. Returns false, and changes nothing, if the state is another robot's.
    pub(crate) fn load(&mut self, saved: &SavedBodies) -> bool {
        let fits = self.flight.is_some() == saved.flight.is_some()
            && self.mechanism.articulated_mut().is_some_and(|robot| robot.load(&saved.tree));
        if fits {
            self.flight = saved.flight;
        }
        fits
    }

    /// Sets the flight command of an aerial robot.
    pub(crate) fn set_flight(&mut self, flight: Option<Flight>) {
        self.flight = flight;
    }
}

impl Physics {
    /// Puts a robot at a pose of its frame, at rest.
    pub(crate) fn spawn(&mut self, robot: Arc<CompiledRobot>, id: PawnId, pose: &Pose) -> RobotBodies {
        let mechanism = Mechanism::insert(&mut self.world, &robot.mechanism, id, pose);
        self.is_changed = true;
        self.robots_of_engine += usize::from(mechanism.is_of_engine());
        self.enter_queries(&mechanism.bodies());
        let flight = robot.def.footing.aerial().map(|_| Flight::default());
        RobotBodies { robot, mechanism, flight }
    }

    /// Inserts colliders into the query structure. The engine would do it with its next step only. Rays and the next spawn must hit them at
    /// once, however many robots are spawned between two steps.
    pub(super) fn enter_queries(&mut self, bodies: &[RigidBodyHandle]) {
        let PhysicsWorld { broad_phase, integration_parameters, colliders, bodies: engine, .. } = &mut self.world;
        for body in bodies.iter().filter_map(|&body| engine.get(body)) {
            for &handle in body.colliders() {
                if let Some(collider) = colliders.get(handle) {
                    set_box(broad_phase, integration_parameters, handle, collider);
                }
            }
        }
    }

    /// Puts a robot at a pose, at rest. Its joints stay as they are. A robot of the engine is spawned anew.
    pub(crate) fn put_robot(&mut self, robot: &mut RobotBodies, id: PawnId, pose: &Pose) {
        self.is_changed = true;
        if let Some(tree) = robot.mechanism.articulated_mut() {
            return tree.put(pose);
        }
        self.remove(robot);
        *robot = self.spawn(robot.robot.clone(), id, pose);
    }

    /// Applies the effect of a spring to a robot for the coming step. Its motors have been applied before.
    pub(crate) fn pull_robot(&mut self, robot: &mut RobotBodies, tug: &Tug) {
        robot.mechanism.pull(&mut self.world, tug);
    }

    /// Returns the effect of a spring on a robot now.
    pub(crate) fn tug_of_robot(&self, robot: &RobotBodies, spring: &Spring) -> Tug {
        spring.tug(&robot.mechanism.grasped(&self.world), self.world.integration_parameters.dt)
    }

    /// Returns a class with objects fixed to its links. Fails with the reason in words, for example if they are too heavy.
    pub(crate) fn fitted<'a>(
        &mut self,
        class: &Arc<CompiledRobot>,
        held: impl IntoIterator<Item = Held<'a>>,
    ) -> Result<Arc<CompiledRobot>, String> {
        let mut held = held.into_iter().peekable();
        if held.peek().is_none() {
            return Ok(class.clone());
        }
        let fitted = with_held(&class.def, held);
        if let Some(wrong) = check::robot(&fitted).into_iter().next() {
            return Err(format!("the robot cannot carry it: {wrong}"));
        }
        Ok(Arc::new(CompiledRobot::new(fitted, &mut self.materials)))
    }

    /// Replaces a robot's class by one that differs in its tools alone. Its motion stays. Returns false, and changes nothing, for a robot of
    /// the engine.
    pub(crate) fn refit(&mut self, robot: &mut RobotBodies, id: PawnId, class: Arc<CompiledRobot>) -> bool {
        let Some(saved) = robot.save() else { return false };
        self.remove(robot);
        *robot = self.spawn(class, id, &Pose::identity());
        robot.load(&saved)
    }

    /// Removes a robot from the world.
    pub(crate) fn remove(&mut self, robot: &RobotBodies) {
        self.robots_of_engine -= usize::from(robot.mechanism.is_of_engine());
        self.remove_bodies(robot.mechanism.bodies().into_iter().rev());
    }

    /// Removes bodies of the engine with their colliders.
    ///
    /// The engine forgets the neighbours of a removed collider only if its slot is still free at the next step. Otherwise it keeps them for
    /// ever. So disabled colliders occupy the slots until then.
    pub(super) fn remove_bodies(&mut self, bodies: impl Iterator<Item = RigidBodyHandle>) {
        self.is_changed = true;
        let mut places = 0;
        for body in bodies {
            places += self.world.remove_body_with_colliders(body, true).map_or(0, |body| body.colliders().len());
        }
        for _ in 0..places {
            let placeholder = ColliderBuilder::ball(0.001).translation(FAR_AWAY).enabled(false);
            self.placeholders.push(self.world.insert_collider(placeholder, None));
        }
    }

    /// Applies motors, wheels and flight to the coming step, for a robot that the engine moves.
    pub(crate) fn before_step(&mut self, robot: &mut RobotBodies) {
        let flight = robot.flight.as_ref();
        robot.mechanism.apply(&mut self.world, &self.materials, flight, &mut self.landing);
    }

    /// Advances the robots in reduced coordinates by one step. Robots that touch each other are one system.
    pub(crate) fn solve_articulated<'a>(
        &mut self,
        robots: impl Iterator<Item = &'a mut RobotBodies>,
        threads: &dyn Threads,
    ) {
        let robots = robots.filter_map(|robot| Some((robot.mechanism.articulated_mut()?, robot.flight.as_ref())));
        let &mut Self {
            ref mut world,
            ref materials,
            ref mut objects,
            ref conveyors,
            robots_of_engine,
            is_changed,
            ..
        } = self;
        let input = StepInput { materials, conveyors, robots_of_engine, is_changed, threads };
        let effort = articulated::solve(world, input, robots.collect(), objects);
        self.effort += effort;
        self.work = effort.multiplications;
    }

    /// Tells the engine the poses of the robots in reduced coordinates at the end of its coming step.
    pub(crate) fn lead_engine<'a>(&mut self, robots: impl Iterator<Item = &'a RobotBodies>) {
        self.objects.iter().for_each(|object| object.lead_engine(&mut self.world));
        let robots = robots.filter_map(|robot| robot.mechanism.articulated());
        robots.for_each(|robot| robot.lead_engine(&mut self.world));
    }

    /// Moves the engine's shapes of the robots in reduced coordinates to their current poses, for rays and the search for free places.
    pub(crate) fn enter_shapes<'a>(&mut self, robots: impl Iterator<Item = &'a RobotBodies>) {
        self.objects.iter_mut().for_each(|object| object.enter_queries(&mut self.world));
        let robots = robots.filter_map(|robot| robot.mechanism.articulated());
        robots.for_each(|robot| robot.enter_queries(&mut self.world));
    }

    /// Returns pose and generalised velocity of a robot in reduced coordinates as numbers. They are empty for robots of the engine.
    pub(crate) fn numbers(&self, robot: &RobotBodies) -> Vec<f64> {
        robot.mechanism.numbers()
    }

    /// Returns every joint that has a value, in the order of the links.
    pub(crate) fn joints(&self, robot: &RobotBodies) -> Vec<JointState> {
        robot.mechanism.joints(&self.world).into_iter().map(|(_, state)| state).collect()
    }

    /// Returns the driven wheels, in order.
    pub(crate) fn wheels(&self, robot: &RobotBodies) -> Vec<WheelState> {
        let wheels = robot.mechanism.joints(&self.world).into_iter().filter(|(is_wheel, _)| *is_wheel);
        wheels.map(|(_, JointState { position, speed })| WheelState { angle: position, speed }).collect()
    }

    /// Returns the fault of a robot's state, if it has one.
    pub(crate) fn fault(&self, robot: &RobotBodies) -> Option<Fault> {
        robot.mechanism.fault(&self.world)
    }

    /// Returns pose and velocity of the robot frame.
    pub(crate) fn body(&self, robot: &RobotBodies) -> BodyState {
        robot.mechanism.state(&self.world)
    }

    /// Returns the frame that moves with a link, by its number in the definition, and is the robot frame when every joint is at 0. `None`
    /// for the body, which carries the robot frame itself.
    pub(crate) fn carrier(&self, robot: &RobotBodies, link: usize) -> Option<BodyState> {
        let origin = robot.robot.def.links.get(link).filter(|_| link > 0)?.origin();
        robot.mechanism.carrier(&self.world, link, origin.into())
    }
}
