//! What is measured in the world: motions against exact kinematics, physical checks, and experiments from files.
//!
//! ```text
//! file.toml -> Plan -> [Run] -> Outcome (steps) -> tables, plots, report
//!                        \-> log (MCAP)
//! ```
//!
//! No clock here: whoever wants to know how long something took in real time takes the time around it.

pub mod batch;
pub mod claim;
mod course;
mod crowd;
pub mod fit;
pub mod plan;
pub mod plot;
mod reference;
pub mod report;
pub mod run;
pub mod table;
pub mod thesis;
pub mod validation;

pub use course::{Course, Moment, Motion, MotionError, Travel};
pub use crowd::Crowd;
