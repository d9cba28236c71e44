//! The messages between the page and its server, each defined once. The page's types are generated from these definitions.
//!
//! Texts are JSON: [`Request`] to the server, [`Message`] to the page. Frames and scans are protobuf, by `proto/live.proto`. The scene and
//! each class of robots are JSON, too. Nothing here reads a socket or a clock.

#![warn(clippy::indexing_slicing, clippy::string_slice, clippy::expect_used)]
#![cfg_attr(test, allow(clippy::indexing_slicing, clippy::string_slice, clippy::expect_used))]

mod control;
mod frame;
mod live;
mod page_scene;
pub mod pb;

pub use control::{Actor, check_real_time_factor};
pub use frame::{encode, frame, past, scan};
pub use live::{
    ClientStatus, Control, Fit, LeagueStatus, Line, Listen, Measured, Message, Request, RobotStatus, Status, Wanted,
};
pub use page_scene::{About, class_json, objects_json, scenarios_json, scene_json};
