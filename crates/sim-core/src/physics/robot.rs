//! A robot as bodies: one multibody of the chassis, its wheels and their rollers.

use std::f64::consts::TAU;

use nalgebra::{UnitQuaternion, Vector3};
use rapier3d::glamx::Mat3;
use rapier3d::prelude::*;

use super::{BodyState, Physics, WheelState, convert, shape, with_material};
use crate::scene::{Part, Pose, RobotDef, Rollers, Wheel};

/// The bodies of one robot.
pub(crate) struct RobotBodies {
    chassis: RigidBodyHandle,
    /// Every body, chassis first, for removal.
    all: Vec<RigidBodyHandle>,
    /// Joints of the driven wheels, in the order of the definition.
    driven: Vec<MultibodyJointHandle>,
    /// Angles of the driven wheels: kept in f64, where the engine's f32 would lose digits within minutes.
    angles: Vec<f64>,
    speeds: Vec<f64>,
}

impl RobotBodies {
    /// Whether a body is one of the robot's.
    pub(super) fn contains(&self, body: RigidBodyHandle) -> bool {
        self.all.contains(&body)
    }
}

impl Physics {
    /// Puts a robot at a pose of its frame, at rest.
    pub(crate) fn spawn(&mut self, robot: &RobotDef, pose: &Pose) -> RobotBodies {
        let chassis = self.insert_body(pose, robot.parts.iter().map(part_mass).sum());
        for solid in &robot.solids {
            let collider = shape::collider(&solid.shape, &solid.pose, &solid.material);
            self.world.insert_collider(collider, Some(chassis));
        }
        let mut bodies = RobotBodies { chassis, all: vec![chassis], driven: vec![], angles: vec![], speeds: vec![] };
        let mut roller_damping = Vec::new();
        for wheel in &robot.wheels {
            self.insert_wheel(pose, wheel, &mut bodies, &mut roller_damping);
        }
        bodies.angles = vec![0.0; bodies.driven.len()];
        bodies.speeds = vec![0.0; bodies.driven.len()];
        self.set_joint_parameters(robot, &bodies, &roller_damping);
        bodies
    }

    /// Takes a robot out of the world.
    pub(crate) fn remove(&mut self, bodies: &RobotBodies) {
        for &body in bodies.all.iter().rev() {
            self.world.remove_body_with_colliders(body, true);
        }
    }

    /// Sets the targets of the wheel servos, rad/s.
    pub(crate) fn set_wheel_speeds(&mut self, robot: &RobotDef, bodies: &RobotBodies, speeds: &[f64]) {
        let motors = robot.driven().iter().filter_map(|wheel| wheel.drive.as_ref());
        for ((&joint, &speed), motor) in bodies.driven.iter().zip(speeds).zip(motors) {
            if let Some((multibody, link)) = self.world.multibody_joints.get_mut(joint)
                && let Some(link) = multibody.link_mut(link)
            {
                link.joint.data.set_motor_velocity(JointAxis::AngX, speed as Real, motor.gain as Real);
            }
        }
    }

    /// Reads the wheels after a step.
    pub(crate) fn update_wheels(&self, bodies: &mut RobotBodies, time_step: f64) {
        for ((&joint, angle), speed) in bodies.driven.iter().zip(&mut bodies.angles).zip(&mut bodies.speeds) {
            if let Some((multibody, link)) = self.world.multibody_joints.get(joint)
                && let Some(link) = multibody.link(link)
            {
                *speed = multibody.joint_velocity(link).iter().next().map_or(0.0, |&speed| f64::from(speed));
                *angle += *speed * time_step;
            }
        }
    }

    /// Pose and velocity of the robot frame.
    pub(crate) fn body(&self, bodies: &RobotBodies) -> BodyState {
        let body = &self.world.bodies[bodies.chassis];
        BodyState {
            pose: convert::from_pose(body.position()),
            linear: convert::from_vector(body.velocity_at_point(body.translation())),
            angular: convert::from_vector(body.angvel()),
        }
    }

    /// The driven wheels, in order.
    pub(crate) fn wheels(&self, bodies: &RobotBodies) -> Vec<WheelState> {
        bodies.angles.iter().zip(&bodies.speeds).map(|(&angle, &speed)| WheelState { angle, speed }).collect()
    }

    fn insert_body(&mut self, pose: &Pose, mass: MassProperties) -> RigidBodyHandle {
        let body = RigidBodyBuilder::dynamic().pose(convert::pose(pose));
        // The engine puts bodies to sleep below 0.4 m/s; a youBot drives at 0.05.
        self.world.insert_body(body.additional_mass_properties(mass).can_sleep(false))
    }

    fn insert_wheel(&mut self, robot: &Pose, wheel: &Wheel, bodies: &mut RobotBodies, roller_damping: &mut Vec<Real>) {
        let anchor = Pose::translation(wheel.position[0], wheel.position[1], wheel.position[2]);
        let pose = robot * anchor;
        let body = self.insert_body(&pose, wheel_mass(wheel));
        bodies.all.push(body);
        let anchor = convert::vector(wheel.position);
        let Some(motor) = &wheel.drive else {
            let ball = with_material(ColliderBuilder::ball(wheel.radius as Real), &wheel.material).density(0.0);
            self.world.insert_collider(ball, Some(body));
            let joint = SphericalJointBuilder::new().local_anchor1(anchor);
            self.world.multibody_joints.insert(bodies.chassis, body, joint, true);
            return;
        };
        // A positive angle about the left (-y) rolls the robot forward: the axis of USARSim's wheel joints.
        let joint = RevoluteJointBuilder::new(-Vector::Y)
            .local_anchor1(anchor)
            .motor_velocity(0.0, motor.gain as Real)
            .motor_max_force(motor.max_torque as Real)
            .motor_model(MotorModel::ForceBased);
        bodies.driven.extend(self.world.multibody_joints.insert(bodies.chassis, body, joint, true));
        match &wheel.rollers {
            Some(rollers) => {
                roller_damping.extend(std::iter::repeat_n(rollers.damping as Real, rollers.count as usize));
                self.insert_rollers(&pose, body, wheel.radius, rollers, bodies);
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
        bodies: &mut RobotBodies,
    ) {
        let (mass, roller_shape) = (shape::roller_mass(rollers, wheel_radius), shape::roller(rollers, wheel_radius));
        for index in 0..rollers.count {
            let local = roller_pose(rollers, index);
            let body = self.insert_body(&(wheel * local), mass);
            bodies.all.push(body);
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
    fn set_joint_parameters(&mut self, robot: &RobotDef, bodies: &RobotBodies, roller_damping: &[Real]) {
        let Some(&first) = bodies.driven.first() else { return };
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
            multibody.armature_mut()[degree_of_freedom] = armature as Real;
        }
        let damping = multibody.damping_mut();
        damping.fill(0.0);
        if let Some(solid) = robot.solids.first() {
            // Damping of a velocity by d per second is a force of d times the mass.
            let body_mass: f64 = robot.parts.iter().map(|part| part.mass).sum();
            damping.rows_mut(0, 3).fill((solid.material.linear_damping * body_mass) as Real);
        }
        for (&degree_of_freedom, &value) in rollers.iter().zip(roller_damping) {
            damping[degree_of_freedom] = value;
        }
    }
}

/// Pose of a roller in the frame of its wheel, its axis along x. Roller k sits at the angle `k 2 pi / count` from the
/// front downward; its axis leans by the roller angle from the wheel's axis toward the direction of turning (thesis
/// Appendix A, lines 741 to 762).
fn roller_pose(rollers: &Rollers, index: u32) -> Pose {
    let (sin_angle, cos_angle) = rollers.angle.abs().sin_cos();
    let (sin, cos) = (TAU * f64::from(index) / f64::from(rollers.count)).sin_cos();
    let centre = Vector3::new(cos, 0.0, sin) * rollers.axis_circle;
    let tangent = Vector3::new(-sin, 0.0, cos);
    let axis = tangent * sin_angle - Vector3::y() * cos_angle * rollers.angle.signum();
    let turn = UnitQuaternion::rotation_between(&Vector3::x(), &axis);
    Pose::from_parts(centre.into(), turn.unwrap_or_default())
}

fn part_mass(part: &Part) -> MassProperties {
    let columns: [f32; 9] = std::array::from_fn(|index| part.inertia.as_slice()[index] as f32);
    MassProperties::with_inertia_matrix(
        convert::vector(part.centre),
        part.mass as Real,
        Mat3::from_cols_array(&columns),
    )
}

/// A plain wheel as a solid disc; the hub of a Mecanum wheel as a disc out to the roller axes.
fn wheel_mass(wheel: &Wheel) -> MassProperties {
    let radius = wheel.rollers.as_ref().map_or(wheel.radius, |rollers| rollers.axis_circle);
    let spin = wheel.mass * radius * radius / 2.0;
    let tilt = wheel.mass * (3.0 * radius * radius + wheel.width * wheel.width) / 12.0;
    let inertia = if wheel.drive.is_some() { [tilt, spin, tilt] } else { [0.4 * wheel.mass * radius * radius; 3] };
    MassProperties::new(Vector::ZERO, wheel.mass as Real, convert::vector(inertia))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Material;

    /// Places and axes of the six rollers of either handedness, worked out from the thesis's Appendix A by the rules
    /// of Unreal's rotators. Its ring has a radius of 0.0475 m.
    #[test]
    fn rollers_sit_and_point_as_in_the_thesis() {
        let material = Material::default();
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let table = [
            ([0.0475, 0.0], [0.0, -half, half]),
            ([0.02375, 0.04114], [-0.6124, -half, 0.3536]),
            ([-0.02375, 0.04114], [-0.6124, -half, -0.3536]),
            ([-0.0475, 0.0], [0.0, -half, -half]),
            ([-0.02375, -0.04114], [0.6124, -half, -0.3536]),
            ([0.02375, -0.04114], [0.6124, -half, 0.3536]),
        ];
        for sign in [1.0, -1.0] {
            let angle = sign * std::f64::consts::FRAC_PI_4;
            let material = material.clone();
            let rollers = Rollers {
                count: 6,
                axis_circle: 0.0475,
                angle,
                last_phase: std::f64::consts::PI / 6.0,
                mass: 0.1,
                damping: 0.0,
                material,
            };
            for (index, ([x, z], axis)) in (0..).zip(table) {
                let pose = roller_pose(&rollers, index);
                let place = pose.translation.vector - Vector3::new(x, 0.0, z);
                let direction = pose.rotation * Vector3::x() - Vector3::new(axis[0], sign * axis[1], axis[2]);
                assert!(place.norm() < 1e-4 && direction.norm() < 1e-3, "roller {index}, {sign}: {pose}");
            }
        }
    }
}
