//! Rigid bodies and contacts: the only place that names rapier3d.

mod aerial;
mod articulated;
mod compile;
mod contact;
mod convert;
mod fault;
mod identity;
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

use rapier3d::geometry::ContactData;
use rapier3d::prelude::*;

pub(crate) use compile::{CompiledMap, CompiledRobot};
pub use fault::Fault;
pub(crate) use identity::Identity;
pub(crate) use placing::Placement;
pub(crate) use query::Sight;
pub(crate) use robot::RobotBodies;
pub(crate) use surface::Materials;

use articulated::MapObject;
use scene::{BodyState, Pose, WheelState};

/// Sweeps of the solver over the contacts while a robot lands. One is enough where the last step's impulses are a good
/// guess. In an impact it gives the whole momentum to the wheel that comes first, and friction takes hold of what
/// follows from that: a robot that falls flat from 1 m then turns by up to 0.1 rad.
const LANDING_SWEEPS: usize = 20;
/// How long a robot lands after its fall, s: until the overlap of the impact is pushed out.
const LANDING_TIME: f64 = 0.1;

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
    /// Time left of the landing of a robot, s; `LANDING_TIME` while one falls.
    landing: f64,
    /// Where systems of robots in reduced coordinates are solved.
    rooms: Vec<articulated::Room>,
    /// How many of them did not settle.
    unsettled: u64,
    /// What stands until the next step in the places of colliders that were removed.
    placeholders: Vec<ColliderHandle>,
}

impl Physics {
    /// What is on a map, and no robot yet.
    pub(crate) fn new(map: &CompiledMap, materials: Arc<Materials>, time_step: f64) -> Self {
        let mut world = PhysicsWorld::new();
        world.narrow_phase.set_query_dispatcher(contact::RollerDispatcher);
        world.gravity = Vector::new(0.0, 0.0, map.gravity);
        let parameters = &mut world.integration_parameters;
        parameters.dt = time_step;
        // One iteration with friction solved together with the penetration is what makes free rollers roll
        // right; without it four iterations are slower and worse. Recycled contacts lag behind a turning roller.
        parameters.num_solver_iterations = 1;
        parameters.friction_in_bias_pass = true;
        parameters.friction_model = FrictionModel::Coulomb;
        parameters.contact_recycling = false;
        // Contacts that are about to happen, from here on: more of them only cost time, a robot moves 2 mm in a step
        // at 1 m/s.
        parameters.normalized_prediction_distance = 0.002;
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
            landing: 0.0,
            rooms: Vec::new(),
            unsettled: 0,
            placeholders: Vec::new(),
        }
    }

    /// Whether the engine has anything to move, or to notice.
    pub(crate) fn is_engine_needed(&self) -> bool {
        self.robots_of_engine > 0 || self.is_changed || self.objects.iter().any(MapObject::is_moved_by_engine)
    }

    /// Advances by one time step what the engine moves.
    pub(crate) fn step(&mut self) {
        self.is_changed = false;
        let sweeps = if self.landing > 0.0 { LANDING_SWEEPS } else { 1 };
        let parameters = &mut self.world.integration_parameters;
        // With the velocity that pushes out overlaps, and without it.
        parameters.num_internal_pgs_iterations = sweeps;
        parameters.num_internal_stabilization_iterations = sweeps;
        self.landing -= parameters.dt;
        // Backwards, so that their places are taken again in the order in which they would have been.
        for placeholder in self.placeholders.drain(..).rev() {
            self.world.remove_collider(placeholder);
        }
        self.world.step();
        self.objects.iter_mut().for_each(|object| object.note_rest(&self.world));
    }

    /// How many systems of robots were solved in which not every contact came to do what it should.
    pub(crate) fn unsettled_steps(&self) -> u64 {
        self.unsettled
    }

    /// Where the map's objects are, in its order.
    pub(crate) fn objects(&self) -> impl Iterator<Item = Pose> {
        self.objects.iter().map(|object| object.pose(&self.world))
    }

    /// Puts every object whose state is a fault back where the map has it, at rest. Returns their numbers with the faults.
    pub(crate) fn restore_objects(&mut self) -> Vec<(usize, Fault)> {
        let Self { objects, world, .. } = self;
        let faulty = objects.iter_mut().enumerate();
        faulty.filter_map(|(number, object)| Some((number, object.restore(world)?))).collect()
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

/// The contacts of a manifold that the last step solved for. The engine chooses four of its points at most; the others
/// keep the impulses that they had when they were last chosen, which its own sums count in.
fn solved(manifold: &ContactManifold) -> impl Iterator<Item = &ContactData> {
    let chosen = |index: usize| {
        let mut contacts = manifold.data.solver_contacts.iter();
        contacts.any(|contact| contact.contact_indices()[0] as usize == index)
    };
    manifold.points.iter().enumerate().filter(move |(index, _)| chosen(*index)).map(|(_, point)| &point.data)
}
