//! Latitude and longitude from satellites (GPSSensor.uc). x points north and y east; a degree has a fixed length.
//!
//! The original looks for the sky in the wrong place of a name and rejects every satellite; this is what it means. Its satellites stand
//! still, and so do these: the 24 slots of the baseline constellation in the GPS Standard Positioning Service Performance Standard (2020,
//! table 3.2-1), at a moment at which 11 are in view from the original's default origin, as many as of its own table.

use gamebots_proto::message::{Bearing, Gps, ItemConf, PoseConf};
use nalgebra::Vector3;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use scene::sensor::gps::{Config, Reading};
use scene::{Geographic, Pose, SensorDef};

use super::{Mount, Sensor, State, View};

/// Length of a degree to the north and to the east, m (GPSSensor.uc).
const DEGREE: [f64; 2] = [111_200.0, 71_670.0];
/// Satellites for a fix.
const FIX: usize = 4;
/// Radius of the Earth, m.
const EARTH: f64 = 6_378_137.0;
/// Radius of the orbits, m.
const ORBIT: f64 = 26_559_700.0;
/// Least elevation of a satellite in view, degrees.
const LEAST_ELEVATION: f64 = 5.0;
/// Inclination of the orbits, degrees.
const INCLINATION: f64 = 55.0;
/// Longitudes of the ascending nodes of the six orbits, degrees.
const NODES: [f64; 6] = [272.847, 332.847, 32.847, 92.847, 152.847, 212.847];
/// Arguments of latitude of the four satellites on each orbit, degrees.
const SLOTS: [[f64; 4]; 6] = [
    [268.126, 161.786, 11.676, 41.806],
    [80.956, 173.336, 309.976, 204.376],
    [111.876, 11.796, 339.666, 241.556],
    [135.226, 265.446, 35.136, 167.356],
    [197.046, 302.596, 66.066, 333.686],
    [238.886, 345.226, 105.206, 135.346],
];
/// Moment of the constellation: angles of the satellites on their orbits and of the Earth, degrees past those of the table.
const MOMENT: f64 = 220.0;
/// Distance within which an obstacle hides a satellite, m.
const HORIZON: f64 = 1000.0;

#[derive(Clone)]
pub(crate) struct Mounted {
    name: String,
    scan_interval: f64,
    pose: Pose,
    config: Config,
    origin: Geographic,
    /// Directions of the satellites above the horizon of the origin, in the world.
    sky: Vec<Vector3<f64>>,
    rng: ChaCha8Rng,
}

pub(super) fn build(config: &Config, mount: Mount) -> Mounted {
    let own = Geographic { latitude: config.latitude, longitude: config.longitude };
    let origin = mount.view.physics.site().origin.unwrap_or(own);
    Mounted {
        name: mount.name.to_owned(),
        scan_interval: mount.scan_interval,
        pose: mount.pose,
        config: config.clone(),
        origin,
        sky: satellites(origin),
        rng: mount.rng,
    }
}

/// Returns the directions of the satellites above the horizon of a place: x to the north, y to the east, z down.
fn satellites(place: Geographic) -> Vec<Vector3<f64>> {
    let (latitude, longitude) = (place.latitude.to_radians(), place.longitude.to_radians());
    let ([sin_lat, cos_lat], [sin_lon, cos_lon]) = (sin_cos(latitude), sin_cos(longitude));
    let up = Vector3::new(cos_lat * cos_lon, cos_lat * sin_lon, sin_lat);
    let east = Vector3::new(-sin_lon, cos_lon, 0.0);
    let north = up.cross(&east);
    let slots = NODES.iter().zip(SLOTS).flat_map(|(&node, slots)| slots.map(|slot| (node, slot)));
    let directions = slots.map(|(node, slot)| {
        // While a satellite goes around twice, the Earth turns once.
        let [sin_node, cos_node] = sin_cos((node - MOMENT / 2.0).to_radians());
        let [sin_slot, cos_slot] = sin_cos((slot + MOMENT).to_radians());
        let [sin_incl, cos_incl] = sin_cos(INCLINATION.to_radians());
        let satellite = Vector3::new(
            cos_node * cos_slot - sin_node * sin_slot * cos_incl,
            sin_node * cos_slot + cos_node * sin_slot * cos_incl,
            sin_slot * sin_incl,
        );
        let away = (satellite * ORBIT - up * EARTH).normalize();
        Vector3::new(away.dot(&north), away.dot(&east), -away.dot(&up))
    });
    let [least, _] = sin_cos(LEAST_ELEVATION.to_radians());
    directions.filter(|direction| -direction.z > least).collect()
}

fn sin_cos(angle: f64) -> [f64; 2] {
    let (sin, cos) = libm::sincos(angle);
    [sin, cos]
}

/// Returns the reading for the wire.
pub(super) fn wire(def: &SensorDef, reading: &Reading) -> Gps {
    let satellites = reading.satellites as usize;
    let bearing = |degrees: f64, letters: [char; 2]| {
        let whole = degrees.abs().trunc();
        let letter = letters[usize::from(degrees < 0.0)];
        let minutes = ((degrees.abs() - whole) * 60.0) as f32;
        (satellites >= FIX).then_some(Bearing { degrees: whole as u32, minutes, letter })
    };
    Gps {
        name: def.name.clone(),
        latitude: bearing(reading.latitude, ['N', 'S']),
        longitude: bearing(reading.longitude, ['E', 'W']),
        fix: u32::from(satellites >= FIX),
        satellites: satellites as u32,
    }
}

impl Sensor for Mounted {
    fn type_name(&self) -> &'static str {
        "GPS"
    }

    fn sense(&mut self, view: &View) -> Option<super::Reading> {
        let position = (view.carrier.pose * self.pose).translation.vector;
        let sight = view.sight(&position.into(), HORIZON);
        let satellites = self.sky.iter().filter(|direction| sight.cast_ray(direction).is_none()).count();
        if satellites < FIX {
            return Some(Reading { latitude: 0.0, longitude: 0.0, satellites: satellites as f64 }.into());
        }
        let Config { max_noise, min_noise, .. } = self.config;
        // The error falls linearly from 4 to 12 satellites, and is three standard deviations.
        let slope = (min_noise - max_noise) / 8.0;
        let deviation = ((max_noise + slope * (satellites as f64 - 4.0)) / 3.0).max(0.0);
        let mut place = |axis: usize| {
            let noise: f64 = StandardNormal.sample(&mut self.rng);
            (position[axis] + deviation * noise) / DEGREE[axis]
        };
        let (north, east) = (place(0), place(1));
        let latitude = self.origin.latitude + north;
        let longitude = self.origin.longitude + east;
        Some(Reading { latitude, longitude, satellites: satellites as f64 }.into())
    }

    fn state(&mut self) -> State<'_> {
        State { random: Some(&mut self.rng), ..State::default() }
    }

    fn conf(&self) -> ItemConf {
        PoseConf { name: self.name.clone(), scan_interval: self.scan_interval as f32 }.into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eleven_satellites_are_above_the_default_origin() {
        let Config { latitude, longitude, .. } = Config::default();
        assert_eq!(satellites(Geographic { latitude, longitude }).len(), 11);
        for latitude in [-80.0, -40.0, 0.0, 60.0, 89.0] {
            let seen = satellites(Geographic { latitude, longitude: 30.0 }).len();
            assert!((5..=14).contains(&seen), "{seen} at {latitude}");
        }
    }
}
