//! Trees of links in reduced coordinates, and a time step in which their servos, contacts and joints are solved together.
//!
//! A [`Tree`] says how links hang on each other, a [`Body`] is one of them in motion. [`step`] finds the velocities at the end of a time
//! step for bodies that touch the world and each other: servos are implicit in the speeds of their joints, so that the contacts feel how
//! stiff they are, and friction is Coulomb's, solved to the end (the crate `friction`).
//!
//! Nothing here knows shapes: whoever has those says where bodies touch. World axes, SI units. A body's generalised velocity is its root's
//! angular velocity, the velocity of its root's centre of mass, then the speeds of its joints, link by link.
//!
//! # Method
//! The matrix of inertia is that of composite bodies, and its factors have entries only where one joint is above another (Featherstone,
//! "Rigid Body Dynamics Algorithms", 2008, chapters 6 and 8): both cost as much as the tree is deep, link by link. Everything is
//! expressed in world axes about the centre of mass of the root, so that no link needs a transform of its own.

mod body;
mod factor;
mod inertia;
mod system;
mod tree;

pub use body::{Body, Drive, Frame};
pub use system::{Contact, JointRow, Outcome, Side, Workspace, most_work, step};
pub use tree::{Joint, Link, Mass, Tree};

/// A position and orientation.
pub type Pose = nalgebra::Isometry3<f64>;
