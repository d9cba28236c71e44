//! Two of the binary messages to viewers; pictures are in `cameras`. Little-endian, world frame of the wire (z down), SI units.
//!
//! A frame (kind 1) holds the state of every robot and object:
//!
//! | bytes | what |
//! |---|---|
//! | 1 | kind, 1 |
//! | 8 | simulated time, f64 |
//! | 2 | robots, u16, then each of them: |
//! | 4 | number, u32 |
//! | 7 x 4 | position and quaternion x y z w, f32 |
//! | 6 x 4 | velocity along and angular velocity about the robot's own axes, f32 |
//! | 1 | driven wheels, then each of them: |
//! | 3 x 4 | angle, speed, target speed, f32 |
//! | 1 | its rollers, then each of them: |
//! | 2 | angle about its own axis, i16, pi being 32768 |
//! | 1 | links beside the body and driven wheels, then each of them: |
//! | 7 x 4 | position and quaternion x y z w in the robot frame, f32 |
//! | 1 | joints that go to positions, in the order of `/scene.json`, then each of them: |
//! | 2 x 4 | position and speed, f32 |
//! | 1 | contacts, then each of them: |
//! | 3 x 4 | point, f32 |
//! | 3 x 2 | force, i16, unit 0.25 N |
//! | 2 | objects, u16, then each of them: |
//! | 4 | number, u32; the map's objects come first |
//! | 7 x 4 | position and quaternion, f32 |
//!
//! A scan (kind 2): 1 kind, 4 robot u32, 1 sensor (its place in the class's list), 2 count u16, then each range as u16 in
//! units of the sensor's range over 65535.

use std::f64::consts::PI;

use scene::{Contact, Pose, RobotDef, RobotSnapshot, Snapshot, WorldDef};

/// Most contacts of one robot that are published, the strongest first.
const MAX_CONTACTS: usize = 64;
/// Unit of a force, N.
const FORCE_UNIT: f64 = 0.25;

/// Encodes a snapshot as a frame.
pub(super) fn frame(scene: &WorldDef, snapshot: &Snapshot) -> Vec<u8> {
    let mut bytes = Bytes::of_kind(1);
    bytes.0.extend(snapshot.time.to_le_bytes());
    let robots = snapshot.robots.iter();
    let robots: Vec<_> = robots.filter_map(|robot| Some((robot, scene.robots.get(&robot.class)?))).collect();
    bytes.u16(robots.len());
    for (robot, def) in robots {
        bytes.0.extend((robot.id.0 as u32).to_le_bytes());
        bytes.robot(def, robot);
    }
    bytes.u16(snapshot.objects.len());
    for object in &snapshot.objects {
        bytes.0.extend((object.id.0 as u32).to_le_bytes());
        bytes.pose(&object.pose);
    }
    bytes.0
}

/// Encodes a sensor's ranges as a scan; `None` if the robot's class has no such sensor.
pub(super) fn scan(def: &RobotDef, robot: u64, sensor: usize, ranges: &[f64]) -> Option<Vec<u8>> {
    let unit = def.sensors.get(sensor)?.config.max_range()? / f64::from(u16::MAX);
    let mut bytes = Bytes::of_kind(2);
    bytes.0.extend((robot as u32).to_le_bytes());
    bytes.0.push(sensor as u8);
    bytes.u16(ranges.len());
    ranges.iter().for_each(|&range| bytes.u16((range / unit).round().clamp(0.0, 65535.0) as usize));
    Some(bytes.0)
}

struct Bytes(Vec<u8>);

impl Bytes {
    fn of_kind(kind: u8) -> Self {
        Self(vec![kind])
    }

    /// Appends a number, clamped to 65535.
    fn u16(&mut self, value: usize) {
        self.0.extend((value.min(usize::from(u16::MAX)) as u16).to_le_bytes());
    }

    fn i16(&mut self, value: f64) {
        self.0.extend((value.round().clamp(-32768.0, 32767.0) as i16).to_le_bytes());
    }

    fn f32s<'a>(&mut self, values: impl IntoIterator<Item = &'a f64>) {
        values.into_iter().for_each(|&value| self.0.extend((value as f32).to_le_bytes()));
    }

    fn pose(&mut self, pose: &Pose) {
        self.f32s(pose.translation.vector.iter().chain(pose.rotation.coords.iter()));
    }

    fn robot(&mut self, def: &RobotDef, robot: &RobotSnapshot) {
        let RobotSnapshot { body, joints, targets, rollers, contacts, .. } = robot;
        self.pose(&body.pose);
        let own = body.pose.rotation.inverse();
        self.f32s((own * body.linear).iter().chain((own * body.angular).iter()));
        let wheels = def.with_values().zip(joints).filter(|(link, _)| link.is_driven_wheel());
        let wheels: Vec<_> = wheels.map(|(_, wheel)| wheel).collect();
        self.0.push(wheels.len() as u8);
        let (mut rollers, roller_counts) = (rollers.iter(), def.driven().map(|wheel| wheel.roller_count()));
        for ((wheel, target), count) in wheels.iter().zip(targets).zip(roller_counts) {
            self.f32s(&[wheel.position, wheel.speed, *target]);
            self.0.push(count as u8);
            for angle in rollers.by_ref().take(count) {
                let turned = angle - 2.0 * PI * (angle / (2.0 * PI)).round();
                self.i16(turned / PI * 32768.0);
            }
        }
        let mut links = def.placed_links(joints).into_iter().skip(1).collect::<Vec<_>>();
        links.retain(|(link, _)| !link.is_driven_wheel());
        self.0.push(links.len() as u8);
        links.iter().for_each(|(_, pose)| self.pose(pose));
        let placed = def.with_values().zip(joints).filter(|(link, _)| link.position_limits().is_some());
        let placed: Vec<_> = placed.map(|(_, joint)| [joint.position, joint.speed]).collect();
        self.0.push(placed.len() as u8);
        self.f32s(placed.iter().flatten());
        let mut contacts: Vec<&Contact> = contacts.iter().collect();
        contacts.sort_by(|a, b| b.force.norm_squared().total_cmp(&a.force.norm_squared()));
        contacts.truncate(MAX_CONTACTS);
        self.0.push(contacts.len() as u8);
        for Contact { point, force } in contacts {
            self.f32s(point.iter());
            force.iter().for_each(|part| self.i16(part / FORCE_UNIT));
        }
    }
}
