//! The page: its files, its requests and its WebSockets.

pub(crate) mod class;
pub(crate) mod file;
pub(crate) mod log_scene;
pub(crate) mod map;
pub(crate) mod metrics;
pub(crate) mod open;
pub(crate) mod opener;
pub(crate) mod packed;
#[cfg(feature = "ros2")]
pub(crate) mod rosbridge;
pub(crate) mod scenario;
pub(crate) mod shared;
pub(crate) mod site;
pub(crate) mod view;
pub(crate) mod viewer;
pub(crate) mod wire;
