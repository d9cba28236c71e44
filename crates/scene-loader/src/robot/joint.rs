//! `[[joint]]`: joints other than those of wheels, with their links.

use std::ops::Range;

use nalgebra::Vector3;
use scene::{Coupling, CouplingKind, Joint, JointKind, Link, Motor, ROOT, check};
use serde::Deserialize;

use crate::document::{Document, Table, Vector};
use crate::urdf::Continuous;

/// A joint and the link of the same name that it carries.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct JointEntry {
    name: String,
    kind: String,
    /// Parent link; without one, the body.
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

/// Coupling of a joint to its leader.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct CouplingEntry {
    joint: String,
    multiplier: f64,
    #[serde(default)]
    offset: f64,
    /// Kind of the coupling; without one, `mimic`.
    kind: Option<String>,
}

/// Links of a robot, for lookups by the entries mounted on them.
pub(super) struct Links {
    pub(super) links: Vec<Link>,
    /// Positions and numbers of the links on joints. Links of a URDF have the position of the URDF's name.
    pub(super) carried: Vec<(Range<usize>, usize)>,
    /// Joints of the URDF that may carry wheels; `None` without a URDF.
    pub(super) wheels: Option<Vec<Continuous>>,
    /// Numbers of the URDF's links.
    pub(super) urdf_links: Range<usize>,
    /// Numbers of the URDF's links that are wheels.
    pub(super) taken: Vec<usize>,
    /// True if all links could be read. Otherwise an unknown name is not reported.
    pub(super) complete: bool,
}

impl Links {
    /// Returns the number of a link by its name; without a name, that of the body.
    pub(super) fn find(
        &self,
        document: &mut Document,
        span: &Range<usize>,
        key: &str,
        name: Option<&str>,
    ) -> Option<usize> {
        find_link(document, span, key, name, &self.links, self.complete)
    }

    /// Reads the links on joints other than those of wheels and of a URDF.
    pub(super) fn read_joints<'a>(&mut self, document: &mut Document<'a>, root: &mut Table<'a>) {
        let noted = document.problems().count();
        let entries = document.list::<JointEntry>(root, "joint");
        self.complete &= document.problems().count() == noted;
        // Leaders may come later in the file.
        let mut couplings = Vec::new();
        for (span, entry) in entries {
            if self.links.iter().any(|link| link.name == entry.name) {
                document.problem(&span, format_args!("second link `{}`: expected a name of its own", entry.name));
                continue;
            }
            let kind = document.one_of(&span, "kind", &entry.kind, JointKind::ALL.iter().map(|(name, _)| *name));
            let parent = self.find(document, &span, "parent", entry.parent.as_deref());
            let (axis, drive) = (entry.axis.unwrap_or([0.0, 0.0, 1.0]), read_servo(document, &span, &entry));
            let JointEntry { name, position, limits, damping, friction, .. } = entry;
            couplings.extend(entry.coupling.map(|coupling| (span.clone(), self.links.len(), coupling)));
            let joint = kind.zip(parent).map(|(kind, parent)| {
                let (kind, axis) = (JointKind::ALL[kind].1, Vector3::from(axis).normalize().into());
                Joint { limits, damping, friction, drive, ..Joint::new(parent, kind, position, axis) }
            });
            // A link without a joint only keeps its name; its problem is already reported.
            self.carried.extend(joint.is_some().then_some((span, self.links.len())));
            self.links.push(Link { name, joint, ..Link::default() });
        }
        for (span, follower, CouplingEntry { joint, multiplier, offset, kind }) in couplings {
            let names = CouplingKind::ALL.iter().map(|(name, _)| *name);
            let kind = document.one_of(&span, "kind", kind.as_deref().unwrap_or("mimic"), names);
            let leader = self.find(document, &span, "joint", Some(&joint));
            let coupling = kind.zip(leader);
            let coupling =
                coupling.map(|(kind, leader)| Coupling { leader, multiplier, offset, kind: CouplingKind::ALL[kind].1 });
            if let Some(joint) = &mut self.links[follower].joint {
                joint.coupling = coupling;
            }
        }
    }

    /// Returns all links, checked, followed by the wheels. The URDF's links that became wheels are left out.
    pub(super) fn with_wheels(self, document: &mut Document, wheels: impl Iterator<Item = Link>) -> Vec<Link> {
        for (span, number) in self.carried.iter().filter(|(_, number)| !self.taken.contains(number)) {
            let link = &self.links[*number];
            let joint = link.joint.as_ref();
            let on_wheel = joint.is_some_and(|joint| self.taken.contains(&joint.parent));
            let after = joint.and_then(|joint| joint.coupling).is_some_and(|it| self.taken.contains(&it.leader));
            let on_wheel =
                (on_wheel || after).then(|| "it hangs on a wheel or follows one: expected another link".to_owned());
            // All joints of a URDF share one position, so the message names the joint.
            let of_urdf =
                if self.urdf_links.contains(number) { format!("joint {}: ", link.name) } else { String::new() };
            let wrong = check::link(link, *number).into_iter().chain(on_wheel);
            document.wrong(span, wrong.map(|message| format!("{of_urdf}{message}")));
        }
        rebuilt(self.links, &self.taken, wheels)
    }
}

/// Returns the number of a link by its name; without a name, that of the body. If not all links could be read, an unknown name is
/// not reported and gives the body.
pub(super) fn find_link(
    document: &mut Document,
    span: &Range<usize>,
    key: &str,
    name: Option<&str>,
    links: &[Link],
    complete: bool,
) -> Option<usize> {
    let (name, known) = (name.unwrap_or(ROOT), links.iter().map(|link| link.name.as_str()));
    let number = known.clone().position(|known| known == name).or((!complete).then_some(0));
    number.or_else(|| document.one_of(span, key, name, known))
}

/// Returns the links without the taken ones, followed by others. Parents and leaders are renumbered.
pub(super) fn rebuilt(links: Vec<Link>, taken: &[usize], others: impl Iterator<Item = Link>) -> Vec<Link> {
    let (mut numbers, mut kept) = (Vec::new(), 0);
    for number in 0..links.len() {
        numbers.push(kept);
        kept += usize::from(!taken.contains(&number));
    }
    let is_kept = |(number, _): &(usize, Link)| !taken.contains(number);
    let kept = links.into_iter().enumerate().filter(is_kept).map(|(_, link)| link);
    let mut links: Vec<Link> = kept.chain(others).collect();
    for joint in links.iter_mut().filter_map(|link| link.joint.as_mut()) {
        joint.parent = numbers[joint.parent];
        if let Some(coupling) = &mut joint.coupling {
            coupling.leader = numbers[coupling.leader];
        }
    }
    links
}

/// Reads the motor of a joint: all of its numbers, or none.
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
