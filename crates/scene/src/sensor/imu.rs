//! Numbers of an inertial measurement unit (IMU.uc).

use serde::{Deserialize, Serialize};

/// It has no numbers of its own: no noise either.
#[derive(Debug, Clone, PartialEq, Default, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {}
