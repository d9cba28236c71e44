//! Requests of viewers to the world itself. Robots are driven over the protocol alone.

use std::net::IpAddr;

use crate::live::{Control, Request};

/// Most steps of one request.
const MAX_STEPS: u32 = 100_000;
/// Real-time factors that can be requested, beside 0 for as fast as possible. Below these, a step would take hours.
const SPEEDS: std::ops::RangeInclusive<f64> = 0.001..=10_000.0;

/// Checks a real-time factor.
///
/// # Errors
/// Describes the range that was expected.
pub fn check_real_time_factor(factor: f64) -> Result<f64, String> {
    if factor == 0.0 || SPEEDS.contains(&factor) {
        return Ok(factor);
    }
    Err(format!("expected {} to {}, or 0 for as fast as possible", SPEEDS.start(), SPEEDS.end()))
}

impl Control {
    /// Reads a request to the world.
    ///
    /// # Errors
    /// Describes the problem.
    pub fn read(text: &str) -> Result<Self, String> {
        match Request::read(text)? {
            Request::Control(control) => Ok(control),
            Request::Token(_) | Request::Fit(_) | Request::Echo(_) | Request::Listen(_) => {
                Err("it is of a page: expected a control".to_owned())
            }
        }
    }

    /// Checks the numbers.
    ///
    /// # Errors
    /// Describes the problem.
    pub fn checked(self) -> Result<Self, String> {
        match self {
            Self::Step(steps) if !(1..=MAX_STEPS).contains(&steps) => {
                Err(format!("`step` is {steps}: expected 1 to {MAX_STEPS}"))
            }
            Self::Speed(speed) => {
                let checked = check_real_time_factor(speed);
                checked.map(Self::Speed).map_err(|expected| format!("`speed` is {speed}: {expected}"))
            }
            Self::Pause(_)
            | Self::Step(_)
            | Self::Reset
            | Self::Record(_)
            | Self::Save
            | Self::Remove(_)
            | Self::Map(_)
            | Self::Scenario(_) => Ok(self),
        }
    }
}

/// A viewer that controls the world, as shown to everyone.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Actor(pub String);

impl Actor {
    /// Names a page by its number and address.
    pub fn page(number: u64, address: IpAddr) -> Self {
        Self(format!("page {number} ({address})"))
    }

    /// Names a client of Foxglove, whose protocol does not identify clients.
    pub fn foxglove() -> Self {
        Self("Foxglove".to_owned())
    }
}
