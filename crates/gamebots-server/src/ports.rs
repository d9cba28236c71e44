//! The ports, a file each.

pub(crate) mod com_server;
pub(crate) mod controllers;
pub(crate) mod gate;
pub(crate) mod images;
pub(crate) mod playback;
pub(crate) mod truth;
pub(crate) mod wireless;
