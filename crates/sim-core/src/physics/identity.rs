//! Identities of colliders, stored in them so that rays and contacts know what they hit.

use rapier3d::prelude::*;

use crate::{ObjectId, PawnId};

/// An entity of a world.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Identity {
    /// A fixed body, by its number among the map's solids.
    Solid(u32),
    /// A movable object.
    Object(ObjectId),
    /// A link of a robot.
    Link {
        /// The robot.
        robot: PawnId,
        /// The link's number in the tree of the robot's drive model; 0 is its body.
        link: u32,
    },
}

/// A body that the articulated mechanics moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(super) enum BodyId {
    /// A robot.
    Robot(PawnId),
    /// A movable object.
    Object(ObjectId),
}

/// Data stored in a collider.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Mark {
    pub(super) identity: Identity,
    /// Number of its material in the scene's table.
    pub(super) material: u32,
}

const SOLID: u8 = 0;
const OBJECT: u8 = 1;
const LINK: u8 = 2;

impl Mark {
    /// Packs the mark, from the highest bits down: robot or object 64, material 32, index 24, kind 8.
    pub(super) fn to_bits(self) -> u128 {
        let (kind, index, owner) = match self.identity {
            Identity::Solid(index) => (SOLID, index, 0),
            Identity::Object(object) => (OBJECT, 0, object.0),
            Identity::Link { robot, link } => (LINK, link, robot.0),
        };
        u128::from(owner) << 64 | u128::from(self.material) << 32 | u128::from(index) << 8 | u128::from(kind)
    }

    /// Unpacks the mark of a collider. Every collider has one.
    pub(super) fn of(collider: &Collider) -> Self {
        let bits = collider.user_data;
        let index = (bits >> 8) as u32 & 0xff_ffff;
        let identity = match bits as u8 {
            SOLID => Identity::Solid(index),
            OBJECT => Identity::Object(ObjectId((bits >> 64) as u64)),
            _ => Identity::Link { robot: PawnId((bits >> 64) as u64), link: index },
        };
        Self { identity, material: (bits >> 32) as u32 }
    }

    /// True if a collider is part of a robot.
    pub(super) fn is_of(collider: &Collider, robot: PawnId) -> bool {
        matches!(Self::of(collider).identity, Identity::Link { robot: owner, .. } if owner == robot)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_collider_knows_what_it_is() {
        for identity in [
            Identity::Solid(7),
            Identity::Object(ObjectId(u64::MAX)),
            Identity::Link { robot: PawnId(0), link: 0 },
            Identity::Link { robot: PawnId(u64::MAX), link: 28 },
        ] {
            for material in [0, u32::MAX] {
                let mark = Mark { identity, material };
                let collider = ColliderBuilder::ball(1.0).user_data(mark.to_bits()).build();
                assert_eq!(Mark::of(&collider), mark);
            }
        }
    }
}
