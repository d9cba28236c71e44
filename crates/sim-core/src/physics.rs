//! Rigid bodies and contacts: the only place that names rapier3d.

mod articulated;
mod bodies;
mod compile;
mod contact;
mod convert;
mod fault;
mod identity;
mod mechanism;
mod motor;
mod observe;
mod placing;
mod query;
mod robot;
mod roller;
mod rolling;
mod shape;
mod surface;

use std::sync::Arc;

use rapier3d::prelude::*;

pub(crate) use compile::{CompiledMap, CompiledRobot};
pub use fault::Fault;
pub(crate) use identity::Identity;
pub(crate) use placing::Placement;
pub(crate) use query::Sight;
pub(crate) use robot::RobotBodies;
pub(crate) use surface::Materials;

use articulated::MapObject;
use bodies::Landing;
use scene::Pose;

/// The bodies of the world and the engine that moves them.
pub(crate) struct Physics {
    world: PhysicsWorld,
    materials: Arc<Materials>,
    /// The map's objects, in its order.
    objects: Vec<MapObject>,
    /// How many robots the engine moves.
    robots_of_engine: usize,
    /// Whether something came or left, which the engine notices with a step.
    is_changed: bool,
    landing: Landing,
    /// Where systems of robots in reduced coordinates are solved.
    rooms: Vec<articulated::Room>,
    /// Number of systems that did not settle.
    unsettled: u64,
    /// Multiplications of the last step's systems of several bodies.
    work: u64,
    /// What stands until the next step in the places of colliders that were removed.
    placeholders: Vec<ColliderHandle>,
}

impl Physics {
    /// What is on a map, and no robot yet.
    pub(crate) fn new(map: &CompiledMap, materials: Arc<Materials>, time_step: f64) -> Self {
        let mut world = PhysicsWorld::new();
        world.narrow_phase.set_query_dispatcher(contact::RollerDispatcher);
        world.gravity = Vector::new(0.0, 0.0, map.gravity);
        bodies::set_parameters(&mut world.integration_parameters, time_step);
        let ground = world.insert_body(RigidBodyBuilder::fixed());
        for (index, solid) in (0..).zip(&map.solids) {
            world.insert_collider(solid.collider(Identity::Solid(index)), Some(ground));
        }
        let mut objects = Vec::new();
        for (index, object) in (0..).zip(&map.objects) {
            objects.push(MapObject::spawn(&mut world, object, index));
        }
        // The colliders enter the query structure with the first step; of nothing, it moves nothing.
        world.step();
        Self {
            world,
            materials,
            objects,
            robots_of_engine: 0,
            is_changed: false,
            landing: Landing::default(),
            rooms: Vec::new(),
            unsettled: 0,
            work: 0,
            placeholders: Vec::new(),
        }
    }

    /// Whether the engine has anything to move, or to notice.
    pub(crate) fn is_engine_needed(&self) -> bool {
        self.robots_of_engine > 0 || self.is_changed
    }

    /// Advances by one time step what the engine moves.
    pub(crate) fn step(&mut self) {
        self.is_changed = false;
        self.landing.set_sweeps(&mut self.world.integration_parameters);
        // Backwards, so that their places are taken again in the order in which they would have been.
        for placeholder in self.placeholders.drain(..).rev() {
            self.world.remove_collider(placeholder);
        }
        self.world.step();
    }

    /// How many systems of robots were solved in which not every contact came to do what it should.
    pub(crate) fn unsettled_steps(&self) -> u64 {
        self.unsettled
    }

    /// Multiplications that systems of several bodies took in the last step, roughly.
    pub(crate) fn work(&self) -> u64 {
        self.work
    }

    /// Where the map's objects are, in its order.
    pub(crate) fn objects(&self) -> impl Iterator<Item = Pose> {
        self.objects.iter().map(MapObject::pose)
    }

    /// Puts every object whose state is a fault back where the map has it, at rest. Returns their numbers with the faults.
    pub(crate) fn restore_objects(&mut self) -> Vec<(usize, Fault)> {
        let faulty = self.objects.iter_mut().enumerate();
        faulty.filter_map(|(number, object)| Some((number, object.restore()?))).collect()
    }

    /// Mixes the state of every body into a digest, in the order that they were made.
    pub(crate) fn digest(&self, mut mix: impl FnMut(f64)) {
        let numbers = self.world.bodies.iter().filter(|(_, body)| !body.is_kinematic()).flat_map(|(_, body)| {
            let (position, velocity) = (body.position(), body.vels());
            let vectors = [position.translation, velocity.linvel, velocity.angvel].map(|vector| vector.to_array());
            vectors.into_iter().flatten().chain(position.rotation.to_array())
        });
        numbers.for_each(&mut mix);
        self.objects.iter().flat_map(MapObject::numbers).for_each(mix);
    }
}
