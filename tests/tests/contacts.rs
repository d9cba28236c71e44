//! Robots in contact in many ways: falling robots come to rest on the surface below, and no energy is gained.

use nalgebra::Vector3;
use scene::{BodyState, DriveModel, PawnId};
use sim_core::{Options, World};
use system_tests::{apply, init, run};

/// Builds a world with robots, each given by class, location and rotation.
fn world_with(map: &str, time_step: f64, robots: &[(&str, [f64; 3], [f64; 3])]) -> (World, Vec<PawnId>) {
    let def = scene_loader::load(map, &[]).unwrap_or_else(|error| panic!("{error}"));
    let mut world = World::new(def, Options { time_step, ..Options::default() });
    let line = |(class, [x, y, z], [roll, pitch, yaw]): &(&str, [f64; 3], [f64; 3])| {
        format!("INIT {{ClassName USARBot.{class}}} {{Location {x},{y},{z}}} {{Rotation {roll},{pitch},{yaw}}}")
    };
    let robots = robots.iter().map(|robot| init(&mut world, &line(robot))).collect();
    (world, robots)
}

fn body(world: &World, robot: PawnId) -> BodyState {
    world.state(robot).expect("the robot is there").0
}

fn place(world: &World, robot: PawnId) -> Vector3<f64> {
    body(world, robot).pose.translation.vector
}

fn fastest(world: &World, robots: &[PawnId]) -> f64 {
    robots.iter().map(|&robot| body(world, robot).linear.norm()).fold(0.0, f64::max)
}

/// Limits for robots at rest: speed, m/s, and motion in a second, m.
const STILL: [f64; 2] = [1e-4, 1e-5];

/// Lets robots fall for some seconds and checks that they lie still on the surface below. The limits are the largest speed, m/s, and the
/// largest motion in the next second, m.
#[track_caller]
fn check_rests(robots: &[(&str, [f64; 3], [f64; 3])], seconds: f64, [most_speed, most_way]: [f64; 2]) {
    for time_step in [0.002, 0.008] {
        let (mut world, ids) = world_with("rough", time_step, robots);
        run(&mut world, seconds);
        let before: Vec<Vector3<f64>> = ids.iter().map(|id| place(&world, *id)).collect();
        run(&mut world, 1.0);
        let speed = fastest(&world, &ids);
        let moved = ids.iter().zip(&before).map(|(id, before)| (place(&world, *id) - before).norm());
        let moved = moved.fold(0.0, f64::max);
        let lowest = before.iter().map(|place| place.z).fold(f64::NEG_INFINITY, f64::max);
        let unsettled = world.unsettled_steps();
        println!(
            "{robots:?} at {time_step} s: {speed:.1e} m/s, {moved:.1e} m, lowest {lowest:.3}, {unsettled} unsettled"
        );
        assert!(speed < most_speed && moved < most_way, "{robots:?} at {time_step} s: {speed} m/s, moved {moved} m");
        // Limits on unsettled steps: one in 500 for a single robot. Steps of a heap have a budget of work, so it may have one in 100, and
        // of Kenafs one in four. Measured for six Kenafs: 238 of 1125; for six P3ATs or YouBots: at most 4.
        let share = match robots {
            [_] => 500.0,
            [("Kenaf", ..), ..] => 4.0,
            _ => 100.0,
        };
        assert!(unsettled as f64 * share < (seconds + 1.0) / time_step, "{robots:?} at {time_step} s: {unsettled}");
        assert!(lowest < 0.01, "{robots:?} at {time_step} s: one sank to {lowest} m");
    }
}

#[test]
fn what_falls_comes_to_rest() {
    for class in ["P3AT", "P2DX", "Kenaf", "YouBot", "YouBotArm", "CasterSkidRobot", "BasicAckermanRobot"] {
        for rotation in [[0.0; 3], [3.1, 0.0, 0.0], [1.5, 0.0, 0.0], [0.3, 1.2, 0.0]] {
            check_rests(&[(class, [0.0, 0.0, -0.8], rotation)], 12.0, STILL);
        }
    }
}
/// Six robots in a heap, and one on another.
#[test]
fn a_heap_comes_to_rest() {
    for class in ["P3AT", "YouBot", "Kenaf"] {
        let at = |number: u32| {
            let number = f64::from(number);
            (class, [0.05 * number, 0.03 * (number * 2.0).sin(), -0.4 - 0.45 * number], [0.4 * number, 0.3, number])
        };
        check_rests(&(0..6).map(at).collect::<Vec<_>>(), 8.0, [0.2, 0.02]);
    }
    let stack = |number: u32| ("YouBot", [0.0, 0.0, -0.3 * f64::from(number)], [0.0; 3]);
    check_rests(&(0..6).map(stack).collect::<Vec<_>>(), 2.0, STILL);
}

/// A robot that drives into a row of others pushes them with the force of its wheels, and all move at one speed.
#[test]
fn a_robot_pushes_a_row() {
    let row: Vec<_> = (0..3).map(|number| ("P3AT", [0.62 * f64::from(number), 0.0, 0.0], [0.0; 3])).collect();
    for order in [[0, 1, 2], [2, 1, 0], [1, 2, 0]] {
        let (mut world, ids) = world_with("rough", 0.004, &order.map(|number| row[number]));
        let pusher = ids[order.iter().position(|&number| number == 0).expect("a first")];
        run(&mut world, 0.5);
        // The others roll along slowly; the pusher's target is faster.
        for &id in &ids {
            apply(&mut world, id, if id == pusher { "DRIVE {Left 4} {Right 4}" } else { "DRIVE {Left 2} {Right 2}" });
        }
        run(&mut world, 5.0);
        let speeds: Vec<f64> = ids.iter().map(|id| body(&world, *id).linear.x).collect();
        let unsettled = world.unsettled_steps();
        println!("{order:?}: {speeds:.4?} m/s, {unsettled} unsettled");
        assert!(speeds.iter().all(|speed| (speed - speeds[0]).abs() < 1e-3), "{order:?}: {speeds:?}");
        assert!(speeds[0] > 0.19, "{order:?}: {speeds:?}");
    }
}

/// Wheels cross gaps of 2 to 20 mm in the floor.
#[test]
fn wheels_pass_a_gap() {
    for gap in [0.002, 0.005, 0.02] {
        for class in ["P3AT", "YouBot"] {
            let mut def = scene_loader::load("rough", &[]).unwrap_or_else(|error| panic!("{error}"));
            let floor = def.map.solids[0].clone();
            let slab = |from: f64, to: f64| {
                let shape = scene::Shape::Box { size: [to - from, 4.0, 0.1] };
                scene::Solid { shape, position: [(from + to) / 2.0, 0.0, 0.05], ..floor.clone() }
            };
            def.map.solids = vec![slab(-2.0, 0.5), slab(0.5 + gap, 4.0)];
            let mut world = World::new(def, Options { time_step: 0.004, ..Options::default() });
            let id = init(&mut world, &format!("INIT {{ClassName USARBot.{class}}} {{Location 0,0,0}}"));
            run(&mut world, 0.5);
            let height = |world: &World| place(world, id).z;
            let (start, mut lowest) = (height(&world), f64::NEG_INFINITY);
            apply(
                &mut world,
                id,
                "DRIVE {Left 3} {Right 3} {Front-Left 3} {Front-Right 3} {Back-Left 3} {Back-Right 3}",
            );
            for _ in 0..1250 {
                world.step();
                lowest = lowest.max(height(&world) - start);
            }
            let body = body(&world, id);
            println!("{class}, {gap} m: sank by {:.2} mm, at {:.2} m", 1e3 * lowest, body.pose.translation.x);
            assert!(
                body.pose.translation.x > 0.7,
                "{class} stays at {} m before a gap of {gap}",
                body.pose.translation.x
            );
            // A rim of radius R sinks by gap² / 8 R.
            assert!(lowest < gap * gap / 8.0 / 0.05 + 2e-5, "{class} sinks by {lowest} m into {gap}");
        }
    }
}

/// An arm that is pressed against the floor yields at its torque limit, and the base does not move.
#[test]
fn an_arm_pressed_against_the_floor_holds() {
    let (mut world, ids) = world_with("rough", 0.004, &[("YouBotArm", [0.0, 0.0, 0.0], [0.0; 3])]);
    run(&mut world, 0.5);
    let arm: Vec<String> =
        world.robot(ids[0]).expect("the robot is there").with_values().map(|link| link.name.clone()).collect();
    println!("{arm:?}");
    apply(&mut world, ids[0], "SET {Type Joint} {Name AllJoints} {Opcode Angle} {Params 1.3}");
    run(&mut world, 6.0);
    let before = place(&world, ids[0]);
    run(&mut world, 1.0);
    let body = body(&world, ids[0]);
    println!("{:?}, {} unsettled", body.pose, world.unsettled_steps());
    assert!(body.linear.norm() < 1e-3 && (body.pose.translation.vector - before).norm() < 1e-3, "{body:?}");
}

/// A wall of one sheet at x = 2 with a winding, and a floor of one sheet that faces down.
fn sheets(wall: [u32; 4]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let [a, b, c, d] = wall;
    let wall = format!("v 2 -1 0\nv 2 1 0\nv 2 1 1\nv 2 -1 1\nf {a} {b} {c} {d}\n");
    std::fs::write(folder.path().join("wall.obj"), wall).expect("a file");
    std::fs::write(folder.path().join("floor.obj"), "v -5 -5 0\nv 5 -5 0\nv 5 5 0\nv -5 5 0\nf 4 3 2 1\n")
        .expect("a file");
    let solid = |name: &str| format!("[[mesh]]\nname = \"{name}\"\nmaterial = \"concrete\"\nfile = \"{name}.obj\"\n");
    let start = "[[start]]\nname = \"A\"\nposition = [0.0, 0.0, 0.0]\n";
    let map = format!("description = \"two sheets\"\n{}{}{start}", solid("wall"), solid("floor"));
    std::fs::write(folder.path().join("map.toml"), map).expect("a file");
    folder
}

#[test]
fn a_sheet_stops_a_robot_from_both_sides_however_it_is_wound() {
    for winding in [[1, 2, 3, 4], [4, 3, 2, 1]] {
        let folder = sheets(winding);
        for model in [DriveModel::Articulated, DriveModel::Bodies] {
            for (from, yaw, stops) in [(0.0, 0.0, 1.75), (4.0, std::f64::consts::PI, 2.25)] {
                let mut def = scene_loader::load(&folder.path().display().to_string(), &[]).expect("a scene");
                def.robots.get_mut("P3AT").expect("a class").drive_model = model;
                let mut world = World::new(def, Options::default());
                let robot = init(
                    &mut world,
                    &format!("INIT {{ClassName USARBot.P3AT}} {{Location {from},0,0}} {{Rotation 0,0,{yaw}}}"),
                );
                apply(&mut world, robot, "DRIVE {Left 4} {Right 4}");
                run(&mut world, 8.0);
                let at = body(&world, robot).pose.translation;
                let is_before = if from < 2.0 { at.x < stops && at.x > 1.0 } else { at.x > stops && at.x < 3.0 };
                assert!(is_before && at.z < 0.0, "{winding:?} {model:?} from {from}: {at}");
            }
        }
    }
}
