//! Which robots are there, and the place that the topics and frames of each are numbered by.

use std::collections::BTreeMap;

/// The robots that are there. A log has room for 65 535 channels, so they are numbered by places that are given back, and not by
/// robots, which come and go without end.
#[derive(Debug, Default)]
pub(crate) struct Places {
    robots: BTreeMap<u64, Placed>,
}

/// A robot that is there.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Placed {
    /// From 0; while no robot leaves it is the robot's number.
    pub(crate) place: u64,
    pub(crate) class: String,
}

impl Places {
    /// The robot, if it is there.
    pub(crate) fn get(&self, robot: u64) -> Option<&Placed> {
        self.robots.get(&robot)
    }

    /// Gives a robot that comes the smallest free place.
    pub(crate) fn come(&mut self, robot: u64, class: &str) -> u64 {
        let mut taken: Vec<u64> = self.robots.values().map(|placed| placed.place).collect();
        taken.sort_unstable();
        let place = taken.iter().zip(0..).take_while(|(taken, place)| *taken == place).count() as u64;
        self.robots.insert(robot, Placed { place, class: class.to_owned() });
        place
    }

    /// Takes back the place of a robot that left.
    pub(crate) fn leave(&mut self, robot: u64) -> Option<u64> {
        self.robots.remove(&robot).map(|placed| placed.place)
    }

    /// Takes back every place.
    pub(crate) fn clear(&mut self) -> impl Iterator<Item = u64> {
        std::mem::take(&mut self.robots).into_values().map(|placed| placed.place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_robot_gets_the_smallest_place_that_is_free() {
        let mut places = Places::default();
        assert_eq!([0, 1, 2, 3].map(|robot| places.come(robot, "P3AT")), [0, 1, 2, 3]);
        assert_eq!([places.leave(2), places.leave(0), places.leave(0)], [Some(2), Some(0), None]);
        assert_eq!([4, 5, 6].map(|robot| places.come(robot, "P3AT")), [0, 2, 4]);
        assert_eq!(places.get(5), Some(&Placed { place: 2, class: "P3AT".to_owned() }));
        assert_eq!(places.clear().collect::<Vec<_>>(), [1, 3, 0, 2, 4]);
        assert_eq!(places.come(7, "P3AT"), 0);
    }
}
