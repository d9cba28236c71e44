//! Follow a path of straight pieces.
//!
//! A robot observes the next three points along the path in its own frame (6), its distance to the right of the path (1), and its
//! velocities (3). The reward is the distance that it came along the path, m, minus its distance beside the path times time, m s. The
//! episode ends at the end of the path, or when a robot is too far beside it.

use rand_chacha::ChaCha8Rng;
use scene::goal;
use sim_core::World;

use crate::rules::{ARRIVAL, Rules, Verdict};
use crate::sight::{Sight, distance, draw};

/// Number of points ahead that a robot observes.
const AHEAD: usize = 3;

/// The goal as it is played.
#[derive(Clone)]
pub(crate) struct Follow {
    settings: goal::Follow,
    /// Time between two actions, s.
    interval: f64,
    /// The path of each robot in the world, m.
    paths: Vec<Path>,
}

#[derive(Clone, Default)]
struct Path {
    points: Vec<[f64; 2]>,
    /// Distance along the path that the robot has come, m.
    travelled: f64,
}

impl Follow {
    pub(crate) fn new(settings: goal::Follow, robots: usize, interval: f64) -> Self {
        Self { settings, interval, paths: vec![Path::default(); robots] }
    }
}

impl Path {
    fn length(&self) -> f64 {
        self.points.windows(2).map(|pair| distance(pair[0], pair[1])).sum()
    }

    /// Returns the point at a distance along the path, m.
    fn at(&self, mut along: f64) -> [f64; 2] {
        for pair in self.points.windows(2) {
            let length = distance(pair[0], pair[1]);
            if along <= length {
                let part = along.max(0.0) / length;
                return [0, 1].map(|axis| pair[0][axis] + part * (pair[1][axis] - pair[0][axis]));
            }
            along -= length;
        }
        self.points.last().copied().unwrap_or_default()
    }

    /// Returns the distance along the path of its point nearest to a robot, and how far to the right the robot is, m. Only the stretch
    /// around `travelled` counts, so that a crossing is no shortcut.
    fn nearest(&self, point: [f64; 2], stretch: f64) -> (f64, f64) {
        let (mut begin, mut best) = (0.0, (self.travelled, f64::INFINITY, 0.0));
        for pair in self.points.windows(2) {
            let length = distance(pair[0], pair[1]);
            let ahead = [0, 1].map(|axis| (pair[1][axis] - pair[0][axis]) / length);
            let offset = [0, 1].map(|axis| point[axis] - pair[0][axis]);
            let low = (self.travelled - stretch - begin).max(0.0);
            let high = (self.travelled + stretch - begin).min(length);
            if low <= high {
                let along = (offset[0] * ahead[0] + offset[1] * ahead[1]).clamp(low, high);
                let far = distance(point, [0, 1].map(|axis| pair[0][axis] + along * ahead[axis]));
                if far < best.1 {
                    best = (begin + along, far, ahead[0] * offset[1] - ahead[1] * offset[0]);
                }
            }
            begin += length;
        }
        (best.0, if best.2 < 0.0 { -best.1 } else { best.1 })
    }
}

impl Rules for Follow {
    fn width(&self) -> usize {
        2 * AHEAD + 1 + 3
    }

    fn begin(&mut self, sight: &Sight, rng: &mut ChaCha8Rng) {
        for (path, robot) in self.paths.iter_mut().zip(&sight.robots) {
            let side = if self.settings.mirror && draw(rng, [0.0, 1.0]) < 0.5 { -1.0 } else { 1.0 };
            let (sin, cos) = libm::sincos(robot.place.yaw);
            let to_world = |[forward, right]: [f64; 2]| {
                let right = side * right;
                [robot.place.x + cos * forward - sin * right, robot.place.y + sin * forward + cos * right]
            };
            let points = std::iter::once([0.0; 2]).chain(self.settings.points.iter().copied());
            *path = Path { points: points.map(to_world).collect(), travelled: 0.0 };
        }
    }

    fn observe(&self, sight: &Sight, robot: usize, push: &mut dyn FnMut(f64)) {
        let (seen, path) = (&sight.robots[robot], &self.paths[robot]);
        for number in 1..=AHEAD {
            let point = path.at(path.travelled + number as f64 * self.settings.spacing);
            seen.place.to_own(point).into_iter().for_each(&mut *push);
        }
        push(path.nearest(seen.place.point(), self.settings.most_beside).1);
        seen.velocity.into_iter().for_each(push);
    }

    fn judge(&mut self, _: &mut World, sight: &Sight) -> Verdict {
        let (mut rewards, mut arrived, mut is_off) = (Vec::with_capacity(self.paths.len()), 0, false);
        for (path, robot) in self.paths.iter_mut().zip(&sight.robots) {
            let (travelled, beside) = path.nearest(robot.place.point(), self.settings.most_beside);
            let is_there = travelled >= path.length() - 1e-2;
            arrived += usize::from(is_there);
            is_off |= beside.abs() >= self.settings.most_beside;
            let reward = travelled - path.travelled - beside.abs() * self.interval;
            rewards.push(reward + if is_there { ARRIVAL } else { 0.0 });
            path.travelled = travelled;
        }
        let is_success = arrived == self.paths.len();
        Verdict { rewards, is_over: is_success || is_off, is_success }
    }
}
