//! Ports beside the page: a conversation each.

pub(crate) mod com_server;
pub(crate) mod controllers;
pub(crate) mod foxglove;
pub(crate) mod gate;
pub(crate) mod images;
pub(crate) mod playback;
pub(crate) mod positions;
pub(crate) mod truth;
pub(crate) mod wireless;
