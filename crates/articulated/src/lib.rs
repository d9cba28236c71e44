//! Robots as trees of links in reduced coordinates, and a time step that solves their servos, contacts and joints together.
//!
//! Servos are implicit in the speeds of their joints, so the contacts feel their stiffness, and any gain is stable at any time step.
//! Friction is Coulomb's, solved to convergence (the crate `friction`). Bodies that touch each other are one system.
//!
//! Nothing here knows shapes: the caller gives the contact points. Vectors are in world axes, which may point anywhere, and units are SI.
//! A body's generalised velocity has three parts: its root's angular velocity, the velocity of its root's centre of mass, and the speeds
//! of its joints, link by link.
//!
//! | type | content |
//! |---|---|
//! | [`Tree`] | the links and their joints, which do not change: [`Link`], [`Joint`], [`Mass`] |
//! | [`Body`] | a tree in motion: pose, joint positions, velocity, servos ([`Drive`]) |
//! | [`Motion`] | position and velocity of a body as plain data |
//! | [`Contact`] | a contact point with its normal, tangents and friction, between two [`Side`]s |
//! | [`JointRow`] | an end, dry friction or a coupling of joints |
//! | [`step`] | the solver: finds the velocities at the end of a time step; [`Body::advance`] then moves the body |
//! | [`Outcome`] | convergence and work of a step |
//! | [`Workspace`] | scratch buffers, reused from step to step |
//!
//! # Example
//! A spinning disc is put on the ground. It slips until it rolls, with a third of its rim speed.
//!
//! ```
//! use std::sync::Arc;
//!
//! use articulated::{Body, Contact, Joint, Link, Mass, Pose, Side, Tree, Workspace, step};
//! use nalgebra::{Matrix3, Vector3};
//!
//! let (mass, radius, time_step, zero) = (2.0, 0.1, 0.001, Vector3::zeros());
//! let inertia = Matrix3::from_diagonal(&Vector3::new(0.25, 0.5, 0.25)) * (mass * radius * radius);
//! let disc = Link::new(0, Joint::Free, zero, Mass { mass, centre: zero, inertia });
//! let mut body = Body::new(Arc::new(Tree::new(vec![disc])), Pose::translation(0.0, 0.0, -radius));
//! // z points down. The disc spins about -y, which rolls it along x.
//! body.set_gravity(Vector3::z() * 9.81);
//! body.velocity_mut()[1] = -30.0;
//! body.place();
//! let mut workspace = Workspace::default();
//! for _ in 0..500 {
//!     let mut contact = Contact {
//!         point: body.centre() + Vector3::z() * radius,
//!         normal: -Vector3::z(),
//!         tangents: [Some(Vector3::x()), Some(Vector3::y())],
//!         friction: 0.5,
//!         target: 0.0,
//!         compliance: [0.0; 3],
//!         first: Side { body: 0, link: 0 },
//!         second: None,
//!         drift: zero,
//!         impulse: zero,
//!         memory: zero,
//!     };
//!     let outcome = step(&mut [&mut body], std::slice::from_mut(&mut contact), &mut [], time_step, &mut workspace);
//!     assert!(outcome.is_settled);
//!     body.advance(time_step);
//! }
//! let (spin, speed) = (-body.velocity()[1], body.velocity()[3]);
//! assert!((speed - 30.0 * radius / 3.0).abs() < 1e-3);
//! assert!((speed - spin * radius).abs() < 1e-3);
//! ```
//!
//! # Method
//! The inertia matrix is that of composite bodies. Its factors have entries only where one joint is above another (Featherstone, "Rigid
//! Body Dynamics Algorithms", 2008, chapters 6 and 8). For each link, both cost as much as the tree is deep. Everything is expressed in
//! world axes about the root's centre of mass, so no link needs a transform of its own.

mod body;
mod factor;
mod inertia;
mod root;
mod system;
mod tree;

pub use body::{Body, Drive, Frame, Motion};
pub use system::{Contact, JointRow, Outcome, Side, Workspace, most_work, step};
pub use tree::{Joint, Link, Mass, Tree};

/// A position and orientation.
pub type Pose = nalgebra::Isometry3<f64>;

/// The examples of the README, as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
