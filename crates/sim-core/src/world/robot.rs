//! One robot in the world: its bodies, its drive, its sensors and their timers.

use std::sync::Arc;

use gamebots_proto::command::{Drive, MultiDrive, Set};
use gamebots_proto::message::{Message, Sta};
use gamebots_proto::{Problem, expected_of, shown};
use scene::{Pose, RobotDef, RobotSnapshot};
use serde::{Deserialize, Serialize};

use super::held::{Attachments, Hand};
use super::item::{self, Effect, Item, Motion, STATUS_INTERVAL};
use super::{Options, PawnId, Report};
use crate::WheelState;
use crate::drive::{DriveState, Order};
use crate::physics::{CompiledRobot, Physics, RobotBodies, SavedBodies};
use crate::sensor::{SavedState, TagOrder, View};

/// Battery level that STA reports without a battery (BaseVehicle.uc:106-109).
const NO_BATTERY: i32 = 99999;

#[derive(Clone)]
pub(super) struct Robot {
    id: PawnId,
    name: String,
    bodies: RobotBodies,
    drive: DriveState,
    items: Vec<Item>,
    spawned: u64,
    /// The step of its next report.
    next_report: u64,
    options: Options,
}

/// The outcome of a command to items.
#[derive(Default)]
pub(super) struct Outcome {
    /// Readings that go out at once.
    pub(super) reports: Vec<Report>,
    /// True if the robot has the item.
    pub(super) found: bool,
    /// Hands, each with true if it takes something, or false if it drops what it has.
    pub(super) hands: Vec<(Hand, bool)>,
    /// Changes of RFID tags.
    pub(super) tags: Vec<TagOrder>,
}

/// The state of a robot as plain data.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct SavedRobot {
    pub(super) id: PawnId,
    pub(super) class: String,
    pub(super) name: String,
    bodies: SavedBodies,
    drive: DriveState,
    items: Vec<SavedState>,
    spawned: u64,
}

impl Robot {
    /// Returns the state. `None` for a robot of the engine, which keeps part of its state to itself.
    pub(super) fn save(&self) -> Option<SavedRobot> {
        Some(SavedRobot {
            id: self.id,
            class: self.def().class.clone(),
            name: self.name.clone(),
            bodies: self.bodies.save()?,
            drive: self.drive.clone(),
            items: self.items.iter().map(Item::save).collect(),
            spawned: self.spawned,
        })
    }

    /// Inserts a robot with a saved state at the end of a step. `None` if the state is another class's.
    pub(super) fn load(
        physics: &mut Physics,
        class: Arc<CompiledRobot>,
        saved: &SavedRobot,
        step: u64,
        options: Options,
    ) -> Option<Self> {
        if saved.spawned > step {
            return None;
        }
        let mut robot =
            Self::spawn(physics, class, saved.name.clone(), &Pose::identity(), saved.id, saved.spawned, options);
        let fits = robot.items.len() == saved.items.len()
            && robot.items.iter_mut().zip(&saved.items).all(|(item, saved)| item.load(saved))
            && robot.drive.is_like(&saved.drive)
            && robot.bodies.load(&saved.bodies);
        robot.drive = saved.drive.clone();
        robot.next_report = robot.report_after(step);
        fits.then_some(robot)
    }

    pub(super) fn spawn(
        physics: &mut Physics,
        class: Arc<CompiledRobot>,
        name: String,
        pose: &Pose,
        id: PawnId,
        spawned: u64,
        options: Options,
    ) -> Self {
        let drive = DriveState::new(&class.def);
        let bodies = physics.spawn(class.clone(), id, pose);
        let mut robot = Self { id, name, bodies, drive, items: Vec::new(), spawned, next_report: 0, options };
        let wheels = physics.wheels(&robot.bodies);
        let view = view(id, &robot.bodies, physics, spawned as f64 * options.time_step, &wheels);
        robot.items = item::mount(&view, options);
        robot.next_report = robot.report_after(spawned);
        robot
    }

    pub(super) fn id(&self) -> PawnId {
        self.id
    }

    pub(super) fn def(&self) -> &RobotDef {
        &self.bodies.robot().def
    }

    pub(super) fn name(&self) -> &str {
        &self.name
    }

    pub(super) fn bodies(&self) -> &RobotBodies {
        &self.bodies
    }

    pub(super) fn bodies_mut(&mut self) -> &mut RobotBodies {
        &mut self.bodies
    }

    /// Tells its cameras the tiles of their pictures, by the numbers of the sensors.
    pub(super) fn set_tiles(&mut self, tile: impl Fn(usize) -> Option<usize>) {
        self.items.iter_mut().for_each(|item| item.set_tile(&tile));
    }

    /// Returns the items of a type with a name, both in any case. An empty name selects all of the type.
    pub(super) fn asked(&self, type_name: &str, name: &str) -> impl Iterator<Item = &Item> {
        self.items.iter().filter(move |item| item.is_asked(type_name, name))
    }

    pub(super) fn speed_unit(&self) -> f64 {
        self.options.speed_unit
    }

    /// Returns the whole seconds that the battery still lasts. They fall linearly from 0.1 s after the spawn. The battery is flat when less
    /// than one second is left (Battery.uc:45-135).
    pub(super) fn battery_left(&self, time: f64) -> i32 {
        let age = time - self.spawned as f64 * self.options.time_step;
        self.def().battery.map_or(NO_BATTERY, |battery| (battery.life - (age - 0.1).max(0.0)).max(0.0) as i32)
    }

    /// Returns a snapshot of its state.
    pub(super) fn snapshot(&self, physics: &Physics) -> RobotSnapshot {
        RobotSnapshot {
            id: self.id,
            class: self.def().class.clone(),
            name: self.name.clone(),
            body: physics.body(&self.bodies),
            joints: physics.joints(&self.bodies),
            targets: self.drive.targets.clone(),
            rollers: physics.roller_angles(&self.bodies),
            contacts: physics.contacts(&self.bodies),
        }
    }

    pub(super) fn drive(&mut self, drive: &Drive, problems: &mut Vec<Problem>) {
        let orders = self.drive.read(&self.bodies.robot().def, drive, self.options.speed_unit, problems);
        orders.iter().for_each(|order| _ = self.follow(order));
    }

    /// Follows an order. Returns false if it has a number that is not finite, or if robots of this kind do not follow such orders.
    pub(super) fn follow(&mut self, order: &Order) -> bool {
        let class = self.bodies.robot().clone();
        if !(order.is_finite() && self.drive.take(&class.def, order)) {
            return false;
        }
        match order {
            Order::Wheels(_) | Order::Twist(_) => self.bodies.set_wheel_speeds(&self.drive.targets),
            Order::Steer(_) => {
                for (joint, target) in self.drive.joint_targets(&class.def) {
                    self.bodies.set_joint_target(joint, target);
                }
            }
            Order::Joints(targets) => {
                targets.iter().for_each(|&(joint, target)| self.bodies.set_joint_target(joint, target));
            }
            Order::Flight(_) => self.bodies.set_flight(self.drive.flight()),
        }
        true
    }

    /// Sets the targets of joints other than wheels: `SET {Type Joint}` with the opcode `Angle` or `Target`, both in exact case, and the name
    /// of a link in any case, or `AllAngles` or `AllJoints` (BotConnection.uc:515-544, USARVehicle.uc:274-316). Returns true if a joint
    /// matches.
    fn set_joints(&mut self, set: &Set) -> bool {
        let target = set.numbers().and_then(|numbers| numbers.first().copied());
        let Some(target) = target.filter(|_| matches!(set.opcode.as_str(), "Angle" | "Target")) else { return false };
        let all = ["AllAngles", "AllJoints"].iter().any(|all| set.name.eq_ignore_ascii_case(all));
        self.set_targets(target, |name| all || name.eq_ignore_ascii_case(&set.name))
    }

    /// Sets the targets of joints other than wheels by their names, in any case.
    pub(super) fn multi_drive(&mut self, drive: &MultiDrive, problems: &mut Vec<Problem>) {
        for (joint, target) in &drive.targets {
            if !self.set_targets(*target, |name| name.eq_ignore_ascii_case(joint)) {
                let joints = self.def().with_values().filter(|link| link.wheel.is_none());
                problems.push(unknown("MULTIDRIVE", joint, joints.map(|link| link.name.as_str())));
            }
        }
    }

    /// Sets the target of every joint other than a wheel whose name fits. Returns true if there is one.
    fn set_targets(&mut self, target: f64, fits: impl Fn(&str) -> bool) -> bool {
        let joints = self.def().with_values().enumerate();
        let named = joints.filter(|(_, link)| link.wheel.is_none() && fits(&link.name));
        let targets: Vec<(usize, f64)> = named.map(|(number, _)| (number, target)).collect();
        !targets.is_empty() && self.follow(&Order::Joints(targets))
    }

    /// Delivers a SET to the items or joints that it names.
    pub(super) fn set(&mut self, set: &Set, physics: &Physics, time: f64) -> Outcome {
        if set.type_name == "Joint" {
            return Outcome { found: self.set_joints(set), ..Outcome::default() };
        }
        let wheels = physics.wheels(&self.bodies);
        let (items, view) = self.items_and_view(physics, time, &wheels);
        let asked = items.iter_mut().filter(|item| item.is_asked(&set.type_name, &set.name));
        let effects = asked.filter_map(|item| item.get_mut().set(set, &view)).collect();
        self.carry_out(effects)
    }

    /// Delivers an ACT or MISPKG to the items that it names: joint targets to an actuator; `Gripper` to a gripper, to those that an actuator
    /// carries, or to a tool changer.
    pub(super) fn act(&mut self, motion: &Motion, problems: &mut Vec<Problem>) -> Outcome {
        if motion.targets.is_empty() && motion.closed.is_none() {
            let verb = if motion.first == 0 { "ACT" } else { "MISPKG" };
            problems.push(Problem::MissingKey { verb, key: "Link and Value, or Gripper" });
        }
        let (items, def) = (&mut self.items, &self.bodies.robot().def);
        let effects: Vec<Effect> =
            items.iter_mut().filter_map(|item| item.get_mut().act(motion, def, problems)).collect();
        if effects.is_empty() {
            let known = self.items.iter().filter(|item| !item.is_sensor()).map(|item| item.get().identity().1);
            problems.push(unknown("Name", motion.name, known));
        }
        self.carry_out(effects)
    }

    /// Follows the orders of items. Hands are left to the world.
    fn carry_out(&mut self, effects: Vec<Effect>) -> Outcome {
        let mut outcome = Outcome { found: !effects.is_empty(), ..Outcome::default() };
        for effect in effects {
            match effect {
                Effect::None => {}
                Effect::Sensed(sensed) => outcome.reports.push(Report::Sensed(sensed)),
                Effect::Order(order) => _ = self.follow(&order),
                Effect::Hand { hand, closed } => outcome.hands.push((hand, closed)),
                Effect::Tag(order) => outcome.tags.push(order),
            }
        }
        outcome
    }

    /// Returns the problem of a SET that matches nothing, with a list of the robot's items.
    pub(super) fn nothing_to_set(&self, set: &Set) -> Problem {
        let items = self.items.iter().filter(|item| item.takes_set()).map(|item| item.get().identity());
        let joints = self.def().with_values().filter(|link| link.wheel.is_none());
        let joints = joints.map(|link| ("Joint", link.name.as_str()));
        no_item("SET", "item or opcode", [&set.type_name, &set.name], items.chain(joints).collect())
    }

    /// Returns the problem of a question that matches nothing, with a list of the robot's items.
    pub(super) fn nothing_to_tell(&self, verb: &str, type_name: &str, name: &str) -> Problem {
        let items = self.items.iter().map(|item| item.get().identity());
        no_item(verb, "item", [type_name, name], [("Robot", "")].into_iter().chain(items).collect())
    }

    /// Borrows the items mutably together with their view, which is read-only.
    fn items_and_view<'a>(
        &'a mut self,
        physics: &'a Physics,
        time: f64,
        wheels: &'a [WheelState],
    ) -> (&'a mut [Item], View<'a>) {
        let Self { items, id, bodies, .. } = self;
        (items, view(*id, bodies, physics, time, wheels))
    }

    pub(super) fn before_step(&mut self, physics: &mut Physics) {
        physics.before_step(&mut self.bodies);
    }

    /// Lets it report from the step after `step` on, or not at all. Sensors that do not report do not measure.
    pub(super) fn set_reporting(&mut self, is_reporting: bool, step: u64) {
        self.next_report = if is_reporting { self.report_after(step) } else { u64::MAX };
    }

    /// True if it has something to report at a step.
    pub(super) fn is_about_to_report(&self, step: u64) -> bool {
        step >= self.next_report
    }

    /// Returns the first step after `step` in which it has something to report.
    fn report_after(&self, step: u64) -> u64 {
        let intervals = self.items.iter().map(|item| item.get().interval()).chain([STATUS_INTERVAL]);
        let next = intervals.map(|interval| due_after(step - self.spawned, self.options.time_step, interval)).min();
        next.map_or(u64::MAX, |age| age.saturating_add(self.spawned))
    }

    /// True if one of its sensors measures at a step.
    pub(super) fn is_about_to_look(&self, step: u64) -> bool {
        if !self.is_about_to_report(step) {
            return false;
        }
        let age = step - self.spawned;
        let mut sensors = self.items.iter().filter(|item| item.is_sensor());
        sensors.any(|item| is_due(age, self.options.time_step, item.get().interval()))
    }

    /// Sends the reports that are due at a step: the status and, unless the battery is flat, items in mounting order.
    pub(super) fn report(
        &mut self,
        physics: &Physics,
        held: &Attachments,
        time: f64,
        step: u64,
        mut send: impl FnMut(Report),
    ) {
        let (age, time_step) = (step - self.spawned, self.options.time_step);
        self.next_report = self.report_after(step);
        let battery = self.battery_left(time);
        if is_due(age, time_step, STATUS_INTERVAL) {
            let vehicle = self.drive.status(self.def(), || physics.joints(&self.bodies));
            send(Message::Sta(Sta { time: time as f32, battery, vehicle }).into());
        }
        let is_due = |item: &Item| is_due(age, time_step, item.get().interval());
        if battery <= 0 || !self.items.iter().any(is_due) {
            return;
        }
        let wheels = physics.wheels(&self.bodies);
        let (items, view) = self.items_and_view(physics, time, &wheels);
        let due = items.iter_mut().filter(|item| is_due(item));
        due.filter_map(|item| item.get_mut().report(&view, held)).for_each(send);
    }
}

fn view<'a>(
    id: PawnId,
    bodies: &'a RobotBodies,
    physics: &'a Physics,
    time: f64,
    wheels: &'a [WheelState],
) -> View<'a> {
    let (robot, body) = (&bodies.robot().def, physics.body(bodies));
    View { time, body, carrier: body, wheels, robot, bodies, physics, id }
}

/// Returns the problem of a name that none of the robot's joints, actuators or grippers has.
pub(super) fn unknown<'a>(key: &'static str, got: &str, known: impl Iterator<Item = &'a str> + Clone) -> Problem {
    Problem::unknown_name(key, got, known, "this robot", "nothing is moved")
}

/// Returns the problem of a type and a name that match none of a robot's items. `known` has the types and names of these.
fn no_item(verb: &str, what: &'static str, [type_name, name]: [&str; 2], known: Vec<(&str, &str)>) -> Problem {
    let blocks = [("Type", type_name), ("Name", name)].into_iter().filter(|(_, value)| !value.is_empty());
    let asked = blocks.fold(verb.to_owned(), |line, (key, value)| format!("{line} {{{key} {}}}", shown(value)));
    let is_of_type = |(own, _): &&(&str, &str)| own.eq_ignore_ascii_case(type_name);
    let names = known.iter().filter(is_of_type).map(|(_, name)| *name).filter(|_| !name.is_empty());
    let meant = names::did_you_mean(&shown(name), names);
    let types = || known.iter().map(|(own, _)| *own).filter(|own| *own != type_name && !type_name.is_empty());
    let meant = if meant.is_empty() { names::did_you_mean(&shown(type_name), types()) } else { meant };
    let listed: Vec<String> = known.iter().map(|(own, name)| format!("{own} {name}").trim_end().to_owned()).collect();
    let expected = expected_of(listed.iter().map(String::as_str), "this robot");
    Problem::NoItem { asked, what, meant, expected }
}

/// True at the step in which another whole interval since the spawn has passed.
fn is_due(age: u64, time_step: f64, interval: f64) -> bool {
    let passed = |age: u64| (age as f64 * time_step / interval + 1e-9).floor();
    interval > 0.0 && age > 0 && passed(age) > passed(age - 1)
}

/// Returns the first age after `age` that is due, in steps since the spawn. `u64::MAX` if there is none.
fn due_after(age: u64, time_step: f64, interval: f64) -> u64 {
    if interval <= 0.0 {
        return u64::MAX;
    }
    let passed = (age as f64 * time_step / interval + 1e-9).floor();
    let guess = (passed + 1.0) * interval / time_step;
    // No world gets that old.
    if guess > 2f64.powi(52) {
        return u64::MAX;
    }
    let first = (age + 1).max((guess as u64).saturating_sub(1));
    (first..).find(|&age| is_due(age, time_step, interval)).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn timers_keep_their_average_rate() {
        for (interval, expected) in [(0.1, 100), (0.2, 50), (0.3, 33), (0.05, 200), (0.0, 0), (0.0015, 5000)] {
            let count = (0..=5000).filter(|&age| is_due(age, 0.002, interval)).count();
            assert_eq!(count, expected, "{interval}");
        }
        assert!(is_due(50, 0.002, 0.1) && !is_due(49, 0.002, 0.1) && !is_due(51, 0.002, 0.1));
    }

    /// `due_after` skips no report.
    #[test]
    fn the_next_report_is_the_next_step_that_is_due() {
        for time_step in [0.001, 0.002, 0.016, 0.02, 0.1] {
            for interval in [0.1, 0.2, 0.3, 0.05, 0.0333, 0.0015, 1e-9, 7.0, 1e300] {
                let due: Vec<u64> = (1..3000).filter(|&age| is_due(age, time_step, interval)).collect();
                for age in 0..2000 {
                    let next = due_after(age, time_step, interval);
                    let expected = due.iter().copied().find(|&due| due > age);
                    assert!(
                        expected.map_or(next >= 3000, |it| it == next),
                        "{interval} at {age}: {next}, {expected:?}"
                    );
                }
            }
        }
        assert_eq!(due_after(5, 0.002, 0.0), u64::MAX);
    }
}
