//! Movable objects: free bodies, solved with the robots that touch them. An object at rest falls asleep.
//!
//! A sleeping object is not part of a system: to its neighbours it is a fixed body. It wakes when their push differs from that in the step
//! in which it fell asleep. A held object never wakes: it stays, or moves as it is led.

use std::sync::Arc;

use articulated::{Joint, Link, Mass, Tree};
use nalgebra::{Point3, Vector3};
use rapier3d::parry::bounding_volume::{Aabb, BoundingVolume};
use rapier3d::prelude::*;
use scene::{BodyState, Object, ObjectId, ObjectSnapshot, Pose};

use super::super::WAKING_REACH;
use super::super::convert;
use super::super::fault::Fault;
use super::super::identity::{BodyId, Identity};
use super::super::pull::{Grasped, Tug};
use super::super::surface::Surface as ColliderSurface;
use super::ArticulatedRobot;
use super::compile::{Articulated, CompiledObject};
use super::form::{Form, Surface};

/// Speed of the fastest point below which an object is at rest, m/s.
const REST_SPEED: f64 = 1e-3;
/// Time at rest after which an object sleeps, s.
const REST_TIME: f64 = 0.1;
/// Change of the impulse on a sleeping object that wakes it, as a share of its weight's impulse in a step.
const WAKING_SHARE: f64 = 0.05;
/// Least change that wakes an object if there is no gravity, as a velocity, m/s.
const WAKING_SPEED: f64 = 1e-5;

/// A movable object in a world.
#[derive(Clone)]
pub(in super::super) struct MovableObject {
    pub(super) id: ObjectId,
    pub(in super::super) def: Arc<Object>,
    /// True if the map has it.
    pub(in super::super) is_of_map: bool,
    /// True if nothing pushes it: it stays, or moves as it is led.
    pub(super) is_held: bool,
    /// Pose at which it was spawned.
    pub(in super::super) start: Pose,
    pub(super) body: Box<ArticulatedRobot>,
    /// Time at rest, s.
    pub(super) still: f64,
    /// True if robots hold a part of its weight, themselves or by other objects: then it does not fall asleep.
    pub(super) is_carried: bool,
    /// State of the sleep, `None` if awake.
    pub(super) sleep: Option<Sleep>,
    /// True if the engine's shape is at the pose at which the object sleeps.
    pub(super) is_entered: bool,
}

/// The state of a sleeping object.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub(super) struct Sleep {
    /// Neighbours, with their impulses on the object in the step in which it fell asleep, N s.
    neighbours: Vec<(BodyId, Vector3<f64>)>,
}

impl Articulated {
    /// Compiles a rigid free body.
    pub(in super::super) fn of_object(seen: ColliderSurface, mass: f64, material: &scene::Material) -> Self {
        let own = uniform(&seen.placed().0, mass);
        let [linear_damping, damping] = material.damping(mass, &own.inertia);
        let root = Link::new(0, Joint::Free, Vector3::zeros(), own);
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
            tracks: Vec::new(),
            following: None,
            touching_itself: Vec::new(),
        }
    }
}

/// Returns the mass of a shape with uniform density, in the shape's frame.
pub(in super::super) fn uniform(shape: &SharedShape, mass: f64) -> Mass {
    let mut properties = shape.mass_properties(1.0);
    properties.set_mass(mass, true);
    let inertia = properties.reconstruct_inertia_matrix().to_cols_array_2d().into();
    Mass { mass, centre: convert::from_vector(properties.local_com), inertia }
}

impl MovableObject {
    /// Spawns an object at a pose.
    pub(in super::super) fn spawn(
        world: &mut PhysicsWorld,
        object: &CompiledObject,
        id: ObjectId,
        pose: &Pose,
        is_of_map: bool,
    ) -> Self {
        let body = RigidBodyBuilder::kinematic_position_based().pose(convert::pose(pose));
        let in_engine = world.insert_body(body);
        let surface = object.surface.collider(Identity::Object(id)).solver_groups(InteractionGroups::none());
        let collider = world.insert_collider(surface, Some(in_engine));
        let in_engine = vec![(in_engine, vec![(collider, 0)])];
        let body = ArticulatedRobot::at_rest(object.compiled.clone(), BodyId::Object(id), pose, in_engine);
        let (def, body) = (object.def.clone(), Box::new(body));
        Self {
            id,
            def,
            is_of_map,
            is_held: false,
            start: *pose,
            body,
            still: 0.0,
            is_carried: false,
            sleep: None,
            is_entered: false,
        }
    }

    pub(in super::super) fn id(&self) -> ObjectId {
        self.id
    }

    pub(in super::super) fn name(&self) -> &str {
        &self.def.solid.name
    }

    /// Returns the engine's body.
    pub(in super::super) fn in_engine(&self) -> Option<RigidBodyHandle> {
        self.body.bodies().next()
    }

    /// Returns a snapshot.
    pub(in super::super) fn snapshot(&self) -> ObjectSnapshot {
        ObjectSnapshot { id: self.id, def: self.def.clone(), pose: self.pose() }
    }

    /// Holds the object, so that nothing pushes it, or lets it go. The engine's robots feel a held object as a body of the engine.
    pub(in super::super) fn hold(&mut self, world: &mut PhysicsWorld, is_held: bool) {
        self.is_held = is_held;
        self.stop();
        let groups = if is_held { InteractionGroups::all() } else { InteractionGroups::none() };
        for &(handle, _) in self.body.in_engine.iter().flat_map(|(_, colliders)| colliders) {
            if let Some(collider) = world.colliders.get_mut(handle) {
                collider.set_solver_groups(groups);
            }
        }
    }

    pub(in super::super) fn is_held(&self) -> bool {
        self.is_held
    }

    /// Puts the object at a pose, at rest and awake.
    pub(in super::super) fn put(&mut self, pose: &Pose) {
        self.body.return_to(pose);
        self.wake();
    }

    /// Sets the velocity with which a held object reaches a pose at the end of the coming step.
    pub(in super::super) fn lead(&mut self, pose: &Pose, time_step: f64) {
        let now = self.pose();
        let turn = (pose.rotation * now.rotation.inverse()).scaled_axis() / time_step;
        // The generalised velocity is that of the centre of mass.
        let centre = Point3::from(self.body.compiled.tree.links()[0].mass.centre);
        let way = (pose * centre - now * centre) / time_step;
        let velocity = self.body.body.velocity_mut();
        velocity[..3].copy_from_slice(turn.as_slice());
        velocity[3..6].copy_from_slice(way.as_slice());
        self.body.body.place();
        self.body.bounds.is_known = false;
        self.is_entered = false;
    }

    /// Moves a led object to a pose, with the velocity that it was led with.
    pub(in super::super) fn arrive(&mut self, pose: &Pose) {
        self.body.body.set_pose(*pose);
        self.body.bounds.is_known = false;
    }

    /// Applies the effect of a spring for the coming step, and keeps the object awake.
    pub(in super::super) fn pull(&mut self, tug: &Tug) {
        if self.sleep.is_some() {
            self.wake();
        }
        self.still = 0.0;
        self.body.pull(tug);
    }

    /// Returns what a spring pulls; `None` for a held object, which feels nothing.
    pub(in super::super) fn grasped(&self) -> Option<Grasped> {
        (!self.is_held).then(|| self.body.grasped())
    }

    /// Sets the velocity of the frame's origin, m/s, and the angular velocity, rad/s, in world axes.
    pub(in super::super) fn push_off(&mut self, linear: &Vector3<f64>, angular: &Vector3<f64>) {
        // The generalised velocity is that of the centre of mass.
        let lever = self.pose().rotation * self.body.compiled.tree.links()[0].mass.centre;
        let velocity = self.body.body.velocity_mut();
        velocity[..3].copy_from_slice(angular.as_slice());
        velocity[3..6].copy_from_slice((linear + angular.cross(&lever)).as_slice());
        self.body.body.place();
    }

    /// Sets the velocity to zero.
    fn stop(&mut self) {
        self.body.body.velocity_mut().fill(0.0);
        self.body.body.place();
        self.wake();
    }

    /// Returns a box around the object and what it may carry.
    pub(in super::super) fn reach(&self) -> Aabb {
        self.bounds().loosened(WAKING_REACH)
    }

    /// True if a box meets the object. The bounds of a sleeping one are known from the last search for contacts.
    pub(in super::super) fn is_near(&self, near: &Aabb) -> bool {
        self.body.around().unwrap_or_else(|| self.bounds()).intersects(near)
    }

    /// Returns a box around the object.
    pub(in super::super) fn bounds(&self) -> Aabb {
        let pose = convert::pose(&self.pose());
        let boxes = self.body.compiled.surfaces.iter().map(|it| it.shape.compute_aabb(&(pose * it.pose)));
        boxes.reduce(|one, other| one.merged(&other)).unwrap_or_else(Aabb::new_invalid)
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
        if !self.is_entered {
            self.body.lead_engine(world);
        }
    }

    /// Moves the engine's shape to the object's pose.
    pub(in super::super) fn enter_queries(&mut self, world: &mut PhysicsWorld) {
        if !self.is_entered {
            self.body.enter_queries(world);
            self.is_entered = self.is_asleep();
        }
    }

    /// Puts an object whose state is a fault back to its first pose, at rest. Returns the fault.
    pub(in super::super) fn restore(&mut self) -> Option<Fault> {
        if self.is_asleep() {
            return None;
        }
        let fault = self.body.fault()?;
        self.body.return_to(&self.start);
        self.wake();
        Some(fault)
    }

    /// True if the object needs the impulses on it in this step: it sleeps or may fall asleep.
    pub(super) fn is_listening(&self, time_step: f64) -> bool {
        !self.is_held && (self.sleep.is_some() || self.still + time_step > REST_TIME)
    }

    /// True if it is no part of a system: it sleeps, or it is held.
    pub(in super::super) fn is_asleep(&self) -> bool {
        self.is_held || self.sleep.is_some()
    }

    pub(in super::super) fn wake(&mut self) {
        (self.still, self.is_carried, self.sleep, self.is_entered) = (0.0, false, None, false);
        self.body.forget_near();
    }

    /// Updates the time at rest after a step, and lets the object fall asleep, unless it is carried. `neighbours` are the impulses on it, N s;
    /// `carries` returns true for a robot, and for an object that is carried itself.
    pub(super) fn note_rest(
        &mut self,
        neighbours: Vec<(BodyId, Vector3<f64>)>,
        carries: impl Fn(BodyId) -> bool,
        gravity: &Vector3<f64>,
        time_step: f64,
    ) {
        // To sleep and to wake again would shake it in a grip: a body that sleeps is a fixed one to its neighbours, and stiffer.
        let given: Vector3<f64> = neighbours.iter().filter(|(by, _)| carries(*by)).map(|(_, impulse)| impulse).sum();
        let weight = gravity * (self.body.compiled.mass * time_step);
        self.is_carried = -given.dot(&weight) > WAKING_SHARE * weight.norm_squared();
        let BodyState { linear, angular, .. } = self.body.state();
        let surface = &self.body.compiled.surfaces[0];
        let speed = linear.norm() + angular.norm() * (surface.middle.norm() + surface.half.norm());
        self.still = if speed < REST_SPEED { self.still + time_step } else { 0.0 };
        if self.still > REST_TIME && !self.is_carried {
            self.body.body.velocity_mut().fill(0.0);
            self.body.body.place();
            self.sleep = Some(Sleep { neighbours });
        }
    }

    /// True if awake neighbours push the object differently than when it fell asleep. `impulses` are theirs in this step, N s.
    pub(super) fn is_disturbed(
        &self,
        impulses: &[(BodyId, Vector3<f64>)],
        is_asleep: impl Fn(BodyId) -> bool,
        gravity: f64,
        time_step: f64,
    ) -> bool {
        let Some(Sleep { neighbours }) = &self.sleep else { return false };
        let awake = neighbours.iter().filter(|(id, _)| !is_asleep(*id));
        let before: Vector3<f64> = awake.map(|(_, impulse)| impulse).sum();
        let now: Vector3<f64> = impulses.iter().map(|(_, impulse)| impulse).sum();
        let least = (WAKING_SHARE * gravity * time_step).max(WAKING_SPEED);
        (now - before).norm() > least * self.body.compiled.mass
    }
}
