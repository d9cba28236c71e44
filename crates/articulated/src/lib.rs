//! Trees of links in reduced coordinates, and a time step that solves their servos, contacts and joints together.
//!
//! A [`Tree`] has the links and their joints. A [`Body`] is a tree in motion. [`step`] finds the velocities at the end of a time step, for
//! bodies that touch the world and each other. Servos are implicit in the speeds of their joints, so the contacts feel their stiffness.
//! Friction is Coulomb's, solved to convergence (the crate `friction`).
//!
//! Nothing here knows shapes: the caller gives the contact points. World axes, SI units. A body's generalised velocity has three parts: its
//! root's angular velocity, the velocity of its root's centre of mass, and the speeds of its joints, link by link.
//!
//! # Method
//! The inertia matrix is that of composite bodies. Its factors have entries only where one joint is above another (Featherstone, "Rigid
//! Body Dynamics Algorithms", 2008, chapters 6 and 8). For each link, both cost as much as the tree is deep. Everything is expressed in
//! world axes about the root's centre of mass, so no link needs a transform of its own.

mod body;
mod factor;
mod inertia;
mod system;
mod tree;

pub use body::{Body, Drive, Frame, Motion};
pub use system::{Contact, JointRow, Outcome, Side, Workspace, most_work, step};
pub use tree::{Joint, Link, Mass, Tree};

/// A position and orientation.
pub type Pose = nalgebra::Isometry3<f64>;
