//! Arms of a robot from only a URDF.

use scene::{Actuator, Link};

/// Returns the chains of at least two joints with servos, as an arm's or a leg's. Their tips are at their last joints.
pub(super) fn actuators(links: &[Link]) -> Vec<Actuator> {
    let parent = |number: usize| links[number].joint.as_ref().map(|joint| joint.parent);
    // A joint that leads another is a gripper's.
    let leads = |number: usize| {
        links
            .iter()
            .any(|link| link.joint.as_ref().and_then(|joint| joint.coupling).is_some_and(|it| it.leader == number))
    };
    let leaders: Vec<bool> = (0..links.len()).map(leads).collect();
    let has_servo = |number: &usize| links[*number].position_limits().is_some() && !leaders[*number];
    let servos: Vec<usize> = (1..links.len()).filter(has_servo).collect();
    // Each link's nearest servo toward the root, and the servos that each link carries so.
    let mut carried = vec![Vec::new(); links.len()];
    let mut firsts = Vec::new();
    for &number in &servos {
        match std::iter::successors(parent(number), |&it| parent(it)).find(has_servo) {
            Some(carrier) => carried[carrier].push(number),
            None => firsts.push(number),
        }
    }
    firsts.extend(carried.iter().filter(|servos| servos.len() > 1).flatten());
    firsts.sort_unstable();
    let mut actuators: Vec<Actuator> = Vec::new();
    for first in firsts {
        let next = |&number: &usize| match carried[number][..] {
            [next] => Some(next),
            _ => None,
        };
        let chain: Vec<usize> = std::iter::successors(Some(first), next).collect();
        let Some(&last) = chain.last().filter(|_| chain.len() > 1) else { continue };
        let names: Vec<&str> = chain.iter().map(|&number| links[number].name.as_str()).collect();
        let mut name = shared_name(&names);
        while actuators.iter().any(|it| it.name == name) || links.iter().any(|link| link.name == name) {
            name.push('_');
        }
        actuators.push(Actuator { name, links: chain, tip: links[last].origin() });
    }
    actuators
}

/// Returns the beginning that names share, without separators; `Arm` if it is short or no word of the wire.
fn shared_name(names: &[&str]) -> String {
    let first = names.first().copied().unwrap_or_default();
    let shared = |length: &usize| names.iter().all(|name| name.get(..*length) == first.get(..*length));
    let length = (0..=first.len()).rev().filter(|length| first.is_char_boundary(*length)).find(shared).unwrap_or(0);
    let name = first[..length].trim_end_matches(['_', '-']);
    let good =
        name.len() > 2 && name.len() <= 64 && name.chars().all(|c| c.is_ascii_alphanumeric() || "_-".contains(c));
    if good { name.to_owned() } else { "Arm".to_owned() }
}
