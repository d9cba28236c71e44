//! Copies of a world that are stepped together.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

use kinematics::Twist;
use scene::{BodyState, JointState, Reading, RobotDef, WheelState};
use sim_core::{Order, PawnId, World, in_parts};
use thread_pool::ThreadPool;

/// Number of worlds that a thread takes at a time.
const WORLDS_AT_A_TIME: usize = 8;
/// Maximum number of numbers in an array of a batch: 8 GB.
const MAX_NUMBERS: usize = 1 << 30;

/// Orders that a batch takes for each robot.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Orders {
    /// Target speed of each driven wheel, rad/s, in the robot's order.
    Wheels,
    /// Target velocities of a Mecanum base: forward, right, m/s, clockwise, rad/s.
    Twist,
    /// Target of each joint that is not a wheel, rad or m, in the order of the links.
    Joints,
    /// Wheels, then joints.
    WheelsAndJoints,
    /// Twist, then joints.
    TwistAndJoints,
}

impl Orders {
    /// Names of all kinds.
    pub const ALL: [(&str, Self); 5] = [
        ("wheels", Self::Wheels),
        ("twist", Self::Twist),
        ("joints", Self::Joints),
        ("wheels+joints", Self::WheelsAndJoints),
        ("twist+joints", Self::TwistAndJoints),
    ];

    fn has_wheels(&self) -> bool {
        matches!(self, Self::Wheels | Self::WheelsAndJoints)
    }

    fn has_twist(&self) -> bool {
        matches!(self, Self::Twist | Self::TwistAndJoints)
    }

    fn has_joints(&self) -> bool {
        matches!(self, Self::Joints | Self::WheelsAndJoints | Self::TwistAndJoints)
    }
}

impl FromStr for Orders {
    type Err = BatchError;

    fn from_str(name: &str) -> Result<Self, BatchError> {
        let known = Self::ALL.into_iter().find(|(known, _)| *known == name).map(|(_, orders)| orders);
        known.ok_or_else(|| BatchError::unknown("orders", name, Self::ALL.map(|(known, _)| known)))
    }
}

/// A group of columns of the observations.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Column {
    /// Position of the robot frame, 3 columns, m.
    Position,
    /// Orientation of the robot frame as a quaternion x, y, z, w.
    Orientation,
    /// Roll, pitch and yaw, rad.
    Rotation,
    /// Velocity of the frame's origin in world axes, 3 columns, m/s.
    Velocity,
    /// Angular velocity in world axes, 3 columns, rad/s.
    AngularVelocity,
    /// Position of every joint, wheels included, rad or m.
    JointPositions,
    /// Speed of every joint, wheels included, rad/s or m/s.
    JointSpeeds,
    /// Angle of every driven wheel, rad.
    WheelAngles,
    /// Speed of every driven wheel, rad/s.
    WheelSpeeds,
    /// Position and quaternion of every movable object, 7 columns each, by their ids. The same for all robots.
    Objects,
    /// The last reading of a sensor by its name, all of its quantities; 0 before the first.
    Sensor(String),
}

impl Column {
    /// Names of all groups but sensors, whose name follows `sensor:`.
    pub const ALL: [(&str, Self); 10] = [
        ("position", Self::Position),
        ("orientation", Self::Orientation),
        ("rotation", Self::Rotation),
        ("velocity", Self::Velocity),
        ("angular_velocity", Self::AngularVelocity),
        ("joint_positions", Self::JointPositions),
        ("joint_speeds", Self::JointSpeeds),
        ("wheel_angles", Self::WheelAngles),
        ("wheel_speeds", Self::WheelSpeeds),
        ("objects", Self::Objects),
    ];
}

impl FromStr for Column {
    type Err = BatchError;

    fn from_str(name: &str) -> Result<Self, BatchError> {
        if let Some(sensor) = name.strip_prefix("sensor:") {
            return Ok(Self::Sensor(sensor.to_owned()));
        }
        let known = Self::ALL.into_iter().find(|(known, _)| *known == name).map(|(_, column)| column);
        let names = Self::ALL.map(|(known, _)| known).into_iter().chain(["sensor:NAME"]);
        known.ok_or_else(|| BatchError::unknown("observation", name, names))
    }
}

impl fmt::Display for Column {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sensor(name) => write!(f, "sensor:{name}"),
            known => f.write_str(Self::ALL.iter().find(|(_, column)| column == known).map_or("", |(name, _)| name)),
        }
    }
}

/// Reasons why a batch cannot be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum BatchError {
    /// A name that does not exist.
    #[error("unknown {kind} `{got}`{meant}: expected one of {expected}")]
    Unknown {
        /// Kind of the name.
        kind: &'static str,
        /// The name.
        got: String,
        /// A suggestion, in words.
        meant: String,
        /// Names that exist.
        expected: String,
    },
    /// A robot cannot follow the orders.
    #[error("{class} takes no orders `{orders}`: {reason}")]
    NotDriven {
        /// Class of the robot.
        class: String,
        /// Name of the orders.
        orders: &'static str,
        /// Description of what is missing.
        reason: &'static str,
    },
    /// A sensor whose readings differ in length.
    #[error("sensor `{name}` of {class} has no reading of fixed length: {reason}")]
    NoReading {
        /// Name of the sensor.
        name: String,
        /// Class of the robot.
        class: String,
        /// Description of what is missing.
        reason: &'static str,
    },
    /// The world has no robots.
    #[error("the world has no robots: expected a world with all its robots")]
    NoRobots,
    /// An array of another size.
    #[error("{array}: got {got} numbers, expected {expected}")]
    Size {
        /// Name of the array.
        array: &'static str,
        /// Number of its numbers.
        got: usize,
        /// Number of numbers that it must have.
        expected: usize,
    },
    /// A batch that is too large.
    #[error(
        "got {worlds} worlds with {numbers} numbers each: expected at least one world, and at most {MAX_NUMBERS} numbers in all"
    )]
    TooLarge {
        /// Number of worlds.
        worlds: usize,
        /// Observations of a world.
        numbers: usize,
    },
    /// An order with a number that is not finite, or to a robot that is gone or has a flat battery.
    #[error(
        "orders to {worlds} worlds were not followed, first world {first}: a number is not finite, the robot is gone, or its battery is flat"
    )]
    NotFollowed {
        /// Number of such worlds.
        worlds: usize,
        /// The first of them.
        first: usize,
    },
    /// An episode that cannot begin, as there is no room for a robot.
    #[error("environment {environment}: no episode begins: {reason}")]
    NoRoom {
        /// Number of the environment.
        environment: usize,
        /// Problems of the robot, in words.
        reason: String,
    },
    /// A step before the first reset.
    #[error("environment {0} was never reset: expected a reset before the first step")]
    NotBegun(usize),
    /// An action that is not finite.
    #[error("environment {environment}: got an action of {got}, expected -1 to 1")]
    Action {
        /// Number of the environment.
        environment: usize,
        /// The action.
        got: f32,
    },
}

impl BatchError {
    fn unknown<'a>(kind: &'static str, got: &str, names: impl IntoIterator<Item = &'a str>) -> Self {
        let names: Vec<&str> = names.into_iter().collect();
        let meant = names::did_you_mean(got, names.iter().copied());
        Self::Unknown { kind, got: got.to_owned(), meant, expected: names.join(", ") }
    }
}

/// Layout of a robot's orders and observations.
#[derive(Debug, Clone)]
struct Layout {
    id: PawnId,
    /// Numbers of the joints that are no wheels, among those with a value.
    joints: Vec<usize>,
    driven: usize,
    /// Sensors by their numbers, each with its columns in the readings of all.
    sensors: Vec<(usize, Range<usize>)>,
    /// Its columns in a row, group by group.
    columns: Vec<Range<usize>>,
}

/// A copy of the world, with the last readings of the sensors that are observed.
#[derive(Clone)]
struct Member {
    world: World,
    readings: Vec<f64>,
    has_followed: bool,
}

/// One world's part of a step.
struct Job<'a> {
    member: &'a mut Member,
    orders: &'a [f64],
    row: &'a mut [f64],
}

/// Copies of a world that are stepped together. Their sensors measure if one of them is observed.
///
/// Orders are rows of [`WorldBatch::order_width`] numbers, a row a world, robot by robot in the order of their spawns. Observations are
/// rows of [`WorldBatch::observation_width`] numbers in the same order.
pub struct WorldBatch {
    first: Member,
    members: Vec<Member>,
    robots: Vec<Layout>,
    orders: Orders,
    columns: Vec<Column>,
    widths: [usize; 2],
    threads: ThreadPool,
}

impl WorldBatch {
    /// Creates copies of a world that has all its robots.
    ///
    /// # Errors
    /// When there is nothing to step, a robot cannot follow the orders, or a sensor is unknown or has no reading of fixed length.
    pub fn new(
        world: &World,
        worlds: usize,
        orders: Orders,
        columns: Vec<Column>,
        threads: ThreadPool,
    ) -> Result<Self, BatchError> {
        // One world goes through all intervals of its sensors, to learn the lengths of their readings.
        let mut trial = Trial::new(world, &columns);
        let (mut robots, mut readings) = (Vec::new(), 0);
        for (id, class, _) in world.robots() {
            let Some(def) = world.robot(id) else { continue };
            check_orders(&orders, def, class)?;
            let joints = def.with_values().enumerate().filter(|(_, link)| link.wheel.is_none());
            let mut sensors = Vec::new();
            for column in &columns {
                let Column::Sensor(name) = column else { continue };
                let sensor = sensor_number(def, name)?;
                let length = trial.length(def, id, sensor)?;
                sensors.push((sensor, readings..readings + length));
                readings += length;
            }
            let joints = joints.map(|(number, _)| number).collect();
            robots.push(Layout { id, joints, driven: def.driven().count(), sensors, columns: Vec::new() });
        }
        if robots.is_empty() {
            return Err(BatchError::NoRobots);
        }
        let mut quiet = world.clone();
        quiet.set_reporting(columns.iter().any(|column| matches!(column, Column::Sensor(_))));
        let first = Member { world: quiet, readings: vec![0.0; readings], has_followed: true };
        let order_width = robots.iter().map(|robot| robot.order_width(&orders)).sum();
        let mut width = 0;
        for robot in &mut robots {
            let seen = Observed::of(&first.world, robot.id, &columns);
            for group in 0..columns.len() {
                let begin = width;
                first.observe_group(robot, &seen, &columns, group, &mut |_| width += 1);
                robot.columns.push(begin..width);
            }
        }
        let widths = [order_width, width];
        if worlds == 0 || widths.iter().any(|width| width.saturating_mul(worlds) > MAX_NUMBERS) {
            return Err(BatchError::TooLarge { worlds, numbers: widths[1] });
        }
        let members = vec![first.clone(); worlds];
        Ok(Self { first, members, robots, orders, columns, widths, threads })
    }

    /// Returns the number of worlds.
    pub fn worlds(&self) -> usize {
        self.members.len()
    }

    /// Returns the length of a row of orders.
    pub fn order_width(&self) -> usize {
        self.widths[0]
    }

    /// Returns the length of a row of observations.
    pub fn observation_width(&self) -> usize {
        self.widths[1]
    }

    /// Returns the columns of each robot and group, in the order of a row: number of the robot, group, columns.
    pub fn layout(&self) -> Vec<(usize, Column, Range<usize>)> {
        let of_robot = |(number, robot): (usize, &Layout)| {
            let groups = self.columns.iter().cloned().zip(robot.columns.clone());
            groups.map(move |(column, range)| (number, column, range)).collect::<Vec<_>>()
        };
        self.robots.iter().enumerate().flat_map(of_robot).collect()
    }

    /// Returns a world. If no sensor is observed, its robots do not report until [`World::set_reporting`].
    pub fn world(&self, number: usize) -> Option<&World> {
        self.members.get(number).map(|member| &member.world)
    }

    /// Gives every world its orders, advances each by `steps` time steps, and writes the observations after them.
    ///
    /// # Errors
    /// When an array has another size; then nothing happens. When a world cannot follow its orders; it is stepped all the same.
    pub fn step(&mut self, orders: &[f64], steps: u32, observations: &mut [f64]) -> Result<(), BatchError> {
        self.check("orders", orders.len(), self.widths[0])?;
        self.check("observations", observations.len(), self.widths[1])?;
        let Self { members, robots, orders: kind, columns, widths, threads, .. } = self;
        let rows = orders.chunks_exact(widths[0].max(1)).chain(std::iter::repeat(&[][..]));
        let jobs = members.iter_mut().zip(rows).zip(rows_mut(observations, widths[1]));
        let mut jobs: Vec<Job> = jobs.map(|((member, orders), row)| Job { member, orders, row }).collect();
        let work = |jobs: &mut [Job]| {
            for Job { member, orders, row } in jobs {
                member.has_followed = member.follow(robots, kind, orders);
                (0..steps).for_each(|_| member.step(robots));
                member.write(robots, columns, row);
            }
        };
        threads.run(|| in_parts(threads, WORLDS_AT_A_TIME, &mut jobs, &work));
        let mut lazy = members.iter().enumerate().filter(|(_, member)| !member.has_followed);
        match lazy.next() {
            Some((first, _)) => Err(BatchError::NotFollowed { worlds: 1 + lazy.count(), first }),
            None => Ok(()),
        }
    }

    /// Puts worlds back to the state that they were copied from: those that `which` marks, or all. Writes the observations of every
    /// world.
    ///
    /// # Errors
    /// When an array has another size; then nothing happens.
    pub fn reset(&mut self, which: Option<&[bool]>, observations: &mut [f64]) -> Result<(), BatchError> {
        if let Some(which) = which {
            self.check("marks", which.len(), 1)?;
        }
        self.check("observations", observations.len(), self.widths[1])?;
        let is_marked = |number: usize| which.is_none_or(|which| which[number]);
        for (number, member) in self.members.iter_mut().enumerate() {
            if is_marked(number) {
                member.clone_from(&self.first);
            }
        }
        for (member, row) in self.members.iter().zip(rows_mut(observations, self.widths[1])) {
            member.write(&self.robots, &self.columns, row);
        }
        Ok(())
    }

    fn check(&self, array: &'static str, got: usize, width: usize) -> Result<(), BatchError> {
        let expected = width * self.members.len();
        if got == expected { Ok(()) } else { Err(BatchError::Size { array, got, expected }) }
    }
}

/// Returns rows of an array; empty ones if they have no width.
fn rows_mut(numbers: &mut [f64], width: usize) -> impl Iterator<Item = &mut [f64]> {
    numbers.chunks_exact_mut(width.max(1)).chain(std::iter::repeat_with(Default::default))
}

impl Layout {
    fn order_width(&self, orders: &Orders) -> usize {
        let wheels = if orders.has_wheels() { self.driven } else { 0 };
        let twist = if orders.has_twist() { 3 } else { 0 };
        wheels + twist + if orders.has_joints() { self.joints.len() } else { 0 }
    }
}

impl Member {
    /// Gives every robot its orders. Returns false if one does not follow.
    fn follow(&mut self, robots: &[Layout], kind: &Orders, mut orders: &[f64]) -> bool {
        let mut take = |count: usize| orders.split_off(..count).unwrap_or_default();
        let mut is_followed = true;
        for robot in robots {
            if kind.has_wheels() {
                let speeds = take(robot.driven).iter().copied().map(Some).collect();
                is_followed &= self.world.order(robot.id, &Order::Wheels(speeds));
            }
            if kind.has_twist()
                && let &[forward, right, clockwise] = take(3)
            {
                is_followed &= self.world.order(robot.id, &Order::Twist(Twist { forward, right, clockwise }));
            }
            if kind.has_joints() {
                let targets = robot.joints.iter().copied().zip(take(robot.joints.len()).iter().copied());
                is_followed &= self.world.order(robot.id, &Order::Joints(targets.collect()));
            }
        }
        is_followed
    }

    fn step(&mut self, robots: &[Layout]) {
        for (pawn, report) in self.world.step() {
            let sim_core::Report::Sensed(sensed) = report else { continue };
            let Some(robot) = robots.iter().find(|robot| robot.id == pawn) else { continue };
            for (_, columns) in robot.sensors.iter().filter(|(sensor, _)| *sensor == sensed.sensor) {
                let numbers = numbers(&sensed.reading);
                self.readings[columns.clone()].iter_mut().zip(numbers).for_each(|(place, number)| *place = number);
            }
        }
    }

    fn write(&self, robots: &[Layout], columns: &[Column], row: &mut [f64]) {
        for robot in robots {
            let seen = Observed::of(&self.world, robot.id, columns);
            for (group, range) in robot.columns.iter().enumerate() {
                let mut places = row[range.clone()].iter_mut();
                let push = &mut |number| places.next().into_iter().for_each(|place| *place = number);
                self.observe_group(robot, &seen, columns, group, push);
                // A robot or an object that is gone has no numbers.
                places.for_each(|place| *place = f64::NAN);
            }
        }
    }

    /// Pushes the numbers of one group of columns.
    fn observe_group(
        &self,
        robot: &Layout,
        Observed { body, wheels, joints }: &Observed,
        columns: &[Column],
        group: usize,
        push: &mut dyn FnMut(f64),
    ) {
        let body = body.as_ref();
        match &columns[group] {
            Column::Position => body.iter().for_each(|it| it.pose.translation.vector.iter().for_each(|n| push(*n))),
            Column::Orientation => body.iter().for_each(|it| it.pose.rotation.coords.iter().for_each(|n| push(*n))),
            Column::Rotation => {
                body.iter().for_each(|it| scene::position_and_rotation(&it.pose).1.into_iter().for_each(&mut *push));
            }
            Column::Velocity => body.iter().for_each(|it| it.linear.iter().for_each(|n| push(*n))),
            Column::AngularVelocity => body.iter().for_each(|it| it.angular.iter().for_each(|n| push(*n))),
            Column::JointPositions => joints.iter().for_each(|joint| push(joint.position)),
            Column::JointSpeeds => joints.iter().for_each(|joint| push(joint.speed)),
            Column::WheelAngles => wheels.iter().for_each(|wheel| push(wheel.angle)),
            Column::WheelSpeeds => wheels.iter().for_each(|wheel| push(wheel.speed)),
            Column::Objects => {
                for object in self.world.objects() {
                    let (position, rotation) = (object.pose.translation.vector, object.pose.rotation.coords);
                    position.iter().chain(rotation.iter()).for_each(|n| push(*n));
                }
            }
            Column::Sensor(_) => {
                let number = columns[..group].iter().filter(|it| matches!(it, Column::Sensor(_))).count();
                let readings = robot.sensors.get(number).map(|(_, columns)| columns.clone()).unwrap_or_default();
                self.readings[readings].iter().for_each(|n| push(*n));
            }
        }
    }
}

/// State of a robot, as far as it is observed.
struct Observed {
    body: Option<BodyState>,
    wheels: Vec<WheelState>,
    joints: Vec<JointState>,
}

impl Observed {
    fn of(world: &World, robot: PawnId, columns: &[Column]) -> Self {
        let has_joints = columns.iter().any(|it| matches!(it, Column::JointPositions | Column::JointSpeeds));
        let joints = if has_joints { world.joints(robot).unwrap_or_default() } else { Vec::new() };
        let (body, wheels) = world.state(robot).map_or((None, Vec::new()), |(body, wheels)| (Some(body), wheels));
        Self { body, wheels, joints }
    }
}

/// Returns the numbers of a reading, quantity by quantity.
pub(crate) fn numbers(reading: &Reading) -> impl Iterator<Item = f64> {
    reading.quantities().into_iter().flat_map(|quantity| quantity.values)
}

fn check_orders(orders: &Orders, def: &RobotDef, class: &str) -> Result<(), BatchError> {
    let refuse = |reason| {
        let name = Orders::ALL.into_iter().find(|(_, known)| known == orders).map_or("", |(name, _)| name);
        Err(BatchError::NotDriven { class: class.to_owned(), orders: name, reason })
    };
    if orders.has_wheels() && def.driven().next().is_none() {
        return refuse("it has no driven wheels");
    }
    if orders.has_twist() && base_motion::mecanum::textbook(def).is_none() {
        return refuse("it has no Mecanum base");
    }
    if orders.has_joints() && !def.with_values().any(|link| link.wheel.is_none()) {
        return refuse("it has no joints besides wheels");
    }
    Ok(())
}

fn sensor_number(def: &RobotDef, name: &str) -> Result<usize, BatchError> {
    let labels = def.sensor_labels();
    let known = labels.iter().position(|label| label.eq_ignore_ascii_case(name));
    known.ok_or_else(|| BatchError::unknown("sensor", name, labels.iter().map(String::as_str)))
}

/// A copy of the world that finds out how long the readings of sensors are.
struct Trial {
    lengths: Vec<(PawnId, usize, usize)>,
    has_varied: Vec<(PawnId, usize)>,
}

impl Trial {
    /// Longest interval of a sensor that is waited for, simulated s.
    const PATIENCE: f64 = 2.0;

    fn new(world: &World, columns: &[Column]) -> Self {
        let mut trial = Self { lengths: Vec::new(), has_varied: Vec::new() };
        if !columns.iter().any(|column| matches!(column, Column::Sensor(_))) {
            return trial;
        }
        let mut world = world.clone();
        let end = world.time() + Self::PATIENCE;
        while world.time() < end {
            for (pawn, report) in world.step() {
                let sim_core::Report::Sensed(sensed) = report else { continue };
                let length = numbers(&sensed.reading).count();
                match trial.lengths.iter().find(|(robot, sensor, _)| (*robot, *sensor) == (pawn, sensed.sensor)) {
                    Some((.., known)) if *known != length => trial.has_varied.push((pawn, sensed.sensor)),
                    Some(_) => {}
                    None => trial.lengths.push((pawn, sensed.sensor, length)),
                }
            }
        }
        trial
    }

    fn length(&mut self, def: &RobotDef, robot: PawnId, sensor: usize) -> Result<usize, BatchError> {
        let refuse = |reason| {
            let name = def.sensors.get(sensor).map_or(String::new(), |sensor| sensor.name.clone());
            Err(BatchError::NoReading { name, class: def.class.clone(), reason })
        };
        if self.has_varied.contains(&(robot, sensor)) {
            return refuse("the number of its values changes");
        }
        let known = self.lengths.iter().find(|(other, number, _)| (*other, *number) == (robot, sensor));
        match known {
            Some(&(.., length)) => Ok(length),
            None => refuse("it measured nothing within 2 s"),
        }
    }
}

#[cfg(test)]
mod tests {
    use gamebots_proto::command::Init;
    use scene::Options;

    use super::*;

    /// Only a fault removes a robot from a batch, so one is removed by hand.
    #[test]
    fn a_robot_that_is_gone_leaves_the_columns_of_the_others_in_place() {
        let def = scene_loader::load("rough", &[]).expect("a map");
        let mut world = World::new(def, Options::default());
        let mut spawn = |class: &str, y: f64| {
            let init = Init { class_name: class.to_owned(), location: [0.0, y, 0.0], ..Init::default() };
            world.init(&init, &mut Vec::new()).expect("a robot")
        };
        let [gone, stays] = [spawn("YouBot", 0.0), spawn("P3AT", 3.0)];
        let columns = vec![Column::Position, Column::WheelSpeeds];
        let batch = WorldBatch::new(&world, 1, Orders::Wheels, columns, ThreadPool::one());
        let mut batch = batch.expect("a batch");
        batch.members[0].world.remove(gone);
        let mut row = vec![0.0; batch.observation_width()];
        batch.members[0].write(&batch.robots, &batch.columns, &mut row);
        let (body, _) = world.state(stays).expect("a robot");
        assert!(row[..7].iter().all(|number| number.is_nan()), "{row:?}");
        assert_eq!(&row[7..10], body.pose.translation.vector.as_slice());
    }
}
