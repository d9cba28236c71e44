//! Search for contacts of robots in reduced coordinates.

use articulated::{Body, Contact};
use nalgebra::{DMatrix, Vector3};
use rapier3d::math::{Matrix, Pose as EnginePose};
use rapier3d::parry::bounding_volume::{Aabb, BoundingVolume};
use rapier3d::parry::query::{ShapeCastOptions, cast_shapes};
use rapier3d::prelude::*;
use scene::Material;

use super::super::convert;
use super::super::fault::Fault;
use super::super::identity::BodyId;
use super::super::surface::Materials;
use super::ArticulatedRobot;
use super::form::{Form, Surface};
use super::link_pose;
use super::shape_contact::{Target, touches};
use super::step_input::StepInput;
use super::wheel::Touch;

/// Distance over which contacts are found, beyond the distance that a surface moves in a step, m.
const PREDICTION: f64 = 0.001;
/// Largest distance over which contacts are found, m. A surface that moves farther in a step is swept.
pub(super) const MAX_PREDICTION: f64 = 0.1;
/// Margin around a robot in which fixed colliders are cached, m. The search repeats when the robot leaves it.
const NEAR: f64 = 0.1;
/// Gap beyond which a roller leaves its surface to a nearer one, at the end of the step with the present velocity, m.
pub(super) const MARGIN: f64 = 1e-6;
/// Most contacts of two bodies, and of a body with everything fixed. The deepest are kept.
const MAX_CONTACTS: [usize; 2] = [32, 128];
/// Distance within which a contact of the same key is that of the last step, m.
const SAME_CONTACT: f64 = 0.02;
/// Cosine above which two normals belong to one surface.
const SAME_SURFACE: f64 = 0.99;

/// Key that recognises a contact in the next step: the robot's surface, the other surface or collider, and the contact's number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(super) struct Key {
    pub(super) surface: usize,
    pub(super) other: (Peer, usize),
    pub(super) number: usize,
}

/// A contact of the last step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Known {
    pub(super) key: Key,
    /// Impulse on the first surface, N s.
    pub(super) impulse: Vector3<f64>,
    /// Contact point, m.
    pub(super) point: Vector3<f64>,
    /// Time since it came, s.
    pub(super) age: f64,
}

/// The owner of the other surface of a contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(super) enum Peer {
    Fixed,
    Itself,
    Body(BodyId),
    OfEngine,
}

/// A contact of a robot's surface. Of a track on a fixed shape, first a corner of an area of contact.
#[derive(Clone)]
pub(super) struct CandidateContact {
    pub(super) key: Key,
    pub(super) counterpart: Counterpart,
    pub(super) touch: Touch,
    /// Impulse of the last step there, N s.
    pub(super) start: Vector3<f64>,
    /// Time since it came, s.
    pub(super) age: f64,
    /// Velocity of the other surface at the contact, m/s, if it is that of a conveyor or of a held body.
    pub(super) drift: Vector3<f64>,
    /// Coefficients of the pair: friction, restitution and rolling resistance.
    pub(super) friction: f64,
    pub(super) restitution: f64,
    pub(super) resistance: f64,
    /// Largest speed at which an overlap is pushed out, m/s.
    pub(super) recovery: f64,
}

/// The other side of a contact.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Counterpart {
    /// A fixed body.
    Fixed,
    /// Another surface of the same robot, by its number.
    Itself(usize),
    /// A robot or object, by its number, and its surface.
    Robot(usize, usize),
    /// A robot of the engine, by its number among those touched, and its link.
    OfEngine(usize, usize),
}

/// A robot of the engine in contact with robots in reduced coordinates.
pub(super) struct OfEngine {
    pub(super) links: Vec<RigidBodyHandle>,
    pub(super) body: Body,
    /// Impulses on it: link, point and impulse.
    pub(super) reactions: Vec<(usize, Vector3<f64>, Vector3<f64>)>,
}

/// A surface at its current pose.
#[derive(Clone)]
pub(super) struct Placed {
    pub(super) pose: EnginePose,
    pub(super) around: Aabb,
    /// Distance over which contacts are found, m: the most that its points move in a step, and a margin.
    pub(super) prediction: f64,
    /// Motion of its centre in a step, m.
    motion: Vector3<f64>,
}

impl Key {
    /// Returns the id of the other robot or object, if it is in reduced coordinates.
    pub(super) fn body(&self) -> Option<BodyId> {
        if let Peer::Body(id) = self.other.0 { Some(id) } else { None }
    }
}

impl CandidateContact {
    /// True if both are of the same materials and at the same speed.
    pub(super) fn is_alike(&self, other: &Self) -> bool {
        let pair = |it: &Self| (it.counterpart, it.friction, it.restitution, it.resistance, it.drift);
        pair(self) == pair(other)
    }
}

impl ArticulatedRobot {
    /// Updates the bounds of the surfaces, the contacts with fixed bodies and the fault.
    pub(super) fn look_around(&mut self, world: &PhysicsWorld, input: StepInput, time_step: f64) {
        self.bounds.is_known = true;
        let is_finite = self.body.is_finite();
        self.bounds.fault = if is_finite { Fault::of(&self.state()) } else { Some(Fault::NotFinite) };
        self.found.clear();
        if self.bounds.fault.is_none() {
            self.place_surfaces(time_step);
            self.touch_fixed(world, input);
            self.touch_itself();
        }
    }

    /// Drops the cached neighbours, as a robot came or left.
    pub(super) fn forget_near(&mut self) {
        self.near = None;
        self.bounds.is_known = false;
    }

    fn place_surfaces(&mut self, time_step: f64) {
        let Self { body, compiled, placed, .. } = self;
        let (frames, centre) = (body.frames(), body.centre());
        placed.clear();
        placed.extend(compiled.surfaces.iter().map(|surface| {
            let frame = &frames[surface.link];
            let pose = convert::pose(&link_pose(body, surface.link)) * surface.pose;
            let arm = frame.rotation * surface.middle;
            // A wheel's own turning does not move its outline.
            let (velocity, speed) = if matches!(surface.form, Form::Solid | Form::Track(_)) {
                let velocity = frame.linear + frame.angular.cross(&arm);
                (velocity, velocity.norm() + frame.angular.norm() * surface.half.norm())
            } else {
                (frame.linear, frame.linear.norm())
            };
            let (prediction, motion) = (PREDICTION + speed * time_step, velocity * time_step);
            let reach = frame.rotation.abs() * surface.half + Vector3::repeat(prediction.min(MAX_PREDICTION));
            let middle = centre + frame.origin + arm;
            let mut around = Aabb::from_half_extents(convert::vector(middle), convert::vector(reach));
            if prediction > MAX_PREDICTION {
                around.merge(&around.translated(convert::vector(motion)));
            }
            Placed { pose, around, prediction, motion }
        }));
        self.bounds.around = placed.iter().map(|placed| placed.around).reduce(|one, other| one.merged(&other));
    }

    /// Returns a box around all surfaces, or `None` without surfaces.
    pub(super) fn around(&self) -> Option<Aabb> {
        self.bounds.around
    }

    fn touch_fixed(&mut self, world: &PhysicsWorld, input: StepInput) {
        let mut found = std::mem::take(&mut self.found);
        if let Some(whole) = self.bounds.around {
            let near = match self.near.take() {
                Some((around, near)) if around.contains(&whole) => (around, near),
                _ => {
                    let around = whole.loosened(NEAR);
                    let query = world.query_pipeline_with_filter(QueryFilter::only_fixed());
                    let mut near: Vec<ColliderHandle> =
                        query.intersect_aabb_conservative(around).map(|(handle, _)| handle).collect();
                    near.sort_by_key(|handle| handle.into_raw_parts());
                    (around, near)
                }
            };
            for &handle in &near.1 {
                if let Some(collider) = world.colliders.get(handle) {
                    let material = input.materials.of(collider);
                    let other =
                        Other { collider, material, peer: Peer::Fixed, handle, counterpart: Counterpart::Fixed };
                    let before = found.len();
                    self.touch_collider(&other, &mut found);
                    if let Some(conveyor) = input.conveyors.iter().find(|it| it.collider == handle) {
                        found[before..].iter_mut().for_each(|it| it.drift = conveyor.drift(&it.touch.normal));
                    }
                }
            }
            self.near = Some(near);
            self.join_treads(&mut found);
            self.join_areas(&mut found);
            keep_deepest(&mut found, MAX_CONTACTS[1], |it| it.touch.gap);
        }
        self.found = found;
    }

    fn touch_itself(&mut self) {
        if self.compiled.touching_itself.is_empty() {
            return;
        }
        let mut found = std::mem::take(&mut self.found);
        let (before, mut met) = (found.len(), Vec::new());
        for &(one, other) in &self.compiled.touching_itself {
            let (at, its_at) = (&self.placed[one], &self.placed[other]);
            if !at.around.intersects(&its_at.around) {
                continue;
            }
            let (surface, its) = (&self.compiled.surfaces[one], &self.compiled.surfaces[other]);
            let (prediction, motion) = (at.prediction + its_at.prediction, at.motion - its_at.motion);
            let target = Target { shape: its.shape.as_ref(), pose: &its_at.pose, is_fixed: false };
            self.meet(surface, at, &target, prediction, motion, &mut met);
            let key = Key { surface: one, other: (Peer::Itself, other), number: 0 };
            let pair = Pair::of(surface, its);
            add(&mut met, key, Counterpart::Itself(other), &pair, &mut found);
        }
        let mut own = found.split_off(before);
        keep_deepest(&mut own, MAX_CONTACTS[0], |it| it.touch.gap);
        found.append(&mut own);
        self.found = found;
    }

    fn touch_collider(&self, other: &Other, found: &mut Vec<CandidateContact>) {
        let shape = other.collider.shape();
        let is_fixed = other.counterpart == Counterpart::Fixed;
        let target = Target { shape, pose: other.collider.position(), is_fixed };
        let bounds = shape.as_halfspace().is_none().then(|| other.collider.compute_aabb());
        let mut met = Vec::with_capacity(4);
        for (index, (surface, at)) in self.compiled.surfaces.iter().zip(&self.placed).enumerate() {
            if bounds.is_some_and(|bounds| !bounds.intersects(&at.around)) {
                continue;
            }
            self.meet(surface, at, &target, at.prediction, at.motion, &mut met);
            if met.is_empty() {
                continue;
            }
            let key = Key { surface: index, other: (other.peer, other.handle.into_raw_parts().0 as usize), number: 0 };
            add(&mut met, key, other.counterpart, &Pair::with(surface, other.material), found);
        }
    }

    /// Adds the contacts of a surface with another. `motion` is its motion towards the other in the step, m. A surface that moves far is swept.
    fn meet(
        &self,
        surface: &Surface,
        at: &Placed,
        target: &Target,
        prediction: f64,
        motion: Vector3<f64>,
        met: &mut Vec<Touch>,
    ) {
        self.meet_at(surface, &at.pose, target, prediction.min(MAX_PREDICTION), met);
        if prediction <= MAX_PREDICTION || !met.is_empty() {
            return;
        }
        let &Target { shape, pose, .. } = target;
        let options = ShapeCastOptions { max_time_of_impact: 1.0, ..Default::default() };
        let way = convert::vector(motion);
        let hit = cast_shapes(&at.pose, way, surface.shape.as_ref(), pose, Vector::ZERO, shape, options);
        if let Ok(Some(hit)) = hit {
            let way = way * hit.time_of_impact;
            let there = EnginePose::from_parts(at.pose.translation + way, at.pose.rotation);
            self.meet_at(surface, &there, target, MAX_PREDICTION, met);
            let way = convert::from_vector(way);
            for touch in met {
                touch.gap -= touch.normal.dot(&way);
                touch.point -= way;
            }
        }
    }

    /// Adds the contacts of a surface at a pose with another.
    fn meet_at(&self, surface: &Surface, at: &EnginePose, target: &Target, prediction: f64, met: &mut Vec<Touch>) {
        let &Target { shape, pose, .. } = target;
        let ring = match surface.form {
            Form::Rollers(ring) => ring,
            Form::Track(track) => return self.compiled.tracks[track].touch(surface, at, target, prediction, met),
            Form::Solid | Form::Wheel { .. } | Form::Ball { .. } => {
                return touches(surface, at, target, prediction, met);
            }
        };
        let ring = &self.compiled.rings[ring];
        let hub = convert::from_pose(at);
        ring.shape.touch(&hub, self.turned(ring), prediction, shape, pose, met);
    }

    /// Drops the contacts of rollers that leave the load to the next roller. Two rollers share the load only while both press. The wheel's
    /// turning brings no roller nearer: the next one lands where the last leaves, on the same circle.
    pub(super) fn hand_over(&mut self, time_step: f64) {
        let Self { found, compiled, body, .. } = self;
        let leaves = |it: &CandidateContact| {
            let nearer = |peer: &CandidateContact| {
                peer.key.surface == it.key.surface
                    && peer.touch.gap < it.touch.gap
                    && peer.touch.normal.dot(&it.touch.normal) > SAME_SURFACE
            };
            if it.touch.roller.is_none() || !found.iter().any(nearer) {
                return false;
            }
            let wheel = compiled.surfaces[it.key.surface].link;
            let carrier = body.tree().links()[wheel].parent;
            let approach = it.touch.normal.dot(&body.velocity_at(carrier, it.touch.point));
            it.touch.gap + approach * time_step > MARGIN
        };
        if !found.iter().any(leaves) {
            return;
        }
        let leaves: Vec<bool> = found.iter().map(leaves).collect();
        let mut leaves = leaves.into_iter();
        found.retain(|_| !leaves.next().unwrap_or(false));
    }
}

/// Contacts of the last step as starts of this one.
impl ArticulatedRobot {
    /// Stores the contacts of a step, in the order in which they were found.
    pub(super) fn remember(&mut self, found: &[CandidateContact], contacts: &[Contact], time_step: f64) {
        let known = found.iter().zip(contacts);
        self.known.extend(known.map(|(it, &Contact { impulse, point, .. })| {
            let age = it.age + time_step;
            Known { key: it.key, impulse, point, age }
        }));
    }

    /// Gives each contact the impulse that it had in the last step. In a system of several bodies tangents remember it, so nothing is
    /// lost: the impulse of a contact that went, or that is another one under the same key, goes to the nearest contact with the same body.
    pub(super) fn recall(&self, found: &mut [CandidateContact], is_alone: bool) {
        if is_alone {
            for it in found.iter_mut() {
                let own = self.known.iter().find(|known| known.key == it.key);
                (it.start, it.age) = own.map_or_else(Default::default, |known| (known.impulse, known.age));
            }
            return;
        }
        for (place, Known { key, impulse, point, age }) in self.known.iter().enumerate() {
            let away = |it: &CandidateContact| (it.touch.point - point).norm_squared();
            let is_same = |it: &CandidateContact| it.key == *key && away(it) < SAME_CONTACT * SAME_CONTACT;
            // Most contacts stay, in the same order.
            let heir = if found.get(place).is_some_and(is_same) {
                found.get_mut(place)
            } else {
                let with_it = found.iter_mut().filter(|it| it.key.other.0 == key.other.0);
                with_it.min_by(|one, other| away(one).total_cmp(&away(other)))
            };
            if let Some(it) = heir {
                it.start += impulse;
                it.age = it.age.max(*age);
            }
        }
    }
}

/// Adds the contacts of a robot with robots of the engine. Returns the numbers of the latter.
pub(super) fn touch_engine(
    world: &PhysicsWorld,
    materials: &Materials,
    robot: &mut ArticulatedRobot,
    bodies: &mut Vec<OfEngine>,
) -> Vec<usize> {
    let mut touched = Vec::new();
    let Some(whole) = robot.around() else { return touched };
    let mut found = std::mem::take(&mut robot.found);
    let filter = QueryFilter::exclude_fixed().exclude_sensors();
    let query = world.query_pipeline_with_filter(filter);
    for (handle, collider) in query.intersect_aabb_conservative(whole) {
        let Some(parent) = collider.parent() else { continue };
        if !world.bodies.get(parent).is_some_and(RigidBody::is_dynamic) {
            continue;
        }
        let known = |bodies: &[OfEngine]| {
            bodies
                .iter()
                .enumerate()
                .find_map(|(index, it)| Some((index, it.links.iter().position(|&link| link == parent)?)))
        };
        if known(bodies).is_none() {
            bodies.extend(OfEngine::new(world, parent));
        }
        let Some((index, link)) = known(bodies) else { continue };
        let counterpart = Counterpart::OfEngine(index, link);
        let other = Other { collider, material: materials.of(collider), peer: Peer::OfEngine, handle, counterpart };
        let before = found.len();
        robot.touch_collider(&other, &mut found);
        if found.len() > before && !touched.contains(&index) {
            touched.push(index);
        }
    }
    robot.found = found;
    touched
}

/// Keeps at most `most` contacts, those with the smallest gaps.
fn keep_deepest<T>(found: &mut Vec<T>, most: usize, gap: impl Fn(&T) -> f64) {
    if found.len() > most {
        found.sort_by(|one, other| gap(one).total_cmp(&gap(other)));
        found.truncate(most);
    }
}

/// A collider of the engine.
struct Other<'a> {
    collider: &'a Collider,
    material: &'a Material,
    peer: Peer,
    handle: ColliderHandle,
    counterpart: Counterpart,
}

/// Adds the contacts of two bodies, given by number, each with the body whose surface finds it. That body is never a sleeping one.
pub(super) fn touch_each_other(
    robots: &[&mut ArticulatedRobot],
    (one, other): (usize, usize),
    is_asleep: &[bool],
    found: &mut Vec<(usize, CandidateContact)>,
) {
    let (mut met, mut added) = (Vec::new(), Vec::new());
    for (own_index, own_at) in robots[one].placed.iter().enumerate() {
        for (its_index, its_at) in robots[other].placed.iter().enumerate() {
            if !own_at.around.intersects(&its_at.around) {
                continue;
            }
            // Wheels and balls have a geometry of their own, so their surfaces come first. Objects, which may sleep, have no such surfaces.
            let rank = |robot: usize, index: usize| robots[robot].compiled.surfaces[index].form.rank();
            let is_first = rank(one, own_index) >= rank(other, its_index) && !is_asleep[one];
            let ((first, index, at), (second, its_index, its_at)) = if is_first {
                ((one, own_index, own_at), (other, its_index, its_at))
            } else {
                ((other, its_index, its_at), (one, own_index, own_at))
            };
            let (robot, surface) = (&*robots[first], &robots[first].compiled.surfaces[index]);
            let its = &robots[second].compiled.surfaces[its_index];
            let prediction = at.prediction + its_at.prediction;
            if prediction <= MAX_PREDICTION && are_apart((surface, at), (its, its_at), prediction) {
                continue;
            }
            let motion = at.motion - its_at.motion;
            let target = Target { shape: its.shape.as_ref(), pose: &its_at.pose, is_fixed: false };
            robot.meet(surface, at, &target, prediction, motion, &mut met);
            let key = Key { surface: index, other: (Peer::Body(robots[second].id), its_index), number: 0 };
            let pair = Pair::of(surface, its);
            add(&mut met, key, Counterpart::Robot(second, its_index), &pair, &mut added);
            if is_asleep[second] {
                let drift = |it: &mut CandidateContact| it.drift = robots[second].body.velocity_at(0, it.touch.point);
                added.iter_mut().for_each(drift);
            }
            found.extend(added.drain(..).map(|it| (first, it)));
        }
    }
    keep_deepest(found, MAX_CONTACTS[0], |(_, it)| it.touch.gap);
}

/// True if the bounding boxes of two surfaces, each in its own axes, are farther apart than a distance along one of these axes, m.
fn are_apart((one, at): (&Surface, &Placed), (other, its_at): (&Surface, &Placed), distance: f64) -> bool {
    let between = its_at.pose.inv_mul(&at.pose);
    let turn = Matrix::from_quat(between.rotation);
    let reach = Matrix::from_cols(turn.x_axis.abs(), turn.y_axis.abs(), turn.z_axis.abs());
    let (half, its_half) = (one.around.half_extents(), other.around.half_extents());
    let way = between * one.around.center() - other.around.center();
    let along = |way: Vector, half: Vector, its_half: Vector| (way.abs() - half - its_half).max_element() > distance;
    along(way, reach * half, its_half) || along(turn.transpose() * way, half, reach.transpose() * its_half)
}

impl Form {
    /// Returns the precedence of a form. In a pair the surface of the higher rank finds the contacts.
    fn rank(self) -> u32 {
        match self {
            Self::Solid => 0,
            Self::Ball { .. } => 1,
            Self::Wheel { .. } => 2,
            Self::Track(_) => 3,
            Self::Rollers(_) => 4,
        }
    }
}

/// Coefficients of a pair of surfaces.
struct Pair {
    friction: f64,
    restitution: f64,
    resistance: f64,
    recovery: f64,
}

impl Pair {
    fn of(one: &Surface, other: &Surface) -> Self {
        let pair = Self::with(one, &other.material);
        Self { recovery: pair.recovery.min(other.recovery()), ..pair }
    }

    /// Returns the coefficients of a surface with a material.
    fn with(surface: &Surface, other: &Material) -> Self {
        let (friction, restitution) = surface.material.pair(other);
        let resistance = surface.material.pair_rolling_resistance(other);
        Self { friction, restitution, resistance, recovery: surface.recovery() }
    }
}

/// Turns the contacts found for a pair into `CandidateContact` entries. Their keys differ from `key` in the contact's number.
fn add(met: &mut Vec<Touch>, key: Key, counterpart: Counterpart, pair: &Pair, found: &mut Vec<CandidateContact>) {
    let &Pair { friction, restitution, resistance, recovery } = pair;
    found.extend(met.drain(..).enumerate().map(|(number, touch)| CandidateContact {
        key: Key { number, ..key },
        counterpart,
        touch,
        start: Vector3::zeros(),
        age: 0.0,
        drift: Vector3::zeros(),
        friction,
        restitution,
        resistance,
        recovery,
    }));
}

impl OfEngine {
    /// Builds the body of a robot of the engine as its contacts see it in the coming step. `None` before the robot's first step.
    fn new(world: &PhysicsWorld, handle: RigidBodyHandle) -> Option<Self> {
        let index = world.multibody_joints.rigid_body_link(handle)?.multibody;
        let multibody = world.multibody_joints.get_multibody(index)?;
        let mass = multibody.inv_augmented_mass();
        let (count, bodies) = (multibody.ndofs(), multibody.links().map(MultibodyLink::rigid_body_handle));
        let links: Vec<RigidBodyHandle> = bodies.collect();
        let is_ready = |link: usize| multibody.body_jacobian(link).ncols() == count;
        if mass.lu_internal().nrows() != count || !(0..links.len()).all(is_ready) {
            return None;
        }
        let inertia = mass.try_inverse()?.try_inverse()?;
        let inertia = DMatrix::from_fn(count, count, |row, column| inertia[(row, column)]);
        let centre = convert::from_vector(world.bodies.get(links[0])?.center_of_mass());
        let twists = links.iter().enumerate().map(|(link, &body)| {
            let jacobian = multibody.body_jacobian(link);
            let arm =
                centre - world.bodies.get(body).map_or(centre, |body| convert::from_vector(body.center_of_mass()));
            let column = |dof: usize| {
                let part = |first: usize| Vector3::from_fn(|row, _| jacobian[(first + row, dof)]);
                [part(3), part(0) + part(3).cross(&arm)]
            };
            (0..count).map(column).collect::<Vec<[Vector3<f64>; 2]>>()
        });
        let twists: Vec<Vec<[Vector3<f64>; 2]>> = twists.collect();
        let mut velocity: Vec<f64> = multibody.generalized_velocity().iter().copied().collect();
        // A free robot falls. One on the ground is held by its own contacts, which the engine solves later.
        let fall = convert::from_vector(world.gravity) * world.integration_parameters.dt;
        let is_free = multibody.root().joint().ndofs() == 6;
        velocity.iter_mut().zip(&fall).filter(|_| is_free).for_each(|(speed, fall)| *speed += fall);
        Some(Self { links, body: Body::given(centre, &velocity, &inertia, twists), reactions: Vec::new() })
    }
}
