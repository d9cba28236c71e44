//! Sensors as items. What they measure is in [`crate::sensor`].

use gamebots_proto::command::Set;
use gamebots_proto::message::{ItemConf, ItemGeo};
use rand_chacha::ChaCha8Rng;
use scene::{RobotDef, Sensed, SensorDef};

use super::{Effect, Report, State, Verbs, View, mounted};
use crate::sensor::{self, Mounted};
use crate::world::held::Attachments;

#[derive(Clone)]
pub(crate) struct Item {
    /// Number in the robot's class.
    number: usize,
    def: SensorDef,
    sensor: Mounted,
}

impl Item {
    /// Mounts a sensor with a random stream of its own.
    pub(super) fn new(number: usize, def: &SensorDef, rng: ChaCha8Rng, view: &View) -> Self {
        Self { number, def: def.clone(), sensor: sensor::mount(def, rng, &view.on_link(def.link)) }
    }

    /// Tells a camera the tile of its picture, by the number of the sensor.
    pub(super) fn set_tile(&mut self, tile: impl Fn(usize) -> Option<usize>) {
        if let Mounted::Camera(camera) = &mut self.sensor {
            camera.tile = tile(self.number);
        }
    }

    fn sense(&mut self, view: &View) -> Option<Sensed> {
        let reading = self.sensor.get_mut().sense(&view.on_link(self.def.link))?;
        Some(Sensed { robot: view.id, sensor: self.number, reading })
    }
}

impl Verbs for Item {
    fn identity(&self) -> (&'static str, &str) {
        (self.sensor.get().type_name(), &self.def.name)
    }

    fn interval(&self) -> f64 {
        self.def.scan_interval
    }

    fn set(&mut self, set: &Set, view: &View) -> Option<Effect> {
        let opcode = set.opcode.to_ascii_uppercase();
        Some(match self.sensor.get_mut().set(&opcode, set, &view.on_link(self.def.link)) {
            sensor::Effect::None => Effect::None,
            sensor::Effect::Scan => self.sense(view).map_or(Effect::None, Effect::Sensed),
            sensor::Effect::Tag(order) => Effect::Tag(order),
        })
    }

    fn conf(&self, _robot: &RobotDef) -> ItemConf {
        self.sensor.get().conf()
    }

    fn geo(&self, robot: &RobotDef) -> Option<ItemGeo> {
        let SensorDef { name, link, position, direction, .. } = &self.def;
        Some(ItemGeo::Mounted(mounted(robot, name, *link, (*position).into(), *direction)))
    }

    fn report(&mut self, view: &View, _: &Attachments) -> Option<Report> {
        self.sense(view).map(Report::Sensed)
    }

    fn state(&mut self) -> State<'_> {
        self.sensor.get_mut().state()
    }
}
