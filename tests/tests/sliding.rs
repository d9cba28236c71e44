//! Robots on plain wheels, compared with the twist at which the friction of their wheels balances.

use std::f64::consts::TAU;

use experiments::{Course, Motion};
use kinematics::coulomb::{Contact, quasi_static};
use sim_core::{Options, World};
use system_tests::Server;

/// Returns the share of the exact motion that a robot makes, in steps of 2 ms.
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

/// Wheels that agree do not slide: straight ahead, with two wheels and a caster, and in a car with Ackermann steering.
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

/// Wheels that must slide follow Coulomb friction. Without its balance a P3AT would turn half as far again.
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

/// Returns the numbers of a block of a line, `{Key 1,2,3}`.
fn block(line: &str, key: &str) -> Option<Vec<f64>> {
    let (_, rest) = line.split_once(&format!("{{{key} "))?;
    rest.split_once('}')?.0.split(',').map(|number| number.parse().ok()).collect()
}

/// Returns the turn rate of a P3AT by its ground truth and its wheel speeds by its tachometer, rad/s, as a client reads them. Both come
/// from whole seconds of the same time.
fn turning(server: &Server, drive: &str) -> (f64, Vec<f64>) {
    const SPAN: [f64; 2] = [3.0, 9.0];
    let mut client = server.client();
    client.send("INIT {ClassName USARBot.P3AT} {Start PlayerStart_0}");
    client.send(&format!("DRIVE {drive}"));
    let (mut start, mut yaws, mut wheels) = (None, Vec::new(), Vec::new());
    loop {
        let line = client.line();
        let Some(time) = block(&line, "Time").map(|time| time[0]) else { continue };
        let age = time - *start.get_or_insert(time);
        if age > SPAN[1] {
            break;
        }
        if age < SPAN[0] {
            continue;
        }
        if line.contains("{Type GroundTruth}") {
            yaws.push((time, block(&line, "Orientation").expect("an orientation")[2]));
        } else if line.contains("{Type Tachometer}") {
            wheels.push((time, block(&line, "Pos").expect("angles")));
        }
    }
    let turned: f64 = yaws.windows(2).map(|pair| pair[1].1 - pair[0].1).map(|by| by - TAU * (by / TAU).round()).sum();
    let rate = turned / (yaws[yaws.len() - 1].0 - yaws[0].0);
    let ((from, first), (to, last)) = (&wheels[0], &wheels[wheels.len() - 1]);
    (rate, first.iter().zip(last).map(|(first, last)| (last - first) / (to - from)).collect())
}

/// A P3AT driven over a socket turns at the rate at which friction balances, computed from its wheel speeds.
#[test]
fn over_the_socket_a_p3at_turns_as_friction_lets_it() {
    // Half of its wheel base, half of its track and the wheels' radius, m; then the distance of its centre of mass ahead of its middle. The
    // latter follows from 10 of 11.9 kg at 12 mm (assets/robots/P3AT/robot.toml).
    let (base, track, radius, ahead) = (0.124, 0.18, 0.098, 0.12 / 11.9);
    let server = Server::start("rough", &[], |config| {
        config.real_time_factor = 10.0;
        let floors = config.world.map.solids.iter_mut().map(|solid| &mut solid.material);
        floors.for_each(|floor| floor.rolling_resistance = 0.0);
        let wheels = config.world.robots.values_mut().flat_map(|robot| robot.wheels_mut());
        wheels.for_each(|wheel| wheel.material.rolling_resistance = 0.0);
    });
    for (name, drive) in [
        ("on the spot", "{Left 2} {Right -2}"),
        ("slowly", "{Left 0.3} {Right -0.3}"),
        ("on a curve", "{Left 3} {Right 1.5}"),
        ("about one side", "{Left 2} {Right 0}"),
    ] {
        let (rate, wheels) = turning(&server, drive);
        let front = (1.0 + ahead / base) / 4.0;
        let contact = |(place, speed): ([f64; 2], &f64)| Contact {
            position: place,
            rolling: [radius * speed, 0.0],
            friction: if place[0] > 0.0 { front } else { 0.5 - front },
            along: None,
        };
        // Front right, front left, back right, back left.
        let places = [[base, track], [base, -track], [-base, track], [-base, -track]];
        let contacts: Vec<Contact> = places.into_iter().zip(&wheels).map(contact).collect();
        let ratio = rate / quasi_static(&contacts).clockwise;
        println!("{name}: {ratio:.4} of the balance of friction, wheels at {wheels:.3?} rad/s");
        assert!((ratio - 1.0).abs() < 0.005, "{name}: {ratio}");
    }
}
