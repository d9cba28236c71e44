//! The simulated world.
//!
//! A [`World`] consists of plain definitions ([`scene`]) and a seed. It takes commands and returns reports. It uses no socket, clock,
//! file, environment variable or thread of its own. Time is the number of steps taken. The same scene, seed and commands by step give
//! the same bits on any number of [`Threads`].
//!
//! The world frame is that of the wire: x forward, y right, z down, right-handed. Units: metres, kilograms, seconds, radians.

mod compiled;
mod drive;
mod flight;
mod kinds;
pub mod mecanum;
mod physics;
mod sensor;
mod site;
mod sliding;
mod threads;
mod world;

pub use compiled::CompiledScene;
pub use drive::Order;
pub use flight::Flight;
pub use physics::Fault;
pub use scene::{BodyState, ObjectId, Options, PawnId, TIME_STEP, WheelState};
pub use threads::{OneThread, Threads, in_parts};
pub use world::{
    Actor, ActorKind, Executed, LoadError, LostRobot, Report, Room, SaveError, SavedWorld, TILES, Tiles, World,
};
