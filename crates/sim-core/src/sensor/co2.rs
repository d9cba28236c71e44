//! Density of CO2 near victims, a sensor of UT2004. The density of each falls with the square of the distance from the head; walls do not
//! stop it.

use gamebots_proto::message::{Co2, ItemConf, PlainConf};
use nalgebra::Point3;
use scene::sensor::co2::{Config, Reading};
use scene::{Pose, SensorDef, Victim};

use super::{Mount, Sensor, View};

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
pub(super) fn wire(def: &SensorDef, reading: &Reading) -> Co2 {
    Co2 { name: def.name.clone(), density: reading.density as f32 }
}

impl Sensor for Mounted {
    fn type_name(&self) -> &'static str {
        "CO2Sensor"
    }

    fn sense(&mut self, view: &View) -> Option<super::Reading> {
        let place = Point3::from((view.carrier.pose * self.pose).translation.vector);
        let site = view.physics.site();
        let heads = site.body_parts.iter().filter(|part| Victim::PARTS[part.part] == "Head");
        let density = heads.filter_map(|head| {
            let share = (head.position - place).norm() / self.config.half_distance;
            Some(site.victims.get(head.victim)?.co2 / (1.0 + share * share))
        });
        Some(Reading { density: (self.config.background + density.sum::<f64>()).min(1.0) }.into())
    }

    fn conf(&self) -> ItemConf {
        PlainConf { name: self.name.clone() }.into()
    }
}
