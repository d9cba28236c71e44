//! Contacts with Coulomb friction, solved to convergence: from the velocities without contacts to the impulses of a time step.
//!
//! In each step a contact gives an impulse along its normal, which never pulls, and one in its tangent plane. The latter is at most the
//! coefficient of friction times the normal impulse. A sliding contact gives all of it, against its slip. Joint ends, dry friction and
//! couplings are simpler: a normal alone, or one row with a limit.
//!
//! Nothing here knows bodies, shapes or steps: the caller reduces those to rows. The crate `articulated` does so for trees of links.
//! A row's direction is the caller's choice. Velocities are in m/s, impulses in N s. A row about an axis takes rad/s and N m s.
//!
//! | type | content |
//! |---|---|
//! | [`Constraint`] | rows that belong together, with the bounds of their impulses |
//! | [`Problem`] | the Delassus matrix of all rows and the right-hand side; [`solve`] finds its impulses |
//! | [`SparseProblem`] | many bodies, each of which touches few others; [`solve_sparse`] finds the impulses within an [`Effort`] |
//! | [`Outcome`], [`SparseOutcome`] | convergence and work of a solution |
//! | [`Residual`] | the error of any impulses; [`Problem::residual`] computes it |
//! | [`Workspace`], [`SparseWorkspace`] | scratch buffers, reused from problem to problem |
//!
//! # Example
//! A block starts to slide if the slope is steeper than its friction holds.
//!
//! ```
//! use friction::{Constraint, Problem, Workspace, solve};
//!
//! /// Returns the speed down a slope after a step from rest, m/s.
//! fn slide(slope: f64, friction: f64) -> f64 {
//!     let (mass, gravity, time_step) = (2.0, 9.81, 0.01);
//!     // Free velocities: into the slope and down it.
//!     let (into, down) = (gravity * time_step * slope.cos(), gravity * time_step * slope.sin());
//!     let problem = Problem {
//!         // Rows: the normal, the tangent down the slope, the tangent across it.
//!         delassus: vec![1.0 / mass, 0.0, 0.0, 0.0, 1.0 / mass, 0.0, 0.0, 0.0, 1.0 / mass],
//!         right_side: vec![into, -down, 0.0],
//!         constraints: vec![Constraint::Contact { friction, tangents: 2 }],
//!     };
//!     let mut impulses = [0.0; 3];
//!     let outcome = solve(&problem, &mut impulses, &mut Workspace::default());
//!     assert!(outcome.is_settled);
//!     down + impulses[1] / mass
//! }
//!
//! // tan(0.3) = 0.309: a friction of 0.5 holds the block, one of 0.2 does not.
//! let slope = 0.3_f64;
//! assert!(slide(slope, 0.5).abs() < 1e-6);
//! let expected = 0.01 * 9.81 * (slope.sin() - 0.2 * slope.cos());
//! assert!((slide(slope, 0.2) - expected).abs() < 1e-6);
//! ```
//!
//! # Method
//! Sweeps over the contacts solve each contact exactly for the impulses of the others. Within a few sweeps they find which contacts push,
//! hold and slide. They are slow to find the amounts if one body has many nearly equal contacts. Newton's method does that in two or three
//! steps from there. In steady motion one Newton step from the last step's impulses is enough. Its equations leave out impulses that follow
//! from others: of contacts that let go, of joints at their bounds, and of rollers that slide. Both methods are bounded, so there is always
//! an answer. [`Outcome`] tells if it converged.
//!
//! [`solve_sparse`] uses the same sweeps and steps. It eliminates the impulses from Newton's equations instead of the velocities, so work
//! and memory grow with the number of bodies. A coordinate that one constraint alone touches is eliminated in that constraint.

mod block_lu;
mod local;
mod newton;
mod parts;
mod problem;
mod solver;
mod sparse;
mod sparse_newton;
mod sparse_solver;

pub use newton::Workspace;
pub use problem::{Constraint, Problem, Residual};
pub use solver::{Outcome, TOLERANCE, solve};
pub use sparse::SparseProblem;
pub use sparse_solver::{Effort, SparseOutcome, SparseWorkspace, solve_sparse};

/// The examples of the README, as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
