//! Motion of a robot's base by its wheels: from a class of robots to the kinematics that fit it.
//!
//! [`Base`] is the whole of it: displacements of the base from angles of its wheels, as odometry needs them, and speeds of the wheels from
//! a twist, as a driver does.

mod base;
pub mod mecanum;
mod sliding;
mod steering;

pub use base::{Base, Car, DiffDrive, Drive, Model, Sliding};
pub use steering::{joint_angles, joint_limits, speed_shares};

/// The example of the README, as a test.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
