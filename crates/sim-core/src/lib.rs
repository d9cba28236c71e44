//! A simulated world of robots: a deterministic function of a scene, a seed and commands by step.
//!
//! A [`World`] is made from plain definitions (the crate `scene`). It takes commands and returns reports. It uses no socket, clock, file,
//! environment variable or thread of its own. Time is the number of steps taken. The same scene, seed and commands by step move every
//! body with the same bits, on every platform and on any number of [`Threads`]. A copy of a world is independent and continues as the
//! original would.
//!
//! The world frame is that of the wire: x forward, y right, z down, right-handed. Units: metres, kilograms, seconds, radians.
//!
//! | type | content |
//! |---|---|
//! | [`CompiledScene`] | a scene prepared for worlds, which share it |
//! | [`World`] | the world: [`World::init`] spawns, [`World::order`] and [`World::execute`] drive, [`World::step`] advances, [`World::state`], [`World::joints`] and [`World::snapshot`] read |
//! | [`Order`] | speeds of wheels, a twist, steering angles, targets of joints, or a flight, in SI units |
//! | [`Executed`], [`Report`] | answers to a command of the wire, and what sensors and robots report after a step |
//! | [`SavedWorld`] | the state of a world as plain data, from [`World::save`] to [`World::load`] |
//! | [`Threads`], [`OneThread`] | the threads that steps run on, given by the caller |
//! | [`FreePlace`], [`LostRobot`], [`Fault`] | a free place for a robot; a robot whose state became invalid, and why |
//! | [`Actor`], [`Tiles`] | what referees and the image server ask for |
//!
//! # Example
//! The function `cart_on_a_plane` in `examples/cart/mod.rs` builds the scene, as the docs of the crate `scene` do. The example `lookahead`
//! drives the cart to a goal by copies of its world.
//!
//! ```
//! use gamebots_proto::command::Init;
//! use sim_core::{Options, Order, World};
//! # mod cart {
//! #     include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/cart/mod.rs"));
//! # }
//!
//! let mut world = World::new(cart::cart_on_a_plane(), Options::default());
//! let init = Init { class_name: "Cart".to_owned(), ..Init::default() };
//! let mut problems = Vec::new();
//! let cart = world.init(&init, &mut problems).ok_or("no free place")?;
//!
//! // Wheels of 0.1 m at 5 rad/s.
//! assert!(world.order(cart, &Order::Wheels(vec![Some(5.0); 4])));
//! while world.time() < 2.0 {
//!     world.step();
//! }
//! let (body, wheels) = world.state(cart).ok_or("the cart is gone")?;
//! assert!((body.linear.x - 0.5).abs() < 1e-3);
//! assert!((wheels[0].speed - 5.0).abs() < 1e-2);
//!
//! // A copy turns, and the original drives on.
//! let mut copy = world.clone();
//! copy.order(cart, &Order::Wheels([5.0, -5.0, 5.0, -5.0].map(Some).into()));
//! (0..500).for_each(|_| drop((world.step(), copy.step())));
//! let yaw = |world: &World| world.state(cart).map(|(body, _)| body.pose.rotation.euler_angles().2);
//! assert!(yaw(&world).is_some_and(|yaw| yaw.abs() < 1e-3));
//! assert!(yaw(&copy).is_some_and(|yaw| yaw > 0.1));
//! # Ok::<(), &str>(())
//! ```

mod compiled;
mod drive;
mod flight;
mod kinds;
mod physics;
mod sensor;
mod site;
mod threads;
mod world;

pub use compiled::CompiledScene;
pub use drive::Order;
pub use flight::Flight;
pub use physics::{Fault, SolverEffort};
pub use scene::{BodyState, ObjectId, Options, PawnId, TIME_STEP, WheelState};
pub use threads::{OneThread, Threads, in_parts};
pub use world::{
    Actor, ActorKind, Executed, FreePlace, LoadError, LostRobot, Report, SaveError, SavedWorld, TILES, Tiles, World,
};

/// The examples of the README, as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
