//! Answers to the page's question if a robot has room.

use page_protocol::{Fit, Wanted};
use sim_core::{FreePlace, World};

/// Checks a robot's pose in the world.
pub fn fit(wanted: Wanted, world: &mut World) -> Fit {
    let Wanted { class, location, yaw } = &wanted;
    let why = match world.fit(class, *location, [0.0, 0.0, *yaw]) {
        None => Some(format!("no class `{class}`")),
        Some(Ok(FreePlace { beside, .. })) => beside,
        Some(Err(why)) => Some(why),
    };
    Fit { wanted, stands: why.is_none(), why }
}
