//! A reader and writer of RFID tags, and a releaser of new ones: items of UT2004 (sensors.md 8).

use gamebots_proto::command::Set;
use gamebots_proto::message::{ItemConf, PlainConf, Rfid, SeenTag};
use nalgebra::Point3;
use scene::sensor::rfid::{Config, Reading};
use scene::{Pose, RfidTag, SensorDef, Texts};

use super::{Effect, Mount, Sensor, TagOrder, View, floats};

/// Numbers of one tag in a reading.
const NUMBERS: usize = 4;
/// Most tags of one reading.
const MOST: usize = 100;

#[derive(Clone)]
pub(crate) struct Mounted {
    name: String,
    pose: Pose,
    /// Reach of a reader, m; `None` for a releaser.
    reach: Option<f64>,
}

pub(super) fn build(config: &Config, mount: Mount) -> Mounted {
    Mounted { name: mount.name.to_owned(), pose: mount.pose, reach: Some(config.max_range) }
}

pub(super) fn build_releaser(mount: Mount) -> Mounted {
    Mounted { name: mount.name.to_owned(), pose: mount.pose, reach: None }
}

/// Returns the reading for the wire.
pub(super) fn wire(def: &SensorDef, reading: &Reading) -> Rfid {
    let memories = reading.memories.all();
    let tag = |(numbers, memory): (&[f64], &String)| {
        let &[id, x, y, z] = numbers else { return None };
        Some(SeenTag {
            id: id as u32,
            location: floats([x, y, z]),
            memory: Some(memory.clone()).filter(|it| !it.is_empty()),
        })
    };
    let tags = reading.tags.chunks_exact(NUMBERS).zip(&memories);
    Rfid { name: def.name.clone(), tags: tags.filter_map(tag).collect() }
}

impl Mounted {
    /// Returns the tags in reach with their places in the sensor's frame, the nearest first.
    fn near<'a>(&self, view: &View<'a>) -> Vec<(&'a RfidTag, Point3<f64>)> {
        let pose = view.carrier.pose * self.pose;
        let reach = self.reach.unwrap_or(0.0);
        let placed = view.physics.tags.iter().map(|tag| (tag, pose.inverse() * Point3::from(tag.position)));
        let mut near: Vec<_> = placed.filter(|(_, place)| place.coords.norm() <= reach).collect();
        near.sort_by(|(_, a), (_, b)| a.coords.norm().total_cmp(&b.coords.norm()));
        near.truncate(MOST);
        near
    }
}

impl Sensor for Mounted {
    fn type_name(&self) -> &'static str {
        if self.reach.is_some() { "RFID" } else { "RFIDReleaser" }
    }

    /// Reads the tags in reach. Without one it sends nothing.
    fn sense(&mut self, view: &View) -> Option<super::Reading> {
        let near = self.near(view);
        if near.is_empty() {
            return None;
        }
        let numbers = near.iter().flat_map(|(tag, place)| [f64::from(tag.id), place.x, place.y, place.z]);
        let memories = Texts::new(near.iter().map(|(tag, _)| tag.memory.as_str()));
        Some(Reading { tags: numbers.collect(), memories }.into())
    }

    /// Executes `Read` and `Write` of a reader, and `Release` of a releaser. A tag's number comes first in the parameters; what follows it
    /// is written.
    fn set(&mut self, opcode: &str, set: &Set, view: &View) -> Effect {
        match opcode {
            "RELEASE" if self.reach.is_none() => {
                Effect::Tag(TagOrder::Release((view.carrier.pose * self.pose).translation.vector.into()))
            }
            "READ" if self.reach.is_some() => Effect::Scan,
            "WRITE" => {
                let text = set.params.trim();
                let (id, memory) = text.split_once(char::is_whitespace).unwrap_or((text, ""));
                let in_reach = |id: &u32| self.near(view).iter().any(|(tag, _)| tag.id == *id);
                let id = id.trim_end_matches(',').parse().ok().filter(in_reach);
                let write = |id| TagOrder::Write { id, memory: memory.trim().to_owned() };
                id.map_or(Effect::None, |id| Effect::Tag(write(id)))
            }
            _ => Effect::None,
        }
    }

    fn conf(&self) -> ItemConf {
        PlainConf { name: self.name.clone() }.into()
    }
}
