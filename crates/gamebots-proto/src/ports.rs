//! The ports beside the controllers': questions, and answers to them. They have no dialects.

mod com_server;
mod login;
mod pictures;
mod positions;
mod truth;
mod wireless;

pub use com_server::{ComAnswer, ComCommand, ComFraming, ComLink};
pub use login::{login, read_login};
pub use pictures::{PictureRequest, PictureRequests, picture, raw};
pub use positions::{Obstacles, Place, PositionsQuestion, Stand, positions};
pub use truth::{Row, TRUTH_END, TruthQuestion, rows};
pub use wireless::{Strength, WirelessCommand, WirelessError, origin, registered, route, strength};
