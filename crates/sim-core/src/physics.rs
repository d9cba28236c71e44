//! Rigid bodies and contacts: the only place that names rapier3d.

mod articulated;
mod bodies;
mod compile;
mod contact;
mod convert;
mod conveyor;
mod effort;
mod fault;
mod identity;
mod mechanism;
mod mesh;
mod motor;
mod objects;
mod observe;
mod packet;
mod placing;
mod pull;
mod query;
mod ray;
mod robot;
mod roller;
mod rolling;
mod shape;
mod surface;

use std::sync::Arc;

use rapier3d::prelude::*;

pub(crate) use compile::{CompiledMap, CompiledRobot, Held};
pub use effort::SolverEffort;
pub use fault::Fault;
pub(crate) use identity::Identity;
pub(crate) use objects::{Lifted, extents};
pub(crate) use placing::Placement;
pub(crate) use pull::{Spring, Tug};
pub(crate) use query::{Light, Sight};
pub(crate) use robot::{RobotBodies, SavedBodies};
pub(crate) use surface::Materials;

pub(crate) use articulated::SavedObject;

use articulated::MovableObject;
use bodies::Landing;
use conveyor::Conveyor;
use scene::{ObjectId, RfidTag};

use crate::site::Site;

/// Distance from a change over which sleeping objects wake, m.
const WAKING_REACH: f64 = 0.01;

/// The bodies of the world and the engine that moves them.
pub(crate) struct Physics {
    world: PhysicsWorld,
    materials: Materials,
    /// Movable objects, by their ids.
    objects: Vec<MovableObject>,
    /// Parts of the map that sensors perceive beside shapes.
    site: Arc<Site>,
    /// RFID tags, those of the map first.
    pub(crate) tags: Vec<RfidTag>,
    conveyors: Vec<Conveyor>,
    /// Number of robots that the engine moves.
    robots_of_engine: usize,
    /// True if a robot came or left since the engine's last step, so the engine has to step to notice.
    is_changed: bool,
    landing: Landing,
    /// Effort of all steps.
    effort: SolverEffort,
    /// Multiplications of the last step's systems of several bodies.
    work: u64,
    /// Disabled colliders that occupy the slots of removed ones until the next step.
    placeholders: Vec<ColliderHandle>,
}

impl Clone for Physics {
    /// Copies the state; the engine's pipelines begin empty.
    fn clone(&self) -> Self {
        let Self {
            world,
            materials,
            objects,
            site,
            tags,
            conveyors,
            robots_of_engine,
            is_changed,
            landing,
            effort,
            work,
            placeholders,
        } = self;
        Self {
            world: engine_copy(world),
            materials: materials.clone(),
            objects: objects.clone(),
            site: site.clone(),
            tags: tags.clone(),
            conveyors: conveyors.clone(),
            robots_of_engine: *robots_of_engine,
            is_changed: *is_changed,
            landing: landing.clone(),
            effort: *effort,
            work: *work,
            placeholders: placeholders.clone(),
        }
    }
}

/// Copies the engine's state. Its pipelines are scratch buffers, which its own snapshots leave out, too.
fn engine_copy(world: &PhysicsWorld) -> PhysicsWorld {
    PhysicsWorld {
        gravity: world.gravity,
        integration_parameters: world.integration_parameters,
        physics_pipeline: PhysicsPipeline::new(),
        collision_pipeline: CollisionPipeline::new(),
        islands: world.islands.clone(),
        broad_phase: world.broad_phase.clone(),
        narrow_phase: world.narrow_phase.clone(),
        bodies: world.bodies.clone(),
        colliders: world.colliders.clone(),
        impulse_joints: world.impulse_joints.clone(),
        multibody_joints: world.multibody_joints.clone(),
        soft_bodies: world.soft_bodies.clone(),
        ccd_solver: world.ccd_solver.clone(),
    }
}

impl Physics {
    /// Meets the materials of classes that were compiled lately.
    pub(crate) fn update_materials(&mut self) {
        self.materials.update();
    }

    /// Builds the bodies of a map, without robots.
    pub(crate) fn new(map: &CompiledMap, materials: Materials, time_step: f64) -> Self {
        let mut world = PhysicsWorld::new();
        world.narrow_phase.set_query_dispatcher(contact::RollerDispatcher);
        world.gravity = Vector::new(0.0, 0.0, map.gravity);
        bodies::set_parameters(&mut world.integration_parameters, time_step);
        let ground = world.insert_body(RigidBodyBuilder::fixed());
        let solids = (0..).zip(&map.solids);
        let solids: Vec<ColliderHandle> = solids
            .map(|(index, solid)| world.insert_collider(solid.collider(Identity::Solid(index)), Some(ground)))
            .collect();
        let mut objects = Vec::new();
        for (number, object) in (0..).zip(&map.objects) {
            let pose = object.def.solid.pose();
            objects.push(MovableObject::spawn(&mut world, object, ObjectId(number), &pose, true));
        }
        // The colliders enter the query structure with the first step. It moves nothing, as the engine has no robots yet.
        world.step();
        Self {
            world,
            materials,
            objects,
            site: map.site.clone(),
            tags: map.tags.clone(),
            conveyors: Conveyor::all(&map.conveyors, &solids),
            robots_of_engine: 0,
            is_changed: false,
            landing: Landing::default(),
            effort: SolverEffort::default(),
            work: 0,
            placeholders: Vec::new(),
        }
    }

    /// Returns the parts of the map that sensors perceive beside shapes.
    pub(crate) fn site(&self) -> &Site {
        &self.site
    }

    /// Returns the gravity of the map, m/s².
    pub(crate) fn gravity(&self) -> nalgebra::Vector3<f64> {
        convert::from_vector(self.world.gravity)
    }

    /// True if the engine has a robot to move or a change to notice.
    pub(crate) fn is_engine_needed(&self) -> bool {
        self.robots_of_engine > 0 || self.is_changed
    }

    /// Advances the engine's bodies by one time step.
    pub(crate) fn step(&mut self) {
        self.is_changed = false;
        self.landing.set_sweeps(&mut self.world.integration_parameters);
        // Backwards, so that the slots are reused in the order they would have had without placeholders.
        for placeholder in self.placeholders.drain(..).rev() {
            self.world.remove_collider(placeholder);
        }
        self.world.step();
    }

    /// Returns the effort of the solver of robots over all steps.
    pub(crate) fn effort(&self) -> SolverEffort {
        self.effort
    }

    /// Returns the multiplications that systems of several bodies took in the last step, roughly.
    pub(crate) fn work(&self) -> u64 {
        self.work
    }

    /// Mixes the state of every body into a digest, in order of creation.
    pub(crate) fn digest(&self, mut mix: impl FnMut(f64)) {
        let numbers = self.world.bodies.iter().filter(|(_, body)| !body.is_kinematic()).flat_map(|(_, body)| {
            let (position, velocity) = (body.position(), body.vels());
            let vectors = [position.translation, velocity.linvel, velocity.angvel].map(|vector| vector.to_array());
            vectors.into_iter().flatten().chain(position.rotation.to_array())
        });
        numbers.for_each(&mut mix);
        self.objects.iter().flat_map(MovableObject::numbers).for_each(&mut mix);
        self.conveyor_factors().for_each(mix);
    }
}
