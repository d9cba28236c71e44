//! Pose from the wheels' angles, without noise. Slip is its only error (Odometry.uc:40-135).
//!
//! Skid robots use the foremost left and right wheels, as USARSim does, or the friction balance of all driven wheels. Omni robots send no
//! odometry in USARSim. Here they use the textbook Mecanum kinematics, as the real youBot's driver does, or those of finite rollers.

use base_motion::{Base, Model};
use gamebots_proto::command::Set;
use gamebots_proto::message::{ItemConf, Odometry, WheelsConf};
use kinematics::PlanarPose;
use scene::sensor::odometry::{Config, Reading};
use scene::{Drivetrain, RobotDef, SensorDef};

use super::{Effect, Mount, Sensor, State, View, floats};
use crate::WheelState;

#[derive(Clone)]
pub(crate) struct Mounted {
    name: String,
    scan_interval: f64,
    /// No odometry without it: the robot has no wheels that it could use.
    base: Option<Base>,
    pose: PlanarPose,
    last_angles: Vec<f64>,
}

pub(super) fn build(config: &Config, mount: Mount) -> Mounted {
    Mounted {
        name: mount.name.to_owned(),
        scan_interval: mount.scan_interval,
        base: base(mount.view.robot, config),
        pose: PlanarPose::default(),
        last_angles: angles(mount.view.wheels),
    }
}

fn base(robot: &RobotDef, config: &Config) -> Option<Base> {
    let is_true = match robot.drivetrain() {
        Drivetrain::Mecanum => config.finite_rollers,
        Drivetrain::Sides => config.sliding,
        // The encoders of its wheels do not say where it steers.
        Drivetrain::None | Drivetrain::Steered => return None,
    };
    Base::of(robot, if is_true { Model::True } else { Model::Ideal })
}

fn angles(wheels: &[WheelState]) -> Vec<f64> {
    wheels.iter().map(|wheel| wheel.angle).collect()
}

/// Returns the reading for the wire.
pub(super) fn wire(def: &SensorDef, reading: &Reading) -> Odometry {
    Odometry { name: def.name.clone(), pose: floats([reading.x, reading.y, reading.theta]) }
}

impl Sensor for Mounted {
    fn type_name(&self) -> &'static str {
        "Odometry"
    }

    fn sense(&mut self, view: &View) -> Option<super::Reading> {
        let angles = angles(view.wheels);
        let turned: Vec<f64> = angles.iter().zip(&self.last_angles).map(|(now, before)| now - before).collect();
        self.last_angles = angles;
        let displacement = self.base.as_ref().map(|base| base.displacement(&turned, &self.last_angles, [0.0; 2]));
        self.pose = self.pose.moved(displacement.unwrap_or_default(), 1.0);
        let PlanarPose { x, y, theta } = self.pose;
        Some(Reading { x, y, theta }.into())
    }

    /// Executes `RESET`: sets the pose to zero and keeps the reference angles of the wheels.
    fn set(&mut self, opcode: &str, _set: &Set, _view: &View) -> Effect {
        if opcode == "RESET" {
            self.pose = PlanarPose::default();
        }
        Effect::None
    }

    fn state(&mut self) -> State<'_> {
        let PlanarPose { x, y, theta } = &mut self.pose;
        let numbers = [x, y, theta].into_iter().chain(&mut self.last_angles).collect();
        State { numbers, ..State::default() }
    }

    fn conf(&self) -> ItemConf {
        WheelsConf { name: self.name.clone(), scan_interval: self.scan_interval as f32 }.into()
    }
}
