//! Which robots are there, and the slot that the topics and frames of each are numbered by.

use std::collections::BTreeMap;

/// The robots that are there. A log has room for 65 535 channels, so they are numbered by slots that are given back, and not by
/// robots, which come and go without end.
#[derive(Debug, Default)]
pub(crate) struct Slots {
    robots: BTreeMap<u64, Slotted>,
}

/// A robot that is there.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Slotted {
    /// From 0; while no robot leaves it is the robot's number.
    pub(crate) slot: u64,
    pub(crate) class: String,
}

impl Slots {
    /// The robot, if it is there.
    pub(crate) fn get(&self, robot: u64) -> Option<&Slotted> {
        self.robots.get(&robot)
    }

    /// Gives a robot that comes the smallest free slot.
    pub(crate) fn come(&mut self, robot: u64, class: &str) -> u64 {
        let mut taken: Vec<u64> = self.robots.values().map(|slotted| slotted.slot).collect();
        taken.sort_unstable();
        let slot = taken.iter().zip(0..).take_while(|(taken, slot)| *taken == slot).count() as u64;
        self.robots.insert(robot, Slotted { slot, class: class.to_owned() });
        slot
    }

    /// Takes back the slot of a robot that left.
    pub(crate) fn leave(&mut self, robot: u64) -> Option<u64> {
        self.robots.remove(&robot).map(|slotted| slotted.slot)
    }

    /// Takes back every slot.
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
