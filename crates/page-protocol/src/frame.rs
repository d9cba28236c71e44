//! Frames and scans for viewers, by `proto/live.proto`.

use std::f64::consts::PI;

use nalgebra::Vector3;
use prost::Message as _;
use scene::{Contact, Pose, PullSnapshot, RobotDef, RobotSnapshot, Snapshot, WorldDef};

use crate::pb::message::Content;
use crate::pb::{Frame, Message, Past, Placed, Pull, Robot, Scan, Wheel};

/// Most contacts of one robot that are published, the strongest first.
const MAX_CONTACTS: usize = 64;
/// Unit of a force, N.
const FORCE_UNIT: f64 = 0.25;
/// Unit of a slip, m/s.
const SLIP_UNIT: f64 = 1e-4;
/// Units of a roller's angle in pi.
const HALF_TURN: f64 = 32768.0;
/// Units of a range in a sensor's greatest range.
const FULL_RANGE: f64 = 65535.0;

/// Encodes a message.
pub fn encode(content: Content) -> Vec<u8> {
    Message { content: Some(content) }.encode_to_vec()
}

/// Encodes a snapshot as a frame.
pub fn frame(scene: &WorldDef, snapshot: &Snapshot) -> Vec<u8> {
    let of_class = |it: &RobotSnapshot| Some(robot(scene.robots.get(&it.class)?, it));
    let robots = snapshot.robots.iter().filter_map(of_class).collect();
    let objects = snapshot.objects.iter();
    let objects = objects.map(|it| Placed { object: it.id.0 as u32, pose: pose(&it.pose).collect() }).collect();
    let pulls = snapshot.pulls.iter();
    let line = |it: &PullSnapshot| floats(&it.from).chain(floats(&it.to)).collect();
    let pulls = pulls.map(|it| Pull { line: line(it), force: it.force.norm() as f32 }).collect();
    encode(Content::Frame(Frame { time: snapshot.time, robots, objects, pulls }))
}

/// Encodes a part of a run. One after the other, parts are the whole.
pub fn past(part: &Past) -> Vec<u8> {
    part.encode_to_vec()
}

/// Encodes a sensor's ranges as a scan; `None` if the robot's class has no such sensor.
pub fn scan(def: &RobotDef, robot: u64, sensor: usize, ranges: &[f64]) -> Option<Vec<u8>> {
    let unit = def.sensors.get(sensor)?.config.max_range()? / FULL_RANGE;
    let ranges = ranges.iter().map(|range| (range / unit).round().clamp(0.0, FULL_RANGE) as u32).collect();
    Some(encode(Content::Scan(Scan { robot: robot as u32, sensor: sensor as u32, ranges })))
}

fn robot(def: &RobotDef, robot: &RobotSnapshot) -> Robot {
    let RobotSnapshot { id, body, joints, targets, rollers, contacts, .. } = robot;
    let own = body.pose.rotation.inverse();
    let driven = def.with_values().zip(joints).filter(|(link, _)| link.is_driven_wheel()).map(|(_, wheel)| wheel);
    let mut rollers = rollers.iter().map(|angle| roller(*angle));
    let wheels = driven.zip(targets).zip(def.driven()).map(|((wheel, target), of_class)| Wheel {
        angle: wheel.position as f32,
        speed: wheel.speed as f32,
        target: *target as f32,
        rollers: rollers.by_ref().take(of_class.roller_count()).collect(),
    });
    let wheels = wheels.collect();
    let links = def.placed_links(joints).into_iter().skip(1).filter(|(link, _)| !link.is_driven_wheel());
    let placed = def.with_values().zip(joints).filter(|(link, _)| link.position_limits().is_some());
    let mut contacts: Vec<&Contact> = contacts.iter().collect();
    contacts.sort_by(|a, b| b.force.norm_squared().total_cmp(&a.force.norm_squared()));
    contacts.truncate(MAX_CONTACTS);
    let number = |wheel: usize| def.driven_number(wheel).map(|number| number as u32 + 1);
    Robot {
        robot: id.0 as u32,
        pose: pose(&body.pose).collect(),
        linear: floats(&(own * body.linear)).collect(),
        angular: floats(&(own * body.angular)).collect(),
        wheels,
        links: links.flat_map(|(_, at)| pose(&at).collect::<Vec<_>>()).collect(),
        joint_positions: placed.clone().map(|(_, joint)| joint.position as f32).collect(),
        joint_speeds: placed.map(|(_, joint)| joint.speed as f32).collect(),
        contact_points: contacts.iter().flat_map(|it| floats(&it.point)).collect(),
        contact_forces: contacts.iter().flat_map(|it| units(&it.force, FORCE_UNIT)).collect(),
        contact_wheels: contacts.iter().map(|it| it.wheel.and_then(number).unwrap_or_default()).collect(),
        contact_slips: contacts.iter().flat_map(|it| units(&it.slip, SLIP_UNIT)).collect(),
        contact_shares: contacts.iter().map(|it| (100.0 * it.friction_share).round() as u32).collect(),
    }
}

fn pose(pose: &Pose) -> impl Iterator<Item = f32> {
    pose.translation.vector.iter().chain(pose.rotation.coords.iter()).map(|&number| number as f32)
}

fn floats(vector: &Vector3<f64>) -> impl Iterator<Item = f32> {
    vector.iter().map(|&number| number as f32)
}

/// Returns a roller's angle within half a turn, in the unit of a frame.
fn roller(angle: f64) -> i32 {
    (scene::wrapped(angle) / PI * HALF_TURN).round().clamp(-HALF_TURN, HALF_TURN - 1.0) as i32
}

/// Returns the components of a vector in a unit.
fn units(vector: &Vector3<f64>, unit: f64) -> impl Iterator<Item = i32> {
    vector.iter().map(move |&part| (part / unit).round() as i32)
}
