//! The battery as an item.

use serde::{Deserialize, Serialize};

/// A battery sensor has no settings; the robot has the battery's numbers.
#[derive(Debug, Clone, PartialEq, Default, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {}
