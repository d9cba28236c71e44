//! A camera on the control connection, as in USARSim: it has a zoom and sends an empty line ten times a second (USARCamera.uc). Its
//! pictures belong to the image server.

use gamebots_proto::command::Set;
use gamebots_proto::message::{CameraConf, ItemConf};
use scene::sensor::camera::{Config, Reading};

use super::{Effect, Mount, Sensor, State, View};

/// Width and height of its picture at the image server, pixels (DefaultUSAR.ini:429-433).
const PICTURE: [i32; 2] = [320, 240];

/// Narrowest and widest field of view that a flat picture can show, degrees.
const DRAWN: [f64; 2] = [1.0, 170.0];

#[derive(Clone)]
pub(crate) struct Mounted {
    name: String,
    /// Tile of its picture at the image server, 0 to 3 by rows.
    pub(crate) tile: Option<usize>,
    /// Default, narrowest and widest field of view, whole degrees.
    default: f64,
    min: f64,
    max: f64,
    now: f64,
}

pub(super) fn build(config: &Config, mount: Mount) -> Mounted {
    let [default, min, max] = [config.field_of_view, config.min_field_of_view, config.max_field_of_view]
        .map(|angle| angle.to_degrees().round());
    Mounted { name: mount.name.to_owned(), tile: None, default, min, max, now: default }
}

impl Sensor for Mounted {
    fn type_name(&self) -> &'static str {
        "Camera"
    }

    fn sense(&mut self, _view: &View) -> Option<super::Reading> {
        let [narrowest, widest] = DRAWN;
        Some(Reading { field_of_view: self.now.clamp(narrowest, widest).to_radians() }.into())
    }

    /// Sets the field of view: `ZOOM` or `FOV` in radians, truncated to whole degrees. 0 restores the default.
    fn set(&mut self, opcode: &str, set: &Set, _view: &View) -> Effect {
        if (opcode == "ZOOM" || opcode == "FOV")
            && let Some([angle]) = set.numbers().as_deref()
        {
            let degrees = angle.to_degrees().trunc();
            self.now = if degrees == 0.0 { self.default } else { degrees.clamp(self.min, self.max) };
        }
        Effect::None
    }

    fn state(&mut self) -> State<'_> {
        State { numbers: vec![&mut self.now], ..State::default() }
    }

    fn conf(&self) -> ItemConf {
        let (tile, [width, height]) = (self.tile.unwrap_or_default() as i32, PICTURE);
        let [default_fov, min_fov, max_fov, fov] =
            [self.default, self.min, self.max, self.now].map(|angle| angle as f32);
        CameraConf {
            name: self.name.clone(),
            offset_x: width * (tile % 2),
            offset_y: height * (tile / 2),
            resolution_x: width,
            resolution_y: height,
            default_fov,
            min_fov,
            max_fov,
            fov,
        }
        .into()
    }
}
