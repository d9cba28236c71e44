//! `robot.toml`: parts, wheels, sensors and battery of a class of robots.

use std::ops::Range;

use nalgebra::{Matrix3, Vector3};
use serde::Deserialize;
use sim_core::scene::{
    self, Battery, DriveModel, Motor, Part, RobotDef, Rollers, SensorDef, Shape, Side, Solid, Steering, Wheel,
};
use sim_core::sensor;

use crate::document::{Document, Table, Vector};
use crate::materials::Materials;
use crate::problem::Problems;
use crate::source::Source;
use crate::urdf::{self, Urdf};

const KEYS: &str = "description, steering, reported_steering, drive_model, one_side_drives, reported_max_torque, urdf, urdf_material, link, part, wheels, rollers, wheel, \
                    caster, sensor, battery";

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum SteeringEntry {
    Skid,
    Omni,
}

/// A part of the body: a solid box that gives its mass, and the shape that touches the world unless it is hidden.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PartEntry {
    name: String,
    mass: f64,
    #[serde(default)]
    position: Vector,
    #[serde(default)]
    rotation: Vector,
    size: Vector,
    material: String,
    #[serde(default = "yes")]
    collides: bool,
}

fn yes() -> bool {
    true
}

/// Numbers of a wheel; those missing are taken from `[wheels]`.
#[derive(Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct WheelEntry {
    name: Option<String>,
    side: Option<SideEntry>,
    joint: Option<String>,
    position: Option<Vector>,
    radius: Option<f64>,
    width: Option<f64>,
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
    roller_angle: Option<f64>,
    first_roller: Option<f64>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
enum SideEntry {
    Left,
    Right,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RollersEntry {
    count: u32,
    axis_circle: f64,
    half_length: Option<f64>,
    mass: f64,
    damping: f64,
    material: String,
    /// Instead of the material's.
    friction: Option<f64>,
}

/// What is to differ from the URDF in a link of the body.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LinkEntry {
    name: String,
    mass: Option<f64>,
    /// Centre of mass in the robot frame.
    centre: Option<Vector>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CasterEntry {
    name: String,
    position: Vector,
    radius: f64,
    mass: f64,
    material: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct BatteryEntry {
    max_energy: f64,
    life: f64,
}

pub(crate) fn read(
    source: &Source,
    file: &str,
    class: &str,
    text: &str,
    materials: &Materials,
    problems: &mut Problems,
) -> Option<RobotDef> {
    let shown = source.display(file);
    let (mut document, mut root) = Document::parse(&shown, text, problems);
    let description = document.required(&mut root, "description", "one sentence about the robot");
    let steering: Option<SteeringEntry> = document.required(&mut root, "steering", "\"skid\" or \"omni\"");
    let reported_steering = read_reported_steering(&mut document, &mut root);
    let drive_model = read_drive_model(&mut document, &mut root);
    if drive_model != DriveModel::Bodies && !matches!(steering, Some(SteeringEntry::Omni)) {
        document.problem(&(0..0), "`drive_model` other than \"bodies\": expected steering \"omni\"");
    }
    let one_side_drives = document.optional(&mut root, "one_side_drives").unwrap_or(false);
    let reported_max_torque = document.optional(&mut root, "reported_max_torque").unwrap_or(50000.0);
    let urdf = read_urdf(source, &mut document, &mut root, materials);
    let (mut parts, mut solids) =
        urdf.as_ref().map_or_else(Default::default, |urdf| (urdf.parts.clone(), urdf.solids.clone()));
    read_links(&mut document, &mut root, &mut parts);
    read_parts(&mut document, &mut root, materials, &mut parts, &mut solids);
    if parts.is_empty() {
        document.problem(&(0..0), "no [[part]] and no `urdf`: expected at least one part with a mass");
    }
    let mut wheels = read_wheels(&mut document, &mut root, urdf.as_ref(), materials);
    let steering = match steering {
        Some(SteeringEntry::Omni) => {
            check_omni(&mut document, &wheels);
            Some(Steering::Omni)
        }
        Some(SteeringEntry::Skid) => Some(Steering::Skid),
        None => None,
    };
    wheels.extend(read_casters(&mut document, &mut root, materials));
    let sensors = read_sensors(&mut document, &mut root, &wheels);
    let battery = read_battery(&mut document, &mut root);
    document.finish(root, KEYS);
    Some(RobotDef {
        class: class.to_owned(),
        description: description?,
        steering: steering?,
        reported_steering,
        drive_model,
        one_side_drives,
        parts,
        solids,
        wheels,
        sensors,
        battery,
        reported_max_torque,
    })
}

fn read_reported_steering<'a>(document: &mut Document<'a>, root: &mut Table<'a>) -> Option<String> {
    const KNOWN: [&str; 4] = ["SkidSteered", "AckermanSteered", "OmniDrive", "None"];
    let (span, name) = document.section::<String>(root, "reported_steering")?;
    if !KNOWN.contains(&name.as_str()) {
        let known = KNOWN.join(", ");
        document.problem(&span, format_args!("`reported_steering` is `{name}`: expected one of {known}"));
    }
    Some(name)
}

fn read_drive_model<'a>(document: &mut Document<'a>, root: &mut Table<'a>) -> DriveModel {
    let Some((span, name)) = document.section::<String>(root, "drive_model") else { return DriveModel::default() };
    name.parse().unwrap_or_else(|error: String| {
        document.problem(&span, error);
        DriveModel::default()
    })
}

fn read_urdf<'a>(
    source: &Source,
    document: &mut Document<'a>,
    root: &mut Table<'a>,
    materials: &Materials,
) -> Option<Urdf> {
    let (span, file) = document.section::<String>(root, "urdf")?;
    let material: String = document.optional(root, "urdf_material").unwrap_or_else(|| "unreal-default".to_owned());
    let material = document.material(&span, &material, materials);
    match source.text(&file) {
        Ok(text) => urdf::read(source, &file, &text, materials, material, document.problems()),
        Err(error) => {
            document.problem(&span, error);
            None
        }
    }
}

/// A mass changes the inertia with it; a centre moves the mass and leaves the shape.
fn read_links<'a>(document: &mut Document<'a>, root: &mut Table<'a>, parts: &mut [Part]) {
    for (span, LinkEntry { name, mass, centre }) in document.list::<LinkEntry>(root, "link") {
        let Some(part) = parts.iter_mut().find(|part| part.name == name) else {
            document.problem(&span, format_args!("link `{name}`: expected a link of the URDF's body"));
            continue;
        };
        if let Some(mass) = mass.filter(|&mass| document.positive(&span, "mass", mass)) {
            part.inertia *= mass / part.mass;
            part.mass = mass;
        }
        if let Some(centre) = centre {
            document.within_reason(&span, "centre", &centre);
            part.centre = centre.into();
        }
    }
}

fn read_parts<'a>(
    document: &mut Document<'a>,
    root: &mut Table<'a>,
    materials: &Materials,
    parts: &mut Vec<Part>,
    solids: &mut Vec<Solid>,
) {
    for (span, entry) in document.list::<PartEntry>(root, "part") {
        document.positive(&span, "mass", entry.mass);
        entry.size.iter().for_each(|&edge| {
            document.positive(&span, "size", edge);
        });
        document.within_reason(&span, "position", &entry.position);
        let pose = scene::pose(entry.position, entry.rotation);
        let turn = pose.rotation.to_rotation_matrix();
        let inertia = turn.matrix() * box_inertia(entry.mass, entry.size) * turn.matrix().transpose();
        parts.push(Part { name: entry.name.clone(), mass: entry.mass, centre: Vector3::from(entry.position), inertia });
        let material = document.material(&span, &entry.material, materials);
        if let Some(material) = material.filter(|_| entry.collides) {
            solids.push(Solid {
                name: entry.name,
                shape: Shape::Box { size: entry.size },
                position: entry.position,
                rotation: entry.rotation,
                material,
            });
        }
    }
}

fn box_inertia(mass: f64, [x, y, z]: Vector) -> Matrix3<f64> {
    let diagonal = Vector3::new(y * y + z * z, x * x + z * z, x * x + y * y);
    Matrix3::from_diagonal(&(diagonal * (mass / 12.0)))
}

fn read_wheels<'a>(
    document: &mut Document<'a>,
    root: &mut Table<'a>,
    urdf: Option<&Urdf>,
    materials: &Materials,
) -> Vec<Wheel> {
    let common = document.section::<WheelEntry>(root, "wheels").map(|(_, common)| common).unwrap_or_default();
    let rollers = document.section::<RollersEntry>(root, "rollers");
    if !root.has("wheel") {
        document.problem(&(0..0), "no [[wheel]]: expected at least one driven wheel");
    }
    let entries = document.list::<WheelEntry>(root, "wheel");
    let wheel = |(span, entry)| read_wheel(document, &span, entry, &common, rollers.as_ref(), urdf, materials);
    entries.into_iter().filter_map(wheel).collect()
}

fn read_wheel(
    document: &mut Document,
    span: &Range<usize>,
    entry: WheelEntry,
    common: &WheelEntry,
    rollers: Option<&(Range<usize>, RollersEntry)>,
    urdf: Option<&Urdf>,
    materials: &Materials,
) -> Option<Wheel> {
    let joint = entry.joint.as_ref().and_then(|name| {
        let joint = urdf.and_then(|urdf| urdf.wheels.iter().find(|wheel| &wheel.joint == name));
        if joint.is_none() {
            document.problem(span, format_args!("joint `{name}`: expected a continuous joint of the URDF"));
        }
        joint
    });
    let mut number = |key: &str, own: Option<f64>, urdf: Option<f64>, common: Option<f64>| {
        let Some(value) = own.or(urdf).or(common) else {
            document.problem(span, format_args!("missing `{key}`: expected it here, in [wheels] or in the URDF"));
            return None;
        };
        document.positive(span, key, value).then_some(value)
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
    if let Some(time) = integral_time {
        document.positive(span, "integral_time", time);
    }
    let mut missing = |key: &str| document.problem(span, format_args!("missing `{key}`"));
    let position = entry.position.or(joint.map(|joint| joint.position));
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
    let material = document.material(span, &material?, materials)?;
    let rollers = match (entry.roller_angle.or(common.roller_angle), rollers) {
        (Some(angle), Some((place, rollers))) => {
            let first_roller = entry.first_roller.or(common.first_roller).unwrap_or(0.0);
            if first_roller.abs() > 7.0 {
                document.problem(span, format_args!("`first_roller` is {first_roller}: expected -7 to 7 rad"));
            }
            let rollers = read_rollers(document, place, span, rollers, angle, radius?, materials)?;
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
    if !(0.0..=100.0).contains(&armature) {
        document.problem(span, format_args!("`armature` is {armature}: expected 0 to 100 kg m²"));
    }
    let drive = Some(Motor { max_speed: max_speed?, gain: gain?, max_torque: max_torque?, integral_time, armature });
    document.within_reason(span, "position", &position?);
    Some(Wheel {
        name: entry.name?,
        side,
        position: position?,
        radius: radius?,
        width: width?,
        mass: mass?,
        material,
        drive,
        rollers,
    })
}

/// What follows from a motor behind a gear.
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
    wheel: &Range<usize>,
    entry: &RollersEntry,
    angle: f64,
    wheel_radius: f64,
    materials: &Materials,
) -> Option<Rollers> {
    if !(3..=32).contains(&entry.count) {
        document.problem(place, format_args!("`count` is {}: expected 3 to 32 rollers", entry.count));
        return None;
    }
    if !(0.1..=1.5).contains(&angle.abs()) {
        document.problem(wheel, format_args!("`roller_angle` is {angle}: expected 0.1 to 1.5 rad, either sign"));
        return None;
    }
    document.positive(place, "mass", entry.mass);
    if !(0.0..=10.0).contains(&entry.damping) {
        document.problem(place, format_args!("`damping` is {}: expected 0 to 10 N m s/rad", entry.damping));
    }
    // At the ends the axis is farthest out; the roller must still be inside the wheel there.
    let end = entry.axis_circle / (std::f64::consts::PI / f64::from(entry.count)).cos();
    if !(entry.axis_circle > 0.0 && end < wheel_radius) {
        let most = wheel_radius * (std::f64::consts::PI / f64::from(entry.count)).cos();
        document.problem(
            place,
            format_args!("`axis_circle` is {}: expected more than 0 and less than {most:.4}", entry.axis_circle),
        );
        return None;
    }
    let mut material = document.material(place, &entry.material, materials)?;
    if let Some(friction) = entry.friction {
        if !(0.0..=10.0).contains(&friction) {
            document.problem(place, format_args!("`friction` is {friction}: expected 0 to 10"));
        }
        material.friction = friction;
    }
    let RollersEntry { count, axis_circle, mass, damping, .. } = *entry;
    let last_phase = std::f64::consts::PI / f64::from(count);
    let mut rollers = Rollers { count, axis_circle, angle, first_roller: 0.0, last_phase, mass, damping, material };
    if let Some(half_length) = entry.half_length {
        rollers.last_phase = last_phase_of(document, place, &rollers, half_length, wheel_radius)?;
    }
    Some(rollers)
}

/// The phase at which a roller of a length ends: from the least that leaves no gap to where its axis leaves the wheel.
fn last_phase_of(
    document: &mut Document,
    place: &Range<usize>,
    rollers: &Rollers,
    half_length: f64,
    wheel_radius: f64,
) -> Option<f64> {
    // At the end of the longest roller its radius is a tenth of that in its middle.
    let thin = 0.1 * (wheel_radius - rollers.axis_circle);
    let (mut low, mut high) = (rollers.last_phase, (rollers.axis_circle / (wheel_radius - thin)).acos());
    let [least, most] = [low, high].map(|phase| rollers.half_length_at(phase, wheel_radius));
    // A tenth of a millimetre less is rounding in a data sheet.
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

/// An omni base has four wheels with rollers in a fixed order, as its kinematics and its encoders count them.
fn check_omni(document: &mut Document, wheels: &[Wheel]) {
    const ORDER: [(f64, Side, f64); 4] =
        [(1.0, Side::Left, 1.0), (1.0, Side::Right, -1.0), (-1.0, Side::Left, -1.0), (-1.0, Side::Right, 1.0)];
    let fits = |(wheel, (front, side, angle)): (&Wheel, (f64, Side, f64))| {
        wheel.position[0] * front > 0.0
            && wheel.side == side
            && wheel.rollers.as_ref().is_some_and(|rollers| rollers.angle * angle > 0.0)
    };
    if wheels.len() != 4 || !wheels.iter().zip(ORDER).all(fits) {
        document.problem(
            &(0..0),
            "steering \"omni\": expected four wheels front left, front right, back left, back right with \
             `roller_angle` +, -, -, +",
        );
    }
}

fn read_casters<'a>(document: &mut Document<'a>, root: &mut Table<'a>, materials: &Materials) -> Vec<Wheel> {
    let mut casters = Vec::new();
    for (span, entry) in document.list::<CasterEntry>(root, "caster") {
        document.positive(&span, "radius", entry.radius);
        document.positive(&span, "mass", entry.mass);
        document.within_reason(&span, "position", &entry.position);
        let side = if entry.position[1] < 0.0 { Side::Left } else { Side::Right };
        let CasterEntry { name, position, radius, mass, material } = entry;
        if let Some(material) = document.material(&span, &material, materials) {
            let width = 2.0 * radius;
            casters.push(Wheel { name, side, position, radius, width, mass, material, drive: None, rollers: None });
        }
    }
    casters
}

fn read_sensors<'a>(document: &mut Document<'a>, root: &mut Table<'a>, wheels: &[Wheel]) -> Vec<SensorDef> {
    let mut sensors = Vec::new();
    for mut table in document.tables(root, "sensor") {
        let span = table.span();
        let classes = || sensor::CLASSES.iter().map(|(class, _)| *class).collect::<Vec<_>>().join(", ");
        let class: Option<String> = document.required(&mut table, "class", &classes());
        let name: Option<String> = document.required(&mut table, "name", "the name of the sensor on the wire");
        let position: Vector = document.optional(&mut table, "position").unwrap_or_default();
        let direction: Vector = document.optional(&mut table, "direction").unwrap_or_default();
        let scan_interval: Option<f64> = document.optional(&mut table, "scan_interval");
        let (Some(class), Some(name)) = (class, name) else { continue };
        document.wire_name(&span, &name);
        document.within_reason(&span, "position", &position);
        document.within_reason(&span, "direction", &direction);
        let Some(&(_, default_interval)) = sensor::CLASSES.iter().find(|(known, _)| *known == class) else {
            document.problem(&span, format_args!("unknown sensor class `{class}`: expected one of {}", classes()));
            continue;
        };
        let scan_interval = scan_interval.unwrap_or(default_interval);
        if !(scan_interval == 0.0 || (0.002..=3600.0).contains(&scan_interval)) {
            document.problem(&span, format_args!("`scan_interval` is {scan_interval}: expected 0 or 0.002 to 3600 s"));
        }
        let read = |settings| sensor::Config::read(&class, settings).transpose();
        let Some(config) = document.rest(table, read).flatten() else { continue };
        if let sensor::Config::Encoder(encoder) = &config
            && encoder.wheel.is_some_and(|wheel| wheel >= wheels.len())
        {
            document
                .problem(&span, format_args!("`wheel` of {name}: expected 0 to {}", wheels.len().saturating_sub(1)));
        }
        if let Err(expected) = config.validate() {
            document.problem(&span, format_args!("sensor {name}: expected {expected}"));
        }
        sensors.push(SensorDef { name, position, direction, scan_interval, config });
    }
    sensors
}

fn read_battery<'a>(document: &mut Document<'a>, root: &mut Table<'a>) -> Option<Battery> {
    let (span, BatteryEntry { max_energy, life }) = document.section(root, "battery")?;
    let good = [("max_energy", max_energy), ("life", life)].map(|(key, value)| {
        value.is_finite() && value > 0.0 || {
            document.problem(&span, format_args!("`{key}` is {value}: expected more than 0"));
            false
        }
    });
    good.iter().all(|&good| good).then_some(Battery { max_energy, life })
}
