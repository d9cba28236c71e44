//! A staged defect of the world's thread, to test the report of one.

use served_world::Told;

use crate::subscribers::subscriber::{Moment, Shot, Subscriber};

/// A listener that panics.
pub(crate) struct Defect {
    /// Simulated time of the panic, s.
    pub(crate) at: f64,
}

impl Subscriber for Defect {
    fn hear(&mut self, _: &mut Moment, _: &Told) {}

    fn stepped(&mut self, moment: &mut Moment) -> Vec<Shot> {
        assert!(moment.world.time() < self.at, "asked to panic");
        Vec::new()
    }
}
