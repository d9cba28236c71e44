//! `robot.toml`: parts, wheels, sensors and battery of a class of robots.

use std::ops::Range;

use nalgebra::{Matrix3, Vector3};
use scene::sensor;
use scene::{
    Battery, Coupling, CouplingKind, DriveModel, Joint, JointKind, Link, Motor, MountedWheel, Part, ROOT, RobotDef,
    Rollers, SensorDef, Shape, Side, Solid, Steering, Wheel, check,
};
use serde::Deserialize;

use crate::document::{Document, Table, Vector};
use crate::materials::Materials;
use crate::problem::{Problems, Unread, listed, suggestion};
use crate::source::Source;
use crate::urdf::{self, Urdf};

const KEYS: &str = "description, steering, reported_steering, drive_model, one_side_drives, reported_max_torque, urdf, urdf_material, link, part, wheels, rollers, wheel, \
                    caster, joint, sensor, battery";

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
    /// The link that it is a part of; without one, the body.
    link: Option<String>,
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
    /// The link that carries it; without one, the body.
    link: Option<String>,
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

/// A joint and the link of the same name that it carries.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct JointEntry {
    name: String,
    kind: String,
    /// Without one, the body.
    parent: Option<String>,
    position: Vector,
    axis: Option<Vector>,
    limits: Option<[f64; 2]>,
    #[serde(default)]
    damping: f64,
    #[serde(default)]
    friction: f64,
    max_speed: Option<f64>,
    max_torque: Option<f64>,
    gain: Option<f64>,
    stiffness: Option<f64>,
    #[serde(default)]
    armature: f64,
    coupling: Option<CouplingEntry>,
}

/// What a joint follows.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CouplingEntry {
    joint: String,
    multiplier: f64,
    #[serde(default)]
    offset: f64,
    /// Without one, `mimic`.
    kind: Option<String>,
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
    let (mut document, mut root) = Document::parse(&shown, text, problems)?;
    let description = document.required(&mut root, "description", "one sentence about the robot");
    let steering: Option<SteeringEntry> = document.required(&mut root, "steering", "\"skid\" or \"omni\"");
    let reported_steering = read_reported_steering(&mut document, &mut root);
    let drive_model = read_drive_model(&mut document, &mut root);
    let one_side_drives = document.optional(&mut root, "one_side_drives").unwrap_or(false);
    let reported_max_torque = document.optional(&mut root, "reported_max_torque").unwrap_or(50000.0);
    if !root.has("part") && !root.has("urdf") {
        document.problem(&(0..0), "no [[part]] and no `urdf`: expected at least one part with a mass");
    }
    let urdf = read_urdf(source, &mut document, &mut root, materials);
    let (mut parts, solids) = match &urdf {
        Ok(Some(urdf)) => (urdf.parts.clone(), urdf.solids.clone()),
        _ => Default::default(),
    };
    read_links(&mut document, &mut root, urdf.is_ok().then_some(&mut parts));
    let body = Link { name: ROOT.to_owned(), parts, solids, ..Link::default() };
    let mut links = read_joints(&mut document, &mut root, body);
    read_parts(&mut document, &mut root, materials, &mut links);
    for (span, link) in &links.carried {
        document.wrong(span, check::link(&links.links[*link], *link));
    }
    let wheels = read_wheels(&mut document, &mut root, &urdf, &links, materials);
    let casters = read_casters(&mut document, &mut root, materials);
    let links = links.links.into_iter().chain(wheels.iter().flatten().cloned()).chain(casters).collect();
    let sensors = read_sensors(&mut document, &mut root, wheels.as_ref().ok().map(Vec::len));
    let battery = read_battery(&mut document, &mut root);
    document.finish(root, KEYS);
    wheels.ok()?;
    let robot = RobotDef {
        class: class.to_owned(),
        description: description?,
        steering: match steering? {
            SteeringEntry::Skid => Steering::Skid,
            SteeringEntry::Omni => Steering::Omni,
        },
        reported_steering,
        drive_model,
        one_side_drives,
        links,
        sensors,
        battery,
        reported_max_torque,
    };
    document.as_a_whole(|| check::robot(&robot));
    Some(robot)
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

fn read_urdf<'a>(
    source: &Source,
    document: &mut Document<'a>,
    root: &mut Table<'a>,
    materials: &Materials,
) -> Result<Option<Urdf>, Unread> {
    let material: String = document.optional(root, "urdf_material").unwrap_or_else(|| "unreal-default".to_owned());
    let Some((span, file)) = document.section::<String>(root, "urdf")? else { return Ok(None) };
    let material = document.material(&span, &material, materials);
    match source.text(&file) {
        Ok(text) => urdf::read(source, &file, &text, material, document.problems()).map(Some),
        Err(error) => {
            document.problem(&span, error);
            Err(Unread)
        }
    }
}

/// A mass changes the inertia with it; a centre moves the mass and leaves the shape. Without `parts` the URDF could not be
/// read.
fn read_links<'a>(document: &mut Document<'a>, root: &mut Table<'a>, parts: Option<&mut Vec<Part>>) {
    let links = document.list::<LinkEntry>(root, "link");
    let Some(parts) = parts else { return };
    for (span, LinkEntry { name, mass, centre }) in links {
        let Some(part) = parts.iter_mut().find(|part| part.name == name) else {
            let names = listed(parts.iter().map(|part| part.name.as_str()));
            document.problem(&span, format_args!("link `{name}`: expected a link of the URDF's body: {names}"));
            continue;
        };
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

/// The links of a robot, as what is mounted on them names them.
struct Links {
    links: Vec<Link>,
    /// Where those that hang on joints stand, with their numbers.
    carried: Vec<(Range<usize>, usize)>,
    /// Whether all of them could be read: otherwise a name that is not known is no mistake of its own.
    complete: bool,
}

impl Links {
    /// The number of a link by its name; without one, the body.
    fn find(&self, document: &mut Document, span: &Range<usize>, key: &str, name: Option<&str>) -> Option<usize> {
        let (name, known) = (name.unwrap_or(ROOT), self.links.iter().map(|link| link.name.as_str()));
        let number = known.clone().position(|known| known == name).or((!self.complete).then_some(0));
        number.or_else(|| document.one_of(span, key, name, known))
    }
}

/// The body, and the links that hang on joints beside those of wheels.
fn read_joints<'a>(document: &mut Document<'a>, root: &mut Table<'a>, body: Link) -> Links {
    let noted = document.problems().count();
    let entries = document.list::<JointEntry>(root, "joint");
    let complete = document.problems().count() == noted;
    let mut links = Links { links: vec![body], carried: Vec::new(), complete };
    // Their leaders may come behind them.
    let mut couplings = Vec::new();
    for (span, entry) in entries {
        if links.links.iter().any(|link| link.name == entry.name) {
            document.problem(&span, format_args!("second link `{}`: expected a name of its own", entry.name));
            continue;
        }
        let kind = document.one_of(&span, "kind", &entry.kind, JointKind::ALL.iter().map(|(name, _)| *name));
        let parent = links.find(document, &span, "parent", entry.parent.as_deref());
        let (axis, drive) = (entry.axis.unwrap_or([0.0, 0.0, 1.0]), read_servo(document, &span, &entry));
        let JointEntry { name, position, limits, damping, friction, .. } = entry;
        couplings.extend(entry.coupling.map(|coupling| (span.clone(), links.links.len(), coupling)));
        let joint = kind.zip(parent).map(|(kind, parent)| {
            let (kind, axis) = (JointKind::ALL[kind].1, Vector3::from(axis).normalize().into());
            Joint { limits, damping, friction, drive, ..Joint::new(parent, kind, position, axis) }
        });
        // Without a joint it only stands for its name, and what is wrong is said.
        links.carried.extend(joint.is_some().then_some((span, links.links.len())));
        links.links.push(Link { name, joint, ..Link::default() });
    }
    for (span, follower, CouplingEntry { joint, multiplier, offset, kind }) in couplings {
        let names = CouplingKind::ALL.iter().map(|(name, _)| *name);
        let kind = document.one_of(&span, "kind", kind.as_deref().unwrap_or("mimic"), names);
        let leader = links.find(document, &span, "joint", Some(&joint));
        let coupling = kind.zip(leader);
        let coupling =
            coupling.map(|(kind, leader)| Coupling { leader, multiplier, offset, kind: CouplingKind::ALL[kind].1 });
        if let Some(joint) = &mut links.links[follower].joint {
            joint.coupling = coupling;
        }
    }
    links
}

/// The motor of a joint: all of its numbers, or none.
fn read_servo(document: &mut Document, span: &Range<usize>, entry: &JointEntry) -> Option<Motor> {
    let JointEntry { max_speed, max_torque, gain, stiffness, armature, .. } = *entry;
    let given = [("max_speed", max_speed), ("max_torque", max_torque), ("gain", gain)];
    if given.iter().all(|(_, number)| number.is_none()) && stiffness.is_none() {
        return None;
    }
    for (key, _) in given.iter().filter(|(_, number)| number.is_none()) {
        document.problem(span, format_args!("missing `{key}`: expected max_speed, max_torque and gain of a motor"));
    }
    let (max_speed, max_torque, gain) = (max_speed?, max_torque?, gain?);
    Some(Motor { max_speed, gain, max_torque, stiffness, integral_time: None, armature })
}

fn box_inertia(mass: f64, [x, y, z]: Vector) -> Matrix3<f64> {
    let diagonal = Vector3::new(y * y + z * z, x * x + z * z, x * x + y * y);
    Matrix3::from_diagonal(&(diagonal * (mass / 12.0)))
}

/// The driven wheels, if all of them could be read.
fn read_wheels<'a>(
    document: &mut Document<'a>,
    root: &mut Table<'a>,
    urdf: &Result<Option<Urdf>, Unread>,
    links: &Links,
    materials: &Materials,
) -> Result<Vec<Link>, Unread> {
    let common = document.section::<WheelEntry>(root, "wheels");
    let rollers = document.section::<RollersEntry>(root, "rollers");
    if !root.has("wheel") {
        document.problem(&(0..0), "no [[wheel]]: expected at least one driven wheel");
    }
    let noted = document.problems().count();
    let entries = document.list::<WheelEntry>(root, "wheel");
    let (Ok(common), Ok(rollers), Ok(urdf)) = (common, rollers, urdf) else { return Err(Unread) };
    let (place, common) = common.unwrap_or_default();
    let wheel = |(span, entry): (Range<usize>, WheelEntry)| {
        let parent = links.find(document, &span, "link", entry.link.as_deref());
        let mut wheel = read_wheel(document, &span, entry, &common, rollers.as_ref(), urdf.as_ref(), materials)?;
        wheel.joint.as_mut()?.parent = parent?;
        Some((span, wheel))
    };
    let count = entries.len();
    let wheels: Vec<(Range<usize>, Link)> = entries.into_iter().filter_map(wheel).collect();
    for (span, link) in &wheels {
        document.wrong(span, wrong_wheel(link));
    }
    if !place.is_empty() {
        // What is wrong with every wheel stands in [wheels].
        let shared = document.problems().take_shared(noted, count);
        document.wrong(&place, shared);
    }
    let wheels = wheels.into_iter().map(|(_, wheel)| wheel).collect();
    if document.problems().count() == noted { Ok(wheels) } else { Err(Unread) }
}

fn read_wheel(
    document: &mut Document,
    span: &Range<usize>,
    entry: WheelEntry,
    common: &WheelEntry,
    rollers: Option<&(Range<usize>, RollersEntry)>,
    urdf: Option<&Urdf>,
    materials: &Materials,
) -> Option<Link> {
    let joint = match (&entry.joint, urdf) {
        (None, _) => None,
        (Some(name), None) => {
            document.problem(span, format_args!("joint `{name}`: expected a `urdf` that has it"));
            return None;
        }
        (Some(name), Some(urdf)) => {
            let joint = urdf.wheels.iter().find(|wheel| &wheel.joint == name);
            if joint.is_none() {
                let names = listed(urdf.wheels.iter().map(|wheel| wheel.joint.as_str()));
                let expected = if names.is_empty() { "it has none".to_owned() } else { format!("one of {names}") };
                let message = format!("joint `{name}`: expected a continuous joint of the URDF: {expected}");
                document.problem(span, message);
            }
            Some(joint?)
        }
    };
    let mut number = |key: &str, own: Option<f64>, urdf: Option<f64>, common: Option<f64>| {
        let value = own.or(urdf).or(common);
        if value.is_none() {
            document.problem(span, format_args!("missing `{key}`: expected it here, in [wheels] or in the URDF"));
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
    let wheel = Wheel { side, radius: radius?, width: width?, mass: mass?, material, rollers };
    Some(Link::of_wheel(entry.name?, position?, Some(motor), wheel))
}

fn wrong_wheel(link: &Link) -> Vec<String> {
    MountedWheel::of((1, link)).map_or(Vec::new(), |wheel| check::wheel(&wheel))
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
    let RollersEntry { count, axis_circle, mass, damping, .. } = *entry;
    let last_phase = std::f64::consts::PI / f64::from(count);
    let mut rollers = Rollers { count, axis_circle, angle, first_roller: 0.0, last_phase, mass, damping, material };
    // What a wheel of no size or an angle that is none makes of its rollers is said of those.
    let sound = check::WHEEL_RADIUS.holds(wheel_radius) && check::ROLLER_ANGLE.holds(angle.abs());
    let wrong = if sound { check::rollers(&rollers, wheel_radius) } else { Vec::new() };
    if let Some(half_length) = entry.half_length.filter(|_| sound && wrong.is_empty()) {
        rollers.last_phase = last_phase_of(document, place, &rollers, half_length, wheel_radius)?;
    }
    document.wrong(place, wrong);
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

fn read_casters<'a>(document: &mut Document<'a>, root: &mut Table<'a>, materials: &Materials) -> Vec<Link> {
    let mut casters = Vec::new();
    for (span, entry) in document.list::<CasterEntry>(root, "caster") {
        let CasterEntry { name, position, radius, mass, material } = entry;
        let side = if position[1] < 0.0 { Side::Left } else { Side::Right };
        let material = document.material(&span, &material, materials);
        let width = 2.0 * radius;
        let wheel = Wheel { side, radius, width, mass, material, rollers: None };
        let caster = Link::of_wheel(name, position, None, wheel);
        document.wrong(&span, wrong_wheel(&caster));
        casters.push(caster);
    }
    casters
}

/// The sensors; `wheels` is how many driven wheels there are, if they could be read.
fn read_sensors<'a>(document: &mut Document<'a>, root: &mut Table<'a>, wheels: Option<usize>) -> Vec<SensorDef> {
    let mut sensors = Vec::new();
    for mut table in document.tables(root, "sensor") {
        let span = table.span();
        let classes = || listed(sensor::CLASSES.iter().map(|(class, _)| *class));
        let class: Option<String> = document.required(&mut table, "class", &classes());
        let name: Option<String> = document.required(&mut table, "name", "the name of the sensor on the wire");
        let position: Vector = document.optional(&mut table, "position").unwrap_or_default();
        let direction: Vector = document.optional(&mut table, "direction").unwrap_or_default();
        let scan_interval: Option<f64> = document.optional(&mut table, "scan_interval");
        let (Some(class), Some(name)) = (class, name) else { continue };
        let Some(&(_, default_interval)) = sensor::CLASSES.iter().find(|(known, _)| *known == class) else {
            let suggestion = suggestion(&class, sensor::CLASSES.iter().map(|(known, _)| *known));
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
        let sensor = SensorDef { name, position, direction, scan_interval, config };
        document.wrong(&span, check::sensor(&sensor));
        sensors.push(sensor);
    }
    sensors
}

fn read_battery<'a>(document: &mut Document<'a>, root: &mut Table<'a>) -> Option<Battery> {
    let (span, BatteryEntry { max_energy, life }) = document.section(root, "battery").ok().flatten()?;
    let battery = Battery { max_energy, life };
    document.wrong(&span, check::battery(&battery));
    Some(battery)
}
