//! Lasers: a fan of beams from the right to the left (RangeScanner.uc:18-71, SICK.uc, HokuyoURG04LX.uc).
//!
//! Angles go through USARSim's whole rotation units, which fixes the number of beams: 21, 181 and 228.
//! No noise and no minimum range, as there; a miss reads the maximum range.

#![expect(clippy::approx_constant, reason = "the numbers are those of USARSim's files")]

use gamebots_proto::command::Set;
use gamebots_proto::message::{ItemConf, RangeScanner as Scan, Reading};
use gamebots_proto::number::{radians, rotation_units};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::{Effect, Mount, Sensor, View};
use crate::scene::Pose;

/// The beams of a laser.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fan {
    /// Angle of the first beam, to the right positive, rad.
    pub first: f64,
    /// How far each beam is to the left of the one before, rad.
    pub resolution: f64,
    /// Smallest range, m.
    pub min_range: f64,
    /// What a miss reads, m.
    pub max_range: f64,
    /// Whether all beams are in the sensor's plane of x and y.
    pub level: bool,
}

impl Fan {
    /// How many beams it has.
    pub(super) fn rays(&self) -> usize {
        (2.0 * self.first / self.resolution) as usize + 1
    }
}

macro_rules! scanner {
    ($(#[$doc:meta])* $name:ident { max_range: $max:literal, field_of_view: $fov:literal, resolution: $resolution:literal }) => {
        $(#[$doc])*
        #[derive(Debug, Clone, PartialEq, Deserialize, Serialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct $name {
            /// What a miss reads, m.
            pub max_range: f64,
            /// Reported, not applied, m.
            pub min_range: f64,
            /// Angle between two beams, rad.
            pub resolution: f64,
            /// Angle of the whole fan, rad.
            pub field_of_view: f64,
            /// Whether the fan is spread by yaw.
            pub yaw: bool,
            /// Whether the fan is spread by pitch.
            pub pitch: bool,
        }

        impl Default for $name {
            fn default() -> Self {
                Self {
                    max_range: $max,
                    min_range: 0.1,
                    resolution: $resolution,
                    field_of_view: $fov,
                    yaw: true,
                    pitch: false,
                }
            }
        }

        impl $name {
            /// Numbers that a scan can be made with.
            pub(super) fn validate(&self) -> Result<(), &'static str> {
                let good = self.max_range > 0.0
                    && self.max_range <= 10_000.0
                    && (0.0..=self.max_range).contains(&self.min_range)
                    && (0.0..=std::f64::consts::TAU).contains(&self.field_of_view)
                    && self.resolution > 0.0
                    && self.resolution <= std::f64::consts::TAU
                    && self.field_of_view / self.resolution <= 10_000.0;
                if good {
                    Ok(())
                } else {
                    Err("min_range <= max_range, both 0 to 10000 m, field_of_view and resolution 0 to 2 pi, at most 10000 beams")
                }
            }

            /// The fan as it is cast.
            pub(super) fn fan(&self) -> Fan {
                let [first, resolution] = [rotation_units(self.field_of_view) / 2, rotation_units(self.resolution).max(1)]
                    .map(|units| f64::from(radians(units)));
                let (min_range, max_range) = (self.min_range, self.max_range);
                Fan { first, resolution, min_range, max_range, level: self.yaw && !self.pitch }
            }

            pub(super) fn build(&self, mount: Mount) -> Mounted {
                let (yaw, pitch) = (self.yaw, self.pitch);
                let resolution = rotation_units(self.resolution).max(1);
                let field_of_view = rotation_units(self.field_of_view);
                Mounted {
                    name: mount.name.to_owned(),
                    pose: mount.pose,
                    max_range: self.max_range,
                    min_range: self.min_range,
                    resolution: radians(resolution),
                    field_of_view: radians(field_of_view),
                    yaw,
                    pitch,
                    beams: beams(resolution, field_of_view, yaw, pitch),
                }
            }
        }
    };
}

scanner! {
    /// The plain scanner (DefaultUSAR.ini:100-107).
    RangeScanner { max_range: 4.0, field_of_view: 3.14, resolution: 0.157 }
}
scanner! {
    /// SICK LMS 200 (DefaultUSAR.ini:137-140).
    Sick { max_range: 20.0, field_of_view: 3.14159, resolution: 0.01745 }
}
scanner! {
    /// Hokuyo URG-04LX (DefaultUSAR.ini:94-98).
    HokuyoUrg04Lx { max_range: 4.0, field_of_view: 4.189, resolution: 0.0184086914 }
}

/// Directions in the sensor frame: the first at +field of view / 2 (right, or up), then on by the resolution.
fn beams(resolution: i32, field_of_view: i32, yaw: bool, pitch: bool) -> Vec<Vector3<f64>> {
    let first = field_of_view / 2;
    let mut angles = Vec::new();
    let mut angle = first;
    while f64::from(angle) >= -f64::from(field_of_view) / 2.0 {
        angles.push(f64::from(radians(angle)));
        angle -= resolution;
    }
    let direction = |angle: f64| {
        let turn = |on: bool| if on { angle } else { 0.0 };
        nalgebra::UnitQuaternion::from_euler_angles(0.0, turn(pitch), turn(yaw)) * Vector3::x()
    };
    angles.into_iter().map(direction).collect()
}

pub(super) struct Mounted {
    name: String,
    pose: Pose,
    max_range: f64,
    min_range: f64,
    resolution: f32,
    field_of_view: f32,
    yaw: bool,
    pitch: bool,
    beams: Vec<Vector3<f64>>,
}

impl Sensor for Mounted {
    fn type_name(&self) -> &'static str {
        "RangeScanner"
    }

    fn sense(&mut self, view: &View) -> Option<Reading> {
        let pose = view.body.pose * self.pose;
        let origin = pose.translation.vector.into();
        let range = |beam: &Vector3<f64>| {
            let hit = view.cast_ray(&origin, &(pose.rotation * beam), self.max_range);
            hit.map_or(self.max_range, |hit| hit.distance) as f32
        };
        let reading = Scan {
            name: self.name.clone(),
            resolution: self.resolution,
            field_of_view: self.field_of_view,
            ranges: self.beams.iter().map(range).collect(),
        };
        Some(reading.into())
    }

    /// `SCAN`: one more reading at once.
    fn set(&mut self, opcode: &str, _set: &Set, _view: &View) -> Effect {
        if opcode == "SCAN" { Effect::Scan } else { Effect::None }
    }

    fn conf(&self) -> ItemConf {
        ItemConf::RangeScanner {
            name: self.name.clone(),
            max_range: self.max_range as f32,
            min_range: self.min_range as f32,
            resolution: self.resolution,
            fov: self.field_of_view,
            panning: self.yaw,
            tilting: self.pitch,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(resolution: f64, field_of_view: f64, count: usize, first: f64, last: f64) {
        let beams = beams(rotation_units(resolution), rotation_units(field_of_view), true, false);
        let yaw = |beam: &Vector3<f64>| beam.y.atan2(beam.x);
        assert_eq!(beams.len(), count);
        assert!((yaw(&beams[0]) - first).abs() < 2e-5, "{}", yaw(&beams[0]));
        assert!((yaw(&beams[count - 1]) - last).abs() < 2e-5, "{}", yaw(&beams[count - 1]));
    }

    /// Counts and angles of the real ones (sensors.md 4.2).
    #[test]
    fn fans_have_the_beams_of_usarsim() {
        check(0.157, 3.14, 21, 1.56993, -1.56897);
        check(0.01745, 3.14159, 181, 1.57070, -1.57013);
        check(0.0184086914, 4.189, 228, 2.09446, -2.08410);
    }
}
