//! Robots go where their wheels take them.

use sim_core::{RobotId, World};
use system_tests::{apply, init, run, world};

/// Position, yaw and wheel angles of a robot.
fn place(world: &World, robot: RobotId) -> ([f64; 3], f64, Vec<f64>) {
    let (body, wheels) = world.state(robot).expect("the robot is in the world");
    let (_, _, yaw) = body.pose.rotation.euler_angles();
    (body.pose.translation.vector.into(), yaw, wheels.iter().map(|wheel| wheel.angle).collect())
}

/// Forward, right and clockwise displacement in the start frame over `seconds` after one second of spin-up.
fn drive(map: &str, class: &str, line: &str, seconds: f64) -> [f64; 3] {
    let mut world = world(map, 1);
    let robot = init(&mut world, &format!("INIT {{ClassName USARBot.{class}}} {{Start PlayerStart_0}}"));
    run(&mut world, 1.0);
    apply(&mut world, robot, line);
    run(&mut world, 1.0);
    let (from, yaw_from, wheels_from) = place(&world, robot);
    run(&mut world, seconds);
    let (to, yaw_to, wheels_to) = place(&world, robot);
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    let turned: Vec<f64> = wheels_to.iter().zip(wheels_from).map(|(to, from)| to - from).collect();
    let got = [dx * yaw_from.cos() + dy * yaw_from.sin(), dy * yaw_from.cos() - dx * yaw_from.sin(), yaw_to - yaw_from];
    println!("{map} {class} {line}: {got:.4?} rise {:.5} wheels {turned:.3?}", from[2] - to[2]);
    got
}

#[track_caller]
fn assert_near(got: f64, expected: f64, part: f64) {
    assert!((got - expected).abs() <= part * expected.abs(), "got {got:.4}, expected {expected:.4} within {part}");
}

#[test]
fn the_youbot_drives_straight_strafes_and_turns_on_every_kind_of_floor() {
    for map in ["rough", "smooth"] {
        let forward = drive(map, "KUKA_YouBot", "DRIVE {Left 1}{Right 1}", 10.0);
        assert_near(forward[0], 0.5, 0.03);
        assert!(forward[1].abs() < 0.01 && forward[2].abs() < 0.02, "{forward:?}");
        let right = drive(map, "KUKA_YouBot", "DRIVE {Front-Left 1}{Front-Right -1}{Back-Left -1}{Back-Right 1}", 10.0);
        assert_near(right[1], 0.477, 0.08);
        assert!(right[0].abs() < 0.01 && right[2].abs() < 0.087, "{right:?}");
        let turn = drive(map, "KUKA_YouBot", "DRIVE {Left 1}{Right -1}", 10.0);
        assert_near(turn[2], 1.26, 0.08);
    }
}

#[test]
fn skid_robots_go_straight_by_wheel_speed_times_radius() {
    for (class, radius) in
        [("P3AT", 0.098), ("P2AT", 0.1075), ("P2DX", 0.0825), ("BasicSkidRobot", 0.128), ("CasterSkidRobot", 0.128)]
    {
        for map in ["rough", "smooth"] {
            let got = drive(map, class, "DRIVE {Left 2}{Right 2}", 5.0);
            assert_near(got[0], 10.0 * radius, 0.01);
            assert!(got[1].abs() < 0.01 && got[2].abs() < 0.01, "{class} drifts: {got:?}");
        }
    }
}

/// Two driven wheels turn without slip: yaw rate = 2 r omega / track.
#[test]
fn robots_with_a_caster_turn_as_their_kinematics_say() {
    for (class, radius, track) in [("P2DX", 0.0825, 0.33), ("CasterSkidRobot", 0.128, 1.152)] {
        let got = drive("rough", class, "DRIVE {Left 1}{Right -1}", 2.0);
        assert_near(got[2], 4.0 * radius / track, 0.01);
    }
}

/// Four wheels slide: with lx ahead and ly beside of the middle, Coulomb friction balances the moments at a yaw
/// rate of r omega / (ly + lx² / ly), whatever the friction.
#[test]
fn robots_with_four_wheels_turn_as_coulomb_friction_says() {
    for (class, radius, lx, ly) in
        [("P3AT", 0.098, 0.124, 0.18), ("P2AT", 0.1075, 0.13, 0.195), ("BasicSkidRobot", 0.128, 0.3, 0.576)]
    {
        for map in ["rough", "smooth"] {
            let got = drive(map, class, "DRIVE {Left 1}{Right -1}", 2.0);
            assert_near(got[2], 2.0 * radius / (ly + lx * lx / ly), 0.15);
        }
    }
}
