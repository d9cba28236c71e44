//! Robots move as their wheels drive them.

use sim_core::{Options, PawnId, World};
use system_tests::{Server, apply, init, run, scene_with_test_robot, world};

/// Returns position, yaw and wheel angles of a robot.
fn place(world: &World, robot: PawnId) -> ([f64; 3], f64, Vec<f64>) {
    let (body, wheels) = world.state(robot).expect("the robot is in the world");
    let (_, _, yaw) = body.pose.rotation.euler_angles();
    (body.pose.translation.vector.into(), yaw, wheels.iter().map(|wheel| wheel.angle).collect())
}

/// Returns forward, right and clockwise displacement in the start frame over `seconds` after one second of spin-up.
fn drive(map: &str, class: &str, line: &str, seconds: f64) -> [f64; 3] {
    drive_in(world(map, 1), class, line, seconds)
}

/// Does as [`drive`] without rolling resistance, so only slip matters.
fn drive_rolling_freely(map: &str, class: &str, line: &str, seconds: f64) -> [f64; 3] {
    let free = ["carpet", "cast-acrylic", "rubber-tyre"]
        .map(|material| format!("material.{material}.rolling_resistance=0").parse().expect("an override"));
    let def = scene_loader::load_with(map, &[], &free).unwrap_or_else(|error| panic!("{error}"));
    drive_in(World::new(def, Options::default()), class, line, seconds)
}

fn drive_in(mut world: World, class: &str, line: &str, seconds: f64) -> [f64; 3] {
    let map = world.def().map.name.clone();
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

/// Returns the displacements of a youBot in ten seconds at a commanded 1 rad/s: forward and to the right (m), and clockwise (rad).
/// `resistance` is the floor's coefficient of rolling resistance. Its speed servos settle below the command by the droop: the torque on a
/// wheel over their gain of 4 N m s/rad. The torque is a quarter of the resistance times the travel of the hubs per radian.
fn youbot_ways(resistance: f64) -> [f64; 3] {
    // The exact kinematics of six rollers. In a turn the hubs move by their distance from the middle.
    let ways = [0.05, 0.05 * 0.9549, 0.05 / 0.3855 * 0.9716];
    let hubs = [ways[0], ways[1], ways[2] * 0.2355f64.hypot(0.15)];
    std::array::from_fn(|motion| 10.0 * ways[motion] * (1.0 - resistance * 20.0 * 9.81 * hubs[motion] / 4.0 / 4.0))
}

#[test]
fn the_youbot_drives_straight_strafes_and_turns_on_every_kind_of_floor() {
    for (map, resistance) in [("rough", 0.03), ("smooth", 0.005)] {
        let expected = youbot_ways(resistance);
        let forward = drive(map, "KUKA_YouBot", "DRIVE {Left 1}{Right 1}", 10.0);
        assert_near(forward[0], expected[0], 0.005);
        assert!(forward[1].abs() < 0.01 && forward[2].abs() < 0.02, "{forward:?}");
        let right = drive(map, "KUKA_YouBot", "DRIVE {Front-Left 1}{Front-Right -1}{Back-Left -1}{Back-Right 1}", 10.0);
        assert_near(right[1], expected[1], 0.01);
        assert!(right[0].abs() < 0.01 && right[2].abs() < 0.087, "{right:?}");
        let turn = drive(map, "KUKA_YouBot", "DRIVE {Left 1}{Right -1}", 10.0);
        assert_near(turn[2], expected[2], 0.01);
    }
}

#[test]
fn a_robot_at_rest_stays_where_it_is_and_its_wheels_too() {
    for class in ["KUKA_YouBot", "P3AT", "P2DX"] {
        let mut world = world("rough", 1);
        let robot = init(&mut world, &format!("INIT {{ClassName USARBot.{class}}} {{Start RobotStart1}}"));
        run(&mut world, 2.0);
        let (from, _, wheels_from) = place(&world, robot);
        run(&mut world, 20.0);
        let (to, _, wheels_to) = place(&world, robot);
        let moved = (to[0] - from[0]).hypot(to[1] - from[1]);
        let turned = wheels_to.iter().zip(wheels_from).map(|(to, from)| (to - from).abs()).fold(0.0, f64::max);
        println!("{class} at rest: moved {:.2} mm, wheels {turned:.4} rad in 20 s", 1e3 * moved);
        assert!(moved < 0.003 && turned < 0.06, "{class} moved {moved:.4} m, its wheels {turned:.4} rad");
    }
}

/// Robots that are as heavy on their left as on their right and carry nothing that touches the floor first, one of each kind.
const SYMMETRIC: [&str; 9] =
    ["AirRobot", "CasterSkidRobot", "FrontAckerman", "KUKA_YouBot", "P2AT", "P2DX", "P3AT", "YouBot", "YouBotArm"];

/// Lets a symmetric robot fall flat onto the floor. It keeps its heading.
#[track_caller]
fn check_lands_straight(class: &str, model: &str, height: f64, heading: f64) {
    let model = format!("{class}.drive_model=\"{model}\"").parse().expect("an override");
    let def = scene_loader::load_with("rough", &[], &[model]).unwrap_or_else(|error| panic!("{error}"));
    let mut world = World::new(def, Options::default());
    let start = format!("{{Location 1,2,-{height}}} {{Rotation 0,0,{heading}}}");
    let robot = init(&mut world, &format!("INIT {{ClassName USARBot.{class}}} {start}"));
    run(&mut world, 3.0);
    let ([x, y, _], yaw, _) = place(&world, robot);
    let (turned, moved) = (yaw - heading, (x - 1.0).hypot(y - 2.0));
    println!("{class} from {height} m at {heading} rad: turned {turned:+.6} rad, moved {:.3} mm", 1e3 * moved);
    assert!(turned.abs() < 1e-3 && moved < 2e-3, "{class} from {height} m at {heading} rad: {turned} rad, {moved} m");
}

#[test]
fn a_robot_that_falls_flat_lands_straight() {
    for (height, heading) in [(0.4, 0.0), (0.4, 0.7), (1.0, 0.0), (1.0, 0.7), (2.0, -2.2)] {
        for class in SYMMETRIC {
            check_lands_straight(class, "bodies", height, heading);
        }
        check_lands_straight("KUKA_YouBot", "analytic", height, heading);
        check_lands_straight("Kenaf", "articulated", height, heading);
    }
}

/// The ground's push on a wheel at landing does not brake the wheel after the robot comes to rest elsewhere.
#[test]
fn on_a_slope_a_robot_that_fell_sets_out_like_one_that_was_put_there() {
    let set_out = |z: &str| {
        let mut world = world("slope-4.5", 1);
        let robot = init(&mut world, &format!("INIT {{ClassName USARBot.CasterSkidRobot}} {{Location 4,0,{z}}}"));
        run(&mut world, 1.5);
        let (from, ..) = place(&world, robot);
        apply(&mut world, robot, "DRIVE {Left 1}{Right 1}");
        run(&mut world, 0.2);
        let (to, ..) = place(&world, robot);
        (to[0] - from[0]).hypot(to[2] - from[2])
    };
    let (put, fell) = (set_out("0"), set_out("-0.6"));
    println!("put there {put:.6} m, fallen {fell:.6} m");
    assert_near(fell, put, 0.01);
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
        let got = drive_rolling_freely("rough", class, "DRIVE {Left 1}{Right -1}", 2.0);
        assert_near(got[2], 4.0 * radius / track, 0.01);
    }
}

/// Four wheels slide. The wheels are lx ahead of and ly beside the middle. Coulomb friction then balances the moments at a yaw rate of r
/// omega / (ly + lx² / ly), for any friction. The centre of mass is in the middle: a BasicSkidRobot's gripper would move it.
#[test]
fn robots_with_four_wheels_turn_as_coulomb_friction_says() {
    for (class, radius, lx, ly) in
        [("P3AT", 0.098, 0.124, 0.18), ("P2AT", 0.1075, 0.13, 0.195), ("Zerg", 0.06, 0.08, 0.13)]
    {
        for map in ["rough", "smooth"] {
            let got = drive_rolling_freely(map, class, "DRIVE {Left 1}{Right -1}", 2.0);
            assert_near(got[2], 2.0 * radius / (ly + lx * lx / ly), 0.15);
        }
    }
}

/// Returns the displacement between two ground truths ten simulated seconds apart, after spin-up, over a real socket.
fn drive_over_the_socket(class: &str, line: &str) -> [f64; 3] {
    let server = Server::start("rough", &[], |config| config.real_time_factor = 3.0);
    let mut peer = server.client();
    peer.send(&format!("INIT {{ClassName USARBot.{class}}} {{Name R1}} {{Start PlayerStart_0}}"));
    peer.lines_for(1.0);
    peer.send(line);
    peer.lines_for(1.0);
    let (from, from_angles) = peer.ground_truth();
    // The readings just before and after the window's end are 0.1 s apart: 99 are skipped, the next counts.
    for _ in 0..99 {
        peer.next_of("GroundTruth");
    }
    let (to, to_angles) = peer.ground_truth();
    let got = [to[0] - from[0], to[1] - from[1], to_angles[2] - from_angles[2]];
    println!("socket {class} {line}: {got:.3?}");
    got
}

/// The thesis's command: 1 rad/s for ten seconds.
#[test]
fn over_the_socket_the_youbot_goes_where_a_finite_roller_wheel_goes() {
    let expected = youbot_ways(0.03);
    let forward = drive_over_the_socket(
        "KUKA_YouBot",
        "DRIVE {Front-Left 1,00}{Front-Right 1,00}{Back-Left 1,00}{Back-Right 1,00}",
    );
    assert_near(forward[0], expected[0], 0.005);
    assert!(forward[2].abs() < 5f64.to_radians(), "{forward:?}");
    let right = drive_over_the_socket(
        "KUKA_YouBot",
        "DRIVE {Front-Left 1,00}{Front-Right -1,00}{Back-Left -1,00}{Back-Right 1,00}",
    );
    assert_near(right[1], expected[1], 0.01);
    assert!(right[2].abs() < 5f64.to_radians(), "{right:?}");
    let turn = drive_over_the_socket(
        "KUKA_YouBot",
        "DRIVE {Front-Left 1,00}{Front-Right -1,00}{Back-Left 1,00}{Back-Right -1,00}",
    );
    assert_near(turn[2], expected[2], 0.01);
}

#[test]
fn over_the_socket_the_p3at_goes_by_wheel_speed_times_radius() {
    let got = drive_over_the_socket("P3AT", "DRIVE {Left 3.000000} {Right 3.000000}");
    assert_near(got[0], 10.0 * 3.0 * 0.098, 0.02);
}

/// Case 104: sensors and answers end with the battery, and the wheels turn on as they were told last.
#[test]
fn wheels_turn_on_when_the_battery_is_flat() {
    let mut world = World::new(scene_with_test_robot("ShortLife"), Options::default());
    let robot = init(&mut world, "INIT {ClassName USARBot.ShortLife} {Location 0,0,0}");
    apply(&mut world, robot, "DRIVE {Left 1} {Right 1}");
    run(&mut world, 5.0);
    assert_eq!(world.battery(robot), Some(0));
    let (from, _, wheels) = place(&world, robot);
    apply(&mut world, robot, "DRIVE {Left 0} {Right 0}");
    run(&mut world, 2.0);
    let (to, _, turned) = place(&world, robot);
    assert!(turned.iter().zip(wheels).all(|(to, from)| (to - from - 2.0).abs() < 0.05), "{turned:?}");
    assert!((to[0] - from[0] - 2.0 * 0.098).abs() < 0.01, "{to:?}");
}
