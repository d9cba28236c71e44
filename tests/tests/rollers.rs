//! Mecanum wheels with exact rollers go where the exact kinematics of finite rollers say, on every kind of floor.

use experiments::{Course, Motion, Travel};
use sim_core::Options;

/// A floor of one solid; its table of the map file.
const FLOORS: [(&str, &str); 3] = [
    ("half-space", "[[half_space]]\n"),
    ("box of 100 m", "[[box]]\nposition = [0, 0, 0.5]\nsize = [100, 100, 1]\n"),
    ("mesh", "[[mesh]]\nfile = \"floor.obj\"\n"),
];

/// A flat floor of 10 x 10 m in triangles with legs of 0.2 m.
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

/// Ten seconds at 1 rad/s on a floor, with so many rollers a wheel.
fn drive(class: &str, floor: &str, rollers: u32, motion: Motion) -> Travel {
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
    for wheel in &mut def.robots.get_mut(class).expect("the youBot").wheels {
        let ring = wheel.rollers.as_mut().expect("rollers");
        ring.mass *= f64::from(ring.count) / f64::from(rollers);
        ring.count = rollers;
    }
    let mut course = Course::start(def, Options::default(), class, 1, motion, 1.0).expect("a course");
    course.run(10.0);
    course.travel().expect("a robot")
}

#[test]
fn the_youbots_follow_the_exact_kinematics_on_every_floor() {
    let thesis = FLOORS.map(|(name, floor)| ("KUKA_YouBot", name, floor));
    for (class, name, floor) in thesis.into_iter().chain([("YouBot", FLOORS[0].0, FLOORS[0].1)]) {
        for (motion, tolerance) in [(Motion::Forward, 0.005), (Motion::Right, 0.007), (Motion::Clockwise, 0.01)] {
            let Travel { moved, ratio, ripple, .. } = drive(class, floor, 6, motion);
            let what = format!("{class}, {name}, {}", motion.name());
            println!("{what}: {ratio:.4} of the exact way, ripple {:.3} mm, {moved:.4?}", 1e3 * ripple);
            assert!((ratio - 1.0).abs() < tolerance, "{what}: {ratio:.4} of the exact way");
            assert!(ripple < 0.15e-3, "{what}: ripple {:.3} mm", 1e3 * ripple);
            if motion != Motion::Clockwise {
                let (way, sideways) = (moved[motion as usize], moved[1 - motion as usize]);
                assert!(moved[2].to_degrees().abs() < 0.1 * way, "{what}: yaw {:.4}", moved[2]);
                assert!(sideways.abs() < 0.003 * way, "{what}: sideways {sideways:.5}");
            }
        }
    }
}

#[test]
fn wheels_of_eight_and_twelve_rollers_work() {
    for count in [8, 12] {
        let Travel { ratio, ripple, .. } = drive("KUKA_YouBot", FLOORS[0].1, count, Motion::Right);
        println!("{count} rollers: {ratio:.4} of the exact way to the right, ripple {:.3} mm", 1e3 * ripple);
        assert!((ratio - 1.0).abs() < 0.007 && ripple < 0.15e-3, "{count} rollers: {ratio:.4}, {ripple}");
    }
}
