//! `[[joint]]`: links that hang on joints, beside wheels.

use std::ops::Range;

use nalgebra::Vector3;
use scene::{Coupling, CouplingKind, Joint, JointKind, Link, Motor, ROOT};
use serde::Deserialize;

use crate::document::{Document, Table, Vector};

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

/// The links of a robot, as what is mounted on them names them.
pub(super) struct Links {
    pub(super) links: Vec<Link>,
    /// Where those that hang on joints stand, with their numbers.
    pub(super) carried: Vec<(Range<usize>, usize)>,
    /// Whether all of them could be read: otherwise a name that is not known is no mistake of its own.
    pub(super) complete: bool,
}

impl Links {
    /// The number of a link by its name; without one, the body.
    pub(super) fn find(
        &self,
        document: &mut Document,
        span: &Range<usize>,
        key: &str,
        name: Option<&str>,
    ) -> Option<usize> {
        let (name, known) = (name.unwrap_or(ROOT), self.links.iter().map(|link| link.name.as_str()));
        let number = known.clone().position(|known| known == name).or((!self.complete).then_some(0));
        number.or_else(|| document.one_of(span, key, name, known))
    }
}

/// The body, and the links that hang on joints beside those of wheels.
pub(super) fn read_joints<'a>(document: &mut Document<'a>, root: &mut Table<'a>, body: Link) -> Links {
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
