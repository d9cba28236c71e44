//! Packets: neighbouring rays from one point, which walk through the engine's tree of boxes together.
//!
//! A scan's rays are close to each other, so they meet the same boxes. A packet visits a box if any of its rays may meet it: the bounds of
//! their directions give a first and a last distance along each axis. Then each ray is cast against the colliders that the packet found,
//! the nearest first. A fan of 181 beams takes a quarter of the time that rays one by one take.

use rapier3d::parry::partitioning::{Bvh, BvhNode};

/// Rays of a packet. More rays share more visits, but spread over more boxes.
pub(super) const RAYS: usize = 12;

/// Least size of a direction's component, so that its inverse is finite.
const LEAST: f64 = 1e-200;

/// Rays from one point.
pub(super) struct Packet {
    origin: [f64; 3],
    /// Most distance of a hit, m.
    reach: f64,
    axes: [Axis; 3],
}

/// Bounds of the inverse components of a packet's directions along an axis.
struct Axis {
    /// Inverse of the largest component if that is positive: no ray reaches a box ahead sooner. Infinite if none reaches it.
    ahead: f64,
    /// Inverse of the smallest component if that is negative, for boxes behind.
    behind: f64,
    /// Inverse of the component of the ray that leaves a box last, if all rays go one way.
    last: Option<f64>,
}

/// A ray with the inverses of its direction.
pub(super) struct Slab {
    origin: [f64; 3],
    inverse: [f64; 3],
}

/// A leaf that a packet may meet.
#[derive(Clone, Copy)]
pub(super) struct Leaf<'a> {
    /// No ray meets it nearer than this, m.
    pub(super) nearest: f64,
    pub(super) node: &'a BvhNode,
    pub(super) number: u32,
}

impl Packet {
    /// Returns the packet of some directions. `reach` is the most distance of a hit, m.
    pub(super) fn new(origin: [f64; 3], directions: &[[f64; 3]], reach: f64) -> Self {
        let axis = |axis: usize| {
            let components = directions.iter().map(|direction| direction[axis]);
            let (low, high) = components.fold((f64::MAX, f64::MIN), |(low, high), at| (low.min(at), high.max(at)));
            Axis {
                ahead: if high > 0.0 { high.recip() } else { f64::INFINITY },
                behind: if low < 0.0 { low.recip() } else { f64::NEG_INFINITY },
                last: if low > 0.0 { Some(low.recip()) } else { (high < 0.0).then(|| high.recip()) },
            }
        };
        Self { origin, reach, axes: [axis(0), axis(1), axis(2)] }
    }

    /// Puts the leaves that the rays may meet into a list, the nearest first.
    pub(super) fn leaves<'a>(&self, tree: &'a Bvh, leaves: &mut Vec<Leaf<'a>>) {
        leaves.clear();
        let found = tree.leaves(|node| self.nearest(node).is_some());
        leaves.extend(found.filter_map(|number| {
            let node = tree.leaf_node(number)?;
            Some(Leaf { nearest: self.nearest(node)?, node, number })
        }));
        // Equally near ones have an order, too, so that results do not depend on the tree's shape.
        leaves.sort_unstable_by(|one, other| one.nearest.total_cmp(&other.nearest).then(one.number.cmp(&other.number)));
    }

    /// Returns a distance that no ray's first point in a box undercuts, m. `None` if no ray meets the box.
    fn nearest(&self, node: &BvhNode) -> Option<f64> {
        let (mut first, mut last) = (0.0_f64, self.reach);
        for (axis, (low, high)) in ends(node, &self.origin).into_iter().enumerate() {
            let Axis { ahead, behind, last: leaves } = self.axes[axis];
            // A product of zero and infinity is not a number, and `max` passes it over.
            first = first.max(low * ahead).max(high * behind);
            if let Some(leaves) = leaves {
                last = last.min((low * leaves).max(high * leaves));
            }
        }
        (first <= last).then_some(first)
    }
}

impl Slab {
    pub(super) fn new(origin: [f64; 3], direction: [f64; 3]) -> Self {
        Self { origin, inverse: direction.map(|component| component.abs().max(LEAST).copysign(component).recip()) }
    }

    /// True if the ray meets a leaf's box within a distance, m.
    pub(super) fn meets(&self, node: &BvhNode, most: f64) -> bool {
        let (mut first, mut last) = (0.0_f64, most);
        for ((low, high), inverse) in ends(node, &self.origin).into_iter().zip(self.inverse) {
            first = first.max((low * inverse).min(high * inverse));
            last = last.min((low * inverse).max(high * inverse));
        }
        first <= last
    }
}

/// Returns the ends of a box along the axes, from a point.
fn ends(node: &BvhNode, origin: &[f64; 3]) -> [(f64, f64); 3] {
    let (low, high) = (node.mins().to_array(), node.maxs().to_array());
    [0, 1, 2].map(|axis| (low[axis] - origin[axis], high[axis] - origin[axis]))
}
