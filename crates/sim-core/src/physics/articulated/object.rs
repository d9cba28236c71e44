//! Objects of the map: the engine's as long as no robot in reduced coordinates is near, and otherwise solved with the robots.

use std::sync::Arc;

use articulated::{Joint, Link, Mass, Tree};
use nalgebra::Vector3;
use rapier3d::math::Pose as EnginePose;
use rapier3d::parry::bounding_volume::{Aabb, BoundingVolume};
use rapier3d::prelude::*;
use scene::{BodyState, Pose};

use super::super::convert;
use super::super::fault::Fault;
use super::super::identity::Identity;
use super::super::surface::Surface as Seen;
use super::ArticulatedRobot;
use super::compile::{Articulated, CompiledObject, Form, Surface};
use crate::RobotId;

/// An object as near as this to a robot, or to another that is, is solved with it, m.
const NEAR: f64 = 0.05;
/// One that is, until it is farther away than this, m.
const FAR: f64 = 0.1;
/// One of the engine's that moves slower than this, m/s and rad/s, for so many steps rests.
const RESTING: (f64, u32) = (1e-4, 200);

/// An object of the map in a world.
pub(in super::super) struct MapObject {
    in_engine: RigidBodyHandle,
    /// Pose in the map.
    start: EnginePose,
    collider: ColliderHandle,
    made_of: Arc<Articulated>,
    /// Where robots are near.
    pub(super) taken: Option<Box<ArticulatedRobot>>,
    /// Steps that it has hardly moved in.
    still: u32,
}

impl Articulated {
    /// Something rigid that is free.
    pub(in super::super) fn of_object(seen: Seen, mass: f64, material: &scene::Material) -> Self {
        let (shape, _) = seen.placed();
        let mut properties = shape.mass_properties(1.0);
        properties.set_mass(mass, true);
        let inertia = properties.reconstruct_inertia_matrix().to_cols_array_2d().into();
        let centre = convert::from_vector(properties.local_com);
        let root = Link::new(0, Joint::Free, Vector3::zeros(), Mass { mass, centre, inertia });
        let damping = material.angular_damping * (inertia.trace() / 3.0);
        let tree = Tree::new(vec![Link { damping, linear_damping: material.linear_damping * mass, ..root }]);
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
    /// Puts an object of a number where the map has it.
    pub(in super::super) fn spawn(world: &mut PhysicsWorld, object: &CompiledObject, number: u32) -> Self {
        let in_engine = world.insert_body(object.body.clone());
        let collider = world.insert_collider(object.surface.collider(Identity::Object(number)), Some(in_engine));
        let start = *world.bodies[in_engine].position();
        Self { in_engine, start, collider, made_of: object.made_of.clone(), taken: None, still: 0 }
    }

    /// Where it is.
    pub(in super::super) fn pose(&self, world: &PhysicsWorld) -> Pose {
        let taken = self.taken.as_ref().map(|taken| *taken.body.pose());
        taken.unwrap_or_else(|| convert::from_pose(world.bodies[self.in_engine].position()))
    }

    /// It as the robots near it see it.
    pub(in super::super) fn taken(&self) -> Option<&ArticulatedRobot> {
        self.taken.as_deref()
    }

    /// Its state, where robots are near.
    pub(in super::super) fn numbers(&self) -> Vec<f64> {
        self.taken.as_ref().map_or_else(Vec::new, |taken| taken.numbers())
    }

    /// Whether the engine has to move it.
    pub(in super::super) fn is_moved_by_engine(&self) -> bool {
        self.taken.is_none() && self.still < RESTING.1
    }

    /// Looks whether it rests; after a step of the engine.
    pub(in super::super) fn note_rest(&mut self, world: &PhysicsWorld) {
        let body = &world.bodies[self.in_engine];
        let moves = body.linvel().length().max(body.angvel().length()) > RESTING.0;
        self.still = if moves || self.taken.is_some() { 0 } else { self.still.saturating_add(1) };
    }

    /// Puts an object whose state is a fault back where the map has it, at rest. Returns the fault.
    pub(in super::super) fn restore(&mut self, world: &mut PhysicsWorld) -> Option<Fault> {
        let fault = match &self.taken {
            Some(taken) => taken.fault(),
            None => self.fault_in_engine(world),
        }?;
        self.give_back(world);
        let (body, collider) = (world.bodies.get_mut(self.in_engine)?, world.colliders.get_mut(self.collider)?);
        body.set_enabled(true);
        collider.set_enabled(true);
        body.set_position(self.start, true);
        body.set_linvel(Vector::ZERO, true);
        body.set_angvel(Vector::ZERO, true);
        Some(fault)
    }

    fn fault_in_engine(&self, world: &PhysicsWorld) -> Option<Fault> {
        let (body, collider) = (world.bodies.get(self.in_engine)?, world.colliders.get(self.collider)?);
        // The engine disables what is not finite.
        if !body.is_enabled() || !collider.is_enabled() {
            return Some(Fault::NotFinite);
        }
        let (linear, angular) = (convert::from_vector(body.linvel()), convert::from_vector(body.angvel()));
        Fault::of(&BodyState { pose: convert::from_pose(body.position()), linear, angular })
    }

    fn around(&self, world: &PhysicsWorld) -> Aabb {
        match &self.taken {
            Some(taken) => {
                let surface = &self.made_of.surfaces[0];
                surface.shape.compute_aabb(&(convert::pose(taken.body.pose()) * surface.pose))
            }
            None => world.colliders[self.collider].compute_aabb(),
        }
    }

    fn take(&mut self, world: &mut PhysicsWorld, number: usize) {
        let pose = self.pose(world);
        let Some(body) = world.bodies.get_mut(self.in_engine) else { return };
        let (linear, angular) = (convert::from_vector(body.linvel()), convert::from_vector(body.angvel()));
        body.set_body_type(RigidBodyType::KinematicPositionBased, false);
        // What the engine moves is solved with it, too.
        if let Some(collider) = world.colliders.get_mut(self.collider) {
            collider.set_solver_groups(InteractionGroups::none());
        }
        let in_engine = vec![(self.in_engine, vec![(self.collider, 0)])];
        let mut taken =
            ArticulatedRobot::at_rest(self.made_of.clone(), RobotId(u64::MAX - number as u64), &pose, in_engine);
        taken.body.velocity_mut()[..3].copy_from_slice(angular.as_slice());
        taken.body.velocity_mut()[3..6].copy_from_slice(linear.as_slice());
        taken.body.place();
        self.taken = Some(Box::new(taken));
    }

    fn give_back(&mut self, world: &mut PhysicsWorld) {
        let Some(taken) = self.taken.take() else { return };
        let Some(body) = world.bodies.get_mut(self.in_engine) else { return };
        let (angular, linear) = taken.body.velocity().split_at(3);
        body.set_body_type(RigidBodyType::Dynamic, true);
        if let Some(collider) = world.colliders.get_mut(self.collider) {
            collider.set_solver_groups(InteractionGroups::all());
        }
        body.set_position(convert::pose(taken.body.pose()), true);
        body.set_angvel(Vector::new(angular[0], angular[1], angular[2]), true);
        body.set_linvel(Vector::new(linear[0], linear[1], linear[2]), true);
        self.still = 0;
    }
}

/// Takes the objects that are near robots, or near such objects, and gives back those that are not any more.
pub(super) fn take_near(world: &mut PhysicsWorld, objects: &mut [MapObject], robots: &[Aabb]) {
    let around: Vec<Aabb> = objects.iter().map(|object| object.around(world)).collect();
    let mut movers: Vec<Aabb> = robots.to_vec();
    let mut is_near = vec![false; objects.len()];
    let mut next = 0;
    while next < movers.len() {
        for (number, object) in objects.iter().enumerate() {
            let reach = if object.taken.is_some() { FAR } else { NEAR };
            if !is_near[number] && around[number].loosened(reach).intersects(&movers[next]) {
                is_near[number] = true;
                movers.push(around[number]);
            }
        }
        next += 1;
    }
    for (number, object) in objects.iter_mut().enumerate() {
        match (is_near[number], object.taken.is_some()) {
            (true, false) => object.take(world, number),
            (false, true) => object.give_back(world),
            _ => {}
        }
    }
}
