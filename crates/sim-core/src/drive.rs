//! Drive families, one file each. A family owns its keys of `DRIVE`, its targets for joints and body, and its fields of STA, CONF and
//! GEO. The maths is in the crate `kinematics`.

mod ackermann;
mod aerial;
mod ground;
mod omni;
mod skid;

use gamebots_proto::command::{Drive, Given, ReadWrite};
use gamebots_proto::message::{GroundSta, Vehicle, VehicleConf, VehicleGeo};
use gamebots_proto::{Problem, shown};
use kinematics::Twist;
use scene::{JointState, Link, Motor, RobotDef, Side, Steering};
use serde::{Deserialize, Serialize};

use crate::flight::Flight;

/// Keys of DRIVE that every robot with a drive takes.
const FLAGS: [&str; 3] = ["Normalized", "Light", "Flip"];
/// Most problems of the keys of one line.
const MAX_REPORTED: usize = 5;

/// A robot's drive state, kept between two `DRIVE` lines.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(crate) struct DriveState {
    /// Target speeds of the driven wheels, rad/s, in the order of the robot's wheels.
    pub targets: Vec<f64>,
    /// True if the headlight is on.
    light: bool,
    /// True if numbers are percent of the limit. Sticky (BotConnection.uc:195-197).
    normalized: bool,
    family: Family,
}

/// An order to a robot, in SI units. DRIVE, MULTIDRIVE, ACT and SET of joints become orders; programs can give them directly.
#[derive(Debug, Clone, PartialEq)]
pub enum Order {
    /// Target speed of each driven wheel, rad/s, in the robot's order; `None` keeps a wheel's target. Forward is positive.
    Wheels(Vec<Option<f64>>),
    /// Target velocities of a Mecanum base.
    Twist(Twist),
    /// Steering angles of a car's front and rear axle, rad, positive to the right.
    Steer([f64; 2]),
    /// Targets of joints, rad or m, by their numbers among the joints that have a value.
    Joints(Vec<(usize, f64)>),
    /// Targets of an aerial robot.
    Flight(Flight),
}

impl Order {
    /// True if every number is finite.
    pub(crate) fn is_finite(&self) -> bool {
        match self {
            Self::Wheels(speeds) => speeds.iter().flatten().all(|speed| speed.is_finite()),
            Self::Twist(Twist { forward, right, clockwise }) => {
                [forward, right, clockwise].iter().all(|it| it.is_finite())
            }
            Self::Steer(angles) => angles.iter().all(|angle| angle.is_finite()),
            Self::Joints(targets) => targets.iter().all(|(_, target)| target.is_finite()),
            Self::Flight(Flight { velocity, turn, attitude }) => {
                velocity.iter().chain([turn]).chain(attitude).all(|it| it.is_finite())
            }
        }
    }
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
    pub(crate) fn new(robot: &RobotDef) -> Self {
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

    /// Returns the orders of a command, in the order in which they count. `speed_unit` is one wheel-speed unit of the wire in rad/s.
    /// Keeps what later commands refer to: the flags, and velocities that they do not name.
    pub(crate) fn read(
        &mut self,
        robot: &RobotDef,
        drive: &Drive,
        speed_unit: f64,
        problems: &mut Vec<Problem>,
    ) -> Vec<Order> {
        self.note_keys(robot, drive, problems);
        self.normalized = drive.normalized.unwrap_or(self.normalized);
        self.light = drive.light.unwrap_or(self.light);
        let mut orders = match &mut self.family {
            Family::Skid => vec![skid::order(robot, drive, problems)],
            Family::Omni(held) => {
                let twist = omni::twist(held, robot, drive, self.normalized, problems);
                twist.into_iter().chain([omni::wheels(robot, drive, problems)]).collect()
            }
            Family::Ackermann(_) => ackermann::orders(robot, drive, problems),
            Family::Aerial(flight) => aerial::order(*flight, robot, drive, problems).into_iter().collect(),
            Family::Legged | Family::None => {
                problems.push(Problem::NotDriven { class: robot.class.clone() });
                Vec::new()
            }
        };
        for order in &mut orders {
            let Order::Wheels(speeds) = order else { continue };
            for (speed, wheel) in speeds.iter_mut().zip(robot.driven()) {
                let unit = |motor: &Motor| if self.normalized { motor.max_speed / 100.0 } else { speed_unit };
                *speed = speed.zip(wheel.drive.map(unit)).map(|(speed, unit)| speed * unit);
            }
        }
        orders
    }

    /// Returns the keys of DRIVE that count for a robot, in the order in which messages list them; none if it has no drive.
    fn keys(&self) -> Vec<&'static str> {
        let own: &[&str] = match self.family {
            Family::Skid => &skid::KEYS,
            Family::Omni(_) => &omni::KEYS,
            Family::Ackermann(_) => &ackermann::KEYS,
            Family::Aerial(_) => &aerial::KEYS,
            Family::Legged | Family::None => return Vec::new(),
        };
        [own, &FLAGS].concat()
    }

    /// Reports the blocks of a command that do nothing for a robot.
    fn note_keys(&self, robot: &RobotDef, drive: &Drive, problems: &mut Vec<Problem>) {
        let known = self.keys();
        let own = |given: &Given| known.iter().copied().find(|key| given.is(key));
        let is_driven = drive.given.iter().any(|given| own(given).is_some());
        let is_flagged = drive.normalized.is_some() || drive.light.is_some() || drive.flip.is_some();
        if known.is_empty() {
            return;
        }
        if !is_flagged && drive.given.iter().all(|given| given.key().is_empty()) {
            problems.push(Problem::EmptyDrive { class: robot.class.clone(), expected: known.join(", ") });
        }
        let (mut seen, mut wrong): (Vec<&str>, Vec<&str>) = (Vec::new(), Vec::new());
        for given in &drive.given {
            if given.key().is_empty() || wrong.contains(&given.key()) {
                continue;
            }
            let ignored =
                |why: &str| Problem::Ignored { what: format!("{{{}}}", shown(given.key())), why: why.to_owned() };
            let problem = match own(given) {
                Some(_) if !given.has_value() => ignored("it has no value"),
                Some(key) if seen.contains(&key) => ignored("the first of a line counts"),
                // Wheels are told apart by their order, so their keys come again.
                Some(key) => {
                    seen.extend(Some(key).filter(|key| !key.starts_with("Wheel")));
                    continue;
                }
                // Programs stop robots of every kind by one line with all keys.
                None if is_driven && given.is_zero() && Drive::KEYS.iter().any(|key| given.is(key)) => continue,
                None => Problem::no_drive_key(&robot.class, given.key(), &known),
            };
            wrong.push(given.key());
            problems.push(problem);
            if wrong.len() == MAX_REPORTED {
                return;
            }
        }
    }

    /// Takes the targets of an order, within the limits of the motors or of the flight. Returns false if robots of this kind do not follow such orders.
    pub(crate) fn take(&mut self, robot: &RobotDef, order: &Order) -> bool {
        match (order, &mut self.family) {
            (Order::Wheels(speeds), Family::Skid | Family::Omni(_) | Family::Ackermann(_)) => {
                for ((target, speed), wheel) in self.targets.iter_mut().zip(speeds).zip(robot.driven()) {
                    if let (Some(speed), Some(motor)) = (speed, wheel.drive) {
                        *target = speed.clamp(-motor.max_speed, motor.max_speed);
                    }
                }
            }
            (Order::Twist(twist), Family::Omni(held)) => {
                *held = *twist;
                self.targets = omni::speeds(robot, *twist);
            }
            (Order::Steer(angles), Family::Ackermann(steer)) => *steer = *angles,
            (Order::Flight(targets), Family::Aerial(flight)) => {
                *flight = robot.footing.aerial().map_or(*flight, |it| targets.within(&it))
            }
            (Order::Joints(targets), _) => {
                let is_joint = |number| robot.with_values().nth(number).is_some_and(|link| link.wheel.is_none());
                return targets.iter().all(|&(number, _)| is_joint(number));
            }
            _ => return false,
        }
        true
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
            Family::Skid | Family::Omni(_) => self.ground([None; 2], robot, joints),
            Family::Ackermann(steer) => self.ground(steer.map(|angle| Some(angle as f32)), robot, joints),
            Family::Aerial(_) => Vehicle::Aerial,
            Family::Legged => {
                let joints = robot.with_values().zip(joints());
                Vehicle::Legged { joints: joints.map(|(link, it)| (link.name.clone(), it.position as f32)).collect() }
            }
            Family::None => Vehicle::Static,
        }
    }

    /// Returns the status of a robot on wheels, with the angles of its flippers.
    fn ground(
        &self,
        [front_steer, rear_steer]: [Option<f32>; 2],
        robot: &RobotDef,
        joints: impl FnOnce() -> Vec<JointState>,
    ) -> Vehicle {
        let mut flippers = robot.flippers().peekable();
        let joints = if flippers.peek().is_some() { joints() } else { Vec::new() };
        let angle = |(value, link): (usize, &Link)| Some((link.name.clone(), joints.get(value)?.position as f32));
        let ground = GroundSta { light: self.light, front_steer, rear_steer };
        Vehicle::Ground(ground, flippers.filter_map(angle).collect())
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
