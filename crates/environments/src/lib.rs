//! Many worlds at once, for learning and planning.
//!
//! [`WorldBatch`] advances copies of a world in one call, with orders and observations in two arrays. [`Environments`] plays a [`Task`]
//! in many worlds: actions go in; observations, rewards and ends of episodes come out. Both use a [`thread_pool::ThreadPool`], and give
//! the same bits for any number of worlds and threads.
//!
//! The crate uses no clock and no file except those that a task names.

mod environment;
mod environments;
mod task;
mod world_batch;

pub use environments::{Autoreset, Environments, Outcomes};
pub use task::{Task, TaskError};
pub use world_batch::{BatchError, Column, Orders, WorldBatch};
