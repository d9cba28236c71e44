//! The simulated world.
//!
//! A [`World`] is made of plain definitions ([`scene`]) and a seed, takes commands and gives messages. It knows
//! no socket, clock, file, environment or thread: time is the number of steps taken, and the same scene, seed
//! and commands by step give the same bits, on however many [`Threads`] it is given.
//!
//! World frame = the wire's: x forward, y right, z down, right-handed; metres, kilograms, seconds, radians.

mod compiled;
pub mod drive;
mod flight;
pub mod mecanum;
mod physics;
mod sensor;
mod sliding;
mod threads;
mod world;

pub use compiled::CompiledScene;
pub use physics::Fault;
pub use scene::{BodyState, Options, RobotId, TIME_STEP, WheelState};
pub use threads::{OneThread, Threads};
pub use world::{Executed, LostRobot, Room, World};
