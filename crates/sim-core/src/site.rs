//! The parts of a map that sensors perceive beside shapes: victims, smoke, sounds, the place on the Earth, and names.

use nalgebra::{Point3, Vector3};
use scene::{Geographic, MapDef, Pose, Smoke, Sound, Victim};

/// A part of a victim that can be seen.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct BodyPart {
    /// Number of the victim.
    pub(crate) victim: usize,
    /// Number of the part in [`Victim::PARTS`].
    pub(crate) part: usize,
    /// Number of its solid on the map.
    pub(crate) solid: u32,
    /// Its middle in the world, m.
    pub(crate) position: Point3<f64>,
}

/// Parts of a map, which its worlds share.
#[derive(Debug, Default)]
pub(crate) struct Site {
    /// Direction of north against the x axis, rad.
    pub(crate) north: f64,
    /// Place of the origin on the Earth.
    pub(crate) origin: Option<Geographic>,
    pub(crate) victims: Vec<Victim>,
    /// Parts of all victims, victim by victim.
    pub(crate) body_parts: Vec<BodyPart>,
    pub(crate) sounds: Vec<Sound>,
    smoke: Vec<Smoke>,
    /// Names and poses of the map's solids.
    solids: Vec<(String, Pose)>,
}

impl Site {
    pub(crate) fn new(map: &MapDef) -> Self {
        let solids = || (0..).zip(&map.solids);
        let parts = map.victims.iter().enumerate().flat_map(|(victim, def)| {
            solids().filter_map(move |(solid, it)| {
                Some(BodyPart { victim, part: def.part(&it.name)?, solid, position: Point3::from(it.position) })
            })
        });
        Self {
            north: map.north,
            origin: map.origin,
            victims: map.victims.clone(),
            body_parts: parts.collect(),
            sounds: map.sounds.clone(),
            smoke: map.smoke.clone(),
            solids: map.solids.iter().map(|solid| (solid.name.clone(), solid.pose())).collect(),
        }
    }

    /// Returns the name and the pose of a solid.
    pub(crate) fn solid(&self, number: u32) -> Option<(&str, Pose)> {
        self.solids.get(number as usize).map(|(name, pose)| (name.as_str(), *pose))
    }

    /// Returns the smoke along a path from a point: its density times the length of the path in it.
    pub(crate) fn smoke(&self, origin: &Point3<f64>, direction: &Vector3<f64>, length: f64) -> f64 {
        self.smoke.iter().map(|smoke| smoke.density * inside(smoke, origin, direction, length)).sum()
    }
}

/// Returns the length of a path inside of a box of smoke, m. The direction has length 1.
fn inside(smoke: &Smoke, origin: &Point3<f64>, direction: &Vector3<f64>, length: f64) -> f64 {
    let (mut enter, mut leave) = (0.0, length);
    for axis in 0..3 {
        let from_middle = smoke.position[axis] - origin[axis];
        let half = smoke.size[axis] / 2.0;
        if direction[axis].abs() < 1e-12 {
            if from_middle.abs() > half {
                return 0.0;
            }
            continue;
        }
        let ends = [(from_middle - half) / direction[axis], (from_middle + half) / direction[axis]];
        enter = f64::max(enter, ends[0].min(ends[1]));
        leave = f64::min(leave, ends[0].max(ends[1]));
    }
    (leave - enter).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(origin: [f64; 3], direction: [f64; 3], length: f64, expected: f64) {
        let smoke = Smoke { name: "s".to_owned(), position: [5.0, 0.0, -1.0], size: [2.0, 4.0, 2.0], density: 0.5 };
        let site = Site { smoke: vec![smoke], ..Site::default() };
        let got = site.smoke(&origin.into(), &Vector3::from(direction).normalize(), length);
        assert!((got - 0.5 * expected).abs() < 1e-12, "{got}");
    }

    #[test]
    fn smoke_counts_along_the_path_within_its_box() {
        check([0.0, 0.0, -1.0], [1.0, 0.0, 0.0], 10.0, 2.0);
        check([0.0, 0.0, -1.0], [1.0, 0.0, 0.0], 5.0, 1.0);
        check([0.0, 0.0, -1.0], [-1.0, 0.0, 0.0], 10.0, 0.0);
        check([5.0, 0.0, -1.0], [0.0, 1.0, 0.0], 10.0, 2.0);
        check([0.0, 3.0, -1.0], [1.0, 0.0, 0.0], 10.0, 0.0);
        check([4.0, -2.0, -1.0], [1.0, 1.0, 0.0], 10.0, 2.0 * std::f64::consts::SQRT_2);
    }
}
