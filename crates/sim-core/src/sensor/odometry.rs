//! Pose from the wheels' angles, without noise: slip is its only error (Odometry.uc:40-135).
//!
//! Skid robots use the foremost left and right wheels as USARSim does, or the balance of friction on all of them; omni robots, which USARSim left silent, the
//! textbook Mecanum kinematics as the real youBot's driver does, or those of finite rollers.

use gamebots_proto::command::Set;
use gamebots_proto::message::{ItemConf, Odometry, Reading, WheelsConf};
use kinematics::{FiniteRollers, Mecanum, PlanarPose, Skid, Twist};
use scene::sensor::odometry::Config;
use scene::{RobotDef, Side, Steering};

use super::{Effect, Mount, Sensor, View};
use crate::{WheelState, mecanum, sliding};

enum Base {
    Skid {
        kinematics: Skid,
        left: usize,
        right: usize,
    },
    /// Where the wheels touch the ground and what they carry.
    Sliding(Vec<sliding::Place>),
    Omni(Mecanum),
    FiniteOmni(FiniteRollers),
    /// A robot without wheels to read.
    None,
}

pub(super) struct Mounted {
    name: String,
    scan_interval: f64,
    base: Base,
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

fn base(robot: &RobotDef, config: &Config) -> Base {
    match robot.steering {
        Steering::Omni if config.finite_rollers => mecanum::finite_rollers(robot).map_or(Base::None, Base::FiniteOmni),
        Steering::Omni => mecanum::textbook(robot).map_or(Base::None, Base::Omni),
        Steering::Ackermann | Steering::Aerial | Steering::Legged | Steering::None => Base::None,
        Steering::Skid if config.sliding => Base::Sliding(sliding::places(robot)),
        Steering::Skid => {
            let foremost = |side| {
                let on_side = robot.driven().enumerate().filter(|(_, wheel)| wheel.side == side);
                on_side.max_by(|a, b| a.1.position[0].total_cmp(&b.1.position[0]))
            };
            let (Some((left, _)), Some((right, wheel))) = (foremost(Side::Left), foremost(Side::Right)) else {
                return Base::None;
            };
            Base::Skid { kinematics: Skid { wheel_radius: wheel.radius, track: 2.0 * wheel.position[1] }, left, right }
        }
    }
}

fn angles(wheels: &[WheelState]) -> Vec<f64> {
    wheels.iter().map(|wheel| wheel.angle).collect()
}

impl Sensor for Mounted {
    fn type_name(&self) -> &'static str {
        "Odometry"
    }

    fn sense(&mut self, view: &View) -> Option<Reading> {
        let angles = angles(view.wheels);
        let turned: Vec<f64> = angles.iter().zip(&self.last_angles).map(|(now, before)| now - before).collect();
        self.last_angles = angles;
        // Turned angles in place of speeds give a displacement in place of a twist: time cancels out.
        let displacement = match &self.base {
            Base::Skid { kinematics, left, right } => kinematics.forward([turned[*left], turned[*right]]),
            Base::Sliding(places) => sliding::twist(places, &turned),
            Base::Omni(kinematics) => kinematics.forward(std::array::from_fn(|wheel| turned[wheel])),
            Base::FiniteOmni(kinematics) => {
                // Half-way through the interval.
                let phase = |wheel: usize| kinematics.phase(wheel, self.last_angles[wheel] - turned[wheel] / 2.0);
                kinematics.forward(std::array::from_fn(|wheel| turned[wheel]), std::array::from_fn(phase))
            }
            Base::None => Twist::default(),
        };
        self.pose = self.pose.moved(displacement, 1.0);
        let pose = [self.pose.x, self.pose.y, self.pose.theta].map(|number| number as f32);
        Some(Odometry { name: self.name.clone(), pose }.into())
    }

    /// `RESET` puts the pose to zero; the references of the wheels stay.
    fn set(&mut self, opcode: &str, _set: &Set, _view: &View) -> Effect {
        if opcode == "RESET" {
            self.pose = PlanarPose::default();
        }
        Effect::None
    }

    fn conf(&self) -> ItemConf {
        WheelsConf { name: self.name.clone(), scan_interval: self.scan_interval as f32 }.into()
    }
}
