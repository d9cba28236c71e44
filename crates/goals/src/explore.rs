//! See as much of an area as possible with a laser.
//!
//! A robot observes the nearest hit in each of 36 sectors of its scan, over the laser's range (36), its place over half the size of the
//! area (2), its heading (2: cosine and sine), its velocities (3), and the part of the area that all robots have seen (1). The reward is
//! the area that a robot is the first to see, m².

use std::sync::Arc;

use rand_chacha::ChaCha8Rng;
use scene::sensor::Fan;
use scene::{RobotDef, goal};
use sim_core::World;

use crate::rules::{Rules, Verdict};
use crate::sight::{RobotSight, Sight};

/// Number of sectors of a scan that a robot observes.
const SECTORS: usize = 36;

/// The goal as it is played.
#[derive(Clone)]
pub(crate) struct Explore {
    settings: goal::Explore,
    /// Cells along x and y.
    size: [usize; 2],
    fan: Fan,
    /// Direction of every beam in the robot frame, forward and right.
    beams: Arc<[[f64; 2]]>,
    /// Place of the laser in the robot frame, forward and right, m.
    mount: [f64; 2],
    is_seen: Vec<bool>,
    seen: usize,
}

impl Explore {
    pub(crate) fn new(settings: goal::Explore, robot: &RobotDef) -> Result<Self, String> {
        let (size, scanner) = (settings.cells(), &settings.scanner);
        let known = robot.sensors.iter().find(|sensor| sensor.name.eq_ignore_ascii_case(scanner));
        let Some(sensor) = known else {
            return Err(format!("explore.scanner: {} has no sensor `{scanner}`", robot.class));
        };
        let Some(laser) = sensor.config.laser() else {
            return Err(format!(
                "explore.scanner: `{scanner}` is of class {}, expected a laser",
                sensor.config.class()
            ));
        };
        let (fan, yaw) = (laser.fan(), sensor.direction[2]);
        let beams = (2.0 * fan.first / fan.resolution) as usize + 1;
        let direction = |beam: usize| {
            let (sin, cos) = libm::sincos(yaw + fan.first - beam as f64 * fan.resolution);
            [cos, sin]
        };
        let beams = (0..beams).map(direction).collect();
        let mount = [sensor.position[0], sensor.position[1]];
        Ok(Self { size, fan, beams, mount, is_seen: vec![false; size[0] * size[1]], seen: 0, settings })
    }

    /// Marks what a robot sees. Returns the number of new cells.
    fn look(&mut self, robot: &RobotSight) -> usize {
        let Self { settings: goal::Explore { area, cell, sight, .. }, size, beams, mount, is_seen, .. } = self;
        let (sin, cos) = libm::sincos(robot.place.yaw);
        let to_world = |[forward, right]: [f64; 2]| [cos * forward - sin * right, sin * forward + cos * right];
        let [from_x, from_y] = to_world(*mount);
        let from = [robot.place.x + from_x, robot.place.y + from_y];
        let mut new = 0;
        for (beam, range) in beams.iter().zip(&robot.scan) {
            let (direction, range) = (to_world(*beam), range.min(*sight));
            let samples = (range / *cell * 2.0) as usize;
            for sample in 0..=samples {
                let along = (sample as f64 * *cell / 2.0).min(range);
                let index = [0, 1].map(|axis| (from[axis] + along * direction[axis] - area[axis][0]) / *cell);
                let is_inside = index.iter().zip(&*size).all(|(&index, &size)| index >= 0.0 && index < size as f64);
                if is_inside {
                    let place = index[0] as usize * size[1] + index[1] as usize;
                    new += usize::from(!std::mem::replace(&mut is_seen[place], true));
                }
            }
        }
        new
    }
}

impl Rules for Explore {
    fn width(&self) -> usize {
        SECTORS + 2 + 2 + 3 + 1
    }

    fn begin(&mut self, sight: &Sight, _rng: &mut ChaCha8Rng) {
        self.is_seen.fill(false);
        self.seen = sight.robots.iter().map(|robot| self.look(robot)).sum();
    }

    fn observe(&self, sight: &Sight, robot: usize, push: &mut dyn FnMut(f64)) {
        let (seen, count) = (&sight.robots[robot], self.beams.len());
        for sector in 0..SECTORS {
            let (from, to) = (sector * count / SECTORS, (sector + 1) * count / SECTORS);
            let beams = seen.scan.get(from..to.max(from + 1)).unwrap_or_default();
            push(beams.iter().copied().fold(self.fan.max_range, f64::min) / self.fan.max_range);
        }
        for ([low, high], place) in self.settings.area.into_iter().zip(seen.place.point()) {
            push((2.0 * place - low - high) / (high - low).max(self.settings.cell));
        }
        let (sin, cos) = libm::sincos(seen.place.yaw);
        [cos, sin].into_iter().chain(seen.velocity).for_each(&mut *push);
        push(self.seen as f64 / self.is_seen.len() as f64);
    }

    fn judge(&mut self, _: &mut World, sight: &Sight) -> Verdict {
        let cell = self.settings.cell * self.settings.cell;
        let new: Vec<usize> = sight.robots.iter().map(|robot| self.look(robot)).collect();
        self.seen += new.iter().sum::<usize>();
        let is_success = self.seen as f64 >= self.settings.part * self.is_seen.len() as f64;
        let rewards = new.into_iter().map(|new| new as f64 * cell).collect();
        Verdict { rewards, is_over: is_success, is_success }
    }
}
