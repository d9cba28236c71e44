//! Room for a robot, which a page asks for before it spawns one.

use serde::{Deserialize, Serialize};
use sim_core::{FreePlace, World};

/// A question, as in `{"fit":{"class":"P3AT","location":[1,0,0],"yaw":0.5}}`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Ask {
    fit: Wanted,
}

/// A robot and the pose that is asked about.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Wanted {
    class: String,
    /// As in INIT, m.
    location: [f64; 3],
    /// Heading, rad.
    yaw: f64,
}

/// An answer: the question and its result.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Fit {
    #[serde(flatten)]
    wanted: Wanted,
    /// True if the robot can stand right there.
    stands: bool,
    /// The obstacle, in words.
    why: Option<String>,
}

impl Ask {
    /// Reads a question; `None` for another request.
    pub(crate) fn read(text: &str) -> Option<Self> {
        serde_json::from_str(text).ok()
    }

    /// Checks the pose in the world.
    pub(crate) fn answer(self, world: &mut World) -> Fit {
        let Wanted { class, location, yaw } = &self.fit;
        let why = match world.fit(class, *location, [0.0, 0.0, *yaw]) {
            None => Some(format!("no class `{class}`")),
            Some(Ok(FreePlace { beside, .. })) => beside,
            Some(Err(why)) => Some(why),
        };
        Fit { wanted: self.fit, stands: why.is_none(), why }
    }
}
