//! `[wheels]`, `[[wheel]]`, `[rollers]` and `[[caster]]`.

use std::ops::Range;

use names::{did_you_mean, listed};
use scene::{Link, Motor, MountedWheel, Rollers, Side, Tyre, Wheel, check};
use serde::Deserialize;

use super::joint::Links;
use crate::document::{Document, Table, Vector};
use crate::materials::Materials;

/// Numbers of a wheel; missing ones are taken from `[wheels]`.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(super) struct WheelEntry {
    pub(super) name: Option<String>,
    pub(super) side: Option<SideEntry>,
    pub(super) joint: Option<String>,
    pub(super) position: Option<Vector>,
    pub(super) radius: Option<f64>,
    pub(super) width: Option<f64>,
    pub(super) mass: Option<f64>,
    pub(super) material: Option<String>,
    pub(super) max_speed: Option<f64>,
    pub(super) gain: Option<f64>,
    pub(super) max_torque: Option<f64>,
    pub(super) integral_time: Option<f64>,
    pub(super) armature: Option<f64>,
    pub(super) gear: Option<f64>,
    pub(super) torque_constant: Option<f64>,
    pub(super) max_current: Option<f64>,
    pub(super) rotor_inertia: Option<f64>,
    pub(super) tyre: Option<Tyre>,
    pub(super) roller_angle: Option<f64>,
    pub(super) first_roller: Option<f64>,
    /// Link that carries it; without one, the body.
    pub(super) link: Option<String>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum SideEntry {
    Left,
    Right,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RollersEntry {
    count: u32,
    axis_circle: f64,
    half_length: Option<f64>,
    mass: f64,
    damping: f64,
    #[serde(default)]
    bearing_friction: f64,
    material: String,
    /// Friction instead of the material's.
    friction: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CasterEntry {
    name: String,
    position: Vector,
    radius: f64,
    mass: f64,
    material: String,
    /// Link that carries it; without one, the body.
    link: Option<String>,
}

pub(super) fn read_wheel(
    document: &mut Document,
    span: &Range<usize>,
    entry: WheelEntry,
    common: &WheelEntry,
    rollers: Option<&(Range<usize>, RollersEntry)>,
    links: &mut Links,
    materials: &Materials,
) -> Option<Link> {
    let parent = entry.link.as_deref().map(|link| links.find(document, span, "link", Some(link)));
    let joint = match (&entry.joint, &links.wheels) {
        (None, _) => None,
        (Some(name), None) => {
            document.problem(span, format_args!("joint `{name}`: expected a `urdf` that has it"));
            return None;
        }
        (Some(_), Some(_)) if !links.complete => return None,
        (Some(name), Some(wheels)) => {
            let joint = wheels.iter().find(|wheel| &wheel.joint == name);
            if joint.is_none() {
                let names = listed(wheels.iter().map(|wheel| wheel.joint.as_str()));
                let expected = if names.is_empty() { "it has none".to_owned() } else { format!("one of {names}") };
                let meant = did_you_mean(name, wheels.iter().map(|wheel| wheel.joint.as_str()));
                let message = format!("joint `{name}`: expected a continuous joint of the URDF: {expected}{meant}");
                document.problem(span, message);
            }
            Some(joint?)
        }
    };
    let mut number = |key: &str, own: Option<f64>, urdf: Option<f64>, common: Option<f64>| {
        let value = own.or(urdf).or(common);
        if value.is_none() {
            document.problem(
                span,
                format_args!("missing `{key}`: expected it here, in the table that all share, or in the URDF"),
            );
        }
        value
    };
    let radius = number("radius", entry.radius, None, common.radius);
    let width = number("width", entry.width, None, common.width);
    let mass = number("mass", entry.mass, joint.map(|joint| joint.mass), common.mass);
    let max_speed = number("max_speed", entry.max_speed, joint.and_then(|joint| joint.max_speed), common.max_speed);
    let gain = number("gain", entry.gain, None, common.gain);
    let gearbox = gearbox(&entry, common);
    let max_torque = number(
        "max_torque",
        entry.max_torque,
        joint.and_then(|joint| joint.max_torque),
        common.max_torque.or(gearbox.max_torque),
    );
    let armature = entry.armature.or(common.armature).or(gearbox.armature).unwrap_or(0.0);
    let integral_time = entry.integral_time.or(common.integral_time);
    let mut missing = |key: &str| document.problem(span, format_args!("missing `{key}`"));
    let link = joint.map(|joint| &links.links[joint.link]);
    let position = entry.position.or(link.map(Link::origin));
    let material = entry.material.or(common.material.clone());
    for (key, there) in [
        ("name", entry.name.is_some()),
        ("side", entry.side.is_some()),
        ("position", position.is_some()),
        ("material", material.is_some()),
    ] {
        if !there {
            missing(key);
        }
    }
    let material = document.material(span, &material?, materials);
    let rollers = match (entry.roller_angle.or(common.roller_angle), rollers) {
        (Some(angle), Some((place, rollers))) => {
            let first_roller = entry.first_roller.or(common.first_roller).unwrap_or(0.0);
            let rollers = read_rollers(document, place, rollers, angle, radius?, materials)?;
            Some(Rollers { first_roller, ..rollers })
        }
        (Some(_), None) => {
            document.problem(span, "`roller_angle` without a [rollers] table");
            None
        }
        (None, _) => None,
    };
    let side = match entry.side? {
        SideEntry::Left => Side::Left,
        SideEntry::Right => Side::Right,
    };
    let motor =
        Motor { max_speed: max_speed?, gain: gain?, max_torque: max_torque?, stiffness: None, integral_time, armature };
    let tyre = entry.tyre.or(common.tyre);
    let wheel = Wheel { side, radius: radius?, width: width?, mass: mass?, material, rollers, belt: None, tyre };
    let mut wheel = Link::of_wheel(entry.name?, position?, Some(motor), wheel);
    if let (Some(link), Some(joint)) = (link, joint) {
        wheel.visuals.clone_from(&link.visuals);
        wheel.joint.as_mut()?.parent = link.joint.as_ref()?.parent;
        links.taken.push(joint.link);
    }
    if let Some(parent) = parent {
        wheel.joint.as_mut()?.parent = parent?;
    }
    Some(wheel)
}

/// Lists the problems of a link's wheel; empty without one.
pub(super) fn wrong_wheel(link: &Link) -> Vec<String> {
    MountedWheel::of((1, link)).map_or(Vec::new(), |wheel| check::wheel(&wheel))
}

/// Limits that follow from a motor behind a gear.
struct Gearbox {
    /// Torque limit at the wheel, N m: gear x torque constant x current.
    max_torque: Option<f64>,
    /// Inertia of the rotor as felt at the wheel, kg m²: rotor inertia x gear².
    armature: Option<f64>,
}

fn gearbox(entry: &WheelEntry, common: &WheelEntry) -> Gearbox {
    let gear = entry.gear.or(common.gear);
    let per_ampere = gear.zip(entry.torque_constant.or(common.torque_constant)).map(|(gear, constant)| gear * constant);
    let max_torque = per_ampere.zip(entry.max_current.or(common.max_current)).map(|(torque, current)| torque * current);
    let armature = gear.zip(entry.rotor_inertia.or(common.rotor_inertia)).map(|(gear, inertia)| inertia * gear * gear);
    Gearbox { max_torque, armature }
}

fn read_rollers(
    document: &mut Document,
    place: &Range<usize>,
    entry: &RollersEntry,
    angle: f64,
    wheel_radius: f64,
    materials: &Materials,
) -> Option<Rollers> {
    let mut material = document.material(place, &entry.material, materials);
    if let Some(friction) = entry.friction {
        document.within(place, "friction", friction, check::FRICTION);
        material.friction = friction;
    }
    let RollersEntry { count, axis_circle, mass, damping, bearing_friction, .. } = *entry;
    let last_phase = std::f64::consts::PI / f64::from(count);
    let mut rollers =
        Rollers { count, axis_circle, angle, first_roller: 0.0, last_phase, mass, damping, bearing_friction, material };
    // An invalid wheel radius or roller angle is reported by itself, not as a problem of the rollers.
    let sound = check::WHEEL_RADIUS.holds(wheel_radius) && check::ROLLER_ANGLE.holds(angle.abs());
    let wrong = if sound { check::rollers(&rollers, wheel_radius) } else { Vec::new() };
    if let Some(half_length) = entry.half_length.filter(|_| sound && wrong.is_empty()) {
        rollers.last_phase = last_phase_of(document, place, &rollers, half_length, wheel_radius)?;
    }
    document.wrong(place, wrong);
    Some(rollers)
}

/// Returns the phase at which a roller of this half length ends. It lies between the least phase without a gap and that of the
/// longest roller.
fn last_phase_of(
    document: &mut Document,
    place: &Range<usize>,
    rollers: &Rollers,
    half_length: f64,
    wheel_radius: f64,
) -> Option<f64> {
    // The end of the longest roller has a tenth of the radius of its middle.
    let thin = 0.1 * (wheel_radius - rollers.axis_circle);
    let (mut low, mut high) = (rollers.last_phase, (rollers.axis_circle / (wheel_radius - thin)).acos());
    let [least, most] = [low, high].map(|phase| rollers.half_length_at(phase, wheel_radius));
    // A deficit of up to a tenth of a millimetre is rounding in a data sheet.
    if !(least - 1e-4..=most).contains(&half_length) {
        let message = format!("`half_length` is {half_length}: expected {least:.5} (no gap) to {most:.5}");
        document.problem(place, message);
        return None;
    }
    for _ in 0..60 {
        let middle = (low + high) / 2.0;
        if rollers.half_length_at(middle, wheel_radius) < half_length {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some(low)
}

pub(super) fn read_casters<'a>(
    document: &mut Document<'a>,
    root: &mut Table<'a>,
    links: &Links,
    materials: &Materials,
) -> Vec<Link> {
    let mut casters = Vec::new();
    for (span, entry) in document.list::<CasterEntry>(root, "caster") {
        let CasterEntry { name, position, radius, mass, material, link } = entry;
        let Some(parent) = links.find(document, &span, "link", link.as_deref()) else { continue };
        if links.taken.contains(&parent) {
            document.problem(&span, format_args!("caster `{name}` hangs on a wheel: expected another link"));
            continue;
        }
        let side = if position[1] < 0.0 { Side::Left } else { Side::Right };
        let material = document.material(&span, &material, materials);
        let width = 2.0 * radius;
        let wheel = Wheel { side, radius, width, mass, material, rollers: None, belt: None, tyre: None };
        let mut caster = Link::of_wheel(name, position, None, wheel);
        if let Some(joint) = &mut caster.joint {
            joint.parent = parent;
        }
        document.wrong(&span, wrong_wheel(&caster));
        casters.push(caster);
    }
    casters
}
