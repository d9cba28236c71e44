//! A tree in motion.

use std::sync::Arc;

use nalgebra::{DMatrix, Matrix3, Point3, Rotation3, Translation3, Unit, UnitQuaternion, Vector3};

use crate::inertia::{Acceleration, Composite};
use crate::{Joint, Link, Mass, Pose, Tree, factor, inertia};

/// A tree, where it is and how it moves.
#[derive(Debug, Clone)]
pub struct Body {
    pub(crate) tree: Arc<Tree>,
    /// Of the root's frame.
    pose: Pose,
    /// Where the root's centre of mass is.
    centre: Vector3<f64>,
    /// Position of the joint of every link that has one value, rad or m.
    positions: Vec<f64>,
    /// Orientation of every link on a ball joint in its parent's frame.
    turns: Vec<UnitQuaternion<f64>>,
    /// Generalised velocity.
    pub(crate) velocity: Vec<f64>,
    pub(crate) frames: Vec<Frame>,
    pub(crate) axes: Vec<Axis>,
    /// m/s².
    pub(crate) gravity: Vector3<f64>,
    /// Servo of every degree of freedom.
    pub(crate) drives: Vec<Drive>,
    /// Generalised force of the coming step beside gravity and servos, N m or N.
    pub(crate) force: Vec<f64>,
    /// Inertia with servos, and then its factors.
    pub(crate) factors: Vec<f64>,
    /// Velocity at the end of the step without contacts.
    pub(crate) free: Vec<f64>,
    /// Room for the links' inertia and acceleration.
    pub(crate) composites: Vec<Composite>,
    pub(crate) accelerations: Vec<Acceleration>,
    /// Of one that something else moves.
    given: Option<Given>,
}

/// How something gives way that something else moves.
#[derive(Debug, Clone)]
struct Given {
    /// As the factors have it.
    inertia: Vec<f64>,
    /// Of every link.
    links: Vec<Vec<Axis>>,
}

/// A link at a moment. Positions are from [`Body::centre`], in world axes.
#[derive(Debug, Clone, Copy)]
pub struct Frame {
    /// World axes from the link's. Of a round link as if it had not turned.
    pub rotation: Matrix3<f64>,
    /// Origin, m.
    pub origin: Vector3<f64>,
    /// Angular velocity, rad/s.
    pub angular: Vector3<f64>,
    /// Velocity of the origin, m/s.
    pub linear: Vector3<f64>,
}

/// What a degree of freedom does at a speed of 1: an angular velocity, and a velocity at the centre.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Axis {
    pub(crate) angular: Vector3<f64>,
    pub(crate) linear: Vector3<f64>,
}

/// A servo as a function of the speed at the end of a step: `at_rest - gain speed`, within a limit. N m or N.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Drive {
    /// At speed 0.
    pub at_rest: f64,
    /// N m s/rad or N s/m.
    pub gain: f64,
    /// Most, either way.
    pub most: f64,
}

impl Axis {
    /// The velocity at a point from the centre.
    pub(crate) fn at(&self, point: Vector3<f64>) -> Vector3<f64> {
        self.linear + self.angular.cross(&point)
    }
}

impl Body {
    /// At rest, every joint at 0.
    pub fn new(tree: Arc<Tree>, pose: Pose) -> Self {
        let (links, dofs) = (tree.links.len(), tree.dof_count());
        let zero = Vector3::zeros();
        let mut body = Self {
            pose,
            centre: zero,
            positions: vec![0.0; links],
            turns: vec![UnitQuaternion::identity(); links],
            velocity: vec![0.0; dofs],
            frames: vec![Frame { rotation: Matrix3::identity(), origin: zero, angular: zero, linear: zero }; links],
            axes: vec![Axis { angular: zero, linear: zero }; dofs],
            gravity: zero,
            drives: vec![Drive::default(); dofs],
            force: vec![0.0; dofs],
            factors: vec![0.0; tree.entries],
            free: vec![0.0; dofs],
            composites: Vec::new(),
            accelerations: Vec::new(),
            given: None,
            tree,
        };
        body.place();
        body
    }

    /// Something that another program moves, as its contacts feel it: its generalised velocity at the end of a step without them, the
    /// inertia that belongs to it, and for every link the twist that each speed gives it about the centre, the angular part first.
    pub fn given(
        centre: Vector3<f64>,
        velocity: &[f64],
        inertia: &DMatrix<f64>,
        links: Vec<Vec<[Vector3<f64>; 2]>>,
    ) -> Self {
        let nothing = Mass { mass: 0.0, centre: Vector3::zeros(), inertia: Matrix3::zeros() };
        let link = |number: usize| {
            let joint = if number == 0 { Joint::Fixed } else { Joint::Prismatic(Vector3::x()) };
            Link::new(number.saturating_sub(1), joint, Vector3::zeros(), nothing)
        };
        let tree = Tree::new((0..=velocity.len()).map(link).collect());
        let mut body = Self::new(Arc::new(tree), Pose::translation(centre.x, centre.y, centre.z));
        body.velocity.copy_from_slice(velocity);
        let axis = |[angular, linear]: [Vector3<f64>; 2]| Axis { angular, linear };
        let links = links.into_iter().map(|twists| twists.into_iter().map(axis).collect()).collect();
        let count = velocity.len();
        let inertia = (0..count).flat_map(|row| (0..=row).map(move |column| inertia[(row, column)])).collect();
        body.given = Some(Given { inertia, links });
        body
    }

    /// The degrees of freedom that move a link, from the root down, by the last of them, and what each does; `None` where nothing does.
    pub(crate) fn axes_of(&self, link: usize) -> Option<(usize, impl Iterator<Item = (usize, &Axis)>)> {
        let tip = if self.given.is_some() { self.velocity.len().checked_sub(1) } else { self.tree.tip(link) }?;
        let own = self.given.as_ref().map(|given| &given.links[link]);
        let axis = move |&dof: &usize| (dof, own.map_or(&self.axes[dof], |own| &own[dof]));
        Some((tip, self.tree.chain(tip).iter().map(axis)))
    }

    /// What it is made of.
    pub fn tree(&self) -> &Tree {
        &self.tree
    }

    /// Pose of the root's frame.
    pub fn pose(&self) -> &Pose {
        &self.pose
    }

    /// Where the root's centre of mass is, m: what the positions of frames are from.
    pub fn centre(&self) -> Vector3<f64> {
        self.centre
    }

    /// The links as they are now.
    pub fn frames(&self) -> &[Frame] {
        &self.frames
    }

    /// Position of the joint of a link, rad or m.
    pub fn position(&self, link: usize) -> f64 {
        self.positions[link]
    }

    /// Generalised velocity.
    pub fn velocity(&self) -> &[f64] {
        &self.velocity
    }

    /// The same, to be set.
    pub fn velocity_mut(&mut self) -> &mut [f64] {
        &mut self.velocity
    }

    /// Velocity of a point of a link in the world, m/s.
    pub fn velocity_at(&self, link: usize, point: Vector3<f64>) -> Vector3<f64> {
        if self.given.is_some() {
            let at = point - self.centre();
            let moved =
                self.axes_of(link).map(|(_, axes)| axes.map(|(dof, axis)| axis.at(at) * self.velocity[dof]).sum());
            return moved.unwrap_or_default();
        }
        let Frame { origin, angular, linear, .. } = &self.frames[link];
        linear + angular.cross(&(point - self.centre() - origin))
    }

    /// Sets what it falls with, m/s²; at first nothing.
    pub fn set_gravity(&mut self, gravity: Vector3<f64>) {
        self.gravity = gravity;
    }

    /// Sets the servo of a degree of freedom for the coming step.
    pub fn set_drive(&mut self, dof: usize, drive: Drive) {
        self.drives[dof] = drive;
    }

    /// Pushes a link at a point in the coming step with a force, N.
    pub fn push(&mut self, link: usize, point: Vector3<f64>, force: Vector3<f64>) {
        let at = point - self.centre();
        let Some(tip) = self.tree.tip(link) else { return };
        for &dof in self.tree.chain(tip) {
            self.force[dof] += self.axes[dof].at(at).dot(&force);
        }
    }

    /// Energy of its motion, J.
    pub fn kinetic_energy(&self) -> f64 {
        let of_link = |(link, frame): (&crate::Link, &Frame)| {
            let velocity = frame.linear + frame.angular.cross(&(frame.rotation * link.mass.centre));
            let turning = frame.rotation.transpose() * frame.angular;
            (link.mass.mass * velocity.norm_squared() + turning.dot(&(link.mass.inertia * turning))) / 2.0
        };
        let rotors = self.tree.dofs.iter().zip(&self.velocity).map(|(dof, speed)| dof.armature * speed * speed / 2.0);
        self.tree.links.iter().zip(&self.frames).map(of_link).sum::<f64>() + rotors.sum::<f64>()
    }

    /// Works out frames and axes from positions and velocities.
    pub fn place(&mut self) {
        self.centre = (self.pose * Point3::from(self.tree.links[0].mass.centre)).coords;
        let Self { tree, pose, positions, turns, velocity, frames, axes, .. } = self;
        for (number, link) in tree.links.iter().enumerate() {
            let (first, _) = tree.dofs_of[number];
            let parent = frames[link.parent];
            let origin = parent.origin + parent.rotation * link.anchor;
            let carried = |origin: &Vector3<f64>| parent.linear + parent.angular.cross(&(origin - parent.origin));
            frames[number] = match link.joint {
                Joint::Free | Joint::Fixed => {
                    let rotation = pose.rotation.to_rotation_matrix().into_inner();
                    let origin = rotation * -link.mass.centre;
                    let mut frame = Frame { rotation, origin, angular: Vector3::zeros(), linear: Vector3::zeros() };
                    if link.joint == Joint::Free {
                        for axis in 0..3 {
                            let unit = Vector3::ith(axis, 1.0);
                            axes[axis] = Axis { angular: unit, linear: Vector3::zeros() };
                            axes[3 + axis] = Axis { angular: Vector3::zeros(), linear: unit };
                        }
                        frame.angular = Vector3::from_column_slice(&velocity[..3]);
                        frame.linear = Vector3::from_column_slice(&velocity[3..6]) + frame.angular.cross(&origin);
                    }
                    frame
                }
                Joint::Revolute(axis) => {
                    let axis = parent.rotation * axis;
                    axes[first] = Axis { angular: axis, linear: origin.cross(&axis) };
                    let rotation = if link.is_round {
                        parent.rotation
                    } else {
                        let turn = Rotation3::from_axis_angle(&Unit::new_unchecked(axis), positions[number]);
                        turn.into_inner() * parent.rotation
                    };
                    let angular = parent.angular + axis * velocity[first];
                    Frame { rotation, origin, angular, linear: carried(&origin) }
                }
                Joint::Prismatic(axis) => {
                    let axis = parent.rotation * axis;
                    axes[first] = Axis { angular: Vector3::zeros(), linear: axis };
                    let origin = origin + axis * positions[number];
                    let linear = carried(&origin) + axis * velocity[first];
                    Frame { rotation: parent.rotation, origin, angular: parent.angular, linear }
                }
                Joint::Ball => {
                    let mut angular = parent.angular;
                    for axis in 0..3 {
                        let unit = Vector3::ith(axis, 1.0);
                        axes[first + axis] = Axis { angular: unit, linear: origin.cross(&unit) };
                        angular[axis] += velocity[first + axis];
                    }
                    let rotation = if link.is_round {
                        parent.rotation
                    } else {
                        parent.rotation * turns[number].to_rotation_matrix().into_inner()
                    };
                    Frame { rotation, origin, angular, linear: carried(&origin) }
                }
            };
        }
    }

    /// Works out inertia and free velocity for a step, with the servos in it.
    pub(crate) fn prepare(&mut self, time_step: f64) {
        if let Some(given) = &self.given {
            self.factors.copy_from_slice(&given.inertia);
            factor::factorise(&self.tree, &mut self.factors);
            self.free.copy_from_slice(&self.velocity);
            return;
        }
        inertia::assemble(self, time_step);
        factor::factorise(&self.tree, &mut self.factors);
        factor::solve(&self.tree, &self.factors, &mut self.free);
        self.free.iter_mut().zip(&self.velocity).for_each(|(free, now)| *free += now);
    }

    /// Moves on by a step with the velocity that it has, and works out where its links are then.
    pub fn advance(&mut self, time_step: f64) {
        let Self { tree, pose, centre, positions, turns, velocity, frames, force, .. } = self;
        let turned = |rotation: UnitQuaternion<f64>, angular: Vector3<f64>| {
            let turned = UnitQuaternion::from_scaled_axis(angular * time_step) * rotation;
            UnitQuaternion::new_normalize(turned.into_inner())
        };
        let three = |velocity: &[f64]| Vector3::from_column_slice(&velocity[..3]);
        for (number, link) in tree.links.iter().enumerate() {
            let dof = tree.dof_of(number);
            match link.joint {
                Joint::Free => {
                    let centre = *centre + three(&velocity[3..]) * time_step;
                    let rotation = turned(pose.rotation, three(velocity));
                    let origin = centre - rotation * link.mass.centre;
                    *pose = Pose::from_parts(Translation3::from(origin), rotation);
                }
                Joint::Revolute(_) | Joint::Prismatic(_) => positions[number] += velocity[dof] * time_step,
                // It turns with what carries it; its own frame is that in the world.
                Joint::Ball if !link.is_round => {
                    let angular = frames[link.parent].rotation.transpose() * three(&velocity[dof..]);
                    turns[number] = turned(turns[number], angular);
                }
                Joint::Fixed | Joint::Ball => {}
            }
        }
        force.fill(0.0);
        self.place();
    }

    /// Whether every number of it is one.
    pub fn is_finite(&self) -> bool {
        let numbers = self.pose.translation.vector.iter().chain(self.pose.rotation.coords.iter());
        numbers.chain(&self.positions).chain(&self.velocity).all(|it| it.is_finite())
    }
}
