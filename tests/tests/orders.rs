//! Orders move robots as the lines do that say the same.

use kinematics::Twist;
use scene::Side;
use sim_core::{Flight, Order};
use system_tests::{apply, init, world};

/// Compares a world whose robot gets a line with one whose robot gets orders, bit by bit.
#[track_caller]
fn check(class: &str, line: &str, orders: &[Order]) {
    let init_line = format!("INIT {{ClassName {class}}} {{Location 0,0,-0.3}}");
    let [mut by_line, mut by_order] = [world("rough", 0), world("rough", 0)];
    let [one, other] = [init(&mut by_line, &init_line), init(&mut by_order, &init_line)];
    apply(&mut by_line, one, line);
    for order in orders {
        assert!(by_order.order(other, order), "{class}: {order:?}");
    }
    let start = by_line.digest();
    for step in 0..250 {
        by_line.step();
        by_order.step();
        assert_eq!(by_line.digest(), by_order.digest(), "{class}, {line}: step {step}");
    }
    assert_ne!(by_line.digest(), start);
    let moved = by_line.observe(one).expect("a robot");
    let is_moving = moved.body.linear.norm() > 0.01 || moved.joints.iter().any(|joint| joint.speed.abs() > 0.01);
    assert!(is_moving, "{class}: {line} moves nothing");
}

fn sides(class: &str, left: f64, right: f64) -> Order {
    let robot = scene_loader::robot(class, &[]).expect("a built-in robot");
    Order::Wheels(robot.driven().map(|wheel| Some(if wheel.side == Side::Left { left } else { right })).collect())
}

/// Returns the speeds of a car's wheels in a bend, whose mean is given.
fn in_a_bend(class: &str, speed: f64, steer: [f64; 2]) -> Vec<Option<f64>> {
    let robot = scene_loader::robot(class, &[]).expect("a built-in robot");
    base_motion::speed_shares(&robot, steer).into_iter().map(|share| Some(share * speed)).collect()
}

fn joint(class: &str, name: &str, target: f64) -> Order {
    let robot = scene_loader::robot(class, &[]).expect("a built-in robot");
    let number = robot.with_values().position(|link| link.name == name).expect("a joint");
    Order::Joints(vec![(number, target)])
}

fn twist(forward: f64, right: f64, clockwise: f64) -> Order {
    Order::Twist(Twist { forward, right, clockwise })
}

fn flight(velocity: [f64; 3], turn: f64) -> Order {
    // Flying ahead leans the robot by its greatest angle.
    Order::Flight(Flight { velocity, turn, attitude: [0.0; 2] })
}

#[test]
fn orders_and_lines_give_the_same_bits() {
    check("P3AT", "DRIVE {Left 3} {Right 2}", &[sides("P3AT", 3.0, 2.0)]);
    check("P3AT", "DRIVE {Left 1000} {Right -1000}", &[sides("P3AT", 1e3, -1e3)]);
    check("YouBot", "DRIVE {Front-Left 2}", &[Order::Wheels(vec![Some(2.0), None, None, None])]);
    check("YouBot", "DRIVE {LinearVelocity 0.2} {RotationalVelocity 0.5}", &[twist(0.2, 0.0, 0.5)]);
    check(
        "YouBot",
        "DRIVE {LateralVelocity 0.2} {Front-Left 1}",
        &[twist(0.0, 0.2, 0.0), Order::Wheels(vec![Some(1.0), None, None, None])],
    );
    check(
        "FrontAckerman",
        "DRIVE {Speed 3} {FrontSteer 0.3} {RearSteer 0}",
        &[Order::Steer([0.3, 0.0]), Order::Wheels(in_a_bend("FrontAckerman", 3.0, [0.3, 0.0]))],
    );
    check(
        "AirRobot",
        "DRIVE {AltitudeVelocity 0.5} {RotationalVelocity 90}",
        &[flight([0.0, 0.0, 0.5], 90f64.to_radians())],
    );
    check("YouBotArm", "ACT {Name Arm} {Link 0} {Value 0.5}", &[joint("YouBotArm", "ArmJoint1", 0.5)]);
}

#[test]
fn an_order_that_a_robot_cannot_follow_changes_nothing() {
    let mut world = world("rough", 0);
    let robot = init(&mut world, "INIT {ClassName P3AT}");
    let mut unmoved = world.clone();
    for order in [
        twist(1.0, 0.0, 0.0),
        Order::Steer([0.1; 2]),
        flight([1.0; 3], 0.0),
        Order::Wheels(vec![Some(f64::NAN); 4]),
        Order::Joints(vec![(0, f64::INFINITY)]),
        // A wheel, and a joint that the robot does not have.
        Order::Joints(vec![(0, 1.0)]),
        Order::Joints(vec![(4, 1.0)]),
    ] {
        assert!(!world.order(robot, &order), "{order:?}");
    }
    assert!(!world.order(sim_core::PawnId(7), &Order::Wheels(vec![Some(1.0); 4])), "nobody");
    for _ in 0..100 {
        world.step();
        unmoved.step();
    }
    assert_eq!(world.digest(), unmoved.digest());
}
