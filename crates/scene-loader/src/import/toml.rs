//! The robot.toml of an imported robot.

use scene::{Link, RobotDef, Side};
use serde::Serialize;

use super::{URDF, sensors};
use crate::robot::of_urdf::{BODY, CASTER, ROLLER, TYRE, sensor_names};

#[derive(Serialize)]
struct Robot<'a> {
    description: String,
    steering: &'a str,
    urdf: &'a str,
    urdf_material: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    rollers: Option<Rollers<'a>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    wheel: Vec<Wheel<'a>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    caster: Vec<Caster<'a>>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    actuator: Vec<Actuator<'a>>,
    sensor: Vec<Sensor<'a>>,
}

#[derive(Serialize)]
struct Rollers<'a> {
    count: u32,
    axis_circle: f64,
    mass: f64,
    damping: f64,
    material: &'a str,
}

#[derive(Serialize)]
struct Wheel<'a> {
    name: &'a str,
    joint: &'a str,
    side: &'a str,
    position: [f64; 3],
    radius: f64,
    width: f64,
    mass: f64,
    material: &'a str,
    max_speed: f64,
    gain: f64,
    max_torque: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    integral_time: Option<f64>,
    armature: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    roller_angle: Option<f64>,
}

#[derive(Serialize)]
struct Caster<'a> {
    name: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    link: Option<&'a str>,
    position: [f64; 3],
    radius: f64,
    mass: f64,
    material: &'a str,
}

#[derive(Serialize)]
struct Actuator<'a> {
    name: &'a str,
    joints: Vec<&'a str>,
    tip: [f64; 3],
}

#[derive(Serialize)]
struct Sensor<'a> {
    class: &'a str,
    name: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    link: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    position: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    direction: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    scan_interval: Option<f64>,
    #[serde(flatten)]
    settings: ::toml::Table,
}

/// Returns the robot.toml of a robot from a URDF, with these notes about what was guessed, replaced and left out.
pub(super) fn of_robot(
    robot: &RobotDef,
    sensors: &[sensors::Sensor],
    file: &str,
    notes: [&[String]; 3],
) -> Result<String, ::toml::ser::Error> {
    let wheels = || robot.links.iter().filter(|link| link.wheel.is_some());
    let steering = scene::Steering::ALL.iter().find(|(_, steering)| *steering == robot.steering);
    let rollers = wheels().find_map(|link| link.wheel.as_ref()?.rollers.as_ref());
    let of_every_robot = sensor_names(robot.steering).iter().map(|&(class, name)| Sensor {
        class,
        name,
        link: None,
        position: None,
        direction: None,
        scan_interval: None,
        settings: ::toml::Table::new(),
    });
    let table = Robot {
        description: format!("Imported from {file}"),
        steering: steering.map_or("none", |(name, _)| name),
        urdf: URDF,
        urdf_material: BODY,
        rollers: rollers.map(|it| Rollers {
            count: it.count,
            axis_circle: short(it.axis_circle),
            mass: short(it.mass),
            damping: it.damping,
            material: ROLLER,
        }),
        wheel: wheels().filter_map(wheel).collect(),
        caster: wheels().filter_map(|link| caster(link, &robot.links)).collect(),
        actuator: robot.actuators.iter().map(|it| actuator(it, &robot.links)).collect(),
        sensor: of_every_robot.chain(sensors.iter().map(|it| sensor(it, &robot.links))).collect(),
    };
    let mut text = format!("# Made by `usarsim import` from {}. Check what was guessed.\n", line(file));
    for (what, notes) in ["guessed", "replaced", "left out"].into_iter().zip(notes) {
        notes.iter().for_each(|note| text += &format!("# {what}: {}\n", line(note)));
    }
    text.push('\n');
    text += &::toml::to_string(&table)?;
    Ok(text)
}

fn wheel(link: &Link) -> Option<Wheel<'_>> {
    let (wheel, drive) = (link.wheel.as_ref()?, link.joint.as_ref()?.drive.as_ref()?);
    let side = match wheel.side {
        Side::Left => "left",
        Side::Right => "right",
    };
    Some(Wheel {
        name: &link.name,
        joint: &link.name,
        side,
        position: link.origin().map(short),
        radius: short(wheel.radius),
        width: short(wheel.width),
        mass: short(wheel.mass),
        material: TYRE,
        max_speed: short(drive.max_speed),
        gain: short(drive.gain),
        max_torque: short(drive.max_torque),
        integral_time: drive.integral_time,
        armature: short(drive.armature),
        roller_angle: wheel.rollers.as_ref().map(|rollers| rollers.angle),
    })
}

fn caster<'a>(link: &'a Link, links: &'a [Link]) -> Option<Caster<'a>> {
    let (wheel, joint) = (link.wheel.as_ref()?, link.joint.as_ref()?);
    if joint.drive.is_some() {
        return None;
    }
    let carrier = (joint.parent > 0).then(|| links.get(joint.parent)).flatten();
    Some(Caster {
        name: &link.name,
        link: carrier.map(|link| link.name.as_str()),
        position: link.origin().map(short),
        radius: short(wheel.radius),
        mass: short(wheel.mass),
        material: CASTER,
    })
}

fn actuator<'a>(actuator: &'a scene::Actuator, links: &'a [Link]) -> Actuator<'a> {
    let joints = actuator.links.iter().filter_map(|&number| links.get(number)).map(|link| link.name.as_str());
    Actuator { name: &actuator.name, joints: joints.collect(), tip: actuator.tip.map(short) }
}

fn sensor<'a>(sensor: &'a sensors::Sensor, links: &'a [Link]) -> Sensor<'a> {
    let sensors::Sensor { class, settings, def } = sensor;
    Sensor {
        class,
        name: &def.name,
        link: (def.link > 0).then(|| links[def.link].name.as_str()),
        position: Some(def.position.map(short)),
        direction: Some(def.direction.map(short)),
        scan_interval: Some(short(def.scan_interval)),
        settings: settings.clone(),
    }
}

/// Returns a number with six digits: a measured mesh has no more. Zero has no sign.
fn short(number: f64) -> f64 {
    format!("{number:.5e}").parse().unwrap_or(number) + 0.0
}

/// Returns a text as one line of a comment.
fn line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}
