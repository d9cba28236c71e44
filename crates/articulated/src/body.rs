//! A tree in motion.

use std::sync::Arc;

use nalgebra::{DMatrix, Matrix3, Point3, Rotation3, Translation3, Unit, UnitQuaternion, Vector3};

use crate::{Joint, Link, Mass, Pose, Tree, factor, inertia, root};

/// A tree with its pose and velocity.
#[derive(Debug, Clone)]
pub struct Body {
    pub(crate) tree: Arc<Tree>,
    /// Pose of the root's frame.
    pose: Pose,
    /// The root's centre of mass in the world, m.
    centre: Vector3<f64>,
    /// Joint position of every link whose joint has one value, rad or m.
    positions: Vec<f64>,
    /// Orientation of every link on a ball joint in its parent's frame.
    turns: Vec<UnitQuaternion<f64>>,
    /// Generalised velocity.
    pub(crate) velocity: Vec<f64>,
    pub(crate) frames: Vec<Frame>,
    pub(crate) axes: Vec<Axis>,
    /// Gravity, m/s².
    pub(crate) gravity: Vector3<f64>,
    /// Servo of every degree of freedom.
    pub(crate) drives: Vec<Drive>,
    /// Generalised force of the coming step besides gravity and servos, N m or N.
    pub(crate) force: Vec<f64>,
    /// Inertia matrix with implicit servos; after factorisation, its factors.
    pub(crate) factors: Vec<f64>,
    /// Velocity at the end of the step without contacts.
    pub(crate) free: Vec<f64>,
    /// Response of a body that another program moves.
    given: Option<Given>,
}

/// Response to impulses of a body that another program moves.
#[derive(Debug, Clone)]
struct Given {
    /// Inertia matrix, stored as the factors are.
    inertia: Vec<f64>,
    /// Twists of every link, one for each speed.
    links: Vec<Vec<Axis>>,
}

/// The current motion of a link. Positions are from [`Body::centre`], in world axes.
#[derive(Debug, Clone, Copy)]
pub struct Frame {
    /// Rotation from the link's axes to the world's. A round link has that of its parent.
    pub rotation: Matrix3<f64>,
    /// Origin, m.
    pub origin: Vector3<f64>,
    /// Angular velocity, rad/s.
    pub angular: Vector3<f64>,
    /// Velocity of the origin, m/s.
    pub linear: Vector3<f64>,
}

/// Twist of a degree of freedom at a speed of 1: an angular velocity, and a velocity at the centre.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Axis {
    pub(crate) angular: Vector3<f64>,
    pub(crate) linear: Vector3<f64>,
}

/// Position and velocity of a tree as plain data.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Motion {
    pose: Pose,
    positions: Vec<f64>,
    turns: Vec<UnitQuaternion<f64>>,
    velocity: Vec<f64>,
}

/// A servo's force as a function of the speed at the end of a step: `at_rest - gain speed`, within a limit. N m or N.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Drive {
    /// Force at speed 0.
    pub at_rest: f64,
    /// Decrease of the force with speed, N m s/rad or N s/m.
    pub gain: f64,
    /// Largest force in either direction.
    pub most: f64,
}

impl Axis {
    /// Returns the velocity of a point, given from the centre.
    pub(crate) fn at(&self, point: Vector3<f64>) -> Vector3<f64> {
        self.linear + self.angular.cross(&point)
    }
}

impl Frame {
    /// Computes the velocity of the link's centre of mass, m/s.
    fn velocity_of_centre(&self, link: &Link) -> Vector3<f64> {
        self.linear + self.angular.cross(&(self.rotation * link.mass.centre))
    }
}

impl Body {
    /// Creates a body at rest, with every joint at 0.
    pub fn new(tree: Arc<Tree>, pose: Pose) -> Self {
        let (links, dofs) = (tree.links.len(), tree.dof_count());
        let zero = Vector3::zeros();
        let mut axes = vec![Axis { angular: zero, linear: zero }; dofs];
        if tree.dofs_of_free_root() > 0 {
            for axis in 0..3 {
                axes[axis].angular = Vector3::ith(axis, 1.0);
                axes[3 + axis].linear = Vector3::ith(axis, 1.0);
            }
        }
        let mut body = Self {
            pose,
            centre: zero,
            positions: vec![0.0; links],
            turns: vec![UnitQuaternion::identity(); links],
            velocity: vec![0.0; dofs],
            frames: vec![Frame { rotation: Matrix3::identity(), origin: zero, angular: zero, linear: zero }; links],
            axes,
            gravity: zero,
            drives: vec![Drive::default(); dofs],
            force: vec![0.0; dofs],
            factors: vec![0.0; tree.entries],
            free: vec![0.0; dofs],
            given: None,
            tree,
        };
        body.place();
        body
    }

    /// Creates a body that another program moves, as its contacts see it. `velocity` is its generalised velocity at the end of a step
    /// without these contacts, and `inertia` the matrix for it. `links` has, for every link, the twist of each speed about the centre, the
    /// angular part first.
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

    /// Returns the last of the degrees of freedom that move a link, and the twists of all degrees of freedom as the link has them. `None` if
    /// nothing moves the link. The chain of the last one has all that move it.
    pub(crate) fn axes_of(&self, link: usize) -> Option<(usize, &[Axis])> {
        match &self.given {
            Some(given) => Some((self.velocity.len().checked_sub(1)?, &given.links[link])),
            None => Some((self.tree.tip(link)?, &self.axes)),
        }
    }

    /// Returns the tree of links.
    #[inline]
    pub fn tree(&self) -> &Tree {
        &self.tree
    }

    /// Returns the pose of the root's frame.
    pub fn pose(&self) -> &Pose {
        &self.pose
    }

    /// Returns the position of the root's centre of mass, m, from which positions of frames are given.
    #[inline]
    pub fn centre(&self) -> Vector3<f64> {
        self.centre
    }

    /// Returns the current frames of the links.
    #[inline]
    pub fn frames(&self) -> &[Frame] {
        &self.frames
    }

    /// Returns the position of a link's joint, rad or m.
    #[inline]
    pub fn position(&self, link: usize) -> f64 {
        self.positions[link]
    }

    /// Returns the generalised velocity.
    #[inline]
    pub fn velocity(&self) -> &[f64] {
        &self.velocity
    }

    /// Returns the generalised velocity for changes. Frames follow with [`Body::place`].
    pub fn velocity_mut(&mut self) -> &mut [f64] {
        &mut self.velocity
    }

    /// Returns the velocity of a point of a link, given in the world, m/s.
    #[inline]
    pub fn velocity_at(&self, link: usize, point: Vector3<f64>) -> Vector3<f64> {
        if self.given.is_some() {
            let at = point - self.centre();
            let Some((tip, axes)) = self.axes_of(link) else { return Vector3::zeros() };
            return self.tree.chain(tip).iter().map(|&dof| axes[dof].at(at) * self.velocity[dof]).sum();
        }
        let Frame { origin, angular, linear, .. } = &self.frames[link];
        linear + angular.cross(&(point - self.centre() - origin))
    }

    /// Returns the velocity at which a link's belt runs over the link where it touches a plane, m/s; zero without a belt. The normal points
    /// into the link, in world axes.
    pub fn belt_velocity(&self, link: usize, normal: Vector3<f64>) -> Vector3<f64> {
        self.belt_at(link, normal).map_or_else(Vector3::zeros, |(dof, run)| run * self.velocity[dof])
    }

    /// Returns the degree of freedom of a link's belt, and the velocity of the belt's surface at a sprocket speed of 1 where it touches a
    /// plane, m. The normal, either way, is in world axes. `None` for a link without a belt.
    pub(crate) fn belt_at(&self, link: usize, normal: Vector3<f64>) -> Option<(usize, Vector3<f64>)> {
        let &Link { joint: Joint::Belt { axis, radius }, parent, .. } = self.tree.links.get(link)? else { return None };
        let axis = self.frames[parent].rotation * axis;
        Some((self.tree.dof_of(link), normal.cross(&axis) * radius))
    }

    /// Sets gravity, m/s². It is 0 at first.
    pub fn set_gravity(&mut self, gravity: Vector3<f64>) {
        self.gravity = gravity;
    }

    /// Sets the servo of a degree of freedom for the coming step.
    pub fn set_drive(&mut self, dof: usize, drive: Drive) {
        self.drives[dof] = drive;
    }

    /// Applies a force, N, at a point of a link in the coming step.
    pub fn push(&mut self, link: usize, point: Vector3<f64>, force: Vector3<f64>) {
        let at = point - self.centre();
        let Self { tree, axes, force: sum, .. } = self;
        let Some(tip) = tree.tip(link) else { return };
        let of_root = tree.dofs_of_free_root();
        sum[..of_root].iter_mut().zip(root::along(&force, &at)).for_each(|(sum, along)| *sum += along);
        for &dof in &tree.chain(tip)[of_root..] {
            sum[dof] += axes[dof].at(at).dot(&force);
        }
    }

    /// Applies a torque, N m, to a link in the coming step. A belt feels the part about the axle of its sprocket.
    pub fn twist(&mut self, link: usize, torque: Vector3<f64>) {
        let Self { tree, axes, force: sum, frames, .. } = self;
        let Some(tip) = tree.tip(link) else { return };
        let of_root = tree.dofs_of_free_root();
        sum[..of_root].iter_mut().zip(root::twist(&torque, &Vector3::zeros())).for_each(|(sum, part)| *sum += part);
        for &dof in &tree.chain(tip)[of_root..] {
            sum[dof] += axes[dof].angular.dot(&torque);
        }
        if let Link { joint: Joint::Belt { axis, .. }, parent, .. } = &tree.links()[link] {
            sum[tree.dof_of(link)] += (frames[*parent].rotation * axis).dot(&torque);
        }
    }

    /// Applies a torque, N m, or force, N, between a joint's two links in the coming step, by degree of freedom.
    pub fn load(&mut self, dof: usize, effort: f64) {
        self.force[dof] += effort;
    }

    /// Computes the kinetic energy, J.
    pub fn kinetic_energy(&self) -> f64 {
        let of_link = |(link, frame): (&crate::Link, &Frame)| {
            let velocity = frame.velocity_of_centre(link);
            let turning = frame.rotation.transpose() * frame.angular;
            (link.mass.mass * velocity.norm_squared() + turning.dot(&(link.mass.inertia * turning))) / 2.0
        };
        let rotors = self.tree.dofs.iter().zip(&self.velocity).map(|(dof, speed)| dof.armature * speed * speed / 2.0);
        self.tree.links.iter().zip(&self.frames).map(of_link).sum::<f64>() + rotors.sum::<f64>()
    }

    /// Computes frames and axes from positions and velocities.
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
                Joint::Belt { .. } => {
                    axes[first] = Axis { angular: Vector3::zeros(), linear: Vector3::zeros() };
                    let linear = carried(&origin);
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

    /// Computes the inertia matrix and the free velocity for a step, with implicit servos.
    pub(crate) fn prepare(&mut self, time_step: f64, scratch: &mut inertia::Scratch) {
        if let Some(given) = &self.given {
            self.factors.copy_from_slice(&given.inertia);
            factor::factorise(&self.tree, &mut self.factors);
            self.free.copy_from_slice(&self.velocity);
            return;
        }
        inertia::assemble(self, time_step, scratch);
        factor::factorise(&self.tree, &mut self.factors);
        factor::solve(&self.tree, &self.factors, &mut self.free);
        self.free.iter_mut().zip(&self.velocity).for_each(|(free, now)| *free += now);
    }

    /// Moves the body by a step with its present velocity, and updates its frames.
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
                Joint::Revolute(_) | Joint::Prismatic(_) | Joint::Belt { .. } => {
                    positions[number] += velocity[dof] * time_step;
                }
                // Its speeds are in world axes, its orientation in the parent's frame.
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

    /// Scales the motion about the centre of mass. The momentum stays, and the energy does not grow if the share is at most 1.
    pub fn scale_motion(&mut self, share: f64) {
        // Frames may have the velocity before the step.
        self.place();
        let mean = self.mean_velocity();
        self.velocity.iter_mut().for_each(|speed| *speed *= share);
        if self.tree.dofs_of_free_root() > 0 {
            self.velocity[3..6].iter_mut().zip(&mean).for_each(|(speed, mean)| *speed += mean * (1.0 - share));
        }
        self.place();
    }

    /// Computes the velocity of the centre of mass, m/s.
    fn mean_velocity(&self) -> Vector3<f64> {
        let links = self.tree.links.iter().zip(&self.frames);
        let (mass, momentum) = links.fold((0.0, Vector3::zeros()), |(mass, momentum), (link, frame)| {
            let velocity = frame.velocity_of_centre(link);
            (mass + link.mass.mass, momentum + velocity * link.mass.mass)
        });
        momentum / mass
    }

    /// Moves the root's frame to a pose. Joints and velocities stay.
    pub fn set_pose(&mut self, pose: Pose) {
        self.pose = pose;
        self.place();
    }

    /// Returns position and velocity.
    pub fn motion(&self) -> Motion {
        let Self { pose, positions, turns, velocity, .. } = self;
        Motion { pose: *pose, positions: positions.clone(), turns: turns.clone(), velocity: velocity.clone() }
    }

    /// Takes position and velocity. Returns false, and changes nothing, if they are another tree's or not finite.
    pub fn set_motion(&mut self, motion: &Motion) -> bool {
        let Motion { pose, positions, turns, velocity } = motion;
        let is_like = [positions.len(), turns.len(), velocity.len()]
            == [self.positions.len(), self.turns.len(), self.velocity.len()];
        let mut moved = self.clone();
        (moved.pose, moved.positions, moved.turns, moved.velocity) =
            (*pose, positions.clone(), turns.clone(), velocity.clone());
        let fits = is_like && moved.is_finite();
        if fits {
            moved.place();
            *self = moved;
        }
        fits
    }

    /// True if no number of the state is infinite or NaN.
    pub fn is_finite(&self) -> bool {
        let numbers = self.pose.translation.vector.iter().chain(self.pose.rotation.coords.iter());
        numbers.chain(&self.positions).chain(&self.velocity).all(|it| it.is_finite())
    }
}
