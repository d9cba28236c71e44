//! Settings of a tachometer (Tachometer.uc).

use serde::{Deserialize, Serialize};

/// A tachometer has no settings of its own.
#[derive(Debug, Clone, PartialEq, Default, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Config {}
