//! Mecanum wheels with exact rollers move as the exact kinematics of finite rollers predict, on every kind of floor.

use experiments::{Course, Motion, Travel};
use scene::DriveModel;
use sim_core::{Options, World};
use system_tests::{apply, init, run};

/// Floors of one solid, as tables of the map file.
const FLOORS: [(&str, &str); 3] = [
    ("half-space", "[[half_space]]\n"),
    ("box of 100 m", "[[box]]\nposition = [0, 0, 0.5]\nsize = [100, 100, 1]\n"),
    ("mesh", "[[mesh]]\nfile = \"floor.obj\"\n"),
];

/// Builds a flat floor of 10 x 10 m from triangles with legs of 0.2 m.
fn floor_mesh() -> String {
    const CELLS: i32 = 50;
    let mut text = String::new();
    for row in 0..=CELLS {
        for column in 0..=CELLS {
            text += &format!("v {} {} 0\n", 0.2 * f64::from(row) - 5.0, 0.2 * f64::from(column) - 5.0);
        }
    }
    for row in 0..CELLS {
        for column in 0..CELLS {
            let near = row * (CELLS + 1) + column + 1;
            let far = near + CELLS + 1;
            text += &format!("f {near} {far} {}\nf {near} {} {}\n", far + 1, far + 1, near + 1);
        }
    }
    text
}

/// Drives ten seconds at 1 rad/s on a floor, with a number of rollers per wheel, each longer than necessary by the overlap.
fn drive(class: &str, floor: &str, rollers: u32, overlap: f64, motion: Motion) -> Travel {
    drive_by(DriveModel::Bodies, Options::default(), class, floor, rollers, overlap, motion)
}

fn drive_by(
    model: DriveModel,
    options: Options,
    class: &str,
    floor: &str,
    rollers: u32,
    overlap: f64,
    motion: Motion,
) -> Travel {
    let folder = tempfile::tempdir().expect("a folder");
    let (kind, rest) = floor.split_once('\n').expect("a table");
    let map = format!(
        "description = \"a floor\"\n{kind}\nname = \"floor\"\nmaterial = \"carpet\"\n{rest}\
         [[start]]\nname = \"Start\"\nposition = [0, 0, 0]\n"
    );
    let path = folder.path().join("map.toml");
    std::fs::write(&path, map).expect("a file");
    std::fs::write(folder.path().join("floor.obj"), floor_mesh()).expect("a file");
    let mut def =
        scene_loader::load(path.to_str().expect("a path"), &[]).unwrap_or_else(|error| panic!("{floor}: {error}"));
    def.robots.get_mut(class).expect("the youBot").drive_model = model;
    for wheel in def.robots.get_mut(class).expect("the youBot").wheels_mut() {
        let ring = wheel.rollers.as_mut().expect("rollers");
        ring.mass *= f64::from(ring.count) / f64::from(rollers);
        ring.count = rollers;
        ring.last_phase = overlap * std::f64::consts::PI / f64::from(rollers);
    }
    let mut course = Course::start(World::new(def, options), class, 1, motion, 1.0).expect("a course");
    course.run(10.0);
    course.travel().expect("a robot")
}

/// Checks that the yaw is below 0.1 degree per metre and the sideways deviation below 0.3 % of the way.
#[track_caller]
fn check_straight(what: &str, motion: Motion, moved: [f64; 3]) {
    if motion != Motion::Clockwise {
        let (way, sideways) = (moved[motion as usize], moved[1 - motion as usize]);
        assert!(moved[2].to_degrees().abs() < 0.1 * way, "{what}: yaw {:.4}", moved[2]);
        assert!(sideways.abs() < 0.003 * way, "{what}: sideways {sideways:.5}");
    }
}

#[test]
fn the_youbots_follow_the_exact_kinematics_on_every_floor() {
    let thesis = FLOORS.map(|(name, floor)| ("KUKA_YouBot", name, floor));
    for (class, name, floor) in thesis.into_iter().chain([("YouBot", FLOORS[0].0, FLOORS[0].1)]) {
        for (motion, tolerance) in [(Motion::Forward, 0.005), (Motion::Right, 0.007), (Motion::Clockwise, 0.01)] {
            let Travel { moved, ratio, ripple, .. } = drive(class, floor, 6, 1.0, motion);
            let what = format!("{class}, {name}, {}", motion.name());
            println!("{what}: {ratio:.4} of the exact travel, ripple {:.3} mm, {moved:.4?}", 1e3 * ripple);
            assert!((ratio - 1.0).abs() < tolerance, "{what}: {ratio:.4} of the exact travel");
            assert!(ripple < 0.15e-3, "{what}: ripple {:.3} mm", 1e3 * ripple);
            check_straight(&what, motion, moved);
        }
    }
}

/// Rollers without bodies, on every floor, at every step from 1 to 8 ms, and with more rollers.
#[test]
fn the_analytic_model_is_within_three_thousandths_everywhere() {
    let floors = FLOORS.into_iter().map(|(name, floor)| (name, floor, "KUKA_YouBot", 6, 0.008));
    let steps = [0.001, 0.002, 0.004].map(|step| ("half-space", FLOORS[0].1, "KUKA_YouBot", 6, step));
    let wheels = [("YouBot", 6), ("KUKA_YouBot", 8), ("KUKA_YouBot", 12)]
        .map(|(class, rollers)| ("half-space", FLOORS[0].1, class, rollers, 0.008));
    for (name, floor, class, rollers, time_step) in floors.chain(steps).chain(wheels) {
        let options = Options { time_step, ..Options::default() };
        for motion in Motion::ALL {
            let travel = drive_by(DriveModel::Analytic, options, class, floor, rollers, 1.0, motion);
            let Travel { moved, ratio, ripple, .. } = travel;
            let what = format!("{class}, {name}, {rollers} rollers, {time_step} s, {}", motion.name());
            println!("{what}: {ratio:.5} of the exact travel, ripple {:.4} mm, {moved:.5?}", 1e3 * ripple);
            assert!((ratio - 1.0).abs() < 0.003, "{what}: {ratio:.5} of the exact travel");
            assert!(ripple < 0.02e-3, "{what}: ripple {:.3} mm", 1e3 * ripple);
            check_straight(&what, motion, moved);
        }
    }
}

/// At the youBot's top speed a step of 8 ms turns the wheel by a tenth of a roller's sector. Even so the load passes from roller to roller
/// without a bump.
#[test]
fn the_analytic_model_is_as_exact_at_full_speed() {
    for time_step in [0.002, 0.008] {
        for motion in [Motion::Forward, Motion::Right] {
            let mut def = scene_loader::load("rough", &[]).unwrap_or_else(|error| panic!("{error}"));
            def.robots.get_mut("KUKA_YouBot").expect("the youBot").drive_model = DriveModel::Analytic;
            let options = Options { time_step, ..Options::default() };
            let mut course = Course::start(World::new(def, options), "KUKA_YouBot", 1, motion, 12.0).expect("a course");
            course.run(4.0);
            let Travel { ratio, ripple, .. } = course.travel().expect("a robot");
            let what = format!("12 rad/s, {time_step} s, {}", motion.name());
            println!("{what}: {ratio:.5} of the exact travel, ripple {:.4} mm", 1e3 * ripple);
            assert!((ratio - 1.0).abs() < 0.003 && ripple < 0.03e-3, "{what}: {ratio}, {ripple}");
        }
    }
}

/// Real wheels are not in phase. Each model also rolls exactly with wheels as `first_roller` sets them.
#[test]
fn wheels_out_of_phase_roll_as_exactly() {
    for model in [DriveModel::Bodies, DriveModel::Analytic, DriveModel::Kinematic] {
        for motion in Motion::ALL {
            let mut def = scene_loader::load("rough", &[]).unwrap_or_else(|error| panic!("{error}"));
            let robot = def.robots.get_mut("KUKA_YouBot").expect("the youBot");
            robot.drive_model = model;
            for (wheel, first) in robot.wheels_mut().zip([0.3, -0.4, 0.1, 0.0]) {
                wheel.rollers.as_mut().expect("rollers").first_roller = first;
            }
            let mut course =
                Course::start(World::new(def, Options::default()), "KUKA_YouBot", 1, motion, 1.0).expect("a course");
            course.run(4.0);
            let Travel { ratio, ripple, .. } = course.travel().expect("a robot");
            let what = format!("{}, out of phase, {}", model.name(), motion.name());
            println!("{what}: {ratio:.5} of the exact travel, ripple {:.4} mm", 1e3 * ripple);
            assert!((ratio - 1.0).abs() < 0.005 && ripple < 0.15e-3, "{what}: {ratio}, {ripple}");
        }
    }
}

#[test]
fn far_from_the_origin_the_way_is_as_exact() {
    for (model, most) in [(DriveModel::Bodies, 1e-5), (DriveModel::Analytic, 1e-4), (DriveModel::Kinematic, 1e-4)] {
        for motion in Motion::ALL {
            let ratio = |distance: f64| {
                let mut def = scene_loader::load("rough", &[]).unwrap_or_else(|error| panic!("{error}"));
                def.robots.get_mut("KUKA_YouBot").expect("the youBot").drive_model = model;
                def.map.starts[0].position = [distance, -distance, 0.0];
                let course = Course::start(World::new(def, Options::default()), "KUKA_YouBot", 1, motion, 1.0);
                let mut course = course.expect("a course");
                course.run(4.0);
                course.travel().expect("a robot").ratio
            };
            let near = ratio(0.0);
            for distance in [100.0, 1000.0] {
                let (what, far) = (format!("{}, {}, {distance} m away", model.name(), motion.name()), ratio(distance));
                println!("{what}: {far:.6} of the exact travel, {near:.6} at the origin");
                assert!((far - near).abs() < most, "{what}: {far}, {near}");
            }
        }
    }
}

#[test]
fn wheels_of_eight_and_twelve_rollers_work() {
    for count in [8, 12] {
        let Travel { ratio, ripple, .. } = drive("KUKA_YouBot", FLOORS[0].1, count, 1.0, Motion::Right);
        println!("{count} rollers: {ratio:.4} of the exact travel to the right, ripple {:.3} mm", 1e3 * ripple);
        assert!((ratio - 1.0).abs() < 0.007 && ripple < 0.15e-3, "{count} rollers: {ratio:.4}, {ripple}");
    }
}

/// The youBot's real rollers are longer than the minimum by 15 %: near their ends two share the contact.
#[test]
fn rollers_may_overlap() {
    for (name, model) in [("bodies", DriveModel::Bodies), ("analytic", DriveModel::Analytic)] {
        for motion in Motion::ALL {
            let options = Options::default();
            let Travel { ratio, ripple, .. } = drive_by(model, options, "KUKA_YouBot", FLOORS[0].1, 6, 1.1, motion);
            let what = format!("{name}, overlap, {}", motion.name());
            println!("{what}: {ratio:.4} of the exact travel, ripple {:.3} mm", 1e3 * ripple);
            assert!((ratio - 1.0).abs() < 0.01 && ripple < 0.15e-3, "{what}: {ratio:.4}, {ripple}");
        }
    }
}

/// Straight ahead the robot drives over the edge of a plate of 1 cm, without a jump, and is level in the end. To the side a wheel is as
/// small as its rollers, 14 mm, so the edge stops it.
#[test]
fn a_step_of_one_centimetre_is_climbed_ahead_and_holds_sideways() {
    let folder = tempfile::tempdir().expect("a folder");
    let map = "description = \"a step\"\n[[half_space]]\nname = \"floor\"\nmaterial = \"carpet\"\n\
               [[box]]\nname = \"plate\"\nmaterial = \"carpet\"\nposition = [2.5, 0, -0.005]\nsize = [4, 4, 0.01]\n\
               [[box]]\nname = \"beside\"\nmaterial = \"carpet\"\nposition = [0, 4.4, -0.005]\nsize = [0.9, 8, 0.01]\n\
               [[start]]\nname = \"Start\"\nposition = [0, 0, 0]\n";
    let path = folder.path().join("map.toml");
    std::fs::write(&path, map).expect("a file");
    for (line, rise) in [("DRIVE {LinearVelocity 0.2}", 0.01), ("DRIVE {LateralVelocity 0.2}", 0.0)] {
        let def = scene_loader::load(path.to_str().expect("a path"), &[]).unwrap_or_else(|error| panic!("{error}"));
        let mut world = sim_core::World::new(def, Options::default());
        let robot = init(&mut world, "INIT {ClassName USARBot.KUKA_YouBot} {Start Start}");
        let pose = |world: &sim_core::World| world.state(robot).expect("the robot").0.pose;
        run(&mut world, 0.5);
        let before = -pose(&world).translation.z;
        apply(&mut world, robot, line);
        let mut highest = before;
        for _ in 0..(10.0 / world.time_step()) as u32 {
            world.step();
            highest = highest.max(-pose(&world).translation.z);
        }
        let (after, (roll, pitch, _)) = (-pose(&world).translation.z, pose(&world).rotation.euler_angles());
        println!("{line}: climbed {:.2} mm, at most {:.2} mm", 1e3 * (after - before), 1e3 * (highest - before));
        assert!((after - before - rise).abs() < 2e-4 && highest - before < rise + 5e-4, "{line}: {after} {highest}");
        assert!(roll.abs() < 0.002 && pitch.abs() < 0.002, "{line}: {roll} {pitch}");
    }
}
