//! What a person who watches can do with the world itself; robots are driven over the protocol alone.

use serde::Deserialize;

/// A wish for the world's thread.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum Control {
    /// Stops time, or lets it go on.
    Pause(bool),
    /// So many steps; time stops after them.
    Step(u32),
    /// Simulated seconds a real second; 0 is as fast as possible.
    Speed(f64),
    /// A fresh world of the same scene and seed, with the robots of everyone who is connected at their first places.
    Reset,
    /// Begins a log, or ends it.
    Record(bool),
}

/// Steps that can be asked for at once.
const MAX_STEPS: u32 = 100_000;
/// Highest real-time factor that can be asked for.
pub(crate) const MAX_SPEED: f64 = 10_000.0;

impl Control {
    /// Reads a wish, as in `{"pause":true}`, `{"step":1}`, `{"speed":2.5}`, `"reset"`, `{"record":true}`.
    ///
    /// # Errors
    /// What is wrong with it, in words.
    pub(crate) fn read(text: &str) -> Result<Self, String> {
        let expected = "expected {\"pause\":bool}, {\"step\":n}, {\"speed\":x}, \"reset\" or {\"record\":bool}";
        let control: Self = serde_json::from_str(text).map_err(|error| format!("{error}: {expected}"))?;
        match control {
            Self::Step(steps) if !(1..=MAX_STEPS).contains(&steps) => {
                Err(format!("`step` is {steps}: expected 1 to {MAX_STEPS}"))
            }
            Self::Speed(speed) if !(0.0..=MAX_SPEED).contains(&speed) => {
                Err(format!("`speed` is {speed}: expected 0 to {MAX_SPEED}"))
            }
            _ => Ok(control),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wishes_are_read_and_limited() {
        for (text, expected) in [
            ("{\"pause\":true}", Some(Control::Pause(true))),
            ("{\"step\":5}", Some(Control::Step(5))),
            ("{\"speed\":0}", Some(Control::Speed(0.0))),
            ("\"reset\"", Some(Control::Reset)),
            ("{\"record\":false}", Some(Control::Record(false))),
            ("{\"step\":0}", None),
            ("{\"step\":100001}", None),
            ("{\"speed\":-1}", None),
            ("{\"speed\":1e300}", None),
            ("{\"drive\":1}", None),
            ("{\"pause\":1}", None),
            ("", None),
        ] {
            assert_eq!(Control::read(text).ok(), expected, "{text}");
        }
    }
}
