//! Contacts with Coulomb's friction, solved to the end.
//!
//! Between two steps every contact gives an impulse: along its normal, which never pulls, and in its tangent plane, at most the
//! coefficient of friction times the normal impulse. Where it slides it gives all of that, against its slip. Ends of joints, their dry
//! friction and couplings are less than that: a normal alone, or one row with a limit. A [`Problem`] says
//! what velocity an impulse on any row gives on any other, and what velocities are missing; [`solve`] finds the impulses.
//!
//! Nothing here knows bodies, shapes or steps: whoever has those reduces them to rows.
//!
//! # Method
//! Sweeps over the contacts, each solved exactly for the impulses of the others, say within a few which contacts push, which hold and
//! which slide. They are slow to say how much where many contacts of one body say nearly the same; Newton's method does that in two or
//! three steps from there. In steady motion the impulses of the step before are a start from which one step of it is enough. Both have a
//! bound, so that there is always an answer, and [`Outcome`] says whether it is right.
//!
//! A [`SparseProblem`] has many bodies, of which each touches few. [`solve_sparse`] takes the same sweeps and steps, but eliminates the
//! impulses from Newton's equations instead of the velocities, so that work and memory grow with the bodies.

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
pub use sparse_solver::{SparseOutcome, SparseWorkspace, solve_sparse};
