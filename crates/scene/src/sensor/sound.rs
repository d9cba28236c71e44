//! Numbers of a microphone, a sensor of UT2004. It hears as an array of microphones does.

pub use super::acoustic::Config;
use crate::reading::reading;

reading! {
    /// The loudest sound that is heard at the moment.
    {
        /// Loudness; 0 in silence.
        loudness: f64 = "dB",
        /// Length of the sound.
        duration: f64 = "s",
    }
}
