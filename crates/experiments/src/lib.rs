//! Measurements in the world: motions against exact kinematics, physical checks, and experiments from files.
//!
//! ```text
//! file.toml -> Plan -> [Run] -> Outcome (steps) -> tables, plots, report
//!                        \-> log (MCAP)
//! ```
//!
//! This crate reads no clock: callers that need real time measure it themselves.

pub mod batch;
pub mod calibrate;
pub mod claim;
mod course;
mod crowd;
pub mod fit;
mod inertia;
pub mod plan;
pub mod plot;
pub mod real;
mod reference;
pub mod report;
pub mod run;
pub mod sweep;
pub mod table;
pub mod thesis;
pub mod validation;

pub use course::{Course, Moment, Motion, MotionError, Travel};
pub use crowd::Crowd;
