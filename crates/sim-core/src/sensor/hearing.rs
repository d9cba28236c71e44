//! Hearing: the loudness of a map's sounds at a place (AcousticArraySensor.uc:62-162).

use nalgebra::Point3;
use scene::Sound;
use scene::sensor::acoustic::Config;

use super::View;

/// Loudness of a volume of 1 at a distance of 1 m, dB (DefaultUSAR.ini:44: one unit of volume is 0.008539412 of a decibel).
const LOUDEST: f64 = 1.0 / 0.008539412;

/// A sound at a place.
pub(super) struct Heard {
    /// Vector from the place to the source in the world, m.
    pub(super) away: nalgebra::Vector3<f64>,
    /// Loudness, dB. `None` if it is too far or too quiet.
    pub(super) loudness: Option<f64>,
}

/// Returns how a sound is heard at a place. Behind a wall it is as loud as at twice the distance. The original doubles it in the open, and
/// means this.
pub(super) fn hear(view: &View, config: &Config, place: &Point3<f64>, sound: &Sound) -> Heard {
    let away = Point3::from(sound.position) - place;
    let distance = away.norm();
    // A ray that ends just before the source, which may be a victim's head.
    let reach = (distance - 0.15).max(0.0);
    let is_hidden = reach > 0.0 && view.sight(place, reach).cast_ray(&(away / distance)).is_some();
    let path = if is_hidden { 2.0 * distance } else { distance };
    // Closer than a metre the loudness does not grow.
    let loudness = (sound.volume * LOUDEST).trunc() - 20.0 * libm::log10(path.max(1.0));
    Heard { away, loudness: (path <= config.hear_threshold && loudness > 0.0).then_some(loudness) }
}
