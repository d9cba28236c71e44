//! The thread of the world, its long work, and files of saved worlds.

pub(crate) mod saves;
pub(crate) mod tasks;
pub(crate) mod thread;
