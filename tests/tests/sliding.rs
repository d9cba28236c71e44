//! Robots on plain wheels beside the twist at which the friction of their wheels balances.

use experiments::{Course, Motion};
use sim_core::Options;

/// The share of the exact motion that a robot makes in some seconds, in steps of 2 ms.
fn ratio(class: &str, motion: Motion) -> f64 {
    let def = scene_loader::load("rough", &[]).unwrap_or_else(|error| panic!("{error}"));
    let course = Course::start(def, Options::default(), class, 1, motion, 1.0);
    let mut course = course.unwrap_or_else(|error| panic!("{error}"));
    course.run(5.0);
    course.travel().expect("a robot").ratio
}

/// Wheels that agree do not slide: straight on, with two wheels and a caster, and a car that steers by Ackermann's geometry.
#[test]
fn robots_whose_wheels_agree_move_as_their_wheels_say() {
    for (class, motion, tolerance) in [
        ("P3AT", Motion::Forward, 0.001),
        ("P2AT", Motion::Forward, 0.001),
        ("P2DX", Motion::Forward, 0.001),
        ("Kenaf", Motion::Forward, 0.002),
        ("FrontAckerman", Motion::Forward, 0.001),
        ("FrontAckerman", Motion::Curve, 0.003),
        ("CasterSkidRobot", Motion::Clockwise, 0.01),
        ("CasterSkidRobot", Motion::Curve, 0.01),
        ("P2DX", Motion::Clockwise, 0.02),
    ] {
        let ratio = ratio(class, motion);
        println!("{class} {}: {ratio:.4}", motion.name());
        assert!((ratio - 1.0).abs() < tolerance, "{class} {}: {ratio}", motion.name());
    }
}

/// The reference knows how far a robot turns that has to slide: without friction's balance a P3AT would turn by half as much again.
/// What is missing to it is the engine's (docs/kinematics.md).
#[test]
fn a_skid_robot_turns_about_as_far_as_friction_lets_it() {
    let ratio = ratio("P3AT", Motion::Clockwise);
    assert!((0.85..1.005).contains(&ratio), "{ratio}");
}
