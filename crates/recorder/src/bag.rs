//! Joints and poses of a robot in a bag of ROS 2, as `ros2 bag record -s mcap` writes it.

use std::collections::BTreeMap;
use std::path::Path;

use ros2_topics::interfaces as ros;
use ros2_topics::{Message, cdr};
use serde::de::DeserializeOwned;

use crate::reader::{ReadError, open, unreadable};
use crate::records::{self, Damage, Record};

/// Bytes before a message: plain CDR, little endian. The other two have no meaning here.
const PLAIN: [u8; 2] = [0, 1];
/// Bytes of the encapsulation.
const HEAD: usize = 4;
/// Most numbers that are kept of a bag: 400 MB of memory.
const MAX_NUMBERS: usize = 50_000_000;
/// Most joints of a topic.
const MAX_JOINTS: usize = 1000;

/// Joints and poses of one robot.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Bag {
    /// Topics of the joints and of the poses.
    pub topics: [String; 2],
    /// Names of the joints, in the order of the angles.
    pub names: Vec<String>,
    /// Time, s, and angles, rad, that are known then. A joint that came later is missing at the end.
    pub joints: Vec<(f64, Vec<f64>)>,
    /// Time, s, and x, y, m, and yaw, rad: y to the left, counterclockwise.
    pub poses: Vec<(f64, [f64; 3])>,
    /// Reason why the rest of the file was not read, if any.
    pub damage: Option<String>,
}

/// The kinds of messages that are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    Joints,
    /// Poses of a camera or motion capture.
    Pose,
    Odometry,
}

impl Kind {
    /// Returns the kind of a schema's name, as in `nav_msgs/msg/Odometry`.
    fn of(schema: &str) -> Option<Self> {
        let is = |name: &str| schema.replacen("/msg/", "/", 1) == name;
        let known = [
            (ros::JointState::NAME, Self::Joints),
            (ros::PoseStamped::NAME, Self::Pose),
            (ros::Odometry::NAME, Self::Odometry),
        ];
        known.into_iter().find_map(|(name, kind)| is(name).then_some(kind))
    }
}

/// Messages of a topic.
#[derive(Default)]
struct Topic {
    names: Vec<String>,
    joints: Vec<(f64, Vec<f64>)>,
    poses: Vec<(f64, [f64; 3])>,
}

/// True if a file is a bag of ROS 2.
///
/// # Errors
/// When it cannot be read, or is no MCAP file.
pub fn is_bag(path: &Path) -> Result<bool, ReadError> {
    let (file, _) = open(path)?;
    let mut profile = None;
    // The header is the first record.
    let _ = records::each(file, |record| {
        if let Record::Header { profile: own, .. } = record {
            profile = Some(own.to_owned());
        }
        Err::<(), _>(Damage("the header is read".to_owned()))
    });
    Ok(profile.is_some_and(|profile| profile == "ros2"))
}

/// Reads the joints and poses of a robot. Without a topic of joints it is the only one; without one of poses it is the only one of
/// `PoseStamped`, then of `Odometry`. If the bag was cut off, returns everything before that.
///
/// # Errors
/// When the file cannot be read, a topic is missing, or several could be meant.
pub fn read(path: &Path, joints: Option<&str>, poses: Option<&str>) -> Result<Bag, ReadError> {
    let (file, _) = open(path)?;
    let (mut schemas, mut channels) = (BTreeMap::new(), BTreeMap::new());
    let mut topics: BTreeMap<(Kind, String), Topic> = BTreeMap::new();
    let mut count = 0;
    let read = records::each(file, |record| {
        match record {
            Record::Schema { id, name, .. } => drop(schemas.insert(id, Kind::of(name))),
            Record::Channel { id, schema, topic, .. } => {
                let kind = schemas.get(&schema).copied().flatten();
                channels.extend(kind.map(|kind| (id, (topic.to_owned(), kind))));
            }
            Record::Message { header, data } => {
                let Some((name, kind)) = channels.get(&header.channel_id) else { return Ok(()) };
                let topic = topics.entry((*kind, name.clone())).or_default();
                count += topic.take(*kind, data).ok_or_else(|| Damage(format!("a message on {name} is no CDR")))?;
                if count > MAX_NUMBERS {
                    return Err(Damage(format!("more than {MAX_NUMBERS} numbers of joints and poses")));
                }
            }
            _ => {}
        }
        Ok::<(), Damage>(())
    });
    let damage = read.err().map(|damage| damage.to_string());
    let of = |kind: Kind| topics.keys().filter(move |(own, _)| *own == kind);
    let choose = |wanted: Option<&str>, kinds: &[Kind], what: &str, option: &str| {
        for &kind in kinds {
            let own: Vec<_> = of(kind).filter(|(_, name)| wanted.is_none_or(|wanted| name == wanted)).collect();
            match own.as_slice() {
                [] => {}
                [key] => return Ok((*key).clone()),
                several => {
                    let names: Vec<&str> = several.iter().map(|(_, name)| name.as_str()).collect();
                    let names = names.join(", ");
                    return Err(unreadable(path, format_args!("{what} on {names}: choose one with {option}")));
                }
            }
        }
        let known: Vec<&str> = kinds.iter().flat_map(|&kind| of(kind)).map(|(_, name)| name.as_str()).collect();
        let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
        let wanted = wanted.map_or(String::new(), |wanted| format!(" on {wanted}"));
        let damage = damage.as_ref().map_or(String::new(), |damage| format!("; {damage}"));
        Err(unreadable(path, format_args!("no {what}{wanted}: it has {known}{damage}")))
    };
    let of_joints = choose(joints, &[Kind::Joints], "sensor_msgs/JointState", "--joints")?;
    let what = "geometry_msgs/PoseStamped or nav_msgs/Odometry";
    let of_poses = choose(poses, &[Kind::Pose, Kind::Odometry], what, "--poses")?;
    let Topic { names, joints, .. } = topics.remove(&of_joints).unwrap_or_default();
    let Topic { poses, .. } = topics.remove(&of_poses).unwrap_or_default();
    Ok(Bag { topics: [of_joints.1, of_poses.1], names, joints, poses, damage })
}

impl Topic {
    /// Takes a message. Returns how many numbers it brought, or `None` if it is none of its kind.
    fn take(&mut self, kind: Kind, data: &[u8]) -> Option<usize> {
        match kind {
            Kind::Joints => {
                let ros::JointState { header, name, position, .. } = message(data)?;
                let mut row = self.joints.last().map_or_else(Vec::new, |(_, row)| row.clone());
                for (name, position) in name.into_iter().zip(position) {
                    let place = self.names.iter().position(|own| *own == name).unwrap_or_else(|| {
                        self.names.push(name);
                        self.names.len() - 1
                    });
                    if place >= MAX_JOINTS {
                        return None;
                    }
                    row.resize(row.len().max(place + 1), 0.0);
                    row[place] = position;
                }
                let count = row.len();
                self.joints.push((seconds(&header.stamp), row));
                return Some(count);
            }
            Kind::Pose => {
                let ros::PoseStamped { header, pose } = message(data)?;
                self.poses.push((seconds(&header.stamp), flat(&pose)));
            }
            Kind::Odometry => {
                let ros::Odometry { header, pose, .. } = message(data)?;
                self.poses.push((seconds(&header.stamp), flat(&pose.pose)));
            }
        }
        Some(4)
    }
}

fn message<T: DeserializeOwned>(data: &[u8]) -> Option<T> {
    let (head, body) = data.split_at_checked(HEAD)?;
    if head[..2] != PLAIN {
        return None;
    }
    cdr::read(body).ok()
}

fn seconds(stamp: &ros::Time) -> f64 {
    f64::from(stamp.sec) + f64::from(stamp.nanosec) * 1e-9
}

/// Returns x, y and yaw of a pose.
fn flat(pose: &ros::Pose) -> [f64; 3] {
    let ros::Pose { position, orientation: ros::Quaternion { x, y, z, w } } = pose;
    [position.x, position.y, f64::atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))]
}
