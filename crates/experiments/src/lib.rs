//! What is measured in the world: motions against exact kinematics, the twelve checks, and experiments from files.
//!
//! No clock here: whoever wants to know how long something took in real time takes the time around it.

mod course;
pub mod validation;

pub use course::{Course, Moment, Motion, MotionError, Travel};
