//! Names and places of the objects in view (ObjectSensor.uc:88-155).

use gamebots_proto::command::Set;
use gamebots_proto::message::{ItemConf, ObjectSensor, PlainConf, SeenObject};
use nalgebra::{Point3, Vector3};
use scene::sensor::object_sensor::{Config, Reading};
use scene::{Pose, SensorDef, Texts, position_and_rotation, rotation_units};

use super::range_scanner::beams;
use super::{Effect, Mount, Sensor, View, floats};

/// Numbers of one object in a reading.
const NUMBERS: usize = 9;

#[derive(Clone)]
pub(crate) struct Mounted {
    name: String,
    pose: Pose,
    max_range: f64,
    /// Directions in the sensor frame, from the right to the left.
    beams: Vec<Vector3<f64>>,
}

pub(super) fn build(config: &Config, mount: Mount) -> Mounted {
    let [field, step] = [config.field_of_view, config.resolution].map(rotation_units::from_radians);
    Mounted {
        name: mount.name.to_owned(),
        pose: mount.pose,
        max_range: config.max_range,
        beams: beams(step.max(1), field, true, false),
    }
}

/// Returns the reading for the wire.
pub(super) fn wire(def: &SensorDef, reading: &Reading) -> ObjectSensor {
    let texts = reading.names.all();
    let seen = |(numbers, texts): (&[f64], &[String])| {
        let (&[x, y, z, roll, pitch, yaw, at_x, at_y, at_z], [name, material]) = (numbers, texts) else { return None };
        Some(SeenObject {
            object: name.clone(),
            location: floats([x, y, z]),
            orientation: floats([roll, pitch, yaw]),
            hit: floats([at_x, at_y, at_z]),
            material: material.clone(),
        })
    };
    let objects = reading.objects.chunks_exact(NUMBERS).zip(texts.chunks_exact(2));
    ObjectSensor { name: def.name.clone(), objects: objects.filter_map(seen).collect() }
}

impl Sensor for Mounted {
    fn type_name(&self) -> &'static str {
        "ObjectSensor"
    }

    fn sense(&mut self, view: &View) -> Option<super::Reading> {
        let pose = view.carrier.pose * self.pose;
        let origin: Point3<f64> = pose.translation.vector.into();
        let sight = view.sight(&origin, self.max_range);
        let (mut seen, mut numbers, mut texts) = (Vec::new(), Vec::new(), Vec::new());
        let mut last = None;
        let directions = self.beams.iter().map(|beam| pose.rotation * beam);
        for (direction, hit) in directions.clone().zip(sight.cast_rays(directions)) {
            let Some(hit) = hit else { continue };
            // To name a robot takes a search, and neighbouring beams mostly hit the same thing.
            if last.replace(hit.identity) == Some(hit.identity) {
                continue;
            }
            // The links of a robot are one object.
            let Some((name, place)) = view.physics.named(hit.identity) else { continue };
            if seen.contains(&name) {
                continue;
            }
            let (position, angles) = position_and_rotation(&place);
            numbers.extend(position);
            numbers.extend(angles);
            numbers.extend(<[f64; 3]>::from((origin + direction * hit.distance).coords));
            texts.extend([name.clone(), view.physics.material_of(&hit).to_owned()]);
            seen.push(name);
        }
        let names = Texts::new(texts.iter().map(String::as_str));
        Some(Reading { objects: numbers.into(), names }.into())
    }

    /// Executes `SCAN`: one more reading goes out at once.
    fn set(&mut self, opcode: &str, _set: &Set, _view: &View) -> Effect {
        if opcode == "SCAN" { Effect::Scan } else { Effect::None }
    }

    fn conf(&self) -> ItemConf {
        PlainConf { name: self.name.clone() }.into()
    }
}
