//! A robot in the engine: one multibody of the chassis, its wheels and their rollers, or one body with
//! [`super::rigid_base`].

use nalgebra::{Translation3, Vector3};
use rapier3d::math::Pose as EnginePose;
use rapier3d::prelude::*;

use super::motor::{Servo, Torque};
use super::rigid_base::RigidBase;
use super::rolling::{self, Load};
use super::touching::solve_touching;
use super::{BodyState, LANDING_TIME, Physics, WheelState, convert, shape, with_material};
use scene::{DriveModel, Mass, Pose, RobotDef, Rollers, Wheel};

/// A robot of which no wheel carries anything falls when it goes down so fast, m/s. Put onto a surface it comes down with
/// 0.14 m/s; what is faster has fallen off the map and lands nowhere.
const FALLING_SPEEDS: std::ops::Range<f64> = 0.2..20.0;

/// Where no ray comes, m.
const FAR_AWAY: Vector = Vector::new(1e6, 1e6, 1e6);

/// The bodies of one robot.
pub(crate) struct RobotBodies {
    chassis: RigidBodyHandle,
    /// Origin of the chassis' body in the robot frame, m.
    centre: Vector3<f64>,
    /// Every body, chassis first, for removal.
    all: Vec<RigidBodyHandle>,
    drivetrain: Drivetrain,
}

/// What turns the wheels.
pub(super) enum Drivetrain {
    Multibody {
        driven: Vec<MultibodyWheel>,
        /// Of every wheel, casters too.
        treads: Vec<Tread>,
    },
    Rigid(Box<RigidBase>),
}

/// A driven wheel, in the order of the definition.
pub(super) struct MultibodyWheel {
    joint: MultibodyJointHandle,
    servo: Servo,
}

/// What touches the ground of a wheel.
pub(super) struct Tread {
    pub(super) colliders: Vec<ColliderHandle>,
    /// Rolling resistance in the last step, N.
    pub(super) resistance: Vector3<f64>,
}

impl RobotBodies {
    /// Every body, chassis first, then each wheel with its rollers behind it.
    pub(super) fn all(&self) -> &[RigidBodyHandle] {
        &self.all
    }

    pub(super) fn drivetrain(&self) -> &Drivetrain {
        &self.drivetrain
    }

    fn base_mut(&mut self) -> Option<&mut RigidBase> {
        match &mut self.drivetrain {
            Drivetrain::Rigid(base) => Some(base),
            Drivetrain::Multibody { .. } => None,
        }
    }

    /// Whether a body is one of the robot's.
    pub(super) fn contains(&self, body: RigidBodyHandle) -> bool {
        self.all.contains(&body)
    }

    /// Sets the targets of the wheel servos, rad/s.
    pub(crate) fn set_wheel_speeds(&mut self, speeds: &[f64]) {
        match &mut self.drivetrain {
            Drivetrain::Multibody { driven, .. } => {
                driven.iter_mut().zip(speeds).for_each(|(wheel, &speed)| wheel.servo.set_target(speed));
            }
            Drivetrain::Rigid(base) => base.set_wheel_speeds(speeds),
        }
    }
}

impl Physics {
    /// Puts a robot at a pose of its frame, at rest.
    pub(crate) fn spawn(&mut self, robot: &RobotDef, pose: &Pose) -> RobotBodies {
        let bodies = if robot.drive_model == DriveModel::Bodies {
            self.spawn_multibody(robot, pose)
        } else {
            self.spawn_rigid(robot, pose)
        };
        self.enter_queries(&bodies);
        bodies
    }

    /// Colliders enter the engine's tree with its next step only. Rays and the next robot that is spawned have to meet them
    /// at once, however many are spawned between two steps.
    fn enter_queries(&mut self, bodies: &RobotBodies) {
        let PhysicsWorld { broad_phase, integration_parameters, colliders, bodies: engine, .. } = &mut self.world;
        for body in bodies.all.iter().filter_map(|&body| engine.get(body)) {
            for &handle in body.colliders() {
                if let Some(collider) = colliders.get(handle) {
                    broad_phase.set_aabb(integration_parameters, handle, collider.compute_aabb());
                }
            }
        }
    }

    fn spawn_multibody(&mut self, robot: &RobotDef, pose: &Pose) -> RobotBodies {
        let mass = robot.body_mass();
        // The engine moves the origin of a multibody's root with the velocity of its centre of mass, so they have to be one.
        let centre = mass.centre;
        let centred = Mass { centre: Vector3::zeros(), ..mass };
        let chassis = self.insert_chassis(&(pose * Translation3::from(centre)), robot, centre, centred);
        let (mut all, mut joints) = (vec![chassis], Vec::new());
        let (mut roller_damping, mut treads) = (Vec::new(), Vec::new());
        for wheel in &robot.wheels {
            let before = all.len();
            self.insert_wheel(pose, wheel, &centre, &mut all, &mut joints, &mut roller_damping);
            let bodies = all[before..].iter().filter_map(|&body| self.world.bodies.get(body));
            let colliders = bodies.flat_map(|body| body.colliders().iter().copied()).collect();
            treads.push(Tread { colliders, resistance: Vector3::zeros() });
        }
        self.set_joint_parameters(robot, &joints, &roller_damping);
        let wheel = |joint| MultibodyWheel { joint, servo: Servo::default() };
        let driven = joints.into_iter().map(wheel).collect();
        let drivetrain = Drivetrain::Multibody { driven, treads };
        RobotBodies { chassis, centre, all, drivetrain }
    }

    fn spawn_rigid(&mut self, robot: &RobotDef, pose: &Pose) -> RobotBodies {
        let mass = robot.total_mass();
        let chassis = self.insert_chassis(pose, robot, Vector3::zeros(), mass);
        for caster in robot.wheels.iter().filter(|wheel| wheel.drive.is_none()) {
            let ball = with_material(ColliderBuilder::ball(caster.radius), &caster.material).friction(0.0);
            let ball = ball.translation(convert::vector(caster.position)).density(0.0);
            self.world.insert_collider(ball, Some(chassis));
        }
        // The wheels are only seen, by rays and by the wheels of others. As one collider they cost one box a step.
        let disc = |wheel: &Wheel| {
            let cylinder = SharedShape::cylinder(wheel.width / 2.0, wheel.radius);
            (EnginePose::from_translation(convert::vector(wheel.position)), cylinder)
        };
        let discs = SharedShape::compound(robot.driven().iter().map(disc).collect());
        let discs = ColliderBuilder::new(discs).collision_groups(InteractionGroups::none()).density(0.0);
        self.world.insert_collider(discs, Some(chassis));
        if let Some(body) = self.world.bodies.get_mut(chassis) {
            // Gravity comes in with the forces of the wheels.
            body.set_gravity_scale(0.0, false);
        }
        let base = RigidBase::new(chassis, robot, mass, *pose);
        RobotBodies {
            chassis,
            centre: Vector3::zeros(),
            all: vec![chassis],
            drivetrain: Drivetrain::Rigid(Box::new(base)),
        }
    }

    /// The chassis with its shapes; `centre` is the place of the body's origin in the robot frame.
    fn insert_chassis(&mut self, pose: &Pose, robot: &RobotDef, centre: Vector3<f64>, mass: Mass) -> RigidBodyHandle {
        let chassis = self.insert_body(pose, convert::mass(&mass));
        for solid in &robot.solids {
            let local = Translation3::from(-centre) * solid.pose();
            let collider = shape::collider(&solid.shape, &local, &solid.material);
            self.world.insert_collider(collider, Some(chassis));
        }
        chassis
    }

    /// Takes a robot out of the world.
    ///
    /// The engine forgets what a removed collider was near to only if no other one has taken its place by the next step;
    /// otherwise it keeps that for ever. So something that touches nothing takes the places until then.
    pub(crate) fn remove(&mut self, bodies: &RobotBodies) {
        let mut places = 0;
        for &body in bodies.all.iter().rev() {
            places += self.world.remove_body_with_colliders(body, true).map_or(0, |body| body.colliders().len());
        }
        for _ in 0..places {
            let placeholder = ColliderBuilder::ball(0.001).translation(FAR_AWAY).enabled(false);
            self.placeholders.push(self.world.insert_collider(placeholder, None));
        }
    }

    /// Gives a robot's motors and wheels their part in the coming step. A base of one body is only solved for, so that
    /// every robot sees the others as the last step left them.
    pub(crate) fn before_step(&mut self, robot: &RobotDef, bodies: &mut RobotBodies) {
        match &mut bodies.drivetrain {
            Drivetrain::Multibody { driven, treads } => {
                self.reset_forces(&bodies.all);
                self.set_motors(robot, driven);
                self.set_rolling_resistance(robot, bodies.chassis, bodies.centre, treads);
            }
            Drivetrain::Rigid(base) => base.solve(&self.world),
        }
    }

    /// Solves anew for robots that stand on each other; to be called when every robot is solved for by itself.
    pub(crate) fn solve_touching<'a>(&self, robots: impl Iterator<Item = &'a mut RobotBodies>) {
        let mut bases: Vec<&mut RigidBase> = robots.filter_map(RobotBodies::base_mut).collect();
        solve_touching(&mut bases, self.world.integration_parameters.dt);
    }

    /// Gives the engine the velocity that was solved for; to be called when every robot is solved for.
    pub(crate) fn give_velocity(&mut self, bodies: &mut RobotBodies) {
        if let Some(base) = bodies.base_mut() {
            base.give_velocity(&mut self.world);
        }
    }

    /// Pushes what the robot's wheels push; to be called when every velocity is given, which would undo it.
    pub(crate) fn react(&mut self, bodies: &RobotBodies) {
        if let Drivetrain::Rigid(base) = &bodies.drivetrain {
            base.react(&mut self.world);
        }
    }

    /// Notes what the wheels of others push; to be called when all have.
    pub(crate) fn note_pushes(&self, bodies: &mut RobotBodies) {
        if let Some(base) = bodies.base_mut() {
            base.note_pushes(&self.world);
        }
    }

    /// Takes on what the step did to a base of one body.
    pub(crate) fn after_step(&self, bodies: &mut RobotBodies) {
        if let Some(base) = bodies.base_mut() {
            base.advance(&self.world);
        }
    }

    /// The driven wheels, in order.
    pub(crate) fn wheels(&self, bodies: &RobotBodies) -> Vec<WheelState> {
        match &bodies.drivetrain {
            Drivetrain::Multibody { driven, .. } => {
                driven.iter().map(|wheel| wheel_state(&self.world, wheel.joint)).collect()
            }
            Drivetrain::Rigid(base) => base.wheels().collect(),
        }
    }

    /// Ends the forces of the last step: rolling resistance, and what the wheels of others did.
    fn reset_forces(&mut self, bodies: &[RigidBodyHandle]) {
        for &handle in bodies {
            let pushed = |body: &RigidBody| body.user_force() != Vector::ZERO || body.user_torque() != Vector::ZERO;
            if self.world.bodies.get(handle).is_some_and(pushed)
                && let Some(body) = self.world.bodies.get_mut(handle)
            {
                body.reset_forces(false);
                body.reset_torques(false);
            }
        }
    }

    fn set_motors(&mut self, robot: &RobotDef, wheels: &mut [MultibodyWheel]) {
        let time_step = self.world.integration_parameters.dt;
        let motors = robot.driven().iter().filter_map(|wheel| wheel.drive.as_ref());
        for (MultibodyWheel { joint, servo }, motor) in wheels.iter_mut().zip(motors) {
            let WheelState { angle, speed } = wheel_state(&self.world, *joint);
            let Torque { at_rest, gain } = servo.torque(motor, angle, speed, time_step);
            if let Some((multibody, link)) = self.world.multibody_joints.get_mut(*joint)
                && let Some(link) = multibody.link_mut(link)
            {
                link.joint.data.set_motor_velocity(JointAxis::AngX, at_rest / gain, gain);
            }
        }
    }

    /// Gives the hubs their rolling resistance, and notices whether the robot falls: both follow from the loads.
    fn set_rolling_resistance(
        &mut self,
        robot: &RobotDef,
        chassis: RigidBodyHandle,
        centre: Vector3<f64>,
        treads: &mut [Tread],
    ) {
        let time_step = self.world.integration_parameters.dt;
        let fall = convert::from_vector(self.world.gravity) * time_step;
        let share = f64::from(robot.mass()) / treads.len() as f64;
        let loads: Vec<Load> = treads.iter().map(|tread| rolling::load(&self.world, &tread.colliders)).collect();
        let Some(chassis) = self.world.bodies.get_mut(chassis) else { return };
        let down = fall.normalize().dot(&convert::from_vector(chassis.linvel()));
        if FALLING_SPEEDS.contains(&down) && loads.iter().all(|load| load.normal == Vector3::zeros()) {
            self.landing = LANDING_TIME;
        }
        for ((wheel, load), tread) in robot.wheels.iter().zip(&loads).zip(treads) {
            let hub = chassis.position() * convert::vector(Vector3::from(wheel.position) - centre);
            let mut velocity = convert::from_vector(chassis.velocity_at_point(hub)) + fall;
            if wheel.drive.is_some() && wheel.rollers.is_none() {
                // A plain wheel rolls ahead; to the side it slides.
                let ahead = convert::from_vector(chassis.rotation() * Vector::X);
                velocity = ahead * ahead.dot(&velocity);
            }
            tread.resistance = rolling::impulse(load, velocity, share) / time_step;
            chassis.add_force_at_point(convert::vector(tread.resistance), hub, true);
        }
    }

    /// Whether every number of a robot is one. The engine holds a body whose state is none where it was last, which is no
    /// better.
    pub(crate) fn is_sound(&self, bodies: &RobotBodies) -> bool {
        let BodyState { pose, linear, angular } = self.body(bodies);
        let body = pose.translation.vector.iter().chain(pose.rotation.coords.iter()).chain(&linear).chain(&angular);
        let wheels = self.wheels(bodies);
        let wheels = wheels.iter().flat_map(|wheel| [wheel.angle, wheel.speed]);
        let held = self.world.quarantine();
        body.copied().chain(wheels).all(f64::is_finite)
            && !held.bodies().iter().any(|&body| bodies.contains(body))
            && !held.colliders().iter().any(|&collider| {
                let parent = self.world.colliders.get(collider).and_then(Collider::parent);
                parent.is_some_and(|body| bodies.contains(body))
            })
    }

    /// Pose and velocity of the robot frame.
    pub(crate) fn body(&self, bodies: &RobotBodies) -> BodyState {
        if let Drivetrain::Rigid(base) = &bodies.drivetrain {
            let (linear, angular) = base.velocity();
            return BodyState { pose: *base.pose(), linear, angular };
        }
        let body = &self.world.bodies[bodies.chassis];
        let pose = convert::from_pose(body.position()) * Translation3::from(-bodies.centre);
        let (linear, angular) = (convert::from_vector(body.linvel()), convert::from_vector(body.angvel()));
        BodyState { pose, linear: linear - angular.cross(&(pose.rotation * bodies.centre)), angular }
    }

    fn insert_body(&mut self, pose: &Pose, mass: MassProperties) -> RigidBodyHandle {
        let body = RigidBodyBuilder::dynamic().pose(convert::pose(pose));
        // The engine puts bodies to sleep below 0.4 m/s; a youBot drives at 0.05.
        self.world.insert_body(body.additional_mass_properties(mass).can_sleep(false))
    }

    fn insert_wheel(
        &mut self,
        robot: &Pose,
        wheel: &Wheel,
        centre: &Vector3<f64>,
        all: &mut Vec<RigidBodyHandle>,
        joints: &mut Vec<MultibodyJointHandle>,
        roller_damping: &mut Vec<Real>,
    ) {
        let chassis = all[0];
        let anchor = Pose::translation(wheel.position[0], wheel.position[1], wheel.position[2]);
        let pose = robot * anchor;
        let body = self.insert_body(&pose, convert::mass(&wheel.hub_mass()));
        all.push(body);
        let anchor = convert::vector(Vector3::from(wheel.position) - centre);
        let Some(motor) = &wheel.drive else {
            let ball = with_material(ColliderBuilder::ball(wheel.radius), &wheel.material).density(0.0);
            self.world.insert_collider(ball, Some(body));
            let joint = SphericalJointBuilder::new().local_anchor1(anchor);
            self.world.multibody_joints.insert(chassis, body, joint, true);
            return;
        };
        // A positive angle about the left (-y) rolls the robot forward: the axis of USARSim's wheel joints.
        let joint = RevoluteJointBuilder::new(-Vector::Y)
            .local_anchor1(anchor)
            .motor_velocity(0.0, motor.gain)
            .motor_max_force(motor.max_torque)
            .motor_model(MotorModel::ForceBased);
        joints.extend(self.world.multibody_joints.insert(chassis, body, joint, true));
        match &wheel.rollers {
            Some(rollers) => {
                roller_damping.extend(std::iter::repeat_n(rollers.damping, rollers.count as usize));
                self.insert_rollers(&pose, body, wheel.radius, rollers, all);
            }
            None => {
                let tread = ColliderBuilder::new(shape::tread(wheel.radius, wheel.width)).density(0.0);
                self.world.insert_collider(with_material(tread, &wheel.material), Some(body));
            }
        }
    }

    fn insert_rollers(
        &mut self,
        wheel: &Pose,
        wheel_body: RigidBodyHandle,
        wheel_radius: f64,
        rollers: &Rollers,
        all: &mut Vec<RigidBodyHandle>,
    ) {
        let roller_shape = shape::roller(rollers, wheel_radius);
        let inertia = rollers.inertia(wheel_radius);
        let mass = convert::mass(&Mass { mass: rollers.mass, centre: Vector3::zeros(), inertia });
        for index in 0..rollers.count {
            let local = rollers.pose(index);
            let body = self.insert_body(&(wheel * local), mass);
            all.push(body);
            let collider = with_material(ColliderBuilder::new(roller_shape.clone()), &rollers.material);
            self.world.insert_collider(collider.density(0.0), Some(body));
            let mut joint = RevoluteJointBuilder::new(Vector::X).build();
            joint.data.set_local_frame1(convert::pose(&local));
            self.world.multibody_joints.insert(wheel_body, body, joint, true);
        }
    }

    /// The robot does not collide with itself (the thesis lists 81 disabled pairs, all within one robot;
    /// collision groups could not tell 64 robots apart). Damping: by default the engine brakes every turning
    /// joint with 0.1 N m s/rad, far too much for a roller, so each is set: 0 for wheels, theirs for rollers.
    fn set_joint_parameters(&mut self, robot: &RobotDef, joints: &[MultibodyJointHandle], roller_damping: &[Real]) {
        let Some(&first) = joints.first() else { return };
        let Some((multibody, _)) = self.world.multibody_joints.get_mut(first) else { return };
        multibody.set_self_contacts_enabled(false);
        let driven = robot.driven().len();
        let (mut wheels, mut rollers) = (Vec::new(), Vec::new());
        for link in multibody.links() {
            match link.parent_id().and_then(|parent| multibody.link(parent)) {
                Some(parent) if parent.is_root() => wheels.push(link.assembly_id()),
                Some(_) => rollers.push(link.assembly_id()),
                None => {}
            }
        }
        for (&degree_of_freedom, wheel) in wheels.iter().take(driven).zip(robot.driven()) {
            let armature = wheel.drive.as_ref().map_or(0.0, |motor| motor.armature);
            multibody.armature_mut()[degree_of_freedom] = armature;
        }
        let damping = multibody.damping_mut();
        damping.fill(0.0);
        if let Some(solid) = robot.solids.first() {
            // Damping of a velocity by d per second is a force of d times the mass, a torque of d times the inertia.
            let body = robot.body_mass();
            damping.rows_mut(0, 3).fill(solid.material.linear_damping * body.mass);
            let inertia = body.inertia.trace() / 3.0;
            damping.rows_mut(3, 3).fill(solid.material.angular_damping * inertia);
        }
        for (&degree_of_freedom, &value) in rollers.iter().zip(roller_damping) {
            damping[degree_of_freedom] = value;
        }
    }
}

fn wheel_state(world: &PhysicsWorld, joint: MultibodyJointHandle) -> WheelState {
    let link = world.multibody_joints.get(joint).and_then(|(multibody, link)| Some((multibody, multibody.link(link)?)));
    let Some((multibody, link)) = link else { return WheelState::default() };
    let speed = multibody.joint_velocity(link).iter().next().map_or(0.0, |&speed| speed);
    WheelState { angle: link.joint.coords()[JointAxis::AngX as usize], speed }
}
