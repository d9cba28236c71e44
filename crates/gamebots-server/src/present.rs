//! The snapshot of the present, which observers on all threads share.

use std::sync::Arc;

use scene::Snapshot;
use sim_core::World;

/// A snapshot, made when first needed after a change.
#[derive(Default)]
pub(crate) struct Present(Option<Arc<Snapshot>>);

impl Present {
    /// Returns the snapshot of a world.
    pub(crate) fn of(&mut self, world: &World) -> Arc<Snapshot> {
        let known = self.0.take().filter(|snapshot| snapshot.time.to_bits() == world.time().to_bits());
        self.0.insert(known.unwrap_or_else(|| Arc::new(world.snapshot()))).clone()
    }

    /// Drops the snapshot, because the world changed between two steps.
    pub(crate) fn forget(&mut self) {
        self.0 = None;
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
