//! A Kinect's depth picture of 320 x 240 points, sent in twenty readings (KinectDepth.uc:21-164). Angles are whole rotation units, so the
//! right edge ends before half of the field of view, as in the original.

use gamebots_proto::command::Set;
use gamebots_proto::message::{ItemConf, RangeImager, RangeImagerConf};
use nalgebra::Vector3;
use scene::sensor::kinect_depth::{COLUMNS, Config, FIELD_OF_VIEW, FRAMES, ROWS, Reading};
use scene::{Pose, SensorDef, rotation_units};

use super::{Effect, Mount, Sensor, State, View, beam};

#[derive(Clone)]
pub(crate) struct Mounted {
    name: String,
    pose: Pose,
    config: Config,
    /// Number of the next part of the picture that is being taken; `FRAMES` or more if none is.
    frame: f64,
}

pub(super) fn build(config: &Config, mount: Mount) -> Mounted {
    let frame = if config.continuous { 0.0 } else { f64::from(FRAMES) };
    Mounted { name: mount.name.to_owned(), pose: mount.pose, config: config.clone(), frame }
}

/// Returns the reading for the wire.
pub(super) fn wire(def: &SensorDef, reading: &Reading) -> RangeImager {
    RangeImager {
        name: def.name.clone(),
        resolution: resolution(),
        field_of_view: field_of_view(),
        frames: reading.frames as u32,
        frame: reading.frame as u32,
        ranges: reading.depths.iter().map(|depth| *depth as f32).collect(),
    }
}

fn resolution() -> Vec<f32> {
    vec![COLUMNS as f32, ROWS as f32]
}

fn field_of_view() -> Vec<f32> {
    FIELD_OF_VIEW.map(|angle| rotation_units::to_radians(rotation_units::from_radians(angle))).to_vec()
}

/// Returns the angles of the columns and of the rows of a part, rad; positive to the right and up.
fn angles(frame: u32) -> [Vec<f64>; 2] {
    let [across, down] = FIELD_OF_VIEW.map(rotation_units::from_radians);
    let (column, row) = (across / COLUMNS as i32, down / ROWS as i32);
    let radians = |units: i32| f64::from(rotation_units::to_radians(units));
    let top = -down / 2 + down * (FRAMES - frame) as i32 / FRAMES as i32;
    let columns = (0..COLUMNS as i32).map(|number| radians(-across / 2 + number * column));
    let rows = (0..(ROWS / FRAMES) as i32).map(|number| radians(top - number * row));
    [columns.collect(), rows.collect()]
}

impl Sensor for Mounted {
    fn type_name(&self) -> &'static str {
        "RangeImager"
    }

    fn sense(&mut self, view: &View) -> Option<super::Reading> {
        if self.frame >= f64::from(FRAMES) {
            return Some(Reading { frames: 0.0, frame: 0.0, depths: [].into() }.into());
        }
        let frame = self.frame;
        self.frame += 1.0;
        if self.config.continuous && self.frame >= f64::from(FRAMES) {
            self.frame = 0.0;
        }
        let pose = view.carrier.pose * self.pose;
        let most = self.config.max_range;
        let sight = view.sight(&pose.translation.vector.into(), most);
        let [columns, rows] = angles(frame as u32);
        let beams = rows.iter().flat_map(|&pitch| columns.iter().map(move |&yaw| beam(yaw, pitch)));
        let beams: Vec<Vector3<f64>> = beams.collect();
        let hits = sight.cast_rays(beams.iter().map(|beam| pose.rotation * beam));
        // A miss is not shortened to its depth.
        let depths = hits.iter().zip(&beams).map(|(hit, beam)| hit.map_or(most, |hit| hit.distance * beam.x));
        Some(Reading { frames: f64::from(FRAMES), frame, depths: depths.collect() }.into())
    }

    /// Executes `SCAN`: the next twenty readings are a picture.
    fn set(&mut self, opcode: &str, _set: &Set, _view: &View) -> Effect {
        if opcode == "SCAN" {
            self.frame = 0.0;
        }
        Effect::None
    }

    fn state(&mut self) -> State<'_> {
        State { numbers: vec![&mut self.frame], ..State::default() }
    }

    fn conf(&self) -> ItemConf {
        RangeImagerConf {
            name: self.name.clone(),
            max_range: self.config.max_range as f32,
            min_range: self.config.min_range as f32,
            resolution: resolution(),
            fov: field_of_view(),
        }
        .into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks against the angles of the original (sensors.md 4.7).
    #[test]
    fn rows_and_columns_have_the_angles_of_usarsim() {
        let units = |angle: f64| (angle * 10430.378).round() as i32;
        let [columns, rows] = angles(0);
        assert_eq!((columns.len(), rows.len()), (320, 12));
        assert_eq!([columns[0], columns[319], rows[0], rows[1]].map(units), [-5279, 4929, 4096, 4062]);
        assert_eq!(units(angles(10)[1][0]), 0);
    }
}
