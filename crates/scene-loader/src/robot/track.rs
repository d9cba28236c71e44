//! `[tracks]` and `[[track]]`: belts around rollers, driven as wheels are.

use std::ops::Range;

use scene::{Belt, Link};
use serde::Deserialize;

use super::joint::Links;
use super::wheel::{SideEntry, WheelEntry, read_wheel};
use crate::document::{Document, Table, Vector};
use crate::materials::Materials;

/// Numbers of a track; missing ones are taken from `[tracks]`.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct TrackEntry {
    name: Option<String>,
    side: Option<SideEntry>,
    /// Link that carries it; without one, the body.
    link: Option<String>,
    /// Middle of the belt, m.
    y: Option<f64>,
    width: Option<f64>,
    /// x, z and outer radius of the belt of every roller, m. The first is the sprocket.
    rollers: Option<Vec<Vector>>,
    mass: Option<f64>,
    material: Option<String>,
    max_speed: Option<f64>,
    gain: Option<f64>,
    max_torque: Option<f64>,
    integral_time: Option<f64>,
    armature: Option<f64>,
    gear: Option<f64>,
    torque_constant: Option<f64>,
    max_current: Option<f64>,
    rotor_inertia: Option<f64>,
}

/// Reads the tracks. Those with a problem are left out.
pub(super) fn read_tracks<'a>(
    document: &mut Document<'a>,
    root: &mut Table<'a>,
    links: &mut Links,
    materials: &Materials,
) -> Vec<(Range<usize>, Link)> {
    let Ok(common) = document.section::<TrackEntry>(root, "tracks") else { return Vec::new() };
    let common = common.map(|(_, common)| common).unwrap_or_default();
    let (y, rollers) = (common.y, common.rollers.clone());
    let common = common.into_sprocket(None, None);
    let entries = document.list::<TrackEntry>(root, "track");
    let track = |(span, entry): (Range<usize>, TrackEntry)| {
        let rollers = entry.rollers.clone().or_else(|| rollers.clone());
        for (key, is_missing) in [("rollers", rollers.is_none()), ("y", entry.y.or(y).is_none())] {
            if is_missing {
                document.problem(&span, format_args!("missing `{key}`: expected it here or in [tracks]"));
            }
        }
        let (rollers, y) = (rollers?, entry.y.or(y)?);
        let Some(&[x, z, radius]) = rollers.first() else {
            document.problem(&span, "`rollers` is empty: expected the sprocket and the rollers of the belt");
            return None;
        };
        let sprocket = entry.into_sprocket(Some([x, y, z]), Some(radius));
        let mut link = read_wheel(document, &span, sprocket, &common, None, links, materials)?;
        let wheel = link.wheel.as_mut()?;
        wheel.belt = Some(Belt { rollers });
        link.joint.as_mut()?.kind = wheel.joint_kind(true);
        Some((span, link))
    };
    entries.into_iter().filter_map(track).collect()
}

impl TrackEntry {
    /// Returns the sprocket, as if it were a wheel.
    fn into_sprocket(self, position: Option<Vector>, radius: Option<f64>) -> WheelEntry {
        WheelEntry {
            name: self.name,
            side: self.side,
            link: self.link,
            position,
            radius,
            width: self.width,
            mass: self.mass,
            material: self.material,
            max_speed: self.max_speed,
            gain: self.gain,
            max_torque: self.max_torque,
            integral_time: self.integral_time,
            armature: self.armature,
            gear: self.gear,
            torque_constant: self.torque_constant,
            max_current: self.max_current,
            rotor_inertia: self.rotor_inertia,
            ..WheelEntry::default()
        }
    }
}
