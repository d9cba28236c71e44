//! Lines of the ports beside the controllers': questions, and answers to them. They have no dialects.

mod positions;
mod truth;

pub use positions::{Obstacles, Place, PositionsQuestion, Stand, positions};
pub use truth::{Row, TruthQuestion, rows};
