//! How robots move: one file a family, which owns its keys of `DRIVE`, what it asks of joints and body, and what it adds to STA,
//! CONF and GEO. The maths is in the crate `kinematics`.

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

use crate::flight::Flight;

/// What a robot remembers between two `DRIVE` lines.
#[derive(Debug, Clone, PartialEq)]
pub struct DriveState {
    /// Speeds of the driven wheels, rad/s, in the order of the robot's wheels.
    pub targets: Vec<f64>,
    /// Headlight.
    light: bool,
    /// Sticky: numbers are percent of the limit (BotConnection.uc:195-197).
    normalized: bool,
    family: Family,
}

/// What a family remembers.
#[derive(Debug, Clone, PartialEq)]
enum Family {
    Skid,
    /// Velocities held until they are replaced.
    Omni(Twist),
    /// Steering angles of front and rear as they were asked for, rad.
    Ackermann([f64; 2]),
    Aerial(Flight),
    /// Moved by its joints alone.
    Legged,
    /// Fixed to the ground.
    None,
}

impl DriveState {
    /// At rest.
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

    /// Takes a command. `speed_unit` is what one wheel-speed unit of the wire is in rad/s.
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

    /// Where joints beside those of wheels are to be: each by its number among those that have a value, rad.
    pub(crate) fn joint_targets(&self, robot: &RobotDef) -> Vec<(usize, f64)> {
        match &self.family {
            Family::Ackermann(steer) => ackermann::joint_targets(robot, *steer),
            _ => Vec::new(),
        }
    }

    /// How its body is to fly; `None` for one that does not.
    pub(crate) fn flight(&self) -> Option<Flight> {
        if let Family::Aerial(flight) = self.family { Some(flight) } else { None }
    }

    /// What it adds to STA.
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

/// What a robot adds to CONF; `speed_unit` is what one wheel-speed unit of the wire is in rad/s.
pub(crate) fn conf(robot: &RobotDef, speed_unit: f64) -> VehicleConf {
    match robot.steering {
        Steering::Skid | Steering::Omni => ground::conf(robot, speed_unit, None),
        Steering::Ackermann => ground::conf(robot, speed_unit, Some(ackermann::ranges(robot))),
        Steering::None => VehicleConf::Static,
        Steering::Aerial | Steering::Legged => VehicleConf::Plain,
    }
}

/// What a robot adds to GEO.
pub(crate) fn geo(robot: &RobotDef) -> VehicleGeo {
    match robot.steering {
        Steering::Skid | Steering::Omni | Steering::Ackermann => ground::geo(robot),
        Steering::None => VehicleGeo::Static,
        Steering::Aerial | Steering::Legged => VehicleGeo::Plain,
    }
}

/// The speed that `{Left ..}` or `{Right ..}` gives a wheel of this side.
fn of_side([left, right]: [Option<f64>; 2], side: Side) -> Option<f64> {
    match side {
        Side::Left => left,
        Side::Right => right,
    }
}
