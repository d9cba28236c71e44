//! The page: its files, its requests and its two WebSockets.

pub(crate) mod class;
pub(crate) mod file;
pub(crate) mod log_scene;
pub(crate) mod metrics;
pub(crate) mod packed;
pub(crate) mod shared;
pub(crate) mod site;
pub(crate) mod view;
pub(crate) mod viewer;
pub(crate) mod wire;
