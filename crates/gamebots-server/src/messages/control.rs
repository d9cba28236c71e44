//! Requests of viewers to the world itself. Robots are driven over the protocol alone.

use std::net::IpAddr;

use serde::Deserialize;

/// A request to the world's thread.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum Control {
    /// Stops or resumes time.
    Pause(bool),
    /// A number of steps, after which time stops.
    Step(u32),
    /// Simulated seconds per real second; 0 is as fast as possible.
    Speed(f64),
    /// A fresh world of the same scene and seed. Connected clients get their robots back at their first poses.
    Reset,
    /// Starts or ends a log.
    Record(bool),
    /// Saves the world to a file.
    Save,
    /// Removes a robot, by its number. Its client stays.
    Remove(u64),
    /// A fresh world on another map, by name. Connected clients get their robots back.
    Map(String),
}

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
    /// Reads a request, as in `{"pause":true}`, `{"step":1}`, `{"speed":2.5}`, `"reset"`, `{"record":true}`, `"save"`,
    /// `{"remove":3}`, `{"map":"arena"}`.
    ///
    /// # Errors
    /// Describes the problem.
    pub(crate) fn read(text: &str) -> Result<Self, String> {
        let expected = "expected {\"pause\":bool}, {\"step\":n}, {\"speed\":x}, \"reset\", {\"record\":bool}, \"save\", {\"remove\":robot} or {\"map\":name}";
        let control: Self = serde_json::from_str(text).map_err(|error| format!("{error}: {expected}"))?;
        match control {
            Self::Step(steps) if !(1..=MAX_STEPS).contains(&steps) => {
                Err(format!("`step` is {steps}: expected 1 to {MAX_STEPS}"))
            }
            Self::Speed(speed) => {
                let checked = check_real_time_factor(speed);
                checked.map(Self::Speed).map_err(|expected| format!("`speed` is {speed}: {expected}"))
            }
            _ => Ok(control),
        }
    }
}

/// A viewer that controls the world, as shown to everyone.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Actor(pub(crate) String);

impl Actor {
    /// Names a page by its number and address.
    pub(crate) fn page(number: u64, address: IpAddr) -> Self {
        Self(format!("page {number} ({address})"))
    }

    /// Names a client of Foxglove, whose protocol does not identify clients.
    pub(crate) fn foxglove() -> Self {
        Self("Foxglove".to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn requests_are_read_and_limited() {
        for (text, expected) in [
            ("{\"pause\":true}", Some(Control::Pause(true))),
            ("{\"step\":5}", Some(Control::Step(5))),
            ("{\"speed\":0}", Some(Control::Speed(0.0))),
            ("\"reset\"", Some(Control::Reset)),
            ("{\"record\":false}", Some(Control::Record(false))),
            ("{\"map\":\"arena\"}", Some(Control::Map("arena".to_owned()))),
            ("{\"remove\":3}", Some(Control::Remove(3))),
            ("{\"remove\":-1}", None),
            ("{\"step\":0}", None),
            ("{\"step\":100001}", None),
            ("{\"speed\":-1}", None),
            ("{\"speed\":1e300}", None),
            ("{\"speed\":1e-300}", None),
            ("{\"speed\":1e-22}", None),
            ("{\"speed\":0.001}", Some(Control::Speed(0.001))),
            ("{\"drive\":1}", None),
            ("{\"pause\":1}", None),
            ("", None),
        ] {
            assert_eq!(Control::read(text).ok(), expected, "{text}");
        }
    }
}
