//! Drive families, one file each. A family owns its keys of `DRIVE`, its targets for joints and body, and its fields of STA, CONF and
//! GEO. The maths is in the crate `kinematics`.

mod ackermann;
mod aerial;
mod ground;
mod omni;
mod skid;

use gamebots_proto::Problem;
use gamebots_proto::command::Drive;
use gamebots_proto::message::{GroundSta, Vehicle, VehicleConf, VehicleGeo};
use kinematics::Twist;
use scene::{JointState, RobotDef, Side, Steering};
use serde::{Deserialize, Serialize};

use crate::flight::Flight;

/// A robot's drive state, kept between two `DRIVE` lines.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DriveState {
    /// Target speeds of the driven wheels, rad/s, in the order of the robot's wheels.
    pub targets: Vec<f64>,
    /// True if the headlight is on.
    light: bool,
    /// True if numbers are percent of the limit. Sticky (BotConnection.uc:195-197).
    normalized: bool,
    family: Family,
}

/// State of a drive family.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
enum Family {
    Skid,
    /// Target velocities, held until a command replaces them.
    Omni(Twist),
    /// Commanded steering angles of front and rear, rad.
    Ackermann([f64; 2]),
    Aerial(Flight),
    /// Moved by its joints alone.
    Legged,
    /// Fixed to the ground.
    None,
}

impl DriveState {
    /// Returns the drive state of a robot at rest.
    pub fn new(robot: &RobotDef) -> Self {
        let family = match robot.steering {
            Steering::Skid => Family::Skid,
            Steering::Omni => Family::Omni(Twist::default()),
            Steering::Ackermann => Family::Ackermann([0.0; 2]),
            Steering::Aerial => Family::Aerial(Flight::default()),
            Steering::Legged => Family::Legged,
            Steering::None => Family::None,
        };
        Self { targets: vec![0.0; robot.driven().count()], light: false, normalized: false, family }
    }

    /// True if both are states of robots of one family with as many driven wheels.
    pub(crate) fn is_like(&self, other: &Self) -> bool {
        let family = |state: &Self| std::mem::discriminant(&state.family);
        self.targets.len() == other.targets.len() && family(self) == family(other)
    }

    /// Applies a command. `speed_unit` is one wheel-speed unit of the wire in rad/s.
    pub fn apply(&mut self, robot: &RobotDef, drive: &Drive, speed_unit: f64, problems: &mut Vec<Problem>) {
        self.normalized = drive.normalized.unwrap_or(self.normalized);
        self.light = drive.light.unwrap_or(self.light);
        let speeds = match &mut self.family {
            Family::Skid => skid::wheel_speeds(robot, drive, problems),
            Family::Omni(twist) => {
                if let Some(targets) = omni::follow_twist(twist, robot, drive, self.normalized, problems) {
                    self.targets = targets;
                }
                omni::wheel_speeds(robot, drive, problems)
            }
            Family::Ackermann(steer) => ackermann::wheel_speeds(steer, robot, drive, problems),
            Family::Aerial(flight) => return aerial::apply(flight, robot, drive, problems),
            Family::Legged | Family::None => {
                return problems.push(Problem::NotDriven { class: robot.class.clone() });
            }
        };
        for ((target, speed), wheel) in self.targets.iter_mut().zip(speeds).zip(robot.driven()) {
            if let (Some(speed), Some(motor)) = (speed, wheel.drive) {
                let unit = if self.normalized { motor.max_speed / 100.0 } else { speed_unit };
                *target = (speed * unit).clamp(-motor.max_speed, motor.max_speed);
            }
        }
    }

    /// Returns the target angles of joints other than wheels, rad, each with the joint's number among those that have a value.
    pub(crate) fn joint_targets(&self, robot: &RobotDef) -> Vec<(usize, f64)> {
        match &self.family {
            Family::Ackermann(steer) => ackermann::joint_targets(robot, *steer),
            _ => Vec::new(),
        }
    }

    /// Returns the targets of its flight; `None` if it does not fly.
    pub(crate) fn flight(&self) -> Option<Flight> {
        if let Family::Aerial(flight) = self.family { Some(flight) } else { None }
    }

    /// Returns its fields of STA.
    pub(crate) fn status(&self, robot: &RobotDef, joints: impl FnOnce() -> Vec<JointState>) -> Vehicle {
        match &self.family {
            Family::Skid | Family::Omni(_) => self.ground([None; 2]),
            Family::Ackermann(steer) => self.ground(steer.map(|angle| Some(angle as f32))),
            Family::Aerial(_) => Vehicle::Aerial,
            Family::Legged => {
                let joints = robot.with_values().zip(joints());
                Vehicle::Legged { joints: joints.map(|(link, it)| (link.name.clone(), it.position as f32)).collect() }
            }
            Family::None => Vehicle::Static,
        }
    }

    fn ground(&self, [front_steer, rear_steer]: [Option<f32>; 2]) -> Vehicle {
        Vehicle::Ground(GroundSta { light: self.light, front_steer, rear_steer })
    }
}

/// Returns a robot's fields of CONF. `speed_unit` is one wheel-speed unit of the wire in rad/s.
pub(crate) fn conf(robot: &RobotDef, speed_unit: f64) -> VehicleConf {
    match robot.steering {
        Steering::Skid | Steering::Omni => ground::conf(robot, speed_unit, None),
        Steering::Ackermann => ground::conf(robot, speed_unit, Some(ackermann::ranges(robot))),
        Steering::None => VehicleConf::Static,
        Steering::Aerial | Steering::Legged => VehicleConf::Plain,
    }
}

/// Returns a robot's fields of GEO.
pub(crate) fn geo(robot: &RobotDef) -> VehicleGeo {
    match robot.steering {
        Steering::Skid | Steering::Omni | Steering::Ackermann => ground::geo(robot),
        Steering::None => VehicleGeo::Static,
        Steering::Aerial | Steering::Legged => VehicleGeo::Plain,
    }
}

/// Returns the speed that `{Left ..}` or `{Right ..}` gives to a wheel on this side.
fn of_side([left, right]: [Option<f64>; 2], side: Side) -> Option<f64> {
    match side {
        Side::Left => left,
        Side::Right => right,
    }
}
