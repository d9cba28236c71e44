//! Listeners of the world: logs, viewers, Foxglove, results.

pub(crate) mod board;
pub(crate) mod cameras;
pub(crate) mod defect;
pub(crate) mod foxglove;
pub(crate) mod job;
pub(crate) mod journal;
pub(crate) mod live;
pub(crate) mod log;
pub(crate) mod past;
pub(crate) mod present;
pub(crate) mod publisher;
pub(crate) mod results;
#[cfg(feature = "ros2")]
pub(crate) mod ros2;
pub(crate) mod shots;
pub(crate) mod subscriber;
