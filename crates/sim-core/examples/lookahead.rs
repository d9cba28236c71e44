//! Drives a cart to a goal by looking ahead: copies of the world try orders, and the best one is given to the original.

mod cart;

use gamebots_proto::command::Init;
use sim_core::{Options, Order, PawnId, World};

/// Place of the goal on the plane, m.
const GOAL: [f64; 2] = [2.0, 1.5];
/// Distance at which the cart has arrived, m.
const NEAR: f64 = 0.1;
/// Time that a copy looks ahead, and time between two choices, s.
const HORIZON: f64 = 1.0;
const PERIOD: f64 = 0.2;
/// Wheel speeds that the copies try on each side, rad/s.
const SPEEDS: [f64; 3] = [-4.0, 0.0, 8.0];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let time = drive()?;
    println!("arrived after {time:.1} s");
    Ok(())
}

/// Drives the cart to the goal. Returns the simulated time, s.
fn drive() -> Result<f64, Box<dyn std::error::Error>> {
    let scene = cart::cart_on_a_plane();
    scene.check()?;
    let mut world = World::new(scene, Options::default());
    let mut problems = Vec::new();
    let init = Init { class_name: "Cart".to_owned(), ..Init::default() };
    let cart = world.init(&init, &mut problems).ok_or_else(|| format!("no cart: {problems:?}"))?;
    while distance(&world, cart) > NEAR {
        if world.time() > 60.0 {
            return Err("the cart did not arrive within a minute".into());
        }
        let order = best_order(&world, cart);
        world.order(cart, &order);
        run(&mut world, PERIOD);
    }
    Ok(world.time())
}

/// Finds the order after which a copy of the world is nearest to the goal.
fn best_order(world: &World, cart: PawnId) -> Order {
    let orders = SPEEDS.iter().flat_map(|&left| SPEEDS.map(|right| wheels(left, right)));
    let distance_after = |order: &Order| {
        let mut copy = world.clone();
        copy.order(cart, order);
        run(&mut copy, HORIZON);
        distance(&copy, cart)
    };
    let tried = orders.map(|order| (distance_after(&order), order));
    tried.min_by(|(one, _), (other, _)| one.total_cmp(other)).map_or_else(|| wheels(0.0, 0.0), |(_, order)| order)
}

/// Returns the order for the wheels of each side, in the robot's order: left and right by turns.
fn wheels(left: f64, right: f64) -> Order {
    Order::Wheels([left, right, left, right].map(Some).into())
}

fn run(world: &mut World, seconds: f64) {
    let end = world.time() + seconds;
    while world.time() < end {
        world.step();
    }
}

/// Returns the distance of the cart from the goal, m; infinite if the cart is gone.
fn distance(world: &World, cart: PawnId) -> f64 {
    let [x, y] = GOAL;
    world
        .state(cart)
        .map_or(f64::INFINITY, |(body, _)| (body.pose.translation.x - x).hypot(body.pose.translation.y - y))
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_cart_arrives() {
        assert!(super::drive().is_ok_and(|time| time < 30.0));
    }
}
