//! Belts of tracks.

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use crate::{Pose, Shape};

/// Corners with which the outline rounds a whole roller.
const CORNERS: u32 = 24;

/// A tight belt around rollers. It moves in the plane across the sprocket's axle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Belt {
    /// Middle of every roller in the robot frame with every joint at 0, x and z, and the outer radius of the belt around it, m. The first
    /// is the sprocket.
    pub rollers: Vec<[f64; 3]>,
}

/// Distance of two drawn pads over the sprocket's radius, and the least and greatest number of them.
const PITCH: f64 = 0.45;
const PADS: [f64; 2] = [12.0, 80.0];

/// The pads of a belt as they are drawn: boxes that move along a closed path.
#[derive(Debug, Clone, PartialEq)]
pub struct Pads {
    /// Corners of the path, x and z from the sprocket's middle, m.
    pub path: Vec<[f64; 2]>,
    /// Number of pads.
    pub count: usize,
    /// Edges of a pad along the path, across the belt and outward, m.
    pub size: [f64; 3],
    /// Radius of the belt around the sprocket, m.
    pub radius: f64,
}

impl Pads {
    /// Returns the poses of the pads from the sprocket's middle when the sprocket is at an angle, rad. Their x axis is along the path.
    pub fn poses(&self, angle: f64) -> Vec<Pose> {
        let next = self.path.iter().cycle().skip(1);
        let edges: Vec<([f64; 2], [f64; 2], f64)> =
            self.path.iter().zip(next).map(|(&one, &other)| (one, other, distance(&one, &other))).collect();
        let length: f64 = edges.iter().map(|(.., length)| length).sum();
        let pose = |number: usize| {
            let mut rest = (length * number as f64 / self.count as f64 + self.radius * angle).rem_euclid(length);
            for &(one, other, length) in &edges {
                if rest <= length && length > 0.0 {
                    let (along, down) = ((other[0] - one[0]) / length, (other[1] - one[1]) / length);
                    let place = [one[0] + along * rest, 0.0, one[1] + down * rest];
                    return crate::pose(place, [0.0, -libm::atan2(down, along), 0.0]);
                }
                rest -= length;
            }
            Pose::identity()
        };
        (0..self.count).map(pose).collect()
    }
}

/// Places along a run that carry its load, from 0 to 1, and their shares. On the spot the friction of these four turns a tank with the
/// same twist as that of an even load, to 1.5 % for tracks 0.5 to 1.5 times as far apart as long; seven places of the trapezoidal rule
/// leave 2.2 %. They have the least error of all symmetric fours with the ends among them, found by a search.
pub const LOADED: [(f64, f64); 4] = [(0.0, 0.15), (0.35, 0.35), (0.65, 0.35), (1.0, 0.15)];

/// A disc inside a belt, and its share of the load on a run of the belt.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Disc {
    /// Middle, x and z in the robot frame, m.
    pub middle: [f64; 2],
    /// Outer radius of the belt, m.
    pub radius: f64,
    /// Share of the load that the run carries on a plane.
    pub share: f64,
}

impl Belt {
    /// Share of a disc that touches a plane alone, as that of a flipper in the air behind it.
    pub const ALONE: f64 = LOADED[1].1;

    /// Returns discs along the run between two rollers, by their numbers.
    pub fn run(&self, from: usize, to: usize) -> [Disc; LOADED.len()] {
        let (one, other) = (self.rollers[from], self.rollers[to]);
        LOADED.map(|(place, share)| {
            let [x, z, radius] = std::array::from_fn(|axis| one[axis] + (other[axis] - one[axis]) * place);
            Disc { middle: [x, z], radius, share }
        })
    }

    /// Returns the discs of the run that lies on a plane below the belt, whose downward normal in the robot frame is given by x and z: the
    /// lowest roller, and the lower one of those beside it.
    pub fn lowest_run(&self, around: &[usize], down: [f64; 2]) -> Vec<Disc> {
        let depth = |&roller: &usize| {
            let [x, z, radius] = self.rollers[roller];
            x * down[0] + z * down[1] + radius
        };
        let deeper = |one: &usize, other: &usize| depth(one).total_cmp(&depth(other));
        let Some(place) = (0..around.len()).max_by(|&one, &other| deeper(&around[one], &around[other])) else {
            return Vec::new();
        };
        let lowest = around[place];
        let beside = [1, around.len() - 1].map(|step| around[(place + step) % around.len()]);
        let next = beside.into_iter().max_by(deeper).filter(|&next| next != lowest);
        let alone = |[x, z, radius]: [f64; 3]| vec![Disc { middle: [x, z], radius, share: 1.0 }];
        next.map_or_else(|| alone(self.rollers[lowest]), |next| self.run(lowest, next).to_vec())
    }

    /// Returns the distance of the farthest point of the belt along a vector from the robot's origin, times its length, m. The vector is
    /// given by x and z in the robot frame, and the belt by the numbers of the rollers that it lies on.
    pub fn reach(&self, around: &[usize], [x, z]: [f64; 2]) -> f64 {
        let length = (x * x + z * z).sqrt();
        let reach = |&roller: &usize| {
            let [own_x, own_z, radius] = self.rollers[roller];
            own_x * x + own_z * z + radius * length
        };
        around.iter().map(reach).fold(f64::NEG_INFINITY, f64::max)
    }

    /// Returns the outline of the belt: the corners of a convex polygon, x and z in the robot frame, m. Its straight runs are exact.
    pub fn outline(&self) -> Vec<[f64; 2]> {
        let mut directions: Vec<f64> =
            (0..CORNERS).map(|number| TAU * f64::from(number) / f64::from(CORNERS)).collect();
        for one in &self.rollers {
            directions.extend(self.rollers.iter().filter_map(|other| run_direction(one, other)));
        }
        let corner = |&[x, z, radius]: &[f64; 3], angle: f64| {
            let (sin, cos) = libm::sincos(angle);
            [x + radius * cos, z + radius * sin]
        };
        let corners = self.rollers.iter().flat_map(|roller| directions.iter().map(move |&angle| corner(roller, angle)));
        convex_hull(corners.collect(), 1e-12)
    }

    /// Returns the length of the belt, m.
    pub fn length(&self) -> f64 {
        let outline = self.outline();
        let next = outline.iter().cycle().skip(1);
        outline.iter().zip(next).map(|(one, other)| distance(one, other)).sum()
    }

    /// Returns the belt's volume as a hull about the sprocket's middle, from end to end of its width, m.
    pub fn hull(&self, width: f64) -> Shape {
        let [x, z] = self.rollers.first().map_or([0.0; 2], |&[x, z, _]| [x, z]);
        let ends = |[along, down]: [f64; 2]| [-0.5, 0.5].map(|end| [along - x, end * width, down - z]);
        Shape::Hull { points: self.outline().into_iter().flat_map(ends).collect() }
    }

    /// Returns the belt's thickness as it is drawn, m.
    fn thickness(&self) -> f64 {
        let least = self.rollers.iter().map(|[.., radius]| *radius).fold(f64::INFINITY, f64::min);
        (0.15 * least).min(0.012)
    }

    /// Returns the belt with its surface farther inside, m.
    fn inside(&self, depth: f64) -> Self {
        Self { rollers: self.rollers.iter().map(|&[x, z, radius]| [x, z, radius - depth]).collect() }
    }

    /// Returns the volume inside the belt, as [`hull`](Self::hull) does.
    pub(crate) fn core(&self, width: f64) -> Shape {
        self.inside(self.thickness()).hull(0.9 * width)
    }

    /// Returns the pads of the belt as they are drawn.
    pub fn pads(&self, width: f64) -> Pads {
        let thickness = self.thickness();
        let middle = self.inside(thickness / 2.0);
        let [x, z] = self.rollers.first().map_or([0.0; 2], |&[x, z, _]| [x, z]);
        let path: Vec<[f64; 2]> = middle.outline().into_iter().map(|[along, down]| [along - x, down - z]).collect();
        let (length, radius) = (middle.length(), self.rollers.first().map_or(0.0, |roller| roller[2]));
        let [least, most] = PADS;
        let count = (length / (PITCH * radius)).clamp(least, most).round();
        Pads { path, count: count as usize, size: [0.6 * length / count, width, thickness], radius }
    }

    /// Returns the numbers of the rollers that the belt lies on, in their order around it.
    pub fn around(&self) -> Vec<usize> {
        let is_on = |corner: &[f64; 2], &[x, z, radius]: &[f64; 3]| {
            (distance(corner, &[x, z]) - radius).abs() < 1e-9 * (1.0 + radius)
        };
        let mut order: Vec<usize> = Vec::new();
        for corner in self.outline() {
            let roller = self.rollers.iter().position(|roller| is_on(&corner, roller));
            order.extend(roller.filter(|roller| order.last() != Some(roller)));
        }
        if order.len() > 1 && order.first() == order.last() {
            order.pop();
        }
        order
    }
}

fn distance(one: &[f64; 2], other: &[f64; 2]) -> f64 {
    ((one[0] - other[0]).powi(2) + (one[1] - other[1]).powi(2)).sqrt()
}

/// Returns the direction, from the middle of a roller, in which the straight run from it to another leaves it. `None` if one is inside the
/// other.
fn run_direction(&[x, z, radius]: &[f64; 3], &[to_x, to_z, other]: &[f64; 3]) -> Option<f64> {
    let (along, down) = (to_x - x, to_z - z);
    let distance = distance(&[x, z], &[to_x, to_z]);
    let lean = (radius - other) / distance;
    (distance > 0.0 && lean.abs() < 1.0).then(|| libm::atan2(down, along) + libm::acos(lean))
}

/// Returns the corners of the convex hull of points in their first two coordinates, in order around it (Andrew's monotone chain).
/// A corner counts if the triangle with its neighbours has more than half of `least` as its area, m².
pub fn convex_hull<const N: usize>(mut points: Vec<[f64; N]>, least: f64) -> Vec<[f64; N]> {
    points.sort_by(|one, other| one[0].total_cmp(&other[0]).then(one[1].total_cmp(&other[1])));
    points.dedup_by(|one, other| distance(&[one[0], one[1]], &[other[0], other[1]]) < 1e-9);
    let half = |points: &mut dyn Iterator<Item = [f64; N]>| {
        let mut chain: Vec<[f64; N]> = Vec::new();
        for point in points {
            while let [.., before, last] = chain[..] {
                let turn =
                    (last[0] - before[0]) * (point[1] - before[1]) - (last[1] - before[1]) * (point[0] - before[0]);
                if turn > least {
                    break;
                }
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let mut outline = half(&mut points.iter().copied());
    outline.extend(half(&mut points.iter().rev().copied()));
    outline
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(rollers: &[[f64; 3]], length: f64, around: &[usize]) {
        let belt = Belt { rollers: rollers.to_vec() };
        let got = belt.length();
        // A chord of 15 degrees is 0.29 % shorter than its arc.
        assert!((0.997..=1.0 + 1e-12).contains(&(got / length)), "{got} is not {length}");
        let (mut got, mut expected) = (belt.around(), around.to_vec());
        got.sort_unstable();
        expected.sort_unstable();
        assert_eq!(got, expected);
    }

    #[test]
    fn a_belt_is_as_long_as_its_runs_and_arcs() {
        check(&[[0.2, 0.0, 0.06], [-0.2, 0.0, 0.06]], 0.8 + TAU * 0.06, &[0, 1]);
        // A roller on the straight run does not lift the belt, nor does one inside.
        check(&[[0.2, 0.0, 0.06], [-0.2, 0.0, 0.06], [0.0, 0.01, 0.04]], 0.8 + TAU * 0.06, &[0, 1]);
        check(&[[0.0, 0.0, 0.1]], TAU * 0.1, &[0]);
        // A flipper: runs of sqrt(d² - (R - r)²), arcs of pi + 2 a and pi - 2 a.
        let lean = libm::asin(0.02 / 0.145);
        let length = 2.0 * (0.145_f64.powi(2) - 0.02_f64.powi(2)).sqrt()
            + 0.06 * (std::f64::consts::PI + 2.0 * lean)
            + 0.04 * (std::f64::consts::PI - 2.0 * lean);
        check(&[[0.0, 0.0, 0.06], [0.145, 0.0, 0.04]], length, &[0, 1]);
    }

    #[test]
    fn a_belt_goes_around_its_outer_rollers_in_order() {
        let belt = Belt { rollers: vec![[0.3, 0.0, 0.05], [0.0, -0.2, 0.05], [-0.3, 0.0, 0.05], [0.0, -0.01, 0.05]] };
        let order = belt.around();
        assert_eq!(order.len(), 3, "{order:?}");
        assert!(!order.contains(&3));
    }
}
