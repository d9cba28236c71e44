//! Parts of victims in view, a sensor of UT2004 (sensors.md 8).

use gamebots_proto::message::{ItemConf, PlainConf, SeenPart, VictSensor};
use nalgebra::Point3;
use scene::sensor::victim::{Config, Reading};
use scene::{Pose, SensorDef, Victim};

use super::{Mount, Sensor, View, floats};
use crate::physics::Identity;
use crate::site::BodyPart;

/// Numbers of one part in a reading.
const NUMBERS: usize = 4;
/// Most parts of one reading, 11 of each victim.
const MOST: usize = 220;

#[derive(Clone)]
pub(crate) struct Mounted {
    name: String,
    pose: Pose,
    config: Config,
}

pub(super) fn build(config: &Config, mount: Mount) -> Mounted {
    Mounted { name: mount.name.to_owned(), pose: mount.pose, config: config.clone() }
}

/// Returns the reading for the wire.
pub(super) fn wire(def: &SensorDef, reading: &Reading) -> VictSensor {
    let part = |numbers: &[f64]| {
        let &[part, x, y, z] = numbers else { return None };
        let part = Victim::PARTS.get(part as usize)?;
        Some(SeenPart { part: (*part).to_owned(), location: floats([x, y, z]) })
    };
    let parts: Vec<SeenPart> = reading.parts.chunks_exact(NUMBERS).filter_map(part).collect();
    VictSensor { name: def.name.clone(), status: parts.is_empty().then(|| "NoVictims".to_owned()), parts }
}

/// Returns the parts of victims that a sensor sees, with their places in its frame, at most 220. A part is in view if a ray to its middle
/// meets it first.
pub(super) fn in_view<'a>(view: &View<'a>, pose: &Pose, config: &Config) -> Vec<(&'a BodyPart, Point3<f64>)> {
    let pose = view.carrier.pose * pose;
    let sight = view.sight(&pose.translation.vector.into(), config.max_range);
    let placed = view.physics.site().body_parts.iter().map(|part| (part, pose.inverse() * part.position));
    let is_seen = |(part, place): &(&BodyPart, Point3<f64>)| {
        let distance = place.coords.norm();
        let off_axis = libm::atan2(libm::sqrt(place.y * place.y + place.z * place.z), place.x);
        if distance > config.max_range || distance < 1e-6 || off_axis > config.field_of_view / 2.0 {
            return false;
        }
        let hit = sight.cast_ray(&(pose.rotation * (place.coords / distance)));
        hit.is_some_and(|hit| hit.identity == Identity::Solid(part.solid))
    };
    placed.filter(is_seen).take(MOST).collect()
}

impl Sensor for Mounted {
    fn type_name(&self) -> &'static str {
        "VictSensor"
    }

    fn sense(&mut self, view: &View) -> Option<super::Reading> {
        let seen = in_view(view, &self.pose, &self.config);
        let numbers = seen.iter().flat_map(|(part, place)| [part.part as f64, place.x, place.y, place.z]);
        Some(Reading { parts: numbers.collect() }.into())
    }

    fn conf(&self) -> ItemConf {
        PlainConf { name: self.name.clone() }.into()
    }
}
