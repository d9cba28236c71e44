//! `robot.toml`: parts, wheels, sensors and battery of a class of robots. `actuator.toml`: an actuator that robots carry.

mod actuator;
mod driven;
mod joint;
mod like;
pub(crate) mod mount;
pub(crate) mod of_urdf;
mod track;
mod visual;
mod wheel;

use std::ops::Range;

use nalgebra::{Matrix3, Vector3};
use names::{did_you_mean, listed};
use scene::sensor;
use scene::{Aerial, Battery, DriveModel, Footing, Link, Part, RobotDef, SensorDef, Shape, Solid, Steering, check};
use serde::Deserialize;

use self::actuator::{read_actuators, read_grippers, read_tool_changers, read_vacuums};
use self::driven::read_wheels;
use self::joint::{Links, find_link};
use self::visual::read_visuals;
use self::wheel::read_casters;
use crate::LoadError;
use crate::document::{Document, Table, Vector};
use crate::equipment::{Changes, Equipment};
use crate::materials::Materials;
use crate::problem::{Problems, Unread};
use crate::source::{MAX_TEXT, Source};
use crate::urdf::{self, Urdf};

const KEYS: &str = "description, names, like, steering, reported_steering, drive_model, one_side_drives, dialect, reported_max_torque, urdf, urdf_material, link, part, wheels, rollers, wheel, \
                    tracks, track, caster, joint, visual, actuator, gripper, tool_changer, vacuum, mount, sensor, battery, aerial";
/// Keys of a robot that an actuator does not have.
const NOT_OF_ACTUATORS: [&str; 13] = [
    "like",
    "names",
    "steering",
    "drive_model",
    "dialect",
    "urdf",
    "wheels",
    "wheel",
    "tracks",
    "track",
    "caster",
    "battery",
    "aerial",
];

/// A file to be read, and what its definition may refer to.
#[derive(Clone, Copy)]
pub(crate) struct Definition<'a> {
    pub(crate) source: &'a Source,
    pub(crate) file: &'a str,
    pub(crate) class: &'a str,
    pub(crate) materials: &'a Materials,
    /// Class whose items in the equipment it has.
    pub(crate) equipped_as: &'a str,
    /// Changes for itself, and for the classes and actuators that it names.
    pub(crate) changes: Changes<'a>,
    /// Number of actuators that it is mounted on, if it is an actuator. `None` for a robot.
    pub(crate) depth: Option<usize>,
    pub(crate) others: Others,
}

/// Loaders of the classes and actuators that a definition names.
#[derive(Clone, Copy)]
pub(crate) struct Others {
    /// Loads a shipped class by its name, with the equipment of that class or another.
    pub(crate) class: fn(&str, Changes, Option<&str>) -> Result<RobotDef, LoadError>,
    /// Loads an actuator beside a file, or a shipped one, that is mounted on a number of others.
    pub(crate) actuator: fn(&Source, &str, Changes, usize) -> Result<RobotDef, LoadError>,
}

/// A part of the body: a solid box that sets its mass, and a colliding shape unless it is hidden.
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
    /// Link that it belongs to; without one, the body.
    link: Option<String>,
}

fn yes() -> bool {
    true
}

/// Changes to a link of the URDF.
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
struct BatteryEntry {
    max_energy: f64,
    life: f64,
}

/// Reads the text of a definition.
pub(crate) fn read(definition: &Definition, text: &str, problems: &mut Problems) -> Option<RobotDef> {
    let &Definition { source, file, class, materials, depth, .. } = definition;
    let shown = source.display(file);
    let (mut document, mut root) = Document::parse(&shown, text, problems)?;
    let equipment = definition.changes.equipment;
    if equipment.replaces(definition.equipped_as) {
        root.forget(&["sensor", "mount"]);
    }
    if depth.is_some() {
        for key in NOT_OF_ACTUATORS.iter().filter(|key| root.has(key)) {
            document.problem(&(0..0), format_args!("`{key}` of an actuator: expected none, robots have it"));
        }
    } else if root.has("like") {
        return like::read(definition, document, root);
    }
    let _: Option<Vec<String>> = document.optional(&mut root, "names");
    let description = document.required(&mut root, "description", "one sentence about the robot");
    let steering = if depth.is_some() { Some(Steering::None) } else { read_steering(&mut document, &mut root) };
    let reported_steering = read_reported_steering(&mut document, &mut root);
    let drive_model = read_drive_model(&mut document, &mut root);
    let one_side_drives = document.optional(&mut root, "one_side_drives").unwrap_or(false);
    let speaks_ut2004 = read_dialect(&mut document, &mut root);
    let reported_max_torque = document.optional(&mut root, "reported_max_torque").unwrap_or(50000.0);
    if !root.has("part") && !root.has("urdf") {
        document.problem(&(0..0), "no [[part]] and no `urdf`: expected at least one part with a mass");
    }
    let urdf = read_urdf(source, &mut document, &mut root, materials);
    let read = urdf.is_ok();
    let urdf = urdf.ok().flatten();
    let named = urdf.is_some() || !read;
    let (span, Urdf { links: mut of_urdf, continuous, assumptions, .. }) = urdf.unwrap_or_else(|| (0..0, Urdf::body()));
    read_links(&mut document, &mut root, read.then_some(&mut of_urdf));
    let urdf_links = 1..of_urdf.len();
    let carried = urdf_links.clone().map(|link| (span.clone(), link)).collect();
    let (wheels, taken) = (named.then_some(continuous), Vec::new());
    let mut links = Links { links: of_urdf, carried, urdf_links, wheels, taken, complete: read };
    links.read_joints(&mut document, &mut root);
    read_parts(&mut document, &mut root, materials, &mut links);
    let wheels = read_wheels(&mut document, &mut root, &mut links, steering, materials);
    let casters = read_casters(&mut document, &mut root, &links, materials);
    let complete = links.complete && wheels.is_ok();
    let mut links = links.with_wheels(&mut document, wheels.iter().flatten().cloned().chain(casters));
    read_visuals(source, &mut document, &mut root, &mut links, complete);
    let actuators = read_actuators(&mut document, &mut root, &links, complete);
    let grippers = read_grippers(&mut document, &mut root, &links, complete);
    let tool_changers = read_tool_changers(&mut document, &mut root, materials, &links, complete);
    let vacuums = read_vacuums(&mut document, &mut root, &links, complete);
    let sensors =
        read_sensors(&mut document, &mut root, equipment, &links, wheels.as_ref().ok().map(Vec::len), complete);
    let battery = read_battery(&mut document, &mut root);
    let aerial = read_aerial(&mut document, &mut root, steering);
    let mounts = mount::read(definition, &mut document, &mut root);
    document.finish(root, KEYS);
    wheels.ok()?;
    let steering = steering?;
    let mut robot = RobotDef {
        class: class.to_owned(),
        description: description?,
        steering,
        reported_steering,
        drive_model,
        one_side_drives,
        speaks_ut2004,
        links,
        sensors,
        actuators,
        grippers,
        tool_changers,
        vacuums,
        battery,
        reported_max_torque,
        footing: Footing::of(steering, aerial),
        assumptions,
    };
    mount::mount(&mut document, &mut robot, mounts, complete);
    equipment.put_on(definition, &mut robot, complete, document.problems());
    document.as_a_whole(|| check::robot(&robot));
    Some(robot)
}

fn read_steering<'a>(document: &mut Document<'a>, root: &mut Table<'a>) -> Option<Steering> {
    let names = || Steering::ALL.iter().map(|(name, _)| *name);
    if !root.has("steering") {
        document.problem(&(0..0), format_args!("missing `steering`: expected one of {}", listed(names())));
    }
    let (span, name) = document.section::<String>(root, "steering").ok().flatten()?;
    document.one_of(&span, "steering", &name, names()).map(|number| Steering::ALL[number].1)
}

/// Flight limits of a robot, m/s, rad/s and rad.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct AerialEntry {
    max_velocity: Vector,
    max_turn: f64,
    max_tilt: f64,
}

fn read_aerial<'a>(document: &mut Document<'a>, root: &mut Table<'a>, steering: Option<Steering>) -> Option<Aerial> {
    if steering == Some(Steering::Aerial) && !root.has("aerial") {
        document.problem(&(0..0), "missing [aerial]: expected max_velocity (m/s), max_turn (rad/s) and max_tilt (rad)");
    }
    let (span, AerialEntry { max_velocity, max_turn, max_tilt }) = document.section(root, "aerial").ok().flatten()?;
    let aerial = Aerial { max_velocity, max_turn, max_tilt };
    document.wrong(&span, check::aerial(&aerial));
    Some(aerial)
}

fn read_reported_steering<'a>(document: &mut Document<'a>, root: &mut Table<'a>) -> Option<String> {
    const KNOWN: [&str; 4] = ["SkidSteered", "AckermanSteered", "OmniDrive", "None"];
    let (span, name) = document.section::<String>(root, "reported_steering").ok().flatten()?;
    if !KNOWN.contains(&name.as_str()) {
        let known = KNOWN.join(", ");
        document.problem(&span, format_args!("`reported_steering` is `{name}`: expected one of {known}"));
    }
    Some(name)
}

fn read_drive_model<'a>(document: &mut Document<'a>, root: &mut Table<'a>) -> DriveModel {
    let Ok(Some((span, name))) = document.section::<String>(root, "drive_model") else { return DriveModel::default() };
    name.parse().unwrap_or_else(|error: String| {
        document.problem(&span, error);
        DriveModel::default()
    })
}

/// Reads the dialect of its clients; true for that of UT2004.
fn read_dialect<'a>(document: &mut Document<'a>, root: &mut Table<'a>) -> bool {
    let Ok(Some((span, name))) = document.section::<String>(root, "dialect") else { return false };
    if !["udk", "ut2004"].contains(&name.as_str()) {
        document.problem(&span, format!("`{name}` is not a dialect: expected udk or ut2004"));
    }
    name == "ut2004"
}

/// Reads the URDF that a robot names, with the position of its name.
fn read_urdf<'a>(
    source: &Source,
    document: &mut Document<'a>,
    root: &mut Table<'a>,
    materials: &Materials,
) -> Result<Option<(Range<usize>, Urdf)>, Unread> {
    let material: String = document.optional(root, "urdf_material").unwrap_or_else(|| "unreal-default".to_owned());
    let Some((span, file)) = document.section::<String>(root, "urdf")? else { return Ok(None) };
    let material = document.material(&span, &material, materials);
    match source.xml(&file, MAX_TEXT) {
        Ok(text) => {
            let mut urdf = urdf::read(source, &file, &text, material, document.problems())?;
            urdf.finish_notes();
            Ok(Some((span, urdf)))
        }
        Err(error) => {
            document.problem(&span, error);
            Err(Unread)
        }
    }
}

/// Reads the changes to links of the URDF. A mass scales the inertia; a centre moves the mass and keeps the shape. `links` is
/// `None` if the URDF could not be read.
fn read_links<'a>(document: &mut Document<'a>, root: &mut Table<'a>, links: Option<&mut Vec<Link>>) {
    let entries = document.list::<LinkEntry>(root, "link");
    let Some(links) = links else { return };
    for (span, LinkEntry { name, mass, centre }) in entries {
        let parts = || links.iter().flat_map(|link| &link.parts).map(|part| part.name.as_str());
        if !parts().any(|part| part == name) {
            let (known, meant) = (listed(parts()), did_you_mean(&name, parts()));
            document.problem(&span, format_args!("link `{name}`: expected a link of the URDF: {known}{meant}"));
            continue;
        }
        for part in links.iter_mut().flat_map(|link| &mut link.parts).filter(|part| part.name == name) {
            if let Some(mass) = mass.filter(|&mass| document.within(&span, "mass", mass, check::PART_MASS)) {
                part.inertia *= mass / part.mass;
                part.mass = mass;
            }
            if let Some(centre) = centre {
                part.centre = centre.into();
            }
            document.wrong(&span, check::part(part));
        }
    }
}

fn read_parts<'a>(document: &mut Document<'a>, root: &mut Table<'a>, materials: &Materials, links: &mut Links) {
    for (span, entry) in document.list::<PartEntry>(root, "part") {
        let PartEntry { name, mass, position, rotation, size, material, collides, link } = entry;
        let material = document.material(&span, &material, materials);
        let solid = Solid { name: name.clone(), shape: Shape::Box { size }, position, rotation, material };
        document.wrong(&span, check::body_solid(&solid));
        document.within(&span, "mass", mass, check::PART_MASS);
        let turn = solid.pose().rotation.to_rotation_matrix();
        let inertia = turn.matrix() * box_inertia(mass, size) * turn.matrix().transpose();
        let Some(number) = links.find(document, &span, "link", link.as_deref()) else { continue };
        let link = &mut links.links[number];
        link.parts.push(Part { name, mass, centre: position.into(), inertia });
        if collides {
            link.solids.push(solid);
        }
    }
}

fn box_inertia(mass: f64, [x, y, z]: Vector) -> Matrix3<f64> {
    let diagonal = Vector3::new(y * y + z * z, x * x + z * z, x * x + y * y);
    Matrix3::from_diagonal(&(diagonal * (mass / 12.0)))
}

/// Reads the sensors. `equipment` has their settings that differ from the defaults. `wheels` is the number of driven wheels, if they could
/// be read; `complete` is true if all links could.
pub(crate) fn read_sensors<'a>(
    document: &mut Document<'a>,
    root: &mut Table<'a>,
    equipment: &'a Equipment,
    links: &[Link],
    wheels: Option<usize>,
    complete: bool,
) -> Vec<SensorDef> {
    let mut sensors = Vec::new();
    for mut table in document.tables(root, "sensor") {
        let span = table.span();
        let classes = || listed(sensor::CLASSES.iter().map(|(class, _)| *class));
        let class: Option<String> = document.required(&mut table, "class", &classes());
        let name: Option<String> = document.required(&mut table, "name", "the name of the sensor on the wire");
        let link: Option<String> = document.optional(&mut table, "link");
        let position: Vector = document.optional(&mut table, "position").unwrap_or_default();
        let direction: Vector = document.optional(&mut table, "direction").unwrap_or_default();
        for (key, value) in class.iter().flat_map(|class| equipment.settings(class)) {
            table.add_default(key, value);
        }
        let scan_interval: Option<f64> = document.optional(&mut table, "scan_interval");
        let (Some(class), Some(name)) = (class, name) else { continue };
        let Some(&(_, default_interval)) = sensor::CLASSES.iter().find(|(known, _)| *known == class) else {
            let suggestion = did_you_mean(&class, sensor::CLASSES.iter().map(|(known, _)| *known));
            let message = format!("unknown sensor class `{class}`: expected one of {}{suggestion}", classes());
            document.problem(&span, message);
            continue;
        };
        let scan_interval = scan_interval.unwrap_or(default_interval);
        let read = |settings| sensor::Config::read(&class, settings).transpose();
        let Some(config) = document.rest(table, read).flatten() else { continue };
        if let (sensor::Config::Encoder(encoder), Some(wheels)) = (&config, wheels)
            && encoder.wheel.is_some_and(|wheel| wheel >= wheels)
        {
            document.problem(&span, format_args!("`wheel` of {name}: expected 0 to {}", wheels.saturating_sub(1)));
        }
        let link = find_link(document, &span, "link", link.as_deref(), links, complete);
        let sensor = SensorDef { name, link: link.unwrap_or(0), position, direction, scan_interval, config };
        document.wrong(&span, check::sensor(&sensor));
        sensors.push(sensor);
    }
    sensors
}

pub(crate) fn read_battery<'a>(document: &mut Document<'a>, root: &mut Table<'a>) -> Option<Battery> {
    let (span, BatteryEntry { max_energy, life }) = document.section(root, "battery").ok().flatten()?;
    let battery = Battery { max_energy, life };
    document.wrong(&span, check::battery(&battery));
    Some(battery)
}
