//! Legs of a robot from only a URDF.

use scene::{JointKind, Link};

use super::extent::lowest;

/// Fewest servos of a leg.
const SERVOS: usize = 2;
/// Greatest height of a foot above the lowest point, as a fraction of the robot's height.
const ABOVE_GROUND: f64 = 0.05;

/// Returns the names of the links that a robot stands on: ends of chains of servos, each on a branch of its own, while the rest is
/// above the ground. Returns none if it is no robot on legs.
pub(super) fn feet(links: &[Link]) -> Vec<String> {
    let heights: Vec<Option<f64>> = links.iter().map(|link| lowest(link).map(|point| point.z)).collect();
    let known = || heights.iter().flatten().copied();
    let (ground, top) = (known().fold(f64::MIN, f64::max), known().fold(f64::MAX, f64::min));
    let on_ground = |number: usize| heights[number].is_some_and(|it| it > ground - ABOVE_GROUND * (ground - top));
    let mut feet = Vec::new();
    let mut branches = Vec::new();
    for number in (0..links.len()).filter(|&number| on_ground(number)) {
        let chain = chain(links, number);
        let turns = |number: &&usize| {
            let joint = links[**number].joint.as_ref();
            joint.is_some_and(|it| it.kind == JointKind::Revolute && it.drive.is_some())
        };
        let (Some(&branch), true) = (chain.last(), chain.iter().filter(turns).count() >= SERVOS) else {
            return Vec::new();
        };
        feet.push(links[number].name.clone());
        if !branches.contains(&branch) {
            branches.push(branch);
        }
    }
    if branches.len() < 2 { Vec::new() } else { feet }
}

/// Returns the links from one to the last before the root. Parents come before their children, so the chain ends.
fn chain(links: &[Link], number: usize) -> Vec<usize> {
    let parent = |number: &usize| links[*number].joint.as_ref().map(|joint| joint.parent);
    std::iter::successors(Some(number), parent).take_while(|&number| number > 0).collect()
}
