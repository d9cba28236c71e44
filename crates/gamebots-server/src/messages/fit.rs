//! Answers to the page's question if a robot has room.

use sim_core::{FreePlace, World};

use crate::messages::live::{Fit, Wanted};

impl Wanted {
    /// Checks the pose in the world.
    pub(crate) fn answer(self, world: &mut World) -> Fit {
        let Self { class, location, yaw } = &self;
        let why = match world.fit(class, *location, [0.0, 0.0, *yaw]) {
            None => Some(format!("no class `{class}`")),
            Some(Ok(FreePlace { beside, .. })) => beside,
            Some(Err(why)) => Some(why),
        };
        Fit { wanted: self, stands: why.is_none(), why }
    }
}
