//! Mecanum wheels with exact rollers go where the exact kinematics of finite rollers say, on every kind of floor.

use kinematics::{FiniteRollers, Mecanum};
use sim_core::{Options, TIME_STEP, World};
use system_tests::{apply, init, run};

const FORWARD: &str = "DRIVE {Left 1}{Right 1}";
const RIGHT: &str = "DRIVE {Front-Left 1}{Front-Right -1}{Back-Left -1}{Back-Right 1}";
const CLOCKWISE: &str = "DRIVE {Left 1}{Right -1}";

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

/// What a drive of ten seconds gave, after two of spin-up.
struct Travel {
    /// Displacement forward and to the right in the start frame, m, and clockwise, rad.
    moved: [f64; 3],
    /// Mean angle that the wheels turned, rad.
    turned: f64,
    /// Highest less lowest point of the body, m.
    ripple: f64,
}

fn drive(floor: &str, rollers: u32, line: &str) -> Travel {
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
    for wheel in &mut def.robots.get_mut("KUKA_YouBot").expect("the youBot").wheels {
        let ring = wheel.rollers.as_mut().expect("rollers");
        ring.mass *= f64::from(ring.count) / f64::from(rollers);
        ring.count = rollers;
    }
    let mut world = World::new(def, Options::default());
    let robot = init(&mut world, "INIT {ClassName USARBot.KUKA_YouBot} {Start Start}");
    run(&mut world, 0.5);
    apply(&mut world, robot, line);
    run(&mut world, 2.0);
    let state = |world: &World| world.state(robot).expect("the robot");
    let (from, wheels_from) = state(&world);
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for _ in 0..(10.0 / TIME_STEP) as u32 {
        world.step();
        let height = -state(&world).0.pose.translation.z;
        (low, high) = (low.min(height), high.max(height));
    }
    let (to, wheels_to) = state(&world);
    let way = from.pose.rotation.inverse() * (to.pose.translation.vector - from.pose.translation.vector);
    let yaw = from.pose.rotation.rotation_to(&to.pose.rotation).euler_angles().2;
    let turned = wheels_to.iter().zip(&wheels_from).map(|(to, from)| (to.angle - from.angle).abs()).sum::<f64>() / 4.0;
    Travel { moved: [way.x, way.y, yaw], turned, ripple: high - low }
}

fn kinematics(count: u32) -> FiniteRollers {
    let base = Mecanum { half_wheelbase: 0.2355, half_track: 0.15, wheel_radius: 0.05 };
    FiniteRollers { base, count, axis_circle: 0.036, angle: std::f64::consts::FRAC_PI_4 }
}

#[test]
fn the_youbot_follows_the_exact_kinematics_on_every_floor() {
    let exact = kinematics(6);
    let radius = exact.base.wheel_radius;
    let lever = exact.base.half_wheelbase + exact.base.half_track;
    for (name, floor) in FLOORS {
        for (line, axis, per_radian, tolerance) in [
            (FORWARD, 0, radius, 0.005),
            (RIGHT, 1, radius * exact.mean_lateral_ratio(), 0.007),
            (CLOCKWISE, 2, radius / lever * exact.mean_rotation_ratio(), 0.01),
        ] {
            let Travel { moved, turned, ripple } = drive(floor, 6, line);
            let ratio = moved[axis] / (per_radian * turned);
            println!("{name}, {line}: {ratio:.4} of the exact way, ripple {:.3} mm, {moved:.4?}", 1e3 * ripple);
            assert!((ratio - 1.0).abs() < tolerance, "{name}, {line}: {ratio:.4} of the exact way");
            assert!(ripple < 0.15e-3, "{name}, {line}: ripple {:.3} mm", 1e3 * ripple);
            if axis < 2 {
                let (way, sideways) = (moved[axis], moved[1 - axis]);
                assert!(moved[2].to_degrees().abs() < 0.1 * way, "{name}, {line}: yaw {:.4}", moved[2]);
                assert!(sideways.abs() < 0.003 * way, "{name}, {line}: sideways {sideways:.5}");
            }
        }
    }
}

#[test]
fn wheels_of_eight_and_twelve_rollers_work() {
    for count in [8, 12] {
        let exact = kinematics(count);
        let Travel { moved, turned, ripple } = drive(FLOORS[0].1, count, RIGHT);
        let ratio = moved[1] / (0.05 * exact.mean_lateral_ratio() * turned);
        println!("{count} rollers: {ratio:.4} of the exact way to the right, ripple {:.3} mm", 1e3 * ripple);
        assert!((ratio - 1.0).abs() < 0.007 && ripple < 0.15e-3, "{count} rollers: {ratio:.4}, {ripple}");
    }
}
