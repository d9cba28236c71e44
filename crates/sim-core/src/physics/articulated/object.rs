//! The map's objects: free bodies, solved with the robots that touch them. An object at rest falls asleep.
//!
//! A sleeping object is not part of a system: to its neighbours it is a fixed body. It wakes when their push differs from that in the step
//! in which it fell asleep.

use std::sync::Arc;

use articulated::{Joint, Link, Mass, Tree};
use nalgebra::Vector3;
use rapier3d::prelude::*;
use scene::{BodyState, Pose};

use super::super::convert;
use super::super::fault::Fault;
use super::super::identity::Identity;
use super::super::surface::Surface as Seen;
use super::ArticulatedRobot;
use super::compile::{Articulated, CompiledObject, Form, Surface};
use crate::PawnId;

/// Speed of the fastest point below which an object is at rest, m/s.
const REST_SPEED: f64 = 1e-3;
/// Time at rest after which an object sleeps, s.
const REST_TIME: f64 = 0.1;
/// Change of the impulse on a sleeping object that wakes it, as a share of its weight's impulse in a step.
const WAKING_SHARE: f64 = 0.05;
/// Bound on the number of objects. It separates their ids, which count down, from robots' ids.
const MAX_OBJECTS: usize = 1 << 32;
/// Least change that wakes an object if there is no gravity, as a velocity, m/s.
const WAKING_SPEED: f64 = 1e-5;

/// An object of the map in a world.
#[derive(Clone)]
pub(in super::super) struct MapObject {
    /// Pose in the map.
    start: Pose,
    pub(super) body: Box<ArticulatedRobot>,
    /// Time at rest, s.
    pub(super) still: f64,
    /// State of the sleep, `None` if awake.
    pub(super) sleep: Option<Sleep>,
    /// True if the engine's shape is at the pose at which the object sleeps.
    pub(super) is_entered: bool,
}

/// The state of a sleeping object.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub(super) struct Sleep {
    /// Neighbours, with their impulses on the object in the step in which it fell asleep, N s.
    neighbours: Vec<(PawnId, Vector3<f64>)>,
}

impl Articulated {
    /// Compiles a rigid free body.
    pub(in super::super) fn of_object(seen: Seen, mass: f64, material: &scene::Material) -> Self {
        let (shape, _) = seen.placed();
        let mut properties = shape.mass_properties(1.0);
        properties.set_mass(mass, true);
        let inertia = properties.reconstruct_inertia_matrix().to_cols_array_2d().into();
        let centre = convert::from_vector(properties.local_com);
        let root = Link::new(0, Joint::Free, Vector3::zeros(), Mass { mass, centre, inertia });
        let [linear_damping, damping] = material.damping(mass, &inertia);
        let tree = Tree::new(vec![Link { damping, linear_damping, ..root }]);
        let surface = Surface::new(0, Form::Solid, material, seen, None);
        Self {
            tree: Arc::new(tree),
            mass,
            places: vec![(0, Vector3::zeros())],
            surfaces: vec![surface],
            joints: Vec::new(),
            gears: Vec::new(),
            wheels: Vec::new(),
            rings: Vec::new(),
            following: None,
        }
    }
}

impl MapObject {
    /// Spawns an object at its pose in the map. `number` is its number there.
    pub(in super::super) fn spawn(world: &mut PhysicsWorld, object: &CompiledObject, number: u32) -> Self {
        let body = RigidBodyBuilder::kinematic_position_based().pose(convert::pose(&object.pose));
        let in_engine = world.insert_body(body);
        let surface = object.surface.collider(Identity::Object(number)).solver_groups(InteractionGroups::none());
        let collider = world.insert_collider(surface, Some(in_engine));
        // Objects count down from the largest id, robots up from 0.
        let id = PawnId(u64::MAX - u64::from(number));
        let in_engine = vec![(in_engine, vec![(collider, 0)])];
        let body = ArticulatedRobot::at_rest(object.made_of.clone(), id, &object.pose, in_engine);
        Self { start: object.pose, body: Box::new(body), still: 0.0, sleep: None, is_entered: false }
    }

    /// Returns the pose of the object's frame.
    pub(in super::super) fn pose(&self) -> Pose {
        *self.body.body.pose()
    }

    /// Returns pose and velocity as numbers.
    pub(in super::super) fn numbers(&self) -> Vec<f64> {
        self.body.numbers()
    }

    /// Tells the engine the pose at the end of its coming step.
    pub(in super::super) fn lead_engine(&self, world: &mut PhysicsWorld) {
        if self.sleep.is_none() {
            self.body.lead_engine(world);
        }
    }

    /// Moves the engine's shape to the object's pose.
    pub(in super::super) fn enter_queries(&mut self, world: &mut PhysicsWorld) {
        if !self.is_entered {
            self.body.enter_queries(world);
            self.is_entered = self.sleep.is_some();
        }
    }

    /// Puts an object whose state is a fault back to its pose in the map, at rest. Returns the fault.
    pub(in super::super) fn restore(&mut self) -> Option<Fault> {
        if self.sleep.is_some() {
            return None;
        }
        let fault = self.body.fault()?;
        self.body.return_to(&self.start);
        self.wake();
        Some(fault)
    }

    /// Returns the number of the object with an id, or `None` for a robot's id.
    pub(super) fn number_of(id: PawnId) -> Option<usize> {
        usize::try_from(u64::MAX - id.0).ok().filter(|&number| number < MAX_OBJECTS)
    }

    /// True if the object needs the impulses on it in this step: it sleeps or may fall asleep.
    pub(super) fn is_listening(&self, time_step: f64) -> bool {
        self.sleep.is_some() || self.still + time_step > REST_TIME
    }

    pub(super) fn is_asleep(&self) -> bool {
        self.sleep.is_some()
    }

    pub(super) fn wake(&mut self) {
        (self.still, self.sleep, self.is_entered) = (0.0, None, false);
        self.body.forget_near();
    }

    /// Updates the time at rest after a step, and lets the object fall asleep. `neighbours` are the impulses on it, N s.
    pub(super) fn note_rest(&mut self, neighbours: Vec<(PawnId, Vector3<f64>)>, time_step: f64) {
        let BodyState { linear, angular, .. } = self.body.state();
        let surface = &self.body.made_of.surfaces[0];
        let speed = linear.norm() + angular.norm() * (surface.middle.norm() + surface.half.norm());
        self.still = if speed < REST_SPEED { self.still + time_step } else { 0.0 };
        if self.still > REST_TIME {
            self.body.body.velocity_mut().fill(0.0);
            self.body.body.place();
            self.sleep = Some(Sleep { neighbours });
        }
    }

    /// True if awake neighbours push the object differently than when it fell asleep. `impulses` are theirs in this step, N s.
    pub(super) fn is_disturbed(
        &self,
        impulses: &[(PawnId, Vector3<f64>)],
        is_asleep: impl Fn(PawnId) -> bool,
        gravity: f64,
        time_step: f64,
    ) -> bool {
        let Some(Sleep { neighbours }) = &self.sleep else { return false };
        let awake = neighbours.iter().filter(|(id, _)| !is_asleep(*id));
        let before: Vector3<f64> = awake.map(|(_, impulse)| impulse).sum();
        let now: Vector3<f64> = impulses.iter().map(|(_, impulse)| impulse).sum();
        let least = (WAKING_SHARE * gravity * time_step).max(WAKING_SPEED);
        (now - before).norm() > least * self.body.made_of.mass
    }
}
