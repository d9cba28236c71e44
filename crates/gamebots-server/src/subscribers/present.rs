//! The present: a snapshot and the poses that guests ask for, which observers on all threads share.

use std::sync::Arc;

use scene::Snapshot;
use served_world::Actors;
use sim_core::World;

/// A snapshot and the poses of everything, made when first needed after a change.
#[derive(Default)]
pub(crate) struct Present {
    snapshot: Option<Arc<Snapshot>>,
    actors: Option<Arc<Actors>>,
}

impl Present {
    /// Returns the snapshot of a world.
    pub(crate) fn of(&mut self, world: &World) -> Arc<Snapshot> {
        let known = self.snapshot.take().filter(|snapshot| snapshot.time.to_bits() == world.time().to_bits());
        self.snapshot.insert(known.unwrap_or_else(|| Arc::new(world.snapshot()))).clone()
    }

    /// Returns everything that has a pose in a world.
    pub(crate) fn actors(&mut self, world: &World) -> Arc<Actors> {
        let known = self.actors.take().filter(|actors| actors.time().to_bits() == world.time().to_bits());
        self.actors.insert(known.unwrap_or_else(|| Arc::new(Actors::of(world)))).clone()
    }

    /// Drops what is known, because the world changed between two steps.
    pub(crate) fn forget(&mut self) {
        *self = Self::default();
    }
}

#[cfg(test)]
mod tests {
    use scene::WorldDef;
    use sim_core::Options;

    use super::*;

    #[test]
    fn a_step_or_a_change_makes_a_new_snapshot() {
        let (mut world, mut present) = (World::new(WorldDef::default(), Options::default()), Present::default());
        let first = present.of(&world);
        assert!(Arc::ptr_eq(&first, &present.of(&world)), "nothing changed");
        present.forget();
        assert!(!Arc::ptr_eq(&first, &present.of(&world)));
        world.step();
        assert_eq!(present.of(&world).time.to_bits(), world.time().to_bits());
    }
}
