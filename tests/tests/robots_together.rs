//! Robots that touch, stand on each other, spawn at one place, and leave while another touches them.

use gamebots_proto::Dialect;
use nalgebra::Vector3;
use scene::DriveModel;
use sim_core::{Options, PawnId, World};
use system_tests::{apply, init, init_on_top, run};

const MODELS: [DriveModel; 3] = [DriveModel::Bodies, DriveModel::Analytic, DriveModel::Kinematic];

/// Builds a world in which one model moves all Mecanum robots.
fn world(map: &str, model: DriveModel) -> World {
    let mut def = scene_loader::load(map, &[]).unwrap_or_else(|error| panic!("{error}"));
    def.robots.values_mut().for_each(|robot| robot.set_drive_model(Some(model)));
    World::new(def, Options::default())
}

fn position(world: &World, robot: PawnId) -> Vector3<f64> {
    world.state(robot).expect("the robot is there").0.pose.translation.vector
}

fn speed(world: &World, robot: PawnId) -> f64 {
    world.state(robot).expect("the robot is there").0.linear.norm()
}

#[test]
fn a_robot_can_leave_while_others_touch_it() {
    for model in MODELS {
        for classes in [["P3AT", "P3AT"], ["KUKA_YouBot", "P3AT"], ["P3AT", "YouBot"], ["P2DX", "CasterSkidRobot"]] {
            for leaver in [0, 1] {
                let mut world = world("rough", model);
                // The second stands on the first.
                let robots = classes.map(|class| init_on_top(&mut world, class, [0.0, 0.0], 0.0));
                run(&mut world, 0.5);
                world.remove(robots[leaver]);
                world.observe(robots[1 - leaver]).expect("the other is still there");
                run(&mut world, 0.5);
                assert!(position(&world, robots[1 - leaver]).z < 0.01, "{classes:?} {model:?}");
            }
        }
    }
}

#[test]
fn a_robot_can_leave_in_the_step_that_it_came_in() {
    for model in MODELS {
        let mut world = world("rough", model);
        for class in ["KUKA_YouBot", "P3AT", "CasterSkidRobot"] {
            let line = format!("INIT {{ClassName USARBot.{class}}} {{Start PlayerStart_0}}");
            let stays = init(&mut world, &line);
            let leaves = init(&mut world, &line);
            world.remove(leaves);
            let comes = init(&mut world, &line);
            run(&mut world, 0.1);
            assert!(speed(&world, stays) < 1.0 && speed(&world, comes) < 1.0, "{class} {model:?}");
        }
    }
}

/// Robots that spawn at one place between two steps stand beside each other, not inside each other.
#[track_caller]
fn check_come_together(model: DriveModel, lines: &[String]) {
    let mut world = world("rough", model);
    let robots: Vec<PawnId> = lines.iter().map(|line| init(&mut world, line)).collect();
    check_stands(world, &robots, &format!("{lines:?} {model:?}"));
}

#[track_caller]
fn check_stands(mut world: World, robots: &[PawnId], what: &str) {
    let highest = |world: &World| robots.iter().map(|&robot| -position(world, robot).z).fold(0.0, f64::max);
    let (start, mut top, mut fastest) = (highest(&world), 0.0f64, 0.0f64);
    for _ in 0..500 {
        world.step();
        top = top.max(highest(&world));
        fastest = robots.iter().map(|&robot| speed(&world, robot)).fold(fastest, f64::max);
    }
    // A robot that slides off another falls freely; no robot is flung away.
    let fall = (2.0 * 9.81 * start.max(0.5)).sqrt();
    assert!(fastest < fall && top < start + 0.01, "{what}: {fastest:.2} m/s, {start} to {top} m");
}

#[test]
fn robots_that_come_in_one_step_do_not_explode() {
    let at = |class: &str, x: f64, y: f64, yaw: f64| {
        format!("INIT {{ClassName USARBot.{class}}} {{Location {x},{y},0}} {{Rotation 0,0,{yaw}}}")
    };
    for model in MODELS {
        for class in ["KUKA_YouBot", "P3AT", "P2DX", "CasterSkidRobot"] {
            check_come_together(model, &[at(class, 0.0, 0.0, 0.0), at(class, 0.0, 0.0, 0.0)]);
            // Corner over corner, where no wheel is above the other robot.
            check_come_together(model, &[at(class, 0.0, 0.0, 0.0), at(class, 0.1, 0.08, 0.7)]);
            check_come_together(model, &[at(class, 0.0, 0.0, 0.0), at("P3AT", 0.2, 0.2, 0.3)]);
        }
    }
    check_come_together(DriveModel::Analytic, &vec![at("P3AT", 0.0, 0.0, 0.0); 20]);
}

/// The weight of a robot reaches the ground in the same step, through any number of robots between.
#[test]
fn a_stack_of_analytic_robots_stands() {
    for count in [3, 4, 5, 6, 8, 12] {
        for (away, turned) in [(0.0, 0.0), (0.001, 0.0), (0.01, 0.003), (0.03, 0.009)] {
            let mut world = world("rough", DriveModel::Analytic);
            let mut put = |index: u32| {
                let (x, yaw) = (away * f64::from(index % 3), turned * f64::from(index));
                init_on_top(&mut world, "KUKA_YouBot", [x, 0.0], yaw)
            };
            let robots: Vec<PawnId> = (0..count).map(&mut put).collect();
            check_stands(world, &robots, &format!("{count} robots, {away} m, {turned} rad"));
        }
    }
}

/// Returns the velocities of two youBots, ahead and to the side, m/s. One drives at 4 rad/s against the back of another that drives at 3.5
/// rad/s. (Held wheels would slide, and nothing keeps a sliding Mecanum base from moving sideways.)
fn pushed(model: DriveModel, pusher_comes_first: bool) -> [Vector3<f64>; 2] {
    let mut world = world("rough", model);
    let places = [-0.575, 0.0];
    let order = if pusher_comes_first { [0, 1] } else { [1, 0] };
    let mut robots = [PawnId(0); 2];
    for index in order {
        robots[index] =
            init(&mut world, &format!("INIT {{ClassName USARBot.KUKA_YouBot}} {{Location {},0,0}}", places[index]));
    }
    run(&mut world, 0.5);
    apply(&mut world, robots[0], "DRIVE {Left 4}{Right 4}");
    apply(&mut world, robots[1], "DRIVE {Left 3.5}{Right 3.5}");
    run(&mut world, 1.0);
    let from = robots.map(|robot| position(&world, robot));
    run(&mut world, 2.0);
    [0, 1].map(|index| (position(&world, robots[index]) - from[index]) / 2.0)
}

/// Equal servos of equal robots meet at the mean speed, which pushes from step to step miss by up to 4 %. A robot that follows its commands
/// is held back to the slower speed.
#[test]
fn a_robot_is_pushed_alike_whichever_came_first() {
    for (model, expected) in [(DriveModel::Analytic, 3.75 * 0.05), (DriveModel::Kinematic, 3.5 * 0.05)] {
        let (first, second) = (pushed(model, true), pushed(model, false));
        println!("{model:?}: {first:.5?} when the pusher came first, {second:.5?} when it came second");
        for speed in first.iter().chain(&second) {
            assert!((speed.x / expected - 1.0).abs() < 0.05 && speed.y.abs() < 0.005, "{model:?}: {speed:?}");
        }
        assert!((first[1].x - second[1].x).abs() < 0.03 * expected, "{model:?}: {first:?} {second:?}");
    }
}

#[test]
fn what_stands_on_an_analytic_robot_weighs_on_its_wheels() {
    let mut world = world("rough", DriveModel::Analytic);
    let [below, above] = [(); 2].map(|()| init_on_top(&mut world, "KUKA_YouBot", [0.0, 0.0], 0.0));
    run(&mut world, 1.0);
    // The ground's force, averaged: the two robots are solved one after the other and take turns from step to step.
    let ground = |world: &World| -> f64 {
        let contacts = world.observe(below).expect("the robot").contacts;
        contacts.iter().filter(|contact| contact.point.z > -0.01).map(|contact| -contact.force.z).sum()
    };
    let weight = 9.81 * f64::from(world.def().robots["KUKA_YouBot"].mass());
    let mut sum = 0.0;
    for _ in 0..100 {
        world.step();
        sum += ground(&world) / 100.0;
    }
    println!("the ground carries {sum:.2} N, one robot weighs {weight:.2} N");
    assert!((sum - 2.0 * weight).abs() < 0.02 * weight, "{sum} {weight}");
    assert!((position(&world, above).z - position(&world, below).z + 0.1).abs() < 0.005);
}

/// No file can cause this, see `hostile_files.rs`. If a state breaks nevertheless, only robots in contact with it are removed, too.
#[test]
fn a_robot_whose_state_is_not_finite_is_taken_out_and_the_rest_goes_on() {
    for model in MODELS {
        let mut def = scene_loader::load("rough", &[]).unwrap_or_else(|error| panic!("{error}"));
        def.robots.values_mut().for_each(|robot| robot.set_drive_model(Some(model)));
        let parts = &mut def.robots.get_mut("YouBot").expect("the class").links[0].parts;
        parts[0].inertia *= f64::NAN;
        let mut world = World::new(def, Options::default());
        let good = init(&mut world, "INIT {ClassName USARBot.P3AT} {Start PlayerStart_0}");
        let broken = init(&mut world, "INIT {ClassName USARBot.YouBot} {Name Broken} {Start RobotStart1}");
        apply(&mut world, broken, "DRIVE {Left 5}{Right 5}");
        apply(&mut world, good, "DRIVE {Left 1}{Right 1}");
        for message in run(&mut world, 2.0) {
            let line = message.write(Dialect::Udk);
            assert!(!line.contains("NaN") && !line.contains("inf"), "{model:?}: {line}");
        }
        let lost: Vec<String> = world.take_lost().into_iter().map(|lost| lost.name).collect();
        println!("{model:?}: lost {lost:?}");
        assert!(speed(&world, good).is_finite() && world.observe(good).is_some());
        assert_eq!(lost, ["Broken"], "{model:?}");
        assert!(world.state(broken).is_none());
    }
}

/// With no robot left and all objects asleep, the solver has no groups.
#[test]
fn the_last_robot_may_leave_after_it_pushed_an_object() {
    for class in ["P3AT", "KUKA_YouBot", "YouBotArm", "Kenaf"] {
        let mut world = World::new(scene_loader::load("hall", &[]).expect("a map"), Options::default());
        let before = world.objects().collect::<Vec<_>>();
        let robot = init(&mut world, &format!("INIT {{ClassName USARBot.{class}}} {{Location 1,0,0}}"));
        apply(&mut world, robot, "DRIVE {Left 4} {Right 4}");
        run(&mut world, 3.0);
        let moved = world
            .objects()
            .zip(&before)
            .any(|(now, was)| (now.pose.translation.vector - was.pose.translation.vector).norm() > 0.1);
        assert!(moved, "{class} pushed nothing");
        world.remove(robot);
        run(&mut world, 1.0);
        let next = init(&mut world, "INIT {ClassName USARBot.P3AT} {Start PlayerStart_0}");
        run(&mut world, 0.5);
        assert!(speed(&world, next) < 0.1);
    }
}
