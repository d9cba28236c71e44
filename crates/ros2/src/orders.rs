//! Orders of other nodes to a robot: velocities, joints, grippers. They become commands of the protocol, so that logs have them.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use base_motion::{Base, Drive as Motion, Model};
use gamebots_proto::Command;
use gamebots_proto::command::{Drive, MultiDrive, Set};
use kinematics::Twist;
use ros2_topics::{Controller, Limit, Space, cdr, interfaces as ros, name};
use scene::{JointState, PawnId, RobotDef, Steering};
use served_world::{Entrance, Session};
use tokio::sync::watch;
use tokio::task::JoinHandle;
use tokio::time::{Instant, timeout};
use tracing::{info, warn};

use crate::clock::Clock;
use crate::node::{Incoming, Node};

/// Time without an order after which a robot that drives is stopped, as ros2_control's controllers do, s. It has to pass by the simulated
/// clock and by the real one, so that nodes may use either.
const TIMEOUT: f64 = 0.5;
/// Time between two looks at the clocks.
const TICK: Duration = Duration::from_millis(10);
/// Largest velocity that is taken, m/s and rad/s. Motors have limits of their own.
const FASTEST: f64 = 1000.0;
/// Keys of Mecanum wheels, in the order of their speeds.
const WHEELS: [&str; 4] = ["Front-Left", "Front-Right", "Back-Left", "Back-Right"];
/// Most points of a trajectory.
const MOST_POINTS: usize = 10_000;
/// Longest time of a trajectory, s.
const LONGEST: f64 = 3600.0;

/// Simulated time and what a robot's joints do now.
#[derive(Clone)]
pub(crate) struct Present {
    pub(crate) clock: Clock,
    pub(crate) joints: Arc<Mutex<Vec<JointState>>>,
}

impl Present {
    fn position(&self, joint: usize) -> Option<f64> {
        let joints = self.joints.lock().unwrap_or_else(PoisonError::into_inner);
        joints.get(joint).map(|joint| joint.position)
    }
}

/// The tasks that listen for a robot. They end with it.
pub(crate) struct Listening(Vec<JoinHandle<()>>);

impl Drop for Listening {
    fn drop(&mut self) {
        self.0.iter().for_each(JoinHandle::abort);
    }
}

/// A velocity in the robot's frame, z up: m/s and rad/s.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Velocity {
    linear: [f64; 3],
    yaw: f64,
}

impl Velocity {
    /// Reads a velocity; `None` if a number is not finite or too large.
    fn of(twist: &ros::Twist) -> Option<Self> {
        let ros::Twist { linear: ros::Vector3 { x, y, z }, angular } = twist;
        let all = [*x, *y, *z, angular.z];
        let is_good = all.iter().all(|it| it.abs() <= FASTEST);
        is_good.then_some(Self { linear: [*x, *y, *z], yaw: angular.z })
    }
}

/// The way from velocities to commands of a class of robots.
#[derive(Debug, Clone)]
pub(crate) struct Driver {
    steering: Steering,
    base: Option<Base>,
    /// Least limit of its driven wheels, rad/s.
    fastest: f64,
    /// Wheel speed of the protocol, rad/s.
    unit: f64,
    /// Limits ahead, to the left and of the turn.
    limits: [Limit; 3],
    /// Time without an order after which it stops, s; 0 for never.
    timeout: f64,
    /// Topic of its controller beside `cmd_vel`.
    topic: Option<String>,
}

impl Driver {
    /// Returns the driver of a class, with the numbers of a controller if there is one; `None` if it does not drive. `unit` is one
    /// wheel-speed unit of the protocol, rad/s.
    pub(crate) fn of(def: &RobotDef, controller: Option<&Controller>, unit: f64) -> Option<Self> {
        let base = match controller {
            Some(controller) => Some(controller.base(def)),
            None => Base::of(def, Model::True),
        };
        let limits = def.driven().filter_map(|wheel| wheel.drive).map(|motor| motor.max_speed);
        let fastest = limits.fold(f64::INFINITY, f64::min);
        let drives = base.is_some() && def.steering.is_on_wheels() || def.steering == Steering::Aerial;
        let limits = controller.map_or([Limit::NONE; 3], |controller| controller.limits);
        let timeout = controller.map_or(TIMEOUT, |controller| controller.timeout);
        let topic = controller.map(Controller::topics).map(|[topic, _]| topic);
        drives.then_some(Self { steering: def.steering, base, fastest, unit, limits, timeout, topic })
    }

    /// Returns the velocity after a time, s, on the way from one to another.
    fn next(&self, now: Velocity, wanted: Velocity, time: f64) -> Velocity {
        let [ahead, left, turn] = self.limits;
        let ([x, y, _], [wanted_x, wanted_y, z]) = (now.linear, wanted.linear);
        Velocity {
            linear: [ahead.next(x, wanted_x, time), left.next(y, wanted_y, time), z],
            yaw: turn.next(now.yaw, wanted.yaw, time),
        }
    }

    /// Returns wheel speeds, rad/s, in the unit of the protocol. Those out of reach are scaled down as a whole, which keeps their curve.
    fn within<const N: usize>(&self, speeds: [f64; N]) -> [f64; N] {
        let excess = speeds.iter().map(|speed| speed.abs() / self.fastest).fold(1.0, f64::max);
        speeds.map(|speed| speed / excess / self.unit)
    }

    fn command(&self, Velocity { linear: [x, y, z], yaw }: Velocity) -> Command {
        // On the wire, y is to the right and a turn is clockwise.
        let drive = Drive { normalized: Some(false), ..Drive::default() };
        if self.steering == Steering::Aerial {
            let drive = drive.with("LinearVelocity", x).with("LateralVelocity", -y).with("AltitudeVelocity", z);
            return Command::Drive(drive.with("RotationalVelocity", -yaw.to_degrees()));
        }
        let twist = Twist { forward: x, right: -y, clockwise: -yaw };
        Command::Drive(match self.base.as_ref().map(|base| base.drive(twist)) {
            Some(Motion::Sides(speeds)) => {
                let [left, right] = self.within(speeds);
                drive.with("Left", left).with("Right", right)
            }
            Some(Motion::Wheels(speeds)) => {
                let speeds = self.within(speeds);
                WHEELS.iter().zip(speeds).fold(drive, |drive, (wheel, speed)| drive.with(wheel, speed))
            }
            Some(Motion::Car { speed, steer: [front, rear] }) => {
                drive.with("Speed", speed / self.unit).with("FrontSteer", front).with("RearSteer", rear)
            }
            None => drive,
        })
    }
}

/// The joints of a robot that others can move.
#[derive(Debug, Clone, Default)]
struct Joints {
    /// Number among the joints that have a value, and name on the wire, by the name in ROS.
    by_name: BTreeMap<String, (usize, String)>,
    /// Names in ROS, in the robot's order.
    order: Vec<String>,
}

impl Joints {
    fn of(def: &RobotDef) -> Self {
        let mut joints = Self::default();
        for (number, link) in def.with_values().enumerate() {
            let has_motor = link.joint.as_ref().is_some_and(|joint| joint.drive.is_some());
            if has_motor && link.wheel.is_none() && link.steered_axle().is_none() {
                joints.order.push(name(&link.name));
                joints.by_name.insert(name(&link.name), (number, link.name.clone()));
            }
        }
        joints
    }

    /// Makes the command for targets by name, rad or m. Fails with the reason in words.
    fn command<'a>(&self, targets: impl Iterator<Item = (&'a String, f64)>) -> Result<Command, String> {
        let mut named = Vec::new();
        for (joint, target) in targets {
            let Some((_, wire)) = self.by_name.get(joint) else {
                return Err(format!("no joint `{joint}`: expected {}", self.order.join(", ")));
            };
            if !target.is_finite() {
                return Err(format!("joint `{joint}` to {target}: expected a finite number"));
            }
            named.push((wire.clone(), target));
        }
        Ok(Command::MultiDrive(MultiDrive { targets: named }))
    }
}

/// A trajectory that has been checked: times since its start, s, with a target for each of its joints.
#[derive(Debug, Clone, PartialEq)]
struct Trajectory {
    joints: Vec<String>,
    points: Vec<(f64, Vec<f64>)>,
}

impl Trajectory {
    fn of(message: ros::JointTrajectory, joints: &Joints) -> Result<Self, String> {
        let ros::JointTrajectory { joint_names, points, .. } = message;
        if let Some(unknown) = joint_names.iter().find(|joint| !joints.by_name.contains_key(*joint)) {
            return Err(format!("no joint `{unknown}`: expected {}", joints.order.join(", ")));
        }
        if points.len() > MOST_POINTS {
            return Err(format!("{} points: expected at most {MOST_POINTS}", points.len()));
        }
        let mut last = 0.0;
        let mut checked = Vec::with_capacity(points.len());
        for (number, point) in points.into_iter().enumerate() {
            let time = f64::from(point.time_from_start.sec) + f64::from(point.time_from_start.nanosec) * 1e-9;
            if !(last..=LONGEST).contains(&time) {
                return Err(format!("point {number} is at {time} s: expected {last} to {LONGEST}"));
            }
            let positions = point.positions;
            if positions.len() != joint_names.len() || positions.iter().any(|it| !it.is_finite()) {
                return Err(format!("point {number}: expected {} finite positions", joint_names.len()));
            }
            last = time;
            checked.push((time, positions));
        }
        Ok(Self { joints: joint_names, points: checked })
    }

    /// Returns the targets at a time since the start, s, on straight lines from the positions at the start.
    fn at(&self, time: f64, start: &[f64]) -> Vec<f64> {
        let next = self.points.iter().position(|(at, _)| *at > time);
        let before = match next {
            Some(0) => None,
            Some(next) => self.points.get(next - 1),
            None => self.points.last(),
        };
        let (from, begin) = before.map_or((0.0, start), |(at, positions)| (*at, positions.as_slice()));
        match next.and_then(|next| self.points.get(next)) {
            None => begin.to_vec(),
            Some((until, goal)) => {
                let share = (time - from) / (until - from);
                begin.iter().zip(goal).map(|(begin, goal)| begin + share * (goal - begin)).collect()
            }
        }
    }

    fn ends(&self) -> f64 {
        self.points.last().map_or(0.0, |(time, _)| *time)
    }
}

/// Listens for a robot on the topics that its class can follow.
pub(crate) fn listen(
    robot: u64,
    def: &RobotDef,
    space: &Space,
    driver: Option<Driver>,
    node: &mut Node,
    entrance: &Entrance,
    present: &Present,
) -> Listening {
    let mut tasks = Vec::new();
    // A session of its own, so that a robot that is ordered much waits for its own orders alone. None if the world ends.
    let session = || entrance.open_program("ROS 2").ok();
    let pawn = PawnId(robot);
    if let Some((driver, session)) = driver.zip(session()) {
        let (send, wanted) = watch::channel(Velocity::default());
        for topic in std::iter::once("cmd_vel").chain(driver.topic.as_deref()) {
            let topic = space.topic(topic);
            for incoming in [node.listen::<ros::Twist>(&topic), node.listen::<ros::TwistStamped>(&topic)] {
                tasks.push(tokio::spawn(hear_velocities(incoming, send.clone(), topic.clone())));
            }
        }
        tasks.push(tokio::spawn(drive(session, pawn, driver, wanted, present.clone())));
    }
    let joints = Joints::of(def);
    if let Some(session) = Some(session).filter(|_| !joints.order.is_empty()).and_then(|session| session()) {
        let (send, wanted) = watch::channel(None);
        let hear = |topic: &str, read: fn(&[u8], &Joints) -> Result<Trajectory, String>| {
            let (topic, joints, send) = (space.topic(topic), joints.clone(), send.clone());
            move |incoming| tokio::spawn(hear_joints(incoming, topic, joints, read, send))
        };
        let trajectories = node.listen::<ros::JointTrajectory>(&space.topic("joint_trajectory"));
        tasks.push(hear("joint_trajectory", of_trajectory)(trajectories));
        let states = node.listen::<ros::JointState>(&space.topic("joint_commands"));
        tasks.push(hear("joint_commands", of_states)(states));
        let arrays = node.listen::<ros::Float64MultiArray>(&space.topic("commands"));
        tasks.push(hear("commands", of_array)(arrays));
        tasks.push(tokio::spawn(follow(session, pawn, joints.clone(), wanted, present.clone())));
    }
    if !def.grippers.is_empty()
        && let Some(session) = session()
    {
        let incoming = node.listen::<ros::Bool>(&space.topic("gripper"));
        tasks.push(tokio::spawn(grip(session, pawn, incoming)));
    }
    Listening(tasks)
}

/// Reads a message, and says once a topic that one is wrong.
struct Complaints(String, bool);

impl Complaints {
    fn add(&mut self, why: &dyn std::fmt::Display) {
        if !std::mem::replace(&mut self.1, true) {
            warn!("ROS 2: {}: {why}; further mistakes there are not logged", self.0);
        }
    }
}

/// Hands on the newest velocity of a topic. Readers of both types may see a message: its length tells its type.
async fn hear_velocities(mut incoming: Incoming, wanted: watch::Sender<Velocity>, topic: String) {
    let mut complaints = Complaints(topic, false);
    while let Some((_, bytes)) = incoming.recv().await {
        let plain = cdr::read::<ros::Twist>(&bytes).ok().filter(|_| bytes.len() <= TWIST_BYTES);
        let twist = plain.or_else(|| cdr::read::<ros::TwistStamped>(&bytes).ok().map(|stamped| stamped.twist));
        match twist.as_ref().and_then(Velocity::of) {
            Some(velocity) => _ = wanted.send(velocity),
            None => complaints.add(&format!("a velocity that is none, or beyond {FASTEST}")),
        }
        tokio::task::yield_now().await;
    }
}

/// Length of a Twist: six numbers of 64 bits. A TwistStamped is longer.
const TWIST_BYTES: usize = 48;

/// Drives a robot as is wanted, within its driver's limits, and stops it when nothing has been wanted for a while.
async fn drive(
    session: Session,
    pawn: PawnId,
    driver: Driver,
    mut wanted: watch::Receiver<Velocity>,
    present: Present,
) {
    let (mut goal, mut now) = (Velocity::default(), Velocity::default());
    // Real and simulated time of the last order, and simulated time of the last velocity.
    let (mut at, mut since, mut last) = (Instant::now(), 0.0, 0.0);
    loop {
        let is_idle = goal == Velocity::default() && now == goal;
        let changed = if is_idle { Ok(wanted.changed().await) } else { timeout(TICK, wanted.changed()).await };
        let is_ordered = match changed {
            Ok(Ok(())) => true,
            Ok(Err(_)) => return,
            Err(_) => false,
        };
        let (real, time) = (Instant::now(), present.clock.time());
        if is_ordered {
            (goal, at, since) = (*wanted.borrow_and_update(), real, time);
        }
        // A time that goes back is that of a fresh world.
        let is_over = (real - at).as_secs_f64() >= driver.timeout && !(0.0..driver.timeout).contains(&(time - since));
        if is_over && driver.timeout > 0.0 && goal != Velocity::default() {
            info!("ROS 2: robot {} is stopped: no cmd_vel for {} s", pawn.0, driver.timeout);
            goal = Velocity::default();
        }
        let next = driver.next(now, goal, if is_idle { 0.0 } else { (time - last).max(0.0) });
        last = time;
        if (next != now || is_ordered) && session.order_to(pawn, driver.command(next)).await.is_err() {
            return;
        }
        now = next;
    }
}

fn of_trajectory(bytes: &[u8], joints: &Joints) -> Result<Trajectory, String> {
    let message = cdr::read::<ros::JointTrajectory>(bytes).map_err(|error| error.to_string())?;
    Trajectory::of(message, joints)
}

fn of_states(bytes: &[u8], joints: &Joints) -> Result<Trajectory, String> {
    let ros::JointState { name, position, .. } =
        cdr::read::<ros::JointState>(bytes).map_err(|error| error.to_string())?;
    at_once(name, position, joints)
}

fn of_array(bytes: &[u8], joints: &Joints) -> Result<Trajectory, String> {
    let message = cdr::read::<ros::Float64MultiArray>(bytes).map_err(|error| error.to_string())?;
    at_once(joints.order.clone(), message.data, joints)
}

/// Makes the trajectory that is at its end at once.
fn at_once(names: Vec<String>, positions: Vec<f64>, joints: &Joints) -> Result<Trajectory, String> {
    let point = ros::JointTrajectoryPoint { positions, ..ros::JointTrajectoryPoint::default() };
    let message = ros::JointTrajectory { joint_names: names, points: vec![point], ..ros::JointTrajectory::default() };
    Trajectory::of(message, joints)
}

/// Hands on the newest trajectory of a topic.
async fn hear_joints(
    mut incoming: Incoming,
    topic: String,
    joints: Joints,
    read: fn(&[u8], &Joints) -> Result<Trajectory, String>,
    wanted: watch::Sender<Option<Trajectory>>,
) {
    let mut complaints = Complaints(topic, false);
    while let Some((_, bytes)) = incoming.recv().await {
        match read(&bytes, &joints) {
            Ok(trajectory) => _ = wanted.send(Some(trajectory)),
            Err(why) => complaints.add(&why),
        }
        tokio::task::yield_now().await;
    }
}

/// Moves joints along the newest trajectory, by the simulated clock.
async fn follow(
    session: Session,
    pawn: PawnId,
    joints: Joints,
    mut wanted: watch::Receiver<Option<Trajectory>>,
    present: Present,
) {
    while wanted.changed().await.is_ok() {
        let Some(trajectory) = wanted.borrow_and_update().clone() else { continue };
        let (began, number) = (present.clock.time(), |joint| joints.by_name.get(joint).map(|(number, _)| *number));
        let now = |joint| number(joint).and_then(|number| present.position(number)).unwrap_or_default();
        let start: Vec<f64> = trajectory.joints.iter().map(now).collect();
        let mut last = None;
        while matches!(wanted.has_changed(), Ok(false)) {
            let time = present.clock.time() - began;
            // A time that goes back is that of a fresh world.
            let time = if time < 0.0 { trajectory.ends() } else { time };
            if last != Some(time) {
                last = Some(time);
                let targets = trajectory.at(time, &start);
                let command = joints.command(trajectory.joints.iter().zip(targets));
                let Ok(command) = command else { break };
                if session.order_to(pawn, command).await.is_err() {
                    return;
                }
            }
            if time >= trajectory.ends() {
                break;
            }
            tokio::time::sleep(TICK).await;
        }
    }
}

/// Closes and opens the robot's grippers.
async fn grip(session: Session, pawn: PawnId, mut incoming: Incoming) {
    while let Some((_, bytes)) = incoming.recv().await {
        let Ok(closes) = cdr::read::<ros::Bool>(&bytes) else { continue };
        let opcode = if closes.data { "Close" } else { "Open" }.to_owned();
        let set = Set { type_name: "Gripper".to_owned(), opcode, ..Set::default() };
        if session.order_to(pawn, Command::Set(set)).await.is_err() {
            return;
        }
        tokio::task::yield_now().await;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn joints(names: &[&str]) -> Joints {
        Joints {
            by_name: names
                .iter()
                .enumerate()
                .map(|(number, it)| ((*it).to_owned(), (number, (*it).to_owned())))
                .collect(),
            order: names.iter().map(|it| (*it).to_owned()).collect(),
        }
    }

    fn message(names: &[&str], points: &[(f64, &[f64])]) -> ros::JointTrajectory {
        let point = |(time, positions): &(f64, &[f64])| ros::JointTrajectoryPoint {
            positions: positions.to_vec(),
            time_from_start: ros::Duration { sec: *time as i32, nanosec: (time.fract() * 1e9) as u32 },
            ..ros::JointTrajectoryPoint::default()
        };
        let joint_names = names.iter().map(|it| (*it).to_owned()).collect();
        ros::JointTrajectory {
            joint_names,
            points: points.iter().map(point).collect(),
            ..ros::JointTrajectory::default()
        }
    }

    #[test]
    fn a_trajectory_goes_straight_from_point_to_point() {
        let known = joints(&["lift", "tilt"]);
        let points: [(f64, &[f64]); 2] = [(1.0, &[1.0, 0.0]), (3.0, &[0.0, 2.0])];
        let trajectory = Trajectory::of(message(&["lift", "tilt"], &points), &known).expect("a trajectory");
        for (time, expected) in [
            (0.0, [0.5, 0.5]),
            (0.5, [0.75, 0.25]),
            (1.0, [1.0, 0.0]),
            (2.0, [0.5, 1.0]),
            (3.0, [0.0, 2.0]),
            (9.0, [0.0, 2.0]),
        ] {
            assert_eq!(trajectory.at(time, &[0.5, 0.5]), expected, "{time}");
        }
    }

    #[test]
    fn a_wrong_trajectory_says_what_is_wrong() {
        let known = joints(&["lift", "tilt"]);
        let check = |names: &[&str], points: &[(f64, &[f64])], expected: &str| {
            let error = Trajectory::of(message(names, points), &known).expect_err("it is wrong");
            assert!(error.contains(expected), "{error}");
        };
        check(&["elbow"], &[], "no joint `elbow`: expected lift, tilt");
        check(&["lift"], &[(1.0, &[1.0, 2.0])], "point 0: expected 1 finite positions");
        check(&["lift"], &[(1.0, &[f64::NAN])], "point 0: expected 1 finite positions");
        check(&["lift"], &[(1.0, &[1.0]), (0.5, &[1.0])], "point 1 is at 0.5 s: expected 1 to 3600");
    }

    #[test]
    fn velocities_beyond_reason_are_none() {
        let twist = |x: f64| ros::Twist { linear: ros::Vector3 { x, ..Default::default() }, ..Default::default() };
        for (x, expected) in [(0.5, true), (f64::NAN, false), (f64::INFINITY, false), (1e9, false)] {
            assert_eq!(Velocity::of(&twist(x)).is_some(), expected, "{x}");
        }
    }
}
