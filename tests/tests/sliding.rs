//! Robots on plain wheels beside the twist at which the friction of their wheels balances.

use experiments::{Course, Motion};
use sim_core::{Options, World};

/// The share of the exact motion that a robot makes in some seconds, in steps of 2 ms.
fn ratio(class: &str, motion: Motion) -> f64 {
    ratio_at(class, motion, 0.002)
}

fn ratio_at(class: &str, motion: Motion, time_step: f64) -> f64 {
    let def = scene_loader::load("rough", &[]).unwrap_or_else(|error| panic!("{error}"));
    let course = Course::start(World::new(def, Options { time_step, ..Options::default() }), class, 1, motion, 1.0);
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
        ("Kenaf", Motion::Forward, 0.001),
        ("FrontAckerman", Motion::Forward, 0.001),
        ("FrontAckerman", Motion::Curve, 0.001),
        ("CasterSkidRobot", Motion::Clockwise, 0.001),
        ("CasterSkidRobot", Motion::Curve, 0.001),
        ("P2DX", Motion::Clockwise, 0.001),
    ] {
        let ratio = ratio(class, motion);
        println!("{class} {}: {ratio:.4}", motion.name());
        assert!((ratio - 1.0).abs() < tolerance, "{class} {}: {ratio}", motion.name());
    }
}

/// Wheels that have to slide do so as Coulomb's friction says: without its balance a P3AT would turn by half as much again.
#[test]
fn robots_whose_wheels_slide_go_as_far_as_friction_lets_them() {
    for class in ["P3AT", "P2AT", "Kenaf", "BasicSkidRobot"] {
        for motion in [Motion::Clockwise, Motion::Curve] {
            for time_step in [0.002, 0.008, 0.016] {
                let ratio = ratio_at(class, motion, time_step);
                println!("{class} {} at {time_step} s: {ratio:.5}", motion.name());
                assert!((ratio - 1.0).abs() < 0.001, "{class} {} at {time_step} s: {ratio}", motion.name());
            }
        }
    }
}
