//! The battery as an item.

use serde::{Deserialize, Serialize};

/// The numbers of a battery are the robot's.
#[derive(Debug, Clone, PartialEq, Default, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {}
