//! Pose from the wheels' angles, without noise. Slip is its only error (Odometry.uc:40-135).
//!
//! Skid robots use the foremost left and right wheels, as USARSim does, or the friction balance of all driven wheels. Omni robots send no
//! odometry in USARSim. Here they use the textbook Mecanum kinematics, as the real youBot's driver does, or those of finite rollers.

use gamebots_proto::command::Set;
use gamebots_proto::message::{ItemConf, Odometry, WheelsConf};
use kinematics::{FiniteRollers, Mecanum, PlanarPose, Skid, Twist};
use scene::sensor::odometry::{Config, Reading};
use scene::{Drivetrain, RobotDef, SensorDef, Side};

use super::{Effect, Mount, Sensor, State, View, floats};
use crate::{WheelState, mecanum, sliding};

#[derive(Clone)]
enum Base {
    Skid {
        kinematics: Skid,
        left: usize,
        right: usize,
    },
    /// The ground contacts of the driven wheels and their loads.
    Sliding(Vec<sliding::Place>),
    Omni(Mecanum),
    FiniteOmni(FiniteRollers),
    /// No odometry: the robot has no wheels that it could use.
    None,
}

#[derive(Clone)]
pub(crate) struct Mounted {
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
    match robot.drivetrain() {
        Drivetrain::Mecanum if config.finite_rollers => {
            mecanum::finite_rollers(robot).map_or(Base::None, Base::FiniteOmni)
        }
        Drivetrain::Mecanum => mecanum::textbook(robot).map_or(Base::None, Base::Omni),
        Drivetrain::None | Drivetrain::Steered => Base::None,
        Drivetrain::Sides if config.sliding => Base::Sliding(sliding::places(robot)),
        Drivetrain::Sides => {
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
        // Angles instead of speeds give a displacement instead of a twist, because time cancels out.
        let displacement = match &self.base {
            Base::Skid { kinematics, left, right } => kinematics.forward([turned[*left], turned[*right]]),
            Base::Sliding(places) => sliding::twist(places, &turned),
            Base::Omni(kinematics) => kinematics.forward(std::array::from_fn(|wheel| turned[wheel])),
            Base::FiniteOmni(kinematics) => {
                // The phase at the middle of the interval.
                let phase = |wheel: usize| kinematics.phase(wheel, self.last_angles[wheel] - turned[wheel] / 2.0);
                kinematics.forward(std::array::from_fn(|wheel| turned[wheel]), std::array::from_fn(phase))
            }
            Base::None => Twist::default(),
        };
        self.pose = self.pose.moved(displacement, 1.0);
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
