//! The world's end of the node: what it tells of the world, without ever waiting.

use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use scene::{PawnId, Reading, RobotDef, Sensed, Snapshot};
use sim_core::{CompiledScene, World};
use tokio::sync::mpsc::Sender;
use tokio::sync::mpsc::error::TrySendError;

use crate::cameras::View;
use crate::clock::Clock;

/// Simulated time between two times on `/clock`, s.
const CLOCK_INTERVAL: f64 = 0.01;
/// Simulated time between two states, s, as in logs.
const STATE_INTERVAL: f64 = 0.02;
/// Simulated time between two states of batteries and of the world, s.
const STATUS_INTERVAL: f64 = 1.0;
/// Real time over which items of a kind are counted, and most of them in it, for worlds that are faster than real time: five times as many
/// as of one in real time.
const WINDOW: Duration = Duration::from_millis(100);
const MOST_IN_WINDOW: u32 = 50;
/// Real time after which a world that does not step tells of the robots that came and left meanwhile.
const IDLE_INTERVAL: Duration = Duration::from_millis(200);
/// Most items that wait. Further ones are left out.
pub(crate) const MOST_WAITING: usize = 512;

/// News of the world.
pub(crate) enum Item {
    /// A fresh world has replaced the old one.
    StartOver(CompiledScene),
    /// A robot that has come.
    Came { robot: u64, name: String, def: Box<RobotDef> },
    /// The time, s.
    Clock(f64),
    /// All robots and objects. Robots that are missing have left.
    State(Arc<Snapshot>),
    /// Robots and objects of a world that stands still.
    Still(Arc<Snapshot>),
    /// The state of the world and of its robots' batteries.
    Status(Status),
    /// A reading of a sensor at a time, s.
    Sensed(f64, Sensed),
    /// A view of a camera that somebody wants to see.
    View(View),
}

/// The state of the world in numbers.
pub(crate) struct Status {
    /// Simulated time, s.
    pub(crate) time: f64,
    /// Steps whose contacts did not converge.
    pub(crate) unsettled: u64,
    /// Robots with a battery, and the seconds that it lasts.
    pub(crate) batteries: Vec<(u64, f64)>,
    /// Items that were left out so far.
    pub(crate) dropped: u64,
}

/// Cameras that somebody wants to see: robot and sensor.
pub(crate) type Wanted = Arc<Mutex<BTreeSet<(u64, usize)>>>;

/// The world's end. Whatever is not taken in time is left out and counted.
pub struct Feed {
    items: Option<Sender<Item>>,
    thread: Option<JoinHandle<()>>,
    wanted: Wanted,
    time: Clock,
    /// Robots that the node knows.
    known: BTreeSet<PawnId>,
    /// True if the node does not know yet that the world started over.
    is_fresh: bool,
    clock: Timer,
    state: Timer,
    status: Timer,
    /// Real time of the last step, or of the last news of a world that stands still.
    moved: Option<Instant>,
    dropped: u64,
}

/// Times of the items of a kind.
#[derive(Default)]
struct Timer {
    /// Simulated time of the last one, s.
    last: Option<f64>,
    /// Begin of the present window of real time, and the items in it.
    window: Option<(Instant, u32)>,
}

impl Timer {
    /// True if an interval of simulated time, s, has passed since the last time that it was true, or time went back.
    fn is_due(&mut self, time: f64, now: Instant, interval: f64) -> bool {
        let has_passed = self.last.is_none_or(|last| time < last || time - last >= interval - 1e-6);
        let window = self.window.filter(|(begin, _)| now.saturating_duration_since(*begin) < WINDOW);
        let (begin, count) = window.unwrap_or((now, 0));
        let is_due = has_passed && count < MOST_IN_WINDOW;
        if is_due {
            (self.last, self.window) = (Some(time), Some((begin, count + 1)));
        }
        is_due
    }
}

impl Feed {
    pub(crate) fn new(items: Sender<Item>, thread: JoinHandle<()>, wanted: Wanted, time: Clock) -> Self {
        Self {
            items: Some(items),
            thread: Some(thread),
            wanted,
            time,
            known: BTreeSet::new(),
            is_fresh: true,
            clock: Timer::default(),
            state: Timer::default(),
            status: Timer::default(),
            moved: None,
            dropped: 0,
        }
    }

    /// Tells of the world as it is after a step, as far as it is due at a real time. `snapshot` makes the snapshot of it.
    pub fn stepped(&mut self, world: &World, now: Instant, snapshot: impl FnOnce() -> Arc<Snapshot>) {
        let time = world.time();
        self.time.set(time);
        self.moved = Some(now);
        if !self.begins(world) {
            return;
        }
        if self.clock.is_due(time, now, CLOCK_INTERVAL) {
            self.send(Item::Clock(time));
        }
        if self.state.is_due(time, now, STATE_INTERVAL) {
            let snapshot = snapshot();
            self.tell_of_new_robots(world, &snapshot);
            self.send(Item::State(snapshot));
        }
        if self.status.is_due(time, now, STATUS_INTERVAL) {
            let left = |(id, ..): (PawnId, &str, &str)| Some((id.0, f64::from(world.battery(id)?)));
            let batteries = world.robots().filter_map(left).collect();
            let (unsettled, dropped) = (world.unsettled_steps(), self.dropped);
            self.send(Item::Status(Status { time, unsettled, batteries, dropped }));
        }
    }

    /// Tells of a world that may stand still, at a real time: of the robots that came and left.
    pub fn turned(&mut self, world: &World, now: Instant, snapshot: impl FnOnce() -> Arc<Snapshot>) {
        let is_still = self.moved.is_none_or(|at| now.saturating_duration_since(at) >= IDLE_INTERVAL);
        if is_still && self.begins(world) {
            self.moved = Some(now);
            let snapshot = snapshot();
            self.tell_of_new_robots(world, &snapshot);
            self.send(Item::Still(snapshot));
        }
    }

    /// Tells of a fresh world, if the node does not know it yet. True if it does now.
    fn begins(&mut self, world: &World) -> bool {
        if self.is_fresh {
            self.is_fresh = !self.send(Item::StartOver(world.scene().clone()));
        }
        !self.is_fresh
    }

    /// Tells of a reading. `snapshot` makes the snapshot of the world, for pictures.
    pub fn sensed(&mut self, world: &World, sensed: &Sensed, snapshot: impl FnOnce() -> Arc<Snapshot>) {
        if self.is_fresh || !self.known.contains(&sensed.robot) {
            return;
        }
        if let Reading::Camera(_) = &sensed.reading {
            let wanted = self.wanted.lock().unwrap_or_else(PoisonError::into_inner);
            if !wanted.contains(&(sensed.robot.0, sensed.sensor)) {
                return;
            }
            drop(wanted);
            let (scene, sensed) = (world.scene().clone(), sensed.clone());
            self.send(Item::View(View { scene, snapshot: snapshot(), sensed }));
        } else {
            self.send(Item::Sensed(world.time(), sensed.clone()));
        }
    }

    /// Notes that a fresh world has replaced the old one.
    pub fn start_over(&mut self) {
        self.known.clear();
        self.is_fresh = true;
    }

    /// Ends: the node leaves, and this waits for it.
    pub fn end(&mut self) {
        self.items = None;
        // A thread that panicked has said so.
        self.thread.take().into_iter().for_each(|thread| _ = thread.join());
    }

    fn tell_of_new_robots(&mut self, world: &World, snapshot: &Snapshot) {
        self.known.retain(|known| snapshot.robots.iter().any(|robot| robot.id == *known));
        for robot in snapshot.robots.iter() {
            let Some(def) = world.robot(robot.id).filter(|_| !self.known.contains(&robot.id)) else { continue };
            let came = Item::Came { robot: robot.id.0, name: robot.name.clone(), def: Box::new(def.clone()) };
            // A robot that finds no room is told of the next time.
            if self.send(came) {
                self.known.insert(robot.id);
            }
        }
    }

    /// Sends an item. Returns false if there is no room.
    fn send(&mut self, item: Item) -> bool {
        let Some(items) = &self.items else { return false };
        match items.try_send(item) {
            Ok(()) => true,
            Err(TrySendError::Full(_)) => {
                self.dropped += 1;
                false
            }
            Err(TrySendError::Closed(_)) => {
                self.items = None;
                false
            }
        }
    }
}

impl Drop for Feed {
    fn drop(&mut self) {
        self.end();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_are_due_by_simulated_time_and_not_too_many_at_once() {
        let (mut timer, start) = (Timer::default(), Instant::now());
        let mut due = |time: f64, real: u64| timer.is_due(time, start + Duration::from_millis(real), 0.01);
        // A world that catches up tells all of it.
        let got = [due(0.0, 0), due(0.008, 8), due(0.01, 10), due(0.02, 10), due(0.03, 10), due(0.0, 13)];
        assert_eq!(got, [true, false, true, true, true, true]);
        let told = (1..=1000).filter(|step| due(f64::from(*step) * 0.01, 20)).count();
        assert_eq!(told, 45, "five were told before");
        assert!(due(20.0, 120));
    }
}
