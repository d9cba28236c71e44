//! Robots of a world: how they come, leave, are moved and read.

use std::sync::Arc;

use rapier3d::prelude::*;
use scene::{BodyState, JointState, Pose, Steering, WheelState};

use super::articulated::{self, Surroundings};
use super::compile::CompiledRobot;
use super::mechanism::Mechanism;
use super::{Fault, Physics};
use crate::RobotId;
use crate::flight::Flight;
use crate::threads::Threads;

/// Position of placeholders, m: no ray comes there.
const FAR_AWAY: Vector = Vector::new(1e6, 1e6, 1e6);

/// A robot as the physics has it.
pub(crate) struct RobotBodies {
    robot: Arc<CompiledRobot>,
    mechanism: Mechanism,
    /// Its flight, if it flies.
    flight: Option<Flight>,
}

impl RobotBodies {
    /// Its compiled class.
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

    /// Sets the target of the servo of a joint by its number among those that have a value: rad or m within its limits, or
    /// rad/s or m/s, as its motor is a servo of.
    pub(crate) fn set_joint_target(&mut self, joint: usize, target: f64) {
        self.mechanism.set_joint_target(joint, target);
    }

    /// Sets the flight of a robot in the air.
    pub(crate) fn set_flight(&mut self, flight: Option<Flight>) {
        self.flight = flight;
    }
}

impl Physics {
    /// Puts a robot at a pose of its frame, at rest.
    pub(crate) fn spawn(&mut self, robot: Arc<CompiledRobot>, id: RobotId, pose: &Pose) -> RobotBodies {
        let mechanism = Mechanism::insert(&mut self.world, &robot.mechanism, id, pose);
        self.is_changed = true;
        self.robots_of_engine += usize::from(mechanism.is_of_engine());
        self.enter_queries(&mechanism.bodies());
        let flight = (robot.def.steering == Steering::Aerial).then(Flight::default);
        RobotBodies { robot, mechanism, flight }
    }

    /// Colliders enter the engine's tree with its next step only. Rays and the next robot that is spawned have to meet them
    /// at once, however many are spawned between two steps.
    fn enter_queries(&mut self, bodies: &[RigidBodyHandle]) {
        let PhysicsWorld { broad_phase, integration_parameters, colliders, bodies: engine, .. } = &mut self.world;
        for body in bodies.iter().filter_map(|&body| engine.get(body)) {
            for &handle in body.colliders() {
                if let Some(collider) = colliders.get(handle) {
                    broad_phase.set_aabb(integration_parameters, handle, collider.compute_aabb());
                }
            }
        }
    }

    /// Takes a robot out of the world.
    ///
    /// The engine forgets what a removed collider was near to only if no other one has taken its place by the next step;
    /// otherwise it keeps that for ever. So something that touches nothing takes the places until then.
    pub(crate) fn remove(&mut self, robot: &RobotBodies) {
        self.is_changed = true;
        self.robots_of_engine -= usize::from(robot.mechanism.is_of_engine());
        let mut places = 0;
        for body in robot.mechanism.bodies().into_iter().rev() {
            places += self.world.remove_body_with_colliders(body, true).map_or(0, |body| body.colliders().len());
        }
        for _ in 0..places {
            let placeholder = ColliderBuilder::ball(0.001).translation(FAR_AWAY).enabled(false);
            self.placeholders.push(self.world.insert_collider(placeholder, None));
        }
    }

    /// Applies motors, wheels and flight of a robot that the engine moves to the coming step.
    pub(crate) fn before_step(&mut self, robot: &mut RobotBodies) {
        let flight = robot.flight.as_ref();
        robot.mechanism.apply(&mut self.world, &self.materials, flight, &mut self.landing);
    }

    /// Advances the robots in reduced coordinates by one step; those that touch each other are one system.
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
            robots_of_engine,
            is_changed,
            ref mut rooms,
            ..
        } = self;
        let surroundings = Surroundings { materials, robots_of_engine, is_changed, threads };
        let cost = articulated::solve(world, surroundings, robots.collect(), objects, rooms);
        self.unsettled += cost.unsettled;
        self.work = cost.work;
    }

    /// Tells the engine the poses of the robots in reduced coordinates at the end of its coming step.
    pub(crate) fn lead_engine<'a>(&mut self, robots: impl Iterator<Item = &'a RobotBodies>) {
        self.objects.iter().for_each(|object| object.lead_engine(&mut self.world));
        let robots = robots.filter_map(|robot| robot.mechanism.articulated());
        robots.for_each(|robot| robot.lead_engine(&mut self.world));
    }

    /// Moves the engine's shapes of the robots in reduced coordinates to where they are, for rays and for the search for room.
    pub(crate) fn enter_shapes<'a>(&mut self, robots: impl Iterator<Item = &'a RobotBodies>) {
        self.objects.iter_mut().for_each(|object| object.enter_queries(&mut self.world));
        let robots = robots.filter_map(|robot| robot.mechanism.articulated());
        robots.for_each(|robot| robot.enter_queries(&mut self.world));
    }

    /// Pose and generalised velocity of a robot in reduced coordinates as numbers; the engine's are its bodies'.
    pub(crate) fn numbers(&self, robot: &RobotBodies) -> Vec<f64> {
        robot.mechanism.numbers()
    }

    /// Every joint that has a value, in the order of the links.
    pub(crate) fn joints(&self, robot: &RobotBodies) -> Vec<JointState> {
        robot.mechanism.joints(&self.world).into_iter().map(|(_, state)| state).collect()
    }

    /// The driven wheels, in order.
    pub(crate) fn wheels(&self, robot: &RobotBodies) -> Vec<WheelState> {
        let wheels = robot.mechanism.joints(&self.world).into_iter().filter(|(is_wheel, _)| *is_wheel);
        wheels.map(|(_, JointState { position, speed })| WheelState { angle: position, speed }).collect()
    }

    /// The fault of a robot's state, if it has one.
    pub(crate) fn fault(&self, robot: &RobotBodies) -> Option<Fault> {
        robot.mechanism.fault(&self.world)
    }

    /// Pose and velocity of the robot frame.
    pub(crate) fn body(&self, robot: &RobotBodies) -> BodyState {
        robot.mechanism.state(&self.world)
    }

    /// The robot frame as it moves with a link by its number in the definition, when every joint was at 0. `None` of the body,
    /// whose own it is.
    pub(crate) fn carrier(&self, robot: &RobotBodies, link: usize) -> Option<BodyState> {
        let origin = robot.robot.def.links.get(link).filter(|_| link > 0)?.origin();
        robot.mechanism.carrier(&self.world, link, origin.into())
    }
}
