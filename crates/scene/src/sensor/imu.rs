//! Settings of an inertial measurement unit (IMU.uc).

use serde::{Deserialize, Serialize};

/// An IMU has no settings of its own, and no noise.
#[derive(Debug, Clone, PartialEq, Default, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {}
