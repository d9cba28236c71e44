//! States of robots and objects, from snapshots of a world.

use scene::{ObjectId, ObjectSnapshot, Snapshot};

use crate::{ObjectRemoved, ObjectSpawned, ObjectState, Record, RobotState};

/// Interval between two recorded states of the robots, s.
pub const STATE_INTERVAL: f64 = 0.02;

/// Timer of the recorded states.
#[derive(Debug, Default)]
pub struct StateTimer {
    taken: u64,
}

impl StateTimer {
    /// True if another interval has passed at a simulated time, s, since this last returned true; to be called after every step.
    pub fn is_due(&mut self, time: f64) -> bool {
        let intervals = (time / STATE_INTERVAL + 1e-6) as u64;
        let is_due = intervals > self.taken;
        self.taken = self.taken.max(intervals);
        is_due
    }
}

/// The objects of the last snapshot, by their ids; `None` before the first one.
#[derive(Debug, Default)]
pub(crate) struct States(Option<Vec<ObjectSnapshot>>);

impl States {
    /// Returns the states of all robots, and of the objects that were spawned, moved or removed since the last snapshot. The map has the
    /// first `of_map` objects.
    pub(crate) fn records(&mut self, of_map: u64, snapshot: &Snapshot) -> Vec<Record> {
        let mut records: Vec<Record> = snapshot.robots.iter().map(RobotState::new).map(Record::State).collect();
        let find = |objects: &[ObjectSnapshot], id| objects.binary_search_by_key(&id, |object| object.id).ok();
        let known = self.0.as_deref().unwrap_or_default();
        for object in &snapshot.objects {
            let before = find(known, object.id).map(|place| &known[place]);
            if before.is_none() && object.id.0 >= of_map {
                records.push(Record::ObjectSpawned(ObjectSpawned::new(object)));
            }
            if before.is_none_or(|before| before.pose != object.pose) {
                records.push(Record::Object(ObjectState::new(object)));
            }
        }
        // At the first call the log knows those of the map.
        let of_map = (0..of_map).map(ObjectId).filter(|_| self.0.is_none());
        let before = known.iter().map(|object| object.id).chain(of_map);
        let removed = before.filter(|id| find(&snapshot.objects, *id).is_none());
        records.extend(removed.map(|id| Record::ObjectRemoved(ObjectRemoved { object: id.0 as u32 })));
        self.0 = Some(snapshot.objects.clone());
        records
    }
}
