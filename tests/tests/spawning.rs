//! Places of spawned robots: on the floor, beside other robots, out of solids, and on top of something only if that is requested.

use gamebots_proto::command::Command;
use nalgebra::Vector3;
use sim_core::{PawnId, World};
use system_tests::{command, init, run, world};

fn position(world: &World, robot: PawnId) -> Vector3<f64> {
    world.state(robot).expect("the robot is there").0.pose.translation.vector
}

/// Spawns a robot in a world. Returns it, and the messages about its place.
fn try_init(world: &mut World, line: &str) -> (Option<PawnId>, Vec<String>) {
    let Command::Init(init) = command(line) else { panic!("not INIT: {line}") };
    let mut problems = Vec::new();
    let robot = world.init(&init, &mut problems);
    (robot, problems.iter().map(ToString::to_string).collect())
}

#[test]
fn a_robot_at_a_start_that_is_taken_stands_beside_it_and_it_is_said() {
    for class in ["P3AT", "KUKA_YouBot", "YouBotArm", "Kenaf", "P2DX", "FrontAckerman"] {
        let mut world = world("rough", 0);
        let line = format!("INIT {{ClassName USARBot.{class}}} {{Name Ann}} {{Start PlayerStart_0}}");
        let first = init(&mut world, &line);
        run(&mut world, 1.0);
        let floor = position(&world, first).z;
        let (second, said) = try_init(&mut world, &line.replace("Ann", "Ben"));
        let second = second.expect("a robot");
        let expected = "{Start PlayerStart_0}: robot 0 `Ann` takes it; the robot is put beside it, at ";
        assert!(matches!(&said[..], [text] if text.starts_with(expected)), "{said:?}");
        run(&mut world, 1.0);
        let (one, other) = (position(&world, first), position(&world, second));
        assert!(one.xy().norm() < 0.01 && (other.z - floor).abs() < 0.002, "{class}: {one:?} {other:?}");
        assert!(((one - other).norm()) < 2.0, "{class}: {other:?} is not beside it");
    }
}

/// A whole class of students starts at one place: no robot stands on another, and all are close together.
#[test]
fn many_robots_at_one_start_stand_side_by_side() {
    for (class, count, widest) in [("P3AT", 100, 8.0), ("YouBot", 30, 6.0), ("AirRobot", 60, 8.0)] {
        let mut world = world("rough", 0);
        let robots: Vec<PawnId> = (0..count)
            .map(|_| try_init(&mut world, &format!("INIT {{ClassName USARBot.{class}}} {{Location 0,0,-1}}")).0)
            .map(|robot| robot.expect("a robot"))
            .collect();
        let places: Vec<Vector3<f64>> = robots.iter().map(|&robot| position(&world, robot)).collect();
        assert!(places.iter().all(|place| place.z == -1.0), "{places:?}");
        let far = places.iter().map(|place| place.xy().norm()).fold(0.0, f64::max);
        assert!(far < widest, "{class}: {far} m from the start");
        for _ in 0..500 {
            world.step();
        }
        let touching = robots
            .iter()
            .filter(|&&robot| (position(&world, robot).xy() - places[robot.0 as usize].xy()).norm() > 0.05);
        assert_eq!(touching.count(), 0, "{class}: some were pushed aside");
    }
}

#[test]
fn a_robot_is_put_out_of_a_solid_or_refused_with_the_reason() {
    // Class, map, place, message, and largest distance from the place; none if it is refused.
    for (class, map, place, expected, near) in [
        ("P3AT", "arena", "-3,2,-0.5", "the solid `pillar-2` takes it; the robot is put beside it", Some(1.0)),
        ("YouBotArm", "arena", "-3,2,0", "the solid `pillar-2` takes it; the robot is put beside it", Some(1.0)),
        ("P3AT", "arena", "-2.83,2.2,0", "the solid `pillar-2` takes it; the robot is put beside it", Some(1.0)),
        ("P3AT", "arena", "6.05,0,0", "the solid `wall-front` takes it; the robot is put beside it", Some(1.0)),
        ("P3AT", "arena", "6,0,-0.3", "the solid `wall-front` takes it; the robot is put beside it", Some(1.0)),
        ("P3AT", "hall", "-2,2.2,0", "the solid `pillar-2` takes it; the robot is put beside it", Some(1.0)),
        ("P3AT", "hall", "2.3,-0.9,0", "the object `crate-large` takes it; the robot is put beside it", Some(1.5)),
        ("P3AT", "rough", "1e6,0,0", "it is outside the map: got 1000000, expected -100000 to 100000 m", None),
        ("P3AT", "rough", "0,0,-2e5", "it is outside the map: got -200000, expected -100000 to 100000 m", None),
    ] {
        let mut world = world(map, 0);
        run(&mut world, 0.5);
        let line = format!("INIT {{ClassName USARBot.{class}}} {{Location {place}}}");
        let (robot, said) = try_init(&mut world, &line);
        assert!(matches!(&said[..], [text] if text.contains(expected)), "{line}: {said:?}");
        let Some(near) = near else {
            assert_eq!(robot, None, "{line}");
            continue;
        };
        let robot = robot.expect("a robot");
        let wanted: Vec<f64> = place.split(',').filter_map(|number| number.parse().ok()).collect();
        let put = position(&world, robot);
        assert!((put.xy() - Vector3::from_column_slice(&wanted).xy()).norm() < near, "{line}: at {put:?}");
        run(&mut world, 2.0);
        let before = position(&world, robot);
        run(&mut world, 1.0);
        let after = world.state(robot).expect("the robot is there").0;
        assert!((after.pose.translation.vector - before).norm() < 0.005, "{line}: {before:?} to {after:?}");
        assert!(
            (after.pose.translation.vector.xy() - put.xy()).norm() < 0.05,
            "{line}: it was thrown from {put:?} to {after:?}"
        );
    }
}

/// A free place is used as it is, without a message or a shift.
#[test]
fn a_robot_stands_on_a_ramp_a_step_and_a_platform_as_it_was_asked_for() {
    for (map, place) in [
        ("arena", "1.8,-3.5,0"),
        ("arena", "3.25,-3.5,0"),
        ("arena", "-4,-2,0"),
        ("arena", "-4.5,-2,0"),
        ("arena", "4.5,-1,0"),
        ("hall", "1.3,-3,0"),
        ("hall", "-3.5,2.5,0"),
        ("slope-4.5", "0.3,0.2,0"),
    ] {
        for class in ["P3AT", "KUKA_YouBot", "Kenaf", "P2DX"] {
            let mut world = world(map, 0);
            let (robot, said) =
                try_init(&mut world, &format!("INIT {{ClassName USARBot.{class}}} {{Location {place}}}"));
            let robot = robot.expect("a robot");
            assert_eq!(said, [""; 0], "{class} on {map} at {place}");
            let put = position(&world, robot);
            let mut fastest = 0.0f64;
            for _ in 0..250 {
                world.step();
                fastest = fastest.max(world.state(robot).expect("the robot is there").0.linear.norm());
            }
            assert!(fastest < 1.0, "{class} on {map} at {place}, put at {put:?}: {fastest} m/s");
        }
    }
}

#[test]
fn a_robot_that_is_asked_for_above_another_comes_to_stand_on_it() {
    let mut world = world("rough", 0);
    let low = init(&mut world, "INIT {ClassName USARBot.P3AT} {Location 0,0,0}");
    run(&mut world, 0.5);
    let (high, said) = try_init(&mut world, "INIT {ClassName USARBot.P3AT} {Location 0,0,-0.6}");
    assert_eq!(said, [""; 0]);
    run(&mut world, 1.0);
    let [low, high] = [low, high.expect("a robot")].map(|robot| position(&world, robot));
    assert!(high.z < low.z - 0.15 && (high.xy() - low.xy()).norm() < 0.1, "{low:?} {high:?}");
}

/// No robot is put behind a wall, on top of it, or off the platform of the start.
#[test]
fn beside_is_on_the_same_floor_and_on_the_same_side_of_a_wall() {
    let mut world = world("arena", 0);
    // The corridor is 1.2 m wide, between y = 3.8 and 5.
    for number in 0..12 {
        let (robot, said) = try_init(&mut world, "INIT {ClassName USARBot.P3AT} {Start RobotStart1}");
        assert_eq!(said.is_empty(), number == 0, "{said:?}");
        let place = position(&world, robot.expect("a robot"));
        let in_room = place.x.abs() < 6.0 && place.y < 5.0;
        let in_open = place.y > 3.8 || place.x < -3.5;
        assert!(in_room && in_open && place.z > -0.4, "number {number} is at {place:?}");
    }
}

/// A page can ask where a robot would stand, without any effect on the world.
#[test]
fn asking_for_room_changes_nothing() {
    let outcome = |asks: bool| {
        let mut world = world("hall", 0);
        let lines = [
            "INIT {ClassName USARBot.P3AT} {Start PlayerStart_0}",
            "INIT {ClassName USARBot.KUKA_YouBot} {Start RobotStart1}",
            "INIT {ClassName USARBot.YouBotArm} {Start RobotStart2}",
        ];
        for line in lines {
            let robot = init(&mut world, line);
            let _ = world.execute(Some(robot), &command("DRIVE {Left 3} {Right 3}"), &mut Vec::new());
        }
        for step in 0..1500 {
            world.step();
            if asks && step % 37 == 0 {
                let place = [f64::from(step % 9) - 4.0, f64::from(step % 7) - 3.0, 0.0];
                assert!(world.fit("Kenaf", place, [0.0; 3]).is_some());
            }
        }
        world.digest()
    };
    assert_eq!(outcome(false), outcome(true));
}

/// A closed mesh is a solid: nobody is put into it, also where it is thicker than a robot is high. Two slabs, one above the other.
#[test]
fn a_robot_that_is_wanted_in_a_closed_mesh_stands_on_it() {
    let corners = |z: f64| [[-9.0, -9.0, z], [9.0, -9.0, z], [9.0, 9.0, z], [-9.0, 9.0, z]];
    let slab = |name: &str, [top, bottom]: [f64; 2]| {
        let quads: [[u32; 4]; 6] = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];
        let shape = scene::Shape::Mesh {
            vertices: [corners(top), corners(bottom)].concat(),
            triangles: quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
        };
        let material = scene::Material::default();
        scene::Solid { name: name.to_owned(), shape, position: [0.0; 3], rotation: [0.0; 3], material }
    };
    let mut def = world("smooth", 0).def().clone();
    def.map.solids = vec![slab("ground", [0.0, 1.0]), slab("upper", [-4.0, -3.0])];
    let mut world = World::new(def, sim_core::Options::default());
    // Wheels reach 0.146 m below the frame. In the air it stays where it is.
    let (ground, upper) = (-0.147, -4.147);
    for (wanted, expected) in
        [(1.5, ground), (1.0, ground), (0.5, ground), (0.0, ground), (-1.0, -1.0), (-3.0, upper), (-3.5, upper)]
    {
        let pose = world.free_pose("P3AT", [3.0, 3.0, wanted], [0.0; 3]).expect("a free place");
        assert!((pose.translation.z - expected).abs() < 1e-3, "{wanted}: {}", pose.translation.z);
    }
    let (robot, said) = try_init(&mut world, "INIT {ClassName USARBot.P3AT} {Location 3,3,0.6}");
    run(&mut world, 1.0);
    let z = position(&world, robot.expect("a robot")).z;
    assert!((z + 0.145).abs() < 0.01 && said.is_empty(), "{z} {said:?}");
}
