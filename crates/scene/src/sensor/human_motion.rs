//! Numbers of a sensor of moving persons, a sensor of UT2004. It sees as a sensor of victims does.

pub use super::victim::Config;
use crate::reading::reading;

reading! {
    /// Motion of a person in view.
    {
        /// Probability that one moves, which falls linearly to 0 at the greatest distance.
        probability: f64 = "",
    }
}
