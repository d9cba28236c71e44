//! Contacts with Coulomb friction, solved to convergence.
//!
//! In each step a contact gives an impulse along its normal, which never pulls, and one in its tangent plane. The latter is at most the
//! coefficient of friction times the normal impulse. A sliding contact gives all of it, against its slip. Joint ends, dry friction and
//! couplings are simpler: a normal alone, or one row with a limit. A [`Problem`] has the Delassus matrix of all rows and the right-hand
//! side. [`solve`] finds the impulses.
//!
//! Nothing here knows bodies, shapes or steps: the caller reduces those to rows.
//!
//! # Method
//! Sweeps over the contacts solve each contact exactly for the impulses of the others. Within a few sweeps they find which contacts push,
//! hold and slide. They are slow to find the amounts if one body has many nearly equal contacts. Newton's method does that in two or three
//! steps from there. In steady motion one Newton step from the last step's impulses is enough. Both methods are bounded, so there is always
//! an answer. [`Outcome`] tells if it converged.
//!
//! A [`SparseProblem`] has many bodies, each of which touches few others. [`solve_sparse`] uses the same sweeps and steps. It eliminates
//! the impulses from Newton's equations instead of the velocities, so work and memory grow with the number of bodies.

mod block_lu;
mod local;
mod newton;
mod problem;
mod solver;
mod sparse;
mod sparse_newton;
mod sparse_solver;

pub use problem::{Constraint, Problem, Residual};
pub use solver::{Outcome, TOLERANCE, Workspace, solve};
pub use sparse::SparseProblem;
pub use sparse_solver::{Effort, SparseOutcome, SparseWorkspace, solve_sparse};
