//! Sensors of an imported robot: lasers and cameras that its URDF gives to Gazebo.

use std::f64::consts::TAU;

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use roxmltree::Node;
use scene::sensor::Config;
use scene::{RobotDef, SensorDef};

use super::inertia::is_held;
use crate::urdf::{isometry, z_down};

/// Maximum number of sensors, and of beams of a laser.
const MAX_SENSORS: usize = 12;
const MAX_BEAMS: f64 = 1441.0;
/// Rotation units of the wire in a radian.
const UNITS: f64 = 65_536.0 / TAU;
/// Range of the time between two readings, s.
const INTERVALS: [f64; 2] = [0.02, 10.0];

/// A sensor of robot.toml.
pub(super) struct Sensor {
    pub(super) class: &'static str,
    pub(super) settings: ::toml::Table,
    pub(super) def: SensorDef,
}

/// Finds the lasers and cameras of Gazebo in a URDF. `robot` is the URDF as it is written, and `def` what it becomes. Sensors that
/// cannot be had are added to `left_out`.
pub(super) fn find(root: Node, robot: &urdf_rs::Robot, def: &RobotDef, left_out: &mut Vec<String>) -> Vec<Sensor> {
    let mut sensors = Vec::<Sensor>::new();
    for gazebo in root.children().filter(|node| node.has_tag_name("gazebo")) {
        let Some(link) = gazebo.attribute("reference") else { continue };
        for node in gazebo.children().filter(|node| node.has_tag_name("sensor")) {
            let name = node.attribute("name").unwrap_or("sensor");
            let kind = node.attribute("type").unwrap_or_default();
            let sensor = if sensors.len() < MAX_SENSORS {
                read(node, kind, link, robot, def)
            } else {
                Err(format!("expected at most {MAX_SENSORS} sensors"))
            };
            match sensor {
                Ok(mut sensor) => {
                    sensor.def.name = free_name(name, &sensors, def);
                    sensors.push(sensor);
                }
                Err(reason) => left_out.push(format!("sensor {name}: {reason}")),
            }
        }
    }
    sensors
}

fn read(node: Node, kind: &str, link: &str, robot: &urdf_rs::Robot, def: &RobotDef) -> Result<Sensor, String> {
    let number = |tag: &str| -> Option<f64> {
        let found = node.descendants().find(|node| node.has_tag_name(tag))?;
        found.text()?.trim().parse().ok().filter(|number: &f64| number.is_finite())
    };
    let mut settings = ::toml::Table::new();
    let mut set = |key: &str, value: f64| drop(settings.insert(key.to_owned(), value.into()));
    let mut yaw = 0.0;
    let class = if kind.contains("ray") || kind.contains("lidar") {
        let horizontal =
            node.descendants().find(|node| node.has_tag_name("horizontal")).ok_or("no <horizontal> scan")?;
        let of_scan = |tag: &str| -> Option<f64> {
            horizontal.children().find(|node| node.has_tag_name(tag))?.text()?.trim().parse().ok()
        };
        let (from, to) = of_scan("min_angle").zip(of_scan("max_angle")).ok_or("no angles of its scan")?;
        let fan = (to - from).clamp(0.0, TAU);
        let beams = of_scan("samples").unwrap_or(MAX_BEAMS).clamp(1.0, MAX_BEAMS).floor();
        yaw = (from + to) / 2.0;
        let range = node.descendants().find(|node| node.has_tag_name("range")).ok_or("no <range>")?;
        for (key, tag) in [("min_range", "min"), ("max_range", "max")] {
            let text = range.children().find(|node| node.has_tag_name(tag)).and_then(|node| node.text());
            set(key, text.and_then(|text| text.trim().parse().ok()).ok_or_else(|| format!("no <{tag}> of its range"))?);
        }
        let (fan, resolution) = in_units(fan, beams);
        set("field_of_view", fan);
        set("resolution", resolution);
        "RangeScanner"
    } else if kind.contains("camera") || kind == "depth" {
        let view = number("horizontal_fov").ok_or("no <horizontal_fov>")?;
        set("field_of_view", view);
        set("min_field_of_view", view);
        set("max_field_of_view", view);
        "Camera"
    } else {
        return Err(format!("type `{kind}` is not read"));
    };
    let (carrier, place) = place(robot, link).ok_or_else(|| format!("link {link} is not found"))?;
    let place = place * pose(node) * UnitQuaternion::from_euler_angles(0.0, 0.0, yaw);
    let (position, direction) = scene::position_and_rotation(&(z_down() * place * z_down()));
    let link = match carrier {
        None => 0,
        Some(joint) => def.links.iter().position(|link| link.name == joint).ok_or("its link has no joint")?,
    };
    if def.links[link].wheel.is_some() {
        return Err("it turns with a wheel".to_owned());
    }
    let config = Config::read(class, settings.clone()).and_then(Result::ok).ok_or("its numbers are not read")?;
    let rate = number("update_rate").filter(|rate| *rate > 0.0).unwrap_or(10.0);
    let scan_interval = (1.0 / rate).clamp(INTERVALS[0], INTERVALS[1]);
    let def = SensorDef { name: class.to_owned(), link, position, direction, scan_interval, config };
    match scene::check::sensor(&def).into_iter().next() {
        Some(wrong) => Err(wrong),
        None => Ok(Sensor { class, settings, def }),
    }
}

/// Returns the angle of a fan of so many beams, and that between two, rad. The wire counts angles in whole rotation units, so the fan may be a
/// little narrower than it is wanted; a single beam is in its middle.
fn in_units(fan: f64, beams: f64) -> (f64, f64) {
    let gaps = beams - 1.0;
    let mut resolution = (fan * UNITS / gaps).floor();
    if gaps < 1.0 || resolution < 1.0 {
        return (0.0, 1.0);
    }
    // Half of the fan is a whole number, too, and in 32 bits a little more than its beams need, so that none is lost.
    let needed = |resolution: f64| 2.0 * ((resolution * gaps / 2.0).floor() + 1.0);
    if needed(resolution) >= TAU * UNITS && resolution > 1.0 {
        resolution -= 1.0;
    }
    // A quarter of a unit keeps rounding away.
    [needed(resolution), resolution].map(|units| (units + 0.25) / UNITS).into()
}

/// Returns the joint that carries a link of a URDF, none if it belongs to the body, and its pose in the URDF's axes.
fn place<'a>(robot: &'a urdf_rs::Robot, link: &'a str) -> Option<(Option<&'a str>, Isometry3<f64>)> {
    robot.links.iter().find(|it| it.name == link)?;
    let (mut at, mut carrier, mut pose) = (link, None, Isometry3::identity());
    // The tree was checked, so this ends at the root.
    for _ in 0..=robot.joints.len() {
        let Some(joint) = robot.joints.iter().find(|joint| joint.child.link == at) else { break };
        pose = isometry(&joint.origin) * pose;
        if carrier.is_none() && !is_held(joint) {
            carrier = Some(joint.name.as_str());
        }
        at = &joint.parent.link;
    }
    Some((carrier, pose))
}

/// Returns the pose of a sensor on its link.
fn pose(node: Node) -> Isometry3<f64> {
    let text = node.children().find(|node| node.has_tag_name("pose")).and_then(|node| node.text()).unwrap_or_default();
    let numbers: Vec<f64> = text.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    match numbers[..] {
        [x, y, z, roll, pitch, yaw] => {
            Isometry3::from_parts(Vector3::new(x, y, z).into(), UnitQuaternion::from_euler_angles(roll, pitch, yaw))
        }
        _ => Isometry3::identity(),
    }
}

/// Returns a name for the wire that no other sensor has.
fn free_name(name: &str, sensors: &[Sensor], def: &RobotDef) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() || "_-".contains(c) { c } else { '_' };
    let mut name: String = name.chars().take(64).map(plain).collect();
    let is_taken = |name: &str| {
        sensors.iter().map(|it| &it.def).chain(&def.sensors).any(|def| def.name.eq_ignore_ascii_case(name))
    };
    while name.is_empty() || is_taken(&name) {
        name.push('_');
    }
    name
}
