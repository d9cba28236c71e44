//! Slots of robots, which number the topics and frames of each.

use std::collections::BTreeMap;

/// The robots in the world, with their slots. A log has room for 65 535 channels. So channels are numbered by slots, which are
/// reused, and not by robots, which come and go without end.
#[derive(Debug, Default)]
pub(crate) struct Slots {
    robots: BTreeMap<u64, Slotted>,
}

/// A robot in the world.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Slotted {
    /// Counted from 0; while no robot leaves, it equals the robot's number.
    pub(crate) slot: u64,
    pub(crate) class: String,
}

impl Slots {
    /// Returns a robot that is in the world.
    pub(crate) fn get(&self, robot: u64) -> Option<&Slotted> {
        self.robots.get(&robot)
    }

    /// Gives a new robot the smallest free slot.
    pub(crate) fn come(&mut self, robot: u64, class: &str) -> u64 {
        let mut taken: Vec<u64> = self.robots.values().map(|slotted| slotted.slot).collect();
        taken.sort_unstable();
        let slot = taken.iter().zip(0..).take_while(|(taken, slot)| *taken == slot).count() as u64;
        self.robots.insert(robot, Slotted { slot, class: class.to_owned() });
        slot
    }

    /// Frees and returns the slot of a robot that left.
    pub(crate) fn leave(&mut self, robot: u64) -> Option<u64> {
        self.robots.remove(&robot).map(|slotted| slotted.slot)
    }

    /// Frees and returns every slot.
    pub(crate) fn clear(&mut self) -> impl Iterator<Item = u64> {
        std::mem::take(&mut self.robots).into_values().map(|slotted| slotted.slot)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_robot_gets_the_smallest_slot_that_is_free() {
        let mut slots = Slots::default();
        assert_eq!([0, 1, 2, 3].map(|robot| slots.come(robot, "P3AT")), [0, 1, 2, 3]);
        assert_eq!([slots.leave(2), slots.leave(0), slots.leave(0)], [Some(2), Some(0), None]);
        assert_eq!([4, 5, 6].map(|robot| slots.come(robot, "P3AT")), [0, 2, 4]);
        assert_eq!(slots.get(5), Some(&Slotted { slot: 2, class: "P3AT".to_owned() }));
        assert_eq!(slots.clear().collect::<Vec<_>>(), [1, 3, 0, 2, 4]);
        assert_eq!(slots.come(7, "P3AT"), 0);
    }
}
