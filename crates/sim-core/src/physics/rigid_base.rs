//! A robot with Mecanum wheels as one body: its wheels only spin, its rollers are only geometry.
//!
//! A free roller without inertia carries force along its own axis only. So each touch of a roller needs two rows in
//! [`super::traction`]: its normal force, and friction along the axis of the roller. The engine moves the body with the
//! velocity that is found, and adds what happens to its own shape (walls, boxes, other robots).

use std::sync::Arc;

use kinematics::{FiniteRollers, Mecanum, Twist};
use nalgebra::{Matrix3, Matrix6, UnitQuaternion, Vector3};
use rapier3d::parry::bounding_volume::Aabb;
use rapier3d::prelude::*;
use scene::{DriveModel, JointState, Mass, Material, Motor, MountedWheel, Pose, RobotDef};

use super::compile::{Base as CompiledBase, Materials};
use super::convert;
use super::motor::Servo;
use super::rolling::{self, Load};
use super::traction::{Base, Limit, Momentum, Motion, Other, Row, SpinningWheel, Velocity};
use super::wheel_contact::{RollerRing, WheelContact};
use crate::mecanum;

/// Stiffness of a roller's tread, N/m. It shares the load between the wheels.
const STIFFNESS: f64 = 1e8;
/// Time in which an overlap is pushed out, s.
const RECOVERY_TIME: f64 = 0.02;
/// Contacts are looked for over this distance and what the body does in a step, m.
const PREDICTION: f64 = 0.001;
/// A roller that stays farther away than this in a step, as it moves now, leaves its surface to a nearer one, m.
const MARGIN: f64 = 1e-6;
/// A bearing that gives way by more than so many times the robot's own speed under a push brakes next to nothing.
const WEAK: f64 = 1e4;
/// Cosine above which two normals are of one surface.
const SAME_SURFACE: f64 = 0.99;
/// Below this speed nothing bounces, m/s.
const LEAST_BOUNCE: f64 = 0.2;
/// A surface whose normal leans toward the axle by more than this cosine meets the side of the wheel.
const SIDE: f64 = 0.7;

/// A wheel of the base.
pub(super) struct BaseWheel {
    /// Centre in the robot frame.
    hub: Vector3<f64>,
    ring: RollerRing,
    /// Outer radius, m.
    radius: f64,
    /// Inertia about the axle with the rollers, kg m².
    inertia: f64,
    /// Bearing friction of a roller, N m s/rad.
    roller_damping: f64,
    material: Material,
    motor: Motor,
}

impl BaseWheel {
    /// `None` for a wheel that has no rollers or no motor.
    pub(super) fn new(wheel: &MountedWheel) -> Option<Self> {
        let (rollers, motor) = (wheel.rollers.as_ref()?, wheel.drive?);
        Some(Self {
            hub: wheel.position.into(),
            ring: RollerRing::new(rollers, wheel.radius),
            radius: wheel.radius,
            inertia: wheel.spin_inertia(),
            roller_damping: rollers.damping,
            material: rollers.material.clone(),
            motor: motor.clone(),
        })
    }
}

/// A wheel on something.
struct Touch<'a> {
    wheel: usize,
    contact: &'a WheelContact,
    /// What it touches.
    collider: &'a Collider,
    /// What that is made of.
    material: &'a Material,
    /// Its index among the bodies that can be moved; `None` is the ground.
    other: Option<usize>,
}

/// What a step asks of the solver, and its answer: kept while bases that touch each other are solved in turn.
#[derive(Default)]
struct Problem {
    wheels: Vec<SpinningWheel>,
    /// At the end of the step, without contacts and motors.
    momentum: Momentum,
    /// The part of it that is rolling resistance, N s.
    resistance: Vector3<f64>,
    rows: Vec<Row>,
    /// What is touched and can be moved, as the rows count it.
    touched: Vec<RigidBodyHandle>,
    others: Vec<Other>,
    impulses: Vec<f64>,
}

/// How a base that follows its commands counts its twist from its wheels' speeds.
enum Following {
    Textbook(Mecanum),
    FiniteRollers(FiniteRollers),
}

/// The base and its state.
pub(super) struct RigidBase {
    body: RigidBodyHandle,
    following: Option<Following>,
    mass: Mass,
    /// Of the velocity and the angular velocity, 1/s.
    damping: [f64; 2],
    /// What each wheel stood on in the last step.
    loads: Vec<Load>,
    wheels: Arc<[BaseWheel]>,
    servos: Vec<Servo>,
    pose: Pose,
    motion: Motion,
    momentum: Momentum,
    /// Angles of the wheels, rad.
    angles: Vec<f64>,
    /// The velocity given to the engine.
    given: (Vector, Vector),
    problem: Problem,
    /// What the wheels of other bases changed of the velocity, linear and angular, in the last step.
    pushed: Velocity,
    /// What the engine changed of it, in the last step and in the one before.
    changes: [Velocity; 2],
    contacts: Vec<WheelContact>,
    /// Where the ground pushed its wheels in the last step, and the impulse, N s: to be looked at.
    pushes: Vec<(Vector3<f64>, Vector3<f64>)>,
    /// The impulse of the ground in the last step that no single contact has, N s: rolling resistance, which is a force
    /// on the hubs, and what makes the base follow its commands.
    shared: Vector3<f64>,
    /// Angles of the rollers, wheel by wheel, rad: to be looked at. They have no inertia, so nothing depends on them.
    roller_angles: Vec<Vec<f64>>,
}

impl RigidBase {
    /// At rest.
    pub(super) fn new(body: RigidBodyHandle, robot: &RobotDef, base: &CompiledBase, pose: Pose) -> Self {
        let zero = Vector3::zeros();
        let (mass, wheels) = (base.mass, base.wheels.clone());
        let count = wheels.len();
        let following = match robot.drive_model {
            DriveModel::Kinematic => mecanum::finite_rollers(robot).map(Following::FiniteRollers),
            DriveModel::KinematicTextbook => mecanum::textbook(robot).map(Following::Textbook),
            DriveModel::Bodies | DriveModel::Articulated | DriveModel::Analytic => None,
        };
        Self {
            body,
            following,
            mass,
            damping: robot.body_damping(),
            loads: vec![Load::default(); count],
            servos: vec![Servo::default(); count],
            wheels,
            pose,
            motion: Motion { linear: zero, angular: zero, spins: vec![0.0; count] },
            momentum: Momentum { linear: zero, angular: zero, spins: vec![0.0; count] },
            angles: vec![0.0; count],
            given: (Vector::ZERO, Vector::ZERO),
            problem: Problem::default(),
            pushed: (zero, zero),
            changes: [(zero, zero); 2],
            contacts: Vec::new(),
            pushes: Vec::new(),
            shared: zero,
            roller_angles: robot.driven().map(|wheel| vec![0.0; wheel.roller_count()]).collect(),
        }
    }

    pub(super) fn set_wheel_speeds(&mut self, speeds: &[f64]) {
        self.servos.iter_mut().zip(speeds).for_each(|(servo, &speed)| servo.set_target(speed));
    }

    pub(super) fn pose(&self) -> &Pose {
        &self.pose
    }

    /// Velocity of the origin of the robot frame, and angular velocity.
    pub(super) fn velocity(&self) -> (Vector3<f64>, Vector3<f64>) {
        let lever = self.pose.rotation * -self.mass.centre;
        (self.motion.linear + self.motion.angular.cross(&lever), self.motion.angular)
    }

    pub(super) fn wheels(&self) -> impl Iterator<Item = JointState> {
        self.angles.iter().zip(&self.motion.spins).map(|(&position, &speed)| JointState { position, speed })
    }

    /// Where the ground pushed its wheels in the last step, and the impulses, N s.
    pub(super) fn pushes(&self) -> &[(Vector3<f64>, Vector3<f64>)] {
        &self.pushes
    }

    /// The impulse of the ground in the last step that no single one of these has, N s.
    pub(super) fn shared(&self) -> Vector3<f64> {
        self.shared
    }

    /// Angles of its rollers, wheel by wheel, rad.
    pub(super) fn roller_angles(&self) -> impl Iterator<Item = f64> {
        self.roller_angles.iter().flatten().copied()
    }

    /// Finds the velocity at the end of the step, with gravity and everything that its wheels touch, as others moved in
    /// the last step.
    pub(super) fn solve(&mut self, world: &PhysicsWorld, materials: &Materials) {
        let time_step = world.integration_parameters.dt;
        let wheels = self.spinning_wheels(time_step);
        let base = self.base(&wheels);
        let twist = self.twist();
        let mut momentum = self.momentum.clone();
        let fall = convert::from_vector(world.gravity) * time_step;
        self.resist_rolling(&mut momentum, fall);
        let resistance = momentum.linear - self.momentum.linear;
        momentum.linear += fall * self.mass.mass;
        let [linear, angular] = self.damping;
        momentum.linear /= 1.0 + linear * time_step;
        momentum.angular /= 1.0 + angular * time_step;
        let (mut rows, mut others, mut touched) = (Vec::new(), Vec::new(), Vec::new());
        let mut contacts = std::mem::take(&mut self.contacts);
        for wheel in 0..self.wheels.len() {
            contacts.clear();
            self.find_contacts(world, wheel, time_step, &mut contacts);
            for contact in &contacts {
                self.turn_roller(wheel, contact, &base, time_step);
                let collider = &world.colliders[contact.other];
                let other = dynamic_body(world, collider).map(|(handle, body)| {
                    touched.iter().position(|&known| known == handle).unwrap_or_else(|| {
                        touched.push(handle);
                        others.push(other_body(world, handle, body));
                        touched.len() - 1
                    })
                });
                let touch = Touch { wheel, contact, collider, material: materials.of(collider), other };
                if twist.is_some() {
                    rows.push(self.normal_row(&touch, &base, time_step));
                } else {
                    self.push_rows(&touch, &contacts, &base, time_step, &mut rows, &mut momentum);
                }
            }
        }
        self.contacts = contacts;
        if let Some(twist) = twist
            && !rows.is_empty()
        {
            let weight = world.gravity.length() * self.mass.mass;
            rows.extend(self.twist_rows(twist, weight * time_step));
        }
        self.problem = Problem { wheels, momentum, resistance, rows, touched, others, impulses: Vec::new() };
        self.solve_pushed(self.pushed, time_step);
    }

    /// Finds the velocity at the end of the step when the wheels of other bases add `pushed` to it, and returns by how much
    /// it is another one than was found before, m/s.
    pub(super) fn solve_pushed(&mut self, pushed: Velocity, time_step: f64) -> f64 {
        let mut problem = std::mem::take(&mut self.problem);
        let Problem { wheels, momentum, resistance, rows, others, .. } = &problem;
        let base = self.base(wheels);
        let (linear, angular) = self.expected();
        let expected = (linear + pushed.0, angular + pushed.1);
        let (mut motion, impulses) = base.solve(momentum, expected, rows, others, time_step);
        if self.following.is_some() {
            motion.spins = self.servos.iter().map(Servo::target).collect();
        }
        let change = (motion.linear - self.motion.linear).norm();
        self.momentum = base.momentum(&motion);
        self.motion = motion;
        self.shared = *resistance;
        self.pushes.clear();
        self.loads.fill(Load::default());
        for (row, impulse) in rows.iter().zip(&impulses) {
            match (row.wheel, row.point, self.pushes.last_mut()) {
                (Some(_), Some(point), Some((known, push))) if *known == point => *push += row.direction * *impulse,
                (Some(_), Some(point), _) => self.pushes.push((point, row.direction * *impulse)),
                (None, Some(_), _) => self.shared += row.direction * *impulse,
                (_, None, _) => {}
            }
            if let (Some((wheel, _)), Limit::Push) = (row.wheel, row.limit) {
                self.loads[wheel].normal += row.direction * *impulse;
                self.loads[wheel].resistance += row.rolling_resistance * impulse;
            }
        }
        problem.impulses = impulses;
        self.problem = problem;
        change
    }

    /// Its body in the engine.
    pub(super) fn body(&self) -> RigidBodyHandle {
        self.body
    }

    /// Velocity of the centre of mass, and angular velocity, as far as they are solved for.
    pub(super) fn solved(&self) -> Velocity {
        (self.motion.linear, self.motion.angular)
    }

    /// What its wheels touch and can be moved.
    pub(super) fn touched(&self) -> &[RigidBodyHandle] {
        &self.problem.touched
    }

    /// By what its wheels change the velocity of one of these.
    pub(super) fn change_of(&self, touched: usize) -> Velocity {
        let Problem { rows, others, impulses, .. } = &self.problem;
        others[touched].change(rows.iter().zip(impulses).filter(|(row, _)| row.other == Some(touched)))
    }

    /// How one of these moves when its wheels do not push it.
    pub(super) fn set_velocity_of(&mut self, touched: usize, velocity: Velocity) {
        let other = &mut self.problem.others[touched];
        (other.linear, other.angular) = velocity;
    }

    /// Gives the velocity to the engine.
    pub(super) fn give_velocity(&mut self, world: &mut PhysicsWorld) {
        self.given = (convert::vector(self.motion.linear), convert::vector(self.motion.angular));
        if let Some(body) = world.bodies.get_mut(self.body) {
            body.set_linvel(self.given.0, false);
            body.set_angvel(self.given.1, false);
        }
    }

    /// Gives the reactions to what was touched. A link of a multibody has its velocity from the multibody, and an impulse on
    /// it is lost: it gets a force for one step.
    pub(super) fn react(&self, world: &mut PhysicsWorld) {
        let time_step = world.integration_parameters.dt;
        for (row, impulse) in self.problem.rows.iter().zip(&self.problem.impulses) {
            let (Some(other), Some(point)) = (row.other, row.point) else { continue };
            let handle = self.problem.touched[other];
            let (impulse, point) = (convert::vector(row.direction * -impulse), convert::vector(point));
            let is_link = world.multibody_joints.rigid_body_link(handle).is_some();
            match world.bodies.get_mut(handle) {
                Some(link) if is_link => link.add_force_at_point(impulse / time_step, point, true),
                Some(body) => body.apply_impulse_at_point(impulse, point, true),
                None => {}
            }
        }
    }

    /// Looks how other bases have pushed it; to be called when all have.
    pub(super) fn note_pushes(&mut self, world: &PhysicsWorld) {
        self.pushed = world.bodies.get(self.body).map_or_else(Default::default, |body| self.change_since_given(body));
    }

    /// What has happened to the velocity that was given to the engine.
    fn change_since_given(&self, body: &RigidBody) -> Velocity {
        (convert::from_vector(body.linvel() - self.given.0), convert::from_vector(body.angvel() - self.given.1))
    }

    /// Moves on by a step, with what the engine has changed.
    pub(super) fn advance(&mut self, world: &PhysicsWorld) {
        let time_step = world.integration_parameters.dt;
        let Some(body) = world.bodies.get(self.body) else { return };
        let change = self.change_since_given(body);
        for (angle, spin) in self.angles.iter_mut().zip(&self.motion.spins) {
            *angle += spin * time_step;
        }
        self.changes = [(change.0 - self.pushed.0, change.1 - self.pushed.1), self.changes[0]];
        let turn = self.pose.rotation.to_rotation_matrix();
        self.motion.linear += change.0;
        self.motion.angular += change.1;
        self.momentum.linear += change.0 * self.mass.mass;
        self.momentum.angular += turn * self.mass.inertia * (turn.inverse() * change.1);
        self.pose = convert::from_pose(body.position());
    }

    /// A change by the engine that goes on, as a wall or a pushed box makes; a single hit does not count.
    fn expected(&self) -> Velocity {
        let [last, before] = &self.changes;
        let common = |a: f64, b: f64| if a * b > 0.0 { a.abs().min(b.abs()).copysign(a) } else { 0.0 };
        (last.0.zip_map(&before.0, common), last.1.zip_map(&before.1, common))
    }

    fn base<'a>(&self, wheels: &'a [SpinningWheel]) -> Base<'a> {
        let turn = self.pose.rotation.to_rotation_matrix();
        let centre = (self.pose * nalgebra::Point3::from(self.mass.centre)).coords;
        let inertia = turn * self.mass.inertia * turn.inverse();
        Base { mass: self.mass.mass, centre, inertia, wheels }
    }

    fn spinning_wheels(&mut self, time_step: f64) -> Vec<SpinningWheel> {
        let axle = self.pose.rotation * -Vector3::y();
        let states = self.angles.iter().zip(&self.motion.spins);
        let wheels = self.wheels.iter().zip(&mut self.servos).zip(states);
        let spinning = wheels.map(|((wheel, servo), (&angle, &speed))| {
            let torque = servo.torque(&wheel.motor, angle, speed, time_step);
            SpinningWheel {
                axle,
                inertia: wheel.inertia,
                armature: wheel.motor.armature,
                stall_torque: torque.at_rest,
                gain: torque.gain,
                max_torque: wheel.motor.max_torque,
            }
        });
        spinning.collect()
    }

    fn find_contacts(&self, world: &PhysicsWorld, wheel: usize, time_step: f64, contacts: &mut Vec<WheelContact>) {
        let (wheel, angle) = (&self.wheels[wheel], self.angles[wheel]);
        let hub = self.pose * Pose::from_parts(wheel.hub.into(), UnitQuaternion::identity());
        let reach = PREDICTION + self.motion.linear.norm() * time_step;
        let half = Vector::splat(wheel.radius + reach);
        let near = Aabb::from_half_extents(convert::vector(hub.translation.vector), half);
        let query = world.query_pipeline();
        for (handle, collider) in query.intersect_aabb_conservative(near) {
            if collider.parent() != Some(self.body) && !collider.is_sensor() {
                wheel.ring.touch(&hub, angle, reach, handle, collider, contacts);
            }
        }
    }

    /// The rows of a touch, unless another of the wheel's `contacts` has its load.
    fn push_rows(
        &self,
        touch: &Touch,
        contacts: &[WheelContact],
        base: &Base,
        time_step: f64,
        rows: &mut Vec<Row>,
        momentum: &mut Momentum,
    ) {
        let Touch { wheel: index, contact, collider, .. } = *touch;
        let wheel = &self.wheels[index];
        let WheelContact { point, normal, axis, gap, .. } = *contact;
        let (hub, velocity) = (self.hub(index), self.velocity_of_wheel(index, point, base));
        // Where one roller hands over to the next, both share the load only while both press. That the wheel turns does not
        // bring the next one nearer: it comes down where the last leaves, on the same circle.
        let nearer = |peer: &WheelContact| peer.gap < gap && peer.normal.dot(&normal) > SAME_SURFACE;
        let approach = normal.dot(&self.velocity_at(point, base.centre));
        if gap + approach * time_step > MARGIN && contacts.iter().any(nearer) {
            return;
        }
        let row = self.normal_row(touch, base, time_step);
        let coefficient = (wheel.material.friction + collider.friction()) / 2.0;
        let limit = Limit::Friction { normal: rows.len(), coefficient };
        rows.push(row);
        let along = (axis - normal * axis.dot(&normal)).normalize();
        let friction = Row { direction: along, target: 0.0, compliance: 0.0, limit, ..row };
        rows.push(friction);
        let across = normal.cross(&along);
        // Torque d w of the bearing at the roller's speed w = v / rho is a force d v / rho².
        let free = contact.rolling_radius.powi(2) / (wheel.roller_damping * time_step);
        if normal.dot(&base.wheels[index].axle).abs() > SIDE {
            rows.push(Row { direction: across, ..friction });
        } else if free * base.mass < WEAK {
            rows.push(Row { direction: across, compliance: free, ..friction });
        } else {
            // So little does not need to be solved for.
            base.push(momentum, index, hub, point, across * (-across.dot(&velocity) / free));
        }
    }

    /// The contact along its normal: it pushes, gives way a little, and bounces as its materials do.
    fn normal_row(&self, touch: &Touch, base: &Base, time_step: f64) -> Row {
        let Touch { wheel: index, contact, collider, material, other } = *touch;
        let WheelContact { point, normal, gap, .. } = *contact;
        let speed = normal.dot(&self.velocity_of_wheel(index, point, base));
        let restitution = (self.wheels[index].material.restitution + collider.restitution()) / 2.0;
        let push = if gap > 0.0 { -gap / time_step } else { -gap / (time_step + RECOVERY_TIME) };
        Row {
            direction: normal,
            point: Some(point),
            wheel: Some((index, self.hub(index))),
            other,
            target: if gap <= 0.0 && speed < -LEAST_BOUNCE { push.max(-speed * restitution) } else { push },
            compliance: 1.0 / (time_step * STIFFNESS * (time_step + RECOVERY_TIME)),
            limit: Limit::Push,
            rolling_resistance: self.wheels[index].material.rolling_resistance + material.rolling_resistance,
        }
    }

    /// A roller that touches rolls across its axis as fast as what it touches passes by.
    fn turn_roller(&mut self, wheel: usize, contact: &WheelContact, base: &Base, time_step: f64) {
        let WheelContact { point, normal, roller, axis, gap, rolling_radius, .. } = *contact;
        if gap < MARGIN {
            let across = normal.cross(&axis);
            let passing = across.dot(&self.velocity_of_wheel(wheel, point, base));
            self.roller_angles[wheel][roller] -= passing / rolling_radius * time_step;
        }
    }

    fn resist_rolling(&self, momentum: &mut Momentum, fall: Vector3<f64>) {
        let share = self.mass.mass / self.wheels.len() as f64;
        let centre = (self.pose * nalgebra::Point3::from(self.mass.centre)).coords;
        for (wheel, load) in self.loads.iter().enumerate().filter(|(_, load)| load.resistance > 0.0) {
            let hub = self.hub(wheel);
            let impulse = rolling::impulse(load, self.velocity_at(hub, centre) + fall, share);
            momentum.linear += impulse;
            momentum.angular += (hub - centre).cross(&impulse);
        }
    }

    fn hub(&self, wheel: usize) -> Vector3<f64> {
        (self.pose * nalgebra::Point3::from(self.wheels[wheel].hub)).coords
    }

    /// Velocity of the body at a point, its centre of mass being where it is.
    fn velocity_at(&self, point: Vector3<f64>, centre: Vector3<f64>) -> Vector3<f64> {
        self.motion.linear + self.motion.angular.cross(&(point - centre))
    }

    /// Velocity of a wheel's material at a point.
    fn velocity_of_wheel(&self, wheel: usize, point: Vector3<f64>, base: &Base) -> Vector3<f64> {
        let spin = base.wheels[wheel].axle * self.motion.spins[wheel];
        self.velocity_at(point, base.centre) + spin.cross(&(point - self.hub(wheel)))
    }

    /// The twist of the wheels' commands, where the base follows it.
    fn twist(&self) -> Option<Twist> {
        let speeds = || std::array::from_fn(|wheel| self.servos[wheel].target());
        self.following.as_ref().map(|following| match following {
            Following::Textbook(mecanum) => mecanum.forward(speeds()),
            Following::FiniteRollers(rollers) => {
                rollers.forward(speeds(), std::array::from_fn(|wheel| rollers.phase(wheel, self.angles[wheel])))
            }
        })
    }

    /// Rows that make the robot frame move by a twist. They push no harder than real wheels could, so walls hold.
    fn twist_rows(&self, twist: Twist, weight: f64) -> [Row; 3] {
        let grip = self.wheels.first().map_or(0.0, |wheel| wheel.material.friction) * weight;
        let lever = self.wheels.iter().map(|wheel| wheel.hub.norm()).fold(0.0, f64::max);
        let row = |axis: Vector3<f64>, point, target, most| Row {
            direction: self.pose.rotation * axis,
            point,
            wheel: None,
            other: None,
            target,
            compliance: 0.0,
            limit: Limit::Within(most),
            rolling_resistance: 0.0,
        };
        let origin = Some(self.pose.translation.vector);
        [
            row(Vector3::x(), origin, twist.forward, grip),
            row(Vector3::y(), origin, twist.right, grip),
            row(Vector3::z(), None, twist.clockwise, grip * lever),
        ]
    }
}

fn dynamic_body<'a>(world: &'a PhysicsWorld, collider: &Collider) -> Option<(RigidBodyHandle, &'a RigidBody)> {
    let handle = collider.parent()?;
    world.bodies.get(handle).filter(|body| body.is_dynamic()).map(|body| (handle, body))
}

fn other_body(world: &PhysicsWorld, handle: RigidBodyHandle, body: &RigidBody) -> Other {
    Other {
        inverse_inertia: inverse_of_link(world, handle).unwrap_or_else(|| inverse_of_body(body)),
        centre: convert::from_vector(body.mass_properties().world_com),
        linear: convert::from_vector(body.linvel()),
        angular: convert::from_vector(body.angvel()),
    }
}

fn inverse_of_body(body: &RigidBody) -> Matrix6<f64> {
    let properties = body.mass_properties();
    let inverse = properties.effective_world_inv_inertia;
    let [xx, xy, xz, yy, yz, zz] = [inverse.m11, inverse.m12, inverse.m13, inverse.m22, inverse.m23, inverse.m33];
    let mut matrix = Matrix6::from_diagonal_element(properties.effective_inv_mass.x);
    matrix.fixed_view_mut::<3, 3>(3, 3).copy_from(&Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz));
    matrix
}

/// What is felt at a link of a multibody, with all that hangs on it. `None` for other bodies, and before the first step.
fn inverse_of_link(world: &PhysicsWorld, handle: RigidBodyHandle) -> Option<Matrix6<f64>> {
    let link = world.multibody_joints.rigid_body_link(handle)?;
    let multibody = world.multibody_joints.get_multibody(link.multibody)?;
    let (jacobian, mass) = (multibody.body_jacobian(link.id), multibody.inv_augmented_mass());
    if mass.lu_internal().nrows() != multibody.ndofs() || jacobian.ncols() != multibody.ndofs() {
        return None;
    }
    let response = jacobian * mass.solve(&jacobian.transpose())?;
    Some(Matrix6::from_fn(|row, column| response[(row, column)]))
}
