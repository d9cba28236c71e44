//! Laser scanners: a fan of beams from right to left (RangeScanner.uc:18-71, SICK.uc, HokuyoURG04LX.uc).
//!
//! Angles are rounded to USARSim's whole rotation units, which fixes the numbers of beams at 21, 181 and 228. As in USARSim there is no
//! noise and no minimum range, and a miss reads the maximum range. Infrared beams (IRScanner.uc) pass through transparent materials and have
//! a minimum range. A Hokuyo's beam that passes too much smoke reads 0 (HokuyoURG04LX.uc:13-133).

use gamebots_proto::command::Set;
use gamebots_proto::message::{IrScanner, ItemConf, RangeScanner as Scan, RangeScannerConf};
use nalgebra::Vector3;
use scene::sensor::RangeScanner;
use scene::sensor::range_scanner::Reading;
use scene::{Pose, SensorDef, rotation_units};

use super::{Effect, Mount, Sensor, View, beam};
use crate::physics::Light;

pub(super) fn build(config: &RangeScanner, mount: Mount) -> Mounted {
    let RangeScanner { max_range, min_range, yaw, pitch, infrared, smoke, .. } = *config;
    let units = (config.resolution_units(), rotation_units::from_radians(config.field_of_view));
    let (resolution, field_of_view) = angles(config);
    Mounted {
        name: mount.name.to_owned(),
        pose: mount.pose,
        max_range,
        min_range,
        resolution,
        field_of_view,
        yaw,
        pitch,
        light: if infrared { Light::Infrared } else { Light::Visible },
        smoke,
        beams: beams(units.0, units.1, yaw, pitch),
    }
}

/// Returns the beam directions in the sensor frame. The first is at +field of view / 2 (right, or up); the angle falls by the resolution
/// from beam to beam.
pub(super) fn beams(resolution: i32, field_of_view: i32, yaw: bool, pitch: bool) -> Vec<Vector3<f64>> {
    let first = field_of_view / 2;
    let mut angles = Vec::new();
    let mut angle = first;
    while f64::from(angle) >= -f64::from(field_of_view) / 2.0 {
        angles.push(f64::from(rotation_units::to_radians(angle)));
        angle -= resolution;
    }
    let turn = |on: bool, angle: f64| if on { angle } else { 0.0 };
    angles.into_iter().map(|angle| beam(turn(yaw, angle), turn(pitch, angle))).collect()
}

#[derive(Clone)]
pub(crate) struct Mounted {
    name: String,
    pose: Pose,
    max_range: f64,
    min_range: f64,
    resolution: f32,
    field_of_view: f32,
    yaw: bool,
    pitch: bool,
    light: Light,
    /// Smoke that a beam passes before it reads 0.
    smoke: Option<f64>,
    beams: Vec<Vector3<f64>>,
}

/// Returns the reading for the wire.
pub(super) fn wire(def: &SensorDef, reading: &Reading) -> Scan {
    let (resolution, field_of_view) = def.config.laser().map_or((0.0, 0.0), angles);
    Scan {
        name: def.name.clone(),
        resolution,
        field_of_view,
        ranges: reading.ranges.iter().map(|range| *range as f32).collect(),
    }
}

/// Returns the reading of an infrared scanner for the wire.
pub(super) fn wire_infrared(def: &SensorDef, reading: &Reading) -> IrScanner {
    let Scan { name, resolution, field_of_view, ranges } = wire(def, reading);
    IrScanner { name, resolution, field_of_view, ranges }
}

/// Returns resolution and field of view, rad, in whole rotation units.
fn angles(config: &RangeScanner) -> (f32, f32) {
    let field_of_view = rotation_units::from_radians(config.field_of_view);
    (rotation_units::to_radians(config.resolution_units()), rotation_units::to_radians(field_of_view))
}

impl Sensor for Mounted {
    fn type_name(&self) -> &'static str {
        if self.light == Light::Infrared { "IRScanner" } else { "RangeScanner" }
    }

    fn sense(&mut self, view: &View) -> Option<super::Reading> {
        let pose = view.carrier.pose * self.pose;
        let origin = pose.translation.vector.into();
        let sight = view.sight_in(self.light, &origin, self.max_range);
        let least = if self.light == Light::Infrared { self.min_range } else { 0.0 };
        let mut ranges = sight.ranges(self.beams.iter().map(|beam| pose.rotation * beam));
        for (range, beam) in ranges.iter_mut().zip(&self.beams) {
            let smoke = || view.physics.site().smoke(&origin, &(pose.rotation * beam), *range);
            let is_lost = self.smoke.is_some_and(|most| smoke() > most);
            *range = if is_lost { 0.0 } else { range.max(least) };
        }
        Some(Reading { ranges: ranges.into() }.into())
    }

    /// Executes `SCAN`: one more reading goes out at once.
    fn set(&mut self, opcode: &str, _set: &Set, _view: &View) -> Effect {
        if opcode == "SCAN" { Effect::Scan } else { Effect::None }
    }

    fn conf(&self) -> ItemConf {
        RangeScannerConf {
            name: self.name.clone(),
            max_range: self.max_range as f32,
            min_range: self.min_range as f32,
            resolution: self.resolution,
            fov: self.field_of_view,
            panning: self.yaw,
            tilting: self.pitch,
        }
        .into()
    }
}

#[cfg(test)]
#[expect(clippy::approx_constant, reason = "the numbers are those of USARSim's files")]
mod tests {
    use super::*;

    fn check(resolution: f64, field_of_view: f64, count: usize, first: f64, last: f64) {
        let beams =
            beams(rotation_units::from_radians(resolution), rotation_units::from_radians(field_of_view), true, false);
        let yaw = |beam: &Vector3<f64>| libm::atan2(beam.y, beam.x);
        assert_eq!(beams.len(), count);
        assert!((yaw(&beams[0]) - first).abs() < 2e-5, "{}", yaw(&beams[0]));
        assert!((yaw(&beams[count - 1]) - last).abs() < 2e-5, "{}", yaw(&beams[count - 1]));
    }

    /// Checks counts and angles against those of USARSim (sensors.md 4.2).
    #[test]
    fn fans_have_the_beams_of_usarsim() {
        check(0.157, 3.14, 21, 1.56993, -1.56897);
        check(0.01745, 3.14159, 181, 1.57070, -1.57013);
        check(0.0184086914, 4.189, 228, 2.09446, -2.08410);
    }
}
